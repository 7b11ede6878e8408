//! Reflection models: one per file, all behind [`Brdf`], all in [`ALL`].

mod fresnel;
mod lafortune;
mod microfacet;
mod model;
mod phong;
mod specular;
mod ward;

use crate::real::Real;
use glam::{DVec2, DVec3};

pub use fresnel::Fresnel;
pub(crate) use fresnel::GrayPolynomial;
pub use lafortune::{Lafortune, MAX_LOBES};
pub use microfacet::{Distribution, Microfacet};
pub use model::{ALL, Exception, Key, Kind, Model, Presence, Value, Values};
pub use phong::Phong;
pub(crate) use specular::FormulaVisitor;
pub use specular::{Specular, Visitor};
pub use ward::{Ward, WardVariant};

/// Half vector of two directions of the upper hemisphere and the cosine between it and either of them; `None` where one
/// is below the horizon, or both graze from opposite sides and none exists.
fn half_vector(wi: DVec3, wo: DVec3) -> Option<(DVec3, f64)> {
    let sum = wi + wo;
    let length = sum.length(); // twice the cosine, and unlike the dot product never negative by rounding
    (wi.z > 0.0 && wo.z > 0.0 && length > 0.0).then(|| (sum / length, 0.5 * length))
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
}
