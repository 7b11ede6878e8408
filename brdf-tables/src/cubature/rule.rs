//! The rules a cap may be integrated by, from the cheapest to the finest.

use crate::gauss::gauss_legendre;
use crate::real::Real;
use core::f64::consts::TAU;
use core::fmt;

/// One rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// So many nodes on rings about the axis of the cap: for caps smaller than the lobe.
    Disc(usize),
    /// The product of two Gauss–Legendre rules of so many nodes, which follow the lobe and the horizon.
    Product(usize),
}

/// All rules, by what they cost (measured: `cargo bench -p brdf-tables cubature`); a table stores indices into this list.
pub const RULES: [Rule; 15] = [
    Rule::Disc(1),
    Rule::Disc(4),
    Rule::Disc(7),
    Rule::Disc(12),
    Rule::Disc(19),
    Rule::Disc(28),
    Rule::Disc(35),
    Rule::Product(4),
    Rule::Disc(46),
    Rule::Product(5),
    Rule::Product(6),
    Rule::Product(8),
    Rule::Product(10),
    Rule::Product(12),
    Rule::Product(16),
];

/// In place of an index, where no rule of a kind will do.
pub const NONE: u8 = RULES.len() as u8;

impl Rule {
    /// Its index in [`RULES`].
    ///
    /// # Panics
    /// If it is not there.
    pub const fn index(self) -> u8 {
        let mut i = 0;
        while i < RULES.len() {
            match (self, RULES[i]) {
                (Rule::Disc(a), Rule::Disc(b)) | (Rule::Product(a), Rule::Product(b)) if a == b => return i as u8,
                _ => i += 1,
            }
        }
        panic!("a rule of the list")
    }

    /// Evaluations of the model.
    pub const fn evaluations(self) -> usize {
        match self {
            Rule::Disc(n) => n,
            Rule::Product(n) => n * n,
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Rule::Disc(n) => write!(f, "disc of {n}"),
            Rule::Product(n) => write!(f, "{n}×{n}"),
        }
    }
}

/// Nodes on a circle about the axis, of equal weight.
#[derive(Clone, Debug)]
pub struct Ring<L> {
    /// 1 − cos of the angle from the axis, over the height of the cap: the fraction of the solid angle within.
    pub height: L,
    /// Weight of each node; those of a rule add up to 1.
    pub weight: L,
    /// (cos, sin) of their azimuths.
    pub azimuths: Vec<(L, L)>,
}

/// The numbers of a rule, which may differ from lane to lane.
#[derive(Clone, Debug)]
pub enum Nodes<L> {
    /// Rings of a [`Rule::Disc`].
    Disc(Vec<Ring<L>>),
    /// Nodes of a [`Rule::Product`].
    Product(Grid<L>),
}

/// Nodes and weights on [−1, 1] of two Gauss–Legendre rules.
#[derive(Clone, Debug)]
pub struct Grid<L> {
    /// Over the meridians.
    pub outer: Vec<(L, L)>,
    /// On each of them.
    pub inner: Vec<(L, L)>,
}

impl<L> Nodes<L> {
    /// The numbers of `rule`, each as `lanes` makes it.
    pub fn new(rule: Rule, lanes: impl Fn(f64) -> L) -> Self {
        match rule {
            Rule::Disc(n) => {
                let ring = |&(height, weight, count, turn): &(f64, f64, usize, f64)| {
                    let azimuth = |k: usize| (TAU * (k as f64 + turn) / count as f64).sin_cos();
                    let azimuths = (0..count).map(azimuth).map(|(s, c)| (lanes(c), lanes(s))).collect();
                    Ring { height: lanes(height), weight: lanes(weight / count as f64), azimuths }
                };
                Nodes::Disc(disc(n).iter().map(ring).collect())
            }
            Rule::Product(n) => {
                let nodes = || gauss_legendre(n).into_iter().map(|(x, w)| (lanes(x), lanes(w))).collect();
                Nodes::Product(Grid { outer: nodes(), inner: nodes() })
            }
        }
    }
}

/// What a shader takes of a rule: whether it is a product, how many numbers a node has, and these numbers: height, weight,
/// cosine and sine of a node of a disc; node and weight of each of the two rules of a product.
#[cfg(feature = "wgsl")]
pub(crate) fn numbers(rule: Rule) -> (bool, usize, Vec<f64>) {
    match Nodes::new(rule, |x| x) {
        Nodes::Disc(rings) => {
            let ring = |r: &Ring<f64>| {
                let (height, weight) = (r.height, r.weight);
                r.azimuths.iter().flat_map(move |&(c, s)| [height, weight, c, s]).collect::<Vec<_>>()
            };
            (false, 4, rings.iter().flat_map(ring).collect())
        }
        Nodes::Product(grid) => (true, 2, grid.outer.iter().flat_map(|&(x, w)| [x, w]).collect()),
    }
}

