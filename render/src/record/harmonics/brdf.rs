//! A BRDF times cosine as harmonics, for outgoing directions on a parabolic map (Kautz et al. 2002; Křivánek et al. 2005,
//! §4.1 and Fig. 2): each direction has the least order that holds its error, or is not cached.

use super::basis::{Basis, MAX_ORDER, PACKED, PerM, WIDTH, legendre_rows, multiples, row, row_length};
use super::projection::{BLOCK, Sum, accumulate};
use crate::bsdf::Parts;
use crate::record::reflector::fresnel_tint;
use crate::record::schlick::{Colors, Edge};
use crate::scene::Rgb;
use brdf_tables::brdf::{Brdf, Fresnel, Specular};
use brdf_tables::gauss::gauss_legendre;
use core::f64::consts::PI;
use glam::{DVec3, Vec2, Vec3A};
use rayon::prelude::*;

/// Smallest order: what the cosine of the Lambertian part needs.
pub(super) const MIN_ORDER: usize = 3;

/// Which order a direction takes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub enum OrderChoice {
    /// The least one that loses at most this share of ∫(f_r cosθ)² dω; directions that no order up to [`MAX_ORDER`] holds are
    /// not cached.
    Error(f32),
    /// This one for every direction, whatever it loses.
    Fixed(usize),
}

/// One outgoing direction of the map.
#[derive(Clone, Debug)]
struct Texel {
    order: usize,
    /// Whether radiance caching is used.
    cached: bool,
    /// Share of the squared norm that the order loses.
    error: f32,
    /// Packed coefficients: cosine rows and, where the material is anisotropic, sine rows.
    numbers: Box<[f32]>,
}

/// Specular part of a material at unit strength.
#[derive(Clone, Debug)]
pub struct HarmonicBrdf {
    /// Functions.
    pub basis: Basis,
    /// The model.
    pub specular: Specular,
    edge: Edge,
    isotropic: bool,
    /// Intervals from the middle of the map to its rim.
    intervals: usize,
    /// Isotropic: along one radius; the azimuth is a turn. Otherwise the first quadrant: all models are symmetric about both
    /// axes.
    texels: Vec<Texel>,
}

/// What the map holds about an outgoing direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outgoing {
    /// Largest order among the texels around it.
    pub order: usize,
    /// Share of path tracing: 0 where all texels around are cached, 1 where none is.
    pub traced: f32,
}

/// Rim of the map: 88.9° from the normal. Beyond, models vanish or explode.
const RIM: f64 = 0.98;

impl HarmonicBrdf {
    /// Fills the map.
    pub fn new(specular: Specular, basis: Basis, choice: OrderChoice) -> Self {
        let isotropic = specular.is_isotropic();
        let width = specular.lobe_width();
        // The error of interpolating lobes of width w at distances δ is δ²/8w² at their peak.
        let intervals = if isotropic { 8.0 / width } else { 3.0 / width };
        let intervals = intervals.clamp(16.0, if isotropic { 256.0 } else { 48.0 }) as usize;
        let columns = intervals + 1;
        let count = if isotropic { columns } else { columns * columns };
        let texels = (0..count)
            .into_par_iter()
            .map(|i| {
                let at = DVec3::new((i % columns) as f64, (i / columns) as f64, 0.0) / intervals as f64;
                let p = at * (RIM / at.length().max(RIM));
                let r2 = p.length_squared();
                let wo = DVec3::new(2.0 * p.x, 2.0 * p.y, 1.0 - r2) / (1.0 + r2);
                texel(&specular, basis, isotropic, choice, wo)
            })
            .collect();
        Self { basis, specular, edge: Edge::new(&specular), isotropic, intervals, texels }
    }

    /// Texels around a direction, with their shares.
    #[inline(always)]
    fn around(&self, wo: Vec3A) -> [(&Texel, f32); 4] {
        self.places(wo).map(|(i, share)| (&self.texels[i], share))
    }

