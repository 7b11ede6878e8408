//! Sheen: fibres that stand on the surface and shine towards grazing, as on velvet.

use super::{Brdf, Footprint, Formula, FormulaVisitor, Fresnel, GrayPolynomial};
use super::{Key, Model, Outgoing, Presence, Profile, Specular, Value, Values};
use crate::real::{Constant, Real};
use core::f64::consts::{LOG2_E, PI};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// f_r = D V with D = (2 + 1/α) sin^(1/α) θh / 2π and V = 1/(4 cosᵢ cosₒ (1 + Λ(cosᵢ) + Λ(cosₒ))) (Estevez and Kulla
/// 2017, "Production friendly microfacet sheen BRDF", the "Charlie" sheen; glTF's `KHR_materials_sheen` with α the square
/// of its roughness). The softening of the terminator that the paper adds for wi alone is left out: it is not reciprocal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheen {
    /// Roughness: the fibres' inclination spreads as α grows.
    pub alpha: f64,
}

/// Smallest roughness: below it the albedo of the formula passes 1 towards grazing (.988 here, 1.010 at .065, 89.7°).
const MIN_ALPHA: f64 = 0.07;

/// Smallest cosine that V is taken at: nearer to the horizon than 1e-4 rad it has a pole.
pub(crate) const FLOOR: f64 = 1e-4;

pub(super) const CHARLIE: Model = Model {
    name: "sheen",
    recipe: "sheen",
    source: "Estevez and Kulla 2017, Production friendly microfacet sheen BRDF, SIGGRAPH course",
    keys: &[Key::number("alpha", MIN_ALPHA, 1.0, Presence::Required)],
    build: |v| Ok(Specular::Sheen(Sheen { alpha: v.number("alpha")? })),
    examples: || [0.07, 0.15, 0.4, 1.0].map(|alpha| Specular::Sheen(Sheen { alpha })).to_vec(),
    exceptions: &[],
};

impl Profile for Sheen {
    fn values(&self) -> (&'static str, Values) {
        ("sheen", Values(vec![("alpha", Value::Number(self.alpha))]))
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    /// That of sin^(1/α) about the horizon.
    fn lobe_width(&self) -> f64 {
        self.alpha.sqrt()
    }

    fn narrowing(&self, _: DVec3) -> f64 {
        1.0
    }

    /// No lobe: everything, brightest where wi grazes on the side of `wo`.
    fn footprint(&self, view: &Outgoing) -> Footprint {
        Footprint::cosine(view, DVec2::X, 1.0)
    }

    fn radial_exponent(&self) -> Option<(f64, f64)> {
        None
    }

    fn fresnel(&self) -> Option<&Fresnel> {
        None
    }

    #[inline(always)]
    fn visit_formula<V: FormulaVisitor>(&self, _: Option<&GrayPolynomial>, visitor: V) -> V::Output {
        visitor.visit(&Fibres::new(self))
    }
}

/// The formula with its constants prepared.
struct Fibres {
    /// 1/2α: the power of sin².
    power: Constant,
    /// (2 + 1/α)/8π.
    scale: Constant,
    /// a, b, c, d, e of L(x) = a/(1 + b x^c) + d x + e.
    fit: [Constant; 5],
    /// 2 L(½).
    twice_middle: Constant,
}

impl Fibres {
    #[inline(always)]
    fn new(model: &Sheen) -> Self {
        // Table 1 of the paper: at α = 0 and α = 1, blended by (1 − α)².
        const ROUGH: [f64; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
        const SMOOTH: [f64; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
        let t = (1.0 - model.alpha).powi(2);
        let fit: [f64; 5] = core::array::from_fn(|i| ROUGH[i] + t * (SMOOTH[i] - ROUGH[i]));
        let [a, b, c, d, e] = fit;
        let middle = a / (1.0 + b * 0.5f64.powf(c)) + 0.5 * d + e;
        Self {
            power: (0.5 / model.alpha).into(),
            scale: ((2.0 + 1.0 / model.alpha) / (8.0 * PI)).into(),
            fit: fit.map(Constant::from),
            twice_middle: (2.0 * middle).into(),
        }
    }

    /// Λ(cosθ).
    #[inline(always)]
    fn lambda<T: Real>(&self, cos: T) -> T {
        let (half, one) = (cos.lit(0.5), cos.lit(1.0));
        let below = cos.lt(half);
        let x = T::select(below, cos, one - cos);
        let [a, b, c, d, e] = self.fit.map(|k| cos.constant(k));
        let l = a * (x.powf(c) * b + one).recip() + d * x + e;
        let exponent = T::select(below, l, cos.constant(self.twice_middle) - l);
        (exponent * cos.lit(LOG2_E)).exp2()
    }
}

impl Formula for Fibres {
    const LONG: bool = true;

    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        let one = wi[0].lit(1.0);
        let h = [wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]];
        let (across, z2) = (h[0].sq() + h[1].sq(), h[2].sq());
        let sin2 = (across * (across + z2).max(one.lit(1e-30)).recip()).min(one);
        let d = sin2.powf(one.constant(self.power)) * one.constant(self.scale);
        let [cos_i, cos_o] = [wi[2], wo[2]].map(|cos| cos.max(one.lit(FLOOR)).min(one));
        d * (cos_i * cos_o * (self.lambda(cos_i) + self.lambda(cos_o) + one)).recip()
    }
}

#[cfg(feature = "wgsl")]
impl Sheen {
    /// The constants of the formula, as a shader takes them: power and scale of D, a to e of L, 2 L(½).
    pub(crate) fn numbers(&self) -> [f64; 8] {
        let Fibres { power, scale, fit: [a, b, c, d, e], twice_middle } = Fibres::new(self);
        [power, scale, a, b, c, d, e, twice_middle].map(Constant::wide)
    }
}

impl Formula for Sheen {
    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        Fibres::new(self).f(wi, wo)
    }
}

impl Brdf for Sheen {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.f(wi.to_array(), wo.to_array())
    }

    /// Uniform over the hemisphere, as in the paper: f_r cosᵢ hardly varies but for D.
    fn sample(&self, _: DVec3, u: DVec2) -> Option<DVec3> {
        let z = 1.0 - u.x;
        let (sp, cp) = (2.0 * PI * u.y).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        (z > 0.0).then_some(DVec3::new(r * cp, r * sp, z))
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z > 0.0 && wo.z > 0.0 { 0.5 / PI } else { 0.0 }
    }
}
