//! Which model explains a measured material best, and how well: candidates fitted to the data, and their errors.

mod fit;
mod search;

use crate::error::Directions;
use crate::measured::{VIEWS, albedo};
use brdf_tables::brdf::build;
use brdf_tables::cap::Cap;
use brdf_tables::cubature::{Cubature, Rule};
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::frame::{mirror, spherical};
use brdf_tables::material::Material;
use brdf_tables::mean::MeanBrdf;
use brdf_tables::measured::Source;
use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use glam::DVec3;
use rayon::prelude::*;

/// Models that are tried.
pub const MODELS: [&str; 9] = {
    let ([lambert, phong, ward, beckmann, ggx, sheen], [sgd, abc, lobes]) = (fit::MODELS, search::MODELS);
    [lambert, phong, ward, beckmann, ggx, sheen, sgd, abc, lobes]
};

/// Angles of the cap axes and radii, in lobe widths, at which the five errors are measured.
const CAPS: [(f64, f64); 9] =
    [(0.1, 0.3), (0.6, 0.3), (1.1, 0.3), (0.1, 1.0), (0.6, 1.0), (1.1, 1.0), (0.1, 2.5), (0.6, 2.5), (1.1, 2.5)];

/// A model beside the data.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Name of the model; that of the data is `data`.
    pub name: &'static str,
    /// Its parameters; of a model that no recipe has, and of the data, values as they are kept.
    pub material: Material,
    /// What `fitter fit` takes: a recipe, or the lines of a file.
    pub recipe: String,
    /// Root mean square of relative errors of f_r over the points of the fit.
    pub relative: f64,
    /// The same at each of [`VIEWS`].
    pub by_view: Vec<f64>,
    /// Directional albedo, RGB, at each of [`VIEWS`].
    pub albedo: Vec<[f64; 3]>,
    /// The five errors of the grey mean BRDF, against that of the data as they are kept.
    pub errors: Summary,
}

/// How far the data are from what a table can hold.
#[derive(Clone, Copy, Debug)]
pub struct Symmetry {
    /// Relative difference when the directions are exchanged: median and 95th percentile.
    pub exchanged: [f64; 2],
    /// The same between both mirror images.
    pub mirrored: [f64; 2],
}

/// f_r of two directions, RGB.
type Value = Box<dyn Fn(DVec3, DVec3) -> [f64; 3] + Send + Sync>;

/// A model with its parameters.
struct Fit {
    material: Material,
    recipe: String,
    value: Value,
}

impl Fit {
    fn of(material: Material) -> Self {
        Self { material, recipe: material.recipe_text(), value: Box::new(move |wi, wo| material.eval(wi, wo)) }
    }

    /// A model that files say, of the format that `kind` names; `None` where its values make no material.
    fn function(kind: &str, text: String, value: Value) -> Option<Self> {
        let material = build(kind, true, |wi, wo| Some(value(wi, wo))).ok()?.material;
        Some(Self { material, recipe: format!("# a file that ends in .{kind}\n{}", text.trim_end()), value })
    }
}

/// A pair of directions with f_r of the data.
struct Point {
    wi: DVec3,
    wo: DVec3,
    rgb: [f64; 3],
    /// Index of the view in [`VIEWS`].
    view: usize,
}

/// Grey value.
fn grey(rgb: &[f64; 3]) -> f64 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

/// The points that models are fitted to: about the mirror direction of each view, dense there, and over all of the hemisphere.
fn points(data: &dyn Source) -> Vec<Point> {
    const RINGS: usize = 28;
    const SPOKES: usize = 14;
    let mut points = Vec::new();
    for (view, degrees) in VIEWS.into_iter().enumerate() {
        let wo = spherical(degrees.to_radians(), 0.0);
        for ring in 0..RINGS {
            let theta = ((ring as f64 + 0.5) / RINGS as f64).powi(2) * FRAC_PI_2;
            for spoke in 0..SPOKES {
                let half = spherical(theta, PI * (spoke as f64 + 0.5) / SPOKES as f64);
                let wi = 2.0 * wo.dot(half) * half - wo;
                if wi.z > 0.05
                    && let Some(rgb) = data.rgb(wi, wo)
                {
                    points.push(Point { wi, wo, rgb, view });
                }
            }
        }
    }
    points
}

