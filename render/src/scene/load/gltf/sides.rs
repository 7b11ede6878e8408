//! Lamps that shine on both sides.
//!
//! Emitters of this crate have one bright side. A double-sided glTF lamp, Blender's default, becomes two sheets back to
//! back, the second behind the first by so little that nothing fits between them. Sheets with holes are there from the front
//! alone ([`crate::scene::Material::FrontAlone`]): else both would take their share of what passes.

use super::material::Back;
use crate::scene::Mesh;
use crate::scene::load::mesh::smooth_normals;
use glam::Vec3;
use std::collections::HashMap;

/// Distance of the sheets in lengths of the mesh's diagonal.
const GAP: f32 = 1e-4;

/// The sheet behind a mesh, facing the other way; `None` for a closed one without holes, whose inside nobody sees.
pub fn behind(mesh: &Mesh, back: Back) -> Option<Mesh> {
    if back == Back::Whole && is_closed([mesh]) {
        return None;
    }
    let bounds = mesh.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let gap = GAP * (bounds.1 - bounds.0).length();
    let mut back = mesh.clone();
    for (position, normal) in back.positions.iter_mut().zip(smooth_normals(mesh)) {
        *position -= gap * normal;
    }
    Some(back.flipped())
}

/// Whether surfaces together have no border: every edge belongs to an even number of triangles; vertices in the same
/// place are one.
pub fn is_closed<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> bool {
    let mut edges: HashMap<_, u32> = HashMap::new();
    for mesh in meshes {
        // Adding 0 makes −0 and 0 the same.
        let key = |i: u32| mesh.positions.get(i as usize).map(|&p| (p + 0.0).to_array().map(f32::to_bits));
        for &[a, b, c] in &mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (from, to) = (key(from), key(to));
                if from != to {
                    *edges.entry(if from < to { (from, to) } else { (to, from) }).or_default() += 1;
                }
            }
        }
    }
    edges.values().all(|&n| n % 2 == 0)
}
