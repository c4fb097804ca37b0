//! Width 1: plain `f32`, `u32` and `bool`.

use super::{Bits, MAX_WIDTH, Mask, Real};

impl Mask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self as u32
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits & 1 != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// Width 1 of [`Bits`]: `u32` with wrapping arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct U32x1(pub u32);

macro_rules! wrapping_op {
    ($trait:ident, $method:ident, $f:expr) => {
        impl core::ops::$trait for U32x1 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($f(self.0, other.0))
            }
        }
    };
}
wrapping_op!(Add, add, u32::wrapping_add);
wrapping_op!(Sub, sub, u32::wrapping_sub);
wrapping_op!(Mul, mul, u32::wrapping_mul);
wrapping_op!(BitAnd, bitand, |a: u32, b: u32| a & b);
wrapping_op!(BitOr, bitor, |a: u32, b: u32| a | b);
wrapping_op!(BitXor, bitxor, |a: u32, b: u32| a ^ b);

impl Bits for U32x1 {
    type Mask = bool;
    #[inline(always)]
    fn splat(value: u32) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> u32) -> Self {
        Self(f(0))
    }
    #[inline(always)]
    fn lane(&self, _: usize) -> u32 {
        self.0
    }
    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: u32) {
        self.0 = value;
    }
    #[inline(always)]
    fn load(slice: &[u32]) -> Self {
        Self(slice[0])
    }
    #[inline(always)]
    fn store(self, slice: &mut [u32]) {
        slice[0] = self.0;
    }
    #[inline(always)]
    fn unpack_octal(word: u32) -> Self {
        Self(word)
    }
    #[inline(always)]
    fn shl<const K: i32>(self) -> Self {
        Self(self.0 << K)
    }
    #[inline(always)]
    fn shr<const K: i32>(self) -> Self {
        Self(self.0 >> K)
    }
    #[inline(always)]
    fn rotl<const K: i32>(self) -> Self {
        Self(self.0.rotate_left(K as u32))
    }
    #[inline(always)]
    fn reverse_bits(self) -> Self {
        Self(self.0.reverse_bits())
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self.0 == other.0
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }
    #[inline(always)]
    fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
        if mask { if_true } else { if_false }
    }
}

impl Real for f32 {
    const WIDTH: usize = 1;
    const PERMUTES: bool = false;
    type Mask = bool;
    type Bits = U32x1;
    type Eight = f32;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn from_fn(mut f: impl FnMut(usize) -> f32) -> Self {
        f(0)
    }
    #[inline(always)]
    fn load(slice: &[f32]) -> Self {
        slice[0]
    }
    #[inline(always)]
    fn store(self, slice: &mut [f32]) {
        slice[0] = self;
    }
    #[inline(always)]
    fn lane(&self, _: usize) -> f32 {
        *self
    }
    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: f32) {
        *self = value;
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        f32::mul_add(self, b, c)
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        f32::mul_add(-self, b, c)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn round(self) -> Self {
        f32::round_ties_even(self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        f32::floor(self)
    }
    #[inline(always)]
    fn min_or(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max_or(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        f32::copysign(self, sign)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn gt(self, other: Self) -> bool {
        self > other
    }
    #[inline(always)]
    fn ge(self, other: Self) -> bool {
        self >= other
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
        if mask { if_true } else { if_false }
    }
    #[inline(always)]
    fn to_bits(self) -> U32x1 {
        U32x1(f32::to_bits(self))
    }
    #[inline(always)]
    fn from_bits(bits: U32x1) -> Self {
        f32::from_bits(bits.0)
    }
    #[inline(always)]
    fn from_int(bits: U32x1) -> Self {
        bits.0 as i32 as f32
    }
    #[inline(always)]
    fn to_int(self) -> U32x1 {
        U32x1(self as i32 as u32)
    }
    #[inline(always)]
    fn gather(table: &[f32], index: U32x1) -> Self {
        table[index.0 as usize]
    }
    #[inline(always)]
    fn lookup4(table: &[f32; 4], index: U32x1) -> Self {
        table[index.0 as usize & 3]
    }
    #[inline(always)]
    fn fetch_rows<const N: usize>(table: &[[f32; N]], index: U32x1) -> [Self; N] {
        table[index.0 as usize]
    }
    #[inline(always)]
    fn store_rows<const N: usize>(columns: &[Self; N], rows: &mut [[f32; N]; MAX_WIDTH]) {
        rows[0] = *columns;
    }
    #[inline(always)]
    fn permute(self, _: U32x1) -> Self {
        self
    }
    #[inline(always)]
    fn compress(self, _: u32) -> Self {
        self
    }
    #[inline(always)]
    fn lower(self) -> f32 {
        self
    }
    #[inline(always)]
    fn upper(self) -> f32 {
        self
    }
    #[inline(always)]
    fn lowest(self) -> f32 {
        self
    }
    #[inline(always)]
    fn highest(self) -> f32 {
        self
    }
}
