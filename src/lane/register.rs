//! Values into registers and out of them.
//!
//! `wide` makes a register by transmuting an array. Where two such registers meet behind a branch the compiler keeps
//! the arrays instead, as 16 scalars with a place on the stack for each; an intrinsic is a register from the start.

use wide::{f32x8, f32x16, u32x8, u32x16};

/// A register type of `wide` and its elements.
pub trait Register<E> {
    /// The same value in every lane.
    fn filled(value: E) -> Self;
    /// The first values of `slice`. Panics if there are fewer than lanes.
    fn read(slice: &[E]) -> Self;
    /// Writes the lanes to the first places of `slice`. Panics if there are fewer.
    fn write(self, slice: &mut [E]);
}

/// [`Register`] by intrinsics where the build has `$feature`, else by `wide`'s arrays.
macro_rules! register {
    ($feature:literal, $lanes:literal, $type:ident, $element:ty, $filled:ident, $read:ident, $write:ident) => {
        impl Register<$element> for $type {
            #[inline(always)]
            fn filled(value: $element) -> Self {
                #[cfg(target_feature = $feature)]
                // SAFETY: the build has the feature; registers only.
                unsafe {
                    Self::from(core::arch::x86_64::$filled(value as _))
                }
                #[cfg(not(target_feature = $feature))]
                Self::splat(value)
            }
            #[inline(always)]
            fn read(slice: &[$element]) -> Self {
                let first = &slice[..$lanes];
                #[cfg(target_feature = $feature)]
                // SAFETY: the build has the feature; `first` has as many values as are read, and no alignment is asked for.
                unsafe {
                    Self::from(core::arch::x86_64::$read(first.as_ptr().cast()))
                }
                #[cfg(not(target_feature = $feature))]
                Self::new(super::array::from_fn(|i| first[i]))
            }
            #[inline(always)]
            fn write(self, slice: &mut [$element]) {
                let first = &mut slice[..$lanes];
                #[cfg(target_feature = $feature)]
                // SAFETY: the build has the feature; `first` has as many places as are written, and no alignment is
                // asked for.
                unsafe {
                    core::arch::x86_64::$write(first.as_mut_ptr().cast(), self.into());
                }
                #[cfg(not(target_feature = $feature))]
                super::array::put(self.to_array(), first, 0);
            }
        }
    };
}

register!("avx", 8, f32x8, f32, _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps);
register!("avx2", 8, u32x8, u32, _mm256_set1_epi32, _mm256_loadu_si256, _mm256_storeu_si256);
register!("avx512f", 16, f32x16, f32, _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps);
register!("avx512f", 16, u32x16, u32, _mm512_set1_epi32, _mm512_loadu_si512, _mm512_storeu_si512);
