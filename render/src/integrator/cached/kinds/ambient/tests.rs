//! A kind is all there once it stands in the list: it fills, draws, is written, read and counted.

use super::{Ambient, GlossyKind};
use crate::cache::Spacing;
use crate::integrator::PathTracer;
use crate::integrator::cached::file::{load, save};
use crate::integrator::cached::kinds::KINDS;
use crate::integrator::cached::policy::{Allowed, Policy};
use crate::integrator::cached::{Interpolation, Settings, render_cached};
use crate::picture::Budget;
use crate::record::eas::Estimator;
use crate::scene::load;
use crate::world::World;
use std::path::Path;

const TAU: f32 = 0.1;

fn world() -> World {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/cornell-glossy.xml");
    let defines = [("width", "32"), ("height", "32")].map(|(n, v)| (n.into(), v.into())).to_vec();
    let (scene, _) = load::load(&scene, &load::Options { defines, ..load::Options::default() }).unwrap();
    World::new(scene).unwrap()
}

#[test]
fn a_kind_of_the_list_renders_and_is_kept() {
    let world = world();
    let policy = Policy::new(&world.scene, Allowed::Ambient, |_| Err("no table is asked for")).unwrap();
    assert!(policy.is_without_tables() && policy.notes.iter().any(|n| n.ends_with("cached with ambient light")));
    let settings = Settings {
        tolerance: Some(TAU),
        estimator: Estimator::Improved,
        // Where they disagree, records of this kind shrink like others.
        spacing: Spacing { adaptive: Some(0.03), ..Spacing::default() },
        sources: None,
        budget: Budget::Samples(8),
        seed: 1,
        indirect_only: true,
        interpolation: Interpolation::Auto,
    };
    let (picture, figures, caches) = render_cached(&world, &policy, &settings, None, &|_| ());
    let records = figures.glossy.ambient.records;
    assert!(records > 20 && figures.all_glossy() == figures.glossy.ambient, "{figures:?}");
    assert_eq!((figures.glossy.eas.records, figures.glossy.harmonics.records), (0, 0));
    let described = KINDS.iter().find(|kind| kind.name == Ambient::NAME).unwrap();
    assert_eq!((described.sentence)(&figures.glossy.ambient), format!("{records} ambient records"));

    // Light from everywhere is no mirror, but about as much as there is.
    let integrator = PathTracer { settings: world.scene.integrator, indirect_only: true };
    let truth = crate::film::render(&world, &integrator, Budget::Samples(64), 7, &|_| ());
    let mean = |p: &crate::picture::Picture| p.image().pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>();
    let ratio = mean(&picture) / mean(&truth);
    assert!((0.8..1.3).contains(&ratio), "{ratio}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ambient.cache");
    save(&path, &world, &policy, &settings, TAU, &caches).unwrap();
    let kept = load(&path, &world, &policy, &settings, TAU).unwrap();
    assert!(kept.complete && kept.caches.glossy.ambient.records().len() == records);
    let (again, ..) = render_cached(&world, &policy, &settings, Some(kept), &|_| ());
    assert!(again.image().pixels == picture.image().pixels);
}
