//! The key of a sample: where its random numbers start.

/// A 64-bit key for sample `sample` of pixel `pixel` under `seed`.
///
/// For one seed all 2³² × 2³² keys differ: (pixel, sample) fill the 64 bits without overlap, and everything done to
/// them is invertible. Two seeds permute the same keys; a (pixel, sample) has the
/// same key under both only where the seeds are equal.
#[inline]
pub fn sample_key(seed: u64, pixel: u32, sample: u32) -> u64 {
    let index = u64::from(pixel) << 32 | u64::from(sample);
    mix(index ^ mix(seed ^ SEED_OFFSET))
}

/// The key of child `child` of a sample: a split, or one ray of a gather. The children of one key all differ, from each
/// other and from it; those of different keys meet as seldom as random numbers of 64 bits do.
#[inline]
pub fn child_key(key: u64, child: u32) -> u64 {
    mix(key.wrapping_add((u64::from(child) + 1).wrapping_mul(CHILD_STEP)))
}

/// Odd, so that a million steps pass through a million values. The fraction of √3.
const CHILD_STEP: u64 = 0xbb67_ae85_84ca_a73b;

/// Keeps seed 0 off the fixed point `mix(0) = 0`. The fraction of √2.
const SEED_OFFSET: u64 = 0x6a09_e667_f3bc_c908;

/// A bijection of 64 bits: MurmurHash3's finaliser (Appleby 2011). Not the one SplitMix64 uses to seed a generator,
/// so that the two do not compose into something simpler.
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ z >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd);
    z = (z ^ z >> 33).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    z ^ z >> 33
}
