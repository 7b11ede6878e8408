//! A few caps over the lanes of a vector, a node of the rule in each: where a list leaves most lanes empty.

use super::rule::{Grid, Nodes, Ring};
use crate::real::LANES;

/// The nodes of a rule in lanes: those of a disc rule, or the outer ones of a product rule.
#[derive(Clone, Debug)]
pub struct Spread {
    /// The nodes; those that fill up a vector have weight 0.
    pub nodes: Nodes<[f32; LANES], f32>,
    /// Caps in a vector: 1, 2 or 4.
    pub caps: usize,
    /// What a vector of these caps takes, and what one with a cap per lane would, in half evaluations (or rows of them).
    cost: [usize; 2],
}

impl Spread {
    /// Of a rule.
    pub fn new(rule: &Nodes<f64, f64>) -> Self {
        let count = match rule {
            Nodes::Disc(rings) => rings.iter().map(|r| r.azimuths.len()).sum(),
            Nodes::Product(grid) => grid.outer.len(),
        };
        let caps = match count {
            ..=4 => 4,
            5..=8 => 2,
            _ => 1,
        };
        let (lanes, vectors) = (LANES / caps, count.div_ceil(LANES));
        // A number of the node of each lane of a vector; lanes to spare repeat the first node with weight 0.
        let filled = |vector: usize, number: &dyn Fn(usize) -> f64, spare: f64| {
            core::array::from_fn(|lane| {
                let node = vector * LANES + lane % lanes;
                (if node < count { number(node) } else { spare }) as f32
            })
        };
        let nodes = match rule {
            Nodes::Disc(rings) => {
                let node = |r: &Ring<f64>| r.azimuths.iter().map(|&(c, s)| [r.height, r.weight, c, s]).collect::<Vec<_>>();
                let flat: Vec<[f64; 4]> = rings.iter().flat_map(node).collect();
                let ring = |vector: usize| {
                    let number = |k: usize| filled(vector, &|node| flat[node][k], if k == 1 { 0.0 } else { flat[0][k] });
                    Ring { height: number(0), weight: number(1), azimuths: vec![(number(2), number(3))] }
                };
                Nodes::Disc((0..vectors).map(ring).collect())
            }
            Nodes::Product(Grid { outer, inner }) => {
                let (node, weight) = (|i: usize| outer[i].0, |i: usize| outer[i].1);
                Nodes::Product(Grid {
                    outer: (0..vectors).map(|v| (filled(v, &node, outer[0].0), filled(v, &weight, 0.0))).collect(),
                    inner: inner.iter().map(|&(x, w)| (x as f32, w as f32)).collect(),
                })
            }
        };
        // What a vector takes before its first node and after its last is little beside a row of a product rule, but as long
        // as a few evaluations: most of it is waiting.
        let rest = if matches!(rule, Nodes::Disc(_)) { 5 } else { 1 };
        Self { nodes, caps, cost: [2 * vectors + rest, 2 * count + rest] }
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
            Nodes::Product(_) => core::array::from_fn(|k| areas[k * (LANES / self.caps) % LANES]),
        };
        [self.added(sums), areas]
    }

    /// Sums over the lanes of each cap.
    #[inline(always)]
    fn added(&self, lanes: &[f32; LANES]) -> [f32; 4] {
        let [a, b, c, d]: [f32; 4] = core::array::from_fn(|k| {
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

#[cfg(test)]
mod tests {
    use super::super::rule::{RULES, nodes};
    use super::*;

    /// However a rule is spread, its weights and those of its nodes are the same.
    #[test]
    fn nothing_is_lost() {
        for (i, rule) in RULES.iter().enumerate() {
            let (exact, _, spread) = nodes(i);
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
                        add(w, &|l| x[l] * x[l]);
                    }
                    for (x, w) in &grid.outer {
                        lone = [lone[0] + w, lone[1] + w * x * x];
                    }
                }
                _ => panic!("{rule}: another kind"),
            }
            for cap in &many[..spread.caps] {
                assert!(cap.iter().zip(lone).all(|(a, b)| (a - b).abs() < 1e-6), "{rule}: {cap:?} {lone:?}");
            }
        }
    }

    #[test]
    fn caps_are_added_apart() {
        for (i, rule) in RULES.iter().enumerate() {
            let (_, _, spread) = nodes(i);
            let lanes = LANES / spread.caps;
            let numbers = core::array::from_fn(|lane| (1 << (lane / lanes)) as f32);
            let [sums, areas] = spread.collect(&[numbers; 2]);
            for k in 0..spread.caps {
                assert_eq!(sums[k], (lanes << k) as f32, "{rule}");
                let area = if matches!(rule, super::super::Rule::Disc(_)) { lanes << k } else { 1 << k };
                assert_eq!(areas[k], area as f32, "{rule}");
            }
        }
    }
}
