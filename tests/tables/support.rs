//! Outside the support angle of its cell a table says nothing worth adding: less than 2/1000 of the maximum.

use super::{fitted, lit_direction, microfacet, phong, rng, ward};
use brdf_tables::brdf::{Distribution, WardVariant};
use brdf_tables::frame::{basis, mirror, spherical};
use core::f64::consts::{PI, TAU};
use fitter::check::{Sampling, random_caps};
use fitter::fit::Choice;
use rand::RngExt;

#[test]
fn nothing_beyond_the_support() {
    let models =
        [phong(3.0), phong(100.0), microfacet(Distribution::Ggx, 0.1, 0.1), ward(0.1, 0.5, WardVariant::Ward1992)];
    for specular in models {
        let table = fitted(specular, Choice::Auto);
        let mean = table.mean().unwrap();
        let mut rng = rng(12);
        let (mut skipped, mut tried, mut brightest) = (0, 0, 0f64);
        for sampling in [Sampling::Main, Sampling::Clipped] {
            for cap in random_caps(&specular, sampling, 40, &mut rng) {
                let top =
                    (0..200).map(|_| mean.value(&cap, lit_direction(&specular, &cap, &mut rng))).fold(0.0, f64::max);
                let support = table.support(&cap);
                assert!(support > 0.0 && support <= PI);
                for _ in 0..100 {
                    // Half anywhere, half just beyond the edge.
                    let angle =
                        if rng.random() { PI * rng.random::<f64>() } else { support + 0.2 * rng.random::<f64>() };
                    let wo = basis(mirror(cap.axis())) * spherical(angle.min(PI), TAU * rng.random::<f64>());
                    if wo.z <= 1e-3 {
                        continue;
                    }
                    tried += 1;
                    if angle > support {
                        skipped += 1;
                        brightest = brightest.max(mean.value(&cap, wo) / top);
                    }
                }
            }
        }
        eprintln!("{specular:?}: {skipped} of {tried} beyond the support, brightest {brightest:.1e}");
        assert!(brightest < 2e-3, "{specular:?}: {brightest:.1e} of the maximum beyond the support");
        assert!(skipped > tried / 50, "{specular:?}: only {skipped} of {tried} beyond the support");
    }
}
