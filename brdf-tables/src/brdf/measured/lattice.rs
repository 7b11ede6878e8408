//! Nodes over the unit cube, and interpolation between them.

/// Counts of nodes along the three axes, the last the fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape([usize; 3]);

/// Most nodes along an axis.
const MOST: usize = 256;
/// Most nodes of a lattice.
const MOST_NODES: usize = 400_000;

impl Shape {
    /// Of counts that make a lattice: 2 to 256 along each axis, at most 400 000 in all.
    pub fn new(nodes: [usize; 3]) -> Option<Self> {
        let valid = nodes.iter().all(|n| (2..=MOST).contains(n)) && nodes.iter().product::<usize>() <= MOST_NODES;
        valid.then_some(Self(nodes))
    }

    pub fn nodes(&self) -> [usize; 3] {
        self.0
    }

    pub fn len(&self) -> usize {
        self.0.iter().product()
    }

    pub fn index(&self, at: [usize; 3]) -> usize {
        (at[0] * self.0[1] + at[1]) * self.0[2] + at[2]
    }

    /// Place of a node along each axis.
    pub fn place(&self, index: usize) -> [usize; 3] {
        let [_, d, p] = self.0;
        [index / (d * p), index / p % d, index % p]
    }

    /// Unit coordinates of a node.
    pub fn coordinates(&self, at: [usize; 3]) -> [f64; 3] {
        core::array::from_fn(|k| at[k] as f64 / (self.0[k] - 1) as f64)
    }

    /// The eight nodes about a point, with their weights.
    pub fn corners(&self, x: [f64; 3]) -> [(usize, f64); 8] {
        let mut low = [0; 3];
        let mut way = [0.0; 3];
        for k in 0..3 {
            let at = x[k].clamp(0.0, 1.0) * (self.0[k] - 1) as f64;
            low[k] = (at as usize).min(self.0[k] - 2);
            way[k] = at - low[k] as f64;
        }
        core::array::from_fn(|corner| {
            let up: [usize; 3] = core::array::from_fn(|k| corner >> k & 1);
            let weight = (0..3).map(|k| if up[k] == 1 { way[k] } else { 1.0 - way[k] }).product();
            (self.index(core::array::from_fn(|k| low[k] + up[k])), weight)
        })
    }

    /// The lattice of every `steps`-th node, where the last is one of them.
    pub fn every(&self, steps: [usize; 3]) -> Option<Self> {
        let divides = (0..3).all(|k| (self.0[k] - 1).is_multiple_of(steps[k]));
        divides.then(|| Self(core::array::from_fn(|k| (self.0[k] - 1) / steps[k] + 1)))
    }

    /// What this lattice has at the nodes of one of its [`Shape::every`].
    pub fn pick<T: Copy>(&self, of: &[T], steps: [usize; 3], coarse: &Self) -> Vec<T> {
        let node = |i: usize| {
            let at = coarse.place(i);
            of[self.index(core::array::from_fn(|k| at[k] * steps[k]))]
        };
        (0..coarse.len()).map(node).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_is_kept() {
        let fine = Shape::new([7, 5, 3]).unwrap();
        let f = |[a, b, c]: [f64; 3]| 1.0 + 2.0 * a - b + 0.5 * c;
        let values: Vec<f64> = (0..fine.len()).map(|i| f(fine.coordinates(fine.place(i)))).collect();
        let coarse = fine.every([3, 2, 1]).unwrap();
        assert_eq!(coarse.nodes(), [3, 3, 3]);
        let picked = fine.pick(&values, [3, 2, 1], &coarse);
        for x in [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.3, 0.71, 0.9], [2.0, -1.0, 0.5]] {
            let inside = x.map(|x: f64| x.clamp(0.0, 1.0));
            for (shape, values) in [(&fine, &values), (&coarse, &picked)] {
                let sum: f64 = shape.corners(x).iter().map(|&(i, w)| w * values[i]).sum();
                assert!((sum - f(inside)).abs() < 1e-12);
            }
        }
        assert_eq!(fine.every([4, 1, 1]), None);
        assert_eq!(Shape::new([1, 5, 5]), None);
        assert_eq!(Shape::new([256, 256, 256]), None);
    }
}
