//! The same paths by all instruction sets, one by one and together.

use super::*;
use crate::camera::RayGenerator;
use crate::integrator::Integrator;
use crate::sampler::Sampler;
use crate::scene::{ColorTexture, Distribution, FloatTexture, Material, Rgb, load};
use fearless_simd::Simd;

const SIZE: u32 = 24;

/// A box whose glossy things are a cosine lobe, metal, and a rough coat.
fn world() -> World {
    let scene = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/cornell-glossy.xml");
    let defines = [("width", "24"), ("height", "24")].map(|(n, v)| (n.into(), v.into())).to_vec();
    let (mut scene, _) = load::load(&scene, &load::Options { defines, ..load::Options::default() }).unwrap();
    let metal = |distribution| Material::RoughConductor {
        distribution,
        alpha_u: FloatTexture::Constant(0.2),
        alpha_v: FloatTexture::Constant(0.4),
        eta: ColorTexture::Constant(Rgb::new(0.2, 0.9, 1.1)),
        k: ColorTexture::Constant(Rgb::new(3.9, 2.4, 2.2)),
        specular: ColorTexture::Constant(Rgb::splat(0.9)),
    };
    let coat = Material::RoughPlastic {
        distribution: Distribution::Beckmann,
        alpha: 0.15,
        eta: 1.5,
        diffuse: ColorTexture::Constant(Rgb::new(0.5, 0.2, 0.1)),
        specular: ColorTexture::Constant(Rgb::ONE),
        nonlinear: true,
    };
    let others = [metal(Distribution::Ggx), coat, metal(Distribution::Beckmann)];
    let phong: Vec<_> =
        (0..scene.materials.len()).filter(|&i| matches!(scene.materials[i], Material::Phong { .. })).collect();
    assert!(phong.len() > 1);
    for (&i, other) in phong[1..].iter().zip(others) {
        scene.materials[i] = other;
    }
    scene.integrator.max_depth = 6;
    World::new(scene).unwrap()
}

fn starts(world: &World) -> Vec<Start> {
    let camera = RayGenerator::new(&world.scene.camera);
    let start = |i: u32| {
        let (x, y) = (i / 8 % SIZE, i / 8 / SIZE);
        let mut sampler = Sampler::new(3, (x, y), i % 8);
        Start { ray: camera.sample(x, y, &mut sampler), sampler }
    };
    (0..8 * SIZE * SIZE).map(start).collect()
}

#[test]
fn every_instruction_set_gives_the_same_bytes() {
    let world = world();
    let (starts, mut queries) = (starts(&world), Queries::default());
    let tracer = PathTracer { settings: world.scene.integrator, indirect_only: false };
    let mut run = |level: Level| {
        let mut out = Vec::new();
        radiances_by(level, &tracer, &world, &starts, &mut queries, &mut out);
        out
    };
    let best = run(Level::new());
    assert!(best.iter().any(|r| r.indirect.glossy.max_element() > 0.0));
    let mut others = vec![Level::baseline()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    others.extend(Level::new().as_avx2().map(Simd::level));
    for other in others {
        assert!(run(other) == best, "{other:?}");
    }
}

#[test]
fn a_path_does_not_depend_on_those_beside_it() {
    let world = world();
    let (starts, mut queries) = (starts(&world), Queries::default());
    let tracer = PathTracer { settings: world.scene.integrator, indirect_only: false };
    let (mut all, mut some) = (Vec::new(), Vec::new());
    tracer.radiances(&world, &starts, &mut queries, &mut all);
    for (range, start) in [(0..1, 0), (100..117, 100), (1000..1040, 1000)] {
        tracer.radiances(&world, &starts[range.clone()], &mut queries, &mut some);
        assert!(some[..] == all[range], "from {start}");
    }
}

/// Against the paths of [`PathTracer::radiance`], one by one: rounding changes the course of one in a thousand at most.
#[test]
fn the_twin_finds_the_same() {
    let world = world();
    let (starts, mut queries) = (starts(&world), Queries::default());
    for indirect_only in [false, true] {
        let tracer = PathTracer { settings: world.scene.integrator, indirect_only };
        let mut out = Vec::new();
        tracer.radiances(&world, &starts, &mut queries, &mut out);
        let (mut others, mut worst) = (0, 0f32);
        for (start, found) in starts.iter().zip(&out) {
            let twin = tracer.radiance(&world, start.ray, &mut start.sampler.clone(), &mut queries);
            let (a, b) = (found.sum(), twin.sum());
            let off = ((a - b).abs() / (b.abs() + 0.01)).max_element();
            if off > 1e-3 {
                others += 1;
            } else {
                worst = worst.max(off);
            }
            assert!((found.distance, found.albedo, found.normal) == (twin.distance, twin.albedo, twin.normal));
        }
        println!("{others} of {} paths differ, the others by up to {worst:.1e}", starts.len());
        assert!(others * 1000 <= starts.len(), "{others}");
    }
}

/// Both loops ask for the same rays, but for light that no normal number can say: narrow Beckmann lobes fade through such numbers,
/// which are nothing in lanes.
#[test]
fn the_twin_traces_as_many_rays() {
    let world = world();
    let (starts, mut together, mut alone) = (starts(&world), Queries::default(), Queries::default());
    let tracer = PathTracer { settings: world.scene.integrator, indirect_only: false };
    tracer.radiances(&world, &starts, &mut together, &mut Vec::new());
    for start in &starts {
        tracer.radiance(&world, start.ray, &mut start.sampler.clone(), &mut alone);
    }
    let (together, alone) = (together.counts.rays as f64, alone.counts.rays as f64);
    assert!((together / alone - 1.0).abs() < 5e-3, "{together} {alone}");
}
