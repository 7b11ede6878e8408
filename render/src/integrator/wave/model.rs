//! Sixteen BSDFs at once: [`crate::bsdf::Bsdf`] for the models of [`crate::bsdf::Lanes`].

use super::columns::Surfaces;
use super::lanes::{Column, Framex16, Vec3x16, cosine_hemisphere, exp2, lit, powf, sin_cos_turn};
use core::f32::consts::{FRAC_1_PI, LOG2_E, PI, TAU};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// The models of a block.
pub struct Model<'a, S: Simd> {
    simd: S,
    at: &'a Surfaces<'a>,
    wo: Vec3x16<S>,
    diffuse: Vec3x16<S>,
    specular: Vec3x16<S>,
    p_diffuse: f32x16<S>,
}

/// f_r by part, and density.
pub struct Value<S: Simd> {
    pub diffuse: Vec3x16<S>,
    pub glossy: Vec3x16<S>,
    pub pdf: f32x16<S>,
}

impl<'a, S: Simd> Model<'a, S> {
    #[inline(always)]
    pub fn load(simd: S, at: &'a Surfaces<'a>) -> Self {
        let vector = |c| Vec3x16::load(simd, c);
        let [wo, diffuse, specular] = [&at.wo, &at.diffuse, &at.specular].map(vector);
        Self { simd, at, wo, diffuse, specular, p_diffuse: f32x16::load_array_ref(simd, &at.p_diffuse) }
    }

    #[inline(always)]
    fn lit(&self, x: f32) -> f32x16<S> {
        lit(self.simd, x)
    }

    #[inline(always)]
    fn column(&self, column: &Column) -> f32x16<S> {
        f32x16::load_array_ref(self.simd, column)
    }

    #[inline(always)]
    fn lanes(&self, bits: u32) -> mask32x16<S> {
        mask32x16::from_bitmask(self.simd, u64::from(bits))
    }

    /// `Bsdf::eval` of local directions, zero below the horizon.
    #[inline(always)]
    pub fn value(&self, wi: Vec3x16<S>) -> Value<S> {
        let (zero, one) = (self.lit(0.0), self.lit(1.0));
        let above = wi.z.simd_gt(zero) & self.wo.z.simd_gt(zero);
        let scale = above.select(self.lit(FRAC_1_PI), zero);
        let mut pdf = self.p_diffuse * (wi.z * scale);
        let diffuse = self.diffuse * if self.at.coats == 0 { scale } else { scale * self.passed(wi.z) };
        let (mut reflectance, mut density) = (Vec3x16 { x: zero, y: zero, z: zero }, zero);
        if self.at.cosine != 0 {
            let (lobe, pdf) = self.cosine_lobe(wi);
            reflectance = Vec3x16 { x: lobe, y: lobe, z: lobe };
            density = pdf;
        }
        if self.at.facets != 0 {
            let facets = self.lanes(self.at.facets);
            let (f, pdf) = self.facets(wi);
            reflectance = Vec3x16::select(facets, f, reflectance);
            density = facets.select(pdf, density);
        }
        let lobes = self.lanes(self.at.cosine | self.at.facets) & above;
        pdf += lobes.select((one - self.p_diffuse) * density, zero);
        let none = Vec3x16 { x: zero, y: zero, z: zero };
        Value { diffuse, glossy: Vec3x16::select(lobes, self.specular * reflectance, none), pdf }
    }

