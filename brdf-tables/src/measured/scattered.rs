//! Values at scattered pairs of directions: a fitted model, times the ratio of the data to it, interpolated.
//!
//! Few directions cannot tell how a highlight looks between them: Cornell's lie five degrees and more apart. So a model is
//! fitted first, kd/π + ks · GGX with Schlick's Fresnel term, and what is interpolated, in the logarithm, is the ratio of the
//! data to it: smooth where the model is about right, whatever the highlight does. Neighbours are found in (√θh, θd, φd), where
//! exchanged directions and mirror images are one point, and weighted by the inverse fourth power of their distance (Shepard
//! 1968).

use super::{Place, ReadError, Source};
use crate::brdf::{Brdf, Distribution, Fresnel, Microfacet, angles};
use core::f64::consts::{FRAC_1_PI, FRAC_2_PI};
use glam::DVec3;

/// Fewest points that say anything.
const FEWEST: usize = 4;
/// Neighbours of an interpolation.
const NEIGHBOURS: usize = 12;
/// What a step along √θh, θd and φd weighs in a distance: azimuths change values least.
const SCALES: [f64; 3] = [2.0, 1.0, 0.5];
/// Roughnesses and normal reflectances tried.
const ROUGHNESSES: usize = 30;
const REFLECTANCES: [f64; 8] = [0.02, 0.04, 0.07, 0.12, 0.2, 0.4, 0.7, 1.0];
/// Least that the largest value may be, sr⁻¹, and least part of it that the floor is: squares of its inverse must be finite.
const FAINTEST: f64 = 1e-12;
const LEAST_FLOOR: f64 = 1e-9;
/// Most points that a fit and a cross-check look at.
const MOST_FITTED: usize = 3000;
const MOST_CHECKED: usize = 600;

/// kd/π and ks of each channel.
type Strengths = ([f64; 3], [f64; 3]);

/// A pair of directions and f_r there.
pub type Point = (DVec3, DVec3, [f64; 3]);

/// The points, in the order of their first coordinate, and the model.
pub struct Scattered {
    places: Vec<[f64; 3]>,
    ratios: Vec<[f64; 3]>,
    facets: Microfacet,
    strengths: Strengths,
    /// What both sides of a ratio are raised by, sr⁻¹, so that zeros have one.
    floor: f64,
}

impl Scattered {
    /// Fits the model; tells of it, and of how well the points foretell each other.
    pub fn new(points: &[Point], notes: &mut Vec<String>) -> Result<Self, ReadError> {
        let lit: Vec<Point> = points.iter().filter(|(wi, wo, _)| wi.z > 1e-4 && wo.z > 1e-4).copied().collect();
        if lit.len() < FEWEST {
            let what = format!("{} pairs of directions above the horizon, at least {FEWEST} are needed", lit.len());
            return Err(ReadError::new(Place::File, what));
        }
        let mut grey: Vec<f64> = lit.iter().map(|p| mean(&p.2)).collect();
        grey.sort_by(f64::total_cmp);
        let (median, largest) = (grey[grey.len() / 2], grey[grey.len() - 1]);
        if largest < FAINTEST {
            let what = format!("all values are zero, or below {FAINTEST:e} sr⁻¹");
            return Err(ReadError::new(Place::File, what));
        }
        let floor = (0.02 * if median > 0.0 { median } else { largest }).max(LEAST_FLOOR * largest);
        let Some((facets, strengths)) = model(&lit, floor) else {
            return Err(ReadError::new(Place::File, "no model has a finite distance from the values"));
        };
        let mut order: Vec<([f64; 3], [f64; 3])> = lit
            .iter()
            .map(|(wi, wo, rgb)| {
                let fitted = at(&facets, &strengths, *wi, *wo);
                (place(*wi, *wo), core::array::from_fn(|c| ((rgb[c] + floor) / (fitted[c] + floor)).ln()))
            })
            .collect();
        order.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let (places, ratios) = order.into_iter().unzip();
        let scattered = Self { places, ratios, facets, strengths, floor };

        let Fresnel::Schlick { f0 } = facets.fresnel else { unreachable!("the model has Schlick's reflectance") };
        let show = |rgb: [f64; 3]| rgb.map(|x| format!("{x:.3}")).join(", ");
        notes.push(format!(
            "model behind the interpolation: kd [{}] + ks [{}] · GGX of α {:.3}, f0 {}",
            show(strengths.0.map(|x| x / FRAC_1_PI)),
            show(strengths.1),
            facets.alpha_x,
            f0[0]
        ));
        let [median, p95] = scattered.cross_check();
        notes.push(format!(
            "each value foretold by the others: {:.1} % off in the median, {:.1} % at the 95th percentile",
            100.0 * median,
            100.0 * p95
        ));
        Ok(scattered)
    }

