//! Nanoseconds per look-up, preparation included, on one core: `cargo bench -p brdf-tables`.
//!
//! The caps are a record's: 128 of them tile the hemisphere, three quarters of them small; each iteration takes a new view.
//! divan reports items (caps × views) per second; the inverse is the time per (EAS, ω).

use brdf_tables::axis::Axes;
use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::{Distribution, Fresnel, Microfacet, Phong, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::{Cubature, RULES, Rule};
use brdf_tables::family;
use brdf_tables::lobe::Lobe;
use brdf_tables::lobes::Lobes;
use brdf_tables::mean::{Exact, MeanBrdf};
use brdf_tables::table::Table;
use brdf_tables::zonal::Zonal;
use core::f64::consts::{PI, TAU};
use divan::{Bencher, counter::ItemsCount};
use glam::{DVec3, Vec3};

fn main() {
    divan::main();
}

/// Caps of a record: elevation and azimuth by a golden-angle spiral, of equal projected area, Ω between 2π/512 and 2π/64.
fn record() -> CapBatch {
    let caps: Vec<Cap> = (0..128)
        .map(|i| {
            let theta = ((i as f64 + 0.5) / 128.0).sqrt().asin();
            let omega = TAU / if i % 4 == 0 { 64.0 } else { 512.0 };
            Cap::new(theta, 2.399_963 * i as f64, omega).expect("in the domain")
        })
        .collect();
    caps.iter().collect()
}

/// Views over the hemisphere.
fn views() -> Vec<Vec3> {
    let view = |i: i32| {
        let (z, phi) = (0.1 + 0.9 * (i as f32 + 0.5) / 64.0, 2.4 * i as f32);
        let s = (1.0 - z * z).sqrt();
        Vec3::new(s * phi.cos(), s * phi.sin(), z)
    };
    (0..64).map(view).collect()
}

fn run(bencher: Bencher, mean: &dyn MeanBrdf) {
    let (caps, views) = (record(), views());
    let mut out = vec![0.0; caps.len()];
    bencher.counter(ItemsCount::new(caps.len() * views.len())).bench_local(|| {
        for &wo in &views {
            mean.values(divan::black_box(&caps), wo, &mut out);
        }
        out[0]
    });
}

fn phong(exponent: f64) -> Specular {
    Specular::Phong(Phong { exponent })
}

fn facets(distribution: Distribution, alpha: f64) -> Specular {
    Specular::Microfacet(Microfacet { distribution, alpha_x: alpha, alpha_y: alpha, fresnel: Fresnel::None })
}

/// The arithmetic of a zonal table does not depend on its numbers.
#[divan::bench(args = [20.0, 100.0, 500.0])]
fn zonal(bencher: Bencher, exponent: f64) {
    let cells = (0..48 * 32).map(|i| i * 37 % 65536).collect();
    let table = Zonal::new(phong(exponent), 48, 32, cells, [[0.0, 1.5e-5]; 2]).expect("sizes fit");
    run(bencher, &table);
}

/// Neither does that of a lobe table.
#[divan::bench(args = [4, 8, 12])]
fn lobes(bencher: Bencher, count: usize) {
    let axes = Axes { theta: 16, phi: 1, omega: 16, sharpness: 100.0, stretch: 1.0 };
    let lobe = Lobe { axis: DVec3::Z, amplitude: 1.0, exponent: 100.0 };
    let table = Lobes::from_nodes(axes, &vec![vec![lobe; count]; axes.len()]).expect("valid lobes");
    run(bencher, &table);
}

/// The shipped tables, as a renderer uses them.
#[divan::bench(args = ["phong-20", "phong-100", "beckmann-0.2", "ggx-0.1", "ggx-0.3", "sheen-0.3", "ward-0.1-0.5", "lafortune-metal"])]
fn shipped(bencher: Bencher, name: &str) {
    let path = format!("{}/../tables/{name}.tbl", env!("CARGO_MANIFEST_DIR"));
    let table = Table::load(&path).expect("a shipped table");
    run(bencher, table.mean().expect("a glossy material"));
}

/// The same materials by the families that the library brings.
#[divan::bench(args = ["phong-20", "phong-100", "beckmann-0.2", "ggx-0.1", "ggx-0.3"])]
fn of_a_family(bencher: Bencher, name: &str) {
    run(bencher, family_table(name).mean().expect("a glossy material"));
}

/// A table of one's own, of measured data for example: `TABLE=satin.tbl cargo bench -p brdf-tables -- named`.
#[divan::bench]
fn named(bencher: Bencher) {
    match std::env::var_os("TABLE") {
        None => println!("no TABLE is named"),
        Some(path) => {
            let table = Table::load(path).expect("TABLE is a table");
            run(bencher, table.mean().expect("a glossy material"));
        }
    }
}

/// Making such a table.
#[divan::bench(args = ["phong-100", "ggx-0.3", "ggx-0.1"])]
fn family_table_made(bencher: Bencher, name: &str) {
    let material = family_table(name).header.material;
    bencher.bench_local(|| family::table(divan::black_box(&material)));
}

/// The table of the recipe of a shipped one.
fn family_table(name: &str) -> Table {
    let path = format!("{}/../tables/{name}.tbl", env!("CARGO_MANIFEST_DIR"));
    let recipe = Table::load(path).expect("a shipped table").header.material;
    family::table(&recipe).expect("a member of a family")
}

/// One rule everywhere.
#[divan::bench(args = RULES)]
fn cubature_ggx(bencher: Bencher, rule: Rule) {
    run(bencher, &Cubature::uniform(facets(Distribution::Ggx, 0.2), rule));
}

#[divan::bench(args = RULES)]
fn cubature_beckmann(bencher: Bencher, rule: Rule) {
    run(bencher, &Cubature::uniform(facets(Distribution::Beckmann, 0.2), rule));
}

#[divan::bench(args = [Rule::Product(4), Rule::Product(6)])]
fn cubature_phong(bencher: Bencher, rule: Rule) {
    run(bencher, &Cubature::uniform(phong(100.0), rule));
}

/// The reference, for scale; a few caps only.
#[divan::bench(sample_count = 5)]
fn exact(bencher: Bencher) {
    let mean = Exact { specular: phong(100.0), tolerance: 1e-3 };
    let cap = Cap::new(0.25 * PI, 0.0, PI / 100.0).expect("in the domain");
    let wo = DVec3::new(-0.7, 0.0, 0.714).normalize();
    bencher.counter(ItemsCount::new(1usize)).bench_local(|| mean.value(divan::black_box(&cap), wo));
}
