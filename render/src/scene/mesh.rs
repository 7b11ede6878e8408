//! Surfaces: triangle meshes, spheres, and groups of them drawn several times.

use super::{AreaEmitter, MaterialId};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use serde::{Deserialize, Serialize};

/// An indexed triangle mesh. A triangle (a, b, c) faces along (b − a) × (c − a).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Vertex indices of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals, one per position; empty for flat shading.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one per position; empty where the file has none (barycentrics stand in, as in Mitsuba).
    pub uvs: Vec<Vec2>,
    /// A second set of texture coordinates, one per position; empty where there is none: the first stands in.
    pub second_uvs: Vec<Vec2>,
    /// Colours and opacities, one per position; empty where there are none.
    pub colors: Vec<[f32; 4]>,
}

/// A sphere, kept exact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3A,
    /// Radius > 0.
    pub radius: f32,
    /// Rotation from the sphere's own frame (poles on ±z, u from the azimuth, v from the zenith angle) to the world.
    pub rotation: Mat3A,
    /// Whether the front faces the centre.
    pub inward: bool,
}

/// Where a surface is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Geometry {
    /// Triangles.
    Mesh(Mesh),
    /// A sphere.
    Sphere(Sphere),
}

/// A surface with its material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Where it is: world space, or the group's space inside a [`Group`].
    pub geometry: Geometry,
    /// How it scatters light.
    pub material: MaterialId,
    /// The light its front side gives off.
    pub emitter: Option<AreaEmitter>,
}

/// Shapes stored once, drawn by every [`Instance`] of the group.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// The shapes, none of which emits.
    pub shapes: Vec<Shape>,
}

/// A group placed in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instance {
    /// Index into [`super::Scene::groups`].
    pub group: u32,
    /// Group space to world; must be invertible.
    pub to_world: Affine3A,
}
