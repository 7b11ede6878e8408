//! Lafortune 1997: a sum of generalised cosine lobes.

use super::{Brdf, Footprint, Formula, FormulaVisitor, Fresnel, GrayPolynomial, Key, Kind};
use super::{Model, Outgoing, Presence, Profile, Specular, Value, Values};
use crate::frame::basis;
use crate::material::MaterialError;
use crate::real::{Constant, Real};
use core::f64::consts::PI;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Most lobes a [`Lafortune`] can hold: enough for published fits, and few enough to live inline.
pub const MAX_LOBES: usize = 4;

/// f_r = Σ max(0, Cx xᵢxₒ + Cy yᵢyₒ + Cz zᵢzₒ)ⁿ (Lafortune, Foo, Torrance and Greenberg 1997, "Non-linear
/// approximation of reflectance functions", eq. 6). The strength of a lobe is in its coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 4]>", into = "Vec<[f64; 4]>")]
pub struct Lafortune {
    lobes: [[f64; 4]; MAX_LOBES],
    count: usize,
}

pub(super) const MODEL: Model = Model {
    name: "lafortune",
    recipe: "lafortune",
    source: "Lafortune, Foo, Torrance and Greenberg 1997, Non-linear approximation of reflectance functions, SIGGRAPH",
    keys: &[Key { name: "lobes", kind: Kind::Lobes, presence: Presence::Required }],
    build: |v| Lafortune::new(v.lobes("lobes")?).map(Specular::Lafortune),
    examples: || {
        let lobes: [&[[f64; 4]]; 5] = [
            &[[-1.0, -1.0, 1.0, 16.0]],
            &[[-1.05, -1.05, 0.95, 20.0]], // off-specular: brighter and nearer to the surface towards grazing
            &[[-1.0, -0.9, 1.0, 30.0]],    // anisotropic
            &[[0.9, 0.9, 0.9, 8.0], [0.0, 0.0, 0.5, 2.0]], // retro-reflective, and diffuse without a mirror part
            &[[-0.96, -0.96, 0.98, 16.0], [-1.018, -1.018, 1.018, 88.0], [-1.0125, -1.0125, 1.0125, 186.0]],
        ];
        lobes.iter().flat_map(|l| Lafortune::new(l)).map(Specular::Lafortune).collect()
    },
    exceptions: &[],
};

/// Checks a list of lobes against the limits of [`Lafortune::new`].
pub(super) fn check(key: &'static str, lobes: &[[f64; 4]]) -> Result<(), MaterialError> {
    let within = |value: f64, min: f64, max: f64| {
        (min..=max).contains(&value).then_some(()).ok_or(MaterialError::Range { key, value, min, max })
    };
    within(lobes.len() as f64, 1.0, MAX_LOBES as f64)?;
    for (at, &[cx, cy, cz, n]) in lobes.iter().enumerate() {
        [cx, cy, cz].iter().try_for_each(|&c| within(c, -100.0, 100.0))?;
        within(n, 1e-3, 1e5)?;
        if cx.abs().max(cy.abs()).max(cz.abs()).powf(n) > 1e9 {
            return Err(MaterialError::Peak { key, lobe: at + 1 });
        }
    }
    Ok(())
}

impl Lafortune {
    /// The model with the given lobes `[Cx, Cy, Cz, n]`.
    ///
    /// # Errors
    /// Not 1 to [`MAX_LOBES`] lobes, |C| > 100 or not finite, n outside [1e-3, 1e5], or a peak above 1e9 sr⁻¹.
    pub fn new(lobes: &[[f64; 4]]) -> Result<Self, MaterialError> {
        check("lobes", lobes)?;
        let mut stored = [[0.0; 4]; MAX_LOBES];
        stored[..lobes.len()].copy_from_slice(lobes);
        Ok(Self { lobes: stored, count: lobes.len() })
    }

    /// The lobes `[Cx, Cy, Cz, n]`.
    #[inline(always)]
    pub fn lobes(&self) -> &[[f64; 4]] {
        &self.lobes[..self.count]
    }

    /// The one of the largest exponent.
    pub(crate) fn sharpest(&self) -> [f64; 4] {
        self.lobes().iter().fold([0.0; 4], |s, l| if l[3] > s[3] { *l } else { s })
    }

    /// Axis of each lobe of wi seen from `wo` (not a unit vector), its exponent, and its integral over the sphere.
    fn seen_from(&self, wo: DVec3) -> impl Iterator<Item = (DVec3, f64, f64)> {
        self.lobes().iter().map(move |&[cx, cy, cz, n]| {
            let axis = DVec3::new(cx, cy, cz) * wo;
            (axis, n, axis.length().powf(n) * 2.0 * PI / (n + 1.0))
        })
    }
}

