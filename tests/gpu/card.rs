//! Records summed on a graphics card, or on what stands in for one, against the processor.

use super::present;
use brdf_tables::family;
use render::gpu::{self, Device, GpuError};
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Caches, Interpolation, Rendering, Settings};
use render::picture::{Budget, Picture};
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings, MAX_ORDER};
use render::scene::load;
use render::world::World;
use std::path::Path;
use std::time::Instant;

const TOLERANCE: f32 = 0.1;

/// A scene of this project, small.
fn world(scene: &str) -> World {
    let defines = [("width", "61"), ("height", "45")].map(|(n, v)| (n.into(), v.into())).to_vec();
    let options = load::Options { defines, ..load::Options::default() };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    World::new(load::load(&path, &options).expect("the project's scenes load").0).expect("they are valid")
}

/// Harmonic records of this kind.
fn harmonics(basis: Basis, gradients: Gradients, order: Option<usize>) -> Allowed {
    Allowed::Harmonics(HarmonicsSettings::new(basis, gradients, TOLERANCE, order))
}

/// Pictures from the same records by each of these, and the records.
fn pictures<const N: usize>(world: &World, allowed: Allowed, by: [Interpolation; N]) -> ([Picture; N], Caches) {
    let policy = Policy::new(&world.scene, allowed, |recipe| family::table(recipe).ok_or(recipe.recipe_text()));
    let policy = policy.expect("every lobe is of a family");
    let settings = Settings {
        tolerance: Some(TOLERANCE),
        estimator: Estimator::Improved,
        spacing: Default::default(),
        sources: None,
        budget: Budget::Samples(4),
        seed: 1,
        indirect_only: false,
        interpolation: Interpolation::Octree,
    };
    let caches = Rendering::new(world, &policy, &settings).fill(world, TOLERANCE, None, None, &|_| ());
    let drawn = by.map(|interpolation| {
        let rendering = Rendering::new(world, &policy, &Settings { interpolation, ..settings });
        let (picture, told) = rendering.shade(world, TOLERANCE, &caches, (settings.budget, 5), Instant::now(), &|_| ());
        assert!(!told.card_failed, "the card failed");
        picture
    });
    (drawn, caches)
}

/// Boxes, floors, walls, objects under a sky, metals, plastics, mirrors, by each kind of record: within 10⁻⁴ of the mean of the picture, the same bytes
/// every time.
#[test]
fn pictures_are_those_of_the_processor() {
    let Some(device) = present(gpu::shared()) else { return };
    println!("{}", device.name());
    let mut all = 0;
    for (scene, allowed) in [
        ("cornell-glossy.xml", Allowed::Eas),
        ("cornell-diffuse.xml", Allowed::Irradiance),
        ("floor-n100.xml", Allowed::Eas),
        ("materials.xml", Allowed::Auto),
        ("anisotropic-sphere.xml", Allowed::Auto),
        ("glossy-wall.xml", Allowed::Eas),
        ("cornell-glossy.xml", harmonics(Basis::Hemispherical, Gradients::Analytic, None)),
        ("cornell-glossy.xml", harmonics(Basis::Spherical, Gradients::Analytic, None)),
        ("floor-n20.xml", harmonics(Basis::Hemispherical, Gradients::None, None)),
        ("floor-n5.xml", harmonics(Basis::Hemispherical, Gradients::Analytic, Some(MAX_ORDER))),
        ("materials.xml", harmonics(Basis::Hemispherical, Gradients::Analytic, None)),
        ("anisotropic-sphere.xml", harmonics(Basis::Hemispherical, Gradients::Analytic, Some(10))),
        ("anisotropic-sphere.xml", harmonics(Basis::Spherical, Gradients::Numerical, Some(7))),
    ] {
        let world = world(scene);
        let by = [Interpolation::Splat, Interpolation::Gpu, Interpolation::Gpu];
        let ([processor, card, again], caches) = pictures(&world, allowed, by);
        let records = caches.records();
        if let Allowed::Harmonics(_) = allowed {
            assert!(!caches.glossy.harmonics.records().is_empty(), "{scene}: no harmonics");
        }
        let [a, b, c] = [processor, card, again].map(|picture| picture.image().pixels);
        assert!(b == c, "{scene}: another picture the second time");
        let mean = a.iter().flatten().map(|x| f64::from(*x)).sum::<f64>() / (3 * a.len()) as f64;
        let difference =
            |(p, q): (&[f32; 3], &[f32; 3])| (0..3).map(|i| f64::from((p[i] - q[i]).abs())).fold(0.0, f64::max);
        let off: Vec<f64> = a.iter().zip(&b).map(|(p, q)| difference((p, q)) / mean).collect();
        let (worst, root) = (
            off.iter().copied().fold(0.0, f64::max),
            (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt(),
        );
        println!("{scene}, {allowed:?}: {records} records, off by {root:.1e} of the mean, worst pixel {worst:.1e}");
        assert!(records > 20 && root < 1e-4, "{scene}");
        all += records;
    }
    assert!(all > 500, "{all} records in all");
}

/// What a card cannot do is an error of what is read next, not the end of the program.
#[test]
fn what_a_card_cannot_do_is_an_error() {
    let Some(device) = present(Device::open()) else { return };
    let program = device.program(
        "@group(0) @binding(0) var<storage, read_write> out: array<u32>;
        @compute @workgroup_size(1) fn main() { out[0] = 7u; }",
    );
    let out = device.room("numbers", 4).expect("there is room for a number");
    device.run(&program, &[&out], [1, 1, 1]);
    assert_eq!(device.read::<u32>(&out), Ok(vec![7]));
    device.run(&program, &[&out], [u32::MAX, 1, 1]);
    assert!(matches!(device.read::<u32>(&out), Err(GpuError::Lost { .. })));
}
