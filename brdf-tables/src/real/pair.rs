//! Two numbers side by side, so that a processor has the operations of one to do while those of the other wait.

use super::{Cell, Constant, Real};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Two numbers. What is done with it is done with either, one operation after the other: a formula is a long chain of
/// operations each of which waits for the one before, and a processor looks ahead by little more than one chain.
#[derive(Clone, Copy, Debug)]
pub struct Pair<T>(pub T, pub T);

macro_rules! operators {
    ($($operator:ident $function:ident,)+) => {$(
        impl<T: Real> $operator for Pair<T> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0), self.1.$function(other.1))
            }
        }
    )+};
}
operators! { Add add, Sub sub, Mul mul, Div div, }

impl<T: Real> Neg for Pair<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

/// Functions of one number.
macro_rules! unary {
    ($($function:ident)+) => {$(
        #[inline(always)]
        fn $function(self) -> Self {
            Self(self.0.$function(), self.1.$function())
        }
    )+};
}

impl<T: Real> Real for Pair<T> {
    type Mask = (T::Mask, T::Mask);
    type Lanes = (T::Lanes, T::Lanes);
    #[inline(always)]
    fn load(self, lanes: &Self::Lanes) -> Self {
        Self(self.0.load(&lanes.0), self.1.load(&lanes.1))
    }
    #[inline(always)]
    fn lit(self, x: f64) -> Self {
        Self(self.0.lit(x), self.1.lit(x))
    }
    #[inline(always)]
    fn constant(self, x: Constant) -> Self {
        Self(self.0.constant(x), self.1.constant(x))
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(self.0.mul_add(a.0, b.0), self.1.mul_add(a.1, b.1))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        (self.0.lt(other.0), self.1.lt(other.1))
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(T::select(mask.0, yes.0, no.0), T::select(mask.1, yes.1, no.1))
    }
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        T::any(mask.0) || T::any(mask.1)
    }
    #[inline(always)]
    fn fetch_pair(index: Self, table: &[u32]) -> (Self, Self) {
        let ((a, b), (c, d)) = (T::fetch_pair(index.0, table), T::fetch_pair(index.1, table));
        (Self(a, c), Self(b, d))
    }
    #[inline(always)]
    fn fetch_cell(index: Self, table: &[Cell]) -> [[Self; 2]; 4] {
        let [a, b, c, d] = T::fetch_cell(index.0, table);
        let [e, f, g, h] = T::fetch_cell(index.1, table);
        [beside(a, e), beside(b, f), beside(c, g), beside(d, h)]
    }
    unary! { sqrt recip floor exp2 log2 asin }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let ((a, b), (c, d)) = (self.0.sin_cos(), self.1.sin_cos());
        (Self(a, c), Self(b, d))
    }
}

#[inline(always)]
fn beside<T>([a, b]: [T; 2], [c, d]: [T; 2]) -> [Pair<T>; 2] {
    [Pair(a, c), Pair(b, d)]
}
