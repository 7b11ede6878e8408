//! Lamps of every shape, seen in every way, against closed forms; and that no sample of them is lost.

use super::scenes::*;
use crate::lamp_shapes::*;
use core::f32::consts::PI;
use glam::{Affine3A, Quat, Vec3, Vec3A};
use render::integrator::{Integrator, PathTracer, SimplePathTracer};
use render::ray::Ray;
use render::sampler::Sampler;
use render::scene::*;
use render::world::{Queries, World};

/// Mean and standard error of `n` estimates along one ray; every one of them must be a number.
fn estimate(name: &str, world: &World, integrator: &impl Integrator, ray: Ray, n: u32) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    let mut queries = Queries::default();
    for i in 0..n {
        let mut sampler = Sampler::new(7, (i, 0), 0);
        let x = integrator.radiance(world, ray, &mut sampler, &mut queries).finite(&mut queries);
        let x = f64::from(x.sum().y);
        sum += x;
        squares += x * x;
    }
    assert_eq!(queries.counts.not_finite, 0, "{name}");
    let (n, mean) = (f64::from(n), sum / f64::from(n));
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

/// Both path tracers must find `exact` along a ray.
fn check(name: &str, scene: Scene, ray: Ray, exact: f64, n: u32) {
    check_with(name, scene, ray, exact, n, true);
}

/// The path tracer must, and if asked its twin.
fn check_with(name: &str, scene: Scene, ray: Ray, exact: f64, n: u32, twin: bool) {
    let settings = IntegratorSettings { max_depth: 12, ..IntegratorSettings::default() };
    let world = World::new(scene).unwrap();
    let near = |who: &str, (mean, error): (f64, f64)| {
        let allowed = 4.0 * error + 5e-4 * exact.max(1e-3);
        assert!((mean - exact).abs() <= allowed, "{name}, {who}: {mean} ± {error}, exactly {exact}");
    };
    let path = PathTracer { settings, indirect_only: false };
    near("path", estimate(name, &world, &path, ray, n));
    if twin {
        near("twin", estimate(name, &world, &SimplePathTracer { max_depth: 12 }, ray, n));
    }
}

/// Radius of a lamp, and its middle.
const SCALES: [(f32, Vec3A); 5] = [
    (1e-3, Vec3A::ZERO),
    (1.0, Vec3A::ZERO),
    (1e3, Vec3A::ZERO),
    (1.0, Vec3A::new(300.0, -500.0, 200.0)),
    (1e-3, Vec3A::new(0.3, -0.5, 0.2)),
];

/// A convex lamp shows its radiance and nothing else, whatever it is made of: nothing it sends out comes back. From behind,
/// a sheet shows none.
#[test]
fn convex_lamps_show_their_radiance() {
    for (scale, center) in SCALES {
        for (m, material) in [diffuse(0.0), diffuse(0.8), glossy(), mirror()].into_iter().enumerate() {
            for (name, shapes) in convex(0, 3.0, scale, center) {
                for (x, y) in [(0.1, 0.2), (-0.55, 0.5), (0.0, 0.0)] {
                    let scene = |shapes: &[Shape]| Scene {
                        shapes: shapes.to_vec(),
                        materials: vec![material.clone()],
                        ..Scene::default()
                    };
                    let from = |z: f32| center + Vec3A::new(x, y, z) * scale;
                    let name = format!("{name}, material {m}, scale {scale} at {center}, ({x}, {y})");
                    check(&name, scene(&shapes), Ray::new(from(5.0), Vec3A::NEG_Z), 3.0, 500);
                    if name.starts_with("rect") || name.starts_with("disk") {
                        check(&name, scene(&shapes), Ray::new(from(-5.0), Vec3A::Z), 0.0, 100);
                    }
                }
            }
        }
    }
}

