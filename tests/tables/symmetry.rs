//! What the surface is symmetric about, every representation is.

use super::{any_cap, examples, lit_direction, representations, rng, synthetic_lobes};
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::mean::MeanBrdf;
use core::f64::consts::{FRAC_PI_2, TAU};
use glam::{DMat3, DVec3};

fn moved(cap: &Cap, by: DMat3) -> Cap {
    let axis = by * cap.axis();
    Cap::new(axis.z.acos(), axis.y.atan2(axis.x), cap.solid_angle()).unwrap()
}

/// Largest change under a motion of cap and direction, over the largest value met.
fn change(mean: &dyn MeanBrdf, specular: &Specular, by: DMat3) -> f64 {
    let mut rng = rng(11);
    let (mut worst, mut largest) = (0f64, 0f64);
    for _ in 0..60 {
        let cap = any_cap(&mut rng);
        // Away from the poles of the angles, where they lose digits.
        let cap = Cap::new(cap.theta().clamp(0.01, FRAC_PI_2 - 0.01), cap.phi(), cap.solid_angle()).unwrap();
        let wo = lit_direction(specular, &cap, &mut rng);
        let (a, b) = (mean.value(&cap, wo), mean.value(&moved(&cap, by), by * wo));
        worst = worst.max((a - b).abs() / a.max(b).max(1e-3));
        largest = largest.max(a);
    }
    assert!(largest > 0.0);
    worst
}

#[test]
fn reflections_and_rotations() {
    let reflections =
        [DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(-1.0, -1.0, 1.0)].map(DMat3::from_diagonal);
    for (specular, name) in examples().filter(|(s, _)| s.lobe_width() > 0.05) {
        let sharpness = specular.lobe_width().powi(-2);
        let mut tables = representations(specular);
        tables.push(Box::new(synthetic_lobes(sharpness, if specular.is_isotropic() { 1 } else { 3 }, 3)));
        for table in tables {
            for by in reflections {
                let change = change(&*table, &specular, by);
                assert!(change < 1e-6, "{} of {name} changes by {change:.1e} under {by:?}", table.name());
            }
            // Lobes out of nobody's fit are symmetric about the plane of incidence only where the fit makes them so.
            let turned = change(&*table, &specular, DMat3::from_rotation_z(0.9));
            if specular.is_isotropic() && table.name() != "lobes" {
                assert!(turned < 1e-6, "{} of {name} changes by {turned:.1e} when turned", table.name());
            } else if !specular.is_isotropic() {
                assert!(turned > 1e-2, "{} of {name} does not see the azimuth", table.name());
            }
        }
    }
}

/// The azimuth of the cap wraps without a seam.
#[test]
fn azimuth_wraps() {
    for (specular, name) in examples().step_by(4) {
        let lobes: Box<dyn MeanBrdf> = Box::new(synthetic_lobes(specular.lobe_width().powi(-2), 3, 3));
        for table in representations(specular).into_iter().chain([lobes]) {
            for seam in [0.0, FRAC_PI_2, 2.0 * FRAC_PI_2, -FRAC_PI_2] {
                let at = |phi: f64| Cap::with_half_angle(0.8, phi, 0.5 * specular.lobe_width()).unwrap();
                let wo = lit_direction(&specular, &at(seam), &mut rng(1));
                let (before, after) = (table.value(&at(seam - 1e-9), wo), table.value(&at(seam + 1e-9), wo));
                let around = table.value(&at(seam + TAU), wo);
                assert!(
                    (before - after).abs() <= 1e-5 * before,
                    "{} of {name} at {seam}: {before} {after}",
                    table.name()
                );
                assert!(
                    (around - after).abs() <= 1e-5 * after,
                    "{} of {name} at {seam}: {around} {after}",
                    table.name()
                );
            }
        }
    }
}
