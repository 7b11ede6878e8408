//! The models that the path tracer evaluates for many surfaces at once, as numbers.

use super::{Bsdf, CoatTable, Facets, Glossy, Lobe, Model, RoughCoat, RoughMetal};
use crate::scene::Rgb;

/// A Lambertian part and a lobe.
pub(crate) struct Lanes<'a> {
    /// Albedo of the Lambertian part at this view; what light passes on its way in is not in it.
    pub diffuse: Rgb,
    /// Factor on the lobe.
    pub specular: Rgb,
    /// Probability of sampling the Lambertian part.
    pub p_diffuse: f32,
    pub lobe: LaneLobe<'a>,
}

/// The lobe at unit strength.
pub(crate) enum LaneLobe<'a> {
    None,
    /// A cosine lobe about the mirror direction, of this exponent.
    Cosine(f32),
    Facets(Facets, LaneFresnel<'a>),
}

/// Reflectance of the facets.
pub(crate) enum LaneFresnel<'a> {
    /// Of a metal.
    Conductor { eta: Rgb, k: Rgb },
    /// Of a coat, through which the Lambertian part is lit.
    Coat { eta: f32, table: &'a CoatTable },
}

impl<'a> Bsdf<'a> {
    /// The model, if code in lanes knows it and nothing bends its normal.
    #[inline(always)]
    pub(crate) fn in_lanes(&self) -> Option<Lanes<'a>> {
        if self.unbent.is_some() || self.facet.is_some() || self.coat.is_some() {
            return None;
        }
        match self.model {
            Model::Diffuse(diffuse) => {
                Some(Lanes { diffuse, specular: Rgb::ZERO, p_diffuse: 1.0, lobe: LaneLobe::None })
            }
            Model::Glossy(Glossy { diffuse, specular, lobe: Lobe::Phong(phong), p_diffuse }) => {
                Some(Lanes { diffuse, specular, p_diffuse, lobe: LaneLobe::Cosine(phong.exponent as f32) })
            }
            Model::RoughMetal(RoughMetal { facets, smooth }) => Some(Lanes {
                diffuse: Rgb::ZERO,
                specular: smooth.specular,
                p_diffuse: 0.0,
                lobe: LaneLobe::Facets(facets, LaneFresnel::Conductor { eta: smooth.eta, k: smooth.k }),
            }),
            Model::RoughCoat(coat) => Some(rough_coat(&coat, self.wo)),
            Model::Absorb
            | Model::Glossy(_)
            | Model::Mirror(_)
            | Model::Dielectric(_)
            | Model::ThinDielectric(_)
            | Model::RoughDielectric(_)
            | Model::Sheet(_)
            | Model::SmoothCoat(_)
            | Model::MetallicRoughness(_)
            | Model::ClearCoat(_)
            | Model::Function(..) => None,
        }
    }
}

#[inline(always)]
fn rough_coat<'a>(coat: &RoughCoat<'a>, wo: glam::Vec3A) -> Lanes<'a> {
    let (diffuse, p_specular) = coat.base_at(wo);
    let fresnel = LaneFresnel::Coat { eta: coat.eta, table: coat.table };
    Lanes {
        diffuse,
        specular: coat.specular,
        p_diffuse: 1.0 - p_specular,
        lobe: LaneLobe::Facets(coat.facets, fresnel),
    }
}
