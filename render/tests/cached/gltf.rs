//! glTF's metallic-roughness from records: its lobe with Schlick's reflectance, and a furnished room.

use crate::common::{compare, gathered, scenes, settings, table, traced};
use brdf_tables::material::Material as Recipe;
use glam::Vec3A;
use render::bsdf::Parts;
use render::frame::Frame;
use render::hemisphere::{Incident, hemisphere_directions};
use render::inspect::{Place, exact, reflected};
use render::integrator::cached::policy::{Allowed, Policy, outlook, specular};
use render::integrator::cached::render_cached;
use render::record::eas::{EasRecord, Estimator};
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use render::record::{Albedo, Centroid, CutSettings, Record, Reflector, Tree, cut};
use render::scene::{ColorTexture, FloatTexture, Material, TextureId, load};
use render::world::World;

fn metallic_roughness(metallic: f32, roughness: FloatTexture, grazing: f32) -> Material {
    Material::MetallicRoughness {
        base_color: ColorTexture::Constant(Vec3A::new(0.9, 0.6, 0.2)),
        metallic: FloatTexture::Constant(metallic),
        roughness,
        f0: ColorTexture::Constant(Vec3A::splat(0.04)),
        specular: FloatTexture::Constant(grazing),
        layered: None,
    }
}

/// What is said of a material is true of that material.
#[test]
fn every_material_is_told_its_own_reason() {
    let constant = FloatTexture::Constant;
    for (material, wanted) in [
        (metallic_roughness(0.0, constant(0.5), 1.0), "EAS records (lobe 0.354 rad)"),
        (metallic_roughness(1.0, constant(1.0), 1.0), "EAS records (lobe 1.000 rad)"),
        (metallic_roughness(1.0, constant(0.16), 1.0), "EAS records (lobe 0.036 rad, 26 % traced)"),
        (metallic_roughness(1.0, constant(0.1), 1.0), "path traced (lobe 0.014 rad is too sharp to cache)"),
        (metallic_roughness(1.0, constant(0.0), 1.0), "path traced (nearly a mirror)"),
        (metallic_roughness(0.0, constant(0.5), 0.0), "irradiance records"),
        (metallic_roughness(0.0, FloatTexture::Texture(TextureId(0)), 0.0), "irradiance records"),
        (
            metallic_roughness(0.5, FloatTexture::Scaled(TextureId(0), 0.7), 1.0),
            "EAS records where its lobe, which a texture gives, is wide enough",
        ),
    ] {
        assert_eq!(outlook(&material), wanted, "{material:?}");
    }
}

/// Parts of a plastic, a coloured metal, a plastic with a coloured reflection that fades, and a white mirror.
const PARTS: [([f32; 3], f32); 4] =
    [([0.04; 3], 1.0), ([0.9, 0.6, 0.2], 1.0), ([0.0, 0.01, 0.03], 0.4), ([1.0; 3], 1.0)];