    /// Logarithm of the ratio at a place, without one of the points.
    fn ratio(&self, x: [f64; 3], without: Option<usize>) -> [f64; 3] {
        let mut nearest: [(f64, usize); NEIGHBOURS] = [(f64::INFINITY, 0); NEIGHBOURS];
        let start = self.places.partition_point(|p| p[0] < x[0]);
        // Outwards from the place along the first coordinate, until that alone is farther than the farthest neighbour.
        let mut visit = |i: usize| {
            let along = SCALES[0] * (self.places[i][0] - x[0]);
            if along * along > nearest[NEIGHBOURS - 1].0 {
                return false;
            }
            if Some(i) != without {
                let squared: f64 = (0..3).map(|k| (SCALES[k] * (self.places[i][k] - x[k])).powi(2)).sum();
                let at = nearest.partition_point(|n| n.0 <= squared);
                if at < NEIGHBOURS {
                    nearest.copy_within(at..NEIGHBOURS - 1, at + 1);
                    nearest[at] = (squared, i);
                }
            }
            true
        };
        for i in start..self.places.len() {
            if !visit(i) {
                break;
            }
        }
        for i in (0..start).rev() {
            if !visit(i) {
                break;
            }
        }
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for (squared, i) in nearest.into_iter().filter(|n| n.0.is_finite()) {
            let weight = (squared + 1e-6).powi(-2);
            (0..3).for_each(|c| sum[c] += weight * self.ratios[i][c]);
            weights += weight;
        }
        sum.map(|x| x / weights)
    }

