//! Modified Phong (Lewis 1993), normalised to unit albedo at normal incidence.

use super::{Brdf, Footprint, Formula, FormulaVisitor, Fresnel, GrayPolynomial};
use super::{Key, Model, Outgoing, Presence, Profile, Specular, Value, Values};
use crate::frame::{basis, mirror};
use crate::real::Real;
use core::f64::consts::PI;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// f_r = (n+2)/(2π) max(0, cos α)^n, α between `wo` and the mirror of `wi` (Lewis 1993, "Making shaders more
/// physically plausible"). Unit strength: `ks` multiplies it in the material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phong {
    /// Shininess n ≥ 0.
    pub exponent: f64,
}

pub(super) const MODEL: Model = Model {
    name: "phong",
    recipe: "phong",
    source: "Lewis 1993, Making shaders more physically plausible, Eurographics Workshop on Rendering",
    keys: &[Key::number("exponent", 0.0, 1e5, Presence::Required)],
    build: |v| Ok(Specular::Phong(Phong { exponent: v.number("exponent")? })),
    examples: || [1.0, 5.0, 40.0, 200.0, 1000.0, 1e4].map(|exponent| Specular::Phong(Phong { exponent })).to_vec(),
    exceptions: &[],
};

impl Profile for Phong {
    fn values(&self) -> (&'static str, Values) {
        ("phong", Values(vec![("exponent", Value::Number(self.exponent))]))
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn lobe_width(&self) -> f64 {
        1.0 / self.exponent.sqrt()
    }

    fn narrowing(&self, _: DVec3) -> f64 {
        1.0
    }

    fn footprint(&self, view: &Outgoing) -> Footprint {
        Footprint::cosine(view, DVec2::new(-view.sin_o, view.cos_o), self.exponent)
    }

    fn radial_exponent(&self) -> Option<(f64, f64)> {
        Some(((self.exponent + 2.0) / (2.0 * PI), self.exponent))
    }

    fn fresnel(&self) -> Option<&Fresnel> {
        None
    }

    #[inline(always)]
    fn visit_formula<V: FormulaVisitor>(&self, _: Option<&GrayPolynomial>, visitor: V) -> V::Output {
        visitor.visit(self)
    }
}

impl Formula for Phong {
    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        let c = wi[2] * wo[2] - wi[0] * wo[0] - wi[1] * wo[1];
        c.powf(c.lit(self.exponent)) * c.lit((self.exponent + 2.0) / (2.0 * PI))
    }
}

impl Brdf for Phong {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.f(wi.to_array(), wo.to_array())
    }

    fn sample(&self, wo: DVec3, u: DVec2) -> Option<DVec3> {
        let c = u.x.powf(1.0 / (self.exponent + 1.0));
        let s = (1.0 - c * c).max(0.0).sqrt();
        let (sp, cp) = (2.0 * PI * u.y).sin_cos();
        let wi = basis(mirror(wo)) * DVec3::new(s * cp, s * sp, c);
        (wi.z > 0.0).then_some(wi)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        (self.exponent + 1.0) / (2.0 * PI) * mirror(wo).dot(wi).max(0.0).powf(self.exponent)
    }
}
