//! The lobe table as published in 2015 (§3.1): positive lobes (Cx x + Cy y + Cz z)ⁿ, the published grid, and linear
//! interpolation of the coefficients. Kept as the measured baseline.

use crate::batch::CapBatch;
use crate::cap::Cap;
use crate::lobe::Lobe;
use crate::mean::MeanBrdf;
use crate::parts::PartsError;
use crate::real::Real;
use core::f64::consts::{FRAC_PI_2, TAU};
use glam::{DVec3, Vec3};

/// Numbers stored per lobe: Cx, Cy, Cz, n.
pub const RAW_SIZE: usize = 4;

/// No mean is larger: between a large base and a large exponent the interpolated power may overflow.
const LARGEST: f64 = 1e12;

/// `Tab[θe][Ωj]` with θe = e π/(2 #H), 0 < e ≤ #H, and Ωj = j 2π(1 − sin θe)/#AS, 0 < j ≤ #AS.
#[derive(Clone, Debug, PartialEq)]
pub struct Paper {
    elevations: usize,
    solid_angles: usize,
    count: usize,
    /// Per cell, per lobe: Cx, Cy, Cz, n.
    data: Vec<f32>,
}

impl Paper {
    /// From the coefficients of all cells.
    ///
    /// # Errors
    /// Their count is wrong, or one is not usable.
    pub fn new(elevations: usize, solid_angles: usize, count: usize, data: Vec<f32>) -> Result<Self, PartsError> {
        if elevations < 1 || solid_angles < 1 || !(1..=16).contains(&count) {
            return Err(PartsError::Size { what: "rows, solid angles or lobes" });
        }
        let cells = elevations.checked_mul(solid_angles);
        PartsError::count(cells.and_then(|n| n.checked_mul(count * RAW_SIZE)), data.len())?;
        PartsError::first("lobe", data.chunks(RAW_SIZE), |l| l.iter().all(|x| x.is_finite()) && l[3] > 0.0)?;
        Ok(Self { elevations, solid_angles, count, data })
    }

    /// From one list of `count` lobes per cell, in the frame where the cap has azimuth 0.
    ///
    /// # Errors
    /// As [`Paper::new`].
    pub fn from_cells(
        elevations: usize,
        solid_angles: usize,
        count: usize,
        cells: &[Vec<Lobe>],
    ) -> Result<Self, PartsError> {
        let mut data = Vec::new();
        for lobes in cells {
            for k in 0..count {
                let lobe = lobes.get(k).copied().unwrap_or(Lobe { exponent: 1.0, ..Lobe::default() });
                data.extend(lobe.raw().map(|c| c as f32));
                data.push(lobe.exponent as f32);
            }
        }
        Self::new(elevations, solid_angles, count, data)
    }

    /// #H, #AS, lobes per cell and the coefficients, as [`Paper::new`] takes them.
    pub fn parts(&self) -> (usize, usize, usize, &[f32]) {
        (self.elevations, self.solid_angles, self.count, &self.data)
    }

    /// The cap of a cell, e and j counted from 1. The last row has Ω = 0 (θe = π/2): the smallest cap stands for it.
    pub fn cap_at(elevations: usize, solid_angles: usize, e: usize, j: usize) -> Cap {
        let theta = FRAC_PI_2 * e as f64 / elevations as f64;
        let omega = TAU * (1.0 - theta.sin()) * j as f64 / solid_angles as f64;
        Cap::new(theta, 0.0, omega.max(1e-12)).expect("cells lie in the domain")
    }

