//! The zonal table for caps that are each seen from a direction of its own: one record read at many surfaces.

use super::{Zonal, crosses};
use crate::batch::MIN_HEIGHT;
use crate::cap::{UNIT, projected_solid_angle};
use crate::real::Real;

impl Zonal {
    /// F in sr⁻¹ of a cap for each lane, seen from the direction `wo` of the lane, as [`MeanBrdf::values`] finds it; and 1 where that is so,
    /// 0 where it is to be asked instead: where the horizon cuts a cap that the lobe reaches, and outside of the domain.
    ///
    /// [`MeanBrdf::values`]: crate::mean::MeanBrdf::values
    #[inline(always)]
    pub fn across<T: Real>(&self, axis: [T; 3], solid_angle: T, wo: [T; 3]) -> [T; 2] {
        let [zero, one] = [0.0, 1.0].map(|x| solid_angle.lit(x));
        let height = solid_angle * one.lit(f64::from(0.5 / core::f32::consts::PI));
        let height = height.max(one.lit(f64::from(MIN_HEIGHT))).min(one);
        let reached = self.reached(axis, height, wo);
        let mean =
            self.numerator(axis, height, wo).max(zero) / projected_solid_angle(axis[2], height).max(one.lit(1e-30));
        let whole = T::select(reached, T::select(crosses(axis[2], height), zero, one), one);
        let off = (axis[0].sq() + axis[1].sq() + axis[2].sq() - one).abs();
        let is_cap = T::select(off.lt(one.lit(UNIT)), T::select(axis[2].lt(zero), zero, one), zero);
        let is_above = T::select(zero.lt(wo[2]), one, zero);
        [T::select(reached, mean, zero), whole * is_cap * is_above]
    }
}

#[cfg(test)]
mod tests {
    use crate::batch::CapBatch;
    use crate::mean::MeanBrdf;
    use crate::real::LANES;
    use crate::table::{Representation, Table};
    use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
    use glam::Vec3;

    #[inline(always)]
    fn lanes<S: Simd>(simd: S, table: &super::Zonal, columns: &[[f32; LANES]; 7]) -> [[f32; LANES]; 2] {
        let [x, y, z, angle, wx, wy, wz] = columns.each_ref().map(|c| f32x16::load_array_ref(simd, c));
        table.across([x, y, z], angle, [wx, wy, wz]).map(|lanes| lanes.to_array())
    }

    /// Sixteen caps from sixteen directions, against each alone: the same bits wherever it says so, which is mostly.
    #[test]
    fn lanes_are_those_of_single_caps() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../tables/phong-40.tbl");
        let Representation::Zonal(table) = Table::load(path).unwrap().representation else { panic!("zonal") };
        let (mut plain, mut bright) = (0, 0);
        for i in 0..500 {
            let u = |k: f32, lane: usize| (i as f32 * k + 0.137 * lane as f32 + 17.0 * k).fract();
            let direction = |k: f32, lane: usize| {
                let (z, phi) = (u(k, lane), core::f32::consts::TAU * u(1.7 * k, lane));
                let r = (1.0 - z * z).sqrt();
                Vec3::new(r * phi.cos(), r * phi.sin(), z)
            };
            let wo: [Vec3; LANES] = core::array::from_fn(|lane| direction(0.618, lane));
            // Near the mirror direction, so that there is something to see.
            let axis: [Vec3; LANES] = core::array::from_fn(|lane| {
                let mirror = Vec3::new(-wo[lane].x, -wo[lane].y, wo[lane].z);
                let axis = mirror + 0.4 * (2.0 * direction(0.271, lane) - Vec3::ONE);
                axis.with_z(axis.z.abs()).normalize()
            });
            let angle: [f32; LANES] = core::array::from_fn(|lane| 10f32.powf(-3.0 * u(0.377, lane)));
            let part = |v: &[Vec3; LANES], k: usize| v.map(|v| v[k]);
            let columns =
                [part(&axis, 0), part(&axis, 1), part(&axis, 2), angle, part(&wo, 0), part(&wo, 1), part(&wo, 2)];
            let [values, is_plain] = dispatch!(Level::new(), simd => lanes(simd, &table, &columns));
            for lane in 0..LANES {
                let mut cap = CapBatch::default();
                cap.push_nearest(axis[lane], angle[lane]);
                let mut alone = [0.0];
                table.values(&cap, wo[lane], &mut alone);
                if is_plain[lane] == 1.0 {
                    plain += 1;
                    bright += u32::from(alone[0] > 0.1);
                    assert_eq!(values[lane].to_bits(), alone[0].to_bits(), "{i} {lane}: {} {}", axis[lane], wo[lane]);
                }
            }
        }
        assert!(plain > 4000 && bright > 1000, "{plain} of 8000 plain, {bright} bright");
    }
}