/// The same lamps in a mirror, and through a pane, which passes 1 − 2R/(1 + R) with R = ((n − 1)/(n + 1))².
#[test]
fn in_a_mirror_and_through_glass() {
    for (scale, center) in SCALES {
        for (name, lamp) in convex(0, 3.0, scale, center) {
            let at = |z: f32| {
                let z = center + Vec3A::Z * (z * scale);
                Affine3A::from_scale_rotation_translation(Vec3::splat(4.0 * scale), Quat::IDENTITY, z.into())
            };
            let pane = |m| [lamp.clone(), vec![mesh(Mesh::rectangle(at(3.0)), m, None)]].concat();
            let thin = Material::ThinDielectric { eta: 1.5, reflectance: gray(1.0), transmittance: gray(1.0) };
            let solid = Material::Dielectric { eta: 1.5, reflectance: gray(1.0), transmittance: gray(1.0) };
            let materials = vec![diffuse(0.0), mirror(), thin, solid];
            let scene = |shapes| Scene { shapes, materials: materials.clone(), ..Scene::default() };
            let name = format!("{name}, scale {scale} at {center}");
            let from = |z: f32| center + Vec3A::new(0.3, 0.1, z) * scale;
            // The mirror faces up; the lamp below it is seen by a ray that rises first.
            let up = Affine3A::from_rotation_x(PI);
            let facing_down = mesh(Mesh::rectangle(at(3.0) * up), 1, None);
            let through = [lamp.clone(), vec![facing_down]].concat();
            check(&format!("{name}, mirror"), scene(through), Ray::new(from(2.0), Vec3A::Z), 2.4, 100);
            let passed = 3.0 * (1.0 - 2.0 * 0.04 / 1.04);
            check(&format!("{name}, pane"), scene(pane(2)), Ray::new(from(5.0), Vec3A::NEG_Z), passed, 4000);
            // A slab of glass: two faces, which reflect between them.
            let block = Affine3A::from_translation(Vec3::from(center + Vec3A::Z * (3.0 * scale)))
                * Affine3A::from_scale(Vec3::new(4.0, 4.0, 0.5) * scale);
            let slab = [lamp.clone(), vec![mesh(Mesh::cube(block), 3, None)]].concat();
            check(&format!("{name}, slab"), scene(slab), Ray::new(from(5.0), Vec3A::NEG_Z), passed, 4000);
        }
    }
}

/// Inside a closed lamp of albedo ρ the radiance is L/(1 − ρ); a floor of albedo a in a black one shows aL.
#[test]
fn from_inside() {
    for (scale, center) in SCALES {
        let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::IDENTITY, center.into());
        let of = |m: Mesh| mesh(m.flipped(), 0, Some(3.0));
        let cap = |z: f32, turn: f32| {
            let place = Affine3A::from_rotation_translation(Quat::from_rotation_x(turn), Vec3::new(0.0, 0.0, z));
            of(Mesh::disk(to_world * place))
        };
        let lamps = [
            ("sphere", vec![sphere(center, scale, true, 0, Some(3.0))]),
            ("cube", vec![of(Mesh::cube(to_world))]),
            ("cylinder", vec![of(Mesh::cylinder(Vec3::NEG_Z, Vec3::Z, 1.0, to_world)), cap(1.0, 0.0), cap(-1.0, PI)]),
            ("mesh", vec![of(ball(to_world))]),
        ];
        let ray = Ray::new(center + Vec3A::new(0.1, -0.2, 0.3) * scale, Vec3A::new(0.3, 0.5, -0.7).normalize());
        for (name, shapes) in lamps {
            let name = format!("{name}, scale {scale} at {center}");
            for albedo in [0.0, 0.3] {
                let exact: f64 = (0..12).map(|k| 3.0 * f64::from(albedo).powi(k)).sum();
                let materials = vec![diffuse(albedo)];
                let scene = Scene { shapes: shapes.clone(), materials, ..Scene::default() };
                // Light sampling alone has no bounded variance where walls of many pieces meet.
                check_with(&name, scene, ray, exact, 2000, shapes.len() == 1 && !name.starts_with("mesh"));
            }
            let floor = to_world * Affine3A::from_scale(Vec3::splat(0.2));
            let shapes = [shapes, vec![mesh(Mesh::rectangle(floor), 1, None)]].concat();
            let down = Ray::new(center + Vec3A::new(0.01, 0.02, 0.5) * scale, Vec3A::NEG_Z);
            let scene = Scene { shapes, materials: vec![diffuse(0.0), diffuse(0.5)], ..Scene::default() };
            check(&format!("{name}, floor"), scene, down, 1.5, 4000);
        }
    }
}

