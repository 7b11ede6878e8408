//! Triangle meshes from files, and what every mesh goes through before it enters a scene.

mod corners;
pub mod obj;
pub mod ply;
mod polygon;
pub mod serialized;
pub mod stl;
pub(super) mod text;

use super::error::FileError;
use crate::scene::Mesh;
use glam::{Affine3A, DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::path::Path;

/// Larger coordinates overflow the squared areas that single precision computes with.
pub const MAX_COORDINATE: f32 = 1e9;

/// Triangles or vertices that are worth handing to another thread.
const BATCH: usize = 1 << 12;

/// A mesh as it stands in its file; normals may have any length, and zero where a vertex has none.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The mesh.
    pub mesh: Mesh,
    /// Whether the file asks for flat shading.
    pub face_normals: bool,
    /// What the file holds and the mesh does not, one line each.
    pub warnings: Vec<String>,
}

impl Parsed {
    /// Puts zero in place of normals and texture coordinates that are not finite, and says so.
    fn new(mut mesh: Mesh, warnings: impl IntoIterator<Item = String>) -> Self {
        let mut warnings: Vec<_> = warnings.into_iter().collect();
        let bad = mesh.normals.iter_mut().filter(|n| !n.is_finite()).map(|n| *n = Vec3::ZERO).count();
        if bad > 0 {
            warnings.push(format!("{bad} vertex normals are not finite: made from the faces instead"));
        }
        let bad = mesh.uvs.iter_mut().filter(|t| !t.is_finite()).map(|t| *t = Vec2::ZERO).count();
        if bad > 0 {
            warnings.push(format!("{bad} texture coordinates are not finite: 0 instead"));
        }
        Self { mesh, face_normals: false, warnings }
    }
}

/// What the scene file asks of a mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct Finish {
    /// Object space to world (or group) space.
    pub to_world: Affine3A,
    /// Flat shading: vertex normals are dropped, and not made where the file has none.
    pub face_normals: bool,
    /// Exchange front and back.
    pub flip_normals: bool,
    /// Which side of a mesh without normals is the front where `to_world` mirrors.
    pub mirrored: Mirrored,
}

/// Which side of a mesh without normals is the front under a transform that mirrors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mirrored {
    /// The side from which its corners run counterclockwise where they end up: Mitsuba's rule.
    #[default]
    ByWinding,
    /// The image of the front: glTF's rule (2.0, §3.7.4), whose winding follows the determinant.
    Image,
}

/// Checks a mesh as parsed, transforms it, drops triangles without area and makes smooth normals where the file has
/// none. Returns the mesh and the number of triangles dropped.
///
/// Vertex normals decide which side is the front, as in Mitsuba: the winding of triangles that disagree is turned.
pub fn finish(mut mesh: Mesh, finish: Finish, path: &Path) -> Result<(Mesh, usize), FileError> {
    let count = mesh.positions.len();
    if let Some((i, t)) = mesh.triangles.iter().enumerate().find(|(_, t)| t.iter().any(|&v| v as usize >= count)) {
        let what = format!("triangle {i} refers to vertices {t:?}, but there are only {count}");
        return Err(FileError::new(path, what));
    }
    settle_strays(&mut mesh);
    check_positions(&mesh).map_err(|what| FileError::new(path, what))?;
    if finish.face_normals {
        mesh.normals.clear();
    }
    let turned = finish.to_world.matrix3.determinant() < 0.0 && finish.mirrored == Mirrored::ByWinding;
    let unmarked = mesh.normals.is_empty();
    mesh = mesh.transformed(finish.to_world);
    if turned && unmarked {
        mesh = mesh.flipped();
    }
    if finish.flip_normals {
        mesh = mesh.flipped();
    }
    settle_strays(&mut mesh);
    check_positions(&mesh).map_err(|what| FileError::new(path, what))?;
    for (what, bad) in [
        ("normal", mesh.normals.iter().position(|n| !n.is_finite())),
        ("texture coordinate", mesh.uvs.iter().position(|t| !t.is_finite())),
        ("texture coordinate", mesh.second_uvs.iter().position(|t| !t.is_finite())),
        ("colour", mesh.colors.iter().position(|c| c.iter().any(|x| !x.is_finite()))),
    ] {
        if let Some(i) = bad {
            return Err(FileError::new(path, format_args!("the {what} of vertex {i} is not finite")));
        }
    }
    let before = mesh.triangles.len();
    let Mesh { triangles, positions, .. } = &mut mesh;
    let has_area = |t: &[u32; 3]| area_vector(positions, t).length_squared() >= f64::from(f32::MIN_POSITIVE);
    if !triangles.par_iter().with_min_len(BATCH).all(has_area) {
        triangles.retain(has_area);
    }
    let dropped = before - triangles.len();
    if mesh.normals.is_empty() && !finish.face_normals {
        mesh.normals = smooth_normals(&mesh);
    } else if !mesh.normals.is_empty() {
        agree_with_normals(&mut mesh);
    }
    Ok((mesh, dropped))
}

