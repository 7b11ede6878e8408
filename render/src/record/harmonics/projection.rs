//! From the samples of a gather to coefficients (Křivánek et al. 2005, eq. 4), and how these change as the record moves.

use super::basis::{
    Basis, LANES, PACKED, PerM, Rows, WIDTH, azimuths, legendre_rows, row, slope_rows, vectors, vectors_mut,
};
use super::gradient::{DISPLACEMENT, Gradients, Patch};
use crate::frame::Frame;
use crate::hemisphere::GatherSample;
use crate::scene::Rgb;
use crate::simd::widest;
use fearless_simd::Level;
use glam::Vec3A;

/// Samples that are summed together: sums are loaded and stored once for all of them.
pub(super) const BLOCK: usize = 4;

/// Sums of one quantity: cosine and sine terms.
pub(super) type Sum = [Rows; 2];

/// How to project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Projector {
    /// Functions.
    pub basis: Basis,
    /// Order n ≤ [`super::MAX_ORDER`].
    pub order: usize,
    /// Whether and how gradients are found.
    pub gradients: Gradients,
}

/// The functions at the directions of a block of samples, and the slopes of the Legendre functions.
struct Functions {
    rows: [Rows; BLOCK],
    slopes: [Rows; BLOCK],
    /// cos mφ, then sin mφ.
    turns: [[PerM; BLOCK]; 2],
}

impl Functions {
    fn new() -> Self {
        Self { rows: [[0.0; PACKED]; BLOCK], slopes: [[0.0; PACKED]; BLOCK], turns: [[[0.0; WIDTH]; BLOCK]; 2] }
    }

    #[inline(always)]
    fn set(&mut self, k: usize, projector: &Projector, direction: Vec3A, slopes: bool) {
        let Projector { basis, order, .. } = *projector;
        let rho2 = direction.x * direction.x + direction.y * direction.y;
        let (x, sine, scale) = basis.argument(direction.z, rho2);
        legendre_rows(order, x, sine, scale, &mut self.rows[k]);
        [self.turns[0][k], self.turns[1][k]] = azimuths(direction);
        if slopes {
            // dP/dz, times z in the hemispherical basis: 1 − x² = 4z(1 − z) there.
            let factor = match basis {
                Basis::Hemispherical => 0.5 * (1.0 + direction.z) / rho2.max(SMALLEST_RHO2),
                Basis::Spherical => 1.0 / rho2.max(SMALLEST_RHO2),
            };
            slope_rows(order, x, factor, &self.rows[k], &mut self.slopes[k]);
        }
    }
}

/// Smallest x² + y² that slopes are divided by.
const SMALLEST_RHO2: f32 = 1e-6;

/// Rows of numbers by m, each times the factor of its sample.
#[inline(always)]
fn weighted(turns: &[PerM; BLOCK], factors: [f32; BLOCK]) -> [PerM; BLOCK] {
    let mut out = *turns;
    for (row, factor) in out.iter_mut().zip(factors) {
        row.iter_mut().for_each(|x| *x *= factor);
    }
    out
}

/// Adds Σ rows · weights over the samples of a block.
#[inline(always)]
pub(super) fn accumulate(order: usize, sums: &mut Rows, rows: &[Rows; BLOCK], weights: &[PerM; BLOCK]) {
    let [r0, r1, r2, r3] = rows;
    let [w0, w1, w2, w3] = weights.each_ref().map(|w| w.as_chunks::<LANES>().0);
    for l in 0..order {
        let rows = vectors(r0, l).iter().zip(vectors(r1, l)).zip(vectors(r2, l).iter().zip(vectors(r3, l)));
        let weights = w0.iter().zip(w1).zip(w2.iter().zip(w3));
        for (sum, (((r0, r1), (r2, r3)), ((w0, w1), (w2, w3)))) in
            vectors_mut(sums, l).iter_mut().zip(rows.zip(weights))
        {
            // In a copy, which nothing else can point into: the compiler makes one vector of it.
            let mut out = *sum;
            for i in 0..LANES {
                out[i] += (r0[i] * w0[i] + r1[i] * w1[i]) + (r2[i] * w2[i] + r3[i] * w3[i]);
            }
            *sum = out;
        }
    }
}

/// Copies packed sums to their compact places.
pub(super) fn compact(order: usize, [cos, sin]: &Sum, out: &mut [f32]) {
    for l in 0..order {
        let (to, from) = (l * l, row(l));
        out[to..=to + l].copy_from_slice(&cos[from..=from + l]);
        out[to + l + 1..to + 2 * l + 1].copy_from_slice(&sin[from + 1..=from + l]);
    }
}

