//! A worker's job: a tile, a range of samples, the queue of camera rays that feeds its lanes, and where results go.

use super::cutout;
use super::world::World;
use crate::accel::Mode;
use crate::film::AovSample;
use crate::geometry::{Hit, Ray};
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3};
use crate::sampling::dimensions::{LENS, PIXEL};
use crate::sampling::{Sampler, Site};
use core::marker::PhantomData;

/// Pixels and samples to render together.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// Left column and top row.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Index of the first sample of every pixel.
    pub first_sample: u32,
    /// Samples a pixel in this job.
    pub samples: u32,
}

impl Job {
    /// Number of (pixel, sample) slots. Slot = pixel in the tile, row by row, times samples, plus sample.
    pub fn slots(&self) -> usize {
        (self.width * self.height * self.samples) as usize
    }
}

/// What each sample of a job found, one slot a sample.
#[derive(Default)]
pub struct SampleBuffer {
    /// Radiance.
    pub rgb: Vec<[f32; 3]>,
    /// First hits, where they are asked for.
    pub features: Option<Vec<AovSample>>,
    /// What camera paths carry beside light paths (see [`light_paths`](super::light_paths)); empty where there are none.
    pub light_ratio: Vec<f32>,
    /// What paths leave to be [shared](super::reuse).
    pub(super) shared: super::reuse::Shared,
}

impl SampleBuffer {
    /// Makes room for a job; every slot reads 0.
    pub fn reset(&mut self, slots: usize, features: bool) {
        self.rgb.clear();
        self.rgb.resize(slots, [0.0; 3]);
        self.features = features.then(|| vec![AovSample::default(); slots]);
    }

    /// Room for the ratios of every path, before any is traced.
    pub fn begin_ratios(&mut self, wanted: bool) {
        self.light_ratio.clear();
        self.light_ratio.resize(if wanted { self.rgb.len() } else { 0 }, 0.0);
    }

    /// Room for what the paths of a job [share](super::reuse): beside the slots of samples as many for what they find at
    /// second vertices, and where `scattering` is more than an albedo, for what is beyond their lobes.
    pub(super) fn share(&mut self, slots: usize, scattering: bool) {
        self.shared.begin(slots, scattering);
        self.rgb.resize(if scattering { 3 * slots } else { 2 * slots }, [0.0; 3]);
    }

    /// Adds to the slots of `mask`.
    #[inline(always)]
    pub fn add<R: Real>(&mut self, slot: R::Bits, rgb: Vec3<R>, mask: R::Mask) {
        let (mut slots, mut values) = ([0; MAX_WIDTH], [[0.0; MAX_WIDTH]; 3]);
        slot.store(&mut slots);
        rgb.x.store(&mut values[0]);
        rgb.y.store(&mut values[1]);
        rgb.z.store(&mut values[2]);
        for lane in lanes_of(mask.bits()) {
            let sum = &mut self.rgb[slots[lane] as usize];
            *sum = [sum[0] + values[0][lane], sum[1] + values[1][lane], sum[2] + values[2][lane]];
        }
    }

    /// Keeps the first hit of the slots of `mask`, if first hits are asked for.
    pub fn write_features<R: Real>(&mut self, slot: R::Bits, albedo: Vec3<R>, n: Vec3<R>, z: R, mask: R::Mask) {
        let Some(features) = &mut self.features else { return };
        for lane in lanes_of(mask.bits()) {
            features[slot.lane(lane) as usize] =
                AovSample { albedo: albedo.lane(lane), normal: n.lane(lane), depth: z.lane(lane), posterior: [0.0; 3] };
        }
    }
}

impl SampleBuffer {
    /// After [`SampleBuffer::write_features`].
    pub fn write_posterior(&mut self, slot: u32, variance: [f32; 3]) {
        if let Some(sample) = self.features.as_mut().and_then(|features| features.get_mut(slot as usize)) {
            sample.posterior = variance;
        }
    }
}

/// The set bits, lowest first.
#[inline(always)]
pub fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            lane
        })
    })
}

/// Rays traced and lanes used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Counters {
    /// One a path.
    pub camera_rays: u64,
    /// After a scattering event.
    pub bounce_rays: u64,
    /// Towards lights.
    pub shadow_rays: u64,
    /// Packets shaded, and lanes alive in them.
    pub packets: u64,
    /// Of [`Counters::packets`] times the width.
    pub active_lanes: u64,
}

