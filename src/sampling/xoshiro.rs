//! xoshiro128++ in lanes (Blackman and Vigna 2021, "Scrambled linear pseudorandom number generators").

use super::dimensions;
use crate::lane::{Bits, Real};

/// One xoshiro128++ generator a lane: the integers of `rand_xoshiro::Xoshiro128PlusPlus`, bit for bit.
#[derive(Clone, Copy, Debug)]
pub struct Xoshiro<R: Real> {
    pub(super) s: [R::Bits; 4],
}

impl<R: Real> Xoshiro<R> {
    /// Lane `i` as `seed_from_u64(key(i))`.
    #[inline]
    pub fn from_keys(mut key: impl FnMut(usize) -> u64) -> Self {
        let mut rng = Self { s: [R::Bits::splat(0); 4] };
        for lane in 0..R::WIDTH {
            rng.seed_lane(lane, key(lane));
        }
        rng
    }

    /// Starts `lane` again as `seed_from_u64(key)` does: two outputs of SplitMix64 (Steele, Lea, Flood 2014). Different
    /// keys give different states, and none gives the all-zero state, which would stay there.
    #[inline]
    pub fn seed_lane(&mut self, lane: usize, key: u64) {
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        for (pair, words) in self.s.chunks_exact_mut(2).enumerate() {
            let word = stafford_mix_13(key.wrapping_add(GOLDEN.wrapping_mul(pair as u64 + 1)));
            words[0].set_lane(lane, word as u32);
            words[1].set_lane(lane, (word >> 32) as u32);
        }
    }

    /// 32 random bits a lane.
    #[inline(always)]
    pub fn next_bits(&mut self) -> R::Bits {
        let [s0, s1, s2, s3] = self.s;
        let result = (s0 + s3).rotl::<7>() + s0;
        let s2 = s2 ^ s0;
        let s3 = s3 ^ s1;
        self.s = [s0 ^ s3, s1 ^ s2, s2 ^ s1.shl::<9>(), s3.rotl::<11>()];
        result
    }

    /// Uniform in [0, 1), a multiple of 2⁻²⁴.
    #[inline(always)]
    pub fn next_unit(&mut self) -> R {
        R::from_int(self.next_bits().shr::<8>()) * R::splat(1.0 / (1u32 << 24) as f32)
    }

    /// The camera's numbers, indexed by [`dimensions`].
    #[inline(always)]
    pub fn camera_dims(&mut self) -> [R; dimensions::CAMERA] {
        crate::lane::array::from_fn(|_| self.next_unit())
    }

    /// One bounce's numbers, indexed by [`dimensions`].
    #[inline(always)]
    pub fn bounce_dims(&mut self) -> [R; dimensions::BOUNCE] {
        crate::lane::array::from_fn(|_| self.next_unit())
    }

    /// From a freshly seeded state to where the numbers of `bounce` (0 is the first) begin: to replay a sample.
    pub fn skip_to_bounce(&mut self, bounce: u32) {
        self.camera_dims();
        for _ in 0..bounce {
            self.bounce_dims();
        }
    }
}

/// The output function of SplitMix64: Stafford's 13th variant of MurmurHash3's finaliser.
#[inline]
fn stafford_mix_13(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
