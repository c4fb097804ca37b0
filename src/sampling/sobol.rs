//! Owen-scrambled Sobol' points in lanes, keyed by (pixel, sample, dimension).
//!
//! A number is 32 bits, each a digit; [`to_unit`] makes it a float. Scrambling is by hash: one Laine–Karras permutation
//! stands for a tree of random digit flips (Laine & Karras 2011; Burley 2020, "Practical Hash-based Owen Scrambling"), so
//! that any point is had from its index alone. It acts on reversed digits, and so points are made reversed: bit k of a
//! number *in reverse* is its digit of weight 2^−(k+1).
//!
//! Pairs of dimensions are padded: each set shuffles the index by a hash of its own, again by Owen's
//! permutation, which leaves any aligned block of 2^k indices a block.

pub use super::mix::to_unit;
use super::site::apart;
use super::sobol_table::{COLUMNS, DIMENSIONS};
use crate::lane::{Bits, Real};

/// The most dimensions one Sobol' point has here.
pub const MAX_DIMENSIONS: usize = DIMENSIONS;

/// A 64-bit key a lane, as [`super::sample_key`] makes them: for a renderer, of (seed, block of pixels, 0).
#[derive(Clone, Copy, Debug)]
pub struct Key<R: Real> {
    /// Of 64 bits.
    pub low: R::Bits,
    /// Of 64 bits.
    pub high: R::Bits,
}

impl<R: Real> Key<R> {
    /// Lane `i` is `key(i)`.
    pub fn from_fn(mut key: impl FnMut(usize) -> u64) -> Self {
        let mut out = Self { low: R::Bits::splat(0), high: R::Bits::splat(0) };
        for lane in 0..R::WIDTH {
            let key = key(lane);
            out.low.set_lane(lane, key as u32);
            out.high.set_lane(lane, (key >> 32) as u32);
        }
        out
    }

    /// 32 bits for one use of the key. Different uses are different walks through a bijection.
    #[inline(always)]
    fn child(self, purpose: u32) -> R::Bits {
        let salted = mix::<R>(self.low ^ R::Bits::splat(purpose.wrapping_mul(0x9e37_79b9)));
        mix::<R>(salted + self.high)
    }
}

/// Two numbers of the padded set `set` for sample `index`: over aligned blocks of 2^k samples a (0, k, 2)-net.
#[inline(always)]
pub fn owen_2d<R: Real>(index: R::Bits, key: Key<R>, set: u32) -> [R::Bits; 2] {
    let shuffled = shuffle::<R>(index, key.child(8 * set));
    let second = pascal::<R>(shuffled);
    // The first dimension's matrix reverses the index: in reverse it is the index.
    [
        laine_karras::<R>(shuffled, key.child(8 * set + 1)).reverse_bits(),
        laine_karras::<R>(second, key.child(8 * set + 2)).reverse_bits(),
    ]
}

/// Padded pairs a lane, of one key: numbers of set k for the points of one pixel.
#[derive(Clone, Copy)]
pub struct PairSet<R: Real> {
    of_set: R::Bits,
}

impl<R: Real> PairSet<R> {
    /// Set `set` of `key`.
    #[inline(always)]
    pub fn new(key: Key<R>, set: R::Bits) -> Self {
        Self { of_set: mix::<R>(mix::<R>(key.low + set * R::Bits::splat(0x9e37_79b9)) ^ key.high) }
    }

    /// The set's own order of the indices, given in reverse.
    #[inline(always)]
    pub fn shuffle(self, reversed_index: R::Bits) -> R::Bits {
        laine_karras::<R>(reversed_index, self.of_set).reverse_bits()
    }

    /// The pair of a shuffled index at `place` < 64, scrambled as the set says: over aligned blocks of 2^k samples a
    /// (0, k, 2)-net at each place, and nearly one at all places together (see [`apart`]).
    #[inline(always)]
    pub fn pair(self, shuffled: R::Bits, place: R::Bits) -> [R::Bits; 2] {
        let [a, b] = apart::<R>(self.shuffle_place(place));
        let (first, second) = (shuffled ^ a, pascal::<R>(shuffled) ^ b);
        // One more mixing each: seeds that only differ by a constant would scramble both dimensions alike.
        let seed = |salt| mix::<R>(self.of_set + R::Bits::splat(salt));
        [
            laine_karras::<R>(first, seed(0x7f4a_7c15)).reverse_bits(),
            laine_karras::<R>(second, seed(0x94d0_49bb)).reverse_bits(),
        ]
    }

    /// The set's own order of the places: in one order for all sets the digits of one would say those of the others, for a whole
    /// block at once. Aligned blocks stay such blocks, as by [`laine_karras`]; bits beyond a place's mean nothing.
    #[inline(always)]
    fn shuffle_place(self, place: R::Bits) -> R::Bits {
        let x = (place + self.of_set.shr::<8>()) * (self.of_set.shr::<16>() | R::Bits::splat(1));
        x ^ (x * R::Bits::splat(0x0552_6c56))
    }
}

