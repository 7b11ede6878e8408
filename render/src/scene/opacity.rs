//! How much of a surface is there.

use super::{Coordinates, FloatTexture, Material, MaterialId, Scene, Texture};
use crate::ray::Ray;
use glam::Vec3A;
use std::sync::Arc;

/// Opacity of a material: the product of the masks that are wrapped in each other.
#[derive(Clone, Debug)]
pub(crate) struct Opacity {
    factors: Arc<[FloatTexture]>,
    /// Whether nothing is there from behind.
    front_alone: bool,
    /// Whether nothing is there for the camera.
    hidden: bool,
}

impl Opacity {
    /// `None` for a material without holes.
    pub fn of(scene: &Scene, material: MaterialId) -> Option<Self> {
        let (mut factors, mut front_alone, mut hidden) = (Vec::new(), false, false);
        let mut next = Some(material);
        while let Some(id) = next {
            next = match &scene.materials[id.0 as usize] {
                Material::Mask { opacity, inner } => {
                    factors.push(*opacity);
                    Some(*inner)
                }
                Material::FrontAlone { inner, hidden: here } => {
                    (front_alone, hidden) = (true, hidden || *here);
                    Some(*inner)
                }
                // Of two that are mixed or laid on each other, neither has holes.
                Material::Blend { .. } | Material::Coat { .. } | Material::Sheen { .. } => None,
                other => other.children().next(),
            };
        }
        (front_alone || !factors.is_empty()).then(|| Self { factors: factors.into(), front_alone, hidden })
    }

    /// Share of light that meets the front at a point, 0 … 1.
    #[inline]
    pub fn at(&self, textures: &[Texture], at: &Coordinates) -> f32 {
        self.factors.iter().map(|f| f.eval(textures, at).clamp(0.0, 1.0)).product()
    }

    /// The same for a ray, which comes from behind where its direction is that of the normal.
    #[inline]
    pub fn towards(&self, textures: &[Texture], at: &Coordinates, normal: Vec3A, ray: &Ray) -> f32 {
        let absent = self.front_alone && normal.dot(ray.direction) > 0.0 || self.hidden && ray.from_camera;
        if absent { 0.0 } else { self.at(textures, at) }
    }

    /// Mean over texture space, taking the masks for independent.
    pub fn mean(&self, textures: &[Texture]) -> f32 {
        self.factors.iter().map(|f| f.mean(textures).clamp(0.0, 1.0)).product()
    }

    /// Whether it varies over the surface.
    pub fn varies(&self) -> bool {
        self.factors.iter().any(|f| !matches!(f, FloatTexture::Constant(_)))
    }
}
