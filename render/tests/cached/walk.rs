//! The fill of a walk: stopped and gone on with, it makes the same records; what it costs, and what it misses.

use crate::common::{table, world};
use glam::DVec3;
use render::cache::Spacing;
use render::integrator::cached::file::Key;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Caches, Interpolation, Rendering, Settings};
use render::picture::Budget;
use render::record::eas::Estimator;
use render::scene::FovAxis;
use render::walk::{Fill, Row, Walk};
use render::world::World;
use std::cell::Cell;
use std::convert::Infallible;

const TAU: f32 = 0.3;

fn settings() -> Settings {
    Settings {
        tolerance: Some(TAU),
        estimator: Estimator::Improved,
        spacing: Spacing::default(),
        sources: None,
        budget: Budget::Samples(1),
        seed: 3,
        indirect_only: false,
        interpolation: Interpolation::Auto,
    }
}

/// A few steps into the box.
fn walk(world: &World, frames: u32) -> Walk {
    let (look, up, fov, width) = (DVec3::new(2.8, 2.5, 2.0), DVec3::Y, None, None);
    let row = |z: f64| Row { eye: DVec3::new(2.0, 2.7, z), look, up, fov, width };
    let rows = [(0, row(-8.0)), (frames - 1, row(-3.0))].into_iter().collect();
    Walk::through(&rows, &world.scene.camera, FovAxis::X, 1.0).unwrap()
}

fn empty(world: &World) -> Caches {
    let (min, max) = world.bounds();
    Caches::new(min, max)
}

#[test]
fn a_fill_that_was_stopped_goes_on_to_the_same_records() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut world = world("cornell-glossy.xml", &[("width", "24"), ("height", "24")]);
    let policy = Policy::new(&world.scene, Allowed::Auto, |r| Ok::<_, ()>(table(r))).expect("tables fit");
    let settings = settings();
    let rendering = Rendering::new(&world, &policy, &settings);
    let key = Key::new(&world, &policy, &settings, TAU);
    let walk = walk(&world, 40);
    let fill = Fill { rendering: &rendering, walk: &walk, tolerance: TAU, range: [0, 39], deadline: None };
    let start = empty(&world);
    let mut stages = 0;
    let stage = |caches: &Caches| {
        stages += 1;
        key.save(&path(&format!("{stages}")), caches).map_err(|e| panic!("{e}"))
    };
    let Ok(whole): Result<_, Infallible> = fill.run(&mut world, start, stage, &|_| ());
    key.save(&path("whole"), &whole).unwrap();
    assert!(stages >= 2, "{stages}");
    let expected = std::fs::read(path("whole")).unwrap();
    for stage in 1..=stages {
        let kept = key.load(&path(&stage.to_string()), &world).unwrap().caches;
        let frames = Cell::new(0);
        let count = |_| frames.set(frames.get() + 1);
        let Ok(caches): Result<_, Infallible> = fill.run(&mut world, kept, |_| Ok(()), &count);
        assert_eq!(frames.get(), 40 - 4 * stage);
        key.save(&path("again"), &caches).unwrap();
        assert!(std::fs::read(path("again")).unwrap() == expected, "from stage {stage}");
    }
}

/// Looking at a lattice costs few holes: after the fill nearly all pixels of all frames are reached, from hardly more records than
/// one frame has.
#[test]
fn scouting_leaves_few_holes() {
    let mut world = world("cornell-glossy.xml", &[("width", "64"), ("height", "64")]);
    let policy = Policy::new(&world.scene, Allowed::Auto, |r| Ok::<_, ()>(table(r))).expect("tables fit");
    let settings = settings();
    let rendering = Rendering::new(&world, &policy, &settings);
    let walk = walk(&world, 60);
    let fill = |range| Fill { rendering: &rendering, walk: &walk, tolerance: TAU, range, deadline: None };
    let start = empty(&world);
    let Ok(one): Result<_, Infallible> = fill([0, 0]).run(&mut world, start.clone(), |_| Ok(()), &|_| ());
    let Ok(all): Result<_, Infallible> = fill([0, 59]).run(&mut world, start, |_| Ok(()), &|_| ());
    let mut holes_of = |caches: &Caches| {
        let mut holes = Vec::new();
        for frame in walk.frames() {
            world.scene.camera.clone_from(walk.camera(frame).unwrap());
            holes.push(rendering.holes(&world, TAU, caches));
        }
        holes
    };
    let (before, after) = (holes_of(&one), holes_of(&all));
    let mean = |holes: &[f64]| holes.iter().sum::<f64>() / holes.len() as f64;
    let most = after.iter().copied().fold(0.0, f64::max);
    println!(
        "records {} for one frame, {} for 60; holes {:.4} with those of the first, {:.4} with all, {most:.4} at most; rays {} and {}",
        one.records(),
        all.records(),
        mean(&before),
        mean(&after),
        one.counts.rays,
        all.counts.rays
    );
    assert!(after[0] == 0.0 && mean(&after) < 0.005 && most < 0.02);
    assert!(mean(&before) > 4.0 * mean(&after));
    assert!(all.counts.rays < 10 * one.counts.rays);
}