    /// Relative error of points foretold by the others, median and 95th percentile.
    fn cross_check(&self) -> [f64; 2] {
        let step = self.places.len().div_ceil(MOST_CHECKED);
        let mut errors: Vec<f64> = (0..self.places.len())
            .step_by(step)
            .map(|i| {
                let (own, others) = (self.ratios[i], self.ratio(self.places[i], Some(i)));
                (0..3).map(|c| (own[c] - others[c]).abs().exp_m1()).fold(0.0, f64::max)
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        [0.5, 0.95].map(|q| errors[(errors.len() as f64 * q) as usize])
    }
}

impl Source for Scattered {
    fn rgb(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        let fitted = at(&self.facets, &self.strengths, wi, wo);
        let ratio = self.ratio(place(wi, wo), None);
        Some(core::array::from_fn(|c| ((fitted[c] + self.floor) * ratio[c].exp() - self.floor).max(0.0)))
    }

    fn is_folded(&self) -> bool {
        true
    }
}

/// Unit coordinates of two directions.
fn place(wi: DVec3, wo: DVec3) -> [f64; 3] {
    let [h, d, p] = angles(wi, wo).map(|a| a * FRAC_2_PI);
    [h.sqrt(), d, p]
}

fn mean(rgb: &[f64; 3]) -> f64 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

/// The model's value.
fn at(facets: &Microfacet, (diffuse, strength): &Strengths, wi: DVec3, wo: DVec3) -> [f64; 3] {
    let lobe = facets.eval(wi, wo);
    core::array::from_fn(|c| diffuse[c] + strength[c] * lobe)
}

/// The roughness and normal reflectance whose kd/π + ks · GGX, fitted to the grey values by least squares of relative errors,
/// is the nearest; then kd/π and ks of each channel. `None` where no distance is finite.
fn model(points: &[Point], floor: f64) -> Option<(Microfacet, Strengths)> {
    let step = points.len().div_ceil(MOST_FITTED);
    let points: Vec<&Point> = points.iter().step_by(step).collect();
    let mut best = (f64::INFINITY, None);
    for i in 0..ROUGHNESSES {
        let alpha = 0.02f64.powf(1.0 - i as f64 / (ROUGHNESSES - 1) as f64);
        for f0 in REFLECTANCES {
            let fresnel = Fresnel::Schlick { f0: [f0; 3] };
            let facets = Microfacet { distribution: Distribution::Ggx, alpha_x: alpha, alpha_y: alpha, fresnel };
            let lobe: Vec<f64> = points.iter().map(|(wi, wo, _)| facets.eval(*wi, *wo)).collect();
            let (strengths, error) = linear(&points, &lobe, floor, mean);
            if error < best.0 {
                best = (error, Some((facets, lobe, strengths)));
            }
        }
    }
    let (facets, lobe, grey) = best.1?;
    let mut strengths = ([grey.0; 3], [grey.1; 3]);
    for c in 0..3 {
        let ((diffuse, strength), _) = linear(&points, &lobe, floor, |rgb| rgb[c]);
        (strengths.0[c], strengths.1[c]) = (diffuse, strength);
    }
    Some((facets, strengths))
}

/// d + s · lobe ≈ value by least squares of relative errors, both not negative; and the sum of squares.
fn linear(points: &[&Point], lobe: &[f64], floor: f64, value: impl Fn(&[f64; 3]) -> f64) -> ((f64, f64), f64) {
    let (mut s1, mut sl, mut sll, mut sy, mut syl) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let weight = |y: f64| (y + floor).powi(-2);
    for (point, l) in points.iter().zip(lobe) {
        let y = value(&point.2);
        let w = weight(y);
        (s1, sl, sll, sy, syl) = (s1 + w, sl + w * l, sll + w * l * l, sy + w * y, syl + w * y * l);
    }
    let determinant = s1 * sll - sl * sl;
    let free = ((sy * sll - syl * sl) / determinant, (s1 * syl - sl * sy) / determinant);
    let (d, s) = match free {
        (d, s) if d >= 0.0 && s >= 0.0 => (d, s),
        (d, _) if d < 0.0 => (0.0, if sll > 0.0 { syl / sll } else { 0.0 }),
        _ => (sy / s1, 0.0),
    };
    let error = points.iter().zip(lobe).map(|(p, l)| {
        let y = value(&p.2);
        weight(y) * (d + s * l - y).powi(2)
    });
    ((d, s), error.sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::spherical;

    /// Directions like Cornell's of a known material: between them it comes back to a few percent.
    #[test]
    fn a_known_material_comes_back() {
        let fresnel = Fresnel::Schlick { f0: [0.05; 3] };
        let facets = Microfacet { distribution: Distribution::Ggx, alpha_x: 0.2, alpha_y: 0.2, fresnel };
        let value = |wi: DVec3, wo: DVec3| [0.1, 0.05, 0.02].map(|kd| kd + facets.eval(wi, wo));
        let mut points = Vec::new();
        for i in 1..9 {
            for o in 0..9 {
                for p in 0..13 {
                    let (wi, wo) =
                        (spherical(0.17 * f64::from(i), 0.0), spherical(0.16 * f64::from(o), 0.26 * f64::from(p)));
                    points.push((wi, wo, value(wi, wo)));
                }
            }
        }
        let mut notes = Vec::new();
        let scattered = Scattered::new(&points, &mut notes).unwrap();
        assert_eq!(notes.len(), 2);
        let mut errors: Vec<f64> = (0..1000)
            .map(|i| {
                let x = |k: f64| (0.5 + f64::from(i) * k).fract();
                let (wi, wo) = (spherical(1.3 * x(0.819), 0.0), spherical(1.3 * x(0.671), 3.1 * x(0.55)));
                let (a, b) = (value(wi, wo), scattered.rgb(wi, wo).unwrap());
                assert_eq!(scattered.rgb(wo, wi).map(|x| (x[0] * 1e9).round()), Some((b[0] * 1e9).round()));
                (0..3).map(|c| (a[c] / b[c] - 1.0).abs()).fold(0.0, f64::max)
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        assert!(errors[500] < 0.02 && errors[950] < 0.08, "{} {}", errors[500], errors[950]);
        assert!(Scattered::new(&points[..3], &mut notes).is_err());
    }
}
