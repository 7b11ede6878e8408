//! What happens where a ray ends.

use crate::subjects::{names, subject};
use divan::{Bencher, counter::ItemsCount};
use glam::{Affine2, Mat3A, Vec2, Vec3A};
use render::light::LightSampleContext;
use render::sampler::{Sampler, Scrambles};
use render::scene::{
    Bitmap, ColorTexture, Distribution, EnvironmentMap, FloatTexture, Interpolation, Material, MaterialId, Rgb, Rows,
    Scene, Texels, Wrap,
};
use render::world::{Interaction, World};

/// The surfaces that the scene's camera rays meet.
fn surfaces(name: &str) -> (&'static World, Vec<Interaction>) {
    let subject = subject(name);
    let world = &subject.world;
    let meet = |ray| Some(world.intersect(ray)).filter(|h| h.exists()).map(|hit| world.interaction(ray, &hit));
    (world, subject.camera.iter().filter_map(meet).collect())
}

/// The surface of a hit: corners, normals, coordinates.
#[divan::bench(args = names())]
fn interaction(bencher: Bencher, name: &str) {
    let subject = subject(name);
    let world = &subject.world;
    let hits: Vec<_> =
        subject.camera.iter().map(|ray| (ray, world.intersect(ray))).filter(|(_, hit)| hit.exists()).collect();
    bencher
        .counter(ItemsCount::new(hits.len()))
        .bench_local(|| hits.iter().map(|(ray, hit)| world.interaction(ray, hit).shading_normal).sum::<Vec3A>());
}

/// The scattering of a surface, textures looked up, evaluated once and sampled once.
#[divan::bench(args = names())]
fn vertex(bencher: Bencher, name: &str) {
    let (world, surfaces) = surfaces(name);
    run_vertices(bencher, world, &surfaces);
}

fn run_vertices(bencher: Bencher, world: &World, surfaces: &[Interaction]) {
    let mut scrambles = Scrambles::default();
    bencher.counter(ItemsCount::new(surfaces.len())).bench_local(|| {
        let mut sum = Rgb::ZERO;
        for (i, at) in surfaces.iter().enumerate() {
            let [choice, _, u, v] = Sampler::new(0, (0, 0), i as u32).next_4x2d(&mut scrambles);
            let bsdf = world.bsdf(at);
            let wi = bsdf.frame().to_world(render::frame::cosine_hemisphere(v));
            sum += bsdf.eval(wi).f.sum();
            sum += bsdf.sample(choice.x, u).map_or(Rgb::ZERO, |s| s.weight.sum());
        }
        sum
    });
}

fn grey(x: f32) -> ColorTexture {
    ColorTexture::Constant(Rgb::splat(x))
}

fn materials() -> Vec<(&'static str, Material)> {
    let f = FloatTexture::Constant;
    vec![
        ("diffuse", Material::Diffuse { reflectance: grey(0.5) }),
        ("phong", Material::Phong { diffuse: grey(0.4), specular: grey(0.4), exponent: f(50.0) }),
        (
            "roughconductor",
            Material::RoughConductor {
                distribution: Distribution::Ggx,
                alpha_u: f(0.2),
                alpha_v: f(0.2),
                eta: grey(0.9),
                k: grey(4.0),
                specular: grey(1.0),
            },
        ),
        (
            "roughdielectric",
            Material::RoughDielectric {
                distribution: Distribution::Ggx,
                alpha_u: f(0.2),
                alpha_v: f(0.2),
                eta: 1.5,
                reflectance: grey(1.0),
                transmittance: grey(1.0),
            },
        ),
        (
            "metallic-roughness",
            Material::MetallicRoughness {
                base_color: grey(0.6),
                metallic: f(0.3),
                roughness: f(0.4),
                f0: grey(0.04),
                specular: f(1.0),
                layered: None,
            },
        ),
    ]
}

/// By material: [`vertex`] on the surfaces of the box, all made of one.
#[divan::bench(args = materials().into_iter().map(|m| m.0))]
fn vertex_of(bencher: Bencher, name: &str) {
    let (world, surfaces) = surfaces("box");
    let material = materials().into_iter().find(|m| m.0 == name).expect("of the list").1;
    let scene = Scene { materials: vec![material; world.scene.materials.len()], ..world.scene.clone() };
    let world = World::new(scene).expect("valid");
    let surfaces: Vec<_> = surfaces.iter().map(|at| Interaction { material: MaterialId(0), ..*at }).collect();
    run_vertices(bencher, &world, &surfaces);
}

/// A light and a place on it.
#[divan::bench(args = names())]
fn light(bencher: Bencher, name: &str) {
    let (world, surfaces) = surfaces(name);
    let mut scrambles = Scrambles::default();
    bencher.counter(ItemsCount::new(surfaces.len())).bench_local(|| {
        let mut sum = 0.0;
        for (i, at) in surfaces.iter().enumerate() {
            let [choice, u, ..] = Sampler::new(0, (0, 0), i as u32).next_4x2d(&mut scrambles);
            let receiver = LightSampleContext { p: at.p, normal: at.shading_normal, one_sided: true };
            sum += world.lights.sample(&world.scene.textures, &receiver, choice.x, u).map_or(0.0, |s| s.pdf);
        }
        sum
    });
}

/// Pixels across and down of the sky and the texture.
const SIZE: [usize; 2] = [2048, 1024];

fn bitmap() -> Bitmap {
    let texel = |i: usize| 0.1 + (i % 251) as f32;
    Bitmap {
        width: SIZE[0] as u32,
        height: SIZE[1] as u32,
        texels: Texels::Gray((0..SIZE[0] * SIZE[1]).map(texel).collect()),
        wrap: [Wrap::Repeat; 2],
        second_uv: false,
        interpolation: Interpolation::Bilinear,
        to_uv: Affine2::IDENTITY,
    }
}

/// Places all over the unit square.
fn places() -> Vec<Vec2> {
    (0..1 << 16).map(|i| Sampler::new(0, (0, 0), i).next_2d()).collect()
}

fn under_a_sky() -> World {
    let map = EnvironmentMap { image: bitmap(), to_world: Mat3A::IDENTITY, scale: 1.0, rows: Rows::Bands };
    let mut scene = subject("box").world.scene.clone();
    scene.environment = Some(render::scene::Environment::Map(map));
    World::new(scene).expect("valid")
}

/// A direction to the sky.
#[divan::bench]
fn sky_sample(bencher: Bencher) {
    let (world, places) = (under_a_sky(), places());
    let receiver = LightSampleContext { p: Vec3A::ZERO, normal: Vec3A::Y, one_sided: true };
    let sample = |u: &Vec2| world.lights.sample(&world.scene.textures, &receiver, 0.1, *u).map_or(0.0, |s| s.pdf);
    bencher.counter(ItemsCount::new(places.len())).bench_local(|| places.iter().map(sample).sum::<f32>());
}

/// Radiance and density of a direction to the sky.
#[divan::bench]
fn sky_look_up(bencher: Bencher) {
    let world = under_a_sky();
    let directions: Vec<_> = places().into_iter().map(render::frame::uniform_sphere).collect();
    let receiver = LightSampleContext { p: Vec3A::ZERO, normal: Vec3A::Y, one_sided: true };
    let look_up = |d: &Vec3A| world.lights.environment_with_pdf(&receiver, *d).1;
    bencher.counter(ItemsCount::new(directions.len())).bench_local(|| directions.iter().map(look_up).sum::<f32>());
}
