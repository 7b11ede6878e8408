//! The mean BRDF by Monte Carlo (eq. 9), with its standard error.

use brdf_tables::brdf::{Brdf, Specular};
use brdf_tables::cap::Cap;
use glam::{DVec2, DVec3};
use sobol_burley::sample;

/// A Monte Carlo estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean, sr⁻¹.
    pub value: f64,
    /// Standard error of the mean, sr⁻¹.
    pub stderr: f64,
}

/// Independently scrambled sequences whose spread is the standard error.
const REPLICATES: usize = 16;
/// Points a scrambled Sobol sequence has before it must be scrambled anew.
const SEQUENCE: usize = 1 << 16;

/// F(cap; wo) of the specular part in sr⁻¹. See [`mean_brdf_mc_rgb`].
pub fn mean_brdf_mc(specular: &Specular, cap: &Cap, wo: DVec3, samples: usize, seed: u64) -> Estimate {
    let [estimate] = estimate(specular, cap, wo, samples, seed, |_| [1.0]);
    estimate
}

/// Solid angle of a cap over that of the lobe below which uniform points alone are drawn.
const SMALL: f64 = 0.25;

/// F(cap; wo) of the specular part, tinted per channel, in sr⁻¹: Owen-scrambled Sobol points, half of them uniform in the
/// cap and half from the BRDF, combined by the balance heuristic (Veach 1997), over any cap of the domain. At least 32
/// samples are taken. For a cap much smaller than the lobe all are uniform: hardly a sample of the BRDF would meet it, and
/// a share of the mean that no replicate sees is missing from the standard error.
pub fn mean_brdf_mc_rgb(specular: &Specular, cap: &Cap, wo: DVec3, samples: usize, seed: u64) -> [Estimate; 3] {
    estimate(specular, cap, wo, samples, seed, |wi| specular.tint(wi, wo))
}

fn estimate<const N: usize>(
    specular: &Specular,
    cap: &Cap,
    wo: DVec3,
    samples: usize,
    seed: u64,
    tint: impl Fn(DVec3) -> [f64; N],
) -> [Estimate; N] {
    let half = samples.div_ceil(2 * REPLICATES).max(1);
    let area = cap.projected_solid_angle();
    let mixed = cap.solid_angle() * peak_density(specular, wo) > SMALL;
    let half = if mixed { half } else { 2 * half };
    let mut means = [[0.0; N]; REPLICATES];
    for (replicate, mean) in means.iter_mut().enumerate() {
        // f cos over the sum of both densities: the balance heuristic for equally many samples of each kind.
        let mut add = |wi: DVec3| {
            if wi.z > 0.0 && cap.contains(wi) {
                let density = 1.0 / cap.solid_angle() + if mixed { specular.pdf(wi, wo) } else { 0.0 };
                let value = specular.eval(wi, wo) * wi.z / (density * half as f64 * area);
                for (m, t) in mean.iter_mut().zip(tint(wi)) {
                    *m += value * t;
                }
            }
        };
        for i in 0..half {
            let block =
                seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add((i / SEQUENCE * REPLICATES + replicate) as u64);
            let scramble = (block ^ block >> 32) as u32;
            let u = |dimension| f64::from(sample((i % SEQUENCE) as u32, dimension, scramble));
            add(cap.sample(DVec2::new(u(0), u(1))));
            if mixed && let Some(wi) = specular.sample(wo, DVec2::new(u(2), u(3))) {
                add(wi);
            }
        }
    }
    core::array::from_fn(|c| {
        let value = means.iter().map(|m| m[c]).sum::<f64>() / REPLICATES as f64;
        let variance = means.iter().map(|m| (m[c] - value).powi(2)).sum::<f64>() / (REPLICATES - 1) as f64;
        Estimate { value, stderr: (variance / REPLICATES as f64).sqrt() }
    })
}

/// About the largest density of the sampler, sr⁻¹: the reciprocal of the lobe's solid angle.
fn peak_density(specular: &Specular, wo: DVec3) -> f64 {
    let grid = (0..64).map(|i| (DVec2::new((i / 8) as f64, (i % 8) as f64) + 0.5) / 8.0);
    grid.filter_map(|u| specular.sample(wo, u)).map(|wi| specular.pdf(wi, wo)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::brdf::Phong;
    use brdf_tables::frame::{mirror, spherical};

    #[test]
    fn seeds_and_counts() {
        let specular = Specular::Phong(Phong { exponent: 30.0 });
        let cap = Cap::with_half_angle(0.6, 0.3, 0.3).unwrap();
        let wo = mirror(cap.axis());
        let run = |samples, seed| mean_brdf_mc(&specular, &cap, wo, samples, seed);
        assert_eq!(run(1000, 4), run(1000, 4));
        assert_ne!(run(1000, 4), run(1000, 5));
        assert!(run(0, 1).value > 0.0, "at least 32 samples are taken");
        assert!(run(1 << 16, 1).stderr < 0.05 * run(1 << 8, 1).stderr);
        // Sequences longer than one scramble go on with another.
        let long = run(16 * 2 * (SEQUENCE + 9), 1);
        assert!((long.value - run(1 << 16, 2).value).abs() < 5.0 * run(1 << 16, 2).stderr);
        assert_eq!(mean_brdf_mc(&specular, &cap, spherical(2.0, 0.0), 100, 1).value, 0.0);
    }

    #[test]
    fn small_caps_are_told_from_large_ones() {
        let specular = Specular::Phong(Phong { exponent: 98.0 });
        // (n + 1)/2π at the mirror direction.
        let density = peak_density(&specular, spherical(0.3, 0.0));
        assert!((density / (99.0 / core::f64::consts::TAU) - 1.0).abs() < 0.1, "{density}");
    }
}
