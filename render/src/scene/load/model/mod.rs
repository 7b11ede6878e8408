//! A mesh file alone as a scene: seen from a corner, under an even sky. A quick look at a model.

mod materials;
mod mtl;

use super::error::{FileError, LoadError, read_file};
use super::framing::frame_everything;
use super::mesh::{Finish, finish, obj, ply, smooth_normals, stl};
use super::{Loaded, Options};
use crate::scene::{Environment, FovAxis, Geometry, Mesh, Rgb, Scene, Shape};
use glam::Vec3;
use materials::Library;
use std::path::Path;

/// Larger files are refused.
const MAX_FILE: u64 = 1 << 33;
/// Reflectance of what has no material.
const GREY: Rgb = Rgb::splat(0.5);

/// Loads an OBJ, PLY or STL file, whose `extension` is in small letters. OBJ has y up, the others z.
///
/// # Errors
/// A file that cannot be read, or shows nothing; options that it has no use for.
pub fn load(path: &Path, extension: &str, options: &Options) -> Result<Loaded, LoadError> {
    let unused = [
        (!options.defines.is_empty(), "-D"),
        (options.camera.is_some(), "--camera"),
        (options.scene.is_some(), "--scene"),
        (options.light_units.is_some(), "--light-units"),
        (options.track.is_some(), "camera:NAME@FPS"),
    ];
    if let Some((_, option)) = unused.iter().find(|(given, _)| *given) {
        return Err(FileError::new(path, format_args!("{option}: a model has no parameters, cameras or lamps")).into());
    }
    let bytes = read_file(path, MAX_FILE)?;
    let mut used = obj::Materials::default();
    let (parsed, up) = match extension {
        "obj" => (obj::parse_with(&bytes, path, false, &mut used)?, Vec3::Y),
        "ply" => (ply::parse(&bytes, path, false)?, Vec3::Z),
        _ => (stl::parse(&bytes, path)?, Vec3::Z),
    };
    let warn = |what: &str| format!("{}: {what}", path.display());
    let mut warnings: Vec<String> = parsed.warnings.iter().map(|w| warn(w)).collect();
    let mut library = Library::new(path, &used.files, options.skip_missing, &mut warnings)?;
    library.announce(used.begins.iter().map(|(_, name)| name.as_str()));
    let (mut scene, mut dropped) = (Scene::default(), 0);
    let mut mesh = parsed.mesh;
    if mesh.normals.is_empty() && !used.begins.is_empty() {
        // Of the whole: parts of it that meet are smooth across the seam.
        mesh.normals = smooth_normals(&mesh);
    }
    for (name, part) in parts(mesh, &used.begins) {
        let how = Finish { face_normals: parsed.face_normals, ..Finish::default() };
        let (mesh, without_area) = finish(part, how, path)?;
        dropped += without_area;
        if !mesh.triangles.is_empty() {
            let (material, emitter) = library.material(&name, &mut scene)?;
            scene.shapes.push(Shape { geometry: Geometry::Mesh(mesh), material, emitter });
        }
    }
    if dropped > 0 {
        warnings.push(warn(&format!("{dropped} triangles without area are not drawn")));
    }
    if scene.shapes.is_empty() {
        return Err(FileError::new(path, "nothing to draw: no triangles").into());
    }
    if options.environment.is_none() {
        scene.environment = Some(Environment::Constant(Rgb::ONE));
    }
    let camera = frame_everything(&scene, up);
    scene.camera = camera.ok_or_else(|| FileError::new(path, "nothing to draw: it has no extent"))?;
    Ok(Loaded {
        scene,
        warnings,
        cameras: Vec::new(),
        camera: None,
        files: library.files,
        fov_axis: FovAxis::X,
        track: Vec::new(),
    })
}

/// The mesh in parts of one material each, in the order in which they are first used; `begins` says from which triangle
/// on which material holds.
fn parts(mesh: Mesh, begins: &[(usize, String)]) -> Vec<(String, Mesh)> {
    let count = mesh.triangles.len();
    let mut runs: Vec<(&str, Vec<[u32; 3]>)> = Vec::new();
    let mut places = std::collections::HashMap::new();
    let ends = begins.iter().skip(1).map(|(start, _)| *start).chain([count]);
    let first = begins.first().map_or(count, |(start, _)| *start);
    let all =
        std::iter::once((0, first, "grey")).chain(begins.iter().zip(ends).map(|((s, name), e)| (*s, e, name.as_str())));
    for (start, end, name) in all.filter(|(start, end, _)| start < end) {
        let place = *places.entry(name).or_insert_with(|| {
            runs.push((name, Vec::new()));
            runs.len() - 1
        });
        runs[place].1.extend_from_slice(&mesh.triangles[start..end]);
    }
    if let [(name, _)] = runs[..] {
        let name = name.to_string();
        return vec![(name, mesh)];
    }
    let mut index = vec![u32::MAX; mesh.positions.len()];
    let cut = |(name, triangles): (&str, Vec<[u32; 3]>)| {
        let mut old = Vec::new();
        let mut new = |v: u32| {
            let slot = &mut index[v as usize];
            if *slot == u32::MAX {
                *slot = old.len() as u32;
                old.push(v);
            }
            *slot
        };
        let triangles = triangles.into_iter().map(|t| t.map(&mut new)).collect();
        old.iter().for_each(|&v| index[v as usize] = u32::MAX);
        let of = |i: &u32| *i as usize;
        let part = Mesh {
            triangles,
            positions: old.iter().map(|i| mesh.positions[of(i)]).collect(),
            normals: if mesh.normals.is_empty() {
                Vec::new()
            } else {
                old.iter().map(|i| mesh.normals[of(i)]).collect()
            },
            uvs: if mesh.uvs.is_empty() { Vec::new() } else { old.iter().map(|i| mesh.uvs[of(i)]).collect() },
            // No format of models has them here.
            second_uvs: Vec::new(),
            colors: Vec::new(),
        };
        (name.to_string(), part)
    };
    runs.into_iter().map(cut).collect()
}
