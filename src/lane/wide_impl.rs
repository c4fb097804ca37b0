//! [`Bits`](super::Bits), [`Real`](super::Real) and [`Mask`] for the register types of `wide`, once for both widths.

use super::Mask;

/// How a register width compares and blends: mask registers with AVX-512, full-lane masks without.
pub(super) trait MaskOps<F, U>: Mask {
    fn lt(a: F, b: F) -> Self;
    fn le(a: F, b: F) -> Self;
    fn gt(a: F, b: F) -> Self;
    fn ge(a: F, b: F) -> Self;
    fn eq(a: F, b: F) -> Self;
    fn eq_bits(a: U, b: U) -> Self;
    fn lt_bits(a: U, b: U) -> Self;
    fn blend(self, if_true: F, if_false: F) -> F;
    fn blend_bits(self, if_true: U, if_false: U) -> U;
}

/// [`Bits`](super::Bits) and [`Real`](super::Real) for one of the register types of `wide`.
macro_rules! wide_lanes {
    ($width:literal, $f:ident, $u:ident, $i:ident, $mask:ident, $eight:ident,
     $lookup4:ident, $rows:ident, $store_rows:ident, $permute:ident, $compress:ident, $extreme:ident, $halves:ident, $le_bits:ident) => {
        impl Bits for $u {
            type Mask = $mask;
            #[inline(always)]
            fn splat(value: u32) -> Self {
                <$u as Register<u32>>::filled(value)
            }
            #[inline(always)]
            fn from_fn(f: impl FnMut(usize) -> u32) -> Self {
                $u::new(crate::lane::array::from_fn(f))
            }
            #[inline(always)]
            fn lane(&self, i: usize) -> u32 {
                self.as_array()[i]
            }
            #[inline(always)]
            fn set_lane(&mut self, i: usize, value: u32) {
                self.as_mut_array()[i] = value;
            }
            #[inline(always)]
            fn load(slice: &[u32]) -> Self {
                <$u as Register<u32>>::read(slice)
            }
            #[inline(always)]
            fn store(self, slice: &mut [u32]) {
                <$u as Register<u32>>::write(self, slice);
            }
            #[inline(always)]
            fn unpack_octal(word: u32) -> Self {
                <Self as Bits>::splat(word) >> $u::new(crate::lane::array::from_fn(|i| 3 * (i as u32 % 8)))
            }
            #[inline(always)]
            fn shl<const K: i32>(self) -> Self {
                self << (K as u32)
            }
            #[inline(always)]
            fn shr<const K: i32>(self) -> Self {
                self >> (K as u32)
            }
            #[inline(always)]
            fn rotl<const K: i32>(self) -> Self {
                (self << (K as u32)) | (self >> (32 - K as u32))
            }
            #[inline(always)]
            fn reverse_bits(self) -> Self {
                super::reverse::Reverse::reversed(self)
            }
            #[inline(always)]
            fn eq(self, other: Self) -> $mask {
                <$mask as super::MaskOps<$f, $u>>::eq_bits(self, other)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                <$mask as super::MaskOps<$f, $u>>::lt_bits(self, other)
            }
            #[inline(always)]
            fn select(mask: $mask, if_true: Self, if_false: Self) -> Self {
                super::MaskOps::<$f, $u>::blend_bits(mask, if_true, if_false)
            }
        }

        impl Real for $f {
            const WIDTH: usize = $width;
            const PERMUTES: bool = $width == 8 || cfg!(target_feature = "avx512f");
            type Mask = $mask;
            type Bits = $u;
            type Eight = $eight;

            #[inline(always)]
            fn splat(value: f32) -> Self {
                <$f as Register<f32>>::filled(value)
            }
            #[inline(always)]
            fn from_fn(f: impl FnMut(usize) -> f32) -> Self {
                $f::new(crate::lane::array::from_fn(f))
            }
            #[inline(always)]
            fn load(slice: &[f32]) -> Self {
                <$f as Register<f32>>::read(slice)
            }
            #[inline(always)]
            fn store(self, slice: &mut [f32]) {
                <$f as Register<f32>>::write(self, slice);
            }
            #[inline(always)]
            fn lane(&self, i: usize) -> f32 {
                self.as_array()[i]
            }
            #[inline(always)]
            fn set_lane(&mut self, i: usize, value: f32) {
                self.as_mut_array()[i] = value;
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                $f::mul_add(self, b, c)
            }
            #[inline(always)]
            fn neg_mul_add(self, b: Self, c: Self) -> Self {
                $f::mul_neg_add(self, b, c)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $f::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $f::abs(self)
            }
            #[inline(always)]
            fn round(self) -> Self {
                $f::round_ties_even(self)
            }
            #[inline(always)]
            fn floor(self) -> Self {
                $f::floor(self)
            }
            #[inline(always)]
            fn min_or(self, other: Self) -> Self {
                self.fast_min(other)
            }
            #[inline(always)]
            fn max_or(self, other: Self) -> Self {
                self.fast_max(other)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                let sign_bit = <Self as Real>::splat(-0.0);
                (sign & sign_bit) | (self & !sign_bit)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                <$mask as super::MaskOps<$f, $u>>::lt(self, other)
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                <$mask as super::MaskOps<$f, $u>>::le(self, other)
            }
            #[inline(always)]
            fn gt(self, other: Self) -> $mask {
                <$mask as super::MaskOps<$f, $u>>::gt(self, other)
            }
            #[inline(always)]
            fn ge(self, other: Self) -> $mask {
                <$mask as super::MaskOps<$f, $u>>::ge(self, other)
            }
            #[inline(always)]
            fn eq(self, other: Self) -> $mask {
                <$mask as super::MaskOps<$f, $u>>::eq(self, other)
            }
            #[inline(always)]
            fn select(mask: $mask, if_true: Self, if_false: Self) -> Self {
                super::MaskOps::<$f, $u>::blend(mask, if_true, if_false)
            }
            #[inline(always)]
            fn to_bits(self) -> $u {
                reinterpret!(self, $f, $u, $width)
            }
            #[inline(always)]
            fn from_bits(bits: $u) -> Self {
                reinterpret!(bits, $u, $f, $width)
            }
            #[inline(always)]
            fn from_int(bits: $u) -> Self {
                let signed: $i = reinterpret!(bits, $u, $i, $width);
                signed.round_float()
            }
            #[inline(always)]
            fn to_int(self) -> $u {
                let signed: $i = self.fast_trunc_int();
                reinterpret!(signed, $i, $u, $width)
            }
            #[inline(always)]
            fn gather(table: &[f32], index: $u) -> Self {
                let index = index.to_array();
                $f::new(crate::lane::array::from_fn(|i| table[index[i] as usize]))
            }
            #[inline(always)]
            fn lookup4(table: &[f32; 4], index: $u) -> Self {
                super::shuffle::$lookup4(table, index)
            }
            #[inline(always)]
            fn fetch_rows<const N: usize>(table: &[[f32; N]], index: $u) -> [Self; N] {
                super::shuffle::$rows(table, index.to_array())
            }
            #[inline(always)]
            fn store_rows<const N: usize>(columns: &[Self; N], rows: &mut [[f32; N]; crate::lane::MAX_WIDTH]) {
                super::shuffle::$store_rows(columns, rows)
            }
            #[inline(always)]
            fn permute(self, index: $u) -> Self {
                super::shuffle::$permute(self, index)
            }
            #[inline(always)]
            fn compress(self, bits: u32) -> Self {
                super::shuffle::$compress(self, bits)
            }
            #[inline(always)]
            fn lower(self) -> $eight {
                super::shuffle::$halves(self)[0]
            }
            #[inline(always)]
            fn upper(self) -> $eight {
                super::shuffle::$halves(self)[1]
            }
            #[inline(always)]
            fn le_bits(self, other: Self) -> u32 {
                super::shuffle::$le_bits(self, other)
            }
            #[inline(always)]
            fn lowest(self) -> f32 {
                super::shuffle::$extreme(self, |a, b| a.fast_min(b))
            }
            #[inline(always)]
            fn highest(self) -> f32 {
                super::shuffle::$extreme(self, |a, b| a.fast_max(b))
            }
        }
    };
}

