//! Microfacet reflection with Beckmann or GGX facets, isotropic or anisotropic.

use super::model::ALPHA;
use super::{Brdf, Footprint, Formula, FormulaVisitor, Fresnel, GrayPolynomial, Key};
use super::{Model, Outgoing, Presence, Profile, Specular, Value, Values, half_vector, half_vector_width};
use crate::material::MaterialError;
use crate::real::{Constant, Real};
use core::f64::consts::{LOG2_E, PI};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Distribution of the facets' normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Distribution {
    /// Gaussian slopes (Beckmann and Spizzichino 1963).
    Beckmann,
    /// Long-tailed slopes (Trowbridge and Reitz 1975; Walter et al. 2007).
    Ggx,
}

/// f_r = D F G₁(wi) G₁(wo) / (4 cosᵢ cosₒ) (Walter, Marschner, Li and Torrance 2007, "Microfacet models for refraction
/// through rough surfaces"; anisotropic as in Heitz 2014, "Understanding the masking-shadowing function").
///
/// G is the separable Smith form. G₁(w)/cos is computed as one term that stays finite at the horizon, so f_r does too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Microfacet {
    /// Distribution of normals.
    pub distribution: Distribution,
    /// Roughness along x.
    pub alpha_x: f64,
    /// Roughness along y.
    pub alpha_y: f64,
    /// Reflectance of a facet.
    pub fresnel: Fresnel,
}

const KEYS: [Key; 6] = [
    Key::number("alpha", ALPHA.0, ALPHA.1, Presence::Optional),
    Key::number("alpha_x", ALPHA.0, ALPHA.1, Presence::Optional),
    Key::number("alpha_y", ALPHA.0, ALPHA.1, Presence::Optional),
    Key::color("eta", 0.01, 100.0, Presence::Optional),
    Key::color("k", 0.01, 100.0, Presence::Optional),
    Key::color("f0", 0.0, 1.0, Presence::Optional),
];

pub(super) const BECKMANN: Model = Model {
    name: "beckmann",
    recipe: "beckmann",
    source: "Walter, Marschner, Li and Torrance 2007, Microfacet models for refraction through rough surfaces, EGSR",
    keys: &KEYS,
    build: |v| build(Distribution::Beckmann, v),
    examples: || examples(Distribution::Beckmann),
    exceptions: &[],
};

pub(super) const GGX: Model = Model {
    name: "ggx",
    recipe: "ggx",
    source: "Walter et al. 2007; Heitz 2014, Understanding the masking-shadowing function, JCGT 3(2)",
    keys: &KEYS,
    build: |v| build(Distribution::Ggx, v),
    examples: || examples(Distribution::Ggx),
    exceptions: &[],
};

/// One alpha or two; eta and k, or f0, or neither.
fn build(distribution: Distribution, v: &Values) -> Result<Specular, MaterialError> {
    let has = |key| v.get(key).is_some();
    let exclude =
        |key, other| if has(key) && has(other) { Err(MaterialError::Conflict { key, other }) } else { Ok(()) };
    exclude("alpha", "alpha_x")?;
    exclude("alpha", "alpha_y")?;
    exclude("eta", "f0")?;
    exclude("k", "f0")?;
    let (alpha_x, alpha_y) = match (v.number("alpha"), v.number("alpha_x"), v.number("alpha_y")) {
        (Ok(alpha), ..) => (alpha, alpha),
        (_, Ok(x), Ok(y)) => (x, y),
        (_, Err(_), Err(_)) => return Err(MaterialError::Missing { key: "alpha (or alpha_x and alpha_y)" }),
        (_, x, y) => (x?, y?),
    };
    let fresnel = if has("f0") {
        Fresnel::Schlick { f0: v.color("f0")? }
    } else if has("eta") || has("k") {
        Fresnel::Conductor { eta: v.color("eta")?, k: v.color("k")? }
    } else {
        Fresnel::None
    };
    Ok(Specular::Microfacet(Microfacet { distribution, alpha_x, alpha_y, fresnel }))
}

fn examples(distribution: Distribution) -> Vec<Specular> {
    let gold = Fresnel::Conductor { eta: [0.143, 0.375, 1.442], k: [3.983, 2.386, 1.603] };
    let plastic = Fresnel::Schlick { f0: [0.04; 3] };
    let tinted = Fresnel::Schlick { f0: [0.9, 0.6, 0.3] };
    let instances = [
        (0.01, 0.01, Fresnel::None),
        (0.1, 0.1, Fresnel::None),
        (0.3, 0.3, gold),
        (0.1, 0.5, tinted),
        (0.4, 0.4, plastic),
        (1.0, 1.0, Fresnel::None),
    ];
    let model = |(alpha_x, alpha_y, fresnel)| Microfacet { distribution, alpha_x, alpha_y, fresnel };
    instances.map(|instance| Specular::Microfacet(model(instance))).to_vec()
}

