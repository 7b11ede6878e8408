//! Luminance and chroma to RGB: Y, RY = (R − Y)/Y, BY = (B − Y)/Y, chroma of every second column and row (OpenEXR's
//! technical introduction, "luminance/chroma images").

use super::super::filled;
use glam::DVec3;

/// Samples of one channel.
pub struct Plane {
    /// Samples per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row.
    pub samples: Vec<f32>,
}

/// Half of the filter that OpenEXR reconstructs chroma with: what the samples 1, 3, 5, … pixels away weigh.
const FILTER: [f32; 7] = [0.627_123, -0.186_077, 0.087_929, -0.043_159, 0.019_597, -0.007_540, 0.002_128];

/// The sample between number `i` and the next one.
fn between(i: usize, count: usize, sample: impl Fn(usize) -> f32) -> f32 {
    let pair = |k: usize| sample(i.saturating_sub(k)) + sample((i + 1 + k).min(count - 1));
    FILTER.iter().enumerate().map(|(k, weight)| weight * pair(k)).sum()
}

impl Plane {
    /// A black one.
    pub fn new(width: usize, height: usize) -> Result<Self, String> {
        Ok(Self { width, height, samples: filled(width * height, 0.0)? })
    }

    /// Twice as many columns.
    fn wider(&self) -> Result<Self, String> {
        let mut wide = Self::new(2 * self.width, self.height)?;
        let rows = wide.samples.chunks_exact_mut(wide.width).zip(self.samples.chunks_exact(self.width));
        for (to, from) in rows {
            for (i, pair) in to.chunks_exact_mut(2).enumerate() {
                pair[0] = from[i];
                pair[1] = between(i, from.len(), |k| from[k]);
            }
        }
        Ok(wide)
    }

    /// Twice as many rows.
    fn higher(&self) -> Result<Self, String> {
        let mut high = Self::new(self.width, 2 * self.height)?;
        for (i, pair) in high.samples.chunks_exact_mut(2 * self.width).enumerate() {
            let (even, odd) = pair.split_at_mut(self.width);
            even.copy_from_slice(&self.samples[i * self.width..][..self.width]);
            for (x, value) in odd.iter_mut().enumerate() {
                *value = between(i, self.height, |k| self.samples[k * self.width + x]);
            }
        }
        Ok(high)
    }

    /// With samples for `width × height` pixels.
    ///
    /// # Errors
    /// Another ratio than 1 or 2.
    pub fn full(mut self, width: usize, height: usize) -> Result<Self, String> {
        if 2 * self.width == width {
            self = self.wider()?;
        }
        if 2 * self.height == height {
            self = self.higher()?;
        }
        if (self.width, self.height) == (width, height) {
            return Ok(self);
        }
        Err("subsampling other than by 2 is not read".into())
    }
}

/// A colour from Y, RY and BY; `weights` are those of red, green and blue in Y.
pub fn rgb([y, ry, by]: [f32; 3], weights: DVec3) -> [f32; 3] {
    let [y, ry, by] = [y, ry, by].map(f64::from);
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    let g = (y - weights.x * r - weights.z * b) / weights.y;
    [r, g, b].map(|c| c as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reconstruction_keeps_constants_and_samples() {
        let plane = |value: fn(usize) -> f32| Plane { width: 20, height: 3, samples: (0..60).map(value).collect() };
        let constant = plane(|_| 0.25).full(40, 6).unwrap();
        assert!(constant.samples.iter().all(|v| (v - 0.25).abs() < 1e-6));
        // A ramp away from the edges: between two samples lies their mean.
        let ramp = plane(|i| (i % 20) as f32).full(40, 6).unwrap();
        assert!((14..26).all(|x| (ramp.samples[2 * 40 + x] - x as f32 / 2.0).abs() < 1e-3));
        assert!(plane(|_| 0.0).full(80, 3).is_err());
    }

    #[test]
    fn colours_come_back() {
        let (weights, right) = (DVec3::new(0.2126, 0.7152, 0.0722), [0.5f32, 0.25, 0.125]);
        let y = (0..3).map(|c| weights[c] as f32 * right[c]).sum::<f32>();
        let found = rgb([y, (right[0] - y) / y, (right[2] - y) / y], weights);
        assert!(found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        assert_eq!(rgb([0.0; 3], weights), [0.0; 3]);
    }
}
