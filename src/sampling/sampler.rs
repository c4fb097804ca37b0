//! The numbers of a path, even or independent: a function of (seed, pixel, sample, dimension) either way.

use super::dimensions::*;
use super::site::{INDEX, INDEX_BITS, Site};
use super::sobol::{self, Key, PairSet};
use super::{Xoshiro, sample_key, to_unit};
use crate::lane::{Bits, Mask, Real, array};

/// How the numbers of the samples of a pixel relate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum SamplerKind {
    /// Owen-scrambled Sobol' points, padded in pairs of dimensions: the numbers of one purpose fill their range evenly over
    /// the samples of a pixel, and so do the place in the pixel and the first vertex's point on a light, or its
    /// direction, together; so, nearly, do those of all pixels of a block of 8×8. Blocks are scrambled independently.
    Sobol,
    /// The same with each pixel scrambled for itself: what `--adaptive` takes where no paths are shared, since its numbers of
    /// samples go by what pixels nearby found.
    #[serde(rename = "sobol-pixels")]
    SobolPixels,
    /// Independent numbers (xoshiro128++): the variance of a pixel's mean is s²/n.
    #[default]
    Independent,
}

impl SamplerKind {
    /// As the command line and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            SamplerKind::Sobol => "sobol",
            SamplerKind::SobolPixels => "sobol-pixels",
            SamplerKind::Independent => "independent",
        }
    }
}

/// One stream of numbers a lane.
///
/// All samplers keep their state in the same four words, so that paths move between lanes alike: xoshiro's state, or of Sobol' points
/// the reversed sample index, the two halves of the block's key, and the index with the pixel's place in the block above it.
#[derive(Clone, Copy, Debug)]
pub struct Sampler<R: Real>(Xoshiro<R>);

/// Sets of dimensions a bounce has: direction, light position, light and lobe, roulette, opacity.
const SETS: u32 = 5;
const OPACITY_SET: u32 = 4;
/// Of the camera: pixel and lens.
const CAMERA_SETS: u32 = 2;
const PIXEL_SET: u32 = 0;
const LENS_SET: u32 = 1;

impl<R: Real> Sampler<R> {
    /// Nothing that may be drawn from.
    pub fn idle() -> Self {
        Self(Xoshiro { s: [R::Bits::splat(0); 4] })
    }

    /// Independent numbers, lane i from `key(i)`.
    #[inline]
    pub fn independent(key: impl FnMut(usize) -> u64) -> Self {
        Self(Xoshiro::from_keys(key))
    }

    /// Starts sample `sample` of `site` in `lane`.
    #[inline]
    pub fn seed_lane(&mut self, kind: SamplerKind, lane: usize, seed: u64, site: Site, sample: u32) {
        match kind {
            SamplerKind::Independent => self.0.seed_lane(lane, sample_key(seed, site.pixel, sample)),
            _ => {
                let (key, word) = site.under(kind).point(seed, sample);
                let words = [(word & INDEX).reverse_bits(), key as u32, (key >> 32) as u32, word];
                for (k, word) in words.into_iter().enumerate() {
                    self.0.s[k].set_lane(lane, word);
                }
            }
        }
    }

    /// Samples `first` … of `site`, one a lane.
    #[inline(always)]
    pub fn of_site(kind: SamplerKind, seed: u64, site: Site, first: u32) -> Self {
        let one_key = (first & INDEX) <= INDEX - (R::WIDTH as u32 - 1);
        match kind {
            SamplerKind::Independent => Self::independent(|lane| sample_key(seed, site.pixel, first + lane as u32)),
            _ if one_key => {
                let (key, word) = site.under(kind).point(seed, first);
                let word = R::Bits::splat(word) + R::Bits::from_fn(|lane| lane as u32);
                let (low, high) = (R::Bits::splat(key as u32), R::Bits::splat((key >> 32) as u32));
                Self(Xoshiro { s: [(word & R::Bits::splat(INDEX)).reverse_bits(), low, high, word] })
            }
            _ => {
                let mut sampler = Self::idle();
                (0..R::WIDTH).for_each(|lane| sampler.seed_lane(kind, lane, seed, site, first + lane as u32));
                sampler
            }
        }
    }

    /// Starts a sample in `lane` whose numbers come from elsewhere: see [`Sampler::identity`].
    #[inline]
    pub(crate) fn name_lane(&mut self, lane: usize, pixel: u32, sample: u32) {
        self.0.s[0].set_lane(lane, pixel);
        self.0.s[1].set_lane(lane, sample);
    }

    /// The pixel and sample that [`Sampler::name_lane`] was given.
    #[inline]
    pub(crate) fn identity(&self, lane: usize) -> [u32; 2] {
        [self.0.s[0].lane(lane), self.0.s[1].lane(lane)]
    }

