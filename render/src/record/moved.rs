//! The sources of a record as another point sees them (eas-2015, eqs. 15–16), many at once.

use super::eas::{Eas, cap_sine, softened, unpack_normal};
use super::reflector::Albedo;
use crate::frame::Frame;
use brdf_tables::cap::projected_solid_angle;
use brdf_tables::real::{LANES, Real};
use core::f64::consts::TAU;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::Vec3A;

/// Most a source may grow or shrink on the way to a point of the zone of influence: what is more is not a translation.
pub(crate) const MAX_RATIO: f64 = 4.0;

/// Smallest squared length of the way to a source, in distances of the source from the record.
pub(crate) const MIN_LENGTH2: f32 = 1e-4;

/// The point to shade.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Position, world space.
    pub position: Vec3A,
    /// Local frame of the shading normal.
    pub frame: Frame,
    /// Unit direction to the eye, local frame.
    pub wo: Vec3A,
}

/// Up to [`LANES`] sources seen from a point.
pub(super) struct Moved {
    /// Unit directions, local frame of the point, on the horizon or above it.
    pub direction: [[f32; LANES]; 3],
    /// Solid angles, sr.
    pub solid_angle: [f32; LANES],
    /// Projected solid angles above the horizon, sr; 0 for what is below.
    pub area: [f32; LANES],
    /// 1 where the lobe sees something of the cap, 0 elsewhere.
    pub near: [f32; LANES],
}

impl Moved {
    /// The sources, at most [`LANES`], `offset` away from their record.
    pub fn new(sources: &[Eas], offset: Vec3A, at: &Receiver, albedo: &Albedo) -> Self {
        let mut columns = [[0.0; LANES]; 8];
        for (lane, source) in sources.iter().enumerate() {
            let [x, y, z] = source.direction;
            let [u, v] = source.normal.map(f32::from);
            let row = [x, y, z, source.inv_distance, source.solid_angle, source.factor, u, v];
            columns.iter_mut().zip(row).for_each(|(column, number)| column[lane] = number);
        }
        dispatch!(Level::new(), simd => lanes(simd, &columns, offset, at, albedo))
    }
}

/// Where sources are moved to.
struct Destination<T> {
    /// Way from the record.
    offset: [T; 3],
    /// Axes of the local frame.
    axes: [[T; 3]; 3],
    /// Mirror direction of the eye, local frame.
    mirror: [T; 3],
}

impl<T: Real> Destination<T> {
    /// One point, in the type of `like`.
    #[inline(always)]
    fn one(like: T, offset: Vec3A, at: &Receiver) -> Self {
        let axis = |a: Vec3A| a.to_array().map(|x| like.lit(f64::from(x)));
        let mirror = axis(Vec3A::new(-at.wo.x, -at.wo.y, at.wo.z));
        Self { offset: axis(offset), axes: at.frame.axes().map(axis), mirror }
    }
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, columns: &[[f32; LANES]; 8], offset: Vec3A, at: &Receiver, albedo: &Albedo) -> Moved {
    let source = columns.each_ref().map(|column| f32x16::load_array_ref(simd, column));
    let to = Destination::one(source[0], offset, at);
    let [x, y, z, solid_angle, area, near] = moved(source, &to, albedo.support());
    Moved {
        direction: [x.to_array(), y.to_array(), z.to_array()],
        solid_angle: solid_angle.to_array(),
        area: area.to_array(),
        near: near.to_array(),
    }
}

