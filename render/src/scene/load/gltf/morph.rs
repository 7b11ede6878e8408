//! Morph targets: deviations from a mesh, each with a weight.

use super::data::Data;
use crate::scene::Mesh;
use crate::scene::load::error::FileError;
use glam::Vec3;
use gltf::Primitive;

/// Moves the vertices and turns the normals of a mesh. Weights beyond the targets have no effect, missing ones are 0.
pub fn apply(
    mesh: &mut Mesh,
    primitive: &Primitive,
    weights: &[f32],
    data: &Data,
    what: &str,
) -> Result<(), FileError> {
    for (target, &weight) in primitive.morph_targets().zip(weights).filter(|(_, w)| **w != 0.0) {
        let parts = [(target.positions(), &mut mesh.positions), (target.normals(), &mut mesh.normals)];
        for (accessor, values) in parts {
            let Some(accessor) = accessor.filter(|_| !values.is_empty()) else { continue };
            let deviations = data.vectors(&accessor)?;
            if deviations.len() != values.len() {
                return Err(data.error(format_args!("{what}: a morph target of different length")));
            }
            for (value, deviation) in values.iter_mut().zip(deviations) {
                *value += weight * Vec3::from_array(deviation);
            }
        }
    }
    Ok(())
}