impl TryFrom<Vec<[f64; 4]>> for Lafortune {
    type Error = MaterialError;
    fn try_from(lobes: Vec<[f64; 4]>) -> Result<Self, Self::Error> {
        Self::new(&lobes)
    }
}

impl From<Lafortune> for Vec<[f64; 4]> {
    fn from(model: Lafortune) -> Self {
        model.lobes().to_vec()
    }
}

/// The formula with its constants prepared, compiled for the number of lobes.
struct Lobes<const COUNT: usize>([[Constant; 4]; COUNT]);

impl<const COUNT: usize> Lobes<COUNT> {
    #[inline(always)]
    fn new(model: &Lafortune) -> Self {
        Self(core::array::from_fn(|i| model.lobes[i].map(Constant::from)))
    }
}

impl<const COUNT: usize> Formula for Lobes<COUNT> {
    const LONG: bool = true;

    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        let (x, y, z) = (wi[0] * wo[0], wi[1] * wo[1], wi[2] * wo[2]);
        let mut sum = x.lit(0.0);
        // A loop: the compiler does not always put a closure into vector code.
        for &[cx, cy, cz, n] in &self.0 {
            let base = x * x.constant(cx) + y * x.constant(cy) + z * x.constant(cz);
            sum = sum + base.powf(x.constant(n));
        }
        sum
    }
}

impl Profile for Lafortune {
    fn values(&self) -> (&'static str, Values) {
        ("lafortune", Values(vec![("lobes", Value::Lobes(self.lobes().to_vec()))]))
    }

    fn is_isotropic(&self) -> bool {
        self.lobes().iter().all(|l| l[0] == l[1])
    }

    fn lobe_width(&self) -> f64 {
        1.0 / self.lobes().iter().fold(0f64, |n, l| n.max(l[3])).sqrt()
    }

    fn narrowing(&self, _: DVec3) -> f64 {
        1.0
    }

    /// That of the sharpest lobe: the others are wider.
    fn footprint(&self, view: &Outgoing) -> Footprint {
        let [cx, cy, cz, n] = self.sharpest();
        let (c, s) = view.rotation;
        let x = cx * c * c + cy * s * s;
        Footprint::cosine(view, DVec2::new(x * view.sin_o, cz * view.cos_o), n)
    }

    fn radial_exponent(&self) -> Option<(f64, f64)> {
        match *self.lobes() {
            [[cx, cy, cz, n]] if cz > 0.0 && cx == -cz && cy == -cz => Some((cz.powf(n), n)),
            _ => None,
        }
    }

    fn fresnel(&self) -> Option<&Fresnel> {
        None
    }

    #[inline(always)]
    fn visit_formula<V: FormulaVisitor>(&self, _: Option<&GrayPolynomial>, visitor: V) -> V::Output {
        match self.count {
            1 => visitor.visit(&Lobes::<1>::new(self)),
            2 => visitor.visit(&Lobes::<2>::new(self)),
            3 => visitor.visit(&Lobes::<3>::new(self)),
            _ => visitor.visit(&Lobes::<MAX_LOBES>::new(self)),
        }
    }
}

impl Formula for Lafortune {
    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        let (x, y, z) = (wi[0] * wo[0], wi[1] * wo[1], wi[2] * wo[2]);
        let mut sum = x.lit(0.0);
        for &[cx, cy, cz, n] in self.lobes() {
            sum = sum + (x * x.lit(cx) + y * x.lit(cy) + z * x.lit(cz)).powf(x.lit(n));
        }
        sum
    }
}

impl Brdf for Lafortune {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.f(wi.to_array(), wo.to_array())
    }

    /// Lobes are chosen by their integral over the sphere, which makes the density proportional to f_r itself.
    fn sample(&self, wo: DVec3, u: DVec2) -> Option<DVec3> {
        let total: f64 = self.seen_from(wo).map(|(_, _, integral)| integral).sum();
        let mut at = u.x * total;
        for (axis, n, integral) in self.seen_from(wo) {
            if at < integral {
                let c = (at / integral).powf(1.0 / (n + 1.0));
                let s = (1.0 - c * c).max(0.0).sqrt();
                let (sp, cp) = (2.0 * PI * u.y).sin_cos();
                let wi = basis(axis.normalize()) * DVec3::new(s * cp, s * sp, c);
                return (wi.z > 0.0).then_some(wi);
            }
            at -= integral;
        }
        None
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        let total: f64 = self.seen_from(wo).map(|(_, _, integral)| integral).sum();
        if total > 0.0 { self.eval(wi, wo) / total } else { 0.0 }
    }
}
