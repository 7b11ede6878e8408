//! Where meshes are drawn: at their node, at its instances, or where the joints of their skin are.

use super::pose::Place;
use super::{Builder, instancing, node_name, skin};
use crate::scene::load::error::FileError;
use glam::DAffine3;
use gltf::{Node, Semantic};

/// More instances of `EXT_mesh_gpu_instancing` are refused, so that nodes shared by many parents cannot grow without end.
const MAX_INSTANCES: usize = 1 << 22;

/// A mesh with the weights of its morph targets and its skin.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Posed {
    pub mesh: usize,
    /// Bits of the weights, without the zeros at their end.
    weights: Vec<u32>,
    /// A mesh with a skin lies in the world.
    pub skin: Option<usize>,
}

impl Posed {
    /// The mesh as it was modelled.
    pub fn at_rest(mesh: usize) -> Self {
        Self { mesh, weights: Vec::new(), skin: None }
    }

    /// Weights of the morph targets; those that are left out are zero.
    pub fn weights(&self) -> Vec<f32> {
        self.weights.iter().copied().map(f32::from_bits).collect()
    }
}

impl Builder<'_> {
    /// Notes where a node has its mesh.
    pub(super) fn place(&mut self, node: &Node, mesh: &gltf::Mesh, to_world: DAffine3) -> Result<(), FileError> {
        let weights = self.pose.nodes[node.index()].weights.as_deref().or(mesh.weights()).unwrap_or_default();
        if weights.iter().any(|w| !w.is_finite()) {
            return Err(self.data.error(format_args!("node {}: a weight is not finite", node.index())));
        }
        let used = weights.iter().rposition(|w| *w != 0.0).map_or(0, |last| last + 1);
        let weights = weights[..used].iter().map(|w| w.to_bits()).collect();
        let mut skin = node.skin();
        if skin.is_some() && mesh.primitives().all(|p| p.get(&Semantic::Joints(0)).is_none()) {
            self.note("a skin is ignored: its mesh has no joints", node_name(node));
            skin = None;
        }
        let posed = Posed { mesh: mesh.index(), weights, skin: skin.as_ref().map(gltf::Skin::index) };
        if let Some(skin) = skin {
            if !self.skins.contains_key(&skin.index()) {
                self.skins.insert(skin.index(), skin::joints(&skin, &self.pose, self.data)?);
            }
            if node.extension_value(instancing::NAME).is_some() {
                self.note("instances are ignored: a mesh with a skin is where its joints are", node_name(node));
            }
            // Wherever its node is, a mesh with a skin is where its joints are: once.
            self.placements.insert(posed, vec![DAffine3::IDENTITY]);
            return Ok(());
        }
        let placements = match instancing::places(node, self.document, self.data)? {
            Some(places) => self.instances(node, &places, to_world)?,
            None => vec![to_world],
        };
        // A scale of zero hides a mesh.
        let seen: Vec<_> = placements.into_iter().filter(|p| p.matrix3.determinant() != 0.0).collect();
        if !seen.is_empty() {
            self.placements.entry(posed).or_default().extend(seen);
        }
        Ok(())
    }

    /// Transforms of the instances of a node's mesh.
    fn instances(&mut self, node: &Node, places: &[Place], to_world: DAffine3) -> Result<Vec<DAffine3>, FileError> {
        self.instances += places.len();
        if self.instances > MAX_INSTANCES {
            let what = format_args!("node {}: more than {MAX_INSTANCES} instances", node.index());
            return Err(self.data.error(what));
        }
        if let Some(complaint) = places.iter().find_map(|place| place.complaint()) {
            self.note(complaint, format_args!("instances of {}", node_name(node)));
        }
        let placements: Vec<_> = places.iter().map(|place| to_world * place.to_parent()).collect();
        match placements.iter().position(|p| !p.is_finite()) {
            Some(i) => Err(self.data.error(format_args!("node {}: instance {i} is not finite", node.index()))),
            None => Ok(placements),
        }
    }
}
