//! Words in lanes against the standard library's.

use octolux::lane::{Bits, Real};

#[test]
fn bits_are_reversed_as_the_standard_library_does() {
    fn check<R: Real>() {
        // Every bit and every byte alone, and words of all kinds.
        let words = (0..32).map(|k| 1 << k).chain((0..=255u32).map(|byte| byte.wrapping_mul(0x0100_0001)));
        let words: Vec<u32> = words.chain((0..10_000u32).map(|i| i.wrapping_mul(0x9e37_79b9))).collect();
        for chunk in words.chunks_exact(R::WIDTH) {
            let reversed = R::Bits::load(chunk).reverse_bits();
            for (lane, word) in chunk.iter().enumerate() {
                assert_eq!(reversed.lane(lane), word.reverse_bits(), "{word:#x} in lane {lane} of {}", R::WIDTH);
            }
        }
    }
    check::<f32>();
    check::<octolux::lane::f32x8>();
    check::<octolux::lane::f32x16>();
}
