//! The zonal table: exact for every lobe that is radial about the mirror direction (modified Phong).
//!
//! With m the mirror of wi and δ the angle between `wo` and the mirrored cap axis, ∫ g(m·wo) m dm over a cap lies in the
//! plane of the axis and `wo`, so two functions of (δ, σ) give the mean for every θe and every `wo`:
//!
//!   ∫ f_r cosθi dwi = A (1 − cosⁿ⁺²σ) [T_P cosθe + T_R cosθo],   A = 2πa/(n+2) for f_r = a cosⁿα.
//!
//! T_P and T_R, normalised by the value of P at δ = 0, are tabulated over two coordinates that follow the cap's edge. The
//! oblique basis (axis, `wo`) makes them 0 and 1 where the cap holds the whole lobe, so that the few nodes deep inside a
//! large cap are enough; about the axis alone they would follow cos δ there.
//! Nothing is fitted: the only errors are those of bilinear interpolation and of 16-bit storage.

mod across;

use crate::batch::{CHUNK, CapBatch, MIN_HEIGHT, Picked};
use crate::brdf::Specular;
use crate::cap::{Cap, projected_solid_angle};
use crate::cubature::{Cubature, Rule};
use crate::mean::MeanBrdf;
use crate::parts::PartsError;
use crate::real::{LANES, Real};
use core::f64::consts::PI;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::{DVec3, Vec3};

/// Reach of the table beyond the edge of the cap, in lobe widths 1/√n: the lobe is e⁻¹⁵ there.
pub(crate) const REACH: f64 = 5.5;
/// Largest offset and step of the stored numbers, which are of the order of 1.
const MAX_SCALE: f64 = 1e3;
/// Rule for the part of a cap below the horizon, which the zonal form includes. Broad lobes come with large caps, and with
/// the kink where the lobe ends.
fn clipping_rule(exponent: f64) -> Rule {
    match exponent {
        n if n < 10.0 => Rule::Product(16),
        n if n < 40.0 => Rule::Product(8),
        _ => Rule::Product(6),
    }
}

/// Tabulated (T_P, T_R) over (u, v): u follows the cap's radius, v the distance to its edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Zonal {
    amplitude: f64,
    exponent: f64,
    columns: usize,
    rows: usize,
    /// Row by row in u; T_P in the low 16 bits and T_R in the high ones.
    cells: Vec<u32>,
    /// T = offset + step · bits, for T_P and T_R.
    scale: [[f64; 2]; 2],
    clipped: Cubature,
}

/// Grid coordinates of the zonal table, shared by the builder and the look-up: S = 2√m sin(σ/2) and s = 2√m sin(δ/2)
/// measure the cap's radius and the distance from its axis in lobe widths.
#[derive(Clone, Copy, Debug)]
pub struct ZonalAxes {
    /// m = max(n, 1).
    pub sharpness: f64,
}

impl ZonalAxes {
    /// The axes for a lobe of exponent `n`.
    pub fn new(exponent: f64) -> Self {
        Self { sharpness: exponent.max(1.0) }
    }

    /// S of a cap of height h = 1 − cos σ.
    #[inline(always)]
    fn radius<T: Real>(&self, height: T) -> T {
        (height * height.lit(2.0 * self.sharpness)).sqrt()
    }

    /// s between the mirrored cap axis m and `wo`: |wo − m|² = 2(1 − cos δ), exact for small δ.
    #[inline(always)]
    fn distance<T: Real>(&self, axis: [T; 3], wo: [T; 3]) -> T {
        let d2 = (wo[0] + axis[0]).sq() + (wo[1] + axis[1]).sq() + (wo[2] - axis[2]).sq();
        (d2 * d2.lit(self.sharpness)).sqrt()
    }

    /// u ∈ [0, 1] from S: S/(S + 3) over its value at σ = π/2.
    #[inline(always)]
    fn u<T: Real>(&self, s: T) -> T {
        let top = (2.0 * self.sharpness).sqrt();
        s * (s + s.lit(3.0)).recip() * s.lit((top + 3.0) / top)
    }

    /// A sigmoid of slope 1 at 0: x/√(1 + x²/4).
    #[inline(always)]
    fn edge<T: Real>(x: T) -> T {
        x * (x.sq() * x.lit(0.25) + x.lit(1.0)).sqrt().recip()
    }

    /// Distance beyond the edge at v = 1.
    #[inline(always)]
    fn reach<T: Real>(&self, radius: T) -> T {
        (radius.lit(2.0 * self.sharpness.sqrt()) - radius).min(radius.lit(REACH))
    }

    /// v ≥ 0 from s and S; 1 where the table ends.
    #[inline(always)]
    fn v<T: Real>(&self, s: T, radius: T) -> T {
        let origin = Self::edge(radius);
        (Self::edge(s - radius) + origin) * (Self::edge(self.reach(radius)) + origin).recip()
    }

