//! The families that the library brings: as good as they promise at widths and caps off their nodes, and quick.

use super::{any_cap, lit_direction, rng};
use brdf_tables::axis::Axes;
use brdf_tables::brdf::{Fresnel, Microfacet, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::{Cubature, Rule};
use brdf_tables::errors::Summary;
use brdf_tables::family::{Family, Kin, Lattice, Store, families, table};
use brdf_tables::material::Material;
use brdf_tables::mean::MeanBrdf;
use brdf_tables::table::Table;
use core::f64::consts::FRAC_PI_2;
use fitter::check::Sampling;
use fitter::family::{Options, Plan, check, fit, off_nodes, random_member};

fn named(family: &Family) -> String {
    Family::file_stem(family.header.kin, family.header.lattice.has_two_widths())
}

fn print(name: &str, Summary { caps, median, p95, worst }: &Summary) {
    let percent = |x: f32| 100.0 * x;
    println!(
        "{name}, {caps} caps: rmse_lobe {:.3} / {:.3} / {:.3} %, l1 {:.2}, albedo {:.2} at worst",
        percent(median.rmse_lobe),
        percent(p95.rmse_lobe),
        percent(worst.rmse_lobe),
        percent(worst.l1),
        percent(worst.albedo)
    );
}

/// They are made as planned; together they weigh less than 2 MB.
#[test]
fn families_are_made_as_planned() {
    let mut bytes = 0;
    for family in families() {
        let two_widths = family.header.lattice.has_two_widths();
        let plan = Plan::new(family.header.kin, two_widths).unwrap();
        assert_eq!(family.header.lattice, plan.lattice);
        let (axes, _, store) = family.parts();
        assert_eq!(axes, plan.error_axes);
        assert!(matches!(store, Store::Zonal(_)) || matches!(store, Store::Rules(r) if r.parts().0 == plan.axes));
        assert!(family.header.command.starts_with(&format!("fitter fit-family {}", plan.kin.name())));
        bytes += family.to_bytes().unwrap().len();
    }
    println!("{bytes} bytes");
    assert!(bytes < 2_000_000, "{bytes} bytes");
}

/// Random members and caps against the finest rule, and a few against independent integration.
#[test]
fn promises_hold_off_the_nodes() {
    for family in families() {
        let name = named(family);
        let main = off_nodes(family, Sampling::Main, 150, 77, None);
        print(&name, &main);
        let found = [main.median, main.p95, main.worst].map(|e| f64::from(e.rmse_lobe));
        assert!(found.iter().zip(family.header.promise).all(|(f, p)| *f <= p), "{name}: {found:?}");
        // The same promise as of a table fitted for one material.
        assert_eq!(family.header.promise, [0.005, 0.0125, 0.025], "{name}");
        assert!(check(family, 4, 78, &|_| ()).passed, "{name}");
    }
}

/// The rules do for metal and plastic as they promise. What reflects nothing but at grazing shines so little that its errors,
/// against a peak of its own, are up to twice as large.
#[test]
fn a_fresnel_term_needs_no_table() {
    let metal = Fresnel::Conductor { eta: [0.143, 0.375, 1.442], k: [3.983, 2.386, 1.603] };
    let schlick = |f0: f64| Fresnel::Schlick { f0: [f0; 3] };
    for family in families().iter().filter(|f| matches!(f.header.kin, Kin::Beckmann | Kin::Ggx)) {
        for (fresnel, room) in [(metal, 1.0), (schlick(0.04), 1.0), (schlick(0.0), 2.0)] {
            let main = off_nodes(family, Sampling::Main, 100, 79, Some(fresnel));
            print(&format!("{}, {fresnel:?}", named(family)), &main);
            let found = [main.median, main.p95, main.worst].map(|e| f64::from(e.rmse_lobe));
            assert!(found.iter().zip(family.header.promise).all(|(f, p)| *f <= room * p), "{found:?}");
        }
    }
}

/// A table that follows from a family is a table like any other: written, read, the same in vectors and alone.
#[test]
fn views_are_tables() {
    let mut rng = rng(80);
    for family in families() {
        for _ in 0..4 {
            let specular = random_member(family.header.kin, &family.header.lattice, &mut rng);
            let view = table(&Material::specular(specular)).unwrap();
            let back = Table::from_bytes(&view.to_bytes().unwrap()).unwrap();
            assert_eq!((&back.header, back.axes, &back.cells), (&view.header, view.axes, &view.cells));
            let exact = Cubature::uniform(specular, Rule::Product(16));
            for _ in 0..20 {
                let cap = any_cap(&mut rng);
                let wo = lit_direction(&specular, &cap, &mut rng);
                let [one, other, truth] =
                    [view.mean().unwrap(), back.mean().unwrap(), &exact as &dyn MeanBrdf].map(|m| m.value(&cap, wo));
                let mut lane = [0.0];
                view.specular_values(&[cap].iter().collect(), wo.as_vec3(), &mut lane);
                assert!((f64::from(lane[0]) - one).abs() <= 2e-3 * one + 1e-4, "{specular:?} {cap:?}: {lane:?} {one}");
                // Off the lobe's peak, errors are larger than its value.
                let bound = 0.1 * truth.max(one) + 1e-3 / specular.lobe_width().powi(2);
                assert!((one - truth).abs() < bound && (other - truth).abs() < bound, "{specular:?} {cap:?} {wo}");
            }
            assert!(view.support(&any_cap(&mut rng)).is_finite());
        }
    }
}

/// A small family of two widths.
fn small() -> Family {
    let grid = |theta, phi, omega| Axes { theta, phi, omega, sharpness: 1.0, stretch: 0.5 };
    let lattice = Lattice { widths: vec![0.1, 0.2, 0.4], reach: Some(1) };
    let plan = Plan { kin: Kin::Ggx, lattice, axes: grid(5, 3, 8), error_axes: grid(2, 3, 3) };
    fit(&plan, &Options { tolerance: 0.005, seed: 3, command: "a command".into(), progress: &|_| () })
}

/// The same arguments, the same bytes, for any number of threads; a lobe that is wider along y is the other one turned; what
/// the family promises holds.
#[test]
fn two_widths() {
    let family = small();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(small);
    assert_eq!(family.to_bytes().unwrap(), alone.to_bytes().unwrap());
    assert_eq!(family.header.promise, [0.005, 0.0125, 0.025]);
    print("two widths", &family.header.off_nodes);
    assert!(check(&family, 4, 82, &|_| ()).passed);
    let mut rng = rng(81);
    let kin = family.header.kin;
    for _ in 0..8 {
        let (_, [x, y]) = Kin::of(&random_member(kin, &family.header.lattice, &mut rng)).unwrap();
        let of = |widths| family.for_model(&Material::specular(kin.member(widths))).unwrap();
        let (one, turned) = (of([x, y]), of([y, x]));
        for _ in 0..10 {
            let cap = any_cap(&mut rng);
            let wo = lit_direction(one.specular().unwrap(), &cap, &mut rng);
            let quarter = |w: glam::DVec3| glam::DVec3::new(-w.y, w.x, w.z);
            let across = Cap::new(cap.theta(), cap.phi() + FRAC_PI_2, cap.solid_angle()).unwrap();
            let [a, b] = [(&one, &cap, wo), (&turned, &across, quarter(wo))]
                .map(|(table, cap, wo)| table.mean().unwrap().value(cap, wo));
            assert!((a - b).abs() <= 0.02 * a.max(b) + 1e-9, "{kin:?} {x} {y} {cap:?}: {a} {b}");
        }
    }
}

/// What no family holds is said so: numbers out of range, ratios too large, models without a family.
#[test]
fn what_is_out_of_range_is_refused() {
    let none = |text: &str| assert!(table(&fitter::recipe::material(text).unwrap()).is_none(), "{text}");
    for text in
        ["phong:exponent=0.5", "ggx:alpha_x=1,alpha_y=0.001", "lafortune:lobes=[[-1,-1,1,20]]", "lambert:reflectance=1"]
    {
        none(text);
    }
    for text in [
        "phong:exponent=1",
        "phong:exponent=100000",
        "ggx:alpha=1",
        "ggx:alpha=0.001",
        "sheen:alpha=0.07",
        "ward:alpha_x=0.1,alpha_y=0.1",
        "ggx:alpha_x=0.1,alpha_y=0.5",
        "beckmann:alpha_x=0.5,alpha_y=0.1",
        "ggx:alpha_x=0.02,alpha_y=0.01",
    ] {
        assert!(table(&fitter::recipe::material(text).unwrap()).is_some(), "{text}");
    }
}

/// Facets with a tint keep it.
#[test]
fn the_material_is_that_of_the_table() {
    let material = fitter::recipe::material("ggx:alpha=0.123,f0=[0.9,0.6,0.3],kd=0.1,ks=0.5").unwrap();
    let view = table(&material).unwrap();
    assert_eq!(view.header.material, material);
    assert!(matches!(view.specular(), Some(Specular::Microfacet(Microfacet { fresnel: Fresnel::Schlick { .. }, .. }))));
}
