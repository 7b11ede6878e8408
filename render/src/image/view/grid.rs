//! A function of colour, tabulated as colour management does: on a cube of logarithms, read by tetrahedra.

use rayon::prelude::*;

/// Stops below and above middle grey that the cube spans.
const STOPS: [f64; 2] = [-10.0, 15.0];

/// Middle grey.
pub(super) const GREY: f64 = 0.18;

/// Samples of a function at equal steps of log₂ along each channel, from 10 stops below middle grey to 15 above. OpenColorIO
/// reads its 3D tables so: what lies outside is moved to the faces of the cube, what lies between by tetrahedra.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Samples along an edge.
    size: usize,
    /// Red varies fastest.
    samples: Vec<[f32; 3]>,
}

impl Grid {
    /// Tabulates `f`, which takes linear channels.
    pub fn new(size: usize, f: impl Fn([f64; 3]) -> [f64; 3] + Sync) -> Self {
        let channel = |i: usize| GREY * (STOPS[0] + (STOPS[1] - STOPS[0]) * i as f64 / (size - 1) as f64).exp2();
        let sample = |i: usize| {
            let place = [i % size, i / size % size, i / (size * size)];
            f(place.map(channel)).map(|x| x as f32)
        };
        Self { size, samples: (0..size.pow(3)).into_par_iter().map(sample).collect() }
    }

    /// The function at a colour.
    pub fn at(&self, linear: [f32; 3]) -> [f32; 3] {
        let steps = (self.size - 1) as f32;
        // Channels of no light have no logarithm.
        let place = linear.map(|x| log_encoded(x.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0) * steps);
        let corner = place.map(|x| (x as usize).min(self.size - 2));
        let rest = [0, 1, 2].map(|i| place[i] - corner[i] as f32);
        let stride = [1, self.size, self.size * self.size];
        let mut index: usize = (0..3).map(|i| corner[i] * stride[i]).sum();
        // From the lowest corner to the highest along the edges, the channel with the largest rest first.
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| rest[b].total_cmp(&rest[a]));
        let mut out = self.samples[index].map(|x| x * (1.0 - rest[order[0]]));
        for (k, &axis) in order.iter().enumerate() {
            index += stride[axis];
            let weight = rest[axis] - order.get(k + 1).map_or(0.0, |&next| rest[next]);
            for (out, sample) in out.iter_mut().zip(self.samples[index]) {
                *out += weight * sample;
            }
        }
        out
    }
}

/// 0 … 1 from the bottom to the top of the cube; the logarithm of a positive number.
pub(super) fn log_encoded(x: f32) -> f32 {
    ((f64::from(x) / GREY).log2() - STOPS[0]) as f32 / (STOPS[1] - STOPS[0]) as f32
}

/// The inverse of [`log_encoded`].
#[cfg(test)]
pub(super) fn log_decoded(x: f32) -> f32 {
    (GREY * (STOPS[0] + (STOPS[1] - STOPS[0]) * f64::from(x)).exp2()) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between samples, a function that is linear in the logarithms is met exactly; outside, the nearest face.
    #[test]
    fn reads_what_it_samples() {
        let log = |c: [f64; 3]| c.map(|x| f64::from(log_encoded(x as f32)));
        let mixed = |[r, g, b]: [f64; 3]| [0.5 * r - 2.0 * g + b, g, 0.25 + b - r];
        let grid = Grid::new(9, |c| mixed(log(c)));
        for place in [[0.1, 0.7, 0.3], [0.99, 0.01, 0.5], [0.5, 0.5, 0.5], [0.125, 1.0, 0.0], [0.31, 0.32, 0.33]] {
            let (found, right) = (grid.at(place.map(log_decoded)), mixed(place.map(f64::from)));
            assert!(found.iter().zip(right).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-5), "{place:?} {found:?}");
        }
        assert_eq!(grid.at([0.0, -1.0, 1e30]), grid.at([1e-6, 1e-6, 1e6]));
    }
}
