//! Depth of field: camera rays start all over a lens, and show what the middle of no pixel shows.

use crate::common::{cached, compare, traced, world};
use render::integrator::cached::policy::Allowed;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use render::scene::Lens;

const SMALL: [(&str, &str); 2] = [("width", "48"), ("height", "48")];

/// Every method agrees with path tracing behind a lens that blurs the far and the near parts by several pixels, and the glossy
/// surfaces in focus by views that are many lobes apart.
#[test]
fn every_method_agrees_with_the_path_tracer() {
    let harmonics = HarmonicsSettings::new(Basis::default(), Gradients::default(), 0.03, None);
    for (scene, share, focus, bound) in
        [("cornell-glossy.xml", 0.06, 0.9, 0.01), ("floor-n100.xml", 0.08, 0.8, 0.01), ("preview.xml", 0.06, 1.0, 0.03)]
    {
        let mut world = world(scene, &SMALL);
        let (low, high) = world.bounds();
        let eye = world.scene.camera.to_world.translation;
        // In shares of the distance to the middle of the scene.
        let distance = eye.distance(0.5 * (low + high));
        world.scene.camera.lens = Lens::new(share * distance, focus * distance);
        let reference = traced(&world, 512);
        let sharp = {
            let mut world = crate::common::world(scene, &SMALL);
            world.scene.camera.lens = None;
            traced(&world, 64)
        };
        let blur = compare(&sharp, &reference).0;
        for (name, allowed) in [
            ("irradiance", Allowed::Irradiance),
            ("eas", Allowed::Eas),
            ("auto", Allowed::Auto),
            ("sh", Allowed::Harmonics(harmonics)),
        ] {
            let (picture, figures) = cached(&world, allowed, 0.03, 64);
            let (error, bias) = compare(&picture, &reference);
            println!(
                "{scene} {name}: rel_mse {error:.5} (of the sharp picture {blur:.3}), bias {:+.2} %, {} records, {:.2} s",
                100.0 * bias,
                figures.eas_records + figures.irradiance_records + figures.harmonics_records,
                figures.shade.as_secs_f64()
            );
            assert!(error < bound && bias.abs() < 0.02, "{scene} {name}: {error} {bias}");
        }
        assert!(blur > 3.0 * bound, "{scene}: the lens makes no difference: {blur}");
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let mut world = world("cornell-glossy.xml", &[("width", "32"), ("height", "32")]);
    let (low, high) = world.bounds();
    world.scene.camera.lens = Lens::new(0.03 * low.distance(high), 0.5 * low.distance(high));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| cached(&world, Allowed::Auto, 0.1, 24)).0.image().pixels
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}
