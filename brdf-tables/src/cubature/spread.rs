//! The numbers of a rule as look-ups need them: a cap in each lane of a vector, or a few caps over its lanes, a node of the
//! rule in each, where a list leaves most lanes empty.

use super::rule::{Grid, Nodes, RULES, Ring};
use crate::real::LANES;
use core::array::from_fn;
use std::sync::OnceLock;

/// A rule laid over the lanes of a vector, so that one cap fills it.
///
/// A disc rule has one node in each lane, of several vectors if it has more nodes than lanes; a small one is repeated, and each
/// copy serves a cap of its own. A product rule has
/// one of its outer nodes in each lane, and each lane runs through the inner nodes; where there are at least twice as many
/// lanes as outer nodes, several lanes hold the same outer node and divide its inner nodes among them.
#[derive(Clone, Debug)]
pub struct Spread {
    /// The nodes; those that fill up a vector have weight 0.
    pub nodes: Nodes<[f32; LANES]>,
    /// Caps in a vector: 1, 2 or 4.
    pub caps: usize,
    /// What a vector of these caps takes, and what one with a cap per lane would, in evaluations.
    cost: [usize; 2],
}

/// What a vector takes before its first evaluation and after its last: mostly waiting, worth a few of them.
const REST: usize = 3;

impl Spread {
    /// Lays a rule over the lanes.
    pub fn new(rule: &Nodes<f64>) -> Self {
        match rule {
            Nodes::Disc(rings) => {
                let node =
                    |r: &Ring<f64>| r.azimuths.iter().map(|&(c, s)| [r.height, r.weight, c, s]).collect::<Vec<_>>();
                let flat: Vec<[f64; 4]> = rings.iter().flat_map(node).collect();
                let caps = match flat.len() {
                    ..=4 => 4,
                    5..=8 => 2,
                    _ => 1,
                };
                let vectors = flat.len().div_ceil(LANES);
                let ring = |vector: usize| {
                    let node = |lane: usize| vector * LANES + lane % (LANES / caps);
                    // Lanes to spare repeat the first node with weight 0.
                    let spare = [flat[0][0], 0.0, flat[0][2], flat[0][3]];
                    let number = |k: usize| from_fn(|lane| flat.get(node(lane)).unwrap_or(&spare)[k] as f32);
                    Ring { height: number(0), weight: number(1), azimuths: vec![(number(2), number(3))] }
                };
                let cost = [vectors + REST, flat.len() + REST];
                Self { nodes: Nodes::Disc((0..vectors).map(ring).collect()), caps, cost }
            }
            Nodes::Product(Grid { outer, inner }) => {
                let parts = LANES / outer.len();
                let share = inner.len().div_ceil(parts);
                let lane_outer = |lane: usize| {
                    let (x, w) = outer[lane % outer.len()];
                    (x as f32, if lane < parts * outer.len() { w as f32 } else { 0.0 })
                };
                let lane_inner = |k: usize, lane: usize| {
                    let (x, w) = *inner.get(k * parts + lane / outer.len() % parts).unwrap_or(&(inner[0].0, 0.0));
                    (x as f32, w as f32)
                };
                let grid = Grid {
                    outer: vec![(from_fn(|l| lane_outer(l).0), from_fn(|l| lane_outer(l).1))],
                    inner: (0..share)
                        .map(|k| (from_fn(|l| lane_inner(k, l).0), from_fn(|l| lane_inner(k, l).1)))
                        .collect(),
                };
                let cost = [share + REST, outer.len() * inner.len() + REST];
                Self { nodes: Nodes::Product(grid), caps: 1, cost }
            }
        }
    }

    /// Whether so many caps cost less than in a vector with one per lane.
    #[inline(always)]
    pub fn pays(&self, caps: usize) -> bool {
        caps.div_ceil(self.caps) * self.cost[0] < self.cost[1]
    }

    /// Numerators and denominators of the means over the caps of a vector, from those of its lanes.
    #[inline(always)]
    pub fn collect(&self, [sums, areas]: &[[f32; LANES]; 2]) -> [[f32; 4]; 2] {
        let areas = match self.nodes {
            Nodes::Disc(_) => self.added(areas),
            Nodes::Product(_) => [areas[0]; 4],
        };
        [self.added(sums), areas]
    }

