//! Scattering at a point of a surface, with Mitsuba's semantics.
//!
//! Each model works in the local frame (z = shading normal): `wo` points to the eye, `wi` to the light. Models that
//! only reflect are asked for directions of the upper hemisphere alone.

mod bend;
mod burley;
mod coat;
mod components;
mod dielectric;
mod facets;
mod fibres;
mod fresnel;
mod glass;
mod glossy;
mod lanes;
mod layers;
mod metal;
mod parts;
mod resolve;
mod rough_dielectric;
mod sheet;
#[cfg(test)]
mod tests;

use crate::frame::{Frame, cosine_hemisphere};
use crate::scene::{MaterialId, Reflection, Rgb};
pub(crate) use burley::{Added, ClearCoat};
pub(crate) use coat::{CoatTable, RoughCoat, SmoothCoat};
pub use components::Component;
pub(crate) use components::{components_of, has_base};
use core::f32::consts::FRAC_1_PI;
use core::ops::{Add, Mul};
pub(crate) use dielectric::{Dielectric, ThinDielectric};
pub(crate) use facets::Facets;
pub(crate) use fibres::FibreTable;
use glam::{Vec2, Vec3A};
pub(crate) use glass::GlassTable;
pub(crate) use glossy::{Glossy, Lobe};
pub(crate) use lanes::{LaneFresnel, LaneLobe, Lanes};
pub(crate) use layers::FacetTable;
pub(crate) use metal::{MetallicRoughness, Mirror, Principled, RoughMetal, Schlick};
pub use parts::Parts;
pub(crate) use rough_dielectric::RoughDielectric;
pub(crate) use sheet::Sheet;

/// A quantity of the diffuse part of a material beside that of the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Split {
    /// Lambertian part.
    pub diffuse: Rgb,
    /// Everything else.
    pub glossy: Rgb,
}

impl Split {
    /// Nothing.
    pub const ZERO: Self = Self { diffuse: Rgb::ZERO, glossy: Rgb::ZERO };

    /// Both parts together.
    #[inline]
    pub fn sum(self) -> Rgb {
        self.diffuse + self.glossy
    }
}

impl Mul<f32> for Split {
    type Output = Self;
    #[inline]
    fn mul(self, s: f32) -> Self {
        Self { diffuse: self.diffuse * s, glossy: self.glossy * s }
    }
}

impl Mul<Rgb> for Split {
    type Output = Self;
    #[inline]
    fn mul(self, c: Rgb) -> Self {
        Self { diffuse: self.diffuse * c, glossy: self.glossy * c }
    }
}

impl Add for Split {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { diffuse: self.diffuse + other.diffuse, glossy: self.glossy + other.glossy }
    }
}

/// f_r in sr⁻¹ (without the cosine) for a pair of directions, and the density of sampling the second.
#[derive(Clone, Copy, Debug, Default)]
pub struct Value {
    /// f_r in sr⁻¹; perfectly specular parts are not in it.
    pub f: Split,
    /// Density in sr⁻¹ of [`Bsdf::sample`], delta parts aside.
    pub pdf: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Unit direction, world space.
    pub wi: Vec3A,
    /// f_r |cosθ| / density: the factor on radiance from `wi`.
    pub weight: Split,
    /// Density in sr⁻¹, 0 for a delta direction.
    pub pdf: f32,
    /// Factor on the index of refraction along the path (1 on reflection).
    pub eta: f32,
}

impl Sample {
    /// Whether the direction comes from a perfectly specular part.
    #[inline]
    pub fn is_delta(&self) -> bool {
        self.pdf == 0.0
    }
}

/// What a model samples, in the local frame.
pub(crate) enum Scatter {
    /// A direction of the smooth part; value and density follow from it.
    Direction(Vec3A),
    /// A direction of a perfectly specular part with its weight and factor of the index of refraction.
    Delta { wi: Vec3A, weight: Rgb, eta: f32 },
}

