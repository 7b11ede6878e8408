//! Real scenes, where the folder `shared/scenes` lies beside the checkout: each loads as it stands.

use render::scene::{Environment, Geometry, Material, Scene, load};
use std::path::PathBuf;
use std::time::Instant;

/// The scene, or `None` with a printed line where the folder is absent.
fn load_shared(name: &str) -> Option<(Scene, Vec<String>)> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes").join(name);
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
        return None;
    }
    let start = Instant::now();
    let loaded = load::load(&path, &load::Options::default()).unwrap_or_else(|e| panic!("{e}"));
    println!("{name}: {:.3} s", start.elapsed().as_secs_f64());
    Some(loaded)
}

fn triangles(scene: &Scene) -> usize {
    let count = |s: &render::scene::Shape| match &s.geometry {
        Geometry::Mesh(m) => m.triangles.len(),
        Geometry::Sphere(_) => 0,
    };
    scene.shapes.iter().map(count).sum()
}

#[test]
fn cornell_boxes_load() {
    for name in ["fig12", "floor-n5", "floor-n20", "floor-n40", "floor-n100", "floor-n200", "diffuse"] {
        let Some((scene, warnings)) = load_shared(&format!("cornell/{name}.xml")) else { return };
        assert_eq!((triangles(&scene), warnings.as_slice()), (36, &[][..]), "{name}");
        assert_eq!(scene.camera.film.width, 256);
        assert_eq!(scene.integrator.max_depth, 8);
        assert_eq!(scene.shapes.iter().filter(|s| s.emitter.is_some()).count(), 1);
    }
}

#[test]
fn matpreview_loads() {
    let Some((scene, warnings)) = load_shared("matpreview/matpreview-n40.xml") else { return };
    // The meshes hold 61 600 triangles.
    assert!(triangles(&scene) > 61_000, "{}", triangles(&scene));
    assert!(matches!(&scene.environment, Some(Environment::Map(m)) if m.scale == 3.0));
    assert_eq!(warnings.len(), 0, "{warnings:#?}");
}

#[test]
fn dragon_loads() {
    let Some((scene, warnings)) = load_shared("dragon/dragon.xml") else { return };
    assert!(triangles(&scene) > 100_000, "{}", triangles(&scene));
    assert!(warnings.is_empty(), "{warnings:#?}");
}

#[test]
fn staircase_loads() {
    let Some((scene, warnings)) = load_shared("staircase2/scene.xml") else { return };
    // 2 400 of the 30 927 triangles are degenerate: poles of spheres.
    assert!(triangles(&scene) > 28_000, "{}", triangles(&scene));
    assert!(scene.materials.iter().any(|m| matches!(m, Material::RoughPlastic { .. })));
    assert!(warnings.iter().all(|w| w.contains("scene.xml:")), "{warnings:#?}");
}

#[test]
fn kitchenette_loads() {
    let Some((scene, warnings)) = load_shared("kitchenette/scene.xml") else { return };
    assert!(triangles(&scene) > 250_000, "{}", triangles(&scene));
    // usePathGuiding of three materials, alpha of three smooth ones: nothing else is unknown.
    assert!(
        warnings
            .iter()
            .all(|w| w.contains("`use_path_guiding`") || w.contains("`alpha`") || w.contains("without area")),
        "{warnings:#?}"
    );
}
