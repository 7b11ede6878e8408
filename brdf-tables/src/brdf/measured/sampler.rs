//! Which directions to draw: the roughness and the share of the cosine that make the least variance.

use super::super::{Brdf, Distribution, Fresnel, Microfacet};
use crate::frame::spherical;
use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use glam::DVec3;

/// Views that the variance is summed over, degrees.
const VIEWS: [f64; 4] = [8.0, 38.0, 62.0, 80.0];
/// Half vectors a view: rings of √θh, and azimuths.
const RINGS: usize = 72;
const AZIMUTHS: usize = 24;
/// Roughnesses tried, from .01 to 1 by equal factors.
const ROUGHNESSES: usize = 36;
/// Shares of the cosine tried.
const SHARES: [f64; 9] = [0.03, 0.08, 0.15, 0.25, 0.4, 0.55, 0.7, 0.85, 0.95];

/// One direction of the sums: f_r cosθi, its density, and what it stands for, sr.
struct Node {
    wi: DVec3,
    value: f64,
    weight: f64,
}

/// (α, share) of the sampler for f_r cosθi as a function of (wi, wo): of those tried, the one of the least sum over views of
/// ∫ (f cos)² / pdf over (∫ f cos)², the variance of one sample.
pub fn fit(value: impl Fn(DVec3, DVec3) -> f64) -> (f64, f64) {
    let views = VIEWS.map(|degrees| spherical(f64::to_radians(degrees), 0.0));
    let nodes: Vec<Vec<Node>> = views.iter().map(|&wo| directions(wo, &value)).collect();
    let mut best = (f64::INFINITY, (0.3, 0.5));
    for i in 0..ROUGHNESSES {
        let alpha = 0.01f64.powf(1.0 - i as f64 / (ROUGHNESSES - 1) as f64);
        let facets =
            Microfacet { distribution: Distribution::Ggx, alpha_x: alpha, alpha_y: alpha, fresnel: Fresnel::None };
        let mut variance = [0.0; SHARES.len()];
        for (nodes, &wo) in nodes.iter().zip(&views) {
            let total: f64 = nodes.iter().map(|n| n.value * n.weight).sum();
            for node in nodes {
                let (cosine, facets) = (node.wi.z * FRAC_1_PI, facets.pdf(node.wi, wo));
                for (sum, share) in variance.iter_mut().zip(SHARES) {
                    let density = share * cosine + (1.0 - share) * facets;
                    *sum += node.weight * node.value * node.value / (density * total * total).max(1e-300);
                }
            }
        }
        for (variance, share) in variance.into_iter().zip(SHARES) {
            if variance < best.0 {
                best = (variance, (alpha, share));
            }
        }
    }
    best.1
}

/// Mirror images of `wo` at half vectors that are dense about the normal.
fn directions(wo: DVec3, value: &impl Fn(DVec3, DVec3) -> f64) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(RINGS * AZIMUTHS);
    for ring in 0..RINGS {
        let x = (ring as f64 + 0.5) / RINGS as f64;
        let theta = x * x * FRAC_PI_2;
        // dθ = π x dx
        let ring_weight = theta.sin() * PI * x / RINGS as f64 * TAU / AZIMUTHS as f64;
        for azimuth in 0..AZIMUTHS {
            let half = spherical(theta, TAU * (azimuth as f64 + 0.5) / AZIMUTHS as f64);
            let cos = wo.dot(half);
            let wi = 2.0 * cos * half - wo;
            if cos > 0.0 && wi.z > 0.0 {
                // dωi = 4 cosθd dωh
                nodes.push(Node { wi, value: value(wi, wo) * wi.z, weight: 4.0 * cos * ring_weight });
            }
        }
    }
    nodes
}
