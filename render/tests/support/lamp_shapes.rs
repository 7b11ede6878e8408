//! Lamps of every shape.

use crate::pieces::*;
use glam::{Affine3A, Quat, Vec3, Vec3A};
use render::scene::*;

/// Rough metal.
pub fn glossy() -> Material {
    Material::RoughConductor {
        distribution: Distribution::Ggx,
        alpha_u: FloatTexture::Constant(0.2),
        alpha_v: FloatTexture::Constant(0.2),
        eta: gray(0.2),
        k: gray(4.0),
        specular: gray(1.0),
    }
}

/// A mirror of reflectance 0.8.
pub fn mirror() -> Material {
    Material::Conductor { eta: gray(0.0), k: gray(1.0), specular: gray(0.8) }
}

/// An icosahedron's faces divided once: a convex mesh of 80 triangles in the unit sphere.
pub fn ball(to_world: Affine3A) -> Mesh {
    let g = 0.5 * (1.0 + 5f32.sqrt());
    let corners = [[0., 1., g], [0., -1., g], [0., 1., -g], [0., -1., -g]];
    let corners = corners.iter().flat_map(|&[x, y, z]| [Vec3::new(x, y, z), Vec3::new(z, x, y), Vec3::new(y, z, x)]);
    let corners: Vec<Vec3> = corners.map(Vec3::normalize).collect();
    let mut ball = Mesh::default();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in &corners[j + 1..] {
                // Edges of the icosahedron are 1.0515 long.
                if a.distance(b).max(b.distance(c)).max(c.distance(a)) > 1.1 {
                    continue;
                }
                let [b, c] = if (b - a).cross(c - a).dot(a) > 0.0 { [b, c] } else { [c, b] };
                let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
                for face in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                    let base = ball.positions.len() as u32;
                    ball.positions.extend(face);
                    ball.triangles.push([base, base + 1, base + 2]);
                }
            }
        }
    }
    assert_eq!(ball.triangles.len(), 80);
    ball.transformed(to_world)
}

/// Convex lamps that reach from −1 to 1, their fronts outwards or to +z, under a scale and a translation.
pub fn convex(material: u32, radiance: f32, scale: f32, center: Vec3A) -> Vec<(&'static str, Vec<Shape>)> {
    let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::IDENTITY, center.into());
    let of = |m: Mesh| mesh(m, material, Some(radiance));
    let side = Mesh::cylinder(Vec3::NEG_Z, Vec3::Z, 1.0, to_world);
    let cap = Mesh::disk(to_world * Affine3A::from_translation(Vec3::Z));
    vec![
        ("sphere", vec![sphere(center, scale, false, material, Some(radiance))]),
        ("rectangle", vec![of(Mesh::rectangle(to_world))]),
        ("disk", vec![of(Mesh::disk(to_world))]),
        ("cube", vec![of(Mesh::cube(to_world))]),
        ("cylinder", vec![of(side), of(cap)]),
        ("mesh", vec![of(ball(to_world))]),
    ]
}