    /// Their places in the map.
    #[inline(always)]
    pub(super) fn places(&self, wo: Vec3A) -> [(usize, f32); 4] {
        let p = Vec2::new(wo.x.abs(), wo.y.abs()) / (1.0 + wo.z.max(0.0));
        let scale = self.intervals as f32;
        let split = |x: f32| {
            let x = (x * scale).clamp(0.0, scale);
            let i = (x as usize).min(self.intervals - 1);
            (i, x - i as f32)
        };
        if self.isotropic {
            let (i, t) = split(p.length());
            return [(i, 1.0 - t), (i + 1, t), (i, 0.0), (i + 1, 0.0)];
        }
        let ((i, s), (j, t)) = (split(p.x), split(p.y));
        let at = |i: usize, j: usize| j * (self.intervals + 1) + i;
        [
            (at(i, j), (1.0 - s) * (1.0 - t)),
            (at(i + 1, j), s * (1.0 - t)),
            (at(i, j + 1), (1.0 - s) * t),
            (at(i + 1, j + 1), s * t),
        ]
    }

    /// Order and packed coefficients of the texels.
    #[cfg(feature = "gpu")]
    pub(super) fn functions(&self) -> impl Iterator<Item = (usize, &[f32])> {
        self.texels.iter().map(|texel| (texel.order, &*texel.numbers))
    }

    /// Whether radiance caching is used in the direction of a texel.
    #[cfg(feature = "gpu")]
    pub(super) fn is_cached(&self, texel: usize) -> bool {
        self.texels[texel].cached
    }

    /// Whether azimuths are turns.
    #[cfg(feature = "gpu")]
    pub(super) fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    /// Order and treatment of a local direction.
    #[inline(always)]
    pub fn outgoing(&self, wo: Vec3A) -> Outgoing {
        let mut out = Outgoing { order: MIN_ORDER, traced: 0.0 };
        for (texel, share) in self.around(wo) {
            if texel.cached {
                out.order = out.order.max(texel.order);
            } else {
                out.traced += share;
            }
        }
        out
    }

    /// Of the texel nearest to a local direction: its order, and the share of ∫(f_r cosθ)² dω that it loses; `None` where
    /// radiance caching is not used.
    pub fn representation(&self, wo: Vec3A) -> Option<(usize, f32)> {
        let around = self.around(wo);
        let nearest = around.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        nearest.cached.then_some((nearest.order, nearest.error))
    }

    /// Cosine and sine of the angle about the normal by which the function of a local direction must still be turned.
    #[inline(always)]
    pub fn turn(&self, wo: Vec3A) -> Vec2 {
        if self.isotropic { Vec2::new(wo.x, wo.y).try_normalize().unwrap_or(Vec2::X) } else { Vec2::X }
    }

    /// Coefficients for a local direction, packed, of the cached texels around it alone; returns what [`Self::outgoing`] does and
    /// [`Self::turn`].
    #[inline(always)]
    pub(super) fn lobe(&self, wo: Vec3A, out: &mut Sum) -> (Outgoing, Vec2) {
        let outgoing = self.outgoing(wo);
        let end = row(outgoing.order);
        out[0][..end].fill(0.0);
        out[1][..end].fill(0.0);
        let cached = 1.0 - outgoing.traced;
        for (texel, share) in self.around(wo) {
            let share = if texel.cached && share > 0.0 { share / cached } else { continue };
            let length = row(texel.order);
            for (out, numbers) in out.iter_mut().zip(texel.numbers.chunks_exact(length)) {
                out[..length].iter_mut().zip(numbers).for_each(|(o, x)| *o += x * share);
            }
        }
        if !self.isotropic {
            self.reflect(outgoing.order, wo, out);
        }
        (outgoing, self.turn(wo))
    }

    /// From the first quadrant to that of `wo`: φ → π − φ, φ → −φ.
    #[inline(always)]
    fn reflect(&self, order: usize, wo: Vec3A, [cos, sin]: &mut Sum) {
        let (x, y) = (1f32.copysign(wo.x), 1f32.copysign(wo.y));
        let mut signs: [PerM; 2] = [[1.0; WIDTH], [y * x; WIDTH]];
        for m in (1..WIDTH).step_by(2) {
            signs[0][m] = x;
            signs[1][m] = y;
        }
        for l in 0..order {
            for m in 0..row_length(l) {
                cos[row(l) + m] *= signs[0][m];
                sin[row(l) + m] *= signs[1][m];
            }
        }
    }

    /// Factor on the reflected light at unit strength, for a local direction to the eye: a colour that changes with the angle is
    /// that for light from everywhere, and the hue of the model's Fresnel term that at the mirror direction; that of Schlick's is in
    /// the colours of the parts.
    pub fn color(&self, parts: &Parts, wo: Vec3A) -> Rgb {
        let s = self.edge.at(wo);
        let color = Colors { normal: parts.specular, grazing: parts.grazing }.at(s) / self.edge.gray_at(s);
        match self.specular.fresnel() {
            Some(Fresnel::Schlick { .. }) => color,
            _ => color * fresnel_tint(&self.specular, Vec3A::new(-wo.x, -wo.y, wo.z), wo),
        }
    }

