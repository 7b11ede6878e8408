//! What a cache knows of a model: the colours of its parts.

use crate::scene::Rgb;
use core::ops::{AddAssign, Mul};

/// Colours of the two parts that a cache multiplies its light by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// Albedo of the Lambertian part.
    pub diffuse: Rgb,
    /// Factor on the specular part at unit strength where the half vector points to the eye, Fresnel term of its table aside.
    pub specular: Rgb,
    /// The same where light grazes the half vector; between the two it follows Schlick's formula. Most models have one factor.
    pub grazing: Rgb,
}

impl Parts {
    /// A factor that is the same at all angles.
    pub(super) fn even(diffuse: Rgb, specular: Rgb) -> Self {
        Self { diffuse, specular, grazing: specular }
    }

    /// Whether there is nothing but a Lambertian part.
    #[inline]
    pub fn is_diffuse(&self) -> bool {
        self.specular == Rgb::ZERO && self.grazing == Rgb::ZERO
    }
}

impl Mul<Rgb> for Parts {
    type Output = Self;
    fn mul(self, c: Rgb) -> Self {
        Self { diffuse: self.diffuse * c, specular: self.specular * c, grazing: self.grazing * c }
    }
}

impl AddAssign for Parts {
    fn add_assign(&mut self, other: Self) {
        self.diffuse += other.diffuse;
        self.specular += other.specular;
        self.grazing += other.grazing;
    }
}
