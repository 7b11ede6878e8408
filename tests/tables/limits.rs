//! The limits that must hold: small caps, the whole hemisphere, Lambert, energy, and every corner of the domain.

use super::{any_cap, examples, fitted, lit_direction, phong, representations, rng, scientific, synthetic_lobes};
use brdf_tables::brdf::{Brdf, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::frame::{mirror, spherical};
use brdf_tables::gauss::gauss_legendre;
use brdf_tables::material::Material;
use brdf_tables::mean::{Exact, MeanBrdf};
use brdf_tables::quadrature::mean_brdf;
use brdf_tables::table::{Representation, Table};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use fitter::fit::{Choice, Options, TOLERANCE, fit};
use fitter::integrate::mean_brdf_mc;
use fitter::solver::SolverKind;
use glam::DVec3;
use rand::RngExt;
use std::sync::LazyLock;

/// Ω → 0 gives f_r(axis, wo), for every model and representation.
#[test]
fn small_caps_give_the_brdf() {
    let mut worst = [0f64; 5];
    for (specular, name) in examples() {
        let tables = representations(specular);
        let mut rng = rng(1);
        for _ in 0..30 {
            let cap = Cap::new(1.5 * rng.random::<f64>(), TAU * rng.random::<f64>(), 1e-11).unwrap();
            let wo = lit_direction(&specular, &cap, &mut rng);
            let f = specular.eval(cap.axis(), wo);
            let scale = specular.eval(cap.axis(), mirror(cap.axis())).max(f);
            let monte_carlo = mean_brdf_mc(&specular, &cap, wo, 64, 1).value;
            let quadrature = mean_brdf(&specular, &cap, wo, 1e-9, 0.0);
            let values = [quadrature, monte_carlo].into_iter().chain(tables.iter().rev().map(|t| t.value(&cap, wo)));
            for (i, (value, bound)) in values.zip([1e-4, 1e-4, 1e-4, 1e-4, 1e-3]).enumerate() {
                let off = (value - f).abs() / scale;
                worst[i] = worst[i].max(off);
                assert!(off < bound, "{name}, way {i}: {value} instead of {f}, {off:.1e} of the peak");
            }
        }
    }
    eprintln!("off f_r, of the peak: quadrature, Monte Carlo, patchwork, cubature, zonal: {}", scientific(&worst));
}

/// ρ(wo) by Gauss–Legendre in the zenith angle and midpoints in azimuth: a rule that knows nothing of caps.
fn albedo(specular: &Specular, wo: DVec3) -> f64 {
    static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(300));
    let spokes = 256;
    let ring = |theta: f64| {
        let wi = (0..spokes).map(|i| spherical(theta, TAU * (f64::from(i) + 0.5) / f64::from(spokes)));
        wi.map(|wi| specular.eval(wi, wo)).sum::<f64>() * theta.sin() * theta.cos() * TAU / f64::from(spokes)
    };
    RULE.iter().map(|&(x, weight)| 0.5 * FRAC_PI_2 * weight * ring(0.5 * FRAC_PI_2 * (1.0 + x))).sum()
}

/// Ω = 2π at θe = 0 gives ρ(wo)/π.
#[test]
fn the_whole_hemisphere_gives_the_albedo() {
    let whole = Cap::new(0.0, 0.0, TAU).unwrap();
    let mut worst = [0f64; 4];
    for (specular, name) in examples().filter(|(s, _)| s.lobe_width() > 0.05) {
        let tables = representations(specular);
        for (theta, phi) in [(0.0, 0.0), (0.5, 0.4), (1.1, 2.0)] {
            let wo = spherical(theta, phi);
            let exact = albedo(&specular, wo) / PI;
            let monte_carlo = mean_brdf_mc(&specular, &whole, wo, 1 << 14, 1).value;
            let quadrature = mean_brdf(&specular, &whole, wo, 1e-8, 0.0);
            // The finest cubature, then the zonal table; not the patchwork.
            let values =
                [quadrature, monte_carlo].into_iter().chain(tables.iter().rev().skip(1).map(|t| t.value(&whole, wo)));
            // 3e-3 for lobes; the ring of a sheen of α = .07 around the horizon, 1e-4 bright, takes 4e-3 of itself.
            for (i, (value, bound)) in values.zip([2e-4, 2e-3, 5e-3, 3e-3]).enumerate() {
                let off = (value / exact - 1.0).abs();
                worst[i] = worst[i].max(off);
                assert!(off < bound, "{name}, way {i}, theta_o {theta}: {value} instead of {exact}, off {off:.1e}");
            }
        }
    }
    eprintln!("off the albedo: quadrature, Monte Carlo, cubature, zonal: {}", scientific(&worst));
}

#[test]
fn lambert_is_exact_and_not_fitted() {
    let rho = [0.8, 0.25, 0.0];
    let command = String::new();
    let options = Options {
        representation: Choice::Auto,
        solver: SolverKind::LevenbergMarquardt,
        lobes: None,
        tolerance: TOLERANCE,
        seed: 1,
        command,
        progress: &|_| core::ops::ControlFlow::Continue(()),
    };
    let table = fit(&Material::lambert(rho), &options).unwrap();
    assert!(matches!(table.representation, Representation::Diffuse) && table.cells.is_empty());
    let bytes = table.to_bytes().unwrap();
    assert!(bytes.len() < 1024, "{} bytes for nothing", bytes.len());
    // Beside a specular part it is as exact.
    let coated = Material { kd: rho, ks: [0.0; 3], ..Material::specular(phong(20.0)) };
    let coated = Table {
        header: brdf_tables::table::Header { material: coated, ..fitted(phong(20.0), Choice::Zonal).header },
        ..fitted(phong(20.0), Choice::Zonal)
    };
    let mut rng = rng(4);
    for _ in 0..2000 {
        let (cap, wo) =
            (any_cap(&mut rng), spherical(0.999 * FRAC_PI_2 * rng.random::<f64>(), TAU * rng.random::<f64>()));
        for table in [&table, &coated] {
            for (value, rho) in table.value(&cap, wo).into_iter().zip(rho) {
                assert!((value - rho / PI).abs() <= 1e-6 * rho, "{value} instead of {rho}/pi");
            }
        }
    }
}