    /// Orders, errors and treatment of the map.
    pub fn summary(&self) -> Summary {
        let cached = || self.texels.iter().filter(|t| t.cached);
        Summary {
            orders: cached().fold((MAX_ORDER, 0), |(a, b), t| (a.min(t.order), b.max(t.order))),
            traced: 1.0 - cached().count() as f32 / self.texels.len() as f32,
            error: cached().map(|t| t.error).fold(0.0, f32::max),
            best: self.texels.iter().map(|t| t.error).fold(f32::INFINITY, f32::min),
        }
    }
}

/// A map in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Smallest and largest order of the cached directions.
    pub orders: (usize, usize),
    /// Share of the texels that are not cached.
    pub traced: f32,
    /// Largest error of the cached directions.
    pub error: f32,
    /// Smallest error of all.
    pub best: f32,
}

/// Projects f_r cosθ for one outgoing direction by a product rule that resolves the lobe.
fn texel(specular: &Specular, basis: Basis, isotropic: bool, choice: OrderChoice, wo: DVec3) -> Texel {
    let narrowing = specular.narrowing(wo).max(0.25);
    let rings = (8.0 / (specular.lobe_width() * narrowing)).clamp(48.0, 256.0) as usize;
    let azimuths = 2 * rings;
    // Isotropic lobes are even in φ.
    let count = if isotropic { azimuths / 2 } else { azimuths };
    let turns: Vec<(DVec3, [PerM; 2])> = (0..count)
        .map(|k| {
            let (s, c) = (2.0 * PI * (k as f64 + 0.5) / azimuths as f64).sin_cos();
            (DVec3::new(c, s, 0.0), multiples(c as f32, s as f32))
        })
        .collect();
    let share = 2.0 * PI / count as f64;
    let mut sums = [[0f32; PACKED]; 2];
    let mut norm = 0.0;
    let mut rows = [[0f32; PACKED]; BLOCK];
    let mut weights = [[[0f32; WIDTH]; BLOCK]; 2];
    for rule in gauss_legendre(rings).chunks(BLOCK) {
        weights = weights.map(|_| [[0f32; WIDTH]; BLOCK]);
        for (k, (x, weight)) in rule.iter().enumerate() {
            let z = 0.5 * (x + 1.0);
            let rho = (1.0 - z * z).sqrt();
            let (argument, sine, scale) = basis.argument(z as f32, (rho * rho) as f32);
            legendre_rows(MAX_ORDER, argument, sine, scale, &mut rows[k]);
            for (turn, [cos, sin]) in &turns {
                let f = specular.eval(DVec3::new(rho * turn.x, rho * turn.y, z), wo) * z;
                let value = 0.5 * weight * share * f;
                norm += value * f;
                for m in 0..WIDTH {
                    weights[0][k][m] += value as f32 * cos[m];
                    weights[1][k][m] += value as f32 * sin[m];
                }
            }
            for side in &mut weights {
                side[k][1..].iter_mut().for_each(|w| *w *= core::f32::consts::SQRT_2);
            }
        }
        let sides = if isotropic { 1 } else { 2 };
        for (sum, weights) in sums.iter_mut().zip(&weights).take(sides) {
            accumulate(MAX_ORDER, sum, &rows, weights);
        }
    }
    let band = |l: usize| {
        let squares = |rows: &[f32]| rows.iter().map(|x| f64::from(x * x)).sum::<f64>();
        sums.iter().map(|rows| squares(&rows[row(l)..row(l + 1)])).sum::<f64>()
    };
    // A lobe that never shines is held by anything.
    let lost = |order: usize| {
        if norm > 0.0 { (1.0 - (0..order).map(band).sum::<f64>() / norm).max(0.0) as f32 } else { 0.0 }
    };
    let (order, cached) = match choice {
        OrderChoice::Fixed(order) => (order.clamp(1, MAX_ORDER), true),
        OrderChoice::Error(error) => match (MIN_ORDER..=MAX_ORDER).find(|&n| lost(n) <= error) {
            Some(order) => (order, true),
            None => (MAX_ORDER, false),
        },
    };
    let numbers = match (cached, isotropic) {
        (false, _) => Vec::new(),
        (true, true) => sums[0][..row(order)].to_vec(),
        (true, false) => [&sums[0][..row(order)], &sums[1][..row(order)]].concat(),
    };
    Texel { order, cached, error: lost(order), numbers: numbers.into_boxed_slice() }
}