/// The light on a floor under a ball of radiance L at height h is L r²/(r + h)², from where the ball nearly touches it to
/// where the square has no digits beside 1. The ball is made bright enough for the floor to show 1.
#[test]
fn balls_near_and_far() {
    for radius in [1e-3f32, 1.0, 1e3] {
        for height in [1e-4f32, 1e-2, 1.0, 1e2, 1e4] {
            let sin2 = (1.0 / (1.0 + f64::from(height))).powi(2);
            let ball = Vec3A::Z * (radius * (1.0 + height));
            let floor = mesh(Mesh::rectangle(Affine3A::from_scale(Vec3::splat(4.0 * radius))), 0, None);
            let lamp = sphere(ball, radius, false, 1, Some((2.0 / sin2) as f32));
            // A second lamp without light must change nothing.
            let dark = sphere(Vec3A::new(30.0, 0.0, 5.0) * radius, radius, false, 1, Some(0.0));
            let materials = vec![diffuse(0.5), diffuse(0.0)];
            let scene = Scene { shapes: vec![floor, lamp, dark], materials, ..Scene::default() };
            // The ray comes in below the ball.
            let start = Vec3A::new(-4.0 * radius, 0.0, 2e-5 * radius);
            let ray = Ray::new(start, (Vec3A::new(1e-6 * radius, 0.0, 0.0) - start).normalize());
            let name = format!("radius {radius}, height {height}");
            check(&name, scene, ray, 1.0, 4000);
        }
    }
}

/// What lights without extent do to a surface that holds them, and a lamp to a surface in its own plane: nothing.
#[test]
fn lights_on_the_surface_itself() {
    let floor = mesh(Mesh::rectangle(Affine3A::IDENTITY), 0, None);
    let at = Vec3A::new(0.25, 0.25, 0.0);
    let ray = Ray::new(at + Vec3A::Z, Vec3A::NEG_Z);
    let point = Light::Point { position: at, intensity: Rgb::ONE };
    let spot = Light::Spot {
        position: at,
        direction: Vec3A::NEG_Z,
        intensity: Rgb::splat(1e3),
        beam: 0.1,
        cutoff: 0.2,
        falloff: Falloff::Linear,
    };
    let sun = Light::Directional { direction: Vec3A::NEG_Z, irradiance: Rgb::splat(PI) };
    let beside = mesh(Mesh::rectangle(Affine3A::from_translation(Vec3::X * 2.0)), 0, Some(5.0));
    // Two triangles, one of them without area.
    let mut thin = Mesh::rectangle(Affine3A::from_translation(Vec3::new(0.0, 0.0, -3.0)));
    thin.positions[2] = thin.positions[1];
    let scene = Scene {
        shapes: vec![floor, beside, mesh(thin, 0, Some(1.0))],
        lights: vec![point, spot, sun],
        materials: vec![diffuse(0.5)],
        ..Scene::default()
    };
    check("on the surface", scene, ray, 0.5, 4000);
}

/// A white floor under a sky of radiance 1 that is brightest at the pole, towards the pole: no direction is lost there.
#[test]
fn the_poles_of_the_sky() {
    let image = Bitmap {
        width: 8,
        height: 5,
        texels: Texels::Gray((0..40).map(|i| if i < 8 { 4.0 } else { 0.0 }).collect()),
        wrap: [Wrap::Repeat; 2],
        second_uv: false,
        interpolation: Interpolation::Bilinear,
        to_uv: glam::Affine2::IDENTITY,
    };
    let sky = EnvironmentMap { image, to_world: glam::Mat3A::IDENTITY, scale: 1.0, rows: Rows::Poles };
    let turn = Affine3A::from_rotation_x(-0.5 * PI);
    let scene = Scene {
        shapes: vec![mesh(Mesh::rectangle(turn), 0, None)],
        environment: Some(Environment::Map(sky)),
        materials: vec![diffuse(0.5)],
        ..Scene::default()
    };
    // ∫ 4 (1 − 4θ/π) 2 sinθ cosθ dθ from 0 to π/4.
    let exact = 2.0 - 4.0 / core::f64::consts::PI;
    let down = Ray::new(Vec3A::new(0.1, 1.0, 0.2), Vec3A::NEG_Y);
    check("pole", scene.clone(), down, 0.5 * exact, 20_000);
    check("pole, seen", scene, Ray::new(Vec3A::Y, Vec3A::Y), 4.0, 10);
}