impl Projector {
    /// Numbers per record: three channels of n² coefficients, and as many for each of two gradients.
    pub fn numbers(&self) -> usize {
        let vectors = if self.gradients == Gradients::None { 3 } else { 9 };
        vectors * self.order * self.order
    }

    /// Coefficients of the samples' radiance in the frame of the basis, compact: red, green, blue, then their derivatives
    /// along x of `frame`, then along y. What is nearer than `nearest` moves as if it were there: the zone of the record is as
    /// wide, and no straight line follows faster changes.
    pub fn project(&self, samples: &[GatherSample], frame: &Frame, nearest: f32) -> Box<[f32]> {
        let count = if self.gradients == Gradients::None { 3 } else { 9 };
        let mut sums: Vec<Sum> = vec![[[0.0; PACKED]; 2]; count];
        widest(
            Level::new(),
            #[inline(always)]
            || self.sum(samples, frame, nearest, &mut sums),
        );
        let size = self.order * self.order;
        let mut out = vec![0.0; self.numbers()];
        sums.iter().zip(out.chunks_exact_mut(size)).for_each(|(sum, out)| compact(self.order, sum, out));
        out.into_boxed_slice()
    }

    #[inline(always)]
    fn sum(&self, samples: &[GatherSample], frame: &Frame, nearest: f32, sums: &mut [Sum]) {
        let spherical = self.basis == Basis::Spherical;
        let to_basis = |v: Vec3A| if spherical { frame.to_world(v) } else { v };
        let axes = [to_basis(Vec3A::X), to_basis(Vec3A::Y)];
        // Constant light has no gradient, whatever the distances: only what differs from the mean is followed.
        let total: f32 = samples.iter().map(|s| s.solid_angle).sum();
        let mean = samples.iter().map(|s| s.radiance * s.solid_angle).sum::<Rgb>() / total.max(f32::MIN_POSITIVE);
        let mut here = Functions::new();
        let mut there = Functions::new();
        for block in samples.chunks(BLOCK) {
            // Places beyond the last sample keep the zeros of these arrays.
            let (mut light, mut contrast) = ([Rgb::ZERO; BLOCK], [Rgb::ZERO; BLOCK]);
            let mut patches = [Patch { direction: Vec3A::Z, normal: -Vec3A::Z, inv_distance: 0.0 }; BLOCK];
            for (k, s) in block.iter().enumerate() {
                patches[k] = Patch {
                    direction: to_basis(s.direction),
                    normal: if spherical { s.normal } else { frame.to_local(s.normal) },
                    inv_distance: s.inv_distance.min(1.0 / nearest.max(f32::MIN_POSITIVE)),
                };
                (light[k], contrast[k]) = (s.radiance * s.solid_angle, (s.radiance - mean) * s.solid_angle);
                here.set(k, self, patches[k].direction, self.gradients == Gradients::Analytic);
            }
            let (values, gradients) = sums.split_at_mut(3);
            add(self.order, values, &here.rows, &here.turns, &light);
            for (axis, sums) in axes.into_iter().zip(gradients.chunks_exact_mut(3)) {
                if self.gradients == Gradients::Analytic {
                    self.differentiate(&patches, axis, &contrast, &here, sums);
                } else {
                    self.displace(&patches, axis, &contrast, &here, &mut there, sums);
                }
            }
        }
    }

    /// d(Ω H)/dp, term by term: the solid angle and the azimuth change what multiplies P̄, the height changes P̄.
    #[inline(always)]
    fn differentiate(
        &self,
        patches: &[Patch; BLOCK],
        axis: Vec3A,
        light: &[Rgb; BLOCK],
        here: &Functions,
        sums: &mut [Sum],
    ) {
        let mut turned = [[[0f32; WIDTH]; BLOCK]; 2];
        let mut raised = *light;
        for k in 0..BLOCK {
            let change = patches[k].change(self.basis, axis);
            let (cos, sin) = (&here.turns[0][k], &here.turns[1][k]);
            for m in 0..WIDTH {
                let turn = m as f32 * change.azimuth;
                turned[0][k][m] = cos[m] * change.solid_angle - sin[m] * turn;
                turned[1][k][m] = sin[m] * change.solid_angle + cos[m] * turn;
            }
            raised[k] *= change.height;
        }
        add(self.order, sums, &here.rows, &turned, light);
        add(self.order, sums, &here.slopes, &here.turns, &raised);
    }