/// [`Mask`] as a register whose true lanes are all ones.
macro_rules! wide_masks {
    ($width:literal, $f:ident, $u:ident, $mask:ident, $powers:expr) => {
        impl Mask for $mask {
            #[inline(always)]
            fn splat(value: bool) -> Self {
                Self(<$f as Real>::splat(f32::from_bits(if value { u32::MAX } else { 0 })))
            }
            #[inline(always)]
            fn bits(self) -> u32 {
                self.0.to_bitmask() as u32
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                let powers = $powers;
                let set: $u = (<$u as Bits>::splat(bits) & powers).simd_eq(powers);
                Self(reinterpret!(set, $u, $f, $width))
            }
            #[inline(always)]
            fn all(self) -> bool {
                self.0.all()
            }
        }
        impl core::ops::Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }
        impl core::ops::BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                Self(self.0 & other.0)
            }
        }
        impl core::ops::BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }
        impl core::ops::BitXor for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitxor(self, other: Self) -> Self {
                Self(self.0 ^ other.0)
            }
        }
        impl super::MaskOps<$f, $u> for $mask {
            #[inline(always)]
            fn lt(a: $f, b: $f) -> Self {
                Self(a.simd_lt(b))
            }
            #[inline(always)]
            fn le(a: $f, b: $f) -> Self {
                Self(a.simd_le(b))
            }
            #[inline(always)]
            fn gt(a: $f, b: $f) -> Self {
                Self(a.simd_gt(b))
            }
            #[inline(always)]
            fn ge(a: $f, b: $f) -> Self {
                Self(a.simd_ge(b))
            }
            #[inline(always)]
            fn eq(a: $f, b: $f) -> Self {
                Self(a.simd_eq(b))
            }
            #[inline(always)]
            fn eq_bits(a: $u, b: $u) -> Self {
                Self(reinterpret!(a.simd_eq(b), $u, $f, $width))
            }
            #[inline(always)]
            fn lt_bits(a: $u, b: $u) -> Self {
                Self(reinterpret!(a.simd_lt(b), $u, $f, $width))
            }
            #[inline(always)]
            fn blend(self, if_true: $f, if_false: $f) -> $f {
                self.0.select(if_true, if_false)
            }
            #[inline(always)]
            fn blend_bits(self, if_true: $u, if_false: $u) -> $u {
                reinterpret!(
                    self.0.select(reinterpret!(if_true, $u, $f, $width), reinterpret!(if_false, $u, $f, $width)),
                    $f,
                    $u,
                    $width
                )
            }
        }
    };
}

/// The same register read as another lane type. SAFETY: both are plain registers of the same size, and every bit
/// pattern is a value of each.
macro_rules! reinterpret {
    ($value:expr, $from:ident, $to:ident, $width:literal) => {{
        let value: $from = $value;
        unsafe { core::mem::transmute::<$from, $to>(value) }
    }};
}
pub(super) use {reinterpret, wide_lanes, wide_masks};
