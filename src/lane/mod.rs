//! Lanes: one arithmetic, three widths.
//!
//! The kernel is written once over [`Real`]. Width 1 is plain `f32`, the scalar baseline and the
//! reference; widths 8 and 16 are registers. Every operation here is correctly rounded (or exact) lane by lane, so
//! a value computed in lane 5 of 16 has the bits the scalar code gives. What that excludes: hardware reciprocal
//! estimates, reductions across lanes, library `sin`/`exp` (ours are in [`math`]) and unspecified NaN choices
//! (see [`Real::min_or`]).
//!
//! This folder is the only place that names `wide` or `core::arch`.

pub mod array;
pub mod float_mode;
pub mod math;
mod prefetch;
mod register;
mod reverse;
mod shuffle;
mod vec3;
mod wide_impl;
mod width1;
mod width16;
mod width8;

pub use prefetch::{prefetch, prefetch_second};
pub use vec3::{Vec3, axes, difference_of_products};
pub(crate) use wide::u32x8;
pub use wide::{f32x8, f32x16};
use wide_impl::{MaskOps, reinterpret, wide_lanes, wide_masks};

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The most lanes there are: the length of arrays that hold one value a lane at any width.
pub const MAX_WIDTH: usize = 16;

/// A truth value per lane.
pub trait Mask:
    Copy + Debug + Not<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Send + Sync
{
    /// The same truth value in every lane.
    fn splat(value: bool) -> Self;
    /// Bit `i` of the result is lane `i`; bits past the width are 0.
    fn bits(self) -> u32;
    /// The inverse of [`Mask::bits`]; bits past the width are ignored.
    fn from_bits(bits: u32) -> Self;
    /// Lanes of `if_true` where the mask holds, else of `if_false`.
    #[inline(always)]
    fn select(mask: Self, if_true: Self, if_false: Self) -> Self {
        (mask & if_true) | (!mask & if_false)
    }
    /// Is any lane true?
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    /// Is no lane true?
    #[inline(always)]
    fn none(self) -> bool {
        !self.any()
    }
    /// Is every lane true?
    #[inline(always)]
    fn all(self) -> bool {
        (!self).none()
    }
    /// Lane `i`.
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        self.bits() >> i & 1 != 0
    }
}

/// A `u32` per lane: random bits, indices, the bit patterns of a [`Real`]. Arithmetic wraps.
pub trait Bits:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Send
    + Sync
{
    /// Of as many lanes.
    type Mask: Mask;
    /// The same value in every lane.
    fn splat(value: u32) -> Self;
    /// Lane `i` is `f(i)`.
    fn from_fn(f: impl FnMut(usize) -> u32) -> Self;
    /// Lane `i`.
    fn lane(&self, i: usize) -> u32;
    /// Replaces lane `i`.
    fn set_lane(&mut self, i: usize, value: u32);
    /// Reads as many values as there are lanes. Panics if `slice` is shorter.
    fn load(slice: &[u32]) -> Self;
    /// Writes as many values as there are lanes. Panics if `slice` is shorter.
    fn store(self, slice: &mut [u32]);
    /// Lane `i` is `word >> 3·(i mod 8)`, for [`Real::permute`]: eight packed indices of three bits.
    fn unpack_octal(word: u32) -> Self;
    /// Logical shift left, `K < 32`.
    fn shl<const K: i32>(self) -> Self;
    /// Logical shift right, `K < 32`.
    fn shr<const K: i32>(self) -> Self;
    /// Rotation left, `0 < K < 32`.
    fn rotl<const K: i32>(self) -> Self;
    /// The bits of each lane in the other order.
    fn reverse_bits(self) -> Self;
    /// Lane by lane.
    fn eq(self, other: Self) -> Self::Mask;
    /// `self < other`, of numbers without sign.
    fn lt(self, other: Self) -> Self::Mask;
    /// Lanes of `if_true` where the mask holds, else of `if_false`.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
}

