//! Whole pictures against the path tracer.

use crate::common::{cached, compare, drawn, table, traced, world};
use brdf_tables::brdf::{Distribution, Fresnel, Microfacet, Specular};
use render::cache::Spacing;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Settings, render_cached};
use render::picture::Budget;
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use render::scene::{ColorTexture, Environment, Material, Rgb};
use render::world::World;

const SMALL: [(&str, &str); 2] = [("width", "64"), ("height", "64")];

/// Boxes, floor, object under a sky, four materials: small error, small bias.
#[test]
fn pictures_agree_with_the_path_tracer() {
    for (scene, bound) in [
        ("cornell-glossy.xml", 0.006),
        ("cornell-diffuse.xml", 0.006),
        ("floor-n100.xml", 0.006),
        ("preview.xml", 0.02),
        ("materials.xml", 0.02),
        ("anisotropic-sphere.xml", 0.02),
    ] {
        let world = world(scene, &SMALL);
        let (picture, figures) = cached(&world, Allowed::Auto, 0.03, 32);
        let (error, bias) = compare(&picture, &traced(&world, 256));
        println!("{scene}: rel_mse {error:.4}, bias {:.2} %, {} EAS records", 100.0 * bias, figures.glossy.eas.records);
        assert!(error < bound && bias.abs() < 0.02, "{scene}: {error} {bias}");
    }
}

/// Paths without end, which Mitsuba's files have where they say nothing, under a sky.
#[test]
fn paths_may_be_without_end() {
    let mut scene = world("preview.xml", &SMALL).scene;
    scene.environment = Some(Environment::Constant(Rgb::new(0.5, 0.7, 1.0)));
    scene.integrator.max_depth = u32::MAX;
    let world = World::new(scene).expect("the scene is valid");
    let reference = traced(&world, 256);
    for allowed in [Allowed::Irradiance, Allowed::Eas] {
        let (error, bias) = compare(&cached(&world, allowed, 0.03, 32).0, &reference);
        println!("{allowed:?}: rel_mse {error:.4}, bias {:.2} %", 100.0 * bias);
        assert!(error < 0.01 && bias.abs() < 0.02, "{allowed:?}: {error} {bias}");
    }
}

/// Models whose reflectance is Schlick's, of a colour: every method shows that colour, at normal incidence and at the rim.
#[test]
fn facets_have_the_colour_of_their_reflectance() {
    let harmonics = HarmonicsSettings::new(Basis::Hemispherical, Gradients::default(), 0.05, None);
    for (distribution, alpha, f0) in
        [(Distribution::Ggx, 0.15, [0.9, 0.6, 0.2]), (Distribution::Beckmann, 0.2, [0.05, 0.1, 0.3])]
    {
        let mut scene = world("preview.xml", &SMALL).scene;
        let specular = Specular::Microfacet(Microfacet {
            distribution,
            alpha_x: alpha,
            alpha_y: alpha,
            fresnel: Fresnel::Schlick { f0 },
        });
        let gray = |x| ColorTexture::Constant(Rgb::splat(x));
        let lobe = Material::Lobe { diffuse: gray(0.02), specular: gray(0.9), model: specular };
        let glossy = scene.materials.iter_mut().filter(|m| matches!(m, Material::Phong { .. }));
        assert!(glossy.map(|material| *material = lobe.clone()).count() > 0);
        let world = World::new(scene).expect("the scene is valid");
        let reference = traced(&world, 256);
        for allowed in [Allowed::Eas, Allowed::Harmonics(harmonics)] {
            let (_, picture, figures, _) = drawn(&world, allowed);
            let (error, bias) = compare(&picture, &reference);
            println!("{distribution:?} {allowed:?}: rel_mse {error:.4}, bias {:.2} %", 100.0 * bias);
            let records = figures.glossy.eas.records + figures.glossy.harmonics.records;
            assert!(records > 0 && error < 0.02 && bias.abs() < 0.02, "{distribution:?} {allowed:?}: {error} {bias}");
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let world = world("cornell-glossy.xml", &[("width", "40"), ("height", "40")]);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| cached(&world, Allowed::Auto, 0.1, 4)).0.image().pixels
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7) && one == with(64));
}

/// A scene that is a thousand times smaller or larger gives the same picture but for rounding.
#[test]
fn the_size_of_the_scene_does_not_matter() {
    let at = |scene: &str| cached(&world(scene, &[("width", "40"), ("height", "40")]), Allowed::Auto, 0.1, 8).0;
    let box_ = at("cornell-glossy.xml");
    for scene in ["failure/scaled-down.xml", "failure/scaled-up.xml", "failure/moved.xml"] {
        let (error, bias) = compare(&at(scene), &box_);
        println!("{scene}: rel_mse {error:.5}, bias {:.2} %", 100.0 * bias);
        assert!(error < 3e-3 && bias.abs() < 1e-2, "{scene}: {error} {bias}");
    }
}

/// The published estimator works end to end.
#[test]
fn the_papers_estimator_draws_the_box() {
    let world = world("cornell-glossy.xml", &[("width", "32"), ("height", "32")]);
    let policy = Policy::new(&world.scene, Allowed::Eas, |r| Ok::<_, ()>(table(r))).expect("tables fit");
    let settings = Settings {
        tolerance: Some(0.1),
        estimator: Estimator::Paper,
        spacing: Spacing::DISTANCE,
        sources: None,
        budget: Budget::Samples(16),
        seed: 1,
        indirect_only: false,
        interpolation: Interpolation::Auto,
    };
    let (picture, figures, _) = render_cached(&world, &policy, &settings, None, &|_| ());
    let (error, bias) = compare(&picture, &traced(&world, 256));
    println!("paper: rel_mse {error:.4}, bias {:.2} %, {} EAS records", 100.0 * bias, figures.glossy.eas.records);
    assert!(error < 0.05 && bias.abs() < 0.05, "{error} {bias}");
}

/// Materials too sharp to cache are traced, and the policy says so.
#[test]
fn sharp_materials_are_traced() {
    let mut world = world("floor.xml", &[("n", "5000"), ("width", "16"), ("height", "16")]);
    let policy = |allowed, world: &render::world::World| {
        Policy::new(&world.scene, allowed, |r| Ok::<_, ()>(table(r))).expect("tables fit")
    };
    assert!(policy(Allowed::Auto, &world).notes.iter().any(|n| n.contains("too sharp")));
    let (_, figures) = cached(&world, Allowed::Auto, 0.2, 2);
    assert_eq!(figures.glossy.eas.records, 0);
    world = crate::common::world("floor.xml", &[("n", "100"), ("width", "16"), ("height", "16")]);
    assert!(policy(Allowed::Auto, &world).notes.iter().any(|n| n.contains("cached")));
    assert!(policy(Allowed::Irradiance, &world).kinds.eas.lobes.is_empty());
}
