//! Makes the binary files of `tests/scenes/assets`: a sky, an environment with one bright texel, a normal map, and an
//! object to look at materials on.
//!
//!     cargo run --release -p burnish-render --example scene_assets

use flate2::{Compression, write::ZlibEncoder};
use glam::{Vec2, Vec3};
use image::codecs::hdr::HdrEncoder;
use image::{ImageFormat, Rgb, RgbImage};
use render::scene::Mesh;
use std::f32::consts::{PI, TAU};
use std::io::{Cursor, Write};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/assets");
    std::fs::create_dir_all(&folder)?;
    for (name, bytes) in [
        ("sky.hdr", hdr(128, 64, sky)?),
        ("bright-texel.hdr", hdr(32, 16, bright_texel)?),
        ("ripples.png", ripples()?),
        ("object.serialized", serialized(&[("body", body()), ("foot", foot())])?),
    ] {
        let mut file = tempfile::NamedTempFile::new_in(&folder)?;
        file.write_all(&bytes)?;
        file.persist(folder.join(name))?;
        println!("{name}: {} bytes", bytes.len());
    }
    Ok(())
}

fn hdr(width: usize, height: usize, radiance: fn(Vec3) -> Vec3) -> image::ImageResult<Vec<u8>> {
    let pixels: Vec<_> = (0..width * height)
        .map(|i| {
            // The direction of Mitsuba's convention: y up, u = atan2(x, −z)/2π.
            let phi = TAU * ((i % width) as f32 + 0.5) / width as f32;
            let theta = PI * ((i / width) as f32 + 0.5) / height as f32;
            let direction = Vec3::new(phi.sin() * theta.sin(), theta.cos(), -phi.cos() * theta.sin());
            Rgb(radiance(direction).to_array())
        })
        .collect();
    let mut out = Vec::new();
    HdrEncoder::new(&mut out).encode(&pixels, width, height)?;
    Ok(out)
}

/// A blue sky over brown ground, a sun 30 degrees up, a bright window behind and a dim one to the left.
fn sky(d: Vec3) -> Vec3 {
    let sun = Vec3::new(0.6, 0.5, 0.62).normalize();
    let (up, horizon, ground) = (Vec3::new(0.25, 0.45, 0.9), Vec3::new(0.8, 0.85, 0.9), Vec3::new(0.12, 0.1, 0.08));
    let base = if d.y > 0.0 { horizon.lerp(up, d.y.sqrt()) } else { ground.lerp(horizon * 0.3, (1.0 + d.y).powi(8)) };
    let window = |center: Vec3, half: f32, radiance: f32| {
        let p = d - center * d.dot(center);
        if d.dot(center) > 0.0 && p.abs().max_element() < half { radiance } else { 0.0 }
    };
    let disc = if d.dot(sun) > 0.996 { 150.0 } else { 0.0 };
    base + Vec3::new(1.0, 0.9, 0.75) * disc + window(Vec3::NEG_Z, 0.3, 6.0) + window(Vec3::NEG_X, 0.2, 3.0)
}

/// Almost dark, but for one texel.
fn bright_texel(d: Vec3) -> Vec3 {
    let here = d.dot(Vec3::new(0.5, 0.62, 0.6).normalize()) > 0.9945;
    if here { Vec3::splat(500.0) } else { Vec3::splat(0.02) }
}

/// Normals of a periodic height field, 2·rgb − 1, tilted by up to about 20 degrees.
fn ripples() -> image::ImageResult<Vec<u8>> {
    let image = RgbImage::from_fn(64, 64, |x, y| {
        let (u, v) = (TAU * (x as f32 + 0.5) / 64.0, TAU * (y as f32 + 0.5) / 64.0);
        let slope = Vec2::new((2.0 * u).cos() * (v).sin(), 0.5 * (2.0 * u).sin() * v.cos() + 0.5 * (3.0 * v).cos());
        let normal = Vec3::new(-0.3 * slope.x, -0.3 * slope.y, 1.0).normalize();
        Rgb(((0.5 * normal + 0.5) * 255.0).round().to_array().map(|c| c as u8))
    });
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, ImageFormat::Png)?;
    Ok(out.into_inner())
}

/// A ball of radius 1 around the origin with a groove about its waist; y is its axis.
pub fn body() -> Mesh {
    let profile = |t: f32| {
        let latitude = PI * (t - 0.5);
        let groove = 1.0 - 0.3 * (-(latitude / 0.22).powi(2)).exp();
        Vec2::new(latitude.cos() * groove, latitude.sin())
    };
    lathe(profile, 56, 40, false)
}

/// A ring around the y axis at height −1 on which the ball stands.
pub fn foot() -> Mesh {
    let profile = |t: f32| {
        let (s, c) = (TAU * t).sin_cos();
        Vec2::new(0.45 - 0.12 * c, -0.98 + 0.12 * s)
    };
    lathe(profile, 40, 12, true)
}

/// Turns a profile (radius, height) of t in [0, 1] around the y axis; t runs upwards on the outside.
fn lathe(profile: impl Fn(f32) -> Vec2, segments: u32, rows: u32, closed: bool) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=rows {
        let t = j as f32 / rows as f32;
        let h = 1e-3;
        let point = profile(t);
        let tangent = if closed {
            profile(t + h) - profile(t - h)
        } else {
            profile((t + h).min(1.0)) - profile((t - h).max(0.0))
        };
        let normal = Vec2::new(tangent.y, -tangent.x).normalize();
        for i in 0..=segments {
            let u = i as f32 / segments as f32;
            let (s, c) = (TAU * (i % segments) as f32 / segments as f32).sin_cos();
            let turn = |p: Vec2| Vec3::new(p.x * s, p.y, p.x * c);
            mesh.positions.push(turn(Vec2::new(point.x.max(0.0), point.y)));
            mesh.normals.push(turn(normal).normalize());
            mesh.uvs.push(Vec2::new(u, t));
        }
    }
    let vertex = |i: u32, j: u32| j * (segments + 1) + i;
    for j in 0..rows {
        for i in 0..segments {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            // At a pole one side of the quadrilateral has no length.
            if closed || j > 0 {
                mesh.triangles.push([a, b, c]);
            }
            if closed || j + 1 < rows {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

/// Mitsuba's serialized format, version 4, single precision, with normals and texture coordinates.
fn serialized(meshes: &[(&str, Mesh)]) -> std::io::Result<Vec<u8>> {
    let (mut file, mut offsets) = (Vec::new(), Vec::new());
    for (name, mesh) in meshes {
        offsets.extend((file.len() as u64).to_le_bytes());
        file.extend([0x1C, 0x04, 4, 0]);
        let mut out = ZlibEncoder::new(&mut file, Compression::best());
        out.write_all(&0x1003u32.to_le_bytes())?;
        out.write_all(name.as_bytes())?;
        out.write_all(&[0])?;
        out.write_all(&(mesh.positions.len() as u64).to_le_bytes())?;
        out.write_all(&(mesh.triangles.len() as u64).to_le_bytes())?;
        let vectors = mesh.positions.iter().chain(&mesh.normals).flat_map(|v| v.to_array());
        let numbers = vectors.chain(mesh.uvs.iter().flat_map(|v| v.to_array()));
        out.write_all(&numbers.flat_map(f32::to_le_bytes).collect::<Vec<_>>())?;
        out.write_all(&mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect::<Vec<_>>())?;
        out.finish()?;
    }
    file.extend(offsets);
    file.extend((meshes.len() as u32).to_le_bytes());
    Ok(file)
}