/// Direction (three numbers), solid angle, projected solid angle and nearness of [`Moved`] from the direction, the inverse
/// distance, the solid angle, the factor and the packed normal of a source.
///
/// The cap keeps its radiance, its solid angle follows eq. 16 with bounded foreshortening, and its irradiance is that of the
/// cap above the horizon, exactly.
#[inline(always)]
fn moved<T: Real>(source: [T; 8], to: &Destination<T>, (cos_s, sin_s): (f32, f32)) -> [T; 6] {
    let [dx, dy, dz, inverse, solid_angle, factor, u, v] = source;
    let (zero, one) = (dx.lit(0.0), dx.lit(1.0));
    let number = |x: f32| one.lit(f64::from(x));
    // The centroid seen from a point `offset` away, C = x + d·direction, in homogeneous form: d = ∞ is a direction only.
    let [ox, oy, oz] = to.offset;
    let toward = [dx - ox * inverse, dy - oy * inverse, dz - oz * inverse];
    let length2 = dot(toward, toward);
    let inverse_length = length2.max(number(MIN_LENGTH2)).sqrt().recip();
    let cos_alpha = -dot(unpack_normal(u, v), toward) * inverse_length;

    let sine = cap_sine(solid_angle);
    let ratio = softened(cos_alpha, sine) * factor * inverse_length.sq();
    let moved_angle = (solid_angle * ratio.clamp(one.lit(1.0 / MAX_RATIO), one.lit(MAX_RATIO))).min(one.lit(TAU));
    let [x, y, z] = to.axes.map(|a| dot(a, toward) * inverse_length);
    // Less than half of a cap is above the horizon: it fades out as it sinks, and its axis stays on the horizon.
    let below = (-z * sine.max(one.lit(1e-12)).recip()).max(zero);
    let height = moved_angle * one.lit(1.0 / TAU);
    let area = projected_solid_angle(z.max(zero), height) * (one - below).sq();
    let along = (x.sq() + y.sq()).max(one.lit(1e-12)).sqrt().recip();
    let sunk = zero.lt(below);
    let direction = [T::select(sunk, x * along, x), T::select(sunk, y * along, y), z.max(zero)];

    // Beyond the support angle s plus the cap's own σ, the lobe sees nothing of it; cos(s + σ) without an angle.
    let (cos_s, sin_s) = (number(cos_s), number(sin_s));
    let cos_r = one - height;
    let sin_r = (height * (one.lit(2.0) - height)).max(zero).sqrt();
    let limit = T::select(cos_r.lt(-cos_s), -one, cos_s * cos_r - sin_s * sin_r);
    let near = T::select(limit.lt(dot(direction, to.mirror)), one, zero);
    let seen = |x: T| {
        let x = T::select(below.lt(one), x, zero);
        T::select(length2.lt(number(MIN_LENGTH2)), zero, x)
    };
    let [x, y, z] = direction;
    [x, y, z, moved_angle, seen(area), seen(near)]
}

/// Up to [`LANES`] points, in columns: position, axes of the frame, mirror direction of the eye. Lanes without a point repeat one.
pub(super) struct Receivers {
    columns: [[f32; LANES]; 15],
    used: u64,
}

impl Receivers {
    /// Of at least one point.
    pub fn new<'a>(points: impl ExactSizeIterator<Item = &'a Receiver>) -> Self {
        let (mut columns, count) = ([[0.0; LANES]; 15], points.len());
        for (lane, at) in points.enumerate() {
            let mirror = Vec3A::new(-at.wo.x, -at.wo.y, at.wo.z);
            let [x, y, z] = at.frame.axes();
            let row = [at.position, x, y, z, mirror].into_iter().flat_map(|v| v.to_array());
            let end = if lane + 1 == count { LANES } else { lane + 1 };
            columns.iter_mut().zip(row).for_each(|(column, number)| column[lane..end].fill(number));
        }
        Self { columns, used: (1 << count) - 1 }
    }

    /// Moves the sources of a record at `position` to all points: the irradiance of each point, and its projected solid angles
    /// together. Tells `near` what the lobes of some points see.
    pub fn visit(
        &self,
        sources: &[Eas],
        position: Vec3A,
        albedo: &Albedo,
        near: &mut impl Near,
    ) -> ([[f32; LANES]; 3], [f32; LANES]) {
        dispatch!(Level::new(), simd => self.lanes(simd, sources, position, albedo, near))
    }

    #[inline(always)]
    fn lanes<S: Simd>(
        &self,
        simd: S,
        sources: &[Eas],
        position: Vec3A,
        albedo: &Albedo,
        near: &mut impl Near,
    ) -> ([[f32; LANES]; 3], [f32; LANES]) {
        let splat = |x: f32| f32x16::splat(simd, x);
        let column = |i: usize| f32x16::load_array_ref(simd, &self.columns[i]);
        let vector = |i: usize| [column(i), column(i + 1), column(i + 2)];
        let [px, py, pz] = vector(0);
        let offset = [px - splat(position.x), py - splat(position.y), pz - splat(position.z)];
        let to = Destination { offset, axes: [vector(3), vector(6), vector(9)], mirror: vector(12) };
        let wo = [-to.mirror[0], -to.mirror[1], to.mirror[2]];
        let (mut irradiance, mut whole) = ([splat(0.0); 3], splat(0.0));
        for source in sources {
            let [x, y, z] = source.direction;
            let [u, v] = source.normal.map(f32::from);
            let row = [x, y, z, source.inv_distance, source.solid_angle, source.factor, u, v];
            let moved = moved(row.map(splat), &to, albedo.support());
            let [.., area, is_near] = moved;
            for (sum, light) in irradiance.iter_mut().zip(source.light) {
                *sum += splat(light) * area;
            }
            whole += area;
            let lanes = is_near.simd_gt(splat(0.0)).to_bitmask() & self.used;
            if lanes != 0 {
                near.seen(simd, source, moved, wo, lanes);
            }
        }
        (irradiance.map(|channel| channel.to_array()), whole.to_array())
    }
}

