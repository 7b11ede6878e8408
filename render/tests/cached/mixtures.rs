//! Surfaces of several components, and bent normals: a record is light, and serves them all.

use crate::common::{compare, drawn, noise, traced, world};
use brdf_tables::brdf::{Sheen, Specular};
use glam::{Affine2, Vec2, Vec3A};
use render::integrator::cached::policy::Allowed;
use render::scene::{ColorTexture, FloatTexture, Material, MaterialId, Scene};
use render::world::World;

fn gray(value: f32) -> ColorTexture {
    ColorTexture::Constant(Vec3A::splat(value))
}

fn phong(exponent: f32, diffuse: f32) -> Material {
    Material::Phong { diffuse: gray(diffuse), specular: gray(0.6), exponent: FloatTexture::Constant(exponent) }
}

fn mirror() -> Material {
    Material::Conductor { eta: gray(0.0), k: gray(1.0), specular: gray(1.0) }
}

fn plastic() -> Material {
    Material::Plastic { eta: 1.5, diffuse: gray(0.5), specular: gray(1.0), nonlinear: false }
}

fn push(scene: &mut Scene, material: Material) -> MaterialId {
    scene.materials.push(material);
    scene.material_names.push(format!("component {}", scene.materials.len()));
    MaterialId(scene.materials.len() as u32 - 1)
}

/// The box whose floor is made of something else.
fn floor(make: impl FnOnce(&mut Scene) -> Material) -> World {
    let mut scene = world("floor-n100.xml", &[("width", "64"), ("height", "64")]).scene;
    let made = make(&mut scene);
    let mut floors =
        scene.materials.iter_mut().filter(|m| matches!(m, Material::Phong { specular, .. } if *specular == gray(0.6)));
    *floors.next().expect("the floor is glossy") = made;
    World::new(scene).expect("the box is valid")
}

fn blend(scene: &mut Scene, weight: FloatTexture, first: Material, second: Material) -> Material {
    let (first, second) = (push(scene, first), push(scene, second));
    Material::Blend { weight, first, second }
}

/// EAS records of the box with such a floor, whose picture is that of the path tracer. With sources from outside, lights are
/// sampled by one component at a time: what is left of error is that noise.
fn records(what: &str, allowed: Allowed, world: &World) -> usize {
    let (policy, picture, figures, _) = drawn(world, allowed);
    let (error, bias) = compare(&picture, &traced(world, 512));
    let records = figures.glossy.eas.records;
    println!(
        "{what}: rel_mse {error:.4}, bias {:.2} %, {records} EAS, {} irradiance records; {:?}",
        100.0 * bias,
        figures.irradiance_records,
        policy.notes
    );
    assert!(error < 0.002 && bias.abs() < 0.01, "{what}: {error} {bias}");
    records
}

/// A blend needs no more records than its sharpest lobe alone.
#[test]
fn components_share_records() {
    let alone = |exponent| records("alone", Allowed::Auto, &floor(|_| phong(exponent, 0.2)));
    let (sharp, broad) = (alone(100.0), alone(20.0));
    let half = FloatTexture::Constant(0.5);
    let both =
        records("blend of 20 and 100", Allowed::Auto, &floor(|s| blend(s, half, phong(20.0, 0.1), phong(100.0, 0.2))));
    println!("{sharp} and {broad} records alone, {both} of the blend");
    assert!(both * 10 < sharp * 12 && both < sharp + broad);
    let varying = |s: &mut Scene| noise(s, 0.0, 1.0, Affine2::from_scale(Vec2::splat(3.0)));
    let textured = floor(|s| {
        let weight = varying(s);
        blend(s, weight, Material::Diffuse { reflectance: gray(0.6) }, phong(100.0, 0.0))
    });
    let with_diffuse = records("blend of diffuse and 100 by a texture", Allowed::Auto, &textured);
    assert!(with_diffuse * 10 < sharp * 12);
    records("the same", Allowed::Eas, &textured);
    records("the same, without glossy records", Allowed::Irradiance, &textured);
}

