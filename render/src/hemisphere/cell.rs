//! The subdivision of the hemisphere of Fig. 5 (eas-2015, §3.2): a cap and six sectors, a cap into seven again, a sector
//! into four.

use core::f32::consts::TAU;
use glam::{Vec2, Vec3A};

/// A region of the hemisphere between two heights and two azimuths; a cap where it holds the pole and all azimuths.
///
/// The paper leaves the proportions open. Here all children of a cell have the same solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Smallest and largest cosθ.
    z: [f32; 2],
    /// Azimuths, radian.
    phi: [f32; 2],
}

/// Sectors around the inner cap.
const SECTORS: usize = 6;

/// Most children of a cell.
pub const MAX_CHILDREN: usize = SECTORS + 1;

impl Cell {
    /// The whole hemisphere.
    pub const HEMISPHERE: Self = Self { z: [0.0, 1.0], phi: [0.0, TAU] };

    /// Whether this is a cap around the normal.
    pub fn is_cap(&self) -> bool {
        self.z[1] >= 1.0 && self.phi == [0.0, TAU]
    }

    /// The cells one level below: a cap has seven, a sector four.
    pub fn children(&self) -> impl Iterator<Item = Self> + use<> {
        let cell = *self;
        let count = if cell.is_cap() { MAX_CHILDREN } else { 4 };
        (0..count).map(move |i| cell.child(i))
    }

    fn child(&self, i: usize) -> Self {
        let [low, high] = self.z;
        if self.is_cap() {
            let rim = self.cap_rim();
            if i == 0 {
                return Self { z: [rim, high], phi: self.phi };
            }
            let azimuth = |k: usize| TAU * k as f32 / SECTORS as f32;
            return Self { z: [low, rim], phi: [azimuth(i - 1), azimuth(i)] };
        }
        let (z, phi) = (0.5 * (low + high), 0.5 * (self.phi[0] + self.phi[1]));
        Self {
            z: if i & 1 == 0 { [low, z] } else { [z, high] },
            phi: if i & 2 == 0 { [self.phi[0], phi] } else { [phi, self.phi[1]] },
        }
    }

    /// Height of the inner cap of a cap.
    fn cap_rim(&self) -> f32 {
        self.z[1] - (self.z[1] - self.z[0]) / MAX_CHILDREN as f32
    }

    /// The child that holds the direction with cosine `z` and azimuth `phi` in [0, 2π).
    pub fn child_of(&self, z: f32, phi: f32) -> usize {
        if self.is_cap() {
            return if z >= self.cap_rim() { 0 } else { 1 + ((phi * SECTORS as f32 / TAU) as usize).min(SECTORS - 1) };
        }
        let middle = |[a, b]: [f32; 2]| 0.5 * (a + b);
        usize::from(z >= middle(self.z)) | usize::from(phi >= middle(self.phi)) << 1
    }

    /// Solid angle, sr.
    pub fn solid_angle(&self) -> f32 {
        (self.phi[1] - self.phi[0]) * (self.z[1] - self.z[0])
    }

    /// ∫ cosθ dω over the cell, sr: its area on the base disk.
    pub fn projected_solid_angle(&self) -> f32 {
        0.5 * (self.phi[1] - self.phi[0]) * (self.z[1] * self.z[1] - self.z[0] * self.z[0])
    }

    /// Half angle of the cap of equal solid angle, radian.
    pub fn half_angle(&self) -> f32 {
        cap_half_angle(self.solid_angle())
    }

    /// Unit direction of the middle, local frame.
    pub fn center(&self) -> Vec3A {
        if self.is_cap() { Vec3A::Z } else { self.at(Vec2::splat(0.5), false) }
    }

    /// Direction in the cell, local frame: uniform in solid angle.
    pub fn sample_uniform(&self, u: Vec2) -> Vec3A {
        self.at(u, false)
    }

