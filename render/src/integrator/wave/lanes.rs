//! Sixteen numbers at once, and the functions of [`crate::math`] and [`crate::frame`] over them. Nothing is fused or approximated
//! by the processor, so every machine has the same bytes.

use brdf_tables::real::{EXP2, LN};
use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, LOG2_E};
use core::ops::{Add, Mul, Neg, Sub};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

/// Paths of a block.
pub const LANES: usize = 16;

/// A number of each path.
pub type Column = [f32; LANES];

/// A vector of each path, by coordinate.
pub type Column3 = [Column; 3];

/// Sixteen vectors.
#[derive(Clone, Copy)]
pub struct Vec3x16<S: Simd> {
    pub x: f32x16<S>,
    pub y: f32x16<S>,
    pub z: f32x16<S>,
}

impl<S: Simd> Vec3x16<S> {
    #[inline(always)]
    pub fn load(simd: S, column: &Column3) -> Self {
        let [x, y, z] = column;
        Self {
            x: f32x16::load_array_ref(simd, x),
            y: f32x16::load_array_ref(simd, y),
            z: f32x16::load_array_ref(simd, z),
        }
    }

    #[inline(always)]
    pub fn store(self, column: &mut Column3) {
        self.x.store_array(&mut column[0]);
        self.y.store_array(&mut column[1]);
        self.z.store_array(&mut column[2]);
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> f32x16<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn length(self) -> f32x16<S> {
        self.dot(self).sqrt()
    }

    #[inline(always)]
    pub fn select(mask: mask32x16<S>, yes: Self, no: Self) -> Self {
        Self { x: mask.select(yes.x, no.x), y: mask.select(yes.y, no.y), z: mask.select(yes.z, no.z) }
    }
}

impl<S: Simd> Add for Vec3x16<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<S: Simd> Sub for Vec3x16<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<S: Simd> Mul<f32x16<S>> for Vec3x16<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f32x16<S>) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

impl<S: Simd> Mul for Vec3x16<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self { x: self.x * o.x, y: self.y * o.y, z: self.z * o.z }
    }
}

impl<S: Simd> Neg for Vec3x16<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

/// The axes of a local frame; z is the normal.
#[derive(Clone, Copy)]
pub struct Framex16<S: Simd>(pub [Vec3x16<S>; 3]);

impl<S: Simd> Framex16<S> {
    /// [`crate::frame::Frame::from_normal`].
    #[inline(always)]
    pub fn from_normal(n: Vec3x16<S>) -> Self {
        let one = lit(n.x.simd, 1.0);
        let s = one.copysign(n.z);
        let a = -one / (s + n.z);
        let b = n.x * n.y * a;
        let x = Vec3x16 { x: one + s * n.x * n.x * a, y: s * b, z: -s * n.x };
        let y = Vec3x16 { x: b, y: s + n.y * n.y * a, z: -n.y };
        Self([x, y, n])
    }

    #[inline(always)]
    pub fn to_world(self, v: Vec3x16<S>) -> Vec3x16<S> {
        self.0[0] * v.x + self.0[1] * v.y + self.0[2] * v.z
    }

    #[inline(always)]
    pub fn to_local(self, v: Vec3x16<S>) -> Vec3x16<S> {
        Vec3x16 { x: self.0[0].dot(v), y: self.0[1].dot(v), z: self.0[2].dot(v) }
    }
}

/// A constant.
#[inline(always)]
pub fn lit<S: Simd>(simd: S, x: f32) -> f32x16<S> {
    f32x16::splat(simd, x)
}

/// The value of a polynomial, coefficients from the highest power on.
#[inline(always)]
fn polynomial<S: Simd, const N: usize>(x: f32x16<S>, coefficients: [f32; N]) -> f32x16<S> {
    coefficients.into_iter().map(|c| lit(x.simd, c)).reduce(|p, c| p * x + c).unwrap_or(x)
}

/// [`crate::math::sin_cos_octant`].
#[inline(always)]
fn sin_cos_octant<S: Simd>(x: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    let y = x * x;
    let sin = x * polynomial(y, [1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0]);
    (sin, polynomial(y, [1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0]))
}

