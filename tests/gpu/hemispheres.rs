//! Hemispheres rasterised onto a plane by a graphics card, or by what stands in for one, against those by rays.

use super::present;
use render::camera::RayGenerator;
use render::color::luminance;
use render::gpu;
use render::hemisphere::{Border, Plane};
use render::integrator::plane::{PlaneError, Rasterizer, SurfaceLight, Viewpoint};
use render::scene::{Rgb, load};
use render::world::World;
use std::path::Path;

/// A scene of `tests/`.
fn world(scene: &str) -> World {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(scene);
    World::new(load::load(&path, &load::Options::default()).expect("our scenes load").0).expect("they are valid")
}

/// Some of what the film shows.
fn viewpoints(world: &World, count: u32) -> Vec<Viewpoint> {
    let generator = RayGenerator::new(&world.scene.camera);
    let film = &world.scene.camera.film;
    let pixel = |i: u32| [0.618_034, 0.414_214].map(|step| (i as f32 * step).fract());
    let seen = (0..count).filter_map(|i| {
        let [x, y] = pixel(i);
        let at = |x: f32, size: u32| ((x * size as f32) as u32).min(size - 1);
        let ray = generator.ray(at(x, film.width), at(y, film.height), glam::Vec2::splat(0.5));
        let hit = world.intersect(&ray);
        hit.exists().then(|| Viewpoint::on(&world.interaction(&ray, &hit)))
    });
    seen.collect()
}

/// Boxes, spheres, placed copies, many triangles: a cell in a hundred differs at most, at silhouettes, which rounding or the facets of spheres
/// decide, and irradiances by no more than what such a cell weighs; what the card sums is what its cells add up to.
#[test]
fn cells_and_irradiances_are_those_of_rays() {
    let Some(device) = present(gpu::shared()) else { return };
    println!("{}", device.name());
    let mut lit = 0;
    for scene in [
        "scenes/cornell-diffuse.xml",
        "scenes/anisotropic-sphere.xml",
        "scenes/principled.xml",
        "scenes/room.glb",
        "inputs/valid/gltf-instances/turned.gltf",
        "inputs/valid/gltf-instances/lit.gltf",
        "inputs/valid/gltf-instances/scaled.gltf",
    ] {
        let world = world(scene);
        let light = SurfaceLight::new(&world, 20_000, 1).expect("these have no holes");
        let card = Rasterizer::new(&world, &light).expect("there is room for them");
        // In most scenes more than are drawn at once.
        let viewpoints = viewpoints(&world, 100);
        assert!(!viewpoints.is_empty(), "{scene}");
        for (side, height, border, bound) in
            [(64, 0.25, Border::Extended, 0.04), (33, 1.0, Border::Rescaled, 0.04), (16, 0.5, Border::Black, 0.06)]
        {
            let plane = Plane::new(side, height, border);
            let [traced, drawn] = [
                light.pictures(&world, &viewpoints, &plane),
                card.pictures(&viewpoints, &plane).expect("the card works"),
            ];
            assert!(
                traced.len() == drawn.len()
                    && traced.iter().chain(&drawn).all(|cells| cells.len() as u32 == side * side)
            );
            let cells = || traced.iter().flatten().zip(drawn.iter().flatten());
            let differ = cells().filter(|(a, b)| a != b).count() as f64 / cells().count() as f64;
            let [a, b]: [Vec<Rgb>; 2] = [
                light.irradiances(&world, &viewpoints, &plane),
                card.irradiances(&viewpoints, &plane).expect("the card works"),
            ];
            let mean = a.iter().map(|e| luminance(*e)).sum::<f32>() / a.len() as f32;
            let off: Vec<f32> =
                a.iter().zip(&b).map(|(a, b)| (*a - *b).abs().max_element() / mean.max(f32::MIN_POSITIVE)).collect();
            let root = (off.iter().map(|x| x * x).sum::<f32>() / off.len() as f32).sqrt();
            let worst = off.iter().copied().fold(0.0, f32::max);
            println!(
                "{scene}, {side}² at {height}: {:.3} % of the cells differ, irradiances by {root:.1e}, at most {worst:.1e}",
                100.0 * differ
            );
            assert!(differ < 0.01 && root < bound, "{scene}: {mean}");
            lit += u32::from(mean > 0.0);
            let weights = plane.weights();
            for (picture, irradiance) in drawn.iter().zip(&b) {
                let off = (light.sum(picture, &weights) - *irradiance).abs().max_element();
                assert!(off <= 1e-5 * irradiance.max_element().max(mean), "{scene}: off by {off}");
            }
            assert_eq!(card.irradiances(&viewpoints, &plane), Ok(b), "{scene}: other numbers the second time");
        }
    }
    assert!(lit >= 12, "{lit} rows with light");
}

/// What would be drawn otherwise than it is, is not drawn.
#[test]
fn holes_are_refused() {
    let world = world("inputs/valid/masks/layers.xml");
    assert_eq!(SurfaceLight::new(&world, 100, 1).err(), Some(PlaneError::Holes));
}