/// Finite and not negative in every corner of the domain: caps that vanish or fill the hemisphere, on the normal and on
/// the horizon, seen from the normal, the mirror direction, and along the surface; scalar and batch.
#[test]
fn finite_in_every_corner() {
    let sharpest = [1e-3, 0.01].map(|alpha| super::microfacet(brdf_tables::brdf::Distribution::Ggx, alpha, 1.0));
    let specular = examples().map(|e| e.0).chain([0.0, 3.0, 1e5].map(phong)).chain(sharpest);
    let mut caps = Vec::new();
    for theta in [0.0, 1e-9, 0.7, 1.5, FRAC_PI_2 - 1e-9, FRAC_PI_2] {
        for omega in [1e-13, 1e-5, 0.1, 3.0, TAU] {
            caps.extend([FRAC_PI_2, 2.5].map(|phi| Cap::new(theta, phi, omega).unwrap()));
        }
    }
    let batch = caps.iter().collect();
    let mut out = vec![0f32; caps.len()];
    for specular in specular {
        let lobes: Box<dyn MeanBrdf> = Box::new(synthetic_lobes(specular.lobe_width().powi(-2), 1, 5));
        for table in representations(specular).into_iter().chain([lobes]) {
            for (z, azimuths) in [(1.0, &[0.0][..]), (0.7, &[0.0, 2.5 - PI]), (1e-6, &[PI, -FRAC_PI_2, 2.5 - PI])] {
                for &phi in azimuths {
                    let wo = spherical(f64::acos(z), phi).with_z(z).normalize();
                    let finite = |value: f64| value.is_finite() && value >= 0.0;
                    for cap in &caps {
                        let value = table.value(cap, wo);
                        assert!(finite(value), "{} of {specular:?}: {value} for {cap:?}, {wo}", table.name());
                    }
                    table.values(&batch, wo.as_vec3(), &mut out);
                    let bad = out.iter().position(|&value| !finite(value.into()));
                    assert_eq!(bad.map(|i| caps[i]), None, "batch of {} of {specular:?}, {wo}", table.name());
                }
            }
            let below = DVec3::new(0.6, 0.0, -0.8);
            assert_eq!(table.value(&caps[9], below), 0.0);
            table.values(&batch, below.as_vec3(), &mut out);
            assert!(out.iter().all(|&value| value == 0.0));
        }
    }
}

/// Disjoint caps reflect no more than the whole hemisphere: Σ F ∫cosθi ≤ ρ(wo), and what they reflect is what quadrature
/// says; and caps that grow to the hemisphere reflect ever more.
#[test]
fn parts_of_the_hemisphere_share_its_energy() {
    // A spiral of caps, none nearer to another than their diameter.
    let count = 60;
    let centre = |i: usize| spherical((1.0 - (i as f64 + 0.5) / count as f64).acos(), i as f64 * 2.399_963_229_728_653);
    let axes: Vec<DVec3> = (0..count).map(centre).collect();
    let nearest = (0..count).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| axes[i].angle_between(axes[j]));
    let radius = 0.5 * nearest.fold(f64::MAX, f64::min);
    let caps: Vec<Cap> =
        axes.iter().map(|a| Cap::with_half_angle(a.z.acos(), a.y.atan2(a.x), radius).unwrap()).collect();
    let reflected =
        |mean: &dyn MeanBrdf, wo| caps.iter().map(|c| c.projected_solid_angle() * mean.value(c, wo)).sum::<f64>();
    let mut worst = 0f64;
    for (specular, name) in examples().filter(|(s, _)| s.lobe_width() > 0.05) {
        for wo in [spherical(0.2, 0.0), spherical(1.0, 2.0), spherical(1.4, 4.0)] {
            let rho = albedo(&specular, wo);
            let exact = reflected(&Exact { specular, tolerance: 1e-4 }, wo);
            assert!(exact < rho && exact > 0.3 * rho, "{name}: {exact} of {rho}");
            for table in representations(specular).iter().rev().skip(1) {
                let sum = reflected(&**table, wo);
                worst = worst.max((sum - exact).abs() / rho);
                assert!(
                    sum <= rho && (sum - exact).abs() < 5e-3 * rho,
                    "{} of {name}: {sum}, {exact}, {rho}",
                    table.name()
                );
                let mut before = 0.0;
                for step in 1..=20 {
                    let cap = Cap::with_half_angle(0.0, 0.0, FRAC_PI_2 * f64::from(step) / 20.0).unwrap();
                    let now = table.value(&cap, wo) * cap.projected_solid_angle();
                    assert!(now >= before - 2e-3 * rho, "{} of {name}: {before} falls to {now}", table.name());
                    before = now;
                }
                assert!(before < 1.01 * rho, "{} of {name}, {wo}: {before} of {rho}", table.name());
            }
        }
    }
    eprintln!("sum over {count} caps of radius {radius:.3}: off by {worst:.1e} of the albedo");
}
