//! Tables in shaders: the text is WGSL, and what it computes is what the library says.

use super::present;
use brdf_tables::brdf::{Distribution, Fresnel, Microfacet, Phong, Specular};
use brdf_tables::wgsl::{Buffer, Tables, source};
use brdf_tables::{Cap, Material, Table, family};
use fitter::fit::{Choice, Options, fit};
use fitter::solver::SolverKind;
use glam::{DVec3, Vec3};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use render::gpu::Device;

fn check(text: &str) {
    let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    let checked = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    checked.unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
}

/// The text is valid, whichever way the buffer is declared.
#[test]
fn source_is_valid() {
    let entry = "@compute @workgroup_size(1) fn main() {
        numbers[0] = mean_brdf(0u, vec3f(0.6, 0.0, 0.8), 0.1, vec3f(-0.6, 0.0, 0.8));
    }";
    let out = "@group(1) @binding(7) var<storage, read_write> numbers: array<f32>;";
    check(&format!("{}\n{out}\n{entry}", source(&Buffer::Bound { group: 1, binding: 6 })));
    let own = "@group(1) @binding(6) var<storage, read> tables: array<u32>;";
    check(&format!("{}\n{own}\n{out}\n{entry}", source(&Buffer::Named("tables"))));
}

const LOOK_UP: &str = "
struct Query { axis: vec3f, solid_angle: f32, wo: vec3f, table: u32 }
@group(0) @binding(1) var<storage, read> queries: array<Query>;
@group(0) @binding(2) var<storage, read_write> means: array<f32>;
@compute @workgroup_size(64) fn look_up(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&queries) {
        let q = queries[id.x];
        means[id.x] = mean_brdf(q.table, q.axis, q.solid_angle, q.wo);
    }
}";

/// A query as the shader takes it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Query {
    axis: Vec3,
    solid_angle: f32,
    wo: Vec3,
    table: u32,
}

/// Half of the views within a few lobe widths of the highlight, caps of any size, a third of them across the horizon.
fn query(table: &Table, place: u32, rng: &mut Xoshiro256PlusPlus) -> Query {
    let width = table.specular().map_or(1.0, Specular::lobe_width);
    let mut direction = |z: f64| {
        let (s, c) = (core::f64::consts::TAU * rng.random::<f64>()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * c, r * s, z)
    };
    let (cap, view, about) = (direction(0.0), direction(0.0), direction(0.0));
    let axis = (cap * rng.random::<f64>() + DVec3::Z * rng.random::<f64>()).normalize();
    let near = DVec3::new(-axis.x, -axis.y, axis.z) + 3.0 * width * rng.random::<f64>() * about;
    let wo = if rng.random() { near } else { view + DVec3::Z * rng.random_range(0.01..3.0) };
    let wo = wo.with_z(wo.z.abs().max(1e-3)).normalize();
    let sigma = width * 10f64.powf(rng.random_range(-2.0..0.5));
    let solid_angle = core::f64::consts::TAU * (1.0 - sigma.min(1.57).cos()).max(1e-9);
    Query { axis: axis.as_vec3(), solid_angle: solid_angle as f32, wo: wo.as_vec3(), table: place }
}

/// Those of the folder, of families, and of every model as lobes or whatever it takes.
fn tables() -> Vec<(String, Table)> {
    let names = [
        "phong-20",
        "phong-40",
        "phong-100",
        "phong-500",
        "ggx-0.1",
        "ggx-0.3",
        "beckmann-0.2",
        "ward-0.1-0.5",
        "sheen-0.3",
        "lafortune-metal",
    ];
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tables/");
    let mut all: Vec<(String, Table)> =
        names.iter().map(|n| (n.to_string(), Table::load(format!("{folder}{n}.tbl")).unwrap())).collect();
    let facets = |distribution, alpha_x, alpha_y, fresnel| {
        Specular::Microfacet(Microfacet { distribution, alpha_x, alpha_y, fresnel })
    };
    let gold = Fresnel::Conductor { eta: [0.143, 0.375, 1.442], k: [3.983, 2.386, 1.603] };
    for (name, specular) in [
        ("family of GGX, gold", facets(Distribution::Ggx, 0.15, 0.15, gold)),
        ("family of Beckmann", facets(Distribution::Beckmann, 0.1, 0.3, Fresnel::Schlick { f0: [0.04; 3] })),
        ("family of Phong", Specular::Phong(Phong { exponent: 321.0 })),
    ] {
        all.push((name.into(), family::table(&Material::specular(specular)).expect(name)));
    }
    let coarse = Options {
        representation: Choice::Lobes,
        solver: SolverKind::LevenbergMarquardt,
        lobes: None,
        tolerance: 0.02,
        seed: 1,
        command: String::new(),
        progress: &|_| core::ops::ControlFlow::Continue(()),
    };
    let lobes = Material::specular(facets(Distribution::Ggx, 0.3, 0.3, Fresnel::None));
    all.push(("lobes ggx 0.3".into(), fit(&lobes, &coarse).unwrap()));
    all
}

/// 10⁵ look-ups of each table, in single precision, against the library's in double precision.
#[test]
fn shaders_look_up_what_the_library_does() {
    const QUERIES: usize = 100_000;
    let Some(device) = present(Device::open()) else { return };
    println!("{}", device.name());
    let mut buffer = Tables::new();
    let tables: Vec<(String, Table, u32)> = tables()
        .into_iter()
        .map(|(name, table)| {
            let place = buffer.push(&table).unwrap();
            (name, table, place)
        })
        .collect();
    let program = device.program(&(source(&Buffer::Bound { group: 0, binding: 0 }) + LOOK_UP));
    let words = device.upload("tables", buffer.words()).unwrap();
    for (name, table, place) in &tables {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let queries: Vec<Query> = (0..QUERIES).map(|_| query(table, *place, &mut rng)).collect();
        let (asked, means) =
            (device.upload("queries", &queries).unwrap(), device.room("means", 4 * QUERIES as u64).unwrap());
        device.run(&program, &[&words, &asked, &means], [QUERIES.div_ceil(64) as u32, 1, 1]);
        let found: Vec<f32> = device.read(&means).unwrap();
        let mean = table.mean().unwrap();
        let exact: Vec<f64> = queries
            .par_iter()
            .map(|q| {
                let cap = Cap::from_axis(q.axis.as_dvec3(), q.solid_angle.into()).unwrap();
                mean.value(&cap, q.wo.as_dvec3().normalize())
            })
            .collect();
        // Relative to the value, or to a thousandth of the largest where it is less.
        let top = exact.iter().copied().fold(0.0, f64::max);
        let off = |(found, exact): (&f32, &f64)| (f64::from(*found) - exact).abs() / exact.max(1e-3 * top);
        let mut errors: Vec<f64> = found.iter().zip(&exact).map(off).collect();
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[((QUERIES - 1) as f64 * share) as usize];
        println!(
            "{name}: median {:.1e}, 99 % {:.1e}, 99.9 % {:.1e}, worst {:.1e}",
            at(0.5),
            at(0.99),
            at(0.999),
            at(1.0)
        );
        // Single precision leaves less in faint tails, at the horizon, and in caps whose rim passes a pole of the rule's coordinates.
        let edges = errors.iter().filter(|e| **e > 1e-4).count();
        assert!(at(0.99) < 1e-5 && at(0.999) < 1e-4 && edges <= 50 && at(1.0) < 0.02, "{name}: {edges} off");
    }
}
