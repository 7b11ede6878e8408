//! Radii by curvature, and radii that shrink where records disagree, beside radii by distance.

use crate::common::{compare, table, traced, world};
use render::cache::{Spacing, WEBER_FRACTION};
use render::film::render;
use render::integrator::PathTracer;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Settings, render_cached};
use render::picture::Budget;
use render::record::eas::Estimator;

#[test]
fn every_spacing_draws_the_scenes() {
    let ways = [
        ("distance", Spacing::DISTANCE),
        ("hessian", Spacing::default()),
        ("adaptive", Spacing { adaptive: Some(5.0 * WEBER_FRACTION), ..Spacing::default() }),
    ];
    for scene in ["cornell-diffuse.xml", "floor-n20.xml"] {
        let world = world(scene, &[("width", "40"), ("height", "40")]);
        let policy = Policy::new(&world.scene, Allowed::Eas, |r| Ok::<_, ()>(table(r))).expect("tables fit");
        let reference = traced(&world, 256);
        let mut counts = Vec::new();
        for (name, spacing) in ways {
            let settings = Settings {
                tolerance: Some(0.1),
                estimator: Estimator::Improved,
                spacing,
                sources: None,
                budget: Budget::Samples(8),
                seed: 1,
                indirect_only: false,
                interpolation: Interpolation::Auto,
            };
            let (picture, figures, _) = render_cached(&world, &policy, &settings, None, &|_| ());
            let (error, bias) = compare(&picture, &reference);
            let records = figures.records();
            println!("{scene}, {name}: {records} records, rel_mse {error:.4}, bias {:.2} %", 100.0 * bias);
            assert!(error < 0.02 && bias.abs() < 0.03, "{scene}, {name}: {error} {bias}");
            counts.push(records);
        }
        // Shrinking makes room for more records.
        assert!(counts[2] > counts[1], "{scene}: {counts:?}");
    }
}

/// Light alone that is scattered twice or more, in which a bias shows that direct light would hide: gradients overshoot a dome
/// of light, and radii by curvature bound by how much.
#[test]
fn curvature_bounds_the_bias_of_gradients() {
    let world = world("cornell-diffuse.xml", &[("width", "64"), ("height", "64")]);
    let policy = Policy::new(&world.scene, Allowed::Irradiance, |r| Ok::<_, ()>(table(r))).expect("tables fit");
    let integrator = PathTracer { settings: world.scene.integrator, indirect_only: true };
    let reference = render(&world, &integrator, Budget::Samples(512), 7, &|_| ());
    let bias = |spacing: Spacing| {
        let settings = Settings {
            tolerance: Some(0.03),
            estimator: Estimator::Improved,
            spacing,
            sources: None,
            budget: Budget::Samples(16),
            seed: 1,
            indirect_only: true,
            interpolation: Interpolation::Auto,
        };
        let (picture, _, _) = render_cached(&world, &policy, &settings, None, &|_| ());
        compare(&picture, &reference).1
    };
    let (distance, hessian) = (bias(Spacing::DISTANCE), bias(Spacing::default()));
    println!("bias of indirect light: {:.2} % by distance, {:.2} % by curvature", 100.0 * distance, 100.0 * hessian);
    assert!(hessian.abs() < 0.02 && hessian.abs() < distance.abs(), "{hessian} {distance}");
}
