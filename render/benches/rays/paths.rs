//! Whole paths from the camera: rays, surfaces, lights and scattering together.

use crate::subjects::{names, subject};
use divan::{Bencher, counter::ItemsCount};
use render::integrator::{Integrator, PathTracer, Start};
use render::sampler::Sampler;
use render::scene::Rgb;
use render::world::{Queries, World};

/// Paths that are handed over together.
const BATCH: usize = 1024;

fn starts(name: &str) -> (&'static World, PathTracer, Vec<Start>) {
    let subject = subject(name);
    let start = |(i, ray): (usize, &_)| Start { ray: *ray, sampler: Sampler::new(0, (i as u32, 0), 0) };
    let tracer = PathTracer { settings: subject.world.scene.integrator, indirect_only: false };
    (&subject.world, tracer, subject.camera.iter().enumerate().map(start).collect())
}

/// Paths, one after the other.
#[divan::bench(args = names())]
fn path(bencher: Bencher, name: &str) {
    let (world, tracer, starts) = starts(name);
    let mut queries = Queries::default();
    bencher.counter(ItemsCount::new(starts.len())).bench_local(|| {
        let one = |start: &Start| tracer.radiance(world, start.ray, &mut start.sampler.clone(), &mut queries).sum();
        starts.iter().map(one).sum::<Rgb>()
    });
}

/// The same paths, sixteen at a time.
#[divan::bench(args = names())]
fn path_in_lanes(bencher: Bencher, name: &str) {
    let (world, tracer, starts) = starts(name);
    let (mut queries, mut out) = (Queries::default(), Vec::new());
    bencher.counter(ItemsCount::new(starts.len())).bench_local(|| {
        let mut sum = Rgb::ZERO;
        for starts in starts.chunks(BATCH) {
            tracer.radiances(world, starts, &mut queries, &mut out);
            sum += out.iter().map(|r| r.sum()).sum::<Rgb>();
        }
        sum
    });
}
