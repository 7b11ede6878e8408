//! Light sampling, BSDF and both together, for sixteen surfaces at once: `sample_lights` and `Bsdf::sample` of the twin.

use super::columns::{Light, Scattered, Surfaces};
use super::lanes::{Column, Framex16, Vec3x16, lit, power_heuristic};
use super::model::Model;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// A light as its surface sees it.
struct Lit<S: Simd> {
    wi: Vec3x16<S>,
    target: Vec3x16<S>,
    clearance: f32x16<S>,
    radiance: Vec3x16<S>,
    pdf: f32x16<S>,
    any: mask32x16<S>,
}

/// The samples of lights, of which those on lamps are found here.
#[inline(always)]
fn sample_lights<S: Simd>(simd: S, light: &Light, p: Vec3x16<S>, u: [f32x16<S>; 2]) -> Lit<S> {
    let column = |c: &Column| f32x16::load_array_ref(simd, c);
    let vector = |c| Vec3x16::load(simd, c);
    let lanes = |bits: u32| mask32x16::from_bitmask(simd, u64::from(bits));
    let given = Lit {
        wi: vector(&light.wi),
        target: vector(&light.target),
        clearance: column(&light.clearance),
        radiance: vector(&light.radiance),
        pdf: column(&light.pdf),
        any: lanes(light.samples),
    };
    if light.lamps == 0 {
        return given;
    }
    let (zero, half) = (lit(simd, 0.0), lit(simd, 0.5));
    // Triangles fold the square along its diagonal.
    let lower = u[0].simd_lt(u[1]);
    let fold = |a: f32x16<S>, b: f32x16<S>| a - half * b;
    let x = lower.select(half * u[0], fold(u[0], u[1]));
    let y = lower.select(fold(u[1], u[0]), half * u[1]);
    let square = lanes(light.square);
    let (x, y) = (square.select(u[0], x), square.select(u[1], y));
    let target = vector(&light.p0) + vector(&light.e1) * x + vector(&light.e2) * y;
    let to_light = target - p;
    let distance = to_light.length();
    let wi = to_light * (lit(simd, 1.0) / distance);
    let cos = -vector(&light.normal).dot(wi);
    let pdf = distance * distance / (cos * column(&light.area));
    let good = cos.simd_gt(zero) & pdf.simd_gt(zero) & pdf.simd_lt(lit(simd, f32::INFINITY));
    let of_lamp = lanes(light.lamps);
    Lit {
        wi: Vec3x16::select(of_lamp, wi, given.wi),
        target: Vec3x16::select(of_lamp, target, given.target),
        clearance: of_lamp.select(column(&light.lamp_clearance), given.clearance),
        radiance: Vec3x16::select(of_lamp, vector(&light.lamp_radiance), given.radiance),
        pdf: of_lamp.select(pdf * column(&light.probability), given.pdf),
        any: given.any | (of_lamp & good),
    }
}

/// Scatters at all surfaces by the points of [`crate::sampler::Samplers`].
#[inline(always)]
pub fn scatter<S: Simd>(simd: S, at: &Surfaces, light: &Light, points: &[Column; 8], out: &mut Scattered) {
    let column = |c: &Column| f32x16::load_array_ref(simd, c);
    let vector = |c| Vec3x16::load(simd, c);
    let lanes = |bits: u32| mask32x16::from_bitmask(simd, u64::from(bits));
    let (zero, one, infinity) = (lit(simd, 0.0), lit(simd, 1.0), lit(simd, f32::INFINITY));
    let pair = |i: usize| [column(&points[i]), column(&points[4 + i])];
    let p = vector(&at.p);
    let (normal, offset) = (vector(&at.normal), column(&at.offset));
    let frame = Framex16(at.axes.each_ref().map(vector));
    let model = Model::load(simd, at);
    let leave = |towards: f32x16<S>| p + normal * offset.copysign(towards);

    if light.lamps | light.samples == 0 {
        out.lit = 0;
    } else {
        let light_sample = sample_lights(simd, light, p, pair(1));
        let Lit { wi, target, radiance, pdf, .. } = light_sample;
        let value = model.value(frame.to_local(wi));
        let mis = lanes(light.deltas).select(one, power_heuristic(pdf, value.pdf));
        let factor = radiance * (frame.0[2].dot(wi).abs() * mis / pdf);
        let (diffuse, glossy) = (value.diffuse * factor, value.glossy * factor);
        diffuse.store(&mut out.reflected[0]);
        glossy.store(&mut out.reflected[1]);
        let sum = diffuse + glossy;
        let bright = sum.x.max(sum.y).max(sum.z).simd_gt(zero);
        out.lit = (bright & light_sample.any).to_bitmask() as u32;
        // `Interaction::spawn_to` and `spawn`.
        let point = lanes(light.points | light.lamps);
        let ahead = Vec3x16::select(point, target - p, target);
        let origin = leave(normal.dot(ahead));
        let direction = Vec3x16::select(point, target - origin, target);
        let end = lit(simd, 1.0 - 1e-4) - light_sample.clearance / direction.length().max(lit(simd, f32::MIN_POSITIVE));
        origin.store(&mut out.shadow_origin);
        direction.store(&mut out.shadow_direction);
        point.select(end, infinity).store_array(&mut out.shadow_end);
    }

    let (local, some) = model.sample(column(&points[4]), pair(2));
    let value = model.value(local);
    let sampled = some & value.pdf.simd_gt(zero) & value.pdf.simd_lt(infinity);
    let scale = local.z / sampled.select(value.pdf, one);
    (value.diffuse * scale).store(&mut out.weight[0]);
    (value.glossy * scale).store(&mut out.weight[1]);
    let wi = frame.to_world(local);
    wi.store(&mut out.wi);
    leave(normal.dot(wi)).store(&mut out.origin);
    value.pdf.store_array(&mut out.pdf);
    out.sampled = sampled.to_bitmask() as u32;
}
