//! New numbers from used ones.

use crate::lane::{Bits, Real};

/// Two words in which every bit depends on every bit of the three given: the final step of Jenkins's lookup3 (2006).
#[inline(always)]
pub fn mix3<R: Real>(a: R::Bits, b: R::Bits, c: R::Bits) -> [R::Bits; 2] {
    let offset = R::Bits::splat(0xdead_beef);
    let [mut a, mut b, mut c] = [a + offset, b + offset, c + offset];
    c = (c ^ b) - b.rotl::<14>();
    a = (a ^ c) - c.rotl::<11>();
    b = (b ^ a) - a.rotl::<25>();
    c = (c ^ b) - b.rotl::<16>();
    a = (a ^ c) - c.rotl::<4>();
    b = (b ^ a) - a.rotl::<14>();
    c = (c ^ b) - b.rotl::<24>();
    [c, b]
}

/// The upper 24 bits as a number in [0, 1).
#[inline(always)]
pub fn to_unit<R: Real>(bits: R::Bits) -> R {
    R::from_int(bits.shr::<8>()) * R::splat(1.0 / (1u32 << 24) as f32)
}
