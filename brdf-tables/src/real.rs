//! One number type for scalar and vector code.
//!
//! A BRDF or a quadrature rule written over [`Real`] compiles to an f64 reference, to f32, and to sixteen f32 lanes: the
//! readable twin and the fast path are the same source, and differ only in precision.

use core::ops::{Add, Div, Mul, Neg, Sub};
use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, f32x16, i32x16, prelude::*, u32x4, u32x16};

mod pair;
#[cfg(test)]
mod tests;

pub use pair::Pair;

/// Lanes of the vector instance of [`Real`].
pub const LANES: usize = 16;

/// Four pairs of 16-bit numbers, the first of each in the low half.
pub type Cell = [u32; 4];

/// A constant of a formula in both precisions: to convert it costs more than to use it where that is for one vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    wide: f64,
    narrow: f32,
}

#[cfg(feature = "wgsl")]
impl Constant {
    pub(crate) fn wide(self) -> f64 {
        self.wide
    }
}

impl From<f64> for Constant {
    fn from(x: f64) -> Self {
        Self { wide: x, narrow: x as f32 }
    }
}

/// The degree-6 minimax polynomial of 2^f on [−½, ½], the highest coefficient first (relative error 2e-8).
pub const EXP2: [f64; 7] =
    [1.535_336e-4, 1.339_887e-3, 9.618_437e-3, 5.550_332_6e-2, 2.402_264_8e-1, 6.931_472e-1, 1.0];
/// p of ln(1 + f) = f − f²/2 + f³ p(f) for 1 + f in [√½, √2) (Cephes logf).
pub const LN: [f64; 9] = [
    7.037_683_6e-2,
    -1.151_461e-1,
    1.167_699_9e-1,
    -1.242_014_1e-1,
    1.424_932_3e-1,
    -1.666_805_8e-1,
    2.000_071_5e-1,
    -2.499_999_4e-1,
    3.333_333_1e-1,
];
/// p of asin x = x + x³ p(x²) for |x| ≤ ½ (Cephes asinf).
pub(crate) const ASIN: [f64; 5] = [4.216_32e-2, 2.418_131_1e-2, 4.547_002_6e-2, 7.495_300_3e-2, 1.666_675_2e-1];
/// p of sin h = h + h³ p(h²) for |h| ≤ π/2, by its series.
pub(crate) const SIN: [f64; 5] = [-2.505_210_8e-8, 2.755_731_9e-6, -1.984_127e-4, 8.333_333_3e-3, -1.666_666_7e-1];
/// cos h in h², likewise.
pub(crate) const COS: [f64; 7] =
    [2.087_675_7e-9, -2.755_731_9e-7, 2.480_158_7e-5, -1.388_888_9e-3, 4.166_666_7e-2, -0.5, 1.0];

/// The polynomial with these coefficients, the highest first.
#[inline(always)]
fn horner<T: Real, const N: usize>(coefficients: &[f64; N], x: T) -> T {
    let mut sum = x.lit(coefficients[0]);
    for c in &coefficients[1..] {
        sum = sum.mul_add(x, x.lit(*c));
    }
    sum
}

/// A real number, or several of them in lanes.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A truth value per lane.
    type Mask: Copy;
    /// All lanes in memory.
    type Lanes;
    /// From memory.
    fn load(self, lanes: &Self::Lanes) -> Self;
    /// The constant `x`, in the type of `self`.
    fn lit(self, x: f64) -> Self;
    /// The same for a constant that is not known when the code is compiled.
    fn constant(self, x: Constant) -> Self;
    /// `self · a + b`.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Square root; the argument must not be negative.
    fn sqrt(self) -> Self;
    /// The smaller of two numbers.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
    /// Whether `self < other`, per lane.
    fn lt(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Whether the mask holds in any lane.
    fn any(mask: Self::Mask) -> bool;
    /// 1/self of a normal number; in lanes by the processor's approximation and one Newton step (relative error below
    /// 1e-6, and no divider, which is the busiest unit of a rational formula).
    fn recip(self) -> Self;
    /// The largest integer not above `self`.
    fn floor(self) -> Self;
    /// The low and the high half of `table[index]`, per lane; the index holds non-negative integers and is kept in range.
    fn fetch_pair(index: Self, table: &[u32]) -> (Self, Self);
    /// The four pairs of `table[index]`, a number n as 1 + n/65536.
    fn fetch_cell(index: Self, table: &[Cell]) -> [[Self; 2]; 4];
    /// 2 to the power `self`; zero below −126 in the f32 types.
    fn exp2(self) -> Self;
    /// Base-2 logarithm of a positive, normal number.
    fn log2(self) -> Self;

    /// Arc sine of a number in [−1, 1].
    fn asin(self) -> Self;
    /// Sine and cosine of an angle in [−π, π].
    fn sin_cos(self) -> (Self, Self);

    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        self.max(-self)
    }
    /// `self²`.
    #[inline(always)]
    fn sq(self) -> Self {
        self * self
    }
    /// `self^n` for a base clamped at zero; `0^n = 0`.
    #[inline(always)]
    fn powf(self, n: Self) -> Self {
        let tiny = self.lit(1e-30);
        Self::select(self.lt(tiny), self.lit(0.0), (n * self.max(tiny).log2()).exp2())
    }
    /// e to the power `self`.
    #[inline(always)]
    fn exp(self) -> Self {
        (self * self.lit(core::f64::consts::LOG2_E)).exp2()
    }
    /// `self` limited to `[lo, hi]`.
    #[inline(always)]
    fn clamp(self, lo: Self, hi: Self) -> Self {
        self.max(lo).min(hi)
    }
}

