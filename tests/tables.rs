//! The mean BRDF: three truths that agree, the errors of every representation, and what happens where methods fail.

mod batch;
mod continuity;
mod determinism;
mod families;
mod family_format;
mod figures;
mod format;
mod fuzz;
mod limits;
mod paper;
mod reflectance;
mod shipped;
mod support;
mod symmetry;
mod truths;

use brdf_tables::axis::Axes;
use brdf_tables::brdf::{ALL, Distribution, Fresnel, Microfacet, Phong, Specular, Ward, WardVariant};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::{Cubature, NONE, Node, Rule};
use brdf_tables::frame::{basis, mirror, spherical};
use brdf_tables::lobe::Lobe;
use brdf_tables::lobes::Lobes;
use brdf_tables::material::Material;
use brdf_tables::mean::MeanBrdf;
use brdf_tables::table::Table;
use core::f64::consts::{FRAC_PI_2, TAU};
use core::ops::ControlFlow;
use fitter::fit::{Choice, Options, TOLERANCE, fit};
use fitter::solver::SolverKind;
use glam::DVec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Every example of every model, with the text that names it in a failure.
fn examples() -> impl Iterator<Item = (Specular, String)> {
    let named = |specular| (specular, Material::specular(specular).recipe_text());
    ALL.iter().flat_map(|model| (model.examples)()).map(named)
}

fn phong(exponent: f64) -> Specular {
    Specular::Phong(Phong { exponent })
}

fn ward(alpha_x: f64, alpha_y: f64, variant: WardVariant) -> Specular {
    Specular::Ward(Ward { alpha_x, alpha_y, variant })
}

fn microfacet(distribution: Distribution, alpha_x: f64, alpha_y: f64) -> Specular {
    Specular::Microfacet(Microfacet { distribution, alpha_x, alpha_y, fresnel: Fresnel::None })
}

fn rng(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// The default fit of a material at unit strength, but for the representation.
fn fitted(specular: Specular, representation: Choice) -> Table {
    fitted_with(specular, representation, SolverKind::LevenbergMarquardt, None)
}

fn fitted_with(specular: Specular, representation: Choice, solver: SolverKind, lobes: Option<usize>) -> Table {
    let command = "test".into();
    let options = Options {
        representation,
        solver,
        lobes,
        tolerance: TOLERANCE,
        seed: 1,
        command,
        progress: &|_| ControlFlow::Continue(()),
    };
    fit(&Material::specular(specular), &options).unwrap()
}

/// A cap anywhere in the domain, its radius log-uniform from a thousandth of a radian.
fn any_cap(rng: &mut impl Rng) -> Cap {
    let sigma = FRAC_PI_2 * 1e-3f64.powf(rng.random());
    Cap::with_half_angle(FRAC_PI_2 * rng.random::<f64>(), TAU * rng.random::<f64>(), sigma).unwrap()
}

/// A direction about as far from the mirrored cap as the reflected lobe reaches, above the horizon.
fn lit_direction(specular: &Specular, cap: &Cap, rng: &mut impl Rng) -> DVec3 {
    let reach = cap.half_angle() + 2.0 * specular.lobe_width();
    loop {
        let offset = spherical((reach * rng.random::<f64>()).min(3.0), TAU * rng.random::<f64>());
        let wo = basis(mirror(cap.axis())) * offset;
        if wo.z > 1e-3 {
            return wo;
        }
    }
}

/// A cubature whose rule changes from cell to cell.
fn patchwork(specular: Specular) -> Cubature {
    let phi = if specular.is_isotropic() { 1 } else { 3 };
    let axes = Axes { theta: 5, phi, omega: 6, sharpness: specular.lobe_width().powi(-2), stretch: 0.5 };
    let (disc, product) = (|i: usize| [0, 1, 5, NONE][i * 7 % 4], |i: usize| [7, 9, 14][i % 3]);
    let nodes: Vec<Node> =
        (0..axes.len()).map(|i| Node { disc: disc(i), product: product(i), outer: 120, far: 200 }).collect();
    Cubature::new(specular, axes, &nodes).unwrap()
}

/// A lobe table out of nobody's fit, for what must hold whatever the coefficients. Like a fitted one it has one value at the
/// normal and is symmetric where the azimuth is mirrored.
fn synthetic_lobes(sharpness: f64, phi: u32, count: usize) -> Lobes {
    let axes = Axes { theta: 6, phi, omega: 7, sharpness, stretch: 1.0 };
    let node = |i: usize| {
        let (omega, azimuth, theta) = (i % 7, i / 7 % phi as usize, i / (7 * phi as usize));
        let (tilt, i) = if theta == 0 { (0.0, omega) } else { (1.0, i) };
        let aside = if azimuth == 0 || azimuth + 1 == phi as usize { 0.0 } else { tilt };
        let lobe = |k: usize| Lobe {
            axis: DVec3::new(0.1 * tilt * ((i + 2 * k) % 5) as f64, 0.05 * aside * (k % 3) as f64, 1.0).normalize(),
            amplitude: [1.0, -0.2, 0.5][k % 3] * (1.0 + (i % 4) as f64),
            exponent: sharpness * (1.0 + 0.2 * ((i + k) % 6) as f64),
        };
        (0..count).map(lobe).collect()
    };
    Lobes::from_nodes(axes, &(0..axes.len()).map(node).collect::<Vec<_>>()).unwrap()
}

/// Every representation that can hold a model without a fit.
fn representations(specular: Specular) -> Vec<Box<dyn MeanBrdf>> {
    let zonal = fitter::zonal::build(specular, 64, 48).map(|table| Box::new(table) as Box<dyn MeanBrdf>);
    let finest = Cubature::uniform(specular, Rule::Product(16));
    zonal.into_iter().chain([Box::new(finest) as _, Box::new(patchwork(specular)) as _]).collect()
}

/// Numbers for a printed line.
fn scientific(values: &[f64]) -> String {
    values.iter().map(|x| format!("{x:.1e}")).collect::<Vec<_>>().join(", ")
}
