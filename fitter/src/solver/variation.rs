//! How the genetic algorithm makes new individuals from old ones.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};

/// Reach of the blend beyond the parents, relative to their distance: with 1/2
/// the offspring spread neither more nor less than the parents did.
const BLEND: f64 = 0.5;
/// Standard deviation of the change of ln width per generation.
const WIDTH_DRIFT: f64 = 0.3;
const WIDTH_RANGE: (f64, f64) = (1e-9, 0.5);

/// A candidate solution and the width of its mutations relative to the box,
/// which is inherited and selected for along with it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Individual {
    pub genes: Vec<f64>,
    pub width: f64,
    pub cost: f64,
}

/// Blend crossover BLX-α (Eshelman and Schaffer 1993) in half of the cases gene
/// by gene, in the other half along the line through the parents, which can
/// follow a valley that is not aligned with the axes.
pub(super) fn crossover(parents: [&Individual; 2], rng: &mut (impl Rng + ?Sized)) -> [Individual; 2] {
    let along_line = rng.random::<bool>();
    let weight = |rng: &mut _| RngExt::random::<f64>(rng) * (1.0 + 2.0 * BLEND) - BLEND;
    let mut weights = [weight(rng), weight(rng)];
    let mut children = parents.map(Individual::clone);
    for i in 0..children[0].genes.len() {
        if !along_line {
            weights = [weight(rng), weight(rng)];
        }
        let (a, b) = (parents[0].genes[i], parents[1].genes[i]);
        children[0].genes[i] = a + weights[0] * (b - a);
        children[1].genes[i] = b + weights[1] * (a - b);
    }
    let width = (parents[0].width * parents[1].width).sqrt();
    for child in &mut children {
        child.width = width;
    }
    children
}

/// Gaussian mutation of one gene and, on average, one more; `ranges` are the
/// lengths of the box. The width drifts first, log-normally (Schwefel 1981).
pub(super) fn mutate(child: &mut Individual, ranges: &[f64], rng: &mut (impl Rng + ?Sized)) {
    let drift = (WIDTH_DRIFT * gaussian(rng)).exp();
    child.width = (child.width * drift).clamp(WIDTH_RANGE.0, WIDTH_RANGE.1);
    let n = child.genes.len();
    let certain = rng.random_range(0..n);
    for (i, (gene, range)) in child.genes.iter_mut().zip(ranges).enumerate() {
        if i == certain || rng.random::<f64>() < 1.0 / n as f64 {
            *gene += child.width * range * gaussian(rng);
        }
    }
}

/// A standard normal number (Box and Muller).
pub(super) fn gaussian(rng: &mut (impl Rng + ?Sized)) -> f64 {
    let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    radius * (TAU * rng.random::<f64>()).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn individual(genes: &[f64], width: f64) -> Individual {
        Individual { genes: genes.to_vec(), width, cost: 0.0 }
    }

    #[test]
    fn children_of_equal_parents_are_equal_to_them() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let parent = individual(&[1.0, -2.0, 3.0], 0.25);
        for child in crossover([&parent, &parent], &mut rng) {
            assert_eq!(child, parent);
        }
    }

    #[test]
    fn children_stay_within_the_blend_and_reach_all_of_it() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
        let (a, b) = (individual(&[0.0; 4], 0.1), individual(&[1.0; 4], 0.4));
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..2000 {
            for child in crossover([&a, &b], &mut rng) {
                assert!((child.width - 0.2).abs() < 1e-12);
                for x in child.genes {
                    (lo, hi) = (lo.min(x), hi.max(x));
                }
            }
        }
        assert!((-0.5..-0.49).contains(&lo) && (1.49..=1.5).contains(&hi), "{lo} {hi}");
    }

    #[test]
    fn gaussian_has_mean_zero_and_variance_one() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let x: Vec<f64> = (0..100_000).map(|_| gaussian(&mut rng)).collect();
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let variance = x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
        assert!(mean.abs() < 0.015 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
    }

    #[test]
    fn mutation_moves_two_genes_on_average_and_at_least_one() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let mut moved = 0;
        for _ in 0..5000 {
            let mut child = individual(&[0.0; 10], 0.1);
            mutate(&mut child, &[1.0; 10], &mut rng);
            let count = child.genes.iter().filter(|x| **x != 0.0).count();
            assert!(count > 0);
            moved += count;
        }
        let mean = f64::from(moved as u32) / 5000.0;
        assert!((mean - 1.9).abs() < 0.1, "{mean}");
    }
}