/// What is done with a source that the lobes of some points see.
pub(super) trait Near {
    /// `moved` is what [`Moved`] holds, `wo` leads to the eye; `lanes` has the bits of those points.
    fn seen<S: Simd>(&mut self, simd: S, source: &Eas, moved: [f32x16<S>; 6], wo: [f32x16<S>; 3], lanes: u64);
}

#[inline(always)]
fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use brdf_tables::table::Table;

    /// Sixteen lanes against f64, from points above, below and beside the sources.
    #[test]
    fn lanes_follow_the_formula() {
        let table = Table::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../tables/phong-40.tbl")).unwrap();
        let albedo = Albedo::new(&table);
        let (mut near, mut apart) = (0, 0);
        for i in 0..400 {
            let u = |k: f32| (i as f32 * k + 31.0 * k).fract();
            let direction = |k: f32| crate::frame::uniform_sphere(glam::Vec2::new(u(k), u(k * 1.7)));
            let own = |k: f32, lane: usize| k + 0.0413 * lane as f32;
            let sources: Vec<Eas> = (0..LANES)
                .map(|lane| Eas {
                    direction: direction(own(0.618, lane)).to_array(),
                    inv_distance: if lane == 3 { 0.0 } else { 2.0 * u(own(0.271, lane)) },
                    light: [1.0; 3],
                    solid_angle: 10f32.powf(-4.0 * u(own(0.377, lane))),
                    normal: [
                        (32767.0 * (2.0 * u(own(0.831, lane)) - 1.0)) as i16,
                        (9000.0 * u(own(0.913, lane))) as i16,
                    ],
                    factor: 1.0 + 2.0 * u(own(0.513, lane)),
                })
                .collect();
            let offset = direction(0.737) * u(0.457);
            let wo = direction(0.347);
            let at = Receiver {
                position: Vec3A::ZERO,
                frame: Frame::from_normal(direction(0.287)),
                wo: Vec3A::new(wo.x, wo.y, wo.z.abs().max(0.01)),
            };
            let lanes = Moved::new(&sources, offset, &at, &albedo);
            for (lane, s) in sources.iter().enumerate() {
                let [x, y, z] = s.direction.map(f64::from);
                let [u, v] = s.normal.map(f64::from);
                let numbers = [s.inv_distance, s.solid_angle, s.factor].map(f64::from);
                let source = [x, y, z, numbers[0], numbers[1], numbers[2], u, v];
                let exact = moved::<f64>(source, &Destination::one(0.0, offset, &at), albedo.support());
                let found = [
                    lanes.direction[0][lane],
                    lanes.direction[1][lane],
                    lanes.direction[2][lane],
                    lanes.solid_angle[lane],
                    lanes.area[lane],
                ];
                for (a, b) in found.iter().zip(exact) {
                    assert!((f64::from(*a) - b).abs() < 2e-4 * b.abs() + 2e-5, "{i} {lane}: {found:?} {exact:?}");
                }
                let length = found[..3].iter().map(|x| x * x).sum::<f32>();
                assert!(lanes.area[lane] == 0.0 || (length - 1.0).abs() < 1e-5, "{i} {lane}: {found:?}");
                near += u32::from(exact[5] > 0.0);
                apart += u32::from(f64::from(lanes.near[lane]) != exact[5]);
            }
        }
        // Rounding decides at the edge of the support only.
        assert!((500..5900).contains(&near) && apart < 10, "{near} of 6400 near, {apart} differ");
    }
}
