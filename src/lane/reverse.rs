//! The bits of each lane in the other order.

use super::Bits;
use wide::{u32x8, u32x16};

/// [`Bits::reverse_bits`] of a register type.
pub trait Reverse {
    /// Lane by lane.
    fn reversed(self) -> Self;
}

/// By swapping neighbours, pairs, … in five steps.
#[inline(always)]
#[cfg_attr(target_feature = "gfni", allow(dead_code))]
pub fn by_swaps<B: Bits>(x: B) -> B {
    let merge = |left: B, right: B, mask: u32| (left & B::splat(!mask)) | (right & B::splat(mask));
    let x = merge(x.shl::<1>(), x.shr::<1>(), 0x5555_5555);
    let x = merge(x.shl::<2>(), x.shr::<2>(), 0x3333_3333);
    let x = merge(x.shl::<4>(), x.shr::<4>(), 0x0f0f_0f0f);
    let x = merge(x.shl::<8>(), x.shr::<8>(), 0x00ff_00ff);
    x.shl::<16>() | x.shr::<16>()
}

/// For each byte of four its place in the other order, for all of a register.
#[cfg(target_feature = "gfni")]
const BYTES: [u32; 16] = {
    let mut bytes = [0x0001_0203; 16];
    let mut lane = 0;
    while lane < bytes.len() {
        // A shuffle stays within four lanes.
        bytes[lane] += 0x0404_0404 * (lane as u32 % 4);
        lane += 1;
    }
    bytes
};

/// The matrix over GF(2) that puts the bits of a byte into the other order.
#[cfg(target_feature = "gfni")]
const BITS: i64 = 0x8040_2010_0804_0201_u64 as i64;

/// [`Reverse`] by intrinsics where the build has GFNI and `$feature`, else by swaps.
macro_rules! reverse {
    ($feature:literal, $type:ident, $shuffle:ident, $multiply:ident, $filled:ident) => {
        impl Reverse for $type {
            #[inline(always)]
            fn reversed(self) -> Self {
                #[cfg(all(target_feature = "gfni", target_feature = $feature))]
                // SAFETY: the build has these features; registers only.
                unsafe {
                    use core::arch::x86_64::*;
                    let bytes = $shuffle(self.into(), <$type as Bits>::load(&BYTES).into());
                    $multiply::<0>(bytes, $filled(BITS)).into()
                }
                #[cfg(not(all(target_feature = "gfni", target_feature = $feature)))]
                by_swaps(self)
            }
        }
    };
}

reverse!("avx2", u32x8, _mm256_shuffle_epi8, _mm256_gf2p8affine_epi64_epi8, _mm256_set1_epi64x);
reverse!("avx512bw", u32x16, _mm512_shuffle_epi8, _mm512_gf2p8affine_epi64_epi8, _mm512_set1_epi64);
