//! Conformance of the reflection models: every test goes through `brdf::ALL` and its examples.

mod closed_form;
mod energy;
mod hemisphere;
mod lanes;
mod recipes;
mod sampling;
mod symmetry;

use brdf_tables::brdf::{ALL, Model, Specular};
use brdf_tables::material::Material;
use glam::DVec3;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Every example of every model, with the text that names it in a failure.
fn examples() -> impl Iterator<Item = (&'static Model, Specular, String)> {
    ALL.iter().flat_map(|model| {
        let named = move |specular| (model, specular, format!("{} ({})", model.name, Material::specular(specular)));
        (model.examples)().into_iter().map(named)
    })
}

/// Directions to look from: the normal, the slant, and grazing; three azimuths for an anisotropic model.
fn views(specular: &Specular, thetas_deg: &[f64]) -> Vec<DVec3> {
    let azimuths: &[f64] = if specular.is_isotropic() { &[0.3] } else { &[0.0, 0.8, core::f64::consts::FRAC_PI_2] };
    let view = |theta: f64, phi| brdf_tables::frame::spherical(theta.to_radians(), phi);
    thetas_deg.iter().flat_map(|&theta| azimuths.iter().map(move |&phi| view(theta, phi))).collect()
}

/// A direction uniform over the upper hemisphere.
fn uniform_direction(rng: &mut Xoshiro256PlusPlus) -> DVec3 {
    let z: f64 = 1.0 - rng.random::<f64>();
    brdf_tables::frame::spherical(z.acos(), core::f64::consts::TAU * rng.random::<f64>())
}