    /// Local directions by `Bsdf::sample`, and which of them are any.
    #[inline(always)]
    pub fn sample(&self, choice: f32x16<S>, u: [f32x16<S>; 2]) -> (Vec3x16<S>, mask32x16<S>) {
        let cosine = cosine_hemisphere(u);
        let some = self.wo.z.simd_gt(self.lit(0.0));
        if self.at.cosine | self.at.facets == 0 {
            return (cosine, some);
        }
        let one = self.lit(1.0);
        // Coats choose the reflection first.
        let first = choice.simd_lt(self.p_diffuse);
        let first = if self.at.coats == 0 {
            first
        } else {
            self.lanes(self.at.coats).select(choice.simd_ge(one - self.p_diffuse), first)
        };
        let base = first | !self.lanes(self.at.cosine | self.at.facets);
        let mut lobe = cosine;
        let mut some = some;
        if self.at.cosine != 0 {
            let cos = powf(u[0], one / (self.column(&self.at.exponent) + one));
            let sin = (one - cos * cos).max(self.lit(0.0)).sqrt();
            let (s, c) = sin_cos_turn(u[1]);
            let mirrored = Vec3x16 { x: -self.wo.x, y: -self.wo.y, z: self.wo.z };
            lobe = Framex16::from_normal(mirrored).to_world(Vec3x16 { x: sin * c, y: sin * s, z: cos });
        }
        if self.at.facets != 0 {
            let facets = self.lanes(self.at.facets);
            let (wi, good) = self.sample_facets(u);
            lobe = Vec3x16::select(facets, wi, lobe);
            some &= good | base | !facets;
        }
        (Vec3x16::select(base, cosine, lobe), some)
    }

    /// The cosine lobe and its density.
    #[inline(always)]
    fn cosine_lobe(&self, wi: Vec3x16<S>) -> (f32x16<S>, f32x16<S>) {
        let (one, two) = (self.lit(1.0), self.lit(2.0));
        let cos = wi.z * self.wo.z - wi.x * self.wo.x - wi.y * self.wo.y;
        let n = self.column(&self.at.exponent);
        let lobe = powf(cos, n) * ((n + two) * self.lit(1.0 / TAU));
        (lobe, lobe * ((n + one) / (n + two)))
    }

    /// f_r of the facets, and the density of reflections by the visible ones.
    #[inline(always)]
    fn facets(&self, wi: Vec3x16<S>) -> (Vec3x16<S>, f32x16<S>) {
        let wo = self.wo;
        let (one, two, tiny) = (self.lit(1.0), self.lit(2.0), self.lit(1e-30));
        let [ax, ay] = [self.column(&self.at.alpha[0]), self.column(&self.at.alpha[1])];
        let h = wi + wo;
        let (x, y, z2) = (h.x / ax, h.y / ay, h.z * h.z);
        let slope2 = x * x + y * y;
        let h2 = h.dot(h);
        let scale = self.lit(0.25 / PI) / (ax * ay);
        let peak = h2 / (slope2 + z2).max(tiny);
        let ggx = peak * peak * scale;
        let width2 = |w: Vec3x16<S>| {
            let (x, y) = (w.x * ax, w.y * ay);
            x * x + y * y
        };
        let (width_i, width_o) = (width2(wi), width2(wo));
        // G₁/cosθ.
        let smith = |z: f32x16<S>, width2: f32x16<S>| two / (z + (z * z + width2).max(tiny).sqrt());
        let (seen_i, seen_o) = (smith(wi.z, width_i), smith(wo.z, width_o));
        let pdf = ggx * seen_o;
        let mut f = pdf * seen_i;
        if self.at.beckmann != 0 {
            let over_z2 = one / z2.max(h2 * self.lit(1e-8)).max(tiny);
            let ratio = h2 * over_z2;
            let d = exp2(slope2 * over_z2 * self.lit(-LOG2_E)) * (ratio * ratio) * scale;
            // Walter's rational fit in a = cosθ/(α sinθ); 1 from a = 1.6 on.
            let walter = |z: f32x16<S>, width2: f32x16<S>| {
                let over_width = one / width2.max(tiny).sqrt();
                let a = (z * over_width).min(self.lit(1.6));
                let below = (a * self.lit(2.577) + self.lit(2.276)) * a + one;
                let fit = (a * self.lit(2.181) + self.lit(3.535)) * over_width / below;
                a.simd_lt(self.lit(1.6)).select(fit, one / z.max(tiny))
            };
            let beckmann = d * walter(wi.z, width_i) * walter(wo.z, width_o);
            f = self.lanes(self.at.beckmann).select(beckmann, f);
        }
        let cos = (self.lit(0.5) * h2.sqrt()).min(one);
        (self.fresnel(cos) * f, pdf)
    }

