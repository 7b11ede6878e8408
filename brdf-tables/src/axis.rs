//! Table parameter ↔ grid coordinate: the only definition of the parametrisation.

use crate::cap::Cap;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use serde::{Deserialize, Serialize};

/// Nodes over (θe, φe, Ω). θe is uniform on [0, π/2] and φe on [0, π/2] (every model is symmetric about its two axes);
/// Ω is uniform on [0, 2π] in τ^stretch, τ = ln(1 + nΩ/4π), n being the exponent of a cosine lobe as wide as the
/// material's: stretch 1 suits values, which are linear in small Ω, and ½ what depends on the radius of a cap. The grid
/// includes Ω = 0, where the mean is the BRDF itself, and θe = 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// Nodes in θe, at least 2.
    pub theta: u32,
    /// Nodes in φe: 1 for an isotropic material.
    pub phi: u32,
    /// Nodes in Ω, at least 2.
    pub omega: u32,
    /// The exponent n in τ.
    pub sharpness: f64,
    /// The power of τ in which Ω is uniform, in (0, 1].
    pub stretch: f64,
}

/// A place on an axis: the node below and the fraction of the way to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Index of the lower node.
    pub index: usize,
    /// 0 at the lower node, 1 at the upper.
    pub fraction: f64,
}

/// The place of the coordinate `x` ∈ [0, 1] on an axis of `nodes` nodes.
fn place(x: f64, nodes: u32) -> Place {
    let x = x.clamp(0.0, 1.0) * f64::from(nodes - 1);
    let index = (x as usize).min(nodes.saturating_sub(2) as usize);
    Place { index, fraction: x - index as f64 }
}

impl Axes {
    /// Number of nodes of the whole grid.
    pub fn len(&self) -> usize {
        self.theta as usize * self.phi as usize * self.omega as usize
    }

    /// Whether the grid has no node.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of a node: θe slowest, then φe, then Ω.
    pub fn index(&self, theta: usize, phi: usize, omega: usize) -> usize {
        (theta * self.phi as usize + phi) * self.omega as usize + omega
    }

    /// θe of a node, radian.
    pub fn theta_at(&self, i: usize) -> f64 {
        FRAC_PI_2 * i as f64 / f64::from(self.theta - 1)
    }

    /// φe of a node, radian.
    pub fn phi_at(&self, i: usize) -> f64 {
        if self.phi == 1 { 0.0 } else { FRAC_PI_2 * i as f64 / f64::from(self.phi - 1) }
    }

    /// Ω of a node, sr.
    pub fn omega_at(&self, i: usize) -> f64 {
        let x = i as f64 / f64::from(self.omega - 1);
        (4.0 * PI / self.sharpness * (x.powf(1.0 / self.stretch) * self.top()).exp_m1()).min(TAU)
    }

    /// τ(2π).
    fn top(&self) -> f64 {
        (0.5 * self.sharpness).ln_1p()
    }

    /// Place of a zenith angle.
    pub fn theta_place(&self, theta: f64) -> Place {
        place(theta / FRAC_PI_2, self.theta)
    }

    /// Place of an azimuth, folded into the first quadrant.
    pub fn phi_place(&self, phi: f64) -> Place {
        place(phi.sin().abs().atan2(phi.cos().abs()) / FRAC_PI_2, self.phi)
    }

    /// Place of a solid angle.
    pub fn omega_place(&self, omega: f64) -> Place {
        let x = (self.sharpness * omega.max(0.0) / (4.0 * PI)).ln_1p() / self.top();
        place(x.powf(self.stretch), self.omega)
    }

    /// The cap of a node; its solid angle is kept above zero.
    pub fn cap_at(&self, theta: usize, phi: usize, omega: usize) -> Cap {
        let omega = self.omega_at(omega).max(1e-12);
        Cap::new(self.theta_at(theta), self.phi_at(phi), omega).expect("nodes lie in the domain")
    }

    /// Whether the counts and the exponent make a usable grid of at most `limit` nodes.
    pub fn is_valid(&self, limit: usize) -> bool {
        let nodes = (u64::from(self.theta) * u64::from(self.phi)).saturating_mul(self.omega.into());
        self.theta >= 2
            && self.omega >= 2
            && self.phi >= 1
            && nodes <= limit as u64
            && self.sharpness.is_finite()
            && self.sharpness > 0.0
            && self.stretch > 0.0
            && self.stretch <= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_beyond_64_bits_is_none() {
        let axes = Axes { theta: 1 << 31, phi: 1 << 31, omega: 4, sharpness: 1.0, stretch: 1.0 };
        assert!(!axes.is_valid(1 << 20));
    }

    #[test]
    fn nodes_and_places_are_inverse() {
        for stretch in [1.0, 0.5] {
            check(Axes { theta: 9, phi: 4, omega: 12, sharpness: 200.0, stretch });
        }
    }

    fn check(axes: Axes) {
        for i in 0..9 {
            let p = axes.theta_place(axes.theta_at(i));
            assert!((p.index as f64 + p.fraction - i as f64).abs() < 1e-9);
        }
        for i in 0..4 {
            let p = axes.phi_place(axes.phi_at(i) + PI);
            assert!((p.index as f64 + p.fraction - i as f64).abs() < 1e-9);
        }
        for i in 0..12 {
            let p = axes.omega_place(axes.omega_at(i));
            assert!((p.index as f64 + p.fraction - i as f64).abs() < 1e-9);
        }
        assert_eq!(axes.omega_at(0), 0.0);
        assert!((axes.omega_at(11) - TAU).abs() < 1e-12);
        assert_eq!(Axes { phi: 1, ..axes }.phi_place(1.0), Place { index: 0, fraction: 0.0 });
    }
}