    /// (σ, δ) in radian at the grid coordinates (u, v): the inverse the builder needs.
    pub fn angles(&self, u: f64, v: f64) -> (f64, f64) {
        let top = (2.0 * self.sharpness).sqrt();
        let x = u * top / (top + 3.0);
        let radius = (3.0 * x / (1.0 - x)).min(top);
        let origin = Self::edge(radius);
        let e = v * (Self::edge(self.reach(radius)) + origin) - origin;
        let s = (radius + e / (1.0 - 0.25 * e * e).sqrt()).max(0.0);
        let half = 0.5 / self.sharpness.sqrt();
        (2.0 * (half * radius).min(1.0).asin(), 2.0 * (half * s).min(1.0).asin())
    }
}

impl Zonal {
    /// A table of `rows` × `columns` pairs (T_P, T_R), row by row in u, for a radial specular model.
    ///
    /// # Errors
    /// The model is not radial, the sizes do not fit, or a scale is out of range.
    pub fn new(
        specular: Specular,
        rows: usize,
        columns: usize,
        cells: Vec<u32>,
        scale: [[f64; 2]; 2],
    ) -> Result<Self, PartsError> {
        let (amplitude, exponent) = specular.radial_exponent().ok_or(PartsError::NotRadial)?;
        if rows < 2 || columns < 2 {
            return Err(PartsError::Size { what: "rows or columns" });
        }
        PartsError::count(rows.checked_mul(columns), cells.len())?;
        PartsError::first("scale", scale.iter().flatten(), |x| x.is_finite() && x.abs() <= MAX_SCALE)?;
        let clipped = Cubature::uniform(specular, clipping_rule(exponent));
        Ok(Self { amplitude, exponent, columns, rows, cells, scale, clipped })
    }

    /// Rows (u), columns (v), the packed pairs and their scale, as [`Zonal::new`] takes them.
    pub fn parts(&self) -> (usize, usize, &[u32], [[f64; 2]; 2]) {
        (self.rows, self.columns, &self.cells, self.scale)
    }

    /// The rule for what the horizon cuts, an index into [`crate::cubature::RULES`].
    #[cfg(feature = "wgsl")]
    pub(crate) fn clipping_rule(&self) -> usize {
        self.clipped.bins().finest()
    }

    /// Whether the lobe seen from `wo` reaches the cap (v < 1), by what that costs least to know.
    #[inline(always)]
    fn reached<T: Real>(&self, axis: [T; 3], height: T, wo: [T; 3]) -> T::Mask {
        let axes = ZonalAxes::new(self.exponent);
        let (radius, s) = (axes.radius(height), axes.distance(axis, wo));
        s.lt(radius + axes.reach(radius))
    }

    /// Numerator of eq. 9 over the whole cap, the part below the horizon (if any) counted as negative.
    #[inline(always)]
    fn numerator<T: Real>(&self, axis: [T; 3], height: T, wo: [T; 3]) -> T {
        let one = height.lit(1.0);
        let axes = ZonalAxes::new(self.exponent);
        let radius = axes.radius(height);
        let v = axes.v(axes.distance(axis, wo), radius);
        // Bilinear look-up; v < 1 in caps that the lobe reaches.
        let (rows, columns) = (one.lit((self.rows - 1) as f64), one.lit((self.columns - 1) as f64));
        let (gu, gv) = ((axes.u(radius) * rows).min(rows), (v * columns).clamp(one.lit(0.0), columns));
        let (iu, iv) = (gu.floor().min(rows - one), gv.floor().min(columns - one));
        let (fu, fv) = (gu - iu, gv - iv);
        let index = iu.mul_add(one.lit(self.columns as f64), iv);
        let (p00, r00) = T::fetch_pair(index, &self.cells);
        let (p01, r01) = T::fetch_pair(index, &self.cells[1..]);
        let (p10, r10) = T::fetch_pair(index, &self.cells[self.columns..]);
        let (p11, r11) = T::fetch_pair(index, &self.cells[self.columns + 1..]);
        let tp = bilinear([p00, p01, p10, p11], fu, fv, self.scale[0]);
        let tr = bilinear([r00, r01, r10, r11], fu, fv, self.scale[1]);

        let sum = tp * axis[2] + tr * wo[2];
        let strength = one.lit(2.0 * PI * self.amplitude / (self.exponent + 2.0));
        strength * self.filled(height) * sum
    }

    /// Whether a cap that crosses the horizon is integrated above it: those cut so deep (axis closer to the horizon than
    /// half the radius) that the part above is the smaller one, whose difference of two larger ones would lose digits, and
    /// those much smaller than the lobe, where a few nodes are exact.
    #[inline(always)]
    fn direct<T: Real>(&self, cz: T, height: T) -> T::Mask {
        let radius2 = height * (cz.lit(2.0) - height);
        let small = height.lt(height.lit(0.1 / self.exponent.max(1.0)));
        T::select(small, cz.lit(0.0), cz.sq()).lt(radius2 * cz.lit(0.25))
    }

