//! Depth of field: camera rays start all over a lens, and show what the middle of no pixel shows.

use crate::common::{cached, compare, traced, world};
use render::integrator::cached::policy::Allowed;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use render::scene::Lens;

const SMALL: [(&str, &str); 2] = [("width", "48"), ("height", "48")];

/// Every method agrees with path tracing behind a lens that blurs the far and the near parts by several pixels, and shows glossy
/// surfaces in focus by views that are many lobes apart; its bias is that of the same picture without lens.
#[test]
fn every_method_agrees_with_the_path_tracer() {
    let harmonics = HarmonicsSettings::new(Basis::default(), Gradients::default(), 0.03, None);
    // Radius and focus in shares of the distance to the middle of the scene.
    for (scene, radius, focus, bound) in
        [("cornell-glossy.xml", 0.2, 0.8, 0.003), ("floor-n100.xml", 0.2, 0.5, 0.003), ("preview.xml", 0.1, 0.6, 0.01)]
    {
        // Lamps out of focus are mostly noise.
        let mut sharp = world(scene, &SMALL);
        sharp.scene.integrator.hide_emitters = true;
        let mut blurred = world(scene, &SMALL);
        blurred.scene.integrator.hide_emitters = true;
        let (low, high) = sharp.bounds();
        let distance = sharp.scene.camera.to_world.translation.distance(0.5 * (low + high));
        blurred.scene.camera.lens = Lens::new(radius * distance, focus * distance);
        let references = [traced(&sharp, 256), traced(&blurred, 512)];
        let blur = compare(&references[0], &references[1]).0;
        for (name, allowed) in [
            ("irradiance", Allowed::Irradiance),
            ("eas", Allowed::Eas),
            ("auto", Allowed::Auto),
            ("sh", Allowed::Harmonics(harmonics)),
        ] {
            let (without, _) = cached(&sharp, allowed, 0.03, 32);
            let (picture, figures) = cached(&blurred, allowed, 0.03, 64);
            let (usual, usual_bias) = compare(&without, &references[0]);
            let (error, bias) = compare(&picture, &references[1]);
            println!(
                "{scene} {name}: rel_mse {error:.5} (sharp {usual:.5}, lens or not {blur:.3}), bias {:+.2} % (sharp {:+.2} %), \
                 {} records",
                100.0 * bias,
                100.0 * usual_bias,
                figures.records(),
            );
            assert!(error < 0.2 * blur, "{scene} {name}: {error} where the lens makes {blur}");
            assert!(error < bound && (bias - usual_bias).abs() < 0.015, "{scene} {name}: {error} {bias} {usual_bias}");
        }
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
