//! What a scene file says, independent of its format: the loaders fill these types.
//!
//! Units: metres or whatever the file uses for length, radians, radiance in W·m⁻²·sr⁻¹. Colours are linear, with the
//! sRGB primaries. Everything refers to everything else by index into the vectors of [`Scene`].

mod camera;
pub mod checksum;
mod function;
mod light;
#[cfg(feature = "formats")]
pub mod load;
mod material;
mod mesh;
mod opacity;
mod shapes;
mod texture;
mod validate;

pub use crate::color::Rgb;
pub use camera::{Camera, Crop, Film, Filter, FovAxis, Lens, Projection};
pub use function::{Function, Reflection};
pub use light::{AreaEmitter, Environment, EnvironmentMap, Falloff, Light, Rows};
pub use material::{Distribution, Material, MaterialId, WardVariant};
pub use mesh::{Geometry, Group, Instance, Mesh, Shape, Sphere};
pub(crate) use opacity::Opacity;
#[cfg(feature = "formats")]
pub(crate) use texture::luminance;
pub use texture::{
    Bitmap, ColorTexture, Coordinates, FloatTexture, Interpolation, Reading, Stored, Texels, Texture, TextureId,
    Transfer, Wrap,
};
pub use validate::SceneError;

use serde::{Deserialize, Serialize};

/// How far light is followed, in Mitsuba's counting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IntegratorSettings {
    /// Largest number of path segments from the eye to the light: 1 shows only emitters, 2 adds direct light;
    /// `u32::MAX` has no limit.
    pub max_depth: u32,
    /// Number of segments after which Russian roulette may end a path.
    pub rr_depth: u32,
    /// Whether emitters and the environment are invisible to the camera.
    pub hide_emitters: bool,
    /// Whether the environment alone is, so that a picture may have a transparent background.
    pub hide_environment: bool,
    /// Whether light on smooth normals ends softly where the triangles under them turn away from it, so that few
    /// triangles do not show. It takes light away that the smooth normals would show: off where pictures are compared.
    pub soft_terminator: bool,
    /// Samples per pixel the file asks for.
    pub spp: u32,
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self {
            max_depth: u32::MAX,
            rr_depth: 5,
            hide_emitters: false,
            hide_environment: false,
            soft_terminator: false,
            spp: 16,
        }
    }
}

/// A whole scene.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Scene {
    /// Shapes in world space.
    pub shapes: Vec<Shape>,
    /// Sets of shapes stored once and drawn by [`Scene::instances`]; their shapes must not emit.
    pub groups: Vec<Group>,
    /// Placements of groups.
    pub instances: Vec<Instance>,
    /// Materials; nested ones (two-sided, blend, …) refer to others of this list.
    pub materials: Vec<Material>,
    /// A name for each material, for messages: the file's id, or made by the loader.
    pub material_names: Vec<String>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Lights without a surface.
    pub lights: Vec<Light>,
    /// Light from infinity, in every direction.
    pub environment: Option<Environment>,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Path length and the like.
    pub integrator: IntegratorSettings,
}
