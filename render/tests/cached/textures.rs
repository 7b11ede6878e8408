//! Roughness and exponents from textures: lobes that change from point to point read the same records.

use crate::common::{compare, drawn, noise, scenes, traced, world};
use brdf_tables::family;
use glam::{Affine2, Vec2};
use render::integrator::cached::policy::{Allowed, Policy};
use render::record::Record;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use render::scene::{FloatTexture, Material, load};
use render::world::World;

fn harmonics() -> Allowed {
    Allowed::Harmonics(HarmonicsSettings::new(Basis::Hemispherical, Gradients::default(), 0.05, None))
}

/// The floor of the furnished room, of constant roughness and of one that a texture gives: by every method its picture is that
/// of the path tracer.
#[test]
fn a_texture_may_give_the_roughness_of_gltf() {
    let room = |texture: bool| {
        let options = load::Options::default();
        let (mut scene, _) = load::load(&scenes().join("room.glb"), &options).expect("the room loads");
        (scene.camera.film.width, scene.camera.film.height) = (96, 54);
        let given = noise(&mut scene, 0.28, 0.6, Affine2::from_scale(Vec2::splat(2.0)));
        let number = if texture { given } else { FloatTexture::Constant(0.4) };
        let names = scene.material_names.iter().zip(&mut scene.materials);
        let mut floors = names.filter(|(name, _)| *name == "floor");
        match floors.next() {
            Some((_, Material::MetallicRoughness { roughness, .. })) => *roughness = number,
            other => panic!("the floor of the room is {other:?}"),
        }
        World::new(scene).expect("the room is valid")
    };
    for (texture, note) in
        [(false, "floor: cached (lobe 0.226 rad)"), (true, "floor: cached (lobe 0.111 to 0.507 rad, from a texture)")]
    {
        let world = room(texture);
        let reference = traced(&world, 256);
        let classes = world.scene.materials.len() as u32;
        for allowed in [Allowed::Auto, Allowed::Eas, harmonics()] {
            let (policy, picture, figures, caches) = drawn(&world, allowed);
            let (error, bias) = compare(&picture, &reference);
            let on_floor = caches.glossy.eas.records().iter().filter(|r| r.zone().material >= classes).count();
            println!(
                "texture {texture}, {allowed:?}: rel_mse {error:.4}, bias {:.2} %, {} EAS records ({on_floor} of grades), {} harmonic",
                100.0 * bias,
                figures.glossy.eas.records,
                figures.glossy.harmonics.records
            );
            assert!(error < 0.02 && bias.abs() < 0.02, "{texture} {allowed:?}: {error} {bias}");
            let harmonic = matches!(allowed, Allowed::Harmonics(_));
            assert_eq!(on_floor > 0, texture && !harmonic);
            let found = policy.notes.iter().find(|n| n.starts_with("floor")).expect("the floor is told of");
            assert!(found == note || harmonic, "{found}");
        }
    }
}

/// A floor whose exponent a texture gives, with places too sharp for records: those are path traced, and it is said.
#[test]
fn a_texture_may_give_the_exponent() {
    for (range, note) in [
        ([20.0, 200.0], "floor-material: cached (lobe 0.071 to 0.224 rad, from a texture)"),
        (
            [100.0, 5000.0],
            "floor-material: cached (lobe 0.014 to 0.100 rad, from a texture), path traced where it is sharper",
        ),
    ] {
        let mut scene = world("floor-n100.xml", &[("width", "48"), ("height", "48")]).scene;
        let given = noise(&mut scene, range[0], range[1], Affine2::from_scale(Vec2::splat(3.0)));
        let glossy = scene.materials.iter_mut().filter_map(|m| match m {
            Material::Phong { exponent, .. } => Some(exponent),
            _ => None,
        });
        assert_eq!(glossy.map(|exponent| *exponent = given).count(), 1);
        let world = World::new(scene).expect("the box is valid");
        let reference = traced(&world, 256);
        for allowed in [Allowed::Auto, Allowed::Eas, harmonics()] {
            let (policy, picture, figures, _) = drawn(&world, allowed);
            let (error, bias) = compare(&picture, &reference);
            println!(
                "{range:?}, {allowed:?}: rel_mse {error:.4}, bias {:.2} %, {} EAS, {} harmonic records",
                100.0 * bias,
                figures.glossy.eas.records,
                figures.glossy.harmonics.records
            );
            assert!(error < 0.02 && bias.abs() < 0.02, "{range:?} {allowed:?}: {error} {bias}");
            let said = policy.notes.iter().any(|n| n.ends_with(note.split_once(": ").expect("a name").1));
            assert!(said || allowed != Allowed::Auto, "{:?}", policy.notes);
        }
    }
}

/// A texture that is so sharp everywhere that nothing is cached says so.
#[test]
fn a_texture_of_mirrors_is_traced() {
    let mut scene = world("floor-n100.xml", &[("width", "16"), ("height", "16")]).scene;
    let given = noise(&mut scene, 3000.0, 5000.0, Affine2::IDENTITY);
    for material in &mut scene.materials {
        if let Material::Phong { exponent, .. } = material {
            *exponent = given;
        }
    }
    let policy = Policy::new(&scene, Allowed::Auto, |recipe| family::table(recipe).ok_or(())).expect("no fit");
    let told = policy
        .notes
        .iter()
        .any(|n| n.ends_with("path traced (lobe 0.014 to 0.018 rad, from a texture: too sharp to cache)"));
    assert!(told, "{:?}", policy.notes);
}