/// Every model of [`MODELS`], and first the data as they are kept, sorted by how well they explain the data.
pub fn explain(data: &dyn Source, kept: &Material) -> Vec<Candidate> {
    let points = points(data);
    let floor = fit::floor(&points);
    let truth = means(kept);
    let finish = |name, Fit { material, recipe, value }: Fit| {
        let relative = |of: &dyn Fn(&Point) -> bool| {
            let errors: Vec<f64> = points
                .iter()
                .filter(|p| of(p))
                .map(|p| {
                    let found = value(p.wi, p.wo);
                    (0..3).map(|c| ((found[c] - p.rgb[c]) / (p.rgb[c] + floor)).powi(2)).sum::<f64>() / 3.0
                })
                .collect();
            (errors.iter().sum::<f64>() / errors.len().max(1) as f64).sqrt()
        };
        let views = |degrees: f64| spherical(degrees.to_radians(), 0.0);
        Candidate {
            name,
            material,
            recipe,
            relative: relative(&|_| true),
            by_view: (0..VIEWS.len()).map(|k| relative(&|p| p.view == k)).collect(),
            albedo: VIEWS.iter().map(|d| albedo(&material, views(*d))).collect(),
            errors: errors(&truth, &material),
        }
    };
    let fit = |name: &'static str| match search::MODELS.contains(&name) {
        true => search::candidate(name, &points, floor),
        false => Some(fit::candidate(name, &points, floor)),
    };
    // Those that take long are begun first.
    let mut candidates: Vec<Candidate> =
        MODELS.into_par_iter().rev().filter_map(|name| Some(finish(name, fit(name)?))).collect();
    candidates.sort_by(|a, b| a.relative.total_cmp(&b.relative));
    candidates.insert(0, finish("data", Fit::of(*kept)));
    candidates
}

/// Grey mean BRDFs of a material over [`CAPS`].
struct Means {
    caps: Vec<(Cap, Directions, Vec<f64>)>,
}

fn grey_mean(material: &Material, rule: Option<&Cubature>, cap: &Cap, wo: DVec3) -> f64 {
    let diffuse = grey(&material.kd) * FRAC_1_PI;
    let Some(specular) = &material.specular else { return diffuse };
    let tint = specular.tint(cap.axis(), wo);
    let strength: f64 = (0..3).map(|c| material.ks[c] * tint[c]).sum::<f64>() / 3.0;
    diffuse + strength * rule.map_or(0.0, |rule| rule.value(cap, wo))
}

fn rule(material: &Material) -> Option<Cubature> {
    material.specular.map(|specular| Cubature::uniform(specular, Rule::Product(16)))
}

fn means(material: &Material) -> Means {
    let Some(specular) = material.specular else { return Means { caps: Vec::new() } };
    let rule = rule(material);
    let cap = |(theta, widths): (f64, f64)| Cap::with_half_angle(theta, 0.0, (widths * specular.lobe_width()).min(1.5));
    let caps = CAPS.into_par_iter().filter_map(|c| cap(c).ok()).map(|cap| {
        let directions = Directions::new(&specular, &cap);
        let exact = directions.wo.iter().map(|&wo| grey_mean(material, rule.as_ref(), &cap, wo)).collect();
        (cap, directions, exact)
    });
    Means { caps: caps.collect() }
}

fn errors(truth: &Means, material: &Material) -> Summary {
    let rule = rule(material);
    let all: Vec<Errors> = truth
        .caps
        .iter()
        .map(|(cap, directions, exact)| {
            let found: Vec<f64> = directions.wo.iter().map(|&wo| grey_mean(material, rule.as_ref(), cap, wo)).collect();
            directions.errors(exact, &found)
        })
        .collect();
    Summary::new(&all)
}