/// Walter's rational fit of Beckmann's G₁ in a = cosθ/(α sinθ): (c₀ + c₁ a) a / (1 + c₂ a + c₃ a²), and 1 from its end on.
pub(crate) const WALTER: [f64; 4] = [3.535, 2.181, 2.276, 2.577];
/// Where that fit ends.
pub(crate) const WALTER_END: f64 = 1.6;

/// Reflectance of the facets in a kernel.
trait Reflectance {
    /// At the cosine between `wi` and the half vector, given the squared length of wi + wo.
    fn at<T: Real>(&self, h2: T) -> T;
}

/// Cosine between `wi` and the half vector from |wi + wo|².
#[inline(always)]
fn half_cosine<T: Real>(h2: T) -> T {
    (h2 * h2.lit(0.25)).min(h2.lit(1.0)).sqrt()
}

/// Reflects everything.
struct Mirror;

impl Reflectance for Mirror {
    #[inline(always)]
    fn at<T: Real>(&self, h2: T) -> T {
        h2.lit(1.0)
    }
}

impl Reflectance for Fresnel {
    #[inline(always)]
    fn at<T: Real>(&self, h2: T) -> T {
        self.gray(half_cosine(h2))
    }
}

impl Reflectance for GrayPolynomial {
    #[inline(always)]
    fn at<T: Real>(&self, h2: T) -> T {
        GrayPolynomial::at(self, half_cosine(h2))
    }
}

/// The formula with its constants prepared and its choices made when it is compiled: branches in the innermost loop would
/// keep the compiler from moving what does not change out of it.
struct Facets<'a, const GGX: bool, R> {
    /// What the squared slopes along x and y are multiplied by: 1/α², for the exponential of Beckmann times −log₂e.
    slope: [Constant; 2],
    /// α² along x and y.
    width: [Constant; 2],
    /// What the distribution is multiplied by to become a density in sr⁻¹, over 4.
    scale: Constant,
    reflectance: &'a R,
}

impl<'a, const GGX: bool, R> Facets<'a, GGX, R> {
    #[inline(always)]
    fn new(model: &Microfacet, reflectance: &'a R) -> Self {
        let alphas = [model.alpha_x, model.alpha_y];
        let per_slope = if GGX { 1.0 } else { -LOG2_E };
        Self {
            slope: alphas.map(|a| (per_slope / (a * a)).into()),
            width: alphas.map(|a| (a * a).into()),
            scale: (0.25 / (PI * model.alpha_x * model.alpha_y)).into(),
            reflectance,
        }
    }

    /// D(h) of a peak of 1 for h = wi + wo of any length, and |h|². With α ≤ 1 the ratio below is at most 1, also in the
    /// limit h → 0 where `wi` and `wo` graze from opposite sides.
    #[inline(always)]
    fn d<T: Real>(&self, h: [T; 3]) -> (T, T) {
        let like = h[0];
        let [x2, y2, z2] = [h[0].sq(), h[1].sq(), h[2].sq()];
        let slope2 = x2 * like.constant(self.slope[0]) + y2 * like.constant(self.slope[1]);
        let h2 = x2 + y2 + z2;
        let tiny = like.lit(1e-30);
        let d = if GGX {
            (h2 * (slope2 + z2).max(tiny).recip()).sq()
        } else {
            // e^−t (1/cos²)² with 1/cos² cut where e^−t has long vanished, so that no overflow meets the zero
            let over_z2 = z2.max(h2 * like.lit(1e-8)).max(tiny).recip();
            (slope2 * over_z2).exp2() * (h2 * over_z2).sq()
        };
        (d, h2)
    }

    /// G₁(w)/cosθ.
    #[inline(always)]
    fn g1_over_cos<T: Real>(&self, w: [T; 3]) -> T {
        let like = w[0];
        let width2 = w[0].sq() * like.constant(self.width[0]) + w[1].sq() * like.constant(self.width[1]);
        if GGX {
            like.lit(2.0) * (w[2] + (w[2].sq() + width2).max(like.lit(1e-30)).sqrt()).recip()
        } else {
            let over_width = width2.max(like.lit(1e-30)).sqrt().recip();
            let [c0, c1, c2, c3] = WALTER.map(|c| like.lit(c));
            let a = (w[2] * over_width).min(like.lit(WALTER_END));
            let denominator = (a * c3 + c2) * a + like.lit(1.0);
            let fit = (a * c1 + c0) * denominator.recip() * over_width;
            T::select(a.lt(like.lit(WALTER_END)), fit, w[2].max(like.lit(1e-30)).recip())
        }
    }
}

