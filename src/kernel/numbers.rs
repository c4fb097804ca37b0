//! Where a sample's random numbers come from: the world's sampler, or what a program brings in its place.

use super::world::World;
use crate::lane::{Real, array};
use crate::own::Numbers;
use crate::sampling::dimensions::{BOUNCE, CAMERA, OPACITY};
use crate::sampling::{ONE_BELOW, Sampler, Site};

impl World {
    /// Starts sample `sample` of `site` in `lane`. A program's own numbers know no seed.
    #[inline(always)]
    pub(super) fn seed_numbers<R: Real>(&self, rng: &mut Sampler<R>, lane: usize, seed: u64, site: Site, sample: u32) {
        match self.numbers {
            None => rng.seed_lane(self.sampler, lane, seed, site, sample),
            Some(_) => rng.name_lane(lane, site.pixel, sample),
        }
    }

    /// Samples `first` … of `site`, one a lane.
    #[inline(always)]
    pub(super) fn numbers_of_site<R: Real>(&self, seed: u64, site: Site, first: u32) -> Sampler<R> {
        if self.numbers.is_none() {
            return Sampler::of_site(self.sampler, seed, site, first);
        }
        let mut rng = Sampler::idle();
        (0..R::WIDTH).for_each(|lane| rng.name_lane(lane, site.pixel, first + lane as u32));
        rng
    }

    /// See [`Sampler::camera_dims`].
    #[inline(always)]
    pub(super) fn camera_numbers<R: Real>(&self, rng: &mut Sampler<R>, lens: bool) -> [R; CAMERA] {
        match &self.numbers {
            None => rng.camera_dims(self.sampler, lens),
            Some(own) => of_dimensions(&**own, rng, |_| 0),
        }
    }

    /// See [`Sampler::bounce_dims`].
    #[inline(always)]
    pub(crate) fn bounce_numbers<R: Real>(&self, rng: &mut Sampler<R>, bounce: R) -> [R; BOUNCE] {
        match &self.numbers {
            None => rng.bounce_dims(self.sampler, bounce),
            Some(own) => of_dimensions(&**own, rng, |lane| first_of_bounce(bounce.lane(lane))),
        }
    }

    /// See [`Sampler::vertex_dims`].
    #[inline(always)]
    pub(super) fn vertex_numbers<R: Real>(&self, rng: &mut Sampler<R>, bounce: R, scatters: bool) -> [R; BOUNCE] {
        match &self.numbers {
            None => rng.vertex_dims(self.sampler, bounce, scatters),
            Some(_) => self.bounce_numbers(rng, bounce),
        }
    }

    /// See [`Sampler::opacity`].
    #[inline(always)]
    pub(super) fn opacity_number<R: Real>(&self, rng: &Sampler<R>, bounce: R) -> R {
        match &self.numbers {
            None => rng.opacity(self.sampler, bounce),
            Some(own) => {
                let [u] = of_dimensions(&**own, rng, |lane| first_of_bounce(bounce.lane(lane)) + OPACITY as u32);
                u
            }
        }
    }
}

fn first_of_bounce(bounce: f32) -> u32 {
    CAMERA as u32 + BOUNCE as u32 * bounce as u32
}

/// `N` numbers a lane from its dimension `first` on, held to [0, 1).
#[inline(never)]
fn of_dimensions<R: Real, const N: usize>(own: &dyn Numbers, rng: &Sampler<R>, first: impl Fn(usize) -> u32) -> [R; N] {
    array::from_fn(|k| {
        R::from_fn(|lane| {
            let [pixel, sample] = rng.identity(lane);
            let u = own.number(pixel, sample, first(lane) + k as u32);
            // The order turns a NaN into 0.
            if u > 0.0 { u.min(ONE_BELOW) } else { 0.0 }
        })
    })
}
