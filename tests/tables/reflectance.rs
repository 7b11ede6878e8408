//! Facets whose reflectance is not that of the table: the rules of a shape serve any Fresnel term.

use super::{lit_direction, rng, synthetic_lobes};
use brdf_tables::axis::Axes;
use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::{Brdf, Distribution, Fresnel, Microfacet, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::Cubature;
use brdf_tables::errors::Summary;
use brdf_tables::material::Material;
use brdf_tables::table::{Header, Representation, Table};
use fitter::check::{Sampling, errors_of, random_caps};
use fitter::fit::Choice;

fn plastic(alpha: f64, f0: f64) -> Specular {
    let fresnel = Fresnel::Schlick { f0: [f0; 3] };
    Specular::Microfacet(Microfacet { distribution: Distribution::Ggx, alpha_x: alpha, alpha_y: alpha, fresnel })
}

/// A table of plastic has the rules for all of glTF: its errors are at most three times those of a table of its own.
#[test]
fn a_table_of_plastic_serves_any_reflectance() {
    for alpha in [0.05, 0.2, 0.5] {
        let table = super::fitted(plastic(alpha, 0.04), Choice::Cubature);
        let Representation::Cubature(cubature) = &table.representation else { panic!("a cubature was asked for") };
        let (axes, nodes) = cubature.parts();
        for f0 in [0.02, 0.2, 1.0] {
            let specular = plastic(alpha, f0);
            let other = Cubature::new(specular, axes, nodes).expect("the nodes of a table");
            let caps = random_caps(&specular, Sampling::Main, 20, &mut rng(4));
            let errors: Vec<_> = caps.iter().map(|cap| errors_of(&other, &specular, cap)).collect();
            let Summary { median, worst, .. } = Summary::new(&errors);
            println!(
                "α = {alpha}, f0 = {f0}: rmse_lobe {} to {}, albedo {}",
                median.rmse_lobe, worst.rmse_lobe, worst.albedo
            );
            assert!(
                median.rmse_lobe < 0.003 && worst.rmse_lobe < 0.015 && worst.albedo < 0.015,
                "{alpha} {f0}: {worst:?}"
            );
            // What a renderer calls is that cubature.
            let batch: CapBatch = caps.iter().collect();
            let wo = lit_direction(&specular, &caps[0], &mut rng(5)).as_vec3();
            let (mut found, mut wanted) = (vec![0.0; caps.len()], vec![0.0; caps.len()]);
            table.values_with_fresnel(Fresnel::Schlick { f0: [f0; 3] }, &batch, wo, &mut found);
            brdf_tables::mean::MeanBrdf::values(&other, &batch, wo, &mut wanted);
            assert_eq!(found, wanted, "{alpha} {f0}");
        }
    }
}

/// Where values are stored, the reflectance at the cap's axis replaces that of the table.
#[test]
fn stored_values_are_scaled() {
    let axes = Axes { theta: 2, phi: 1, omega: 2, sharpness: 1.0, stretch: 1.0 };
    let own = plastic(0.3, 0.04);
    let header =
        Header { material: Material::specular(own), ..super::fitted(super::phong(20.0), Choice::Zonal).header };
    let representation = Representation::Lobes(synthetic_lobes(30.0, 1, 4));
    let table = Table { header, representation, axes, cells: Vec::new() };
    let caps: Vec<Cap> = [0.1, 0.7, 1.3].map(|theta| Cap::with_half_angle(theta, 2.0, 0.05).expect("a cap")).to_vec();
    let (batch, wo) = (caps.iter().collect::<CapBatch>(), brdf_tables::frame::spherical(0.8, -1.1));
    let (mut own_values, mut found) = ([0.0; 3], [0.0; 3]);
    table.specular_values(&batch, wo.as_vec3(), &mut own_values);
    table.values_with_fresnel(Fresnel::None, &batch, wo.as_vec3(), &mut found);
    for (i, cap) in caps.iter().enumerate() {
        let mirror = Microfacet { fresnel: Fresnel::None, ..facets(own) };
        let ratio = mirror.eval(cap.axis(), wo) / own.eval(cap.axis(), wo);
        assert!((f64::from(found[i]) / (f64::from(own_values[i]) * ratio) - 1.0).abs() < 1e-4, "{i}");
    }
}

fn facets(specular: Specular) -> Microfacet {
    let Specular::Microfacet(facets) = specular else { panic!("facets") };
    facets
}
