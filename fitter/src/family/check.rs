//! How good a family is, measured at members and caps off its nodes by an integration that shares no code with it.

use super::{member, random_member};
use crate::check::{Sampling, errors_of, random_caps};
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::family::Family;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What [`check`] found.
#[derive(Clone, Debug)]
pub struct FamilyCheck {
    /// Errors on the domain of the promise.
    pub main: Summary,
    /// Errors on caps that cross the horizon.
    pub clipped: Summary,
    /// Errors on the rest of the domain.
    pub wide: Summary,
    /// The member and the cap of the main domain with the largest rmse_lobe.
    pub worst: (Specular, Cap, Errors),
    /// Whether the main domain keeps the promise.
    pub passed: bool,
}

/// Measures a family at `points` random caps of the main domain of as many random members, and at a quarter as many of each
/// other kind.
pub fn check(family: &Family, points: usize, seed: u64, progress: &(dyn Fn(f64) + Sync)) -> FamilyCheck {
    let others = points.div_ceil(4);
    let (done, all) = (AtomicUsize::new(0), points + 2 * others);
    let run = |sampling, count: usize, salt: u64| -> Vec<(Specular, Cap, Errors)> {
        let of = |i: u64| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed.rotate_left(32) ^ salt << 48 ^ i);
            let specular = random_member(family.header.kin, &family.header.lattice, &mut rng);
            let cap = random_caps(&specular, sampling, 1, &mut rng)[0];
            let table = member(family, specular);
            let errors = errors_of(table.mean().expect("a specular member"), &specular, &cap);
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
            (specular, cap, errors)
        };
        (0..count as u64).into_par_iter().map(of).collect()
    };
    let summary = |found: &[(Specular, Cap, Errors)]| Summary::new(&found.iter().map(|f| f.2).collect::<Vec<_>>());
    let found = run(Sampling::Main, points.max(1), 1);
    let (clipped, wide) = (summary(&run(Sampling::Clipped, others, 2)), summary(&run(Sampling::Wide, others, 3)));
    let main = summary(&found);
    let worst = found.into_iter().max_by(|a, b| a.2.rmse_lobe.total_cmp(&b.2.rmse_lobe)).expect("one at least");
    let measured = [main.median, main.p95, main.worst].map(|e| f64::from(e.rmse_lobe));
    let passed = measured.iter().zip(family.header.promise).all(|(m, p)| *m <= p);
    FamilyCheck { main, clipped, wide, worst, passed }
}