/// Finite, and near enough to compute with.
fn usable(p: &Vec3) -> bool {
    p.is_finite() && p.abs().max_element() <= MAX_COORDINATE
}

/// Moves vertices that no triangle has and that cannot be used (scanners mark what they did not see so) to one that can.
fn settle_strays(mesh: &mut Mesh) {
    if mesh.positions.iter().all(usable) {
        return;
    }
    let mut referred = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&i| referred[i as usize] = true);
    let home = mesh.triangles.first().map_or(Vec3::ZERO, |t| mesh.positions[t[0] as usize]);
    for (p, _) in mesh.positions.iter_mut().zip(referred).filter(|(p, referred)| !referred && !usable(p)) {
        *p = home;
    }
}

/// Refuses vertices that are not finite or too far away to compute with.
pub fn check_positions(mesh: &Mesh) -> Result<(), String> {
    let Some(i) = mesh.positions.iter().position(|p| !usable(p)) else { return Ok(()) };
    Err(format!("vertex {i} lies at {}: not finite, or beyond {MAX_COORDINATE:e}", mesh.positions[i]))
}

/// (b − a) × (c − a): twice the area along the front's normal.
fn area_vector(positions: &[Vec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Vertex normals as the mean of the faces' normals weighted by their angle at the vertex (Thürmer & Wüthrich 1998).
pub fn smooth_normals(mesh: &Mesh) -> Vec<Vec3> {
    let weighted = |t: &[u32; 3]| {
        let normal = area_vector(&mesh.positions, t).normalize_or_zero().as_vec3();
        [0, 1, 2].map(|k| {
            let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|j| mesh.positions[t[j] as usize]);
            normal * (b - a).angle_between(c - a)
        })
    };
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    // Angles take the time; sums are made in the order of the triangles, for rounding depends on it.
    for triangles in mesh.triangles.chunks(64 * BATCH) {
        let each: Vec<[Vec3; 3]> = triangles.par_iter().with_min_len(BATCH).map(weighted).collect();
        for (t, normals) in triangles.iter().zip(each) {
            (0..3).for_each(|k| sums[t[k] as usize] += normals[k]);
        }
    }
    // A vertex whose faces cancel, or without a face, has no direction of its own: any unit vector keeps the promise.
    sums.into_iter().map(|n| n.normalize_or(Vec3::Z)).collect()
}

/// Turns triangles so that they face as their vertex normals do; vertices with a normal of length zero take their
/// faces'.
fn agree_with_normals(mesh: &mut Mesh) {
    let Mesh { triangles, positions, normals, .. } = mesh;
    triangles.par_iter_mut().with_min_len(BATCH).for_each(|t| {
        let sum: Vec3 = t.iter().map(|&i| normals[i as usize]).sum();
        if area_vector(positions, t).dot(sum.as_dvec3()) < 0.0 {
            t.swap(1, 2);
        }
    });
    if mesh.normals.contains(&Vec3::ZERO) {
        let made = smooth_normals(mesh);
        mesh.normals.iter_mut().zip(made).filter(|(n, _)| **n == Vec3::ZERO).for_each(|(n, made)| *n = made);
    }
    mesh.normals.par_iter_mut().with_min_len(BATCH).for_each(|n| *n = n.normalize_or(Vec3::Z));
}
