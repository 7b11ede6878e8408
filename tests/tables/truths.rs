//! The closed form, the deterministic quadrature, Monte Carlo, and a product rule in other coordinates: one number.

use super::{any_cap, examples, lit_direction, phong, rng};
use brdf_tables::brdf::{Brdf, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::frame::spherical;
use brdf_tables::quadrature::mean_brdf;
use core::f64::consts::{FRAC_PI_2, PI};
use fitter::integrate::mean_brdf_mc;
use fitter::zonal::radial_mean;
use glam::DVec3;
use rand::RngExt;

/// Of many estimates, how many lie beyond 2 and 4 standard errors (16 replicates: Student's t has longer tails than the
/// normal distribution; 6 % and 0.1 % are expected), and the largest distance in standard errors.
#[derive(Default)]
struct Spread {
    count: usize,
    beyond_two: usize,
    beyond_four: usize,
    worst: f64,
}

impl Spread {
    fn add(&mut self, error: f64, stderr: f64, negligible: f64) {
        let distance = (error.abs() - negligible).max(0.0) / stderr.max(1e-300);
        self.count += 1;
        self.beyond_two += usize::from(distance > 2.0);
        self.beyond_four += usize::from(distance > 4.0);
        self.worst = self.worst.max(distance);
    }

    fn check(&self, name: &str) {
        let Self { count, beyond_two, beyond_four, worst } = *self;
        eprintln!(
            "{name}: of {count}, {beyond_two} beyond 2 standard errors, {beyond_four} beyond 4, worst {worst:.1}"
        );
        assert!(
            beyond_two as f64 <= 0.12 * count as f64 + 2.0,
            "{name}: {beyond_two} of {count} beyond 2 standard errors"
        );
        assert!(beyond_four as f64 <= 0.005 * count as f64 + 1.0, "{name}: {beyond_four} of {count} beyond 4");
        assert!(worst < 8.0, "{name}: {worst} standard errors off");
    }
}

#[test]
fn closed_form_quadrature_and_monte_carlo_agree() {
    let (mut spread, mut off) = (Spread::default(), 0f64);
    for n in [1.0, 3.0, 20.0, 100.0, 1000.0, 1e4] {
        let specular = phong(n);
        let radial = specular.radial_exponent().unwrap();
        let mut rng = rng(1);
        for _ in 0..40 {
            let theta = FRAC_PI_2 * rng.random::<f64>();
            let sigma = (FRAC_PI_2 - theta).min(4.0 / n.sqrt()) * rng.random::<f64>();
            let cap = Cap::with_half_angle(theta, 6.0 * rng.random::<f64>(), sigma).unwrap();
            let wo = lit_direction(&specular, &cap, &mut rng);
            let closed = radial_mean(radial, &cap, wo).unwrap();
            let quadrature = mean_brdf(&specular, &cap, wo, 1e-9, 0.0);
            // The peak of F for a cap of this size.
            let peak = radial.0 * 2.0 / (2.0 + n * sigma * sigma);
            off = off.max((closed - quadrature).abs() / peak);
            let estimate = mean_brdf_mc(&specular, &cap, wo, 1024, rng.random());
            spread.add(estimate.value - closed, estimate.stderr, 1e-9 * peak);
        }
    }
    eprintln!("closed form against quadrature: {off:.1e} of the peak");
    assert!(off < 1e-7, "quadrature is off the closed form by {off} of the peak");
    spread.check("Monte Carlo against the closed form");
}

/// Every model, caps anywhere (half of them cross the horizon), directions down to 3.6 degrees above the horizon (12 for α = 0.01).
#[test]
fn quadrature_and_monte_carlo_agree_for_every_model() {
    let mut all = Spread::default();
    for (specular, name) in examples() {
        let mut spread = Spread::default();
        let mut rng = rng(2);
        for at in 0..24 {
            let cap = match at % 2 {
                0 => any_cap(&mut rng),
                _ => {
                    let sigma = 0.02 + 0.8 * rng.random::<f64>();
                    Cap::with_half_angle(FRAC_PI_2 - 0.9 * sigma * rng.random::<f64>(), 1.0, sigma).unwrap()
                }
            };
            let mut wo = lit_direction(&specular, &cap, &mut rng);
            // At grazing the quadrature cannot resolve the thinnest lobes in the largest caps: see its documentation.
            wo.z = wo.z.max(1.0 / 16.0).max(0.003 / specular.lobe_width());
            let wo = wo.normalize();
            let exact = mean_brdf(&specular, &cap, wo, 1e-7, 0.0);
            let estimate = mean_brdf_mc(&specular, &cap, wo, 4096, rng.random());
            for s in [&mut spread, &mut all] {
                s.add(estimate.value - exact, estimate.stderr, 1e-6 * exact);
            }
        }
        spread.check(&name);
    }
    all.check("all models");
}

/// The spread over seeds is the standard error that a single run states, which shrinks faster than 1/√N.
#[test]
fn standard_error_is_honest() {
    for (specular, theta, sigma) in
        [(phong(100.0), 0.7, 0.2), (phong(3.0), 1.4, 0.6), (examples().last().unwrap().0, 1.0, 0.5)]
    {
        let cap = Cap::with_half_angle(theta, 0.4, sigma).unwrap();
        let wo = lit_direction(&specular, &cap, &mut rng(5));
        let exact = mean_brdf(&specular, &cap, wo, 1e-9, 0.0);
        let mut stated = Vec::new();
        for samples in [256, 4096] {
            let runs: Vec<_> = (0..200).map(|seed| mean_brdf_mc(&specular, &cap, wo, samples, seed)).collect();
            let rms = |f: &dyn Fn(usize) -> f64| {
                ((0..runs.len()).map(|i| f(i).powi(2)).sum::<f64>() / runs.len() as f64).sqrt()
            };
            let (spread, stderr) = (rms(&|i| runs[i].value - exact), rms(&|i| runs[i].stderr));
            eprintln!("{samples} samples: spread {:.2e}, stated {:.2e}", spread / exact, stderr / exact);
            assert!((0.8..1.25).contains(&(spread / stderr)), "{samples} samples: spread {spread}, stated {stderr}");
            stated.push(stderr);
        }
        assert!(stated[1] < stated[0] / 5.0, "16 times the samples: from {} to {}", stated[0], stated[1]);
    }
}

/// ∫ f_r cosθi over the cap in (θ, φ) about the normal: the cap meets the circle of zenith angle θ in one arc around φe.
/// Chebyshev nodes in θ for the square roots where the arc closes, midpoints in φ.
fn numerator_about_the_normal(specular: &Specular, cap: &Cap, wo: DVec3) -> f64 {
    let (theta_e, sigma) = (cap.theta(), cap.half_angle());
    let (rows, columns) = (4000, 400);
    // The arc is a whole circle near the normal when the cap holds it; the integrand is smooth on either side.
    let whole = (sigma - theta_e).max(0.0);
    let top = (theta_e + sigma).min(FRAC_PI_2);
    let mut sum = 0.0;
    for (low, high) in [(0.0, whole), (if whole > 0.0 { whole } else { (theta_e - sigma).max(0.0) }, top)] {
        for i in 0..rows {
            let t = PI * (i as f64 + 0.5) / rows as f64;
            let theta = 0.5 * (low + high) - 0.5 * (high - low) * t.cos();
            let step = 0.5 * (high - low) * t.sin() * PI / rows as f64;
            let cos_arc = (sigma.cos() - theta.cos() * theta_e.cos()) / (theta.sin() * theta_e.sin());
            let arc = if theta < whole { PI } else { cos_arc.clamp(-1.0, 1.0).acos() };
            let mean: f64 = (0..columns)
                .map(|j| cap.phi() + arc * (2.0 * (j as f64 + 0.5) / columns as f64 - 1.0))
                .map(|phi| specular.eval(spherical(theta, phi), wo))
                .sum::<f64>()
                / columns as f64;
            sum += mean * 2.0 * arc * theta.cos() * theta.sin() * step;
        }
    }
    sum
}

#[test]
fn quadrature_agrees_with_a_rule_about_the_normal() {
    let anisotropic = examples().filter(|(s, _)| !s.is_isotropic() && s.lobe_width() > 0.1);
    let isotropic = [phong(1.0), phong(40.0)].map(|s| (s, format!("{s:?}")));
    for (specular, name) in isotropic.into_iter().chain(anisotropic) {
        for (theta, sigma) in [(0.3, 0.5), (0.8, 0.3), (1.3, 0.6), (FRAC_PI_2, 0.4)] {
            let cap = Cap::with_half_angle(theta, 0.7, sigma).unwrap();
            let wo = lit_direction(&specular, &cap, &mut rng(3));
            let exact = mean_brdf(&specular, &cap, wo, 1e-9, 0.0);
            let brute = numerator_about_the_normal(&specular, &cap, wo) / cap.projected_solid_angle();
            let off = (exact - brute).abs() / brute;
            eprintln!("{name} theta {theta} sigma {sigma}: {off:.1e}");
            assert!(off < 5e-6, "{name}, theta {theta}, sigma {sigma}: {exact} {brute}");
        }
    }
}
