//! A worker's job: a tile, a range of samples, the queue of camera rays that feeds its lanes, and where results go.

use super::cutout;
use super::path::{Paths, Traversal};
use super::world::World;
use crate::accel::Mode;
use crate::film::AovSample;
use crate::geometry::{Hit, Ray};
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3};
use crate::sampling::Sampler;
use crate::sampling::dimensions::{LENS, PIXEL};

/// Pixels and samples to render together.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// Left column and top row.
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
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
}

impl SampleBuffer {
    /// Makes room for a job; every slot reads 0.
    pub fn reset(&mut self, slots: usize, features: bool) {
        self.rgb.clear();
        self.rgb.resize(slots, [0.0; 3]);
        self.features = features.then(|| vec![AovSample::default(); slots]);
    }

    #[inline(always)]
    pub fn write<R: Real>(&mut self, slot: R::Bits, rgb: Vec3<R>, mask: R::Mask) {
        let (mut slots, mut values) = ([0; MAX_WIDTH], [[0.0; MAX_WIDTH]; 3]);
        slot.store(&mut slots);
        rgb.x.store(&mut values[0]);
        rgb.y.store(&mut values[1]);
        rgb.z.store(&mut values[2]);
        for lane in lanes_of(mask.bits()) {
            self.rgb[slots[lane] as usize] = [values[0][lane], values[1][lane], values[2][lane]];
        }
    }

    pub fn write_features<R: Real>(&mut self, slot: R::Bits, albedo: Vec3<R>, n: Vec3<R>, z: R, mask: R::Mask) {
        let Some(features) = &mut self.features else { return };
        for lane in lanes_of(mask.bits()) {
            features[slot.lane(lane) as usize] =
                AovSample { albedo: albedo.lane(lane), normal: n.lane(lane), depth: z.lane(lane) };
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
    pub camera_rays: u64,
    pub bounce_rays: u64,
    pub shadow_rays: u64,
    /// Packets shaded, and lanes alive in them.
    pub packets: u64,
    pub active_lanes: u64,
}

impl Counters {
    #[inline(always)]
    pub fn packet<M: Mask, R: Real<Mask = M>>(&mut self, alive: M, bounce: R) {
        let camera = (alive & bounce.eq(R::zero())).bits().count_ones() as u64;
        let all = alive.bits().count_ones() as u64;
        self.camera_rays += camera;
        self.bounce_rays += all - camera;
        self.packets += 1;
        self.active_lanes += all;
    }
    #[inline(always)]
    pub fn shadow<M: Mask>(&mut self, mask: M) {
        self.shadow_rays += mask.bits().count_ones() as u64;
    }
    pub fn add(&mut self, other: &Counters) {
        self.camera_rays += other.camera_rays;
        self.bounce_rays += other.bounce_rays;
        self.shadow_rays += other.shadow_rays;
        self.packets += other.packets;
        self.active_lanes += other.active_lanes;
    }
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.bounce_rays + self.shadow_rays
    }
}

/// Camera samples of a job, made a packet at a time.
pub struct CameraQueue<'a, R: Real> {
    world: &'a World,
    job: &'a Job,
    /// The next sample to make: pixel within the tile, sample within the job.
    pixel: u32,
    sample: u32,
    ready: Option<CameraPacket<R>>,
    /// Lanes of `ready` not yet taken.
    left: u32,
}

/// Camera samples, with their hits where they are traced together.
pub struct CameraPacket<R: Real> {
    pub ray: Ray<R>,
    /// A miss where the queue was not asked to trace.
    pub hit: Hit<R>,
    pub rng: Sampler<R>,
    pub slot: R::Bits,
    pub active: R::Mask,
    /// Do the origins differ?
    lens: bool,
}

impl<'a, R: Real> CameraQueue<'a, R> {
    pub fn new(world: &'a World, job: &'a Job) -> Self {
        CameraQueue { world, job, pixel: 0, sample: 0, ready: None, left: 0 }
    }

