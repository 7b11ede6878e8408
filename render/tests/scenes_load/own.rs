//! The project's own scenes: all load without a warning, and are what they say.

use crate::error as scene_error;
use glam::{Vec3, Vec3A};
use render::scene::{ColorTexture, Environment, FloatTexture, Geometry, Material, Mesh, Scene, Shape, load};
use std::path::{Path, PathBuf};

#[path = "../../examples/scene_assets.rs"]
#[allow(dead_code)]
mod scene_assets;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes")
}

fn own(name: &str, defines: &[(&str, &str)]) -> Scene {
    let defines = defines.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
    let options = load::Options { defines, ..load::Options::default() };
    let (scene, warnings) = load::load(&folder().join(name), &options).unwrap_or_else(|e| panic!("{e}"));
    assert!(warnings.is_empty(), "{name}: {warnings:#?}");
    scene
}

/// Scene files of a folder.
fn scenes(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = files.filter(|n| n.ends_with(".xml")).collect();
    names.sort();
    names
}

fn mesh(shape: &Shape) -> &Mesh {
    match &shape.geometry {
        Geometry::Mesh(mesh) => mesh,
        Geometry::Sphere(_) => panic!("a mesh is expected"),
    }
}

/// Shininess of the front material of a shape.
fn exponent(scene: &Scene, shape: &Shape) -> Option<f32> {
    let Material::TwoSided { front, .. } = scene.materials[shape.material.0 as usize] else { return None };
    match scene.materials[front.0 as usize] {
        Material::Phong { exponent: FloatTexture::Constant(n), .. } => Some(n),
        _ => None,
    }
}

#[test]
fn every_scene_loads_without_a_warning() {
    let mut count = 0;
    for (prefix, path) in [("", folder()), ("failure/", folder().join("failure"))] {
        for name in scenes(&path) {
            let scene = own(&format!("{prefix}{name}"), &[]);
            assert!(!scene.shapes.is_empty() && scene.camera.film.width <= 512, "{name}");
            count += 1;
        }
    }
    assert!(count >= 35, "{count}");
}

#[test]
fn glossy_cornell_box() {
    let scene = own("cornell-glossy.xml", &[("width", "64"), ("max_depth", "3")]);
    assert_eq!((scene.camera.film.width, scene.integrator.max_depth), (64, 3));
    // Lamp, floor, ceiling, back, left, right, short, tall.
    let shininess: Vec<_> = scene.shapes.iter().map(|s| exponent(&scene, s)).collect();
    assert_eq!(shininess, [None, None, None, Some(100.0), None, None, Some(40.0), Some(200.0)]);
    // Fronts look into the room, those of the boxes out of them.
    for (i, shape) in scene.shapes.iter().enumerate() {
        let mesh = mesh(shape);
        let middle = |t: &[Vec3]| t.iter().sum::<Vec3>() / t.len() as f32;
        let inside = if i < 6 { Vec3::new(2.78, 2.74, 2.79) } else { middle(&mesh.positions) };
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let front = (b - a).cross(c - a).dot(inside - middle(&[a, b, c]));
            assert!(if i < 6 { front > 0.0 } else { front < 0.0 }, "shape {i}");
        }
    }
    // The published spectra under daylight, and the lamp's warm light.
    let albedo = |name: &str| {
        let i = scene.material_names.iter().position(|n| n == name).unwrap();
        let Material::Diffuse { reflectance: ColorTexture::Constant(c) } = scene.materials[i] else { panic!() };
        c
    };
    let near = |a: Vec3A, b: [f32; 3], tolerance: f32| (a - Vec3A::from(b)).abs().max_element() < tolerance;
    assert!(near(albedo("white"), [0.735, 0.735, 0.73], 0.02), "{}", albedo("white"));
    assert!(albedo("red").x > 5.0 * albedo("red").y && albedo("green").y > 2.0 * albedo("green").x);
    let lamp = scene.shapes[0].emitter.as_ref().unwrap().radiance.mean(&[]);
    assert!(near(lamp, [20.71, 10.85, 2.77], 0.02), "{lamp}");
}