/// Rules on the disc, each ring as (squared radius, weight, nodes, first azimuth over their spacing). The map from the disc
/// to the cap keeps areas.
///
/// Of degree 1, 3, 5 (Radon 1948) and 7 (Albrecht & Collatz 1958); the larger ones are Gauss or Radau rules in the squared
/// radius, of degree 9, 11, 13 and 15 but for the terms r^k cos kφ that the k nodes of an inner ring miss: less than 0.5 %.
fn disc(nodes: usize) -> Vec<(f64, f64, usize, f64)> {
    let rings = |rule: &[(f64, f64)], counts: &[usize]| {
        let ring = |(i, (&(x, weight), &count)): (usize, (&(f64, f64), &usize))| {
            (0.5 * (1.0 + x), 0.5 * weight, count, 0.5 * (i % 2) as f64)
        };
        rule.iter().zip(counts).enumerate().map(ring).collect()
    };
    let (root6, root29) = (6f64.sqrt(), 29f64.sqrt());
    match nodes {
        1 => vec![(0.0, 1.0, 1, 0.0)],
        4 => vec![(0.5, 1.0, 4, 0.5)],
        7 => vec![(0.0, 0.25, 1, 0.0), (2.0 / 3.0, 0.75, 6, 0.0)],
        12 => vec![
            (0.75, 8.0 / 27.0, 4, 0.0),
            ((27.0 - 3.0 * root29) / 52.0, (551.0 + 41.0 * root29) / 1566.0, 4, 0.5),
            ((27.0 + 3.0 * root29) / 52.0, (551.0 - 41.0 * root29) / 1566.0, 4, 0.5),
        ],
        19 => {
            let radau = [
                (-1.0, 2.0 / 9.0),
                ((1.0 - root6) / 5.0, (16.0 + root6) / 18.0),
                ((1.0 + root6) / 5.0, (16.0 - root6) / 18.0),
            ];
            rings(&radau, &[1, 8, 10])
        }
        28 => rings(&gauss_legendre(3), &[6, 10, 12]),
        35 => {
            let radau = [
                (-1.0, 0.125),
                (-0.575_318_923_521_694_1, 0.657_688_639_960_119_5),
                (0.181_066_271_118_530_6, 0.776_386_937_686_343_8),
                (0.822_824_080_974_592_1, 0.440_924_422_353_536_8),
            ];
            rings(&radau, &[1, 8, 12, 14])
        }
        46 => rings(&gauss_legendre(4), &[6, 10, 14, 16]),
        _ => panic!("no disc rule of {nodes} nodes"),
    }
}

/// Two unit vectors that make a frame with the unit vector `axis`, z ≥ 0 (Duff et al. 2017).
#[inline(always)]
pub fn tangents<T: Real>([x, y, z]: [T; 3]) -> [[T; 3]; 2] {
    let one = z.lit(1.0);
    let a = -(one + z).recip();
    let b = x * y * a;
    [[one + x.sq() * a, b, -x], [b, one + y.sq() * a, -y]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ over the unit disc of x^i y^j, over π: exact up to the degree, and not beyond it.
    #[test]
    fn disc_rules_have_their_degree() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let exactly = 1e-14;
        for (count, degree, bound) in [
            (1, 1, exactly),
            (4, 3, exactly),
            (7, 5, exactly),
            (12, 7, exactly),
            (19, 9, 0.005),
            (28, 11, 0.005),
            (35, 13, 0.005),
            (46, 15, 0.005),
        ] {
            let Nodes::Disc(rings) = Nodes::new(Rule::Disc(count), |x| x) else { panic!("a disc") };
            let mean = |i: i32, j: i32| -> f64 {
                let power = |ring: &Ring<f64>| {
                    let r = ring.height.sqrt();
                    ring.azimuths.iter().map(|(c, s)| ring.weight * (r * c).powi(i) * (r * s).powi(j)).sum::<f64>()
                };
                rings.iter().map(power).sum()
            };
            // Even powers 2p, 2q: (2p)! (2q)! / (4^(p+q) p! q! (p+q+1)!).
            let exact = |i: i32, j: i32| match (i % 2, j % 2) {
                (0, 0) => {
                    let (p, q) = (i / 2, j / 2);
                    let below = 4f64.powi(p + q) * factorial(p) * factorial(q) * factorial(p + q + 1);
                    factorial(i) * factorial(j) / below
                }
                _ => 0.0,
            };
            for i in 0..=degree {
                for j in 0..=degree - i {
                    assert!((mean(i, j) - exact(i, j)).abs() < bound, "{count}: x^{i} y^{j}");
                }
            }
            // Radial terms are exact for all.
            let radial = |p: i32| -> f64 {
                let term = |r: &Ring<f64>| r.weight * r.azimuths.len() as f64 * r.height.powi(p);
                rings.iter().map(term).sum()
            };
            for p in 0..=degree / 2 {
                assert!((radial(p) * f64::from(p + 1) - 1.0).abs() < 1e-13, "{count}: r^{}", 2 * p);
            }
            let next = (0..=degree + 1).map(|i| (mean(i, degree + 1 - i) - exact(i, degree + 1 - i)).abs());
            assert!(next.fold(0.0, f64::max) > 1e-5, "{count} nodes: more than degree {degree}");
        }
    }

    #[test]
    fn rules_and_indices() {
        for (i, rule) in RULES.iter().enumerate() {
            assert_eq!(usize::from(rule.index()), i);
            let sum = |nodes: &Nodes<f64>| match nodes {
                Nodes::Disc(rings) => rings.iter().map(|r| r.azimuths.len()).sum::<usize>(),
                Nodes::Product(grid) => grid.outer.len() * grid.inner.len(),
            };
            assert_eq!(sum(&Nodes::new(*rule, |x| x)), rule.evaluations(), "{rule}");
        }
    }

    #[test]
    fn tangents_are_orthonormal() {
        for axis in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -1.0, 0.0], [-0.48, 0.64, 0.6f64]] {
            let [t, u] = tangents(axis);
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            for (a, b, expected) in [(t, t, 1.0), (u, u, 1.0), (t, u, 0.0), (t, axis, 0.0), (u, axis, 0.0)] {
                assert!((dot(a, b) - expected).abs() < 1e-12, "{axis:?}");
            }
        }
    }
}