#[cfg(test)]
mod tests {
    use super::super::projection::compact;
    use super::super::rotation::about_z;
    use super::*;
    use brdf_tables::brdf::{Phong, Ward, WardVariant};

    fn phong(exponent: f64) -> Specular {
        Specular::Phong(Phong { exponent })
    }

    /// f_r cosθ off the texels, from the coefficients: within the error that was asked for, and that of interpolation.
    #[test]
    fn lobes_come_back_off_the_texels() {
        let ward = Specular::Ward(Ward { alpha_x: 0.6, alpha_y: 0.25, variant: WardVariant::Ward1992 });
        for (specular, choice, bound) in [
            (phong(5.0), OrderChoice::Error(1e-3), 2e-3),
            (phong(40.0), OrderChoice::Error(1e-3), 2e-3),
            (phong(100.0), OrderChoice::Fixed(29), 4e-3),
            (ward, OrderChoice::Error(1e-2), 1.5e-2),
        ] {
            for basis in [Basis::Hemispherical, Basis::Spherical] {
                let brdf = HarmonicBrdf::new(specular, basis, choice);
                let mut worst = 0f64;
                for wo in [Vec3A::new(0.3, -0.21, 1.0), Vec3A::new(-0.8, 0.3, 1.0), Vec3A::new(-0.1, -0.9, 0.9)] {
                    let wo = wo.normalize();
                    let mut lobe = [[0.0; PACKED]; 2];
                    let (outgoing, turn) = brdf.lobe(wo, &mut lobe);
                    if outgoing.traced > 0.0 {
                        continue;
                    }
                    about_z(outgoing.order, &mut lobe, &multiples(turn.x, turn.y));
                    let mut numbers = vec![0.0; outgoing.order * outgoing.order];
                    compact(outgoing.order, &lobe, &mut numbers);
                    let (mut wrong, mut total) = (0.0, 0.0);
                    for i in 0..4000 {
                        let z = (f64::from(i) + 0.5) / 4000.0;
                        let (s, c) = (2.4 * f64::from(i)).sin_cos();
                        let r = (1.0 - z * z).sqrt();
                        let wi = DVec3::new(r * c, r * s, z);
                        let exact = specular.eval(wi, wo.as_dvec3()) * z;
                        let values = basis.values(outgoing.order, wi.as_vec3a());
                        let found: f64 = numbers.iter().zip(&values).map(|(a, b)| f64::from(a * b)).sum();
                        wrong += (found - exact).powi(2);
                        total += exact * exact;
                    }
                    worst = worst.max(wrong / total);
                }
                println!("{specular:?} {basis:?}: {:?}, off texels {worst:.1e} of the squared norm", brdf.summary());
                assert!(worst < bound, "{specular:?} {basis:?}: {worst}");
            }
        }
    }

    /// radiance-caching-2005, Fig. 2: Phong of exponent 15 and a wide anisotropic Ward lobe at 5 %. The first is cached for every
    /// view with ten bands; the second loses some views. Sharper lobes need higher orders, and in the end none will do.
    #[test]
    fn orders_adapt_as_in_the_paper() {
        let of = |s, error| HarmonicBrdf::new(s, Basis::Hemispherical, OrderChoice::Error(error)).summary();
        let soft = of(phong(15.0), 0.05);
        assert!(soft.traced == 0.0 && soft.orders.1 <= 10 && soft.error <= 0.05, "{soft:?}");
        let mut last = 0;
        for exponent in [5.0, 20.0, 40.0, 100.0] {
            let found = of(phong(exponent), 0.01);
            println!("n = {exponent} at 1 %: {found:?}");
            assert!(found.orders.1 > last && found.error <= 0.01, "{exponent}: {found:?}");
            last = found.orders.1;
        }
        let sharp = of(phong(5000.0), 0.05);
        assert!(sharp.traced == 1.0 && sharp.best > 0.05, "{sharp:?}");
        let tight = HarmonicBrdf::new(phong(5000.0), Basis::Hemispherical, OrderChoice::Fixed(7)).summary();
        assert!(tight.traced == 0.0 && tight.orders == (7, 7) && tight.error > 0.5, "{tight:?}");
    }
}