#[test]
fn spectra_agree_with_mitsuba() {
    // Mitsuba's RGB mode, which weights reflectances with equal energy in version 0.x, has published these values.
    let reflectance = |name: &str| {
        let path = folder().join(format!("cornell/{name}.spd"));
        let body = format!(
            "<scene version='0.6.0'><sensor type='perspective'/><shape type='sphere'><bsdf type='diffuse'>
             <spectrum name='reflectance' filename='{}'/></bsdf></shape></scene>",
            path.display()
        );
        let (scene, _) = crate::Folder::new().with("s.xml", body).load("s.xml", &[]).unwrap();
        let Material::Diffuse { reflectance: ColorTexture::Constant(c) } = scene.materials[0] else { panic!() };
        c
    };
    for (name, expected) in [
        ("white", [0.885809, 0.698859, 0.666422]),
        ("green", [0.105421, 0.37798, 0.076425]),
        ("red", [0.570068, 0.0430135, 0.0443706]),
    ] {
        let got = reflectance(name);
        assert!((got - Vec3A::from(expected)).abs().max_element() < 2e-3, "{name}: {got}, not {expected:?}");
    }
}

#[test]
fn floors_of_every_shininess() {
    for n in [5, 20, 40, 100, 200, 500] {
        let scene = own(&format!("floor-n{n}.xml"), &[]);
        assert_eq!(exponent(&scene, &scene.shapes[1]), Some(n as f32));
    }
    let scene = own("floor.xml", &[("n", "7.5")]);
    assert_eq!(exponent(&scene, &scene.shapes[1]), Some(7.5));
}

#[test]
fn scaled_and_moved_boxes_are_the_same_box() {
    let reference = own("cornell-glossy.xml", &[]);
    for (name, scale, shift) in [("scaled-down", 1e-3, 0.0), ("scaled-up", 1e3, 0.0), ("moved", 1.0, 1e4)] {
        let scene = own(&format!("failure/{name}.xml"), &[]);
        let change = |p: Vec3| p * scale + Vec3::X * shift;
        let tolerance = 1e-5 * scale + 1e-7 * shift;
        for (a, b) in reference.shapes.iter().zip(&scene.shapes) {
            let pairs = mesh(a).positions.iter().zip(&mesh(b).positions);
            assert!(pairs.into_iter().all(|(a, b)| (change(*a) - *b).abs().max_element() <= tolerance), "{name}");
        }
        let eye = |s: &Scene| Vec3::from(s.camera.to_world.translation);
        assert!((change(eye(&reference)) - eye(&scene)).abs().max_element() <= tolerance, "{name}");
    }
}

#[test]
fn assets_are_what_the_example_makes() {
    let scene = own("preview.xml", &[]);
    let Some(Environment::Map(map)) = &scene.environment else { panic!() };
    assert_eq!((map.image.width, map.image.height), (128, 64));
    assert!((0..map.image.texels.len()).any(|i| map.image.texels.get(i).x > 100.0), "the sky has a sun");
    // Turned by 12 degrees about z, as in the scene.
    let turn = glam::Affine3A::from_rotation_z(12f32.to_radians());
    let (ball, made) = (mesh(&scene.shapes[1]), scene_assets::body().transformed(turn));
    let close = ball.positions.iter().zip(&made.positions).all(|(a, b)| (*a - *b).length() < 1e-5);
    assert!(close && ball.triangles == made.triangles);
    assert_eq!(mesh(&scene.shapes[2]).triangles, scene_assets::foot().triangles);
    // Fronts face outwards.
    for t in &made.triangles {
        let [a, b, c] = t.map(|v| made.positions[v as usize]);
        assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
    }
    let dark = own("failure/bright-texel.xml", &[]);
    let Some(Environment::Map(map)) = &dark.environment else { panic!() };
    let bright = (0..map.image.texels.len()).filter(|&i| map.image.texels.get(i).x > 100.0).count();
    assert_eq!(bright, 1);
}

#[test]
fn a_scene_outside_the_folder_cannot_use_names_of_it() {
    assert!(scene_error("<include filename='cornell/box.xml'/>").contains("cornell/box.xml: cannot read"));
}

#[test]
fn mutated_scenes_never_panic() {
    let scene = std::fs::read(folder().join("materials.xml")).unwrap();
    let object = std::fs::read(folder().join("assets/object.serialized")).unwrap();
    let folder = crate::Folder::new().with("assets/object.serialized", object);
    let mut state = 1u64;
    for _ in 0..400 {
        let mut damaged = scene.clone();
        for _ in 0..4 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let at = (state >> 33) as usize % damaged.len();
            match state >> 20 & 3 {
                0 => damaged[at] = b' ' + (state >> 24) as u8 % 96,
                1 => drop(damaged.remove(at)),
                2 => damaged.insert(at, b"0-9.e<>\"/ $"[(state >> 24) as usize % 11]),
                _ => damaged.truncate(at.max(damaged.len() - 40)),
            }
        }
        std::fs::write(folder.path("s.xml"), damaged).unwrap();
        folder.load("s.xml", &[]).ok();
    }
}