impl<const GGX: bool, R: Reflectance> Formula for Facets<'_, GGX, R> {
    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        self.rest(wi, wo) * self.factor(wo)
    }

    #[inline(always)]
    fn factor<T: Real>(&self, wo: [T; 3]) -> T {
        self.g1_over_cos(wo) * wo[2].constant(self.scale)
    }

    #[inline(always)]
    fn rest<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        let h = [wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]];
        let (d, h2) = self.d(h);
        d * self.g1_over_cos(wi) * self.reflectance.at(h2)
    }
}

impl Profile for Microfacet {
    fn values(&self) -> (&'static str, Values) {
        let model = match self.distribution {
            Distribution::Beckmann => "beckmann",
            Distribution::Ggx => "ggx",
        };
        let mut values = if self.alpha_x == self.alpha_y {
            vec![("alpha", Value::Number(self.alpha_x))]
        } else {
            vec![("alpha_x", Value::Number(self.alpha_x)), ("alpha_y", Value::Number(self.alpha_y))]
        };
        match self.fresnel {
            Fresnel::None => {}
            Fresnel::Schlick { f0 } => values.push(("f0", Value::Color(f0))),
            Fresnel::Conductor { eta, k } => values.extend([("eta", Value::Color(eta)), ("k", Value::Color(k))]),
        }
        (model, Values(values))
    }

    fn is_isotropic(&self) -> bool {
        self.alpha_x == self.alpha_y
    }

    fn lobe_width(&self) -> f64 {
        half_vector_width(self.alpha_x, self.alpha_y)
    }

    fn narrowing(&self, wo: DVec3) -> f64 {
        wo.z
    }

    fn footprint(&self, view: &Outgoing) -> Footprint {
        Footprint::slopes(view, self.alpha_x, self.alpha_y, self.distribution == Distribution::Ggx)
    }

    fn radial_exponent(&self) -> Option<(f64, f64)> {
        None
    }

    fn fresnel(&self) -> Option<&Fresnel> {
        Some(&self.fresnel).filter(|f| **f != Fresnel::None)
    }

    #[inline(always)]
    fn visit_formula<V: FormulaVisitor>(&self, gray: Option<&GrayPolynomial>, visitor: V) -> V::Output {
        match (self.distribution, self.fresnel, gray) {
            (Distribution::Ggx, Fresnel::None, _) => visitor.visit(&Facets::<true, _>::new(self, &Mirror)),
            (Distribution::Ggx, _, Some(gray)) => visitor.visit(&Facets::<true, _>::new(self, gray)),
            (Distribution::Ggx, fresnel, None) => visitor.visit(&Facets::<true, _>::new(self, &fresnel)),
            (Distribution::Beckmann, Fresnel::None, _) => visitor.visit(&Facets::<false, _>::new(self, &Mirror)),
            (Distribution::Beckmann, _, Some(gray)) => visitor.visit(&Facets::<false, _>::new(self, gray)),
            (Distribution::Beckmann, fresnel, None) => visitor.visit(&Facets::<false, _>::new(self, &fresnel)),
        }
    }
}

impl Formula for Microfacet {
    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        match self.distribution {
            Distribution::Ggx => Facets::<true, _>::new(self, &self.fresnel).f(wi, wo),
            Distribution::Beckmann => Facets::<false, _>::new(self, &self.fresnel).f(wi, wo),
        }
    }
}

impl Brdf for Microfacet {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.f(wi.to_array(), wo.to_array())
    }

    /// Visible GGX normals by spherical caps (Dupuy and Benyoub 2023) for both distributions: for Beckmann facets
    /// D/D_ggx ≤ 4/e and G₁/G₁_ggx < 1.8, so the weight f_r cos/pdf stays below 2.7 F without a numerical inversion.
    fn sample(&self, wo: DVec3, u: DVec2) -> Option<DVec3> {
        // stretch the view to the hemisphere configuration
        let alpha = DVec3::new(self.alpha_x, self.alpha_y, 1.0);
        let view = (alpha * wo).normalize();
        // sample the cap of directions whose half vector with the view is visible
        let z = (1.0 - u.x) * (1.0 + view.z) - view.z;
        let s = (1.0 - z * z).max(0.0).sqrt();
        let (sp, cp) = (2.0 * PI * u.y).sin_cos();
        // unstretch the normal and reflect about it
        let h = (alpha * (DVec3::new(s * cp, s * sp, z) + view)).try_normalize()?;
        let wi = 2.0 * wo.dot(h) * h - wo;
        (wi.z > 0.0).then_some(wi)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let Some((h, _)) = half_vector(wi, wo) else { return 0.0 };
        let ggx = Facets::<true, _>::new(self, &Mirror);
        ggx.d(h.to_array()).0 * ggx.factor(wo.to_array())
    }
}