    /// The state, to be kept between bounces.
    #[inline(always)]
    pub fn words(&self) -> [R::Bits; 4] {
        self.0.s
    }

    /// Goes on from a state.
    #[inline(always)]
    pub fn from_words(words: [R::Bits; 4]) -> Self {
        Self(Xoshiro { s: words })
    }

    /// The camera's numbers, indexed by [`dimensions`](super::dimensions); without `lens` those of the lens are unspecified.
    #[inline(always)]
    pub fn camera_dims(&mut self, kind: SamplerKind, lens: bool) -> [R; CAMERA] {
        match kind {
            SamplerKind::Independent => self.0.camera_dims(),
            _ => {
                let pixel = self.pair(R::Bits::splat(PIXEL_SET));
                let lens = if lens { self.pair(R::Bits::splat(LENS_SET)) } else { pixel };
                [pixel[0], pixel[1], lens[0], lens[1]]
            }
        }
    }

    /// The numbers of `bounce` (0 is the first; a lane), indexed by [`dimensions`](super::dimensions). To be asked for
    /// every bounce in turn.
    #[inline(always)]
    pub fn bounce_dims(&mut self, kind: SamplerKind, bounce: R) -> [R; BOUNCE] {
        match kind {
            SamplerKind::Independent => self.0.bounce_dims(),
            _ => {
                let mut u = self.sobol_vertex(bounce, true);
                u[OPACITY] = self.opacity(kind, bounce);
                u
            }
        }
    }

    /// The same without the number for cut-outs, and, if not `scatters`, without those that a material and roulette draw: these
    /// may be anything.
    #[inline(always)]
    pub(crate) fn vertex_dims(&mut self, kind: SamplerKind, bounce: R, scatters: bool) -> [R; BOUNCE] {
        match kind {
            SamplerKind::Independent => self.0.bounce_dims(),
            _ => self.sobol_vertex(bounce, scatters),
        }
    }

    /// The number of `bounce` that decides on cut-outs, looked up before the others are drawn.
    #[inline(always)]
    pub fn opacity(&self, kind: SamplerKind, bounce: R) -> R {
        match kind {
            SamplerKind::Independent => { self.0 }.bounce_dims()[OPACITY],
            _ => self.hashed(Self::set(bounce, OPACITY_SET)),
        }
    }

    /// The number of a set of `bounce`.
    #[inline(always)]
    fn set(bounce: R, k: u32) -> R::Bits {
        bounce.to_int() * R::Bits::splat(SETS) + R::Bits::splat(CAMERA_SETS + k)
    }

    #[inline(never)]
    fn sobol_vertex(&self, bounce: R, scatters: bool) -> [R; BOUNCE] {
        let set = |k: u32| PairSet::new(self.key(), Self::set(bounce, k));
        // What no path draws stays 0.
        let mut u = [R::zero(); BOUNCE];
        let (position, direction) = (set(1), set(0));
        let mut of_position = position.shuffle(self.0.s[0]);
        let mut of_direction = if scatters { direction.shuffle(self.0.s[0]) } else { of_position };
        let first = bounce.eq(R::zero());
        if first.any() {
            let pixel = PairSet::new(self.key(), R::Bits::splat(PIXEL_SET));
            let [a, b] = sobol::beside::<R>(pixel.shuffle(self.0.s[0]));
            of_position = R::Bits::select(first, a, of_position);
            of_direction = R::Bits::select(first, b, of_direction);
        }
        [u[LIGHT_POSITION], u[LIGHT_POSITION + 1]] = array::map(position.pair(of_position, self.place()), to_unit);
        [u[LIGHT_CHOICE], u[BSDF_LOBE]] = self.pair(Self::set(bounce, 2));
        if scatters {
            [u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]] =
                array::map(direction.pair(of_direction, self.place()), to_unit);
            u[ROULETTE] = self.hashed(Self::set(bounce, 3));
        }
        u
    }

    #[inline(always)]
    fn key(&self) -> Key<R> {
        Key { low: self.0.s[1], high: self.0.s[2] }
    }

    #[inline(always)]
    fn pair(&self, set: R::Bits) -> [R; 2] {
        let set = PairSet::new(self.key(), set);
        array::map(set.pair(set.shuffle(self.0.s[0]), self.place()), to_unit)
    }

    #[inline(always)]
    fn place(&self) -> R::Bits {
        self.0.s[3].shr::<INDEX_BITS>()
    }

    #[inline(always)]
    fn hashed(&self, set: R::Bits) -> R {
        to_unit(sobol::hashed_lanes::<R>(self.0.s[3], self.key(), set))
    }
}