/// A model with its parameters looked up.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Model<'a> {
    Absorb,
    Diffuse(Rgb),
    Glossy(Glossy<'a>),
    Mirror(Mirror),
    RoughMetal(RoughMetal),
    Dielectric(Dielectric),
    ThinDielectric(ThinDielectric),
    RoughDielectric(RoughDielectric),
    Sheet(Sheet),
    SmoothCoat(SmoothCoat),
    RoughCoat(RoughCoat<'a>),
    MetallicRoughness(MetallicRoughness),
    ClearCoat(ClearCoat),
    /// f_r, and a rough share of light that is reflected.
    Function(&'a dyn Reflection, Rgb),
}

/// Scattering at one point, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'a> {
    model: Model<'a>,
    /// A coat that is added to it.
    coat: Option<Added>,
    frame: Frame,
    /// To the eye, local.
    wo: Vec3A,
    /// The smooth shading normal in the local frame, where a texture bent the frame away from it.
    unbent: Option<Vec3A>,
    /// The normal of the diffuse part in the local frame, where it is not that of the frame.
    diffuse_normal: Option<Vec3A>,
    /// The normal of the triangle in the local frame, where light is to end softly with it.
    facet: Option<Vec3A>,
    /// The material behind all wrappers.
    material: MaterialId,
}

impl Bsdf<'_> {
    /// Unit normal of the local frame, on the side of the eye for models that only reflect.
    #[inline]
    pub fn normal(&self) -> Vec3A {
        self.frame.normal()
    }

    /// The local frame.
    #[inline]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Unit direction to the eye, local frame.
    #[inline]
    pub fn wo(&self) -> Vec3A {
        self.wo
    }

    /// The material behind all wrappers (two-sided, masks, bent normals, blends).
    #[inline]
    pub fn material(&self) -> MaterialId {
        self.material
    }

    /// Colours of the parts of models that are a Lambertian part and one lobe; `None` for the others.
    pub fn parts(&self) -> Option<Parts> {
        if self.coat.is_some() {
            return None;
        }
        match &self.model {
            Model::Diffuse(reflectance) => Some(Parts::even(*reflectance, Rgb::ZERO)),
            Model::Glossy(m) => Some(m.parts()),
            Model::RoughMetal(m) => Some(Parts::even(Rgb::ZERO, m.smooth.specular)),
            // A base alone: the coat is looked through.
            Model::SmoothCoat(m) if m.specular == Rgb::ZERO => Some(Parts::even(m.base_albedo(self.wo), Rgb::ZERO)),
            Model::RoughCoat(m) => Some(Parts::even(m.base_albedo(self.wo), m.specular)),
            Model::MetallicRoughness(m) => Some(m.parts(self.wo)),
            Model::Absorb
            | Model::Mirror(_)
            | Model::Dielectric(_)
            | Model::ThinDielectric(_)
            | Model::RoughDielectric(_)
            | Model::Sheet(_)
            | Model::SmoothCoat(_)
            | Model::ClearCoat(_)
            | Model::Function(..) => None,
        }
    }

    /// Whether light is reflected, never transmitted.
    #[inline]
    pub fn only_reflects(&self) -> bool {
        match self.model {
            Model::Dielectric(_) | Model::ThinDielectric(_) | Model::RoughDielectric(_) | Model::Sheet(_) => false,
            Model::Absorb
            | Model::Diffuse(_)
            | Model::Glossy(_)
            | Model::Mirror(_)
            | Model::RoughMetal(_)
            | Model::SmoothCoat(_)
            | Model::RoughCoat(_)
            | Model::MetallicRoughness(_)
            | Model::ClearCoat(_)
            | Model::Function(..) => true,
        }
    }

    /// Whether nothing but perfectly specular parts scatters: sampling lights is of no use.
    #[inline]
    pub fn is_delta(&self) -> bool {
        match &self.model {
            Model::Absorb | Model::Mirror(_) | Model::Dielectric(_) | Model::ThinDielectric(_) => true,
            Model::Sheet(m) => m.facets.is_none(),
            Model::Diffuse(_)
            | Model::Glossy(_)
            | Model::RoughMetal(_)
            | Model::RoughDielectric(_)
            | Model::SmoothCoat(_)
            | Model::RoughCoat(_)
            | Model::MetallicRoughness(_)
            | Model::ClearCoat(_)
            | Model::Function(..) => false,
        }
    }

    /// f_r and density for light from the world direction `wi`.
    #[inline(always)]
    pub fn eval(&self, wi: Vec3A) -> Value {
        self.local_value(self.frame.to_local(wi))
    }

    /// |cosθ| of a world direction in the local frame.
    #[inline]
    pub fn abs_cos(&self, wi: Vec3A) -> f32 {
        self.frame.normal().dot(wi).abs()
    }

    #[inline(always)]
    fn local_value(&self, wi: Vec3A) -> Value {
        let wo = self.wo;
        // Under a bent normal, a direction must lie on the same side of both normals (as in Mitsuba).
        if let Some(n) = self.unbent
            && n.dot(wi) * wi.z <= 0.0
        {
            return Value::default();
        }
        // What transmits has values on both sides.
        if self.only_reflects() && (wo.z <= 0.0 || wi.z <= 0.0) {
            return Value::default();
        }
        let mut value = match &self.model {
            Model::Diffuse(reflectance) => {
                Value { f: Split { diffuse: *reflectance * FRAC_1_PI, glossy: Rgb::ZERO }, pdf: wi.z * FRAC_1_PI }
            }
            Model::Glossy(m) => m.value(wo, wi),
            Model::RoughMetal(m) => m.value(wo, wi),
            Model::SmoothCoat(m) => m.value(wo, wi),
            Model::RoughCoat(m) => m.value(wo, wi),
            Model::MetallicRoughness(m) => m.value(wo, wi),
            Model::ClearCoat(m) => m.value(wo, wi),
            Model::Function(function, _) => {
                let (f, pdf) = function.eval(wi, wo);
                Value { f: Split { diffuse: Rgb::ZERO, glossy: f }, pdf }
            }
            Model::RoughDielectric(m) => return m.value(wo, wi),
            Model::Sheet(m) => return m.value(wo, wi),
            Model::Absorb | Model::Mirror(_) | Model::Dielectric(_) | Model::ThinDielectric(_) => Value::default(),
        };
        if let (Some(n), Some(bent)) = (self.unbent, self.diffuse_normal) {
            let cos = bent.dot(wi).max(0.0);
            value.f.diffuse *= cos / wi.z * bend::terminator(n.dot(wi), cos, n.dot(bent));
        }
        if let Some(facet) = self.facet {
            value.f.diffuse *= bend::terminator(facet.dot(wi), wi.z, facet.z);
        }
        match &self.coat {
            None => value,
            Some(coat) => coat.over(value, wo, wi),
        }
    }

    /// Samples a direction for light; `choice` chooses among parts. `None` where the sample is lost.
    #[inline(always)]
    pub fn sample(&self, mut choice: f32, u: Vec2) -> Option<Sample> {
        let wo = self.wo;
        if self.only_reflects() && wo.z <= 0.0 {
            return None;
        }
        // The coat is sampled by its share, what lies below by the rest.
        let of_coat = self.coat.filter(|coat| choice < coat.share);
        if let Some(coat) = &self.coat {
            choice = ((choice - coat.share) / (1.0 - coat.share)).clamp(0.0, 1.0 - f32::EPSILON);
        }
        let scatter = match &self.model {
            _ if of_coat.is_some() => of_coat.and_then(|added| added.coat.sample(wo, u)),
            Model::Absorb => None,
            Model::Diffuse(_) => Some(Scatter::Direction(cosine_hemisphere(u))),
            Model::Glossy(m) => m.sample(wo, choice, u),
            Model::Mirror(m) => m.sample(wo),
            Model::RoughMetal(m) => m.sample(wo, u),
            Model::Dielectric(m) => m.sample(wo, choice),
            Model::ThinDielectric(m) => m.sample(wo, choice),
            Model::RoughDielectric(m) => m.sample(wo, choice, u),
            Model::Sheet(m) => m.sample(wo, choice, u),
            Model::SmoothCoat(m) => m.sample(wo, choice, u),
            Model::RoughCoat(m) => m.sample(wo, choice, u),
            Model::MetallicRoughness(m) => m.sample(wo, choice, u),
            Model::ClearCoat(m) => m.sample(wo, u),
            Model::Function(function, _) => function.sample(wo, u).map(Scatter::Direction),
        }?;
        match scatter {
            Scatter::Delta { wi, weight, eta } => Some(Sample {
                wi: self.frame.to_world(wi),
                weight: Split {
                    diffuse: Rgb::ZERO,
                    glossy: weight * (1.0 / (1.0 - self.coat.map_or(0.0, |coat| coat.share))),
                },
                pdf: 0.0,
                eta,
            }),
            Scatter::Direction(wi) => {
                let Value { f, pdf } = self.local_value(wi);
                let eta = if let Model::RoughDielectric(m) = &self.model { m.eta_along(wo, wi) } else { 1.0 };
                (pdf > 0.0 && pdf.is_finite()).then(|| Sample {
                    wi: self.frame.to_world(wi),
                    weight: f * (wi.z.abs() / pdf),
                    pdf,
                    eta,
                })
            }
        }
    }

    /// Rough estimate of the share of light scattered, for denoisers: reflectance of all parts at this view.
    pub fn albedo(&self) -> Rgb {
        let own = self.own_albedo();
        self.coat.map_or(own, |coat| (own + coat.reflectance(self.wo)).min(Rgb::ONE))
    }

    fn own_albedo(&self) -> Rgb {
        match &self.model {
            Model::Absorb => Rgb::ZERO,
            Model::Diffuse(reflectance) => *reflectance,
            Model::Glossy(m) => (m.diffuse + m.specular).min(Rgb::ONE),
            Model::Mirror(m) => m.reflectance(self.wo.z.abs()),
            Model::RoughMetal(m) => m.reflectance(self.wo.z.abs()),
            Model::Dielectric(_) | Model::ThinDielectric(_) | Model::RoughDielectric(_) | Model::Sheet(_) => Rgb::ONE,
            Model::SmoothCoat(m) => m.diffuse.min(Rgb::ONE),
            Model::RoughCoat(m) => m.diffuse.min(Rgb::ONE),
            Model::MetallicRoughness(m) => m.base_color,
            Model::ClearCoat(m) => Rgb::splat(m.reflectance(self.wo.z)),
            Model::Function(_, albedo) => *albedo,
        }
    }
}

/// Mirror of `w` about the normal.
#[inline]
fn mirror(w: Vec3A) -> Vec3A {
    Vec3A::new(-w.x, -w.y, w.z)
}

fn mean(c: Rgb) -> f32 {
    (c.x + c.y + c.z) * (1.0 / 3.0)
}

/// a / (a + b), ½ where both vanish.
fn share(a: f32, b: f32) -> f32 {
    if a + b > 0.0 { a / (a + b) } else { 0.5 }
}
