//! The albedo: at most 1, near 1 for smooth white models, and above 1 exactly where an exception says so.

use super::hemisphere::albedo;
use super::{examples, views};
use brdf_tables::brdf::{ALL, Exception};
use glam::DVec3;

const THETAS_DEG: [f64; 12] = [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0, 88.0, 89.0, 89.7, 89.98];

#[test]
fn albedo_at_most_one_and_exceptions_real() {
    let mut worst = vec![0f64; ALL.len()];
    for (model, specular, name) in examples() {
        let at = ALL.iter().position(|m| m.name == model.name).unwrap();
        for wo in views(&specular, &THETAS_DEG) {
            let albedo = albedo(&specular, wo);
            worst[at] = worst[at].max(albedo);
            let excused = model.exceptions.contains(&Exception::AlbedoAboveOne);
            assert!(albedo <= 1.0 + 1e-4 || excused, "{name}: albedo {albedo} from {wo}");
        }
    }
    for (model, worst) in ALL.iter().zip(worst) {
        println!("{}: largest albedo {worst:.4}", model.name);
        let excused = model.exceptions.contains(&Exception::AlbedoAboveOne);
        assert!(!excused || worst > 1.5, "{} is excused from energy but reaches only {worst}", model.name);
    }
}

/// A white furnace: a smooth surface without Fresnel loss returns what it receives, but for three models whose formula
/// lacks a factor 1/cos and which return the cosine's share of it.
#[test]
fn smooth_models_are_white() {
    let mut seen = 0;
    for (model, specular, name) in examples() {
        if specular.lobe_width() > 0.02 {
            continue;
        }
        seen += 1;
        for wo in views(&specular, &[0.0, 30.0, 60.0]) {
            let albedo = albedo(&specular, wo);
            let expected = if ["phong", "lafortune", "ward-1992"].contains(&model.name) { wo.z } else { 1.0 };
            assert!((albedo - expected).abs() < 2e-3, "{name}: albedo {albedo} from {wo}");
        }
    }
    assert!(seen >= 5, "only {seen} smooth white examples");
}

/// The energy check of materials agrees with the quadrature: at normal incidence a material is accepted just below
/// albedo 1 and refused just above.
#[test]
fn validation_knows_the_normal_albedo() {
    use brdf_tables::material::{Material, MaterialError};
    for (_, specular, name) in examples() {
        let rest = 1.0 - albedo(&specular, DVec3::Z);
        let with = |kd: f64| Material { kd: [0.0, kd, 0.0], ..Material::specular(specular) }.validate();
        if specular.tint(DVec3::Z, DVec3::Z) != [1.0; 3] {
            continue; // the channels differ from the grey albedo
        }
        assert_eq!(with((rest - 2e-3).max(0.0)), Ok(()), "{name}");
        if rest + 3e-3 < 1.0 {
            assert!(matches!(with(rest + 3e-3), Err(MaterialError::Energy { channel: 'g', .. })), "{name} {rest}");
        }
    }
}
