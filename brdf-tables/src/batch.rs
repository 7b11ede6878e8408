//! Many caps as a structure of arrays, padded to whole vectors.

use crate::cap::{Cap, CapError, UNIT, check_axis, check_solid_angle};
use crate::real::LANES;
use glam::Vec3;

/// Caps in the local frame of one shading point: axis components and height 1 − cos σ = Ω/2π, each in an array of its own.
#[derive(Clone, Debug, Default)]
pub struct CapBatch {
    pub(crate) axis: [Vec<f32>; 3],
    pub(crate) height: Vec<f32>,
    len: usize,
}

impl CapBatch {
    /// Room for `caps` caps.
    pub fn with_capacity(caps: usize) -> Self {
        let mut batch = Self::default();
        for column in batch.axis.iter_mut().chain([&mut batch.height]) {
            column.reserve(caps.next_multiple_of(LANES));
        }
        batch
    }

    /// Caps held.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets the caps, keeps the memory.
    pub fn clear(&mut self) {
        for column in self.axis.iter_mut().chain([&mut self.height]) {
            column.clear();
        }
        self.len = 0;
    }

    /// Adds a cap around the unit vector `axis` (z ≥ 0) with solid angle Ω in sr, in (0, 2π].
    ///
    /// # Errors
    /// What lies outside of that domain; the batch is then as it was.
    pub fn push(&mut self, axis: Vec3, solid_angle: f32) -> Result<(), CapError> {
        check_axis(axis.as_dvec3())?;
        check_solid_angle(solid_angle.into())?;
        self.push_nearest(axis, solid_angle);
        Ok(())
    }

    /// As [`CapBatch::push`], but for values that rounding, or a move of the point that they are seen from, may have put
    /// outside the domain: they are moved to its edge, so that a look-up never meets one. What is not a direction counts as
    /// the normal, what is not a number as the smallest cap.
    pub fn push_nearest(&mut self, axis: Vec3, solid_angle: f32) {
        // `max`, unlike `clamp`, drops NaN; a comparison with NaN fails.
        let height = (solid_angle * (0.5 / core::f32::consts::PI)).max(MIN_HEIGHT);
        let height = height.min(1.0);
        let inside = (axis.length_squared() - 1.0).abs() < UNIT as f32 && axis.z >= 0.0;
        let axis = if inside { axis } else { axis.with_z(axis.z.max(0.0)).try_normalize().unwrap_or(Vec3::Z) };
        let values = [axis.x, axis.y, axis.z, height];
        let columns = self.axis.iter_mut().chain([&mut self.height]);
        for ((column, value), pad) in columns.zip(values).zip([0.0, 0.0, 1.0, 0.5]) {
            if self.len.is_multiple_of(LANES) {
                column.resize(self.len + LANES, pad);
            }
            column[self.len] = value;
        }
        self.len += 1;
    }

    /// Axis and solid angle of cap `i`.
    pub fn get(&self, i: usize) -> (Vec3, f32) {
        let axis = Vec3::new(self.axis[0][i], self.axis[1][i], self.axis[2][i]);
        (axis, self.height[i] * core::f32::consts::TAU)
    }

    /// Cap `i` in f64.
    pub(crate) fn cap(&self, i: usize) -> Cap {
        let (axis, solid_angle) = self.get(i);
        Cap::around(axis.as_dvec3(), f64::from(solid_angle))
    }

    /// Axis components and height, padded.
    pub(crate) fn columns(&self) -> [&[f32]; 4] {
        let [x, y, z] = &self.axis;
        [x, y, z, &self.height].map(|column| &column[..self.height.len()])
    }

    /// The lanes `[start, start + LANES)`.
    #[inline(always)]
    pub(crate) fn lanes(&self, start: usize) -> [&[f32; LANES]; 4] {
        self.columns().map(|column| column[start..].first_chunk().expect("columns are padded to whole vectors"))
    }
}

/// Below this height (Ω ≈ 6e-13 sr) the mean over the cap is the BRDF itself to f32 precision.
pub(crate) const MIN_HEIGHT: f32 = 1e-13;

/// Caps a look-up treats at a time; fixed, so that it needs no allocation.
pub(crate) const CHUNK: usize = 128;

/// Some caps of a chunk side by side, so that vectors can be loaded from any place in the list.
pub(crate) struct Picked {
    columns: [[f32; CHUNK + LANES]; 4],
    /// Index of each in the batch.
    pub(crate) index: [u32; CHUNK],
}

