//! Lamps that shine on both sides.
//!
//! Emitters of this crate have one bright side. A double-sided glTF lamp, Blender's default, becomes two sheets back to
//! back, the second behind the first by so little that nothing fits between them.

use crate::scene::Mesh;
use crate::scene::load::mesh::smooth_normals;
use glam::Vec3;
use std::collections::HashMap;

/// Distance of the sheets in lengths of the mesh's diagonal.
const GAP: f32 = 1e-4;

/// The sheet behind an open mesh, facing the other way; `None` for a closed one, whose inside nobody sees.
pub fn behind(mesh: &Mesh) -> Option<Mesh> {
    if is_closed(mesh) {
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

/// Whether every edge belongs to two triangles; vertices in the same place are one.
fn is_closed(mesh: &Mesh) -> bool {
    // Adding 0 makes −0 and 0 the same.
    let key = |i: u32| (mesh.positions[i as usize] + 0.0).to_array().map(f32::to_bits);
    let mut edges: HashMap<_, u32> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (key(from), key(to));
            *edges.entry(if from < to { (from, to) } else { (to, from) }).or_default() += 1;
        }
    }
    edges.values().all(|&n| n == 2)
}