/// Two more orders of the indices, for pairs that go well with the pair of `shuffled` and with each other: any two of the
/// three pairs together are low-discrepancy points of four dimensions, and each is a (0, k, 2)-net of its own, which no four
/// dimensions of Sobol's are.
///
/// With C₀ the unit matrix and C₁ Pascal's, the generators of Sobol's first pair, and S the shift to the next lower digit,
/// the orders are A = (I + S)·C₁·(I + S + S² + S⁶ + S⁸) and B = (I + S² + S⁵ + S⁶ + S⁷ + S⁸)·C₁·(I + S³ + S⁴ + S⁵ + S⁷) over
/// GF(2): C₀, C₁, C₀A, C₁A generate a (t, k, 4)-net with Σ t = 24 over k = 2 … 12, and so do C₀, C₁, C₀B, C₁B. Found by trying
/// 2¹⁶ such products; the least sum of any was 24 (`tests/sampling/sobol.rs` has the t of each k).
#[inline(always)]
pub fn beside<R: Real>(shuffled: R::Bits) -> [R::Bits; 2] {
    let x = shuffled;
    let a = pascal::<R>(x ^ x.shr::<1>() ^ x.shr::<2>() ^ x.shr::<6>() ^ x.shr::<8>());
    let b = pascal::<R>(x ^ x.shr::<3>() ^ x.shr::<4>() ^ x.shr::<5>() ^ x.shr::<7>());
    [a ^ a.shr::<1>(), b ^ b.shr::<2>() ^ b.shr::<5>() ^ b.shr::<6>() ^ b.shr::<7>() ^ b.shr::<8>()]
}

/// A number without structure for sample `index` and purpose `set`, a lane: a hash.
#[inline(always)]
pub fn hashed_lanes<R: Real>(index: R::Bits, key: Key<R>, set: R::Bits) -> R::Bits {
    let of_set = mix::<R>(key.low + set * R::Bits::splat(0x9e37_79b9)) ^ key.high;
    mix::<R>(mix::<R>(of_set) + index * R::Bits::splat(0x9e37_79b1))
}

/// Number `dimension` < [`MAX_DIMENSIONS`] of Sobol' point `index`, in reverse, not scrambled.
#[inline(always)]
pub fn sobol_reversed<R: Real>(index: R::Bits, dimension: usize) -> R::Bits {
    match dimension {
        0 => index,
        1 => pascal::<R>(index),
        _ => {
            let (mut digits, mut point) = (index, R::Bits::splat(0));
            for column in &COLUMNS[dimension] {
                let taken = R::Bits::splat(0) - (digits & R::Bits::splat(1));
                point = point ^ (taken & R::Bits::splat(*column));
                digits = digits.shr::<1>();
            }
            point
        }
    }
}

/// Number `dimension` of Sobol' point `index`, scrambled by the key; jointly over all dimensions, without padding.
#[inline(always)]
pub fn owen_sobol<R: Real>(index: R::Bits, key: Key<R>, dimension: usize) -> R::Bits {
    laine_karras::<R>(sobol_reversed::<R>(index, dimension), key.child(dimension as u32)).reverse_bits()
}

/// Number `dimension` of Sobol' point `index` under a random digital shift: every digit flipped alike for all points.
#[inline(always)]
pub fn shifted_sobol<R: Real>(index: R::Bits, key: Key<R>, dimension: usize) -> R::Bits {
    sobol_reversed::<R>(index, dimension).reverse_bits() ^ key.child(dimension as u32)
}

/// Point `index` of [`owen_2d`]'s set 0 in f64, at the centres of its 2³² cells.
pub fn owen_pair(index: u32, key: u64) -> [f64; 2] {
    let key = Key::<f32>::from_fn(|_| key);
    owen_2d::<f32>(Bits::splat(index), key, 0).map(|b| (f64::from(b.lane(0)) + 0.5) * f64::powi(2.0, -32))
}

#[inline(always)]
fn shuffle<R: Real>(index: R::Bits, seed: R::Bits) -> R::Bits {
    laine_karras::<R>(index.reverse_bits(), seed).reverse_bits()
}

/// Sobol's second dimension in reverse: bit i is the parity of C(j, i)·bit j, which by Lucas is a sum over the supersets of
/// i, one step for each bit of i (Ahmed 2024, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and
/// Compact").
#[inline(always)]
fn pascal<R: Real>(x: R::Bits) -> R::Bits {
    let x = x ^ (x.shr::<1>() & R::Bits::splat(0x5555_5555));
    let x = x ^ (x.shr::<2>() & R::Bits::splat(0x3333_3333));
    let x = x ^ (x.shr::<4>() & R::Bits::splat(0x0f0f_0f0f));
    let x = x ^ (x.shr::<8>() & R::Bits::splat(0x00ff_00ff));
    x ^ (x.shr::<16>() & R::Bits::splat(0x0000_ffff))
}

/// A permutation in which a bit changes only by those below it: on a number in reverse, a tree of digit flips. The
/// constants are Vegdahl's (2021, "Building a Better LK Hash").
#[inline(always)]
fn laine_karras<R: Real>(x: R::Bits, seed: R::Bits) -> R::Bits {
    let x = x ^ (x * R::Bits::splat(0x3d20_adea));
    let x = x + seed;
    let x = x * (seed.shr::<16>() | R::Bits::splat(1));
    let x = x ^ (x * R::Bits::splat(0x0552_6c56));
    x ^ (x * R::Bits::splat(0x53a2_2864))
}

/// MurmurHash3's 32-bit finaliser (Appleby 2011).
#[inline(always)]
fn mix<R: Real>(x: R::Bits) -> R::Bits {
    let x = (x ^ x.shr::<16>()) * R::Bits::splat(0x85eb_ca6b);
    let x = (x ^ x.shr::<13>()) * R::Bits::splat(0xc2b2_ae35);
    x ^ x.shr::<16>()
}