impl Picked {
    /// An empty list.
    pub(crate) fn new() -> Self {
        Self { columns: [[0.0; CHUNK + LANES]; 4], index: [0; CHUNK] }
    }

    /// The caps of a batch with these indices.
    #[inline(always)]
    pub(crate) fn from_batch(caps: &CapBatch, index: &[u32]) -> Self {
        let (mut picked, columns) = (Self::new(), caps.columns());
        for (place, &i) in index.iter().enumerate() {
            picked.put(place, columns, i);
        }
        picked
    }

    /// Puts cap `i` of the batch at `place`.
    #[inline(always)]
    pub(crate) fn put(&mut self, place: usize, columns: [&[f32]; 4], i: u32) {
        for (column, from) in self.columns.iter_mut().zip(columns) {
            column[place] = from[i as usize];
        }
        self.index[place] = i;
    }

    /// The caps from `place` on, one per lane; what lies beyond the end of the list is to be ignored.
    #[inline(always)]
    pub(crate) fn lanes(&self, place: usize) -> [&[f32; LANES]; 4] {
        self.columns.each_ref().map(|column| column[place..].first_chunk().expect("room for a vector beyond the last"))
    }

    /// Cap `place`: axis and height.
    #[inline(always)]
    pub(crate) fn get(&self, place: usize) -> [f32; 4] {
        self.columns.each_ref().map(|column| column[place])
    }

    /// `count` caps from `place` on, each in `LANES / count` lanes.
    #[inline(always)]
    pub(crate) fn spread(&self, place: usize, count: usize) -> [[f32; LANES]; 4] {
        self.columns.each_ref().map(|column| {
            let first: &[f32; LANES] = column[place..].first_chunk().expect("room for a vector beyond the last");
            match count {
                1 => [first[0]; LANES],
                2 => core::array::from_fn(|lane| first[lane / (LANES / 2)]),
                _ => core::array::from_fn(|lane| first[lane / (LANES / 4)]),
            }
        })
    }
}

impl<'a> FromIterator<&'a Cap> for CapBatch {
    fn from_iter<I: IntoIterator<Item = &'a Cap>>(caps: I) -> Self {
        let mut batch = Self::default();
        for cap in caps {
            batch.push_nearest(cap.axis().as_vec3(), cap.solid_angle() as f32);
        }
        batch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pushed_caps_come_back() {
        let caps: Vec<Cap> = (0..37)
            .map(|i| Cap::with_half_angle(0.04 * f64::from(i), f64::from(i), 0.01 + 0.04 * f64::from(i)).unwrap())
            .collect();
        let batch: CapBatch = caps.iter().collect();
        assert_eq!(batch.len(), 37);
        for (i, cap) in caps.iter().enumerate() {
            let back = batch.cap(i);
            assert!((back.axis() - cap.axis()).length() < 1e-6, "axis {i}");
            assert!((back.solid_angle() / cap.solid_angle() - 1.0).abs() < 1e-6, "solid angle {i}");
        }
        // Lanes beyond the last cap hold one that no look-up trips over.
        let [x, y, z, height] = batch.lanes(32);
        assert_eq!([x[10], y[10], z[10], height[10]], [0.0, 0.0, 1.0, 0.5]);
    }

    #[test]
    fn what_is_outside_moves_to_the_edge() {
        let mut batch = CapBatch::with_capacity(4);
        for (axis, omega) in [(Vec3::NAN, f32::NAN), (Vec3::new(0.6, 0.0, -0.8), 9.0), (Vec3::NEG_Z, -1.0)] {
            let before = batch.len();
            assert!(batch.push(axis, omega).is_err() && batch.len() == before);
            batch.push_nearest(axis, omega);
        }
        let smallest = MIN_HEIGHT * core::f32::consts::TAU;
        assert_eq!(batch.get(0), (Vec3::Z, smallest));
        assert_eq!(batch.get(1), (Vec3::X, core::f32::consts::TAU));
        assert_eq!(batch.get(2), (Vec3::Z, smallest));
        batch.clear();
        assert!(batch.is_empty());
        let slanted = Vec3::new(0.6, 0.0, 0.8);
        assert_eq!(batch.push(slanted, core::f32::consts::TAU), Ok(()));
        assert_eq!(batch.get(0), (slanted, core::f32::consts::TAU));
    }
}
