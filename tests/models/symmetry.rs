//! Helmholtz reciprocity, positivity, darkness below the horizon, and what a model says about its own symmetry.

use super::{examples, uniform_direction};
use brdf_tables::brdf::Brdf;
use brdf_tables::frame::{basis, mirror, spherical};
use core::f64::consts::TAU;
use glam::{DMat3, DVec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Pairs of directions: half of them anywhere, half of them within two lobe widths of the mirror direction.
fn pairs(width: f64) -> impl Iterator<Item = (DVec3, DVec3)> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    (0..2000).filter_map(move |at| {
        let wo = uniform_direction(&mut rng);
        let offset = spherical(2.0 * width * rng.random::<f64>(), TAU * rng.random::<f64>());
        let wi = if at % 2 == 0 { uniform_direction(&mut rng) } else { basis(mirror(wo)) * offset };
        (wi.z > 0.0).then_some((wi, wo))
    })
}

#[test]
fn reciprocal_and_positive() {
    for (_, specular, name) in examples() {
        let mut bright = 0;
        for (wi, wo) in pairs(specular.lobe_width()) {
            let (there, back) = (specular.eval(wi, wo), specular.eval(wo, wi));
            assert!(there >= 0.0, "{name}: {there} for {wi} {wo}");
            assert!((there - back).abs() <= 1e-12 * there + f64::MIN_POSITIVE, "{name}: {there} {back} for {wi} {wo}");
            bright += usize::from(there > 0.0);
        }
        assert!(bright > 500, "{name}: only {bright} pairs reflect");
    }
}

#[test]
fn nothing_below_the_horizon() {
    for (_, specular, name) in examples() {
        for (wi, wo) in pairs(specular.lobe_width()) {
            let below = DVec3::new(wi.x, wi.y, -wi.z);
            for (a, b) in [(below, wo), (wo, below)] {
                assert_eq!(specular.eval(a, b), 0.0, "{name}");
            }
            assert_eq!(specular.pdf(below, wo), 0.0, "{name}");
        }
    }
}

/// Turning both directions about the normal changes an anisotropic model and no other.
#[test]
fn isotropy_is_as_stated() {
    let turn = DMat3::from_rotation_z(0.9);
    for (_, specular, name) in examples() {
        let change = |(wi, wo)| {
            let (a, b) = (specular.eval(wi, wo), specular.eval(turn * wi, turn * wo));
            if a + b > 0.0 { (a - b).abs() / (a + b) } else { 0.0 }
        };
        let worst = pairs(specular.lobe_width()).map(change).fold(0.0, f64::max);
        // Near the top of a lobe of exponent 1e4 rounding is magnified as often.
        assert_eq!(worst < 1e-8, specular.is_isotropic(), "{name}: change {worst}");
    }
}

/// A model that states `(amplitude, exponent)` is that power of the cosine from the mirror direction.
#[test]
fn radial_models_are_powers() {
    let mut seen = 0;
    for (_, specular, name) in examples() {
        let Some((amplitude, exponent)) = specular.radial_exponent() else { continue };
        seen += 1;
        for (wi, wo) in pairs(specular.lobe_width()) {
            let expected = amplitude * mirror(wo).dot(wi).max(0.0).powf(exponent);
            assert!((specular.eval(wi, wo) - expected).abs() < 1e-9 * amplitude, "{name}");
        }
    }
    assert!(seen >= 7);
}
