//! How much fibres on a surface reflect in all.

use brdf_tables::brdf::{Brdf, Sheen};
use core::f64::consts::PI;
use glam::DVec3;

/// Albedo of white fibres by the cosine of the view.
#[derive(Clone, Debug)]
pub(crate) struct FibreTable {
    albedo: [f32; Self::NODES],
}

impl FibreTable {
    /// Nodes at √cos from 0 to 1: the albedo rises towards grazing.
    const NODES: usize = 64;
    /// Points of the midpoint rules over √cos and half of the azimuths.
    const POINTS: [usize; 2] = [96, 48];

    /// By a rule over the hemisphere.
    pub fn new(model: &Sheen) -> Self {
        Self { albedo: core::array::from_fn(|i| Self::integrate(model, i as f64 / (Self::NODES - 1) as f64)) }
    }

    fn integrate(model: &Sheen, root: f64) -> f32 {
        let direction = |cos: f64, azimuth: f64| {
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
        };
        let [rows, columns] = Self::POINTS;
        let wo = direction((root * root).max(1e-4), 0.0);
        let mut sum = 0.0;
        for i in 0..rows {
            let x = (i as f64 + 0.5) / rows as f64;
            // dcos = 2 x dx
            let weight = 2.0 * x * x * x / rows as f64;
            for k in 0..columns {
                let wi = direction(x * x, PI * (k as f64 + 0.5) / columns as f64);
                sum += model.eval(wi, wo) * weight;
            }
        }
        (sum * 2.0 * PI / columns as f64) as f32
    }

    /// Share of light that leaves towards a view.
    #[inline]
    pub fn albedo(&self, cos: f32) -> f32 {
        let x = cos.clamp(0.0, 1.0).sqrt() * (Self::NODES - 1) as f32;
        let i = (x as usize).min(Self::NODES - 2);
        self.albedo[i] + (self.albedo[i + 1] - self.albedo[i]) * (x - i as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::frame::spherical;

    /// The sum over directions that are drawn evenly, which shares no rule with the table.
    #[test]
    fn the_table_is_the_integral() {
        for alpha in [0.07, 0.3, 1.0] {
            let model = Sheen { alpha };
            let table = FibreTable::new(&model);
            for theta in [0.0, 0.5, 1.0, 1.3, 1.45, 1.55] {
                let wo = spherical(theta, 0.0);
                let count = 400_000;
                let value = |i: u32| {
                    let [x, y] = [0.754_877_666, 0.569_840_291].map(|a: f64| (0.5 + f64::from(i) * a).fract());
                    let wi = spherical(x.acos(), 2.0 * PI * y);
                    model.eval(wi, wo) * wi.z * 2.0 * PI
                };
                let sum = (0..count).map(value).sum::<f64>() / f64::from(count);
                let found = f64::from(table.albedo(wo.z as f32));
                assert!((found - sum).abs() < 0.003 + 0.002 * sum, "α {alpha}, {theta}: {found} {sum}");
                assert!(found <= 1.0, "α {alpha}, {theta}: {found}");
            }
        }
    }
}