macro_rules! scalar {
    ($t:ident, $precision:ident) => {
        impl Real for $t {
            type Mask = bool;
            type Lanes = $t;
            #[inline(always)]
            fn load(self, lanes: &$t) -> $t {
                *lanes
            }
            #[inline(always)]
            fn lit(self, x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn constant(self, x: Constant) -> Self {
                x.$precision
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                // Without a hardware instruction the fused form is a slow library call.
                self * a + b
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $t::sqrt(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn any(mask: bool) -> bool {
                mask
            }
            #[inline(always)]
            fn recip(self) -> Self {
                1.0 / self
            }
            #[inline(always)]
            fn floor(self) -> Self {
                $t::floor(self)
            }
            #[inline(always)]
            fn fetch_pair(index: Self, table: &[u32]) -> (Self, Self) {
                let pair = table[(index as usize).min(table.len() - 1)];
                ((pair & 0xffff) as $t, (pair >> 16) as $t)
            }
            #[inline(always)]
            fn fetch_cell(index: Self, table: &[Cell]) -> [[Self; 2]; 4] {
                table[(index as usize).min(table.len() - 1)]
                    .map(|pair| [pair & 0xffff, pair >> 16].map(|half| 1.0 + half as $t / 65536.0))
            }
            #[inline(always)]
            fn exp2(self) -> Self {
                $t::exp2(self)
            }
            #[inline(always)]
            fn log2(self) -> Self {
                $t::log2(self)
            }
            #[inline(always)]
            fn asin(self) -> Self {
                $t::asin(self)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $t::sin_cos(self)
            }
        }
    };
}
scalar!(f64, wide);
scalar!(f32, narrow);

/// The entries of a table for four lanes, side by side.
#[inline(always)]
fn four<S: Simd>(simd: S, table: &[Cell], at: &[u32; LANES], first: usize) -> u32x16<S> {
    let (a, b) = (&table[at[first] as usize], &table[at[first + 1] as usize]);
    let (c, d) = (&table[at[first + 2] as usize], &table[at[first + 3] as usize]);
    let (a, b) = (u32x4::load_array_ref(simd, a), u32x4::load_array_ref(simd, b));
    let (c, d) = (u32x4::load_array_ref(simd, c), u32x4::load_array_ref(simd, d));
    a.combine(b).combine(c.combine(d))
}

/// The low and the high halves of pairs, as the leading digits of numbers from 1 to 2: which needs no conversion.
#[inline(always)]
fn halves<S: Simd>(pair: u32x16<S>) -> [f32x16<S>; 2] {
    const ONE: u32 = 0x3f80_0000;
    const DIGITS: u32 = 0xffff << 7;
    [((pair << 7) & DIGITS | ONE).bitcast(), ((pair >> 9) & DIGITS | ONE).bitcast()]
}

impl<S: Simd> Real for f32x16<S> {
    type Mask = <Self as SimdBase<S>>::Mask;
    type Lanes = [f32; LANES];
    #[inline(always)]
    fn load(self, lanes: &[f32; LANES]) -> Self {
        Self::load_array_ref(self.simd, lanes)
    }
    #[inline(always)]
    fn lit(self, x: f64) -> Self {
        Self::splat(self.simd, x as f32)
    }
    #[inline(always)]
    fn constant(self, x: Constant) -> Self {
        Self::splat(self.simd, x.narrow)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        SimdFloat::mul_add(self, a, b)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        SimdFloat::sqrt(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        SimdBase::min(self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        SimdBase::max(self, other)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        self.simd_lt(other)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Select::select(mask, yes, no)
    }
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.any_true()
    }
    #[inline(always)]
    fn floor(self) -> Self {
        SimdFloat::floor(self)
    }
    #[inline(always)]
    fn fetch_pair(index: Self, table: &[u32]) -> (Self, Self) {
        let simd = index.simd;
        let at: u32x16<S> = index.to_int();
        let mut pairs = at.min((table.len() - 1) as u32).to_array();
        // A plain loop of loads: the compiler keeps it branch-free, and no processor gathers much faster.
        for pair in &mut pairs {
            *pair = table[*pair as usize];
        }
        let pairs = u32x16::load_array(simd, pairs);
        ((pairs & 0xffff).to_float(), (pairs >> 16).to_float())
    }
    #[inline(always)]
    fn fetch_cell(index: Self, table: &[Cell]) -> [[Self; 2]; 4] {
        let simd = index.simd;
        // Signed numbers are converted by one instruction everywhere; as unsigned ones the negative are large.
        let at: u32x16<S> = index.to_int::<i32x16<S>>().bitcast();
        let at = at.min((table.len() - 1) as u32).to_array();
        let (a, b, c, d) = (
            four(simd, table, &at, 0),
            four(simd, table, &at, 4),
            four(simd, table, &at, 8),
            four(simd, table, &at, 12),
        );
        // Each vector holds the pairs of four lanes; even places and odd ones, twice, part them by their number.
        let (even, even_rest) = (a.unzip_low(b), c.unzip_low(d));
        let (odd, odd_rest) = (a.unzip_high(b), c.unzip_high(d));
        [
            halves(even.unzip_low(even_rest)),
            halves(odd.unzip_low(odd_rest)),
            halves(even.unzip_high(even_rest)),
            halves(odd.unzip_high(odd_rest)),
        ]
    }
    #[inline(always)]
    fn recip(self) -> Self {
        let y = self.approximate_recip();
        y * Real::mul_add(-self, y, self.lit(2.0))
    }
    /// Magic-number split into integer and fraction, then [`EXP2`].
    #[inline(always)]
    fn exp2(self) -> Self {
        let x = Real::max(Real::min(self, self.lit(126.0)), self.lit(-126.0));
        let magic = self.lit(12_582_912.0); // 1.5 · 2^23: adding it rounds to an integer held in the low mantissa bits
        let shifted = x + magic;
        let f = x - (shifted - magic);
        let p = horner(&EXP2, f);
        let bits: i32x16<S> = shifted.bitcast();
        let scaled: i32x16<S> = p.bitcast::<i32x16<S>>() + (bits << 23);
        Real::select(self.lt(self.lit(-126.0)), self.lit(0.0), scaled.bitcast())
    }
    /// Mantissa to [√½, √2), then the Cephes degree-8 polynomial of ln(1 + f) (relative error 1e-7 away from 1).
    #[inline(always)]
    fn log2(self) -> Self {
        let bits: i32x16<S> = self.bitcast();
        // Subtracting the bits of √½ leaves the exponent of the reduced mantissa in the upper nine bits.
        let exponent = (bits - 0x3f35_04f3) >> 23;
        let mantissa: Self = (bits - (exponent << 23)).bitcast();
        let f = mantissa - self.lit(1.0);
        let p = horner(&LN, f);
        let z = f * f;
        let ln = Real::mul_add(p * z, f, f - z * self.lit(0.5));
        Real::mul_add(ln, self.lit(core::f64::consts::LOG2_E), exponent.to_float())
    }
    /// Cephes asinf: a polynomial to ½, and asin x = π/2 − 2 asin √((1 − x)/2) above.
    #[inline(always)]
    fn asin(self) -> Self {
        let a = Real::abs(self);
        let large = self.lit(0.5).lt(a);
        let z = Real::select(large, self.lit(0.5) * Real::abs(self.lit(1.0) - a), a * a);
        let x = Real::select(large, Real::sqrt(z), a);
        let p = horner(&ASIN, z);
        let r = Real::mul_add(p * z, x, x);
        let r = Real::select(large, self.lit(core::f64::consts::FRAC_PI_2) - (r + r), r);
        Real::select(self.lt(self.lit(0.0)), -r, r)
    }
    /// Taylor series of the half angle (|x| ≤ π/2, error below 6e-8), then the double-angle formulas.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let h = self * self.lit(0.5);
        let z = h * h;
        let s = horner(&SIN, z);
        let s = Real::mul_add(s * z, h, h);
        let c = horner(&COS, z);
        let two = self.lit(2.0);
        (two * s * c, (c - s) * (c + s))
    }
}
