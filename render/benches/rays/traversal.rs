//! Rays per second, and how long a tree takes to build.

use crate::subjects::{Purpose, names, subject};
use divan::{Bencher, counter::ItemsCount};
use render::world::{Queries, World};

fn nearest(bencher: Bencher, name: &str, purpose: Purpose) {
    let subject = subject(name);
    let rays = subject.rays(purpose);
    let mut queries = Queries::default();
    bencher
        .counter(ItemsCount::new(rays.len()))
        .bench_local(|| rays.iter().filter(|ray| queries.intersect(&subject.world, ray).exists()).count());
}

#[divan::bench(args = names())]
fn nearest_camera(bencher: Bencher, name: &str) {
    nearest(bencher, name, Purpose::Camera);
}

#[divan::bench(args = names())]
fn nearest_third_bounce(bencher: Bencher, name: &str) {
    nearest(bencher, name, Purpose::ThirdBounce);
}

#[divan::bench(args = names())]
fn any_shadow(bencher: Bencher, name: &str) {
    let subject = subject(name);
    let mut queries = Queries::default();
    bencher
        .counter(ItemsCount::new(subject.shadow.len()))
        .bench_local(|| subject.shadow.iter().filter(|ray| queries.occluded(&subject.world, ray)).count());
}

/// Trees of a whole scene, on all cores.
#[divan::bench(args = names(), max_time = 3)]
fn build(bencher: Bencher, name: &str) {
    let scene = &subject(name).world.scene;
    bencher.with_inputs(|| scene.clone()).bench_local_values(|scene| World::new(scene).expect("valid"));
}
