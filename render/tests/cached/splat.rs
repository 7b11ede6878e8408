//! Records drawn onto tiles of pixels against pixels that look for records.

use crate::common::{table, world};
use render::integrator::cached::kinds::KINDS;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Rendering, Settings};
use render::picture::{Budget, Picture};
use render::scene::{Lens, Projection, load};
use render::world::World;
use std::path::Path;
use std::time::Instant;

const SMALL: [(&str, &str); 2] = [("width", "48"), ("height", "40")];
const TOLERANCE: f32 = 0.1;

/// The kinds by name.
fn allowed(method: &str) -> Allowed {
    match method {
        "auto" => Allowed::Auto,
        "irradiance" => Allowed::Irradiance,
        _ => KINDS.iter().find(|kind| kind.name == method).map(|kind| (kind.alone)(TOLERANCE)).expect("a kind"),
    }
}

/// The pictures by octree and by splatting from the same records, and the number of records.
fn both(world: &World, method: &str, threads: usize) -> ([Picture; 2], usize) {
    let policy = Policy::new(&world.scene, allowed(method), |r| Ok::<_, ()>(table(r))).expect("no table is refused");
    let settings = Settings { tolerance: Some(TOLERANCE), budget: Budget::Samples(4), ..crate::common::settings() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| {
        let filled = Rendering::new(world, &policy, &settings).fill(world, TOLERANCE, None, None, &|_| ());
        let pictures = [Interpolation::Octree, Interpolation::Splat].map(|interpolation| {
            let rendering = Rendering::new(world, &policy, &Settings { interpolation, ..settings });
            rendering.shade(world, TOLERANCE, &filled, (settings.budget, 5), Instant::now(), &|_| ()).0
        });
        (pictures, filled.records())
    })
}

/// All scenes, with every kind that their materials allow: boxes, floors, objects under a sky, mirrors, glass, bent normals.
#[test]
fn pictures_are_those_of_the_octree_to_the_last_bit() {
    let mut drawn = 0;
    for (scene, methods) in [
        ("cornell-glossy.xml", &["auto", "eas", "sh", "irradiance"][..]),
        ("cornell-diffuse.xml", &["irradiance"]),
        ("floor-n100.xml", &["eas", "sh"]),
        ("floor-n20.xml", &["sh"]),
        ("preview.xml", &["auto"]),
        ("materials.xml", &["auto", "sh"]),
        ("anisotropic-sphere.xml", &["auto"]),
        ("glossy-object.xml", &["eas"]),
        ("glossy-wall.xml", &["eas"]),
    ] {
        for method in methods {
            let ([octree, splat], records) = both(&world(scene, &SMALL), method, 2);
            println!("{scene} {method}: {records} records");
            assert!(records > 20, "{scene} {method}: {records} records");
            assert!(octree.image().pixels == splat.image().pixels, "{scene} {method}");
            drawn += records;
        }
    }
    assert!(drawn > 2500, "{drawn} records in all");
}

/// Scenes of others, where the folder `shared/scenes` lies beside the checkout: many triangles, textures, rooms behind one another.
#[test]
fn pictures_of_real_scenes_are_those_of_the_octree() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    for (scene, method) in [
        ("cornell/fig12.xml", "auto"),
        ("dragon/dragon.xml", "eas"),
        ("matpreview/matpreview-n40.xml", "eas"),
        ("sponza/sponza.xml", "irradiance"),
        ("staircase2/scene.xml", "auto"),
        ("wooden-staircase/scene.xml", "auto"),
        ("kitchenette/scene.xml", "irradiance"),
    ] {
        let path = folder.join(scene);
        if !path.exists() {
            println!("skipped: {} is absent", path.display());
            continue;
        }
        let (mut scene, _) = load::load(&path, &load::Options::default()).unwrap_or_else(|e| panic!("{e}"));
        scene.camera.film.resize(Some(48), None);
        let world = World::new(scene).expect("it is valid");
        let ([octree, splat], records) = both(&world, method, 2);
        println!("{} {method}: {records} records", path.display());
        assert!(records > 20, "{}: {records} records", path.display());
        assert!(octree.image().pixels == splat.image().pixels, "{}", path.display());
    }
}

/// Parallel rays, a lens, a camera amid the records with a near plane that cuts their spheres, a part of the film.
#[test]
fn any_camera_sees_the_same_records() {
    let box_ = || world("cornell-glossy.xml", &SMALL);
    let mut parallel = box_();
    parallel.scene.camera.projection = Projection::Orthographic { half_width: 2.5 };
    let mut lens = box_();
    lens.scene.camera.lens = Lens::new(0.3, 7.0);
    let mut inside = box_();
    let forward = inside.scene.camera.to_world.matrix3.z_axis.normalize();
    let (min, max) = inside.bounds();
    let depth = (0.5 * (min + max) - inside.scene.camera.to_world.translation).dot(forward);
    inside.scene.camera.to_world.translation += forward * (0.9 * depth);
    inside.scene.camera.near = 0.3 * depth;
    let mut part = box_();
    part.scene.camera.film.crop = Some(render::scene::Crop { x: 7, y: 11, width: 33, height: 21 });
    for (name, world) in [("parallel", parallel), ("lens", lens), ("inside", inside), ("part", part)] {
        let ([octree, splat], records) = both(&world, "eas", 1);
        assert!(records > 20 && octree.image().pixels == splat.image().pixels, "{name}: {records} records");
        assert!(octree.image().pixels.iter().any(|p| p[0] > 0.0), "{name}: black");
    }
}

/// The number of threads makes no difference.
#[test]
fn splatted_pictures_do_not_depend_on_threads() {
    let world = world("cornell-glossy.xml", &SMALL);
    let [one, three] = [1, 3].map(|threads| both(&world, "auto", threads).0[1].image().pixels);
    assert!(one == three);
}
