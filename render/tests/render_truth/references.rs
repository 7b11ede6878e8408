//! Converged images of another renderer (Mitsuba 3), where the folder `shared/scenes` lies beside the checkout.

use render::film::render;
use render::image::read;
use render::integrator::PathTracer;
use render::picture::Budget;
use render::scene::load;
use render::world::World;
use std::path::{Path, PathBuf};

fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes").join(name);
    if !path.exists() {
        eprintln!("skipped: {name} is not beside the checkout");
        return None;
    }
    Some(path)
}

/// The bias of the whole picture and of each of 8 × 8 blocks, in standard errors, estimated from the differences
/// inside the block; Šidák's correction for the number of blocks gives the limit.
fn agrees(scene: &str, spp: u32, largest_bias: f64) {
    let (Some(file), Some(reference)) = (shared(&format!("{scene}.xml")), shared(&format!("{scene}-ref.exr"))) else {
        return;
    };
    let reference = read(&reference).unwrap();
    let (scene, _) = load::load(&file, &load::Options::default()).unwrap();
    let tracer = PathTracer { settings: scene.integrator, indirect_only: false };
    let world = World::new(scene).unwrap();
    let picture = render(&world, &tracer, Budget::Samples(spp), 5, &|_| ()).image();
    let (w, h) = (reference.width as usize, reference.height as usize);
    assert_eq!((picture.width, picture.height), (reference.width, reference.height));
    let value = |p: &[f32; 3]| f64::from(p[0] + p[1] + p[2]);
    let mean = reference.pixels.iter().map(value).sum::<f64>() / (w * h) as f64;
    let difference: Vec<f64> = picture.pixels.iter().zip(&reference.pixels).map(|(a, b)| value(a) - value(b)).collect();
    let bias = difference.iter().sum::<f64>() / (w * h) as f64 / mean;
    assert!(bias.abs() <= largest_bias, "{}: bias {bias}", file.display());
    let n = 8;
    for block in 0..n * n {
        let (bx, by) = (block % n, block / n);
        let inside =
            (by * h / n..(by + 1) * h / n).flat_map(|y| (bx * w / n..(bx + 1) * w / n).map(move |x| y * w + x));
        let values: Vec<f64> = inside.map(|i| difference[i]).collect();
        let count = values.len() as f64;
        let m = values.iter().sum::<f64>() / count;
        let error = (values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / count / count).sqrt();
        // 4.5 standard errors: one run in 2300 fails by chance over 64 blocks.
        assert!(m.abs() <= 4.5 * error + 1e-3 * mean, "{}: block {bx},{by}: {m} ± {error}", file.display());
    }
}

#[test]
fn glossy_cornell_box() {
    agrees("cornell/fig12", 32, 0.005);
}

#[test]
fn diffuse_cornell_box() {
    agrees("cornell/diffuse", 16, 0.005);
}
