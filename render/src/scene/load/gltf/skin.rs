//! Skins: meshes whose vertices follow joints, whatever node they hang on (glTF 3.7.3.3).

use super::data::Data;
use super::pose::Pose;
use crate::scene::Mesh;
use crate::scene::load::error::FileError;
use glam::{DAffine3, DMat3, DMat4, DVec3};
use gltf::{Primitive, Semantic, Skin};

/// For every joint of a skin, what takes a vertex of the mesh as modelled to the world.
pub fn joints(skin: &Skin, pose: &Pose, data: &Data) -> Result<Vec<DAffine3>, FileError> {
    let joints = skin.joints().map(|joint| pose.to_world(joint.index(), data));
    let joints = joints.collect::<Result<Vec<_>, _>>()?;
    let Some(accessor) = skin.inverse_bind_matrices() else { return Ok(joints) };
    let error = |what: String| data.error(format_args!("accessor {}: {what}", accessor.index()));
    let inverses = data.vectors::<16>(&accessor)?;
    if inverses.len() < joints.len() {
        return Err(error(format!("{} matrices for the {} joints of a skin", inverses.len(), joints.len())));
    }
    let follow = |(i, (joint, inverse)): (usize, (DAffine3, [f32; 16]))| {
        let matrix = joint * DAffine3::from_mat4(DMat4::from_cols_array(&inverse.map(f64::from)));
        if matrix.is_finite() { Ok(matrix) } else { Err(error(format!("matrix {i} is not finite"))) }
    };
    joints.into_iter().zip(inverses).enumerate().map(follow).collect()
}

/// What takes one vertex to the world: the mean of its joints.
#[derive(Clone, Copy)]
struct Blend {
    matrix: DAffine3,
    weight: f64,
    /// For a vertex without weights.
    first: u32,
}

/// Moves the vertices of a mesh to the world and turns its normals. Returns how many vertices have no weights and follow
/// their first joint instead.
///
/// # Errors
/// Attributes that do not fit the mesh, joints that are not there.
pub fn apply(
    mesh: &mut Mesh,
    primitive: &Primitive,
    joints: &[DAffine3],
    data: &Data,
    what: &str,
) -> Result<usize, FileError> {
    let zero = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
    let mut blends = vec![Blend { matrix: zero, weight: 0.0, first: 0 }; mesh.positions.len()];
    for set in 0.. {
        let error = |place: usize, text: String| data.error(format_args!("{what}: accessor {place}: {text}"));
        let (indices, weights) = match (primitive.get(&Semantic::Joints(set)), primitive.get(&Semantic::Weights(set))) {
            (Some(indices), Some(weights)) => (indices, weights),
            (None, None) if set > 0 => break,
            _ => {
                return Err(data
                    .error(format_args!("{what}: JOINTS_{set} and WEIGHTS_{set} go together in a mesh with a skin")));
            }
        };
        let (of_joints, of_weights) = (indices.index(), weights.index());
        let (indices, weights) = (data.integers::<4>(&indices)?, data.vectors::<4>(&weights)?);
        if indices.len() != blends.len() || weights.len() != blends.len() {
            return Err(data.error(format_args!("{what}: attributes of different length")));
        }
        for ((blend, indices), weights) in blends.iter_mut().zip(indices).zip(weights) {
            if set == 0 {
                blend.first = indices[0];
            }
            for (index, weight) in indices.into_iter().zip(weights) {
                if !weight.is_finite() {
                    return Err(error(of_weights, "a weight is not finite".into()));
                }
                // Many files have any joint where the weight is zero.
                if weight > 0.0 {
                    blend.add(joint(joints, index).map_err(|text| error(of_joints, text))?, weight.into());
                }
            }
        }
    }
    let mut free = 0;
    for blend in blends.iter_mut().filter(|b| b.weight == 0.0) {
        free += 1;
        blend.add(joint(joints, blend.first).map_err(|text| data.error(format_args!("{what}: {text}")))?, 1.0);
    }
    follow(mesh, &blends);
    Ok(free)
}

fn joint(joints: &[DAffine3], index: u32) -> Result<DAffine3, String> {
    let found = joints.get(index as usize).copied();
    found.ok_or_else(|| format!("a vertex follows joint {index}, but its skin has only {}", joints.len()))
}

impl Blend {
    fn add(&mut self, joint: DAffine3, weight: f64) {
        self.matrix.matrix3 += joint.matrix3 * weight;
        self.matrix.translation += joint.translation * weight;
        self.weight += weight;
    }
}

fn follow(mesh: &mut Mesh, blends: &[Blend]) {
    for (position, blend) in mesh.positions.iter_mut().zip(blends) {
        *position = (blend.matrix.transform_point3(position.as_dvec3()) / blend.weight).as_vec3();
    }
    // Mirrored joints turn their triangles inside out.
    let mirrored: Vec<bool> = blends.iter().map(|b| b.matrix.matrix3.determinant() < 0.0).collect();
    for triangle in &mut mesh.triangles {
        if triangle.iter().all(|&i| mirrored.get(i as usize) == Some(&true)) {
            triangle.swap(1, 2);
        }
    }
    for ((normal, blend), mirrored) in mesh.normals.iter_mut().zip(blends).zip(mirrored) {
        // The cofactors are the inverse transpose times the determinant, whose sign is that of the mirror image.
        let [x, y, z] = [blend.matrix.matrix3.x_axis, blend.matrix.matrix3.y_axis, blend.matrix.matrix3.z_axis];
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let turned = (cofactors * normal.as_dvec3()).normalize_or_zero().as_vec3();
        // One of length zero is made from the faces later.
        *normal = if mirrored { -turned } else { turned };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, Vec3};

    /// A triangle in the plane x + y = 1, and what joints make of it.
    fn followed(matrix: DAffine3) -> Mesh {
        let mut mesh = Mesh {
            positions: vec![Vec3::X, Vec3::Y, Vec3::new(1.0, 0.0, 1.0)],
            normals: vec![Vec3::new(1.0, 1.0, 0.0); 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        // Weights that add up to two.
        let double = DAffine3 { matrix3: matrix.matrix3 * 2.0, translation: matrix.translation * 2.0 };
        follow(&mut mesh, &[Blend { matrix: double, weight: 2.0, first: 0 }; 3]);
        mesh
    }

    #[test]
    fn normals_stay_perpendicular_and_the_front_in_front() {
        for scale in [DVec3::ONE, DVec3::new(3.0, 1.0, 0.5), DVec3::new(-2.0, 1.0, 1.0), DVec3::splat(-1.0)] {
            let turn = DQuat::from_rotation_z(0.7);
            let Mesh { positions: p, normals, triangles, .. } =
                followed(DAffine3::from_scale_rotation_translation(scale, turn, DVec3::new(1.0, 2.0, 3.0)));
            let [a, b, c] = triangles[0].map(|i| p[i as usize]);
            let face = (b - a).cross(c - a).normalize();
            assert!((normals[0] - face).length() < 1e-6, "{scale}: {} {face}", normals[0]);
        }
    }

    #[test]
    fn normals_of_flattened_meshes_are_left_to_the_faces() {
        assert_eq!(followed(DAffine3::from_scale(DVec3::X)).normals, [Vec3::ZERO; 3]);
    }
}
