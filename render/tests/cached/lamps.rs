//! Lamps of every shape by every method, seen in every way, against closed forms and quadrature: caches must not lose
//! light where they take over from the path tracer.

use crate::common::cached;
use crate::lamp_shapes::*;
use crate::pieces::*;
use core::f64::consts::PI;
use glam::{Affine3A, DVec3, Quat, Vec3, Vec3A};
use render::film::render;
use render::integrator::PathTracer;
use render::integrator::cached::policy::Allowed;
use render::picture::{Budget, Picture};
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use render::scene::*;
use render::world::World;

const RADIANCE: f32 = 3.0;

/// What a picture of one line of sight must show.
struct View {
    name: String,
    scene: Scene,
    exact: f64,
}

/// A picture of so few minutes of arc that all of it is one line of sight.
fn view(name: String, shapes: Vec<Shape>, materials: Vec<Material>, eye: Vec3A, target: Vec3A, exact: f64) -> View {
    let distance = (target - eye).length();
    let camera = Camera { near: 1e-4 * distance, ..camera(eye.into(), target.into(), 1e-3, 2) };
    let integrator = IntegratorSettings { max_depth: 12, ..IntegratorSettings::default() };
    View { name, scene: Scene { shapes, materials, camera, integrator, ..Scene::default() }, exact }
}

/// Mean of the picture by every method; no sample of it may be lost.
fn check(view: View, spp: u32, allowed: f64) {
    let View { name, scene, exact } = view;
    let world = World::new(scene).unwrap();
    let harmonics = HarmonicsSettings::new(Basis::Hemispherical, Gradients::Analytic, 0.02, None);
    let methods = [
        ("irradiance", Allowed::Irradiance),
        ("eas", Allowed::Eas),
        ("auto", Allowed::Auto),
        ("sh", Allowed::Harmonics(harmonics)),
    ];
    let near = |method: &str, picture: &Picture| {
        assert_eq!(picture.counts.not_finite, 0, "{name}, {method}");
        let image = picture.image();
        let mean = image.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / image.pixels.len() as f64;
        let off = (mean - exact).abs();
        assert!(off <= allowed * exact.max(1e-3), "{name}, {method}: {mean}, exactly {exact}");
    };
    let path = PathTracer { settings: world.scene.integrator, indirect_only: false };
    near("path", &render(&world, &path, Budget::Samples(spp), 7, &|_| ()));
    for (method, allowed) in methods {
        near(method, &cached(&world, allowed, 0.02, spp).0);
    }
}

const EXPONENT: f32 = 20.0;

fn phong() -> Material {
    Material::Phong { diffuse: gray(0.0), specular: gray(1.0), exponent: FloatTexture::Constant(EXPONENT) }
}

/// f_r of [`phong`] for the floor z = 0, in sr⁻¹.
fn phong_value(wo: DVec3, wi: DVec3) -> f64 {
    let n = f64::from(EXPONENT);
    (n + 2.0) / (2.0 * PI) * DVec3::new(-wo.x, -wo.y, wo.z).dot(wi).max(0.0).powf(n)
}

