//! Absorption on the way through glass that holds other things.
//!
//! Light that meets the boundary of a glass from behind is absorbed there ([`crate::scene::Material::Glass`]), whatever the
//! path did before. What it meets inside, and what shines there, need to know which glass they are in: the path keeps it.

use crate::bsdf::Bsdf;
use crate::scene::Rgb;
use crate::world::{Interaction, World};
use glam::Vec3A;

/// The glasses that a path is inside of, the innermost last.
#[derive(Clone, Copy, Debug)]
pub struct Media {
    /// Absorption coefficients per unit of length.
    inside: [Rgb; Self::MOST],
    count: usize,
}

impl Media {
    /// Glasses inside of each other; further ones count as clear.
    const MOST: usize = 4;

    /// Outside of all.
    pub const NONE: Self = Self { inside: [Rgb::ZERO; Self::MOST], count: 0 };

    /// Share of light left after a way of this length from a surface that ends it.
    #[inline]
    pub fn left(&self, length: f32) -> Rgb {
        match self.count.checked_sub(1).map(|top| self.inside.get(top)) {
            Some(Some(&absorption)) if absorption != Rgb::ZERO => (-absorption * length).exp(),
            _ => Rgb::ONE,
        }
    }

    /// Share of light that comes to a surface which then scatters it: 1 where its BSDF has the way in it already.
    #[inline]
    pub fn left_before(&self, world: &World, at: &Interaction, bsdf: &Bsdf) -> Rgb {
        let counted = at.normal.dot(at.wo) < 0.0 && world.boundary(bsdf.material()).is_some();
        if self.count == 0 || counted { Rgb::ONE } else { self.left(at.distance) }
    }

    /// Where a path is that goes on from a surface in a direction.
    #[inline]
    pub fn beyond(&self, world: &World, at: &Interaction, bsdf: &Bsdf, wi: Vec3A) -> Self {
        let mut media = *self;
        if bsdf.only_reflects() || at.normal.dot(at.wo) * at.normal.dot(wi) >= 0.0 {
            return media;
        }
        let Some(absorption) = world.boundary(bsdf.material()) else { return media };
        if at.normal.dot(wi) < 0.0 {
            if let Some(free) = media.inside.get_mut(media.count) {
                *free = absorption;
            }
            media.count += 1;
        } else {
            media.count = media.count.saturating_sub(1);
        }
        media
    }
}
