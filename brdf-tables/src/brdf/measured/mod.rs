//! A material that was measured: f_r as a lattice of values, not a formula.

mod build;
mod coordinates;
mod data;
mod lattice;
mod sampler;

use super::{Brdf, Distribution, Footprint, Formula, FormulaVisitor, Fresnel, GrayPolynomial, Microfacet};
use super::{Outgoing, Profile, Value, Values, half_vector_width};
use crate::real::{Pair, Real};
use core::f64::consts::{FRAC_1_PI, TAU};
use core::fmt;
use data::{Data, Lookup};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub use build::{BuildError, Built, build};
pub use coordinates::{angles, directions};
#[cfg(feature = "wgsl")]
pub(crate) use data::INSIDE;

/// f_r from values over the half and difference angles (Rusinkiewicz 1998, "A new change of variables for efficient BRDF
/// representation"), isotropic, reciprocal and symmetric about the plane of incidence by its coordinates.
///
/// The logarithms of the values, 16 bits each, are interpolated in functions of these angles that follow highlights and the
/// horizon, and are found without any arc; what the lattice holds is grey, with the
/// colours in a coarser one beside it ([`Measured::tint`]). Directions are drawn from a cosine and visible GGX normals, fitted
/// to the values, with their exact density.
///
/// It is a handle: values are kept once for the life of the process, however often the same ones are read, so that materials
/// stay small and are copied like those of formulas. [`build`] makes one of any function of two directions.
#[derive(Clone, Copy)]
pub struct Measured(&'static Data);

impl Measured {
    /// What the material is called: the name of the file it was read from.
    pub fn name(&self) -> &'static str {
        &self.0.stored.name
    }

    /// Nodes along functions of θh, θd and φd, in this order: (1 − cosθh)^¼, (1 − cosθd)^½, and the square of the z of the
    /// difference of the directions over the largest that it has at θh and θd above the horizon.
    pub fn lattice(&self) -> [usize; 3] {
        self.0.shape.nodes()
    }

    /// Nodes of the colours along the same axes; `None` where the values are grey.
    pub fn tint_lattice(&self) -> Option<[usize; 3]> {
        self.0.tint.as_ref().map(|(shape, _)| shape.nodes())
    }

    /// Bytes that the values take in a file.
    pub fn bytes(&self) -> usize {
        2 * (self.0.stored.values.len() + self.0.stored.tint.len())
    }

    /// Roughness of the GGX normals that directions are drawn from, and the probability of the cosine instead.
    pub fn sampler(&self) -> (f64, f64) {
        (self.0.stored.alpha, self.0.stored.share)
    }

    /// Colour that multiplies [`Brdf::eval`]: the mean of its channels is 1.
    pub fn tint(&self, wi: DVec3, wo: DVec3) -> [f64; 3] {
        let Some((shape, tint)) = &self.0.tint else { return [1.0; 3] };
        let mut sum = [0.0; 3];
        for (node, weight) in shape.corners(coordinates::unit(wi.to_array(), wo.to_array())) {
            for c in 0..3 {
                sum[c] += weight * f64::from(tint[node][c]);
            }
        }
        // Their mean is 1 but for the rounding of what is stored.
        let mean = (sum[0] + sum[1] + sum[2]) / 3.0;
        if mean > 0.0 { sum.map(|t| t / mean) } else { [1.0; 3] }
    }

    /// What a shader takes: nodes, the logarithms that 0 and 65535 stand for, and pairs of neighbours.
    #[cfg(feature = "wgsl")]
    pub(crate) fn numbers(&self) -> ([usize; 3], [f64; 2], Vec<u32>) {
        (self.lattice(), self.0.stored.range, self.0.pairs())
    }

    fn facets(&self) -> Microfacet {
        let alpha = self.0.stored.alpha;
        Microfacet { distribution: Distribution::Ggx, alpha_x: alpha, alpha_y: alpha, fresnel: Fresnel::None }
    }
}

impl PartialEq for Measured {
    /// The same values: they are kept once.
    fn eq(&self, other: &Self) -> bool {
        core::ptr::eq(self.0, other.0)
    }
}

impl fmt::Debug for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Measured({}, {:08x})", self.name(), self.0.checksum)
    }
}

impl Serialize for Measured {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Measured {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stored = data::Stored::deserialize(deserializer)?;
        Data::new(stored).map(|data| Self(data::keep(data))).map_err(serde::de::Error::custom)
    }
}

impl Profile for Measured {
    /// What tells materials apart: their name, and a checksum of their values.
    fn values(&self) -> (&'static str, Values) {
        let (name, checksum) = (Value::Word(self.name()), Value::Word(&self.0.checksum_text));
        ("measured", Values(vec![("name", name), ("checksum", checksum)]))
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn lobe_width(&self) -> f64 {
        half_vector_width(self.0.stored.alpha, self.0.stored.alpha)
    }

    fn narrowing(&self, wo: DVec3) -> f64 {
        wo.z
    }

    fn footprint(&self, view: &Outgoing) -> Footprint {
        Footprint::slopes(view, self.0.stored.alpha, self.0.stored.alpha, true)
    }

    fn radial_exponent(&self) -> Option<(f64, f64)> {
        None
    }

    fn fresnel(&self) -> Option<&Fresnel> {
        None
    }

    #[inline(always)]
    fn visit_formula<V: FormulaVisitor>(&self, _: Option<&GrayPolynomial>, visitor: V) -> V::Output {
        visitor.visit(&Lookup::new(self.0))
    }
}

impl Formula for Measured {
    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        Lookup::new(self.0).f(wi, wo)
    }
}

impl Formula for Lookup<'_> {
    #[inline(always)]
    fn f<T: Real>(&self, wi: [T; 3], wo: [T; 3]) -> T {
        self.value(coordinates::unit(wi, wo))
    }

    /// A look-up is a chain of roots, one reading and a power, each of which waits for the one before: side by side, four
    /// chains take little more than two.
    const LONG: bool = true;

    #[inline(always)]
    fn rest_of_four<T: Real>(&self, [a, b, c, d]: [[T; 3]; 4], [x, y, z]: [T; 3]) -> [T; 4] {
        let four = |a: T, b: T, c: T, d: T| Pair(Pair(a, b), Pair(c, d));
        let wi = [four(a[0], b[0], c[0], d[0]), four(a[1], b[1], c[1], d[1]), four(a[2], b[2], c[2], d[2])];
        let wo = [four(x, x, x, x), four(y, y, y, y), four(z, z, z, z)];
        let Pair(Pair(a, b), Pair(c, d)) = self.f(wi, wo);
        [a, b, c, d]
    }
}

impl Brdf for Measured {
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        self.f(wi.to_array(), wo.to_array())
    }

    fn sample(&self, wo: DVec3, u: DVec2) -> Option<DVec3> {
        let share = self.0.stored.share;
        if u.x >= share {
            return self.facets().sample(wo, DVec2::new((u.x - share) / (1.0 - share), u.y));
        }
        let radius2 = u.x / share;
        let (s, c) = (TAU * u.y).sin_cos();
        let r = radius2.sqrt();
        Some(DVec3::new(r * c, r * s, (1.0 - radius2).max(0.0).sqrt())).filter(|wi| wi.z > 0.0)
    }

    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let share = self.0.stored.share;
        share * wi.z * FRAC_1_PI + (1.0 - share) * self.facets().pdf(wi, wo)
    }
}

#[cfg(test)]
mod tests;
