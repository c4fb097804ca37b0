//! Width 16: one AVX-512 register with its mask register, or two AVX registers.

use super::register::Register;
use super::{Bits, Mask, Real, reinterpret};
use wide::{f32x8, f32x16, i32x16, u32x16};

super::wide_lanes!(
    16,
    f32x16,
    u32x16,
    i32x16,
    Mask16,
    f32x8,
    lookup4_16,
    rows16,
    store_rows16,
    permute16,
    compress16,
    extreme16,
    halves16,
    le_bits16
);

/// Width 16 of [`Mask`] without AVX-512: every bit of a true lane is set.
#[cfg(not(target_feature = "avx512f"))]
#[derive(Clone, Copy, Debug)]
pub struct Mask16(f32x16);
#[cfg(not(target_feature = "avx512f"))]
super::wide_masks!(
    16,
    f32x16,
    u32x16,
    Mask16,
    u32x16::new([1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768])
);

/// Width 16 of [`Mask`] with AVX-512: a mask register.
#[cfg(target_feature = "avx512f")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mask16(u16);

#[cfg(target_feature = "avx512f")]
mod mask_register {
    use super::*;
    use core::arch::x86_64::*;

    impl Mask for Mask16 {
        #[inline(always)]
        fn splat(value: bool) -> Self {
            Self(if value { u16::MAX } else { 0 })
        }
        #[inline(always)]
        fn bits(self) -> u32 {
            self.0 as u32
        }
        #[inline(always)]
        fn from_bits(bits: u32) -> Self {
            Self(bits as u16)
        }
        #[inline(always)]
        fn all(self) -> bool {
            self.0 == u16::MAX
        }
    }
    impl core::ops::Not for Mask16 {
        type Output = Self;
        #[inline(always)]
        fn not(self) -> Self {
            Self(!self.0)
        }
    }
    macro_rules! mask_op {
        ($trait:ident, $method:ident, $op:tt) => {
            impl core::ops::$trait for Mask16 {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self(self.0 $op other.0)
                }
            }
        };
    }
    mask_op!(BitAnd, bitand, &);
    mask_op!(BitOr, bitor, |);
    mask_op!(BitXor, bitxor, ^);

    // SAFETY (all five): the module is compiled only where the build enables avx512f, and a build runs only on a CPU
    // that `cpu::guard` found to have its features. The types are plain registers; no memory is touched.
    #[inline(always)]
    pub fn compare<const OP: i32>(a: f32x16, b: f32x16) -> Mask16 {
        Mask16(unsafe { _mm512_cmp_ps_mask::<OP>(a.into(), b.into()) })
    }
    #[inline(always)]
    pub fn equal(a: u32x16, b: u32x16) -> Mask16 {
        Mask16(unsafe { _mm512_cmpeq_epi32_mask(a.into(), b.into()) })
    }
    #[inline(always)]
    pub fn less(a: u32x16, b: u32x16) -> Mask16 {
        Mask16(unsafe { _mm512_cmplt_epu32_mask(a.into(), b.into()) })
    }
    #[inline(always)]
    pub fn blend(mask: Mask16, if_true: f32x16, if_false: f32x16) -> f32x16 {
        unsafe { _mm512_mask_blend_ps(mask.0, if_false.into(), if_true.into()) }.into()
    }
    #[inline(always)]
    pub fn blend_bits(mask: Mask16, if_true: u32x16, if_false: u32x16) -> u32x16 {
        unsafe { _mm512_mask_blend_epi32(mask.0, if_false.into(), if_true.into()) }.into()
    }

    impl crate::lane::MaskOps<f32x16, u32x16> for Mask16 {
        #[inline(always)]
        fn lt(a: f32x16, b: f32x16) -> Self {
            compare::<_CMP_LT_OQ>(a, b)
        }
        #[inline(always)]
        fn le(a: f32x16, b: f32x16) -> Self {
            compare::<_CMP_LE_OQ>(a, b)
        }
        #[inline(always)]
        fn gt(a: f32x16, b: f32x16) -> Self {
            compare::<_CMP_GT_OQ>(a, b)
        }
        #[inline(always)]
        fn ge(a: f32x16, b: f32x16) -> Self {
            compare::<_CMP_GE_OQ>(a, b)
        }
        #[inline(always)]
        fn eq(a: f32x16, b: f32x16) -> Self {
            compare::<_CMP_EQ_OQ>(a, b)
        }
        #[inline(always)]
        fn eq_bits(a: u32x16, b: u32x16) -> Self {
            equal(a, b)
        }
        #[inline(always)]
        fn lt_bits(a: u32x16, b: u32x16) -> Self {
            less(a, b)
        }
        #[inline(always)]
        fn blend(self, if_true: f32x16, if_false: f32x16) -> f32x16 {
            blend(self, if_true, if_false)
        }
        #[inline(always)]
        fn blend_bits(self, if_true: u32x16, if_false: u32x16) -> u32x16 {
            blend_bits(self, if_true, if_false)
        }
    }
}