/// What the data have that a table of them has not.
pub fn symmetry(data: &dyn Source) -> Symmetry {
    let mut exchanged = Vec::new();
    let mut mirrored = Vec::new();
    for i in 0..4000 {
        let x = |k: f64| (0.5 + f64::from(i) * k).fract();
        let (wi, wo) =
            (spherical(1.4 * x(0.819_172_5), 0.0), spherical(1.4 * x(0.671_043_6), 2.0 * PI * x(0.549_700_5)));
        let apart = |a: Option<[f64; 3]>, b: Option<[f64; 3]>| {
            let (a, b) = (a?, b?);
            let mean = 0.5 * (grey(&a) + grey(&b));
            (mean > 0.0).then(|| (grey(&a) - grey(&b)).abs() / mean)
        };
        let here = data.rgb(wi, wo);
        exchanged.extend(apart(here, data.rgb(wo, wi)));
        let flip = |w: DVec3| DVec3::new(w.x, -w.y, w.z);
        mirrored.extend(apart(here, data.rgb(flip(wi), flip(wo))));
    }
    let quantiles = |mut errors: Vec<f64>| {
        errors.sort_by(f64::total_cmp);
        [0.5, 0.95].map(|q| errors.get((errors.len() as f64 * q) as usize).copied().unwrap_or(0.0))
    };
    Symmetry { exchanged: quantiles(exchanged), mirrored: quantiles(mirrored) }
}

/// f_r, grey, in the plane of incidence for light at an angle: (angle of the view, value), the mirror direction at +angle.
pub fn cut(value: impl Fn(DVec3, DVec3) -> Option<[f64; 3]>, degrees: f64) -> Vec<(f64, f64)> {
    let wi = mirror(spherical(degrees.to_radians(), 0.0));
    let mut samples = Vec::new();
    // Dense about the mirror direction.
    for i in -120..=120 {
        let s = f64::from(i) / 120.0;
        let angle = degrees + s * s.abs() * (90.0 + degrees);
        if angle.abs() < 89.5 {
            let wo = spherical(angle.to_radians(), 0.0);
            samples.extend(value(wi, wo).map(|rgb| (angle, grey(&rgb))));
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::brdf::{Distribution, Fresnel, Microfacet, Specular};

    /// Data that are GGX are explained by GGX, with its parameters.
    struct Known(Material);

    impl Source for Known {
        fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
            Some(self.0.eval(wi, wo))
        }
        fn is_folded(&self) -> bool {
            true
        }
    }

    #[test]
    fn a_known_model_is_found() {
        let fresnel = Fresnel::Schlick { f0: [0.04; 3] };
        let facets = Microfacet { distribution: Distribution::Ggx, alpha_x: 0.15, alpha_y: 0.15, fresnel };
        let known = Material { kd: [0.3, 0.2, 0.1], ks: [1.0; 3], specular: Some(Specular::Microfacet(facets)) };
        let kept = brdf_tables::brdf::build("known", true, |wi, wo| Some(known.eval(wi, wo))).unwrap().material;
        let candidates = explain(&Known(known), &kept);
        assert_eq!((candidates[0].name, candidates[1].name), ("data", "ggx"));
        let found = &candidates[1];
        assert!(found.relative < 0.01, "{found:?}");
        let Some(Specular::Microfacet(facets)) = found.material.specular else { panic!("{found:?}") };
        assert!((facets.alpha_x - 0.15).abs() < 0.003, "{facets:?}");
        assert!((found.material.kd[0] - 0.3).abs() < 0.005, "{:?}", found.material.kd);
        assert!(found.errors.p95.rmse_lobe < 0.01 && candidates[2].relative > 0.05);
        let symmetry = symmetry(&Known(known));
        assert!(symmetry.exchanged[1] < 1e-9 && symmetry.mirrored[1] < 1e-9);
    }
}
