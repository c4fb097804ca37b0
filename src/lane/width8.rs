//! Width 8: one AVX register.

use super::register::Register;
use super::{Bits, Mask, Real, reinterpret};
use wide::{f32x8, i32x8, u32x8};

/// Width 8 of [`Mask`]: every bit of a true lane is set.
#[derive(Clone, Copy, Debug)]
pub struct Mask8(f32x8);

super::wide_lanes!(
    8,
    f32x8,
    u32x8,
    i32x8,
    Mask8,
    f32x8,
    lookup4_8,
    rows8,
    store_rows8,
    permute8,
    compress8,
    extreme8,
    halves8,
    le_bits8
);
super::wide_masks!(8, f32x8, u32x8, Mask8, u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]));