/// An `f32` per lane.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// Number of lanes.
    const WIDTH: usize;
    /// Of as many lanes.
    type Mask: Mask;
    /// Of as many lanes.
    type Bits: Bits<Mask = Self::Mask>;
    /// Does [`Real::permute`] take an instruction or two?
    const PERMUTES: bool;
    /// What tests the eight children of a tree node: a register, or at width 1 a loop of eight scalar tests.
    type Eight: Real;

    /// The same value in every lane.
    fn splat(value: f32) -> Self;
    /// Lane `i` is `f(i)`.
    fn from_fn(f: impl FnMut(usize) -> f32) -> Self;
    /// Reads `WIDTH` values. Panics if `slice` is shorter.
    fn load(slice: &[f32]) -> Self;
    /// Writes `WIDTH` values. Panics if `slice` is shorter.
    fn store(self, slice: &mut [f32]);
    /// Lane `i`.
    fn lane(&self, i: usize) -> f32;
    /// Replaces lane `i`.
    fn set_lane(&mut self, i: usize, value: f32);

    /// `self·b + c`, rounded once.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `c − self·b`, rounded once.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// Correctly rounded; NaN below zero.
    fn sqrt(self) -> Self;
    /// Exact.
    fn abs(self) -> Self;
    /// To the nearest integer, ties to even.
    fn round(self) -> Self;
    /// Exact.
    fn floor(self) -> Self;
    /// `self < other ? self : other`. So `other` wins over a NaN in either place and among equal zeros: keep the
    /// running bound on the right.
    fn min_or(self, other: Self) -> Self;
    /// `self > other ? self : other`; see [`Real::min_or`].
    fn max_or(self, other: Self) -> Self;
    /// The magnitude of `self` with the sign bit of `sign`.
    fn copysign(self, sign: Self) -> Self;

    /// `self < other`; false beside a NaN, as are the others.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self ≤ other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    fn gt(self, other: Self) -> Self::Mask;
    /// `self ≥ other`.
    fn ge(self, other: Self) -> Self::Mask;
    /// Lane by lane.
    fn eq(self, other: Self) -> Self::Mask;
    /// Lanes of `if_true` where the mask holds, else of `if_false`.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;

    /// The pattern of each lane.
    fn to_bits(self) -> Self::Bits;
    /// The number of each pattern.
    fn from_bits(bits: Self::Bits) -> Self;
    /// Exact for integers below 2²⁴. Domain: values below 2³¹.
    fn from_int(bits: Self::Bits) -> Self;
    /// Truncates. Domain: [0, 2³¹); outside it the result is unspecified.
    fn to_int(self) -> Self::Bits;
    /// Lane `i` is `table[index.lane(i)]`. Panics past the end of the table.
    fn gather(table: &[f32], index: Self::Bits) -> Self;
    /// Lane `i` is `table[index.lane(i)]`. Domain: indices below 4; others are unspecified.
    fn lookup4(table: &[f32; 4], index: Self::Bits) -> Self;
    /// Column `c` holds, in lane `i`, `table[index.lane(i)][c]`: one row a lane, transposed. Panics past the end.
    fn fetch_rows<const N: usize>(table: &[[f32; N]], index: Self::Bits) -> [Self; N];
    /// The other way round: lane `i` of each column to row `i`; rows past the last lane stay as they are.
    fn store_rows<const N: usize>(columns: &[Self; N], rows: &mut [[f32; N]; MAX_WIDTH]);
    /// Lane `i` is `self.lane(index.lane(i) % WIDTH)`.
    fn permute(self, index: Self::Bits) -> Self;
    /// The lanes of `bits` (a [`Mask::bits`]) moved to the front, in order; the others are unspecified.
    fn compress(self, bits: u32) -> Self;
    /// Lanes 0 … 7 (at width 1: all there is).
    fn lower(self) -> Self::Eight;
    /// Lanes 8 … 15 (below width 16: all there is).
    fn upper(self) -> Self::Eight;
    /// `self.le(other).bits()`
    #[inline(always)]
    fn le_bits(self, other: Self) -> u32 {
        self.le(other).bits()
    }
    /// The smallest lane. Exact, so in any order. Domain: no NaN.
    fn lowest(self) -> f32;
    /// The largest lane. Exact, so in any order. Domain: no NaN.
    fn highest(self) -> f32;

    // What is the same for every width.
    /// 0 in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// 1 in every lane.
    #[inline(always)]
    fn one() -> Self {
        Self::splat(1.0)
    }
    /// Correctly rounded 1/x; never the hardware estimate.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::one() / self
    }
    /// Zero where the mask does not hold (whatever the value there, NaN included).
    #[inline(always)]
    fn masked(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::zero())
    }
    /// `√max(x, 0)`: for arguments that only rounding makes negative.
    #[inline(always)]
    fn safe_sqrt(self) -> Self {
        self.max_or(Self::zero()).sqrt()
    }
    /// Lanes that are neither infinite nor NaN.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.abs().lt(Self::splat(f32::INFINITY))
    }
}