impl Counters {
    /// A packet of camera rays or of others is traced.
    #[inline(always)]
    pub fn traced<M: Mask>(&mut self, camera: bool, mask: M) {
        *(if camera { &mut self.camera_rays } else { &mut self.bounce_rays }) += mask.bits().count_ones() as u64;
    }
    /// A packet is shaded.
    #[inline(always)]
    pub fn shaded<M: Mask>(&mut self, mask: M) {
        self.packets += 1;
        self.active_lanes += mask.bits().count_ones() as u64;
    }
    /// A packet of shadow rays is traced.
    #[inline(always)]
    pub fn shadow<M: Mask>(&mut self, mask: M) {
        self.shadow_rays += mask.bits().count_ones() as u64;
    }
    /// Adds another worker's.
    pub fn add(&mut self, other: &Counters) {
        self.camera_rays += other.camera_rays;
        self.bounce_rays += other.bounce_rays;
        self.shadow_rays += other.shadow_rays;
        self.packets += other.packets;
        self.active_lanes += other.active_lanes;
    }
    /// Of all kinds.
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.bounce_rays + self.shadow_rays
    }
}

/// Camera samples of a job, made a packet at a time.
pub struct CameraQueue<'a, R: Real> {
    world: &'a World,
    job: &'a Job,
    /// The next sample to make: column and row within the tile, sample within the job, slot.
    column: u32,
    row: u32,
    sample: u32,
    slot: u32,
    lanes: PhantomData<R>,
}

/// Camera samples, with their hits where they are traced together.
pub struct CameraPacket<R: Real> {
    pub ray: Ray<R>,
    /// A miss where the queue was not asked to trace.
    pub hit: Hit<R>,
    pub rng: Sampler<R>,
    pub slot: R::Bits,
    pub active: R::Mask,
}

/// Camera samples without rays yet: their numbers, pixels (column, row) and slots.
struct Started<R: Real> {
    rng: Sampler<R>,
    x: R,
    y: R,
    slot: R::Bits,
    active: R::Mask,
}

impl<'a, R: Real> CameraQueue<'a, R> {
    pub fn new(world: &'a World, job: &'a Job) -> Self {
        CameraQueue { world, job, column: 0, row: 0, sample: 0, slot: 0, lanes: PhantomData }
    }

    /// On by `count` samples of the same pixel: slots are in the order of pixels, row by row, and their samples.
    #[inline(always)]
    fn step(&mut self, count: u32) {
        self.slot += count;
        self.sample += count;
        if self.sample == self.job.samples {
            (self.sample, self.column) = (0, self.column + 1);
            if self.column == self.job.width {
                (self.column, self.row) = (0, self.row + 1);
            }
        }
    }

    /// The next samples and their numbers.
    #[inline(always)]
    fn start(&mut self) -> Option<Started<R>> {
        let job = self.job;
        if self.row >= job.height || job.width == 0 || job.samples == 0 {
            return None;
        }
        let (px, py) = (job.x + self.column, job.y + self.row);
        if job.samples - self.sample >= R::WIDTH as u32 {
            let (site, sample) = (self.site(px, py), job.first_sample + self.sample);
            let slot = R::Bits::splat(self.slot) + R::Bits::from_fn(|lane| lane as u32);
            self.step(R::WIDTH as u32);
            return Some(Started {
                rng: self.world.numbers_of_site(self.world.seed, site, sample),
                x: R::splat(px as f32),
                y: R::splat(py as f32),
                slot,
                active: R::Mask::splat(true),
            });
        }
        Some(self.start_one_by_one())
    }

    #[inline(always)]
    fn site(&self, x: u32, y: u32) -> Site {
        Site::of_pixel(x, y, self.world.film.width)
    }

    /// The same where they are of several pixels.
    #[inline(always)]
    fn start_one_by_one(&mut self) -> Started<R> {
        let job = self.job;
        let (mut x, mut y, mut slot) = (R::zero(), R::zero(), R::Bits::splat(0));
        let mut rng = Sampler::<R>::idle();
        let mut made = 0;
        while made < R::WIDTH && self.row < job.height {
            let (px, py) = (job.x + self.column, job.y + self.row);
            let sample = job.first_sample + self.sample;
            self.world.seed_numbers(&mut rng, made, self.world.seed, self.site(px, py), sample);
            x.set_lane(made, px as f32);
            y.set_lane(made, py as f32);
            slot.set_lane(made, self.slot);
            made += 1;
            self.step(1);
        }
        Started { rng, x, y, slot, active: R::Mask::from_bits(((1u64 << made) - 1) as u32) }
    }

    /// The next packet of camera samples: the samples of a pixel side by side, so that rays are coherent. `None` where
    /// the job has no more.
    #[inline(never)]
    pub fn next_packet<M: Mode>(&mut self, trace: bool) -> Option<CameraPacket<R>> {
        let Started { mut rng, x, y, slot, active } = self.start()?;
        let lens = self.world.plan.lens;
        let u = self.world.camera_numbers(&mut rng, lens);
        let (x, y) = (x + u[PIXEL], y + u[PIXEL + 1]);
        let camera = &self.world.camera;
        let ray = if lens { camera.lens_ray(x, y, [u[LENS], u[LENS + 1]]) } else { camera.ray(x, y) };
        let hit = if trace {
            cutout::closest::<R, M>(self.world, &ray, &rng, R::zero(), active)
        } else {
            Hit::miss(ray.t_max)
        };
        Some(CameraPacket { ray, hit, rng, slot, active })
    }
}
