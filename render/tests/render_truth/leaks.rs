//! Rays neither leave closed rooms nor meet the surface they start from, at any scale of the scene.

use super::scenes::*;
use glam::{Affine3A, Vec3};
use render::film::render;
use render::integrator::PathTracer;
use render::picture::{Budget, Picture};
use render::scene::*;
use render::world::World;

fn picture(scene: Scene, spp: u32) -> Picture {
    let settings = scene.integrator;
    let world = World::new(scene).unwrap();
    render(&world, &PathTracer { settings, indirect_only: false }, Budget::Samples(spp), 1, &|_| ())
}

fn scaled(mut scene: Scene, factor: f32) -> Scene {
    let by = Affine3A::from_scale(Vec3::splat(factor));
    for shape in &mut scene.shapes {
        if let Geometry::Mesh(m) = &mut shape.geometry {
            *m = core::mem::take(m).transformed(by);
        }
    }
    scene.camera.to_world.translation *= factor;
    scene.camera.near *= factor;
    scene.camera.far *= factor;
    scene
}

/// A glaring sky outside a closed dark box.
#[test]
fn no_light_leaks_into_a_closed_box() {
    for factor in [1e-3, 1.0, 1e3] {
        let mut scene = scaled(lit_box(vec![diffuse(0.9)], vec![]), factor);
        scene.shapes[1].emitter = None;
        scene.environment = Some(Environment::Constant(Rgb::splat(1e6)));
        let picture = picture(scene, 64);
        assert!(picture.pixels.iter().all(|p| p.sum().sum() == Rgb::ZERO), "scale {factor}");
        assert!(picture.pixels.iter().all(|p| p.surfaces == 64), "scale {factor}");
    }
}

#[test]
fn the_picture_does_not_depend_on_the_scale() {
    let block = mesh(
        Mesh::cube(Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.3),
            glam::Quat::from_rotation_y(0.4),
            Vec3::new(-0.2, -0.7, -0.3),
        )),
        1,
        None,
    );
    let glossy = Material::Phong { diffuse: gray(0.2), specular: gray(0.6), exponent: FloatTexture::Constant(60.0) };
    let scene = lit_box(vec![diffuse(0.6), glossy], vec![block]);
    let mean = |p: &Picture| p.pixels.iter().map(|p| f64::from(p.sum().sum().y)).sum::<f64>();
    let expected = mean(&picture(scene.clone(), 64));
    for factor in [1e-3, 1e3] {
        let other = mean(&picture(scaled(scene.clone(), factor), 64));
        assert!((other / expected - 1.0).abs() < 2e-3, "scale {factor}: {other} {expected}");
    }
}

#[test]
fn same_bytes_on_any_number_of_threads() {
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let picture = pool.install(|| picture(lit_box(vec![diffuse(0.7)], vec![]), 20));
        picture.pixels.iter().flat_map(|p| p.sum().sum().to_array().map(f32::to_bits)).collect::<Vec<_>>()
    };
    let one = bytes(1);
    assert_eq!(one, bytes(2));
    assert_eq!(one, bytes(7));
}
