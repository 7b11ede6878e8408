//! From a model to the tables of all its members: a [`Family`].

mod check;
mod plan;
mod rules;
mod zonal;

use crate::check::{Sampling, random_caps};
use crate::error::Directions;
use crate::fit::oracle;
use brdf_tables::axis::Axes;
use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::{Fresnel, Microfacet, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::family::{Family, FamilyHeader, Kin, Measured, Store};
use brdf_tables::material::Material;
use brdf_tables::mean::MeanBrdf;
use brdf_tables::table::{CellInfo, Table};
pub use check::{FamilyCheck, check};
pub use plan::{Plan, random_member};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// How to fit a family.
pub struct Options<'a> {
    /// Tolerance on rmse_lobe, a fraction.
    pub tolerance: f64,
    /// Seed of the members and caps at which errors are measured.
    pub seed: u64,
    /// Command line to record.
    pub command: String,
    /// Told the fraction done, from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// Random members, and caps of each kind, whose errors the promise rests on.
const MEASURED: usize = 600;

/// Fits a family. The bytes of the result depend on the arguments only, not on the number of threads.
pub fn fit(plan: &Plan, options: &Options) -> Family {
    let Plan { kin, lattice, error_axes, .. } = plan;
    let (store, notes) = match kin {
        Kin::Phong => zonal::fit(plan),
        _ => rules::fit(plan, options),
    };
    let mut header = FamilyHeader {
        kin: *kin,
        lattice: lattice.clone(),
        creator: concat!("fitter ", env!("CARGO_PKG_VERSION")).into(),
        command: options.command.clone(),
        seed: options.seed,
        tolerance: options.tolerance,
        promise: [options.tolerance, 2.5 * options.tolerance, 5.0 * options.tolerance],
        notes,
        at_nodes: Summary::default(),
        off_nodes: Summary::default(),
        clipped: Summary::default(),
    };
    let nothing = vec![Measured::default(); lattice.cells() * error_axes.len()];
    let assemble = |header: &FamilyHeader, measured, store: Store| {
        Family::new(header.clone(), *error_axes, measured, store).expect("a plan that fits the model")
    };
    let unmeasured = assemble(&header, nothing, store);
    let (measured, at_nodes) = measure_cells(&unmeasured, *error_axes);
    header.at_nodes = Summary::new(&at_nodes);
    (options.progress)(0.95);
    let off = |sampling, salt: u64| off_nodes(&unmeasured, sampling, MEASURED, options.seed ^ salt << 32, None);
    (header.off_nodes, header.clipped) = (off(Sampling::Main, 1), off(Sampling::Clipped, 2));
    let found = [header.off_nodes.median, header.off_nodes.p95, header.off_nodes.worst];
    for (promise, found) in header.promise.iter_mut().zip(found) {
        // What was not reached is promised as measured, with room for the spread between samples.
        if f64::from(found.rmse_lobe) > *promise {
            header.notes.push(format!("{promise} not reached: promises what was measured instead"));
        }
        *promise = promise.max(1.5 * f64::from(found.rmse_lobe));
    }
    (options.progress)(1.0);
    let (.., store) = unmeasured.parts();
    assemble(&header, measured, store.clone())
}

/// Errors at `points` random caps of as many random members, against the finest rule: quicker than [`check`] by far, and less
/// independent. With `fresnel` the members of a family of facets have that reflectance.
pub fn off_nodes(family: &Family, sampling: Sampling, points: usize, seed: u64, fresnel: Option<Fresnel>) -> Summary {
    let FamilyHeader { kin, lattice, .. } = &family.header;
    let of = |i: u64| {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ i);
        let specular = match (random_member(*kin, lattice, &mut rng), fresnel) {
            (Specular::Microfacet(facets), Some(fresnel)) => Specular::Microfacet(Microfacet { fresnel, ..facets }),
            (specular, _) => specular,
        };
        measure(&member(family, specular), &random_caps(&specular, sampling, 1, &mut rng)[0]).0
    };
    Summary::new(&(0..points as u64).into_par_iter().map(of).collect::<Vec<_>>())
}

/// The table of a member that is within range.
fn member(family: &Family, specular: Specular) -> Table {
    family.for_model(&Material::specular(specular)).expect("a member within range")
}

/// What is found at the nodes of the error grid of each cell, the larger of its corners, and the errors of the main domain.
fn measure_cells(family: &Family, axes: Axes) -> (Vec<Measured>, Vec<Errors>) {
    let (kin, lattice) = (family.header.kin, &family.header.lattice);
    let measured: Vec<(Measured, Vec<Errors>)> = (0..lattice.cells() * axes.len())
        .into_par_iter()
        .map(|i| {
            let (cell, node) = (i / axes.len(), i % axes.len());
            let (mut all, mut main) = (Measured::default(), Vec::new());
            for specular in plan::inside(kin, lattice, cell) {
                let table = member(family, specular);
                let (o, rest) = (node % axes.omega as usize, node / axes.omega as usize);
                let cap = table.axes.cap_at(rest / axes.phi as usize, rest % axes.phi as usize, o);
                let (errors, support) = measure(&table, &cap);
                all = all.or(Measured::new(&CellInfo { errors, support: support as f32 }));
                if cap.half_angle() <= 2.5 * specular.lobe_width() && cap.theta() <= 84f64.to_radians() {
                    main.push(errors);
                }
            }
            (all, main)
        })
        .collect();
    let main = measured.iter().flat_map(|m| m.1.iter().copied()).collect();
    (measured.into_iter().map(|m| m.0).collect(), main)
}

/// Errors and support angle of a table for one cap.
fn measure(table: &Table, cap: &Cap) -> (Errors, f64) {
    let (specular, mean) = (table.specular().expect("a member"), table.mean().expect("a member"));
    let directions = Directions::new(specular, cap);
    let exact = values(&oracle(*specular), cap, &directions);
    let errors = directions.errors(&exact, &values(mean, cap, &directions));
    (errors, directions.support(cap, &exact))
}

/// Values of F over the directions, by the look-up that renderers use: ten times as fast as the readable one.
fn values(mean: &dyn MeanBrdf, cap: &Cap, directions: &Directions) -> Vec<f64> {
    let (caps, mut value) = ([*cap].iter().collect::<CapBatch>(), [0.0]);
    let of = |wo: &glam::DVec3| {
        mean.values(&caps, wo.as_vec3(), &mut value);
        f64::from(value[0])
    };
    directions.wo.iter().map(of).collect()
}