/// ∫ f(wi) cosθ cosθ' / d² dA over the fronts of a lamp, seen from a point of the floor z = 0 all of it is above.
fn over_lamp(shapes: &[Shape], at: DVec3, f: impl Fn(DVec3) -> f64) -> f64 {
    // Light of a piece of area `area` (times its unit normal).
    let piece = |p: DVec3, area: DVec3| {
        let to = p - at;
        let (d2, wi) = (to.length_squared(), to.normalize());
        f(wi) * wi.z.max(0.0) * (-area.dot(wi)).max(0.0) / d2
    };
    let n = 48;
    let triangle = |[a, b, c]: [DVec3; 3]| {
        let area = (b - a).cross(c - a) * 0.5 / f64::from(n * n);
        let corner =
            |i: u32, j: u32| a + (b - a) * (f64::from(i) / f64::from(n)) + (c - a) * (f64::from(j) / f64::from(n));
        let middle = |x: [DVec3; 3]| piece((x[0] + x[1] + x[2]) / 3.0, area);
        let cells = (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j)));
        cells.fold(0.0, |sum, (i, j)| {
            let up = middle([corner(i, j), corner(i + 1, j), corner(i, j + 1)]);
            let inner = i + j + 1 < n;
            sum + up + if inner { middle([corner(i + 1, j + 1), corner(i + 1, j), corner(i, j + 1)]) } else { 0.0 }
        })
    };
    let shape = |shape: &Shape| match &shape.geometry {
        Geometry::Mesh(m) => {
            let corner = |i: u32| m.positions[i as usize].as_dvec3();
            m.triangles.iter().map(|t| triangle(t.map(corner))).sum::<f64>()
        }
        Geometry::Sphere(s) => {
            let (rows, columns) = (400, 800);
            let cell = 2.0 / f64::from(rows) * 2.0 * PI / f64::from(columns) * f64::from(s.radius).powi(2);
            let cells = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
            cells.fold(0.0, |sum, (i, j)| {
                let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(rows);
                let (sin, cos) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns)).sin_cos();
                let normal = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
                sum + piece(s.center.as_dvec3() + f64::from(s.radius) * normal, normal * cell)
            })
        }
    };
    shapes.iter().map(shape).sum()
}

const PLACES: [(f32, Vec3A); 3] = [(1e-3, Vec3A::new(0.3, -0.5, 0.2)), (1.0, Vec3A::ZERO), (1e3, Vec3A::ZERO)];

/// Directly, whatever the lamp is made of; from behind, a sheet shows nothing.
#[test]
fn seen_directly() {
    for (scale, center) in PLACES {
        for (m, material) in [diffuse(0.8), phong(), glossy(), mirror()].into_iter().enumerate() {
            for (shape, lamp) in convex(0, RADIANCE, scale, center) {
                let eye = |z: f32| center + Vec3A::new(0.1, 0.2, z) * scale;
                let name = format!("{shape}, material {m}, scale {scale}");
                let materials = || vec![material.clone()];
                check(view(name.clone(), lamp.clone(), materials(), eye(5.0), eye(0.0), 3.0), 8, 1e-4);
                if shape == "rectangle" || shape == "disk" {
                    check(view(format!("{name}, behind"), lamp, materials(), eye(-5.0), eye(0.0), 0.0), 8, 1e-4);
                }
            }
        }
    }
}

/// In a mirror, and through a slab of glass, which passes 1 − 2R/(1 + R) with R = ((n − 1)/(n + 1))².
#[test]
fn in_a_mirror_and_through_glass() {
    let solid = Material::Dielectric { eta: 1.5, reflectance: gray(1.0), transmittance: gray(1.0) };
    for (scale, center) in PLACES {
        for (shape, lamp) in convex(0, RADIANCE, scale, center) {
            let at = |z: f32, size: Vec3, turn: f32| {
                let middle = center + Vec3A::Z * (z * scale);
                let (size, turn) = (size * scale, Quat::from_rotation_x(turn));
                Affine3A::from_scale_rotation_translation(size, turn, middle.into())
            };
            let eye = |z: f32| center + Vec3A::new(0.3, 0.1, z) * scale;
            let materials = || vec![diffuse(0.0), mirror(), solid.clone()];
            let facing_down = Mesh::rectangle(at(3.0, Vec3::splat(4.0), core::f32::consts::PI));
            let with = |content: Shape| [lamp.clone(), vec![content]].concat();
            let name = format!("{shape}, scale {scale}");
            let shapes = with(mesh(facing_down, 1, None));
            check(view(format!("{name}, mirror"), shapes, materials(), eye(2.0), eye(3.0), 2.4), 8, 1e-4);
            let slab = with(mesh(Mesh::cube(at(3.0, Vec3::new(4.0, 4.0, 0.5), 0.0)), 2, None));
            let passed = 3.0 * (1.0 - 2.0 * 0.04 / 1.04);
            check(view(format!("{name}, slab"), slab, materials(), eye(5.0), eye(0.0), passed), 20_000, 5e-3);
        }
    }
}

