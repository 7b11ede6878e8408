//! The closed set of specular models, and the way from the set to one model's generic formula.

use super::{Brdf, Formula, GrayPolynomial, Lafortune, Microfacet, Phong, Values, Ward};
use core::f64::consts::PI;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Specular part of a material, at unit strength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Specular {
    /// Modified Phong.
    Phong(Phong),
    /// Sum of generalised cosine lobes.
    Lafortune(Lafortune),
    /// Ward's Gaussian lobe.
    Ward(Ward),
    /// Beckmann or GGX facets.
    Microfacet(Microfacet),
}

/// One expression for whichever concrete model `$self` holds.
macro_rules! each_model {
    ($self:ident, $m:ident => $call:expr) => {
        match $self {
            Specular::Phong($m) => $call,
            Specular::Lafortune($m) => $call,
            Specular::Ward($m) => $call,
            Specular::Microfacet($m) => $call,
        }
    };
}

/// Code to run on the model inside a [`Specular`], compiled once per model: what a vector kernel over
/// [`Formula::f`] needs, so that the choice of the model is made once and not per direction.
pub trait Visitor {
    /// What the visit returns.
    type Output;
    /// Runs on the concrete model.
    fn visit<M: Brdf + Formula>(self, model: &M) -> Self::Output;
}

/// As [`Visitor`], for code that needs the formula only and is worth compiling for each variant of a model.
pub(crate) trait FormulaVisitor {
    /// What the visit returns.
    type Output;
    /// Runs on the formula.
    fn visit<F: Formula>(self, formula: &F) -> Self::Output;
}

impl Specular {
    /// The Fresnel term as a polynomial, where there is one that is smooth enough.
    pub(crate) fn gray_polynomial(&self) -> Option<GrayPolynomial> {
        match self {
            Specular::Microfacet(m) => GrayPolynomial::new(&m.fresnel),
            _ => None,
        }
    }

    /// Runs `visitor` on the formula; `gray` is the material's own [`Specular::gray_polynomial`].
    #[inline(always)]
    pub(crate) fn visit_formula<V: FormulaVisitor>(&self, gray: Option<&GrayPolynomial>, visitor: V) -> V::Output {
        match self {
            Specular::Phong(m) => visitor.visit(m),
            Specular::Lafortune(m) => m.visit_formula(visitor),
            Specular::Ward(m) => m.visit_formula(visitor),
            Specular::Microfacet(m) => m.visit_formula(gray, visitor),
        }
    }

    /// Runs `visitor` on the concrete model.
    #[inline(always)]
    pub fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
        each_model!(self, m => visitor.visit(m))
    }

    /// Model name and values of the recipe (`kd` and `ks` belong to the material).
    pub fn values(&self) -> (&'static str, Values) {
        each_model!(self, m => m.values())
    }

    /// Whether f_r depends on the two azimuths only through their difference.
    pub fn is_isotropic(&self) -> bool {
        match self {
            Specular::Phong(_) => true,
            Specular::Lafortune(m) => m.lobes().iter().all(|l| l[0] == l[1]),
            Specular::Ward(m) => m.alpha_x == m.alpha_y,
            Specular::Microfacet(m) => m.alpha_x == m.alpha_y,
        }
    }

    /// Scale of the lobe about the mirror direction, radian, at most 1: 1/√n of a cosine lobe (of the sharpest one), or
    /// √(2 αx αy) of a distribution of half vectors (angles double on reflection, and e^−(δ/α)² is cos^(2/α²) δ).
    pub fn lobe_width(&self) -> f64 {
        let width = match self {
            Specular::Phong(m) => 1.0 / m.exponent.sqrt(),
            Specular::Lafortune(m) => 1.0 / m.lobes().iter().fold(0f64, |n, l| n.max(l[3])).sqrt(),
            Specular::Ward(m) => (2.0 * m.alpha_x * m.alpha_y).sqrt(),
            Specular::Microfacet(m) => (2.0 * m.alpha_x * m.alpha_y).sqrt(),
        };
        width.min(1.0)
    }

    /// `(a, n)` when f_r = a max(0, cos α)ⁿ with α from the mirror direction: a lobe whose mean over a cap is zonal.
    pub fn radial_exponent(&self) -> Option<(f64, f64)> {
        match self {
            Specular::Phong(m) => Some(((m.exponent + 2.0) / (2.0 * PI), m.exponent)),
            Specular::Lafortune(m) => match *m.lobes() {
                [[cx, cy, cz, n]] if cz > 0.0 && cx == -cz && cy == -cz => Some((cz.powf(n), n)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Colour that multiplies [`Brdf::eval`] per channel (1 for a model without Fresnel term).
    pub fn tint(&self, wi: DVec3, wo: DVec3) -> [f64; 3] {
        match self {
            Specular::Microfacet(m) => m.fresnel.tint((0.5 * (wi + wo).length()).min(1.0)),
            _ => [1.0; 3],
        }
    }
}

impl Brdf for Specular {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        each_model!(self, m => m.eval(wi, wo))
    }
    fn sample(&self, wo: DVec3, u: DVec2) -> Option<DVec3> {
        each_model!(self, m => m.sample(wo, u))
    }
    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        each_model!(self, m => m.pdf(wi, wo))
    }
}