    /// 1 − cosⁿ⁺² σ for h = 1 − cos σ, by series where the direct form would cancel.
    #[inline(always)]
    fn filled<T: Real>(&self, h: T) -> T {
        let k = h.lit(self.exponent + 2.0);
        let series = -h * (h.lit(1.0) + h * (h.lit(0.5) + h * (h.lit(1.0 / 3.0) + h * h.lit(0.25))));
        let direct = (h.lit(1.0) - h).max(h.lit(1e-30)).log2() * h.lit(core::f64::consts::LN_2);
        let x = k * T::select(h.lt(h.lit(0.05)), series, direct);
        let small = -x * (h.lit(1.0) + x * (h.lit(0.5) + x * (h.lit(1.0 / 6.0) + x * h.lit(1.0 / 24.0))));
        T::select((-x).lt(h.lit(0.05)), small, h.lit(1.0) - x.exp())
    }
}

/// Between the corners (u, v) = 00, 01, 10, 11, then offset + step · x.
#[inline(always)]
fn bilinear<T: Real>([a, b, c, d]: [T; 4], fu: T, fv: T, [offset, step]: [f64; 2]) -> T {
    let (low, high) = ((b - a).mul_add(fv, a), (d - c).mul_add(fv, c));
    (high - low).mul_add(fu, low).mul_add(a.lit(step), a.lit(offset))
}

/// Whether a cap crosses the horizon: sin²σ > cos²θe.
#[inline(always)]
fn crosses<T: Real>(cz: T, height: T) -> T::Mask {
    cz.sq().lt(height * (cz.lit(2.0) - height))
}

impl MeanBrdf for Zonal {
    fn name(&self) -> &'static str {
        "zonal"
    }

    fn value(&self, cap: &Cap, wo: DVec3) -> f64 {
        let (axis, height) = (cap.axis().to_array(), cap.height().max(f64::from(MIN_HEIGHT)));
        if wo.z <= 0.0 || !self.reached(axis, height, wo.to_array()) {
            return 0.0;
        }
        let crossing = crosses(axis[2], height);
        if crossing && self.direct(axis[2], height) {
            return self.clipped.value(cap, wo);
        }
        let whole = self.numerator(axis, height, wo.to_array());
        let sum = if crossing { self.clipped.clip_value(cap, wo, whole) } else { whole };
        sum.max(0.0) / projected_solid_angle(axis[2], height)
    }

    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        let out = &mut out[..caps.len()];
        if wo.z <= 0.0 {
            return out.fill(0.0);
        }
        dispatch!(Level::new(), simd => batch(simd, self, caps, wo, out));
    }
}

/// Three passes: which caps the lobe reaches at all, the table for those, and the horizon for those that cross it.
#[inline(always)]
fn batch<S: Simd>(simd: S, table: &Zonal, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
    let direction = wo.to_array().map(|x| f32x16::splat(simd, x));
    out.fill(0.0);
    for start in (0..out.len()).step_by(CHUNK) {
        let (mut near, mut nears) = ([0u32; CHUNK], 0);
        for block in (start..out.len().min(start + CHUNK)).step_by(LANES) {
            let [x, y, z, height] = caps.lanes(block).map(|lanes| f32x16::load_array_ref(simd, lanes));
            let reached = table.reached([x, y, z], height, direction);
            let reached = Real::select(reached, z.lit(1.0), z.lit(0.0)).to_array();
            for (i, &reached) in reached[..LANES.min(out.len() - block)].iter().enumerate() {
                near[nears] = (block + i) as u32;
                nears += usize::from(reached > 0.0);
            }
        }
        let mut crossing = Crossing::default();
        let picked = Picked::from_batch(caps, &near[..nears]);
        for place in (0..nears).step_by(LANES) {
            let values = whole_caps(simd, table, picked.lanes(place), wo);
            crossing.sort(&near[place..nears.min(place + LANES)], &values, out);
        }
        let Crossing { cut, mut whole, cuts, direct, directs } = crossing;
        if cuts > 0 {
            table.clipped.clip(simd, &Picked::from_batch(caps, &cut[..cuts]), wo, &mut whole[..cuts]);
        }
        for (&i, &sum) in cut[..cuts].iter().zip(&whole[..cuts]) {
            let out = &mut out[i as usize];
            *out = sum.max(0.0) / *out;
        }
        if directs > 0 {
            let picked = Picked::from_batch(caps, &direct[..directs]);
            table.clipped.means(simd, &picked, directs, wo, |place, value| out[picked.index[place] as usize] = value);
        }
    }
}