/// [`crate::math::sin_cos_turn`].
#[inline(always)]
pub fn sin_cos_turn<S: Simd>(u: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    let simd = u.simd;
    let quarter = (lit(simd, 4.0) * u + lit(simd, 0.5)).floor();
    let (s, c) = sin_cos_octant(lit(simd, FRAC_PI_2) * (lit(simd, 4.0) * u - quarter));
    let quarter: u32x16<S> = quarter.to_int();
    let even = (quarter & 1).simd_eq(0);
    let (s, c) = (even.select(s, c), even.select(c, s));
    ((quarter & 2).simd_eq(0).select(s, -s), ((quarter + 1) & 2).simd_eq(0).select(c, -c))
}

/// [`crate::frame::cosine_hemisphere`].
#[inline(always)]
pub fn cosine_hemisphere<S: Simd>(u: [f32x16<S>; 2]) -> Vec3x16<S> {
    let (zero, one, two) = (lit(u[0].simd, 0.0), lit(u[0].simd, 1.0), lit(u[0].simd, 2.0));
    let (px, py) = (two * u[0] - one, two * u[1] - one);
    let wide = px.abs().simd_gt(py.abs());
    let (r, other) = (wide.select(px, py), wide.select(py, px));
    let middle = r.simd_eq(zero);
    let (s, c) = sin_cos_octant(lit(r.simd, FRAC_PI_4) * (other / middle.select(one, r)));
    let (x, y) = (r * wide.select(c, s), r * wide.select(s, c));
    Vec3x16 { x, y, z: (one - (x * x + y * y)).max(zero).sqrt() }
}

/// 2 to the power x: the polynomial of `brdf-tables`; zero below −126.
#[inline(always)]
pub fn exp2<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    let (low, magic) = (lit(x.simd, -126.0), lit(x.simd, 12_582_912.0));
    let kept = x.min(lit(x.simd, 126.0)).max(low);
    // 1.5 · 2²³: adding it rounds to an integer held in the low mantissa bits.
    let shifted = kept + magic;
    let f = kept - (shifted - magic);
    let bits: i32x16<S> = shifted.bitcast();
    let scaled: i32x16<S> = polynomial(f, EXP2.map(|c| c as f32)).bitcast::<i32x16<S>>() + (bits << 23);
    x.simd_lt(low).select(lit(x.simd, 0.0), scaled.bitcast())
}

/// Base-2 logarithm of a positive, normal number: the polynomial of `brdf-tables`.
#[inline(always)]
pub fn log2<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    let bits: i32x16<S> = x.bitcast();
    // Subtracting the bits of √½ leaves the exponent of the reduced mantissa in the upper nine bits.
    let exponent = (bits - 0x3f35_04f3) >> 23;
    let mantissa: f32x16<S> = (bits - (exponent << 23)).bitcast();
    let f = mantissa - lit(x.simd, 1.0);
    let z = f * f;
    let ln = polynomial(f, LN.map(|c| c as f32)) * z * f + (f - z * lit(x.simd, 0.5));
    let exponent: f32x16<S> = exponent.to_float();
    ln * lit(x.simd, LOG2_E) + exponent
}

/// `x^n` for a base clamped at zero; `0^n = 0`.
#[inline(always)]
pub fn powf<S: Simd>(x: f32x16<S>, n: f32x16<S>) -> f32x16<S> {
    let tiny = lit(x.simd, 1e-30);
    x.simd_lt(tiny).select(lit(x.simd, 0.0), exp2(n * log2(x.max(tiny))))
}

/// [`crate::light::power_heuristic`].
#[inline(always)]
pub fn power_heuristic<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (lit(a.simd, 0.0), lit(a.simd, 1.0));
    let (a2, b2) = (a * a, b * b);
    let sum = a2 + b2;
    let plain = sum.simd_gt(zero) & a2.simd_lt(lit(a.simd, f32::INFINITY));
    plain.select(a2 / sum, a.simd_ge(b).select(one, zero))
}