/// The light of a lamp on a diffuse and on a glossy floor, in the direction of the eye.
#[test]
fn on_a_floor() {
    for scale in [1e-3f32, 1.0, 1e3] {
        let target = Vec3A::new(0.4, 0.2, 0.0) * scale;
        // The mirror direction passes the rim of the lamp.
        let eye = Vec3A::new(-0.2, -0.15, 1.2) * scale;
        let wo = (eye - target).as_dvec3().normalize();
        let turned = Affine3A::from_rotation_translation(
            Quat::from_rotation_x(core::f32::consts::PI),
            Vec3::new(0.0, 0.0, 2.5 * scale),
        );
        for (shape, lamp) in convex(1, RADIANCE, scale, Vec3A::ZERO) {
            // Fronts of sheets look down on the floor.
            let lamp: Vec<_> = lamp
                .into_iter()
                .map(|mut s| {
                    match &mut s.geometry {
                        Geometry::Mesh(m) => *m = core::mem::take(m).transformed(turned),
                        Geometry::Sphere(s) => s.center = turned.transform_point3a(s.center),
                    }
                    s
                })
                .collect();
            let at = target.as_dvec3();
            let irradiance = over_lamp(&lamp, at, |_| 1.0);
            let glossy = over_lamp(&lamp, at, |wi| phong_value(wo, wi));
            for (what, material, exact) in
                [("diffuse", diffuse(0.5), 0.5 / PI * irradiance), ("phong", phong(), glossy)]
            {
                let floor = mesh(Mesh::rectangle(Affine3A::from_scale(Vec3::splat(9.0 * scale))), 0, None);
                let shapes = [vec![floor], lamp.clone()].concat();
                let name = format!("{shape} over a {what} floor, scale {scale}");
                // Lamps are black: the floor sees their light alone.
                let materials = vec![material, diffuse(0.0)];
                check(view(name, shapes, materials, eye, target, f64::from(RADIANCE) * exact), 20_000, 1e-2);
            }
        }
    }
}

/// In a closed lamp: its walls of albedo ρ show L/(1 − ρ), a black one a glossy floor that shows L times its albedo.
#[test]
fn from_inside() {
    for (scale, center) in PLACES {
        let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::IDENTITY, center.into());
        let of = |m: Mesh| mesh(m.flipped(), 0, Some(RADIANCE));
        let cap = |z: f32, turn: f32| {
            let place = Affine3A::from_rotation_translation(Quat::from_rotation_x(turn), Vec3::new(0.0, 0.0, z));
            of(Mesh::disk(to_world * place))
        };
        let side = of(Mesh::cylinder(Vec3::NEG_Z, Vec3::Z, 1.0, to_world));
        let lamps = [
            ("sphere", vec![sphere(center, scale, true, 0, Some(RADIANCE))]),
            ("cube", vec![of(Mesh::cube(to_world))]),
            ("cylinder", vec![side, cap(1.0, 0.0), cap(-1.0, core::f32::consts::PI)]),
            ("mesh", vec![of(ball(to_world))]),
        ];
        let from = |x: f32, y: f32, z: f32| center + Vec3A::new(x, y, z) * scale;
        for (shape, lamp) in lamps {
            let name = format!("inside a {shape}, scale {scale}");
            let exact: f64 = (0..12).map(|k| f64::from(RADIANCE) * 0.3f64.powi(k)).sum();
            let (eye, target) = (from(0.1, -0.2, 0.3), from(0.3, 0.3, -0.5));
            check(view(name.clone(), lamp.clone(), vec![diffuse(0.3)], eye, target, exact), 2000, 1e-2);
            let floor = mesh(Mesh::rectangle(to_world * Affine3A::from_scale(Vec3::splat(0.2))), 1, None);
            let (eye, target) = (from(-0.3, 0.1, 0.4), from(0.0, 0.02, 0.0));
            let wo = (eye - target).as_dvec3().normalize();
            let exact = f64::from(RADIANCE) * over_hemisphere(|wi| phong_value(wo, wi) * wi.z);
            let shapes = [lamp, vec![floor]].concat();
            check(view(format!("{name}, floor"), shapes, vec![diffuse(0.0), phong()], eye, target, exact), 8000, 1e-2);
        }
    }
}

