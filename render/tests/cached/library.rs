//! The front door: the example runs and is short, the light it tells is that of the sum over the hemisphere, and what it cannot
//! do it refuses.

use brdf_tables::brdf::{Brdf, Phong};
use brdf_tables::table::Table;
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::Vec3A;
use render::cache::Grid;
use render::frame::Frame;
use render::glossy::{GlossyCache, GlossyError, Spot};
use render::hemisphere::{Incident, hemisphere_directions};
use render::record::Scratch;
use std::path::Path;

#[allow(dead_code)]
#[path = "../../examples/cache_library.rs"]
mod example;

const GRID: Grid = Grid { width: 40, height: 30 };

fn table() -> Table {
    Table::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("../tables/phong-100.tbl")).expect("the table is shipped")
}

/// A floor seen at a slant.
fn spot(pixel: usize) -> Option<Spot> {
    let (x, y) = (pixel as u32 % GRID.width, pixel as u32 / GRID.width);
    let position = Vec3A::new(0.05 * (x as f32 - 19.5), 0.05 * (14.5 - y as f32), 0.0);
    Some(Spot {
        position,
        frame: Frame::from_normal(Vec3A::Z),
        wo: (Vec3A::new(0.0, -2.0, 1.5) - position).normalize(),
        material: 0,
        diffuse: Vec3A::new(0.1, 0.2, 0.3),
        specular: Vec3A::splat(0.6),
        footprint: 0.05,
    })
}

/// A ceiling whose light changes as fast as the lobe can tell.
fn ceiling(from: Vec3A, direction: Vec3A) -> Incident {
    let distance = 2.0 / direction.z.max(1e-4);
    let x = (from + direction * distance).x;
    Incident { radiance: Vec3A::splat(1.0 + 4.0 * (-(2.0 * x).powi(2)).exp()), distance, normal: -Vec3A::Z }
}

fn filled(tolerance: f32, light: impl Fn(Vec3A, Vec3A) -> Incident + Sync) -> GlossyCache {
    let corners = (Vec3A::splat(-2.0), Vec3A::splat(2.0));
    let mut cache = GlossyCache::new(corners, vec![table()], tolerance).expect("a glossy table");
    cache.fill(GRID, 7, spot, |s, direction, _| light(s.position, direction));
    cache
}

/// The reflected light as a sum over the hemisphere, by the model itself.
fn truth(s: &Spot, light: impl Fn(Vec3A, Vec3A) -> Incident) -> Vec3A {
    let (phong, wo) = (Phong { exponent: 100.0 }, s.frame.to_local(s.wo).as_dvec3());
    let directions = hemisphere_directions(200_000);
    let term = |wi: &Vec3A| {
        let brdf = s.diffuse * FRAC_1_PI + s.specular * phong.eval(wi.as_dvec3(), wo) as f32;
        light(s.position, s.frame.to_world(*wi)).radiance * brdf * wi.z
    };
    directions.iter().map(term).sum::<Vec3A>() * (TAU / directions.len() as f32)
}

/// The error is about τ, and falls with it; light that is the same everywhere is exact but for the table.
#[test]
fn the_light_is_that_of_the_hemisphere() {
    let even = |_: Vec3A, _: Vec3A| Incident { radiance: Vec3A::ONE, distance: 2.0, normal: -Vec3A::Z };
    let spots: Vec<Spot> = (0..1200).step_by(37).filter_map(spot).collect();
    let mut scratch = Scratch::default();
    let mut error = |cache: &GlossyCache, s: &Spot, truth: Vec3A| {
        let found = cache.light(s, &mut scratch).expect("a record reaches every spot");
        assert!(found.trust > 0.8, "{} at {}", found.trust, s.position);
        found.radiance / truth - 1.0
    };
    let (furnace, caches) = (filled(0.02, even), [0.02, 0.005].map(|tolerance| filled(tolerance, ceiling)));
    let mut squares = [0.0; 2];
    for s in &spots {
        let off = error(&furnace, s, truth(s, even)).abs().max_element();
        assert!(off < 0.01, "{off} at {}", s.position);
        let truth = truth(s, ceiling);
        for (sum, cache) in squares.iter_mut().zip(&caches) {
            *sum += error(cache, s, truth).length_squared() / 3.0;
        }
    }
    let [coarse, fine] = squares.map(|sum| (sum / spots.len() as f32).sqrt());
    assert!(coarse < 0.025 && fine < 0.01 && fine < 0.7 * coarse, "{coarse} {fine}");
    let records = caches.map(|cache| cache.records().records().len());
    assert!(records[0] >= 10 && records[1] > records[0] && records[1] < 1200, "{records:?}");
}

/// Same records for any number of threads, and none more where all is covered.
#[test]
fn filling_is_repeatable() {
    let text = |cache: &GlossyCache| format!("{:?}", cache.records().records());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let (mut many, one) = (filled(0.02, ceiling), pool.install(|| filled(0.02, ceiling)));
    assert_eq!(text(&many), text(&one));
    many.fill(GRID, 8, spot, |s, direction, _| ceiling(s.position, direction));
    assert_eq!(text(&many), text(&one));
}

#[test]
fn what_is_no_glossy_surface_is_refused() {
    let corners = (Vec3A::splat(-2.0), Vec3A::splat(2.0));
    let diffuse = Table::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden/diffuse.tbl")).unwrap();
    assert_eq!(GlossyCache::new(corners, vec![table(), diffuse], 0.02).unwrap_err(), GlossyError::Diffuse(1));
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(GlossyCache::new(corners, vec![table()], bad), Err(GlossyError::Tolerance(_))), "{bad}");
    }
    let cache = filled(0.02, |_, _| Incident { radiance: Vec3A::NAN, distance: f32::NAN, normal: Vec3A::NAN });
    let mut scratch = Scratch::default();
    let some = spot(0).unwrap();
    assert_eq!(cache.light(&some, &mut scratch).map(|l| l.radiance), Some(Vec3A::ZERO));
    assert_eq!(cache.light(&Spot { material: 1, ..some }, &mut scratch), None);
    assert_eq!(cache.light(&Spot { wo: -some.wo, ..some }, &mut scratch), None);
    assert_eq!(cache.light(&Spot { position: Vec3A::splat(1.9), ..some }, &mut scratch), None);
}

#[test]
fn the_example_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source = std::fs::read_to_string(root.join("examples/cache_library.rs")).expect("the example is there");
    assert!(source.lines().count() < 60);
    let text = example::run(&root.join("../tables/phong-100.tbl").to_string_lossy()).expect("the table is shipped");
    assert!(text.contains(" 3072 pixels") && !text.contains("NaN"), "{text}");
    assert!(example::run("absent.tbl").is_err());
}
