//! Reflection models: one per file, all behind [`Brdf`], all in [`ALL`].
//!
//! A new model is a file with its formula ([`Formula`]), sampling ([`Brdf`]) and what it knows of itself (`Profile`), and a
//! line in the list of `specular.rs`. What was measured has no formula and no recipe: [`Measured`] is made by [`build`].

mod footprint;
mod fresnel;
mod lafortune;
mod measured;
mod microfacet;
mod model;
mod phong;
mod sheen;
mod specular;
mod ward;

use crate::real::Real;
use glam::{DVec2, DVec3};

pub use footprint::Footprint;
pub(crate) use footprint::Outgoing;
pub use fresnel::Fresnel;
pub(crate) use fresnel::GrayPolynomial;
pub use lafortune::{Lafortune, MAX_LOBES};
pub use measured::{BuildError, Built, Measured, angles, build, directions};
pub use microfacet::{Distribution, Microfacet};
pub use model::{Exception, Key, Kind, Model, Presence, Value, Values};
pub use phong::Phong;
pub use sheen::Sheen;
pub use specular::{ALL, Specular, Visitor};
pub use ward::{Ward, WardVariant};

/// Numbers that shaders share with the formulas.
#[cfg(feature = "wgsl")]
pub(crate) mod constants {
    pub(crate) use super::measured::INSIDE;
    pub(crate) use super::microfacet::{WALTER, WALTER_END};
    pub(crate) use super::sheen::FLOOR as SHEEN_FLOOR;
    pub(crate) use super::ward::FLOOR as WARD_FLOOR;
}

/// Half vector of two directions of the upper hemisphere and the cosine between it and either of them; `None` where one
/// is below the horizon, or both graze from opposite sides and none exists.
fn half_vector(wi: DVec3, wo: DVec3) -> Option<(DVec3, f64)> {
    let sum = wi + wo;
    let length = sum.length(); // twice the cosine, and unlike the dot product never negative by rounding
    (wi.z > 0.0 && wo.z > 0.0 && length > 0.0).then(|| (sum / length, 0.5 * length))
}

/// Width of the lobe of a distribution of half vectors with these slopes along x and y, as of [`Specular::lobe_width`]: angles
/// double on reflection, and e^−(δ/α)² is cos^(2/α²) δ.
fn half_vector_width(alpha_x: f64, alpha_y: f64) -> f64 {
    (2.0 * alpha_x * alpha_y).sqrt()
}

/// Specular reflection model. Directions are unit vectors in the local frame (z = normal) that point away from the
/// surface; only the upper hemisphere reflects.
pub trait Brdf {
    /// f_r(wi, wo) in sr⁻¹, without the cosine; 0 where either direction is below the horizon.
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64;

    /// A direction `wi` for the unit-square point `u`, with density about proportional to the lobe seen from `wo`;
    /// `None` where the sample falls below the horizon (its mass is then missing from the integral of [`Brdf::pdf`]).
    fn sample(&self, wo: DVec3, u: DVec2) -> Option<DVec3>;

    /// Density of [`Brdf::sample`] at `wi`, in sr⁻¹.
    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64;
}

/// The model as a formula over any [`Real`]: scalar reference and vector lanes from one source.
pub trait Formula {
    /// f_r(wi, wo) in sr⁻¹ for directions of the upper hemisphere (not tested here).
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T;

    /// The factor of f_r that `wo` alone gives: a rule over many `wi` applies it once.
    #[inline(always)]
    fn factor<T: Real>(&self, wo: [T; 3]) -> T {
        wo[2].lit(1.0)
    }

    /// f_r over [`Formula::factor`].
    #[inline(always)]
    fn rest<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        self.f(wi, wo)
    }

    /// Whether it is a long chain of operations that wait for one another: look-ups then take directions four at a time, and
    /// none without need.
    const LONG: bool = false;

    /// [`Formula::rest`] of four directions.
    #[inline(always)]
    fn rest_of_four<T: Real>(&self, [a, b, c, d]: [[T; 3]; 4], wo: [T; 3]) -> [T; 4] {
        [self.rest(a, wo), self.rest(b, wo), self.rest(c, wo), self.rest(d, wo)]
    }
}

/// What a model knows of itself beside its formula. Nothing here has a default: a model that forgets one does not compile.
pub(crate) trait Profile: Brdf + Formula {
    /// Model name and values of the recipe.
    fn values(&self) -> (&'static str, Values);
    /// As [`Specular::is_isotropic`].
    fn is_isotropic(&self) -> bool;
    /// As [`Specular::lobe_width`], without its limit.
    fn lobe_width(&self) -> f64;
    /// As [`Specular::narrowing`].
    fn narrowing(&self, wo: DVec3) -> f64;
    /// Where the lobe seen from a direction lies.
    fn footprint(&self, view: &Outgoing) -> Footprint;
    /// As [`Specular::radial_exponent`].
    fn radial_exponent(&self) -> Option<(f64, f64)>;
    /// As [`Specular::fresnel`].
    fn fresnel(&self) -> Option<&Fresnel>;
    /// Runs `visitor` on the formula, compiled for this variant of the model; `gray` stands for the Fresnel term, if it is
    /// there.
    fn visit_formula<V: FormulaVisitor>(&self, gray: Option<&GrayPolynomial>, visitor: V) -> V::Output;
}

/// As [`Visitor`], for code that needs the formula only and is worth compiling for each variant of a model.
pub(crate) trait FormulaVisitor {
    /// What the visit returns.
    type Output;
    /// Runs on the formula.
    fn visit<F: Formula>(self, formula: &F) -> Self::Output;
}