/// ∫ f dω over the upper hemisphere.
fn over_hemisphere(f: impl Fn(DVec3) -> f64) -> f64 {
    let (rows, columns) = (500, 1000);
    let cells = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let sum = cells.fold(0.0, |sum, (i, j)| {
        let z = (f64::from(i) + 0.5) / f64::from(rows);
        let (sin, cos) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns)).sin_cos();
        sum + f(DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z))
    });
    sum * 2.0 * PI / f64::from(rows * columns)
}

/// A rough boundary of glass between two halves of a closed lamp: reflected and transmitted light are integrals over the
/// facets (Walter et al. 2007: of f_r cosθ dω, 4 |wo·h| F D G / (4 cosθo) for reflection, and likewise for transmission,
/// whose radiance is divided by η²).
#[test]
fn through_rough_glass() {
    let (alpha, eta) = (0.3f64, 1.5f64);
    let (eye, target) = (Vec3A::new(-0.3, 0.1, 0.4), Vec3A::ZERO);
    for behind in [false, true] {
        let turn = |v: Vec3A| if behind { Vec3A::new(v.x, v.y, -v.z) } else { v };
        let wo = eye.as_dvec3().normalize();
        // Index of the other side over that of the eye's.
        let n = if behind { 1.0 / eta } else { eta };
        let g1 = |w: DVec3| 2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 / (w.z * w.z) - 1.0)).sqrt());
        let exact = over_hemisphere(|h| {
            let c = wo.dot(h);
            if c <= 0.0 {
                return 0.0;
            }
            let d = alpha * alpha / (PI * (h.z * h.z * (alpha * alpha - 1.0) + 1.0).powi(2));
            let sin2 = (1.0 - c * c) / (n * n);
            let facet = |w: DVec3| d * g1(wo) * g1(w) * c / wo.z;
            let reflected = 2.0 * c * h - wo;
            let mirrored = if reflected.z > 0.0 { facet(reflected) } else { 0.0 };
            if sin2 >= 1.0 {
                return mirrored;
            }
            let cos_t = (1.0 - sin2).sqrt();
            let (s, p) = ((c - n * cos_t) / (c + n * cos_t), (n * c - cos_t) / (n * c + cos_t));
            let fresnel = 0.5 * (s * s + p * p);
            let refracted = (c / n - cos_t) * h - wo / n;
            let passed = if refracted.z < 0.0 { facet(refracted) / (n * n) } else { 0.0 };
            fresnel * mirrored + (1.0 - fresnel) * passed
        });
        let glass = Material::RoughDielectric {
            distribution: Distribution::Ggx,
            alpha_u: FloatTexture::Constant(alpha as f32),
            alpha_v: FloatTexture::Constant(alpha as f32),
            eta: eta as f32,
            reflectance: gray(1.0),
            transmittance: gray(1.0),
        };
        let boundary = mesh(Mesh::rectangle(Affine3A::from_scale(Vec3::splat(2.0))), 1, None);
        let lamps = [
            ("sphere", sphere(Vec3A::ZERO, 1.0, true, 0, Some(RADIANCE))),
            ("cube", mesh(Mesh::cube(Affine3A::IDENTITY).flipped(), 0, Some(RADIANCE))),
            ("mesh", mesh(ball(Affine3A::IDENTITY).flipped(), 0, Some(RADIANCE))),
        ];
        for (shape, lamp) in lamps {
            let shapes = vec![lamp, boundary.clone()];
            let name = format!("rough glass in a {shape}, from behind: {behind}");
            let materials = vec![diffuse(0.0), glass.clone()];
            check(view(name, shapes, materials, turn(eye), target, f64::from(RADIANCE) * exact), 8000, 1e-2);
        }
    }
}