    /// Sums over the lanes of each cap.
    #[inline(always)]
    fn added(&self, lanes: &[f32; LANES]) -> [f32; 4] {
        let [a, b, c, d]: [f32; 4] = from_fn(|k| {
            let l = &lanes[4 * k..4 * k + 4];
            (l[0] + l[1]) + (l[2] + l[3])
        });
        match self.caps {
            1 => [(a + b) + (c + d), 0.0, 0.0, 0.0],
            2 => [a + b, c + d, 0.0, 0.0],
            _ => [a, b, c, d],
        }
    }
}

/// The numbers of a rule in each form a look-up needs.
pub struct Numbers {
    /// In f64.
    pub exact: Nodes<f64>,
    /// The same in every lane: a cap per lane.
    pub lanes: Nodes<[f32; LANES]>,
    /// A node per lane.
    pub spread: Spread,
}

/// The numbers of `RULES[index]`.
pub fn numbers(index: usize) -> &'static Numbers {
    static ALL: OnceLock<Vec<Numbers>> = OnceLock::new();
    let build = |&rule| {
        let exact = Nodes::new(rule, |x| x);
        Numbers { spread: Spread::new(&exact), lanes: Nodes::new(rule, |x| [x as f32; LANES]), exact }
    };
    &ALL.get_or_init(|| RULES.iter().map(build).collect())[index]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However a rule is spread, its weights and those of its nodes are the same.
    #[test]
    fn nothing_is_lost() {
        for (i, rule) in RULES.iter().enumerate() {
            let Numbers { exact, spread, .. } = numbers(i);
            let lanes = LANES / spread.caps;
            let (mut lone, mut many) = ([0.0; 2], [[0f64; 2]; 4]);
            let mut add = |weight: &[f32; LANES], value: &dyn Fn(usize) -> f32| {
                for lane in 0..LANES {
                    let (cap, weight) = (lane / lanes, f64::from(weight[lane]));
                    many[cap] = [many[cap][0] + weight, many[cap][1] + weight * f64::from(value(lane))];
                }
            };
            match (&spread.nodes, exact) {
                (Nodes::Disc(spread), Nodes::Disc(rings)) => {
                    for r in spread {
                        add(&r.weight, &|l| r.height[l] * (r.azimuths[0].0[l] + 2.0 * r.azimuths[0].1[l]).powi(2));
                    }
                    for (r, a) in rings.iter().flat_map(|r| r.azimuths.iter().map(move |a| (r, a))) {
                        lone = [lone[0] + r.weight, lone[1] + r.weight * r.height * (a.0 + 2.0 * a.1).powi(2)];
                    }
                }
                (Nodes::Product(spread), Nodes::Product(grid)) => {
                    for (x, w) in &spread.outer {
                        for (y, v) in &spread.inner {
                            add(&from_fn(|l| w[l] * v[l]), &|l| (x[l] + 2.0 * y[l]).powi(2));
                        }
                    }
                    for (x, w) in &grid.outer {
                        for (y, v) in &grid.inner {
                            lone = [lone[0] + w * v, lone[1] + w * v * (x + 2.0 * y).powi(2)];
                        }
                    }
                }
                _ => panic!("{rule}: another kind"),
            }
            for cap in &many[..spread.caps] {
                assert!(cap.iter().zip(lone).all(|(a, b)| (a - b).abs() < 3e-6), "{rule}: {cap:?} {lone:?}");
            }
        }
    }

    #[test]
    fn caps_are_added_apart() {
        for (i, rule) in RULES.iter().enumerate() {
            let spread = &numbers(i).spread;
            let lanes = LANES / spread.caps;
            let numbers = from_fn(|lane| (1 << (lane / lanes)) as f32);
            let [sums, areas] = spread.collect(&[numbers; 2]);
            for k in 0..spread.caps {
                assert_eq!(sums[k], (lanes << k) as f32, "{rule}");
                let area = if matches!(rule, super::super::Rule::Disc(_)) { lanes << k } else { 1 << k };
                assert_eq!(areas[k], area as f32, "{rule}");
            }
        }
    }
}
