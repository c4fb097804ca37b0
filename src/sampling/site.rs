//! Where on the film a sample is taken, and what that has to do with its numbers: pixels of a block share one scrambling of
//! Sobol' points and are set apart by a shift each, so that the points of all together are spread nearly as evenly as those of
//! each alone, at any number of samples.
//!
//! What is made of a block then has less error than of as many pixels scrambled each for itself: paths that its pixels share, and
//! what the eye or a filter takes the mean of (as with the one sequence along a space-filling curve of Ahmed & Wonka 2020,
//! "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", which wants to know the
//! number of samples beforehand; and nothing here reaches beyond a block).

use super::{SamplerKind, sample_key};
use crate::lane::{Bits, Real, array};

/// Pixels along each side of a block. Path reuse gathers such blocks.
pub const BLOCK_SIDE: u32 = 8;

/// Pixels of a block.
pub const PLACES: u32 = BLOCK_SIDE * BLOCK_SIDE;

/// Bits of a word below a place.
pub(super) const INDEX_BITS: i32 = 26;

/// Of a word, the index.
pub(super) const INDEX: u32 = (1 << INDEX_BITS) - 1;

/// A pixel by its number, and by its block and place there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Site {
    /// Of the pixel, row by row. Independent numbers go by it alone.
    pub pixel: u32,
    /// Of the block, row by row.
    pub block: u32,
    /// In the block, below [`PLACES`]: bit 0 says in which half of the columns, bit 1 in which half of the rows, bits 2 and 3
    /// in which halves of those, and so on.
    pub place: u32,
}

impl Site {
    /// Of the pixel in column `x` and row `y` of a film that is `width` pixels wide.
    #[inline(always)]
    pub fn of_pixel(x: u32, y: u32, width: u32) -> Self {
        let bits = |k: u32| (x >> (2 - k) & 1) << (2 * k) | (y >> (2 - k) & 1) << (2 * k + 1);
        Self {
            pixel: y * width + x,
            block: y / BLOCK_SIDE * width.div_ceil(BLOCK_SIDE) + x / BLOCK_SIDE,
            place: bits(0) | bits(1) | bits(2),
        }
    }

    /// Of a sequence that shares its scrambling with no other.
    pub fn alone(number: u32) -> Self {
        Self { pixel: number, block: number, place: 0 }
    }

    /// What shares its scrambling with it under a sampler.
    #[inline(always)]
    pub(super) fn under(self, kind: SamplerKind) -> Self {
        if kind == SamplerKind::SobolPixels { Self::alone(self.pixel) } else { self }
    }

    /// The key of the points that sample `sample` is one of, and a word: its index among them, above it the place.
    #[inline(always)]
    pub(super) fn point(self, seed: u64, sample: u32) -> (u64, u32) {
        // A word has room for 2²⁶ samples: the next are other points.
        let round = sample >> INDEX_BITS;
        (sample_key(seed, self.block, round), sample & INDEX | self.place << INDEX_BITS)
    }
}

/// What to add, digit by digit, to both numbers of a point in reverse (bit k is the digit of weight 2^−(k+1)) at `place` <
/// [`PLACES`].
///
/// Together with Sobol's first pair the shifts generate a digital (t, m + 6, 2)-net of the first 2^m points of all 64 places:
/// Σ t = 13 over m = 0 … 9, where scrambling each place for itself leaves t = 6, Σ t = 60; of aligned blocks of 2, 4, 8, 16, 32
/// places Σ t is 9, 11, 12, 12, 15. Found by annealing; t = 0 for all is impossible even for two.
#[inline(always)]
pub fn apart<R: Real>(place: R::Bits) -> [R::Bits; 2] {
    let pairs = [place, place.shr::<2>(), place.shr::<4>()];
    array::map([0, 1], |d: usize| {
        let [a, b, c] = array::map([0, 1, 2], |k: usize| R::lookup4(&SHIFTS[d][k], pairs[k]).to_bits());
        a ^ b ^ c
    })
}

/// For each bit of a place, lowest first, the digits that it adds to both numbers. No more than 30: then what is looked up are
/// the bits of finite floats.
const COLUMNS: [[u32; 2]; 6] = [
    [0x2e04_e74d, 0x1114_5b5b],
    [0x26dc_a52d, 0x009a_f5b0],
    [0x3ebd_64fa, 0x2e2b_48e6],
    [0x1df9_11e5, 0x2f31_f2ba],
    [0x3aba_e36a, 0x20cf_2df1],
    [0x0852_7db9, 0x063f_3325],
];

/// The same for each two bits of a place, as [`Real::lookup4`] takes them.
const SHIFTS: [[[f32; 4]; 3]; 2] = {
    let mut shifts = [[[0.0; 4]; 3]; 2];
    let mut k = 0;
    while k < 24 {
        let (d, pair, bits) = (k / 12, k / 4 % 3, k % 4);
        let low = if bits & 1 != 0 { COLUMNS[2 * pair][d] } else { 0 };
        let high = if bits & 2 != 0 { COLUMNS[2 * pair + 1][d] } else { 0 };
        shifts[d][pair][bits] = f32::from_bits(low ^ high);
        k += 1;
    }
    shifts
};