    /// (Ω′ H′ − Ω H)/Δ, Δ in proportion to the distance of each sample.
    #[inline(always)]
    fn displace(
        &self,
        patches: &[Patch; BLOCK],
        axis: Vec3A,
        light: &[Rgb; BLOCK],
        here: &Functions,
        there: &mut Functions,
        sums: &mut [Sum],
    ) {
        let (mut before, mut after) = (*light, *light);
        for (k, patch) in patches.iter().enumerate() {
            let (direction, ratio) = patch.displaced(axis);
            there.set(k, self, direction, false);
            let rate = patch.inv_distance / DISPLACEMENT;
            before[k] *= -rate;
            after[k] *= rate * ratio;
        }
        add(self.order, sums, &there.rows, &there.turns, &after);
        add(self.order, sums, &here.rows, &here.turns, &before);
    }
}

/// Adds a block to three sums, one per channel.
#[inline(always)]
fn add(order: usize, sums: &mut [Sum], rows: &[Rows; BLOCK], turns: &[[PerM; BLOCK]; 2], light: &[Rgb; BLOCK]) {
    for (channel, sum) in sums.iter_mut().enumerate() {
        let factors = light.map(|l| l[channel]);
        for (sum, turns) in sum.iter_mut().zip(turns) {
            accumulate(order, sum, rows, &weighted(turns, factors));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemisphere::Incident;
    use crate::record::harmonics::MAX_ORDER;
    use brdf_tables::gauss::gauss_legendre;

    const ALL: [(Basis, Gradients); 4] = [
        (Basis::Hemispherical, Gradients::Analytic),
        (Basis::Hemispherical, Gradients::Numerical),
        (Basis::Spherical, Gradients::Analytic),
        (Basis::Spherical, Gradients::Numerical),
    ];

    /// A product rule over the hemisphere: exact for the functions, so that what differs is the gradient and not the sampling.
    fn gather(position: Vec3A, frame: &Frame, light: impl Fn(Vec3A, Vec3A) -> Incident) -> Vec<GatherSample> {
        const AZIMUTHS: u32 = 96;
        let mut samples = Vec::new();
        for (x, weight) in gauss_legendre(64) {
            let z = 0.5 * (x as f32 + 1.0);
            for k in 0..AZIMUTHS {
                let (s, c) = (core::f32::consts::TAU * k as f32 / AZIMUTHS as f32).sin_cos();
                let r = (1.0 - z * z).sqrt();
                let direction = Vec3A::new(r * c, r * s, z);
                let Incident { radiance, distance, normal } = light(position, frame.to_world(direction));
                let solid_angle = 0.5 * weight as f32 * core::f32::consts::TAU / AZIMUTHS as f32;
                let inv_distance = 1.0 / distance;
                samples.push(GatherSample {
                    direction,
                    radiance,
                    inv_distance,
                    normal,
                    solid_angle,
                    projected: solid_angle * z,
                });
            }
        }
        samples
    }

    /// The inside of a sphere of radius 2 about the origin whose wall glows smoothly: nothing hides anything.
    fn ball(position: Vec3A, direction: Vec3A) -> Incident {
        let along = position.dot(direction);
        let distance = -along + (along * along + 4.0 - position.length_squared()).sqrt();
        let q = position + direction * distance;
        let glow = 1.0 + 0.5 * (1.3 * q.x).sin() + 0.4 * (1.1 * q.y + 0.7 * q.z).cos();
        Incident { radiance: Rgb::new(glow, 0.5 * glow * glow, 0.3), distance, normal: -q / 2.0 }
    }

    /// A smooth function comes back from its coefficients at order 10: to 0.5 % of its norm if it is the same all along the
    /// horizon, which is one point of the basis, and to 2.5 % if it is not.
    #[test]
    fn smooth_functions_come_back() {
        let frame = Frame::from_normal(Vec3A::new(0.48, 0.6, 0.64));
        for (fade, bound) in [(true, 0.005), (false, 0.025)] {
            let light = |_: Vec3A, d: Vec3A| {
                let share = if fade { d.dot(frame.normal()) } else { 1.0 };
                let radiance = Rgb::splat(1.0 + share * (d.dot(Vec3A::new(0.3, -0.5, 0.4)).powi(2) + 0.5 * d.x));
                Incident { radiance, distance: f32::INFINITY, normal: Vec3A::ZERO }
            };
            let samples = gather(Vec3A::ZERO, &frame, light);
            let projector = Projector { basis: Basis::Hemispherical, order: 10, gradients: Gradients::None };
            let numbers = projector.project(&samples, &frame, 1.0);
            let (mut wrong, mut total) = (0.0, 0.0);
            for s in samples.iter().step_by(7) {
                let values = projector.basis.values(10, s.direction);
                let found: f32 = numbers[..100].iter().zip(&values).map(|(a, b)| a * b).sum();
                wrong += s.solid_angle * (found - s.radiance.x).powi(2);
                total += s.solid_angle * s.radiance.x.powi(2);
            }
            let error = (wrong / total).sqrt();
            println!("order 10 of a smooth function, fading {fade}: {:.3} % wrong", 100.0 * error);
            assert!(error < bound, "{fade} {error}");
        }
    }

    /// Sums by blocks and recurrences agree with the formula of eq. 4.
    #[test]
    fn projections_are_the_sums_of_equation_four() {
        let frame = Frame::from_normal(Vec3A::new(-0.6, 0.0, 0.8));
        let samples: Vec<GatherSample> = gather(Vec3A::ZERO, &frame, ball).into_iter().step_by(31).collect();
        assert!(!samples.len().is_multiple_of(BLOCK));
        for basis in [Basis::Hemispherical, Basis::Spherical] {
            let projector = Projector { basis, order: 12, gradients: Gradients::None };
            let numbers = projector.project(&samples, &frame, 1.0);
            for l in 0..12usize {
                for m in -(l as i32)..=l as i32 {
                    let exact: f64 = samples
                        .iter()
                        .map(|s| {
                            let d = if basis == Basis::Spherical { frame.to_world(s.direction) } else { s.direction };
                            f64::from(s.radiance.y * s.solid_angle) * basis.value(l, m, d.as_dvec3())
                        })
                        .sum();
                    let at = if m >= 0 { l * l + m as usize } else { l * l + l + m.unsigned_abs() as usize };
                    assert!((f64::from(numbers[144 + at]) - exact).abs() < 1e-4, "{basis:?} {l} {m}");
                }
            }
        }
    }

    /// Gradients in a closed room without occlusion: within 2 % of differences of projections, of their norm over the bands
    /// that hold the light.
    #[test]
    fn gradients_agree_with_finite_differences() {
        let frame = Frame::from_normal(Vec3A::new(0.36, 0.48, 0.8));
        let position = Vec3A::new(0.3, -0.4, 0.2);
        for (basis, gradients) in ALL {
            for order in [4, 10, MAX_ORDER] {
                let projector = Projector { basis, order, gradients };
                let at = |p: Vec3A| projector.project(&gather(p, &frame, ball), &frame, 0.01);
                let (here, size) = (at(position), order * order);
                let (mut wrong, mut total) = (0f64, 0f64);
                for (axis, local) in [Vec3A::X, Vec3A::Y].into_iter().enumerate() {
                    let step = frame.to_world(local) * 0.02;
                    let (after, before) = (at(position + step), at(position - step));
                    for i in 0..3 * size {
                        let exact = f64::from(after[i] - before[i]) / 0.04;
                        wrong += (f64::from(here[3 * size * (axis + 1) + i]) - exact).powi(2);
                        total += exact * exact;
                    }
                }
                let error = (wrong / total).sqrt();
                println!("{basis:?} {gradients:?}, order {order}: {:.2} % off", 100.0 * error);
                assert!(error < 0.02, "{basis:?} {gradients:?} {order}: {error}");
            }
        }
    }

    /// Constant light has no gradient whatever stands about, and what is black nothing at all.
    #[test]
    fn constant_light_has_no_gradient() {
        let frame = Frame::from_normal(Vec3A::Z);
        let light = |_: Vec3A, d: Vec3A| Incident {
            radiance: Rgb::ONE,
            distance: if d.x > 0.0 { 0.3 } else { 5.0 },
            normal: -Vec3A::X,
        };
        for (basis, gradients) in ALL {
            let projector = Projector { basis, order: 8, gradients };
            let numbers = projector.project(&gather(Vec3A::ZERO, &frame, light), &frame, 0.1);
            assert!(numbers[192..].iter().all(|x| x.abs() < 1e-3), "{basis:?} {gradients:?}");
        }
    }
}
