//! Radiance known in closed form, met within three standard errors.

use super::scenes::*;
use core::f64::consts::PI;
use glam::{Affine3A, Vec3, Vec3A};
use render::integrator::{Integrator, PathTracer, SimplePathTracer};
use render::ray::Ray;
use render::sampler::Sampler;
use render::scene::*;
use render::world::{Queries, World};

/// Mean and standard error of `n` independent estimates along one ray.
fn estimate(world: &World, integrator: &impl Integrator, ray: Ray, n: u32) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..n {
        let mut sampler = Sampler::new(42, (i, 0), 0);
        let x = f64::from(integrator.radiance(world, ray, &mut sampler, &mut Queries::default()).sum().y);
        sum += x;
        squares += x * x;
    }
    let (n, mean) = (f64::from(n), sum / f64::from(n));
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

fn check(name: &str, scene: Scene, ray: Ray, exact: f64, twin: bool) {
    let settings = scene.integrator;
    let world = World::new(scene).unwrap();
    let tracer = PathTracer { settings, indirect_only: false };
    let (mean, error) = estimate(&world, &tracer, ray, 100_000);
    println!("{name}: {mean:.6} ± {error:.6}, exactly {exact:.6}");
    // The rest is the rounding of sums in f32.
    assert!((mean - exact).abs() <= 3.0 * error + 1e-4 * exact, "{name}: {mean} ± {error}, exactly {exact}");
    if twin {
        let simple = SimplePathTracer { max_depth: 60 };
        let (mean, error) = estimate(&world, &simple, ray, 20_000);
        assert!((mean - exact).abs() <= 3.0 * error + 1e-4 * exact, "twin, {name}: {mean} ± {error}, exactly {exact}");
    }
}

fn inside() -> Ray {
    Ray::new(Vec3A::new(0.2, -0.3, 0.1), Vec3A::new(0.3, 0.5, -0.7).normalize())
}

/// Unit sphere of albedo ½: a light of intensity π at its centre, or emission of ½, sums to ½ + ¼ + … = 1.
#[test]
fn unit_sphere_has_radiance_one() {
    let shell = |radiance| vec![sphere(Vec3A::ZERO, 1.0, true, 0, radiance)];
    let lamp = vec![Light::Point { position: Vec3A::ZERO, intensity: Rgb::splat(PI as f32) }];
    let scene = Scene { shapes: shell(None), lights: lamp, materials: vec![diffuse(0.5)], ..Scene::default() };
    check("lamp", scene, inside(), 1.0, true);
    let scene = Scene { shapes: shell(Some(0.5)), materials: vec![diffuse(0.5)], ..Scene::default() };
    check("shining wall", scene, inside(), 1.0, true);
}

/// A convex body under light from everywhere shows its albedo.
#[test]
fn white_sky_shows_the_albedo() {
    let ray = Ray::new(Vec3A::new(0.3, 0.2, 5.0), Vec3A::NEG_Z);
    for (name, sky) in [("constant", Environment::Constant(Rgb::ONE)), ("map", Environment::Map(white_map()))] {
        for shape in [sphere(Vec3A::ZERO, 1.0, false, 0, None), mesh(Mesh::cube(Affine3A::IDENTITY), 0, None)] {
            let scene = Scene {
                shapes: vec![shape],
                materials: vec![diffuse(0.8)],
                environment: Some(sky.clone()),
                ..Scene::default()
            };
            check(name, scene, ray, 0.8, true);
        }
    }
}

fn white_map() -> EnvironmentMap {
    EnvironmentMap {
        image: Bitmap {
            width: 8,
            height: 4,
            texels: Texels::Gray(vec![0.5; 32]),
            wrap: [Wrap::Repeat; 2],
            second_uv: false,
            interpolation: Interpolation::Bilinear,
            to_uv: glam::Affine2::IDENTITY,
        },
        to_world: glam::Mat3A::IDENTITY,
        scale: 2.0,
        rows: Rows::Poles,
    }
}

/// Irradiance at a point below the centre of a parallel a × b rectangle at height h, over π (the corner form four
/// times): the radiance of a white diffuse floor under radiance 1.
fn form_factor(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (0.5 * a / h, 0.5 * b / h);
    let part = |x: f64, y: f64| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    4.0 / (2.0 * PI) * (part(x, y) + part(y, x))
}

