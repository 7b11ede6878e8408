//! `EXT_mesh_gpu_instancing`: one mesh at many places in the space of its node.

use super::data::Data;
use super::pose::Place;
use crate::scene::load::error::FileError;
use glam::{DQuat, DVec3};
use gltf::{Document, Node};
use serde::Deserialize;

/// The extension's name.
pub const NAME: &str = "EXT_mesh_gpu_instancing";

#[derive(Deserialize)]
struct Extension {
    #[serde(default)]
    attributes: Attributes,
}

/// Accessors, of one length; those of an application are left out.
#[derive(Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
struct Attributes {
    translation: Option<usize>,
    rotation: Option<usize>,
    scale: Option<usize>,
}

/// Where the mesh of a node is drawn, in the node's space; `None` for a node without instances.
///
/// # Errors
/// Accessors that are missing, of the wrong kind, or of different length.
pub fn places(node: &Node, document: &Document, data: &Data) -> Result<Option<Vec<Place>>, FileError> {
    let Some(extension) = node.extension_value(NAME) else { return Ok(None) };
    let error = |what: String| data.error(format_args!("node {}: {NAME}: {what}", node.index()));
    let Extension { attributes } = Extension::deserialize(extension).map_err(|e| error(e.to_string()))?;
    let accessor = |index: usize| document.accessors().nth(index).ok_or_else(|| error(format!("no accessor {index}")));
    let vectors = |index: Option<usize>| index.map(|i| data.vectors::<3>(&accessor(i)?)).transpose();
    let (translations, scales) = (vectors(attributes.translation)?, vectors(attributes.scale)?);
    let rotations = attributes.rotation.map(|i| data.vectors::<4>(&accessor(i)?)).transpose()?;
    let counts = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let count = counts.into_iter().flatten().next().unwrap_or(1);
    if counts.into_iter().flatten().any(|n| n != count) {
        return Err(error("attributes of different length".into()));
    }
    let vector = |of: &Option<Vec<[f32; 3]>>, i: usize| of.as_ref().map(|v| DVec3::from(v[i].map(f64::from)));
    let place = |i: usize| Place::Parts {
        translation: vector(&translations, i).unwrap_or(DVec3::ZERO),
        rotation: rotations.as_ref().map_or(DQuat::IDENTITY, |r| rotation(r[i])),
        scale: vector(&scales, i).unwrap_or(DVec3::ONE),
    };
    Ok(Some((0..count).map(place).collect()))
}

/// Of unit length, which integers have roughly, but for one of length zero.
fn rotation(numbers: [f32; 4]) -> DQuat {
    let rotation = DQuat::from_array(numbers.map(f64::from));
    let length = rotation.length();
    if length > 0.0 { rotation / length } else { rotation }
}
