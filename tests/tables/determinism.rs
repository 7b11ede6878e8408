//! Same seed, same bytes, whatever the number of threads.

use super::{fitted_with, microfacet, phong};
use brdf_tables::brdf::Distribution;
use fitter::fit::Choice;
use fitter::solver::SolverKind;

#[test]
fn bytes_do_not_depend_on_threads() {
    let cases = [
        (phong(20.0), Choice::Zonal, None),
        (microfacet(Distribution::Beckmann, 0.3, 0.3), Choice::Cubature, None),
        (phong(10.0), Choice::Lobes, Some(1)),
    ];
    for (specular, choice, lobes) in cases {
        let bytes = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| fitted_with(specular, choice, SolverKind::LevenbergMarquardt, lobes).to_bytes().unwrap())
        };
        let one = bytes(1);
        for threads in [2, 7] {
            assert!(bytes(threads) == one, "{choice} of {specular:?} differs between 1 and {threads} threads");
        }
    }
}
