//! Random numbers in lanes, and the warps that make directions and points of them.
//!
//! Randomness belongs to the sample: [`sample_key`] makes a 64-bit key of (seed, pixel, sample), a [`Sampler`] draws the
//! same numbers from that key in any lane at any width, and [`dimensions`] says what each number is for.

pub mod dimensions;
mod frame;
mod key;
mod mix;
mod sampler;
pub mod site;
pub mod sobol;
mod sobol_table;
pub mod warp;
mod xoshiro;

pub use frame::Frame;
pub use key::{child_key, sample_key};
pub use mix::{mix3, to_unit};
pub use sampler::{Sampler, SamplerKind};
pub use site::Site;
pub use xoshiro::Xoshiro;

use crate::lane::Real;

/// The largest f32 below 1.
pub const ONE_BELOW: f32 = 1.0 - f32::EPSILON / 2.0;

/// The number in [0, 1) left over when `u` in [`lo`, `hi`) has made a choice of probability `hi − lo`: it may make the
/// next choice. Each choice of probability p costs log₂(1/p) of the 24 bits.
///
/// Finite and below 1 for any `u`; meaningless where `hi` ≤ `lo`.
#[inline(always)]
pub fn rescale<R: Real>(u: R, lo: R, hi: R) -> R {
    // The first clamp also turns a NaN (0/0) into 0.
    let scaled = ((u - lo) / (hi - lo)).max_or(R::zero());
    scaled.min_or(R::splat(ONE_BELOW))
}
