//! Facets whose reflectance is not that of the table: the rules of a shape serve any Fresnel term.

use super::{fitted, lit_direction, rng};
use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::{Distribution, Fresnel, Microfacet, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::Cubature;
use brdf_tables::errors::Summary;
use brdf_tables::table::Representation;
use fitter::check::{Sampling, errors_of, random_caps};
use fitter::fit::Choice;

fn facets(alpha: f64, fresnel: Fresnel) -> Specular {
    Specular::Microfacet(Microfacet { distribution: Distribution::Ggx, alpha_x: alpha, alpha_y: alpha, fresnel })
}

#[test]
fn a_table_of_facets_serves_any_reflectance() {
    for alpha in [0.05, 0.2, 0.5, 1.0] {
        for (name, fit) in [("none", Fresnel::None), ("0.04", Fresnel::Schlick { f0: [0.04; 3] })] {
            let table = fitted(facets(alpha, fit), Choice::Cubature);
            let Representation::Cubature(cubature) = &table.representation else { panic!("a cubature was asked for") };
            let (axes, nodes) = cubature.parts();
            for f0 in [0.0, 0.02, 0.04, 0.2, 1.0] {
                let specular = facets(alpha, Fresnel::Schlick { f0: [f0; 3] });
                let other = Cubature::new(specular, axes, nodes).expect("the nodes of a table");
                let caps = random_caps(&specular, Sampling::Main, 60, &mut rng(4));
                let errors: Vec<_> = caps.iter().map(|cap| errors_of(&other, &specular, cap)).collect();
                let summary = Summary::new(&errors);
                println!(
                    "alpha {alpha} fit {name} f0 {f0}: rmse_lobe {} {} {} albedo {}",
                    summary.median.rmse_lobe, summary.p95.rmse_lobe, summary.worst.rmse_lobe, summary.worst.albedo
                );
            }
        }
    }
}
