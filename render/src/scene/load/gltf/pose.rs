//! Where the nodes of a file stand.

use super::MAX_DEPTH;
use super::data::Data;
use crate::scene::load::error::FileError;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::Document;
use gltf::scene::Transform;

/// A node against its parent.
#[derive(Clone, Debug)]
pub struct Local {
    pub place: Place,
    /// Weights of the morph targets of its mesh, where they are not the mesh's own.
    pub weights: Option<Vec<f32>>,
}

/// The transform of a node.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    Matrix(DAffine3),
    /// The quaternion is as it stands in the file: of any length.
    Parts {
        translation: DVec3,
        rotation: DQuat,
        scale: DVec3,
    },
}

impl Place {
    /// To the space of the parent.
    pub fn to_parent(self) -> DAffine3 {
        match self {
            Self::Matrix(matrix) => matrix,
            Self::Parts { translation, rotation, scale } => {
                let length = rotation.length();
                let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
                DAffine3 { matrix3: DMat3::from_quat(rotation) * DMat3::from_diagonal(scale), translation }
            }
        }
    }

    /// Translation, rotation and scale; of a matrix, those that come nearest to it.
    pub fn parts(self) -> (DVec3, DQuat, DVec3) {
        match self {
            Self::Matrix(matrix) => {
                let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
                (translation, rotation, scale)
            }
            Self::Parts { translation, rotation, scale } => (translation, rotation, scale),
        }
    }

    /// What is done to a rotation that is none.
    pub fn complaint(self) -> Option<&'static str> {
        let Self::Parts { rotation, .. } = self else { return None };
        let length = rotation.length();
        if length == 0.0 {
            Some("a rotation of length zero is left out")
        } else if (length - 1.0).abs() > 1e-3 {
            Some("the quaternion of a rotation is not of unit length: it is normalised")
        } else {
            None
        }
    }
}

/// All nodes of a file at one moment.
#[derive(Clone, Debug)]
pub struct Pose {
    pub nodes: Vec<Local>,
    parents: Vec<Option<usize>>,
}

impl Pose {
    /// As the nodes stand in the file.
    pub fn of_nodes(document: &Document) -> Self {
        let local = |node: gltf::Node| {
            let place = match node.transform() {
                Transform::Matrix { matrix } => Place::Matrix(DAffine3::from_mat4(DMat4::from_cols_array_2d(
                    &matrix.map(|column| column.map(f64::from)),
                ))),
                Transform::Decomposed { translation, rotation, scale } => Place::Parts {
                    translation: DVec3::from(translation.map(f64::from)),
                    rotation: DQuat::from_array(rotation.map(f64::from)),
                    scale: DVec3::from(scale.map(f64::from)),
                },
            };
            Local { place, weights: node.weights().map(<[f32]>::to_vec) }
        };
        let mut parents = vec![None; document.nodes().len()];
        for node in document.nodes() {
            node.children().for_each(|child| parents[child.index()] = Some(node.index()));
        }
        Self { nodes: document.nodes().map(local).collect(), parents }
    }

    /// A node's transform to the space of its parent.
    pub fn to_parent(&self, node: usize) -> DAffine3 {
        self.nodes[node].place.to_parent()
    }

    /// A node and those that it hangs on.
    pub fn line(&self, node: usize) -> Vec<usize> {
        core::iter::successors(Some(node), |n| self.parents[*n]).take(MAX_DEPTH).collect()
    }

    /// A node's transform to the world, whether or not the scene holds the node.
    ///
    /// # Errors
    /// Nodes that are their own ancestors, and transforms that are not finite.
    pub fn to_world(&self, node: usize, data: &Data) -> Result<DAffine3, FileError> {
        let (mut to_world, mut ancestor) = (self.to_parent(node), self.parents[node]);
        for _ in 0..MAX_DEPTH {
            let Some(parent) = ancestor else {
                let what = || data.error(format_args!("node {node}: its transform is not finite"));
                return if to_world.is_finite() { Ok(to_world) } else { Err(what()) };
            };
            (to_world, ancestor) = (self.to_parent(parent) * to_world, self.parents[parent]);
        }
        Err(data.error(format_args!("node {node}: the node tree is endless")))
    }
}