    /// The lobes at a query, each coefficient interpolated linearly between the closest rows and solid angles; queries
    /// outside the grid take its first or last cell.
    fn interpolated(&self, theta: f64, omega: f64) -> impl Iterator<Item = [f64; RAW_SIZE]> + '_ {
        let e = (theta / FRAC_PI_2 * self.elevations as f64).clamp(1.0, self.elevations as f64);
        let low = (e as usize).min(self.elevations.max(2) - 1);
        let row = move |e: usize| {
            let top = TAU * (1.0 - (FRAC_PI_2 * e as f64 / self.elevations as f64).sin());
            let j = (omega / top.max(1e-12) * self.solid_angles as f64).clamp(1.0, self.solid_angles as f64);
            let low = (j as usize).min(self.solid_angles.max(2) - 1);
            (low, (low + 1).min(self.solid_angles), j - low as f64)
        };
        let high = (low + 1).min(self.elevations);
        let along = e - low as f64;
        (0..self.count).map(move |k| {
            core::array::from_fn(|c| {
                let at = |e: usize, j: usize| {
                    let cell = (e - 1) * self.solid_angles + j - 1;
                    f64::from(self.data[(cell * self.count + k) * RAW_SIZE + c])
                };
                let line = |e: usize| {
                    let (j0, j1, f) = row(e);
                    at(e, j0) * (1.0 - f) + at(e, j1) * f
                };
                line(low) * (1.0 - along) + line(high) * along
            })
        })
    }
}

impl MeanBrdf for Paper {
    fn name(&self) -> &'static str {
        "paper"
    }

    fn value(&self, cap: &Cap, wo: DVec3) -> f64 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        let (sp, cp) = cap.phi().sin_cos();
        let w = DVec3::new(cp * wo.x + sp * wo.y, cp * wo.y - sp * wo.x, wo.z);
        self.interpolated(cap.theta(), cap.solid_angle())
            .map(|[x, y, z, n]| Real::powf(x * w.x + y * w.y + z * w.z, n))
            .sum::<f64>()
            .min(LARGEST)
    }

    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        for (i, out) in out[..caps.len()].iter_mut().enumerate() {
            *out = self.value(&caps.cap(i), wo.as_dvec3()) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{mirror, spherical};

    /// At the nodes the table says what was put in; beyond the grid, what its edge says.
    #[test]
    fn nodes_and_edges() {
        let lobe = |e: usize, j: usize| Lobe {
            axis: mirror(spherical(FRAC_PI_2 * e as f64 / 4.0, 0.0)),
            amplitude: 1.0 + j as f64,
            exponent: 10.0 + e as f64,
        };
        let cells: Vec<Vec<Lobe>> = (1..=4).flat_map(|e| (1..=3).map(move |j| vec![lobe(e, j)])).collect();
        let table = Paper::from_cells(4, 3, 1, &cells).unwrap();
        let wo = spherical(0.8, 2.9);
        for (e, j) in (1..=3).flat_map(|e| (1..=3).map(move |j| (e, j))) {
            let cap = Paper::cap_at(4, 3, e, j);
            assert!((cap.theta() - FRAC_PI_2 * e as f64 / 4.0).abs() < 1e-12);
            assert!((table.value(&cap, wo) / lobe(e, j).value(wo) - 1.0).abs() < 1e-5, "cell {e} {j}");
        }
        let small = Cap::new(FRAC_PI_2 / 4.0, 0.0, 1e-9).unwrap();
        assert!((table.value(&small, wo) / lobe(1, 1).value(wo) - 1.0).abs() < 1e-5);
        let upright = Cap::new(0.0, 0.0, Paper::cap_at(4, 3, 1, 2).solid_angle()).unwrap();
        assert!((table.value(&upright, wo) / lobe(1, 2).value(wo) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn counts_and_numbers_are_checked() {
        let cell = [-0.3f32, 0.0, 0.9, 20.0];
        assert!(Paper::new(2, 2, 1, cell.repeat(4)).is_ok());
        assert!(Paper::new(2, 2, 1, cell.repeat(3)).is_err());
        assert!(Paper::new(usize::MAX, usize::MAX, 16, cell.repeat(4)).is_err());
        assert!(Paper::new(2, 2, 1, [0.0, 0.0, 1.0, 0.0].repeat(4)).is_err(), "exponent 0");
        // A large base on one row and a large exponent on the next.
        let steep = [[1e6f32, 0.0, 1e6, 1.0], [1.0, 0.0, 1.0, 1e6]].as_flattened().to_vec();
        let value = Paper::new(2, 1, 1, steep).unwrap().value(&Cap::new(1.2, 0.0, 0.1).unwrap(), spherical(0.7, 0.0));
        assert!(value.is_finite() && value > 1.0, "{value}");
    }
}
