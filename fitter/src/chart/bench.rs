//! Error and time of one way to evaluate the mean BRDF, the same caps and directions for all.

use super::Point;
use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::frame::spherical;
use brdf_tables::mean::MeanBrdf;
use brdf_tables::quadrature::mean_brdf;
use fitter::check::{Sampling, random_caps};
use fitter::error::Directions;
use glam::Vec3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// Relative tolerance of the reference, of the peak of F.
const REFERENCE: f64 = 2e-5;
/// Caps of a batch: about what a record of a radiance cache holds.
const BATCH: usize = 256;
/// Caps of a batch for a method that takes longer than [`SLOW`] per evaluation.
const SMALL_BATCH: usize = 8;
/// As [`SMALL_BATCH`], ns.
const SLOW: f64 = 5000.0;
/// Runs per view, of which the median counts; fewer for slow methods.
const RUNS: usize = 15;
/// As [`RUNS`].
const SLOW_RUNS: usize = 5;

/// Caps of the main domain with their exact values, and batches to time.
pub struct Bench {
    caps: Vec<(Cap, Directions, Vec<f64>)>,
    batches: [CapBatch; 2],
    views: [Vec3; 8],
}

impl Bench {
    /// Draws the caps and integrates them.
    pub fn new(specular: &Specular, points: usize, seed: u64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let caps = random_caps(specular, Sampling::Main, points, &mut rng);
        let exact = |cap: Cap| {
            let directions = Directions::new(specular, &cap);
            // The values near the mirror direction tell the scale of the others.
            let peak =
                directions.wo.iter().take(40).map(|&wo| mean_brdf(specular, &cap, wo, 1e-2, 0.0)).fold(0.0, f64::max);
            let values = directions.wo.par_iter().map(|&wo| mean_brdf(specular, &cap, wo, REFERENCE, peak)).collect();
            (cap, directions, values)
        };
        let batch = |count| random_caps(specular, Sampling::Main, count, &mut rng).iter().collect();
        let batches = [BATCH, SMALL_BATCH].map(batch);
        let views = core::array::from_fn(|i| spherical(0.2 * i as f64, 0.8 * i as f64).as_vec3());
        Self { caps: caps.into_par_iter().map(exact).collect(), batches, views }
    }

    /// Measures a method.
    pub fn point(&self, label: impl Into<String>, mean: &dyn MeanBrdf, bytes: Option<usize>) -> Point {
        let errors: Vec<Errors> = self
            .caps
            .par_iter()
            .map(|(cap, directions, exact)| {
                let values: Vec<f64> = directions.wo.par_iter().map(|&wo| mean.value(cap, wo)).collect();
                directions.errors(exact, &values)
            })
            .collect();
        let [large, small] = &self.batches;
        let rough = self.nanoseconds(mean, small, 1);
        let nanoseconds =
            if rough > SLOW { self.nanoseconds(mean, small, SLOW_RUNS) } else { self.nanoseconds(mean, large, RUNS) };
        Point { label: label.into(), nanoseconds, bytes, errors: Summary::new(&errors) }
    }

    /// Time of one evaluation, ns: the median over several runs for each view, and the mean over the views.
    fn nanoseconds(&self, mean: &dyn MeanBrdf, caps: &CapBatch, runs: usize) -> f64 {
        let mut out = vec![0f32; caps.len()];
        let mut run = |wo: Vec3| {
            // Long enough for the clock, short enough to fit between two interruptions.
            let (start, mut passes) = (Instant::now(), 0);
            while passes == 0 || start.elapsed().as_micros() < 200 {
                mean.values(black_box(caps), black_box(wo), &mut out);
                black_box(&mut out);
                passes += 1;
            }
            start.elapsed().as_secs_f64() * 1e9 / (passes * caps.len()) as f64
        };
        let median = |&wo: &Vec3| {
            let mut times: Vec<f64> = (0..runs).map(|_| run(wo)).collect();
            times.sort_by(f64::total_cmp);
            times[runs / 2]
        };
        self.views.iter().map(median).sum::<f64>() / self.views.len() as f64
    }
}