/// What no record holds of a blend is traced: a mirror, and a lobe that is too sharp.
#[test]
fn other_components_are_traced() {
    let weight = FloatTexture::Constant(0.3);
    records("blend of 100 and a mirror", Allowed::Auto, &floor(|s| blend(s, weight, phong(100.0, 0.2), mirror())));
    records(
        "blend of 100 and 5000",
        Allowed::Auto,
        &floor(|s| blend(s, weight, phong(100.0, 0.2), phong(5000.0, 0.0))),
    );
    let graded = floor(|s| {
        let exponent = noise(s, 10.0, 300.0, Affine2::from_scale(Vec2::splat(3.0)));
        let textured = Material::Phong { diffuse: gray(0.1), specular: gray(0.6), exponent };
        blend(s, weight, phong(40.0, 0.2), textured)
    });
    records("blend of 40 and 10 to 300 by a texture", Allowed::Auto, &graded);
}

/// Coats: a smooth one over a diffuse base, and a clear one over a glossy base.
#[test]
fn coats_are_sums_of_their_parts() {
    let smooth = floor(|_| plastic());
    assert_eq!(records("plastic", Allowed::Auto, &smooth), 0);
    records("plastic", Allowed::Irradiance, &smooth);
    let clear = floor(|s| {
        let (coat, base) = (push(s, mirror()), push(s, phong(20.0, 0.2)));
        Material::Coat { added: false, weight: FloatTexture::Constant(1.0), coat, base }
    });
    assert!(records("clear coat over 20", Allowed::Auto, &clear) > 0);
    let deep = floor(|s| {
        let inner = blend(s, FloatTexture::Constant(0.4), plastic(), phong(30.0, 0.1));
        let inner = push(s, inner);
        let coat = push(s, phong(200.0, 0.0));
        Material::Coat { added: false, weight: FloatTexture::Constant(1.0), coat, base: inner }
    });
    records("glossy coat over a blend of plastic and 30", Allowed::Auto, &deep);
    let painted = floor(|s| {
        let [weight, zero] = [0.8, 0.0].map(FloatTexture::Constant);
        let coat = push(s, Material::ClearCoat { gloss: FloatTexture::Constant(0.5) });
        let base = Material::Principled {
            base_color: gray(0.5),
            metallic: FloatTexture::Constant(0.4),
            roughness: FloatTexture::Constant(0.5),
            anisotropic: 0.0,
            eta: 1.5,
            spec_tint: zero,
            sheen: FloatTexture::Constant(0.2),
            sheen_tint: zero,
        };
        let base = push(s, base);
        Material::Coat { added: true, weight, coat, base }
    });
    assert!(records("principled under a clear coat", Allowed::Auto, &painted) > 0);
}

/// Fibres over a glossy base read the records that the base reads.
#[test]
fn fibres_share_records() {
    let sheen = floor(|s| {
        let model = Specular::Sheen(Sheen { alpha: 0.4 });
        let fibres = push(s, Material::Lobe { diffuse: gray(0.0), specular: gray(1.0), model });
        let base = push(s, phong(20.0, 0.2));
        Material::Sheen { color: ColorTexture::Constant(Vec3A::new(0.9, 0.6, 0.3)), fibres, base }
    });
    assert!(records("sheen over 20", Allowed::Auto, &sheen) > 0);
    records("sheen over 20, EAS", Allowed::Eas, &sheen);
}

/// Normals bent by a texture, up to 17° here, spread what is seen in a record, so that it reaches less far; it serves all of them.
#[test]
fn bent_normals_share_records() {
    let with = |scale_by: f32| {
        let mut scene = world("failure/normal-map.xml", &[("width", "96"), ("height", "72")]).scene;
        for material in &mut scene.materials {
            if let Material::NormalMap { scale, .. } = material {
                *scale *= scale_by;
            }
        }
        records(&format!("normals bent {scale_by} times"), Allowed::Auto, &World::new(scene).expect("it is valid"))
    };
    let (flat, bent) = (with(0.0), with(1.0));
    println!("{flat} records flat, {bent} bent");
    assert!(bent < 3 * flat, "{flat} {bent}");
}
