//! How good a table is, measured off its nodes against an integration that shares no code with it.

use crate::error::Directions;
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::mean::MeanBrdf;
use brdf_tables::quadrature::mean_brdf;
use brdf_tables::table::Table;
use core::f64::consts::{FRAC_PI_2, TAU};
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Which caps to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Radius uniform up to 2.5 lobe widths, θe uniform in 0 … 84°, crossing the horizon by at most 0.9 of the radius:
    /// the domain of the promise.
    Main,
    /// Radius uniform up to 2.5 lobe widths, crossing the horizon by 0 … 0.9 of the radius.
    Clipped,
    /// The rest of the domain: θe uniform in 0 … 90°, radius log-uniform in 0.01 … 10 lobe widths, at most 90°.
    Wide,
}

/// Accuracy of the reference, over the peak of F: ten times better than the best promise worth making.
const REFERENCE: f64 = 1e-4;

/// `count` random caps for the lobe width of `specular`.
pub fn random_caps(specular: &Specular, sampling: Sampling, count: usize, rng: &mut impl Rng) -> Vec<Cap> {
    let widest = (2.5 * specular.lobe_width()).min(FRAC_PI_2);
    let mut caps = Vec::with_capacity(count);
    while caps.len() < count {
        let radius = widest * rng.random::<f64>().max(1e-3);
        let phi = TAU * rng.random::<f64>();
        let u = rng.random::<f64>();
        let cap = match sampling {
            Sampling::Main => {
                let theta = u * 84f64.to_radians();
                if theta + 0.1 * radius > FRAC_PI_2 {
                    continue;
                }
                Cap::with_half_angle(theta, phi, radius)
            }
            Sampling::Clipped => Cap::with_half_angle(FRAC_PI_2 - radius * (1.0 - 0.9 * u), phi, radius),
            Sampling::Wide => {
                let widths = 10.0 * 1e-3f64.powf(rng.random());
                Cap::with_half_angle(u * FRAC_PI_2, phi, (widths * specular.lobe_width()).min(FRAC_PI_2))
            }
        };
        caps.extend(cap);
    }
    caps
}

/// The five errors of `mean` for one cap, against deterministic quadrature.
pub fn errors_of(mean: &dyn MeanBrdf, specular: &Specular, cap: &Cap) -> Errors {
    let directions = Directions::new(specular, cap);
    let approximate: Vec<f64> = directions.wo.iter().map(|&wo| mean.value(cap, wo)).collect();
    let scale = approximate.iter().fold(0f64, |m, &f| m.max(f));
    let exact: Vec<f64> = directions.wo.iter().map(|&wo| mean_brdf(specular, cap, wo, REFERENCE, scale)).collect();
    directions.errors(&exact, &approximate)
}

/// What [`check`] found.
#[derive(Clone, Debug)]
pub struct Check {
    /// Errors on the domain of the promise.
    pub main: Summary,
    /// Errors on caps that cross the horizon.
    pub clipped: Summary,
    /// Errors on the rest of the domain.
    pub wide: Summary,
    /// The cap of the main domain with the largest rmse_lobe, if any was drawn.
    pub worst: Option<(Cap, Errors)>,
    /// Promised rmse_lobe: median, 95th percentile, worst.
    pub promise: [f64; 3],
    /// Whether the main domain keeps the promise.
    pub passed: bool,
}

/// Measures a table at `points` random caps of its main domain and a quarter as many of each other kind. A diffuse
/// material has no error by construction.
pub fn check(table: &Table, points: usize, seed: u64, progress: &(dyn Fn(f64) + Sync)) -> Check {
    let promise = table.header.promise;
    let (Some(mean), Some(specular)) = (table.mean(), table.specular()) else {
        let none = Summary::default();
        return Check { main: none, clipped: none, wide: none, worst: None, promise, passed: true };
    };
    let others = points.div_ceil(4);
    let (done, all) = (AtomicUsize::new(0), points + 2 * others);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut run = |sampling, count| -> (Vec<Cap>, Vec<Errors>) {
        let caps = random_caps(specular, sampling, count, &mut rng);
        let errors = caps.par_iter().map(|cap| {
            let errors = errors_of(mean, specular, cap);
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
            errors
        });
        let errors = errors.collect();
        (caps, errors)
    };
    let (caps, errors) = run(Sampling::Main, points);
    let (_, clipped) = run(Sampling::Clipped, others);
    let (_, wide) = run(Sampling::Wide, others);
    let worst = caps.into_iter().zip(errors.iter().copied()).max_by(|a, b| a.1.rmse_lobe.total_cmp(&b.1.rmse_lobe));
    let main = Summary::new(&errors);
    let measured = [main.median, main.p95, main.worst].map(|e| f64::from(e.rmse_lobe));
    let passed = measured.iter().zip(promise).all(|(m, p)| *m <= p);
    Check { main, clipped: Summary::new(&clipped), wide: Summary::new(&wide), worst, promise, passed }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::brdf::Phong;
    use brdf_tables::cubature::{Cubature, Rule};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn drawn_caps_lie_in_their_domain() {
        for exponent in [1.0, 30.0, 1000.0] {
            let specular = Specular::Phong(Phong { exponent });
            let width = specular.lobe_width();
            let caps = |sampling| random_caps(&specular, sampling, 500, &mut Xoshiro256PlusPlus::seed_from_u64(1));
            for cap in caps(Sampling::Main) {
                assert!(cap.half_angle() <= 2.5 * width + 1e-9 && cap.theta() <= 84f64.to_radians() + 1e-9);
                assert!(cap.theta() + 0.1 * cap.half_angle() <= FRAC_PI_2 + 1e-9);
            }
            for cap in caps(Sampling::Clipped) {
                let cut = (cap.theta() + cap.half_angle() - FRAC_PI_2) / cap.half_angle();
                assert!((-1e-6..=0.9 + 1e-6).contains(&cut), "cut by {cut} of the radius");
            }
            assert!(caps(Sampling::Wide).iter().any(|cap| cap.theta() > 1.5));
        }
    }

    /// A rule of one node is told from one of 256 by the five errors.
    #[test]
    fn a_poor_table_is_found_out() {
        let specular = Specular::Phong(Phong { exponent: 50.0 });
        let cap = Cap::with_half_angle(0.7, 0.2, 0.3).unwrap();
        let error = |rule| errors_of(&Cubature::uniform(specular, rule), &specular, &cap).to_array();
        for (poor, good) in error(Rule::Disc(1)).into_iter().zip(error(Rule::Product(16))) {
            assert!(poor > 0.003 && good < 1e-3, "{poor} {good}");
        }
    }
}