    /// Reflectance of the facets.
    #[inline(always)]
    fn fresnel(&self, cos: f32x16<S>) -> Vec3x16<S> {
        let coats = self.at.coats & self.at.facets;
        let coat = if coats == 0 { self.lit(0.0) } else { self.dielectric(cos) };
        let coat = Vec3x16 { x: coat, y: coat, z: coat };
        if coats == self.at.facets {
            return coat;
        }
        let metal = |i: usize| self.conductor(cos, self.column(&self.at.eta[i]), self.column(&self.at.k[i]));
        Vec3x16::select(self.lanes(coats), coat, Vec3x16 { x: metal(0), y: metal(1), z: metal(2) })
    }

    /// `fresnel::dielectric` from outside.
    #[inline(always)]
    fn dielectric(&self, cos: f32x16<S>) -> f32x16<S> {
        let (zero, one) = (self.lit(0.0), self.lit(1.0));
        let eta = self.column(&self.at.coat_eta);
        let cos2_t = one - (one - cos * cos) / (eta * eta);
        let cos_t = cos2_t.max(zero).sqrt();
        let s = (cos - eta * cos_t) / (cos + eta * cos_t);
        let p = (eta * cos - cos_t) / (eta * cos + cos_t);
        let reflected = eta.simd_eq(one).select(zero, self.lit(0.5) * (s * s + p * p));
        cos2_t.simd_gt(zero).select(reflected, one)
    }

    /// `fresnel::conductor`, of one channel.
    #[inline(always)]
    fn conductor(&self, cos: f32x16<S>, eta: f32x16<S>, k: f32x16<S>) -> f32x16<S> {
        let (zero, one, half) = (self.lit(0.0), self.lit(1.0), self.lit(0.5));
        let cos2 = cos * cos;
        let sin2 = one - cos2;
        let difference = eta * eta - k * k - sin2;
        let sum2 = (difference * difference + self.lit(4.0) * eta * eta * k * k).max(zero).sqrt();
        let a = (half * (sum2 + difference)).max(zero).sqrt();
        let twice = self.lit(2.0) * cos * a;
        let s = (sum2 + cos2 - twice) / (sum2 + cos2 + twice);
        let (sum, product) = (cos2 * sum2 + sin2 * sin2, twice * sin2);
        let p = s * ((sum - product) / (sum + product));
        (half * (s + p)).max(zero).min(one)
    }

    /// Share of light under a cosine that comes to the Lambertian part.
    #[inline(always)]
    fn passed(&self, cos: f32x16<S>) -> f32x16<S> {
        let mut shares = [1.0; super::lanes::LANES];
        let mut left = self.at.coats;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            shares[lane] = self.at.tables[lane].map_or(1.0, |table| table.transmittance(cos.as_array()[lane]));
        }
        self.column(&shares)
    }

    /// `Facets::sample_reflection`, and where it finds a direction.
    #[inline(always)]
    fn sample_facets(&self, u: [f32x16<S>; 2]) -> (Vec3x16<S>, mask32x16<S>) {
        let wo = self.wo;
        let (zero, one) = (self.lit(0.0), self.lit(1.0));
        let alpha = Vec3x16 { x: self.column(&self.at.alpha[0]), y: self.column(&self.at.alpha[1]), z: one };
        let stretched = alpha * wo;
        let view = stretched * (one / stretched.length());
        let z = (one - u[0]) * (one + view.z) - view.z;
        let r = (one - z * z).max(zero).sqrt();
        let (s, c) = sin_cos_turn(u[1]);
        let h = alpha * (Vec3x16 { x: r * c, y: r * s, z } + view);
        let length = h.length();
        let h = h * (one / length);
        let cos = wo.dot(h);
        let wi = h * (cos + cos) - wo;
        (wi, length.simd_gt(zero) & h.z.simd_gt(zero) & cos.simd_gt(zero) & wi.z.simd_gt(zero))
    }
}