/// A record reflects what the model does, sample by sample: light from everywhere and from a window.
#[test]
fn records_reflect_with_schlicks_colours() {
    let frame = Frame::from_normal(Vec3A::new(0.48, 0.6, 0.64));
    let constant = |_: Vec3A| Incident { radiance: Vec3A::ONE, distance: f32::INFINITY, normal: Vec3A::ZERO };
    let window = |d: Vec3A| Incident {
        radiance: Vec3A::new(3.0, 2.0, 1.0) * (4.0 * (d.dot(frame.to_world(Vec3A::new(0.8, 0.0, 0.6))) - 1.0)).exp()
            + 0.2,
        distance: f32::INFINITY,
        normal: Vec3A::ZERO,
    };
    let directions: Vec<_> = hemisphere_directions(200).into_iter().filter(|wo| wo.z > 0.2).collect();
    let mut worst = 0f32;
    for roughness in [0.3, 0.7] {
        let recipe = specular(&metallic_roughness(0.0, FloatTexture::Constant(roughness), 1.0)).expect("it has a lobe");
        let table = table(&Recipe::specular(recipe));
        let (albedo, width) = (Albedo::new(&table), recipe.lobe_width() as f32);
        for (normal, grazing) in PARTS {
            let parts = Parts { diffuse: Vec3A::ZERO, specular: normal.into(), grazing: Vec3A::splat(grazing) };
            let reflector = Reflector::of(&table, &parts);
            let place = Place { position: Vec3A::ZERO, frame, reflector, albedo: &albedo };
            let made = |light: &dyn Fn(Vec3A) -> Incident| {
                let mut samples = gathered(&frame, width.min(0.2), 0.4, 4, light);
                let tree = Tree::new(&mut samples, 4, Centroid::Direction);
                let settings = CutSettings { tolerance: 1e-3, max_eas: 2000 };
                let cut = cut(&tree, &reflector, &hemisphere_directions(64), &settings);
                let record = EasRecord::new(Vec3A::ZERO, &frame, 0, &tree, &cut, Estimator::Improved);
                (reflected(&record, &place, Estimator::Improved, &directions), samples)
            };
            let error = |light: &dyn Fn(Vec3A) -> Incident| {
                let (found, samples) = made(light);
                let truth = exact(&samples, &reflector, &directions, &|_| ());
                let wrong: f32 = found.iter().zip(&truth).map(|(l, t)| (*l - *t).length_squared()).sum();
                (wrong / truth.iter().map(|t| t.length_squared()).sum::<f32>()).sqrt()
            };
            let (constant, window) = (error(&constant), error(&window));
            println!(
                "roughness {roughness}, {normal:?} to {grazing}: constant light {constant:.4}, a window {window:.4}"
            );
            worst = worst.max(constant).max(window);
        }
    }
    assert!(worst < 0.02, "{worst}");
}

/// The room of `tests/scenes` at a small size.
fn room(width: u32) -> World {
    let (mut scene, warnings) =
        load::load(&scenes().join("room.glb"), &load::Options::default()).expect("the room loads");
    assert!(warnings.is_empty(), "the room is read without warnings");
    (scene.camera.film.width, scene.camera.film.height) = (width, width * 9 / 16);
    World::new(scene).expect("the room is valid")
}

/// The floor, wood, ceramics and metals of the room shine from EAS records, its walls from irradiance; every method agrees
/// with the path tracer. What all of them have of error is the noise of direct light.
#[test]
fn a_furnished_room_shines_from_records() {
    let world = room(96);
    let reference = traced(&world, 512);
    let order = None;
    let harmonics = HarmonicsSettings::new(Basis::Hemispherical, Gradients::default(), 0.05, order);
    let id = |name: &str| {
        let named = |(n, m): (&String, &Material)| n == name && matches!(m, Material::MetallicRoughness { .. });
        world.scene.material_names.iter().zip(&world.scene.materials).position(named).expect("the room has it") as u32
    };
    for allowed in [Allowed::Auto, Allowed::Irradiance, Allowed::Harmonics(harmonics)] {
        let policy = Policy::new(&world.scene, allowed, |r| Ok::<_, ()>(table(r))).expect("no table is refused");
        let (picture, figures, caches) = render_cached(&world, &policy, &settings(), None, &|_| ());
        let (error, bias) = compare(&picture, &reference);
        println!(
            "{allowed:?}: rel_mse {error:.4}, bias {:.2} %, {} EAS, {} harmonic and {} irradiance records",
            100.0 * bias,
            figures.glossy.eas.records,
            figures.glossy.harmonics.records,
            figures.irradiance_records
        );
        assert!(error < 0.02 && bias.abs() < 0.02, "{allowed:?}: {error} {bias}");
        assert!(!caches.irradiance.records().is_empty(), "{allowed:?}: the walls have records");
        if allowed == Allowed::Auto {
            for name in ["floor", "oak", "chair", "steel"] {
                let records = caches.glossy.eas.records().iter().filter(|r| r.zone().material == id(name)).count();
                assert!(records > 0, "no record on {name}");
            }
            let said = |text: &str| policy.notes.iter().any(|n| n == text);
            assert!(said("floor: cached (lobe 0.127 rad)"), "{:?}", policy.notes);
            assert!(said("chrome: path traced (lobe 0.009 rad is too sharp to cache)"), "{:?}", policy.notes);
        }
    }
}