#[test]
fn rectangle_light_has_its_form_factor() {
    let (a, b, h, albedo) = (1.4, 0.6, 0.8, 0.7);
    let light = Affine3A::from_scale_rotation_translation(
        Vec3::new(a as f32 / 2.0, b as f32 / 2.0, 1.0),
        glam::Quat::from_rotation_x(core::f32::consts::PI),
        Vec3::new(0.0, 0.0, h as f32),
    );
    let whole = Mesh::rectangle(light);
    let mut halves = [whole.clone(), whole.clone()];
    halves[0].triangles.truncate(1);
    halves[1].triangles.remove(0);
    let floor = mesh(Mesh::rectangle(Affine3A::from_scale(Vec3::splat(5.0))), 0, None);
    let settings = IntegratorSettings { max_depth: 2, ..IntegratorSettings::default() };
    let ray = Ray::new(Vec3A::new(-2.0, 0.0, 0.5), Vec3A::new(2.0, 0.0, -0.5).normalize());
    // The light as one parallelogram, and as two triangles chosen by the tree.
    for lights in [vec![mesh(whole, 0, Some(1.0))], halves.map(|m| mesh(m, 0, Some(1.0))).to_vec()] {
        let scene = Scene {
            shapes: [vec![floor.clone()], lights].concat(),
            materials: vec![diffuse(albedo as f32)],
            integrator: settings,
            ..Scene::default()
        };
        check("rectangle", scene, ray, albedo * form_factor(a, b, h), false);
    }
}

/// Irradiance under a sphere light is π L sin² of its half angle, times the cosine.
#[test]
fn sphere_light_has_its_form_factor() {
    let floor = mesh(Mesh::rectangle(Affine3A::from_scale(Vec3::splat(5.0))), 0, None);
    let scene = Scene {
        shapes: vec![floor, sphere(Vec3A::new(0.0, 0.0, 2.0), 0.5, false, 0, Some(3.0))],
        materials: vec![diffuse(0.5)],
        integrator: IntegratorSettings { max_depth: 2, ..IntegratorSettings::default() },
        ..Scene::default()
    };
    let ray = Ray::new(Vec3A::new(-2.0, 0.0, 0.5), Vec3A::new(2.0, 0.0, -0.5).normalize());
    check("sphere", scene, ray, 0.5 * 3.0 * 0.25 * 0.25, false);
}

/// A triangle whose smooth normals lean 40° towards a light that grazes it at 10°: the light falls on the smooth normal, and with
/// a soft terminator times −g³ + g² + g, g = cos 80° / (cos 40° cos 40°) (Chiang, Li and Burley 2019).
#[test]
fn smooth_normals_end_softly() {
    let degrees = |x: f64| x.to_radians() as f32;
    let lean = Vec3::new(degrees(40.0).sin(), 0.0, degrees(40.0).cos());
    let mut triangle = Mesh::rectangle(Affine3A::from_scale(Vec3::splat(5.0)));
    triangle.normals = vec![lean; triangle.positions.len()];
    let direction = -Vec3A::new(degrees(80.0).sin(), 0.0, degrees(80.0).cos());
    let sun = Light::Directional { direction, irradiance: Rgb::splat(2.0) };
    let ray = Ray::new(Vec3A::new(0.2, 0.1, 3.0), Vec3A::NEG_Z);
    let hard = 0.5 / PI * 2.0 * 40f64.to_radians().cos();
    let g = 80f64.to_radians().cos() / 40f64.to_radians().cos().powi(2);
    for (soft, exact) in [(false, hard), (true, hard * (g * g + g - g * g * g))] {
        let scene = Scene {
            shapes: vec![mesh(triangle.clone(), 0, None)],
            materials: vec![diffuse(0.5)],
            lights: vec![sun],
            integrator: IntegratorSettings { soft_terminator: soft, ..IntegratorSettings::default() },
            ..Scene::default()
        };
        check(if soft { "soft terminator" } else { "terminator" }, scene, ray, exact, true);
    }
}

/// Irradiance from a directional light and from a spot.
#[test]
fn lights_without_extent() {
    let floor = mesh(Mesh::rectangle(Affine3A::from_scale(Vec3::splat(5.0))), 0, None);
    let slanted = Vec3A::new(0.0, 0.6, -0.8);
    let lights = vec![
        Light::Directional { direction: slanted, irradiance: Rgb::splat(2.0) },
        Light::Spot {
            position: Vec3A::new(0.0, 0.0, 2.0),
            direction: Vec3A::NEG_Z,
            intensity: Rgb::splat(3.0),
            beam: 0.1,
            cutoff: 0.2,
            falloff: Falloff::Linear,
        },
    ];
    let scene = Scene { shapes: vec![floor], materials: vec![diffuse(0.5)], lights, ..Scene::default() };
    let ray = Ray::new(Vec3A::new(-2.0, 0.0, 0.5), Vec3A::new(2.0, 0.0, -0.5).normalize());
    check("sun and spot", scene, ray, 0.5 / PI * (2.0 * 0.8 + 3.0 / 4.0), true);
}