    /// Gives every free lane the next camera sample, as long as there are any.
    #[inline(always)]
    pub fn refill<T: Traversal>(&mut self, paths: &mut Paths<R>) {
        if paths.alive.all() {
            return;
        }
        let mut alive = paths.alive.bits();
        let mut free = !alive & (u32::MAX >> (32 - R::WIDTH as u32));
        while free != 0 {
            if self.left == 0 {
                self.ready = self.next_packet::<T::Camera>(T::PRETRACED);
                self.left = self.ready.as_ref().map_or(0, |packet| packet.active.bits());
            }
            let Some(packet) = &self.ready else { break };
            // Free lanes and waiting samples are paired in order.
            let (mut from, mut taken) = ([0; MAX_WIDTH], 0);
            for lane in lanes_of(free).take(self.left.count_ones() as usize) {
                from[lane] = self.left.trailing_zeros();
                self.left &= self.left - 1;
                taken |= 1 << lane;
            }
            packet.give(R::Mask::from_bits(taken), R::Bits::load(&from), paths);
            free &= !taken;
            alive |= taken;
        }
        paths.alive = R::Mask::from_bits(alive);
    }

    /// The next packet of camera samples: the samples of a pixel side by side, so that rays are coherent. `None` where
    /// the job has no more.
    #[inline(never)]
    pub fn next_packet<M: Mode>(&mut self, trace: bool) -> Option<CameraPacket<R>> {
        let (mut x, mut y) = (R::zero(), R::zero());
        let mut rng = Sampler::<R>::idle();
        let mut slot = R::Bits::splat(0);
        let mut made = 0;
        let job = self.job;
        while made < R::WIDTH && self.pixel < job.width * job.height {
            let (px, py) = (job.x + self.pixel % job.width, job.y + self.pixel / job.width);
            let pixel = py * self.world.film.width + px;
            let sample = job.first_sample + self.sample;
            rng.seed_lane(self.world.sampler, made, self.world.seed, pixel, sample);
            x.set_lane(made, px as f32);
            y.set_lane(made, py as f32);
            slot.set_lane(made, self.pixel * job.samples + self.sample);
            made += 1;
            self.sample += 1;
            if self.sample == job.samples {
                (self.sample, self.pixel) = (0, self.pixel + 1);
            }
        }
        let active = R::Mask::from_bits(((1u64 << made) - 1) as u32);
        if made == 0 {
            return None;
        }
        let lens = self.world.plan.lens;
        let u = rng.camera_dims(self.world.sampler, lens);
        let (x, y) = (x + u[PIXEL], y + u[PIXEL + 1]);
        let camera = &self.world.camera;
        let ray = if lens { camera.lens_ray(x, y, [u[LENS], u[LENS + 1]]) } else { camera.ray(x, y) };
        let hit = if trace {
            cutout::closest::<R, M>(self.world, &ray, &rng, R::zero(), active)
        } else {
            Hit::miss(ray.t_max)
        };
        Some(CameraPacket { ray, hit, rng, slot, active, lens })
    }
}

impl<R: Real> CameraPacket<R> {
    /// Starts, in the lanes of `mask`, the paths of the lanes `from`.
    #[inline(always)]
    fn give(&self, mask: R::Mask, from: R::Bits, paths: &mut Paths<R>) {
        let put = |to: &mut R, value: R| *to = R::select(mask, value, *to);
        let put_bits =
            |to: &mut R::Bits, v: R::Bits| *to = R::Bits::select(mask, R::from_bits(v).permute(from).to_bits(), *to);
        let put_all = |to: &mut Vec3<R>, value: Vec3<R>| *to = Vec3::select(mask, value, *to);
        let Ray { origin, direction, .. } = &self.ray;
        if self.lens {
            let moved = Vec3::new(origin.x.permute(from), origin.y.permute(from), origin.z.permute(from));
            put_all(&mut paths.ray.origin, moved);
        } else {
            put_all(&mut paths.ray.origin, *origin);
        }
        put(&mut paths.ray.direction.x, direction.x.permute(from));
        put(&mut paths.ray.direction.y, direction.y.permute(from));
        put(&mut paths.ray.direction.z, direction.z.permute(from));
        put(&mut paths.ray.t_max, R::splat(f32::INFINITY));
        put(&mut paths.hit.t, self.hit.t.permute(from));
        put(&mut paths.hit.u, self.hit.u.permute(from));
        put(&mut paths.hit.v, self.hit.v.permute(from));
        put_bits(&mut paths.hit.primitive, self.hit.primitive);
        put_bits(&mut paths.slot, self.slot);
        paths.rng.take_lanes(mask, &self.rng, from);
        put_all(&mut paths.beta, Vec3::all(R::one()));
        put_all(&mut paths.radiance, Vec3::zero());
        put(&mut paths.bsdf_pdf, R::splat(f32::INFINITY));
        put(&mut paths.eta_squared, R::one());
        put(&mut paths.bounce, R::zero());
    }
}
