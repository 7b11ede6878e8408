//! Reflection of a record's sources at many points at once: the sources are moved to all of them side by side, and looked up so where the
//! table is zonal.

use super::eas::{Eas, EasRecord, Estimator};
use super::moved::{Near, Receiver, Receivers};
use super::reflector::{Albedo, Reflector};
use super::translate::{Reflected, Scratch, Seen, completed, reflect};
use crate::record::Record;
use crate::scene::Rgb;
use brdf_tables::real::LANES;
use brdf_tables::zonal::Zonal;
use fearless_simd::{Simd, f32x16, prelude::*};
use glam::Vec3A;

/// [`reflect`] by [`Estimator::Improved`] at up to [`LANES`] points at once, each with its reflector, all of one table: the same numbers to
/// the last bit.
pub fn reflect_together(
    record: &EasRecord,
    at: &[(&Receiver, &Reflector)],
    albedo: &Albedo,
    scratches: &mut [Scratch; LANES],
    reflected: impl FnMut(usize, Reflected),
) {
    let block = &at[..at.len().min(LANES)];
    match block.first().and_then(|(_, reflector)| reflector.zonal()) {
        Some((table, _)) => side_by_side(record, block, albedo, table, &mut scratches[0], reflected),
        None if block.is_empty() => (),
        None => one_by_one(record, block, albedo, scratches, reflected),
    }
}

/// Points whose look-ups are side by side, but for those that a source is on the horizon of.
fn side_by_side(
    record: &EasRecord,
    block: &[(&Receiver, &Reflector)],
    albedo: &Albedo,
    table: &Zonal,
    scratch: &mut Scratch,
    mut reflected: impl FnMut(usize, Reflected),
) {
    let mut tint = [[0.0; LANES]; 3];
    for (lane, (_, reflector)) in block.iter().enumerate() {
        let color = reflector.zonal().map_or(Rgb::ZERO, |(_, tint)| tint);
        tint.iter_mut().zip(color.to_array()).for_each(|(column, number)| column[lane] = number);
    }
    let points = Receivers::new(block.iter().map(|(at, _)| *at));
    let mut near = LookedUp { table, tint, specular: [[0.0; LANES]; 3], unit: [0.0; LANES], unsure: 0 };
    let (irradiance, whole) = points.visit(&record.sources, record.position(), albedo, &mut near);
    for (lane, (at, reflector)) in block.iter().enumerate() {
        let part = if near.unsure >> lane & 1 == 1 {
            reflect(record, at, reflector, albedo, Estimator::Improved, scratch)
        } else {
            let color = |columns: &[[f32; LANES]; 3]| Rgb::from_array(columns.each_ref().map(|channel| channel[lane]));
            let light = (color(&irradiance), whole[lane]);
            let seen = (color(&near.specular), near.unit[lane]);
            completed(record, at, (reflector, albedo, Estimator::Improved), light, seen)
        };
        reflected(lane, part);
    }
}

/// Sums of what lobes reflect.
struct LookedUp<'a> {
    table: &'a Zonal,
    tint: [[f32; LANES]; 3],
    specular: [[f32; LANES]; 3],
    /// Of light that is 1 everywhere.
    unit: [f32; LANES],
    /// Points for which a source could not be looked up so.
    unsure: u64,
}

impl Near for LookedUp<'_> {
    #[inline(always)]
    fn seen<S: Simd>(&mut self, simd: S, source: &Eas, moved: [f32x16<S>; 6], wo: [f32x16<S>; 3], lanes: u64) {
        let zero = f32x16::splat(simd, 0.0);
        let [x, y, z, solid_angle, area, is_near] = moved;
        let [mean, is_known] = self.table.across([x, y, z], solid_angle, wo);
        self.unsure |= is_known.simd_le(zero).to_bitmask() & lanes;
        let mean = is_near.simd_gt(zero).select(mean, zero);
        let load = |column: &[f32; LANES]| f32x16::load_array_ref(simd, column);
        for ((sum, tint), light) in self.specular.iter_mut().zip(&self.tint).zip(source.light) {
            let light = f32x16::splat(simd, light) * area * load(tint);
            *sum = (load(sum) + light * mean).to_array();
        }
        self.unit = (load(&self.unit) + area * mean).to_array();
    }
}

/// Points whose look-ups follow one another.
fn one_by_one(
    record: &EasRecord,
    block: &[(&Receiver, &Reflector)],
    albedo: &Albedo,
    scratches: &mut [Scratch; LANES],
    mut reflected: impl FnMut(usize, Reflected),
) {
    scratches.iter_mut().for_each(Scratch::clear);
    let points = Receivers::new(block.iter().map(|(at, _)| *at));
    let mut near = Listed { block, scratches };
    let (irradiance, whole) = points.visit(&record.sources, record.position(), albedo, &mut near);
    for (lane, ((at, reflector), scratch)) in block.iter().zip(&mut *near.scratches).enumerate() {
        let irradiance = Rgb::from_array(irradiance.each_ref().map(|channel| channel[lane]));
        let with = (*reflector, albedo, Estimator::Improved);
        reflected(lane, scratch.reflected(record, at, with, irradiance, whole[lane]));
    }
}

/// Lists of what is to be looked up.
struct Listed<'a> {
    block: &'a [(&'a Receiver, &'a Reflector<'a>)],
    scratches: &'a mut [Scratch; LANES],
}

impl Near for Listed<'_> {
    #[inline(always)]
    fn seen<S: Simd>(&mut self, _: S, source: &Eas, moved: [f32x16<S>; 6], _: [f32x16<S>; 3], lanes: u64) {
        let [x, y, z, solid_angle, area, _] = moved.map(|column| column.to_array());
        let mut left = lanes;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let (at, reflector) = self.block[lane];
            let (direction, area) = (Vec3A::new(x[lane], y[lane], z[lane]), area[lane]);
            let irradiance = Rgb::from_array(source.light) * area;
            let seen = Seen { direction, solid_angle: solid_angle[lane], irradiance };
            self.scratches[lane].add(&seen, area, reflector.tint(direction, at.wo));
        }
    }
}