/// Caps of a chunk that cross the horizon: those to take the part below away from, with their whole integrals, and those to
/// integrate directly.
struct Crossing {
    cut: [u32; CHUNK],
    whole: [f32; CHUNK],
    cuts: usize,
    direct: [u32; CHUNK],
    directs: usize,
}

impl Default for Crossing {
    fn default() -> Self {
        Self { cut: [0; CHUNK], whole: [0.0; CHUNK], cuts: 0, direct: [0; CHUNK], directs: 0 }
    }
}

impl Crossing {
    /// Stores the means of the caps of `block` that lie above the horizon, and notes the others.
    #[inline(always)]
    fn sort(&mut self, block: &[u32], [sums, areas, depths]: &[[f32; LANES]; 3], out: &mut [f32]) {
        for (k, &i) in block.iter().enumerate() {
            // Where the horizon cuts, the denominator takes the place of the value until the part below is known.
            out[i as usize] = if depths[k] == 0.0 { sums[k].max(0.0) / areas[k].max(1e-30) } else { areas[k] };
            if depths[k] == 1.0 {
                (self.cut[self.cuts], self.whole[self.cuts]) = (i, sums[k]);
                self.cuts += 1;
            } else if depths[k] == 2.0 {
                self.direct[self.directs] = i;
                self.directs += 1;
            }
        }
    }
}

/// Whole integrals of a vector of caps, their projected solid angles, and 0 where the cap lies above the horizon, 1 where the
/// part below is to be taken away, 2 where the part above is to be integrated.
#[inline(always)]
fn whole_caps<S: Simd>(simd: S, table: &Zonal, lanes: [&[f32; LANES]; 4], wo: Vec3) -> [[f32; LANES]; 3] {
    simd.vectorize(
        #[inline(always)]
        || {
            let [x, y, z, height] = lanes.map(|lanes| f32x16::load_array_ref(simd, lanes));
            let wo = wo.to_array().map(|w| f32x16::splat(simd, w));
            let sums = table.numerator([x, y, z], height, wo);
            let depth = Real::select(table.direct(z, height), z.lit(2.0), z.lit(1.0));
            let depth = Real::select(crosses(z, height), depth, z.lit(0.0));
            [sums, projected_solid_angle(z, height), depth].map(|values| values.to_array())
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Phong;

    #[test]
    fn coordinates_are_inverse() {
        for exponent in [0.5, 1.0, 40.0, 1e4] {
            let axes = ZonalAxes::new(exponent);
            for (u, v) in (1..=20).flat_map(|i| (0..=20).map(move |j| (f64::from(i) / 20.0, f64::from(j) / 20.0))) {
                let (sigma, delta) = axes.angles(u, v);
                let radius = axes.radius(2.0 * (0.5 * sigma).sin().powi(2));
                let s = 2.0 * axes.sharpness.sqrt() * (0.5 * delta).sin();
                assert!((axes.u(radius) - u).abs() < 1e-9, "n {exponent}: {u}");
                assert!((axes.v(s, radius) - v).abs() < 1e-7, "n {exponent}: {u} {v}");
            }
            assert!((axes.angles(1.0, 0.0).0 - 0.5 * PI).abs() < 1e-12);
        }
    }

    /// 1 − cosⁿ⁺²σ in both precisions, from the smallest cap to the hemisphere.
    #[test]
    fn filled_keeps_its_digits() {
        for exponent in [1.0, 20.0, 1e4] {
            let phong = Specular::Phong(Phong { exponent });
            let table = Zonal::new(phong, 2, 2, vec![0; 4], [[0.0, 1.0]; 2]).unwrap();
            for h in (0..=60).map(|i| 10f64.powf(-0.2 * f64::from(i))) {
                let exact = -((exponent + 2.0) * (-h).ln_1p()).exp_m1();
                assert!((table.filled(h) / exact - 1.0).abs() < 1e-6, "n {exponent} h {h}");
                assert!((f64::from(table.filled(h as f32)) / exact - 1.0).abs() < 1e-5, "n {exponent} h {h} in f32");
            }
        }
    }

    #[test]
    fn what_is_not_radial_or_not_finite_is_refused() {
        let make = |scale, cells| {
            Zonal::new(Specular::Phong(Phong { exponent: 5.0 }), 2, 2, vec![0; cells], [[0.0, scale]; 2])
        };
        assert!(make(1.0, 4).is_ok() && make(1.0, 5).is_err());
        assert!(make(f64::NAN, 4).is_err() && make(1e9, 4).is_err());
        let rough =
            crate::brdf::ALL.iter().flat_map(|m| (m.examples)()).find(|s| s.radial_exponent().is_none()).unwrap();
        assert!(Zonal::new(rough, 2, 2, vec![0; 4], [[0.0, 1.0]; 2]).is_err());
    }
}
