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

    /// Whether the path is outside of all.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    /// Share of light left after a way of this length inside, from a surface that ends it.
    #[inline]
    pub fn left(&self, length: f32) -> Rgb {
        match self.count.checked_sub(1).and_then(|top| self.inside.get(top)) {
            Some(&absorption) if absorption != Rgb::ZERO => (-absorption * length).exp(),
            _ => Rgb::ONE,
        }
    }

    /// Share of light that comes to a surface which then scatters it: 1 where its BSDF has the way in it already.
    #[inline]
    pub fn left_before(&self, world: &World, at: &Interaction, bsdf: &Bsdf) -> Rgb {
        if self.count == 0 || at.normal.dot(at.wo) < 0.0 && world.boundary(bsdf.material()).is_some() {
            return Rgb::ONE;
        }
        self.left(at.distance)
    }

    /// The same on a way that goes on from the surface in a direction.
    #[inline]
    pub fn left_beyond(&self, world: &World, at: &Interaction, bsdf: &Bsdf, wi: Vec3A, length: f32) -> Rgb {
        if bsdf.only_reflects() {
            return self.left(length);
        }
        let mut media = *self;
        media.pass(world, at, bsdf, wi);
        media.left(length)
    }

    /// Goes on from a surface in a direction, perhaps into a glass or out of it.
    #[inline]
    pub fn pass(&mut self, world: &World, at: &Interaction, bsdf: &Bsdf, wi: Vec3A) {
        let enters = at.normal.dot(wi) < 0.0;
        if bsdf.only_reflects() || enters == (at.normal.dot(at.wo) < 0.0) {
            return;
        }
        match world.boundary(bsdf.material()) {
            Some(absorption) if enters => {
                if let Some(free) = self.inside.get_mut(self.count) {
                    *free = absorption;
                }
                self.count += 1;
            }
            Some(_) => self.count = self.count.saturating_sub(1),
            None => {}
        }
    }
}