    /// Direction in the cell, local frame: with a density proportional to cosθ.
    pub fn sample_cosine(&self, u: Vec2) -> Vec3A {
        self.at(u, true)
    }

    fn at(&self, u: Vec2, cosine: bool) -> Vec3A {
        let [low, high] = self.z;
        let z = if cosine { (low * low + u.x * (high * high - low * low)).sqrt() } else { low + u.x * (high - low) };
        let (s, c) = (self.phi[0] + u.y * (self.phi[1] - self.phi[0])).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3A::new(r * c, r * s, z)
    }

    /// Outline on the base disk, for pictures: a closed polygon.
    pub fn outline(&self) -> Vec<Vec2> {
        let radius = |z: f32| (1.0 - z * z).max(0.0).sqrt();
        let (outer, inner) = (radius(self.z[0]), radius(self.z[1]));
        let steps = 8 + (48.0 * (self.phi[1] - self.phi[0]) / TAU) as usize;
        let azimuth = |k: usize| self.phi[0] + (self.phi[1] - self.phi[0]) * k as f32 / steps as f32;
        let arc = |r: f32, k: usize| r * Vec2::from_angle(azimuth(k));
        let mut points: Vec<Vec2> = (0..=steps).map(|k| arc(outer, k)).collect();
        if !self.is_cap() {
            points.extend((0..=steps).rev().map(|k| arc(inner, k)));
        }
        points
    }
}

/// Half angle σ in radian of the cap of solid angle Ω = 2π(1 − cos σ), Ω in sr.
pub fn cap_half_angle(solid_angle: f32) -> f32 {
    2.0 * (0.5 * (solid_angle / TAU).clamp(0.0, 1.0)).sqrt().asin()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::PI;

    /// Cells some levels below, mixed depths.
    fn cells() -> Vec<Cell> {
        let mut cells = vec![Cell::HEMISPHERE];
        for i in 0..40 {
            let cell = cells.remove(i % cells.len());
            cells.extend(cell.children());
        }
        cells
    }

    #[test]
    fn children_tile_their_parent() {
        let cells = cells();
        let sum = |f: fn(&Cell) -> f32| cells.iter().map(f).sum::<f32>();
        assert!((sum(Cell::solid_angle) / TAU - 1.0).abs() < 1e-5);
        assert!((sum(Cell::projected_solid_angle) / PI - 1.0).abs() < 1e-5);
        for cell in &cells {
            for child in cell.children() {
                let share = child.solid_angle() / cell.solid_angle() * cell.children().count() as f32;
                assert!((share - 1.0).abs() < 1e-3, "{cell:?} {child:?}");
            }
        }
    }

    #[test]
    fn samples_find_their_cell() {
        for cell in cells() {
            for (i, child) in cell.children().enumerate() {
                for k in 0..25 {
                    let u = Vec2::new((k % 5) as f32 + 0.5, (k / 5) as f32 + 0.5) / 5.0;
                    for w in [child.sample_uniform(u), child.sample_cosine(u)] {
                        assert!((w.length() - 1.0).abs() < 1e-5);
                        let phi = w.y.atan2(w.x).rem_euclid(TAU);
                        assert_eq!(cell.child_of(w.z, phi), i, "{cell:?} {w}");
                    }
                }
            }
        }
    }

    /// The cosine density is what the projected solid angle says.
    #[test]
    fn cosine_samples_integrate_the_cosine() {
        for cell in cells() {
            let mean: f32 = (0..4096)
                .map(|i| cell.sample_cosine(Vec2::new((i / 64) as f32 + 0.5, (i % 64) as f32 + 0.5) / 64.0).z.recip())
                .sum::<f32>()
                / 4096.0;
            // ∫ dω = A · mean of 1/cosθ under the cosine density.
            let found = mean * cell.projected_solid_angle();
            assert!((found / cell.solid_angle() - 1.0).abs() < 0.05, "{cell:?} {found}");
        }
    }
}
