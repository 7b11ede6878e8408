//! What each of the numbers behind τ costs and buys: rays, time, records, memory and error where it is made smaller and larger.
//! Rays, records and errors are the same on any machine.
//! `cargo run --release -p burnish-render --example knobs -- [SCENE [WIDTH [TAU]]]`

use render::cache::Spacing;
use render::film::render;
use render::integrator::PathTracer;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Interpolation, Knobs, Settings, render_with};
use render::metric::compare;
use render::picture::Budget;
use render::record::eas::Estimator;
use render::scene::load;
use render::tables::Tables;
use render::world::World;
use std::error::Error;
use std::path::Path;

/// Factors on a number, 1 as it is.
const FACTORS: [f32; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// A number by name.
type Knob = (&'static str, fn(&mut Knobs) -> &mut f32);

/// Those of [`Knobs`] that our estimator uses.
const KNOBS: [Knob; 15] = [
    ("irradiance_rays", |k| &mut k.irradiance_rays),
    ("irradiance.scale", |k| &mut k.irradiance.scale),
    ("irradiance.min_pixels", |k| &mut k.irradiance.min_pixels),
    ("irradiance.max_pixels", |k| &mut k.irradiance.max_pixels),
    ("coarse_rays", |k| &mut k.coarse_rays),
    ("coarse.scale", |k| &mut k.coarse.scale),
    ("coarse.min_pixels", |k| &mut k.coarse.min_pixels),
    ("coarse.max_pixels", |k| &mut k.coarse.max_pixels),
    ("rays_per_cell", |k| &mut k.rays_per_cell),
    ("fineness", |k| &mut k.fineness),
    ("glossy.scale", |k| &mut k.glossy.scale),
    ("glossy.min_pixels", |k| &mut k.glossy.min_pixels),
    ("glossy.max_pixels", |k| &mut k.glossy.max_pixels),
    ("cut", |k| &mut k.cut),
    ("curvature", |k| &mut k.curvature),
];

/// Samples of the reference, and of the picture where a material is traced.
const REFERENCE_SPP: u32 = 4096;
const SPP: u32 = 16;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let scene = words.next().map_or_else(|| root.join("tests/scenes/cornell-glossy.xml"), Into::into);
    let width: u32 = words.next().map_or(Ok(64), |w| w.parse())?;
    let tolerance: f32 = words.next().map_or(Ok(0.02), |w| w.parse())?;
    let (mut scene, _) = load::load(&scene, &load::Options::default())?;
    let film = &mut scene.camera.film;
    (film.height, film.width, film.crop) = ((width * film.height).div_ceil(film.width), width, None);
    let world = World::new(scene)?;
    let mut tables = Tables::open(&root.join("tables"))?;
    let policy = Policy::new(&world.scene, Allowed::Eas, |recipe| tables.find(recipe))?;
    let settings = Settings {
        tolerance: Some(tolerance),
        estimator: Estimator::Improved,
        spacing: Spacing::default(),
        sources: None,
        budget: Budget::Samples(SPP),
        seed: 1,
        // Direct light has noise of its own.
        indirect_only: true,
        interpolation: Interpolation::Auto,
    };
    let integrator = PathTracer { settings: world.scene.integrator, indirect_only: true };
    let reference = render(&world, &integrator, Budget::Samples(REFERENCE_SPP), 7, &|_| ()).image();
    println!(
        "{:22} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>10} {:>8}",
        "number", "value", "Mrays", "fill s", "shade s", "records", "KB", "rel_mse", "bias %"
    );
    for (name, knob) in KNOBS {
        for factor in FACTORS {
            let mut knobs = Knobs::default();
            *knob(&mut knobs) *= factor;
            let (picture, figures, caches) = render_with(&world, &policy, &settings, &knobs, None, &|_| ());
            let error = compare(&picture.image(), &reference)?;
            let mark = if factor == 1.0 { "  as it is" } else { "" };
            println!(
                "{name:22} {:8.3} {:8.3} {:8.2} {:8.2} {:8} {:8} {:10.6} {:8.2}{mark}",
                *knob(&mut knobs),
                1e-6 * caches.counts.rays as f64,
                figures.fill.as_secs_f64(),
                figures.shade.as_secs_f64(),
                figures.records(),
                figures.bytes / 1000,
                error.rel_mse,
                100.0 * error.bias
            );
        }
    }
    Ok(())
}
