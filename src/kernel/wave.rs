//! The paths of a worker on their way: rays are traced, packets of hits shaded, shadow rays traced, generation by
//! generation.
//!
//! After every step lanes fall away: rays miss, vertices are unlit, paths end. What is left is moved together, so that
//! each step runs on full packets. Paths that ended make room for camera samples (regeneration) until the job runs out.
//! A path's contributions are added to its slot in its own order, whatever company it was in: the sums are the same at
//! any width.

use super::cutout;
use super::material::ShadingKind;
use super::path::{self, Paths, Traversal, mis_weight};
use super::probe::{Lanes, Probe, Stage};
use super::queue::{Queue, ROOM};
use super::reuse;
use super::rows::{CONTRIBUTION, DIRECTION, GOING, HIT, MISSED, NAME, SHADOW};
use super::rows::{pack, pack_hit, path_ray, shadow_ray, unpack, unpack_hits};
use super::shade::Shade;
use super::tile::{CameraQueue, Counters, Job, SampleBuffer};
use super::world::World;
use crate::accel::FLIGHT;
use crate::geometry::{Hit, Ray};
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3, array, f32x8, f32x16};
use crate::plan::Shading;

/// Paths of a worker on their way at once: they and what waits stay in the second cache; 128 were up to 5 % slower.
pub(super) const POOL: usize = 512;

/// [`together`] of any lanes: of one, these are fewer rays than fly together.
pub(super) const TOGETHER: usize = 16;

/// Packets traced together: a [flight](FLIGHT) of rays. Half of one, eight packets of eight lanes, took 5 to 7 % longer where paths
/// are short.
pub(super) const fn together<R: Real>() -> usize {
    if FLIGHT / R::WIDTH < TOGETHER { FLIGHT / R::WIDTH } else { TOGETHER }
}

const _: () = assert!(8 * together::<f32x8>() == FLIGHT && 16 * together::<f32x16>() == FLIGHT);

// A packet may go beyond the pool, and what is stored of it a register further.
const _: () = assert!(POOL + 3 * MAX_WIDTH <= ROOM);

/// Renders all samples of a job into `out`.
pub fn render<R: Real, T: Traversal, S: Shade, P: Probe>(
    world: &World,
    shade: &S,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
    probe: &mut P,
) {
    out.begin_ratios(world.light_paths.is_some());
    if world.plan.path_reuse {
        out.share(job.slots(), S::Models::SHADING == Shading::General || world.plan.shading_normals);
    }
    let mut camera = CameraQueue::<R>::new(world, job);
    let mut wave = Wave::<R, S, P>::new(world, shade, POOL, out, counters, probe);
    wave.run::<T>(|counters| {
        let packet = camera.next_packet::<T::Camera>(true)?;
        counters.traced(true, packet.active);
        Some(Paths::begin(packet.ray, packet.hit, packet.rng, packet.slot, packet.active))
    });
    if world.plan.path_reuse {
        reuse::connect::<R, S, P>(world, job, out, counters, probe);
    }
}

/// See the module. Only what traces is compiled for each [`Traversal`]: what shades, which is most of it, is not.
pub(super) struct Wave<'a, R: Real, S, P> {
    world: &'a World,
    shade: &'a S,
    out: &'a mut SampleBuffer,
    counters: &'a mut Counters,
    probe: &'a mut P,
    pool: usize,
    /// Rays to trace, of this generation and the next.
    going: Queue<R, GOING>,
    next: Queue<R, GOING>,
    /// Too few so far.
    hits: Queue<R, HIT, { FLIGHT + 3 * MAX_WIDTH }>,
    missed: Queue<R, MISSED, { 3 * MAX_WIDTH }>,
    shadows: Queue<R, SHADOW>,
    /// Slots and last bounces of paths that ended in this generation; only for a probe.
    ended: Vec<(u32, f32)>,
}

impl<'a, R: Real, S: Shade, P: Probe> Wave<'a, R, S, P> {
    /// Nothing on its way; for `pool` paths, [`POOL`] at most, and one packet at least.
    pub fn new(
        world: &'a World,
        shade: &'a S,
        pool: usize,
        out: &'a mut SampleBuffer,
        counters: &'a mut Counters,
        probe: &'a mut P,
    ) -> Self {
        // Hits that wait are fewer than a packet: so there are always paths to go on with, or room for more.
        debug_assert!(pool <= POOL);
        let pool = pool.max(R::WIDTH);
        Wave {
            world,
            shade,
            out,
            counters,
            probe,
            pool,
            going: Queue::new(),
            next: Queue::new(),
            hits: Queue::new(),
            missed: Queue::new(),
            shadows: Queue::new(),
            ended: Vec::new(),
        }
    }

    /// Takes paths that have been traced from `camera` as long as it has any, and follows all to their end.
    pub fn run<T: Traversal>(&mut self, mut camera: impl FnMut(&mut Counters) -> Option<Paths<R>>) {
        let mut more = true;
        loop {
            core::mem::swap(&mut self.going, &mut self.next);
            for first in (0..self.going.len()).step_by(R::WIDTH * together::<R>()) {
                self.trace::<T>(first);
            }
            self.going.clear();
            while more && self.next.len() + self.hits.len() < self.pool {
                match camera(self.counters) {
                    Some(paths) => {
                        self.begin(paths);
                        self.shade_full::<T>();
                    }
                    None => more = false,
                }
            }
            if !more {
                self.shade_rest::<T>();
            }
            self.trace_shadows::<T>();
            if !more && self.next.is_empty() {
                break;
            }
        }
        self.add_rest();
        self.tap_ends();
    }

    /// Traces the packets from `first` on.
    #[inline(never)]
    fn trace<T: Traversal>(&mut self, first: usize) {
        let count = (self.going.len() - first).div_ceil(R::WIDTH).min(together::<R>());
        let nowhere = Ray::new(Vec3::zero(), Vec3::zero(), R::zero());
        let (mut rays, mut active) = ([nowhere; TOGETHER], [R::Mask::splat(false); TOGETHER]);
        let mut hits = [Hit::miss(R::zero()); TOGETHER];
        for k in 0..count {
            let first = first + k * R::WIDTH;
            (rays[k], active[k]) = (
                path_ray(
                    #[inline(always)]
                    |k| self.going.field(k, first),
                ),
                self.going.rows(first),
            );
            self.counters.traced(false, active[k]);
        }
        self.world.closest_many::<R, T::Bounce>(&rays[..count], &active[..count], &mut hits[..count]);
        for (k, hit) in hits[..count].iter().enumerate() {
            self.arrive::<T>(first + k * R::WIDTH, *hit, active[k]);
        }
        self.shade_full::<T>();
    }

    /// The packet of rays from `first` on has been traced: those that hit wait to be [shaded](Self::shade_full).
    #[inline(always)]
    fn arrive<T: Traversal>(&mut self, first: usize, mut hit: Hit<R>, alive: R::Mask) {
        if self.world.plan.cutouts {
            let Paths { ray, rng, bounce, .. } = unpack(|k| self.going.field(k, first), alive);
            hit = cutout::stopping::<R, T::Bounce>(self.world, &ray, &rng, bounce, hit, alive);
        }
        if P::ACTIVE {
            let [slot, bounce] = self.going.fields(NAME, first);
            path::tap_hit(self.probe, Lanes { slot: slot.to_bits(), bounce, active: alive }, &mut hit);
        }
        let found = alive & hit.valid();
        let missed = alive & !found;
        if missed.any() {
            self.leave(missed, &self.going.fields(DIRECTION, first));
        }
        if found.any() {
            self.hits.push_longer(found, &self.going, first, pack_hit(&hit));
        }
    }

    /// The same of paths that begin.
    #[inline(always)]
    fn begin(&mut self, mut paths: Paths<R>) {
        path::tap_hit(self.probe, paths.lanes(paths.alive), &mut paths.hit);
        let found = paths.alive & paths.hit.valid();
        let missed = paths.alive & !found;
        let row = pack(&paths);
        if missed.any() {
            self.leave(missed, &array::from_fn(|k| row[DIRECTION + k]));
        }
        if found.any() {
            let hit = pack_hit(&paths.hit);
            self.hits.push(found, &array::from_fn(|k| if k < GOING { row[k] } else { hit[k - GOING] }));
        }
    }

    /// Rays left the scene.
    #[inline(always)]
    fn leave(&mut self, missed: R::Mask, row: &[R; MISSED]) {
        if self.world.plan.environment || S::OWN_LIGHT {
            self.missed.push(missed, row);
            if self.missed.full() > 0 {
                self.add_environment();
                self.missed.keep_rest();
            }
        } else if P::ACTIVE {
            let [.., slot, bounce] = *row;
            self.note_ends(Lanes { slot: slot.to_bits(), bounce, active: missed });
        }
    }

    /// Radiance of the environment for a packet of rays that left the scene.
    #[inline(never)]
    fn add_environment(&mut self) {
        let ([dx, dy, dz, bx, by, bz, bsdf_pdf, slot, bounce], active) = self.missed.packet(0);
        let lanes = Lanes { slot: slot.to_bits(), bounce, active };
        let (radiance, pdf) = self.shade.escaped(self.world, Vec3::new(dx, dy, dz));
        let mut contribution = Vec3::new(bx, by, bz).hadamard(radiance) * mis_weight(bsdf_pdf, pdf);
        if S::OWN_LIGHT {
            // A light sample is of one of the two, and is weighed by its density there.
            let (radiance, pdf) = self.shade.escaped_to_own(self.world, Vec3::new(dx, dy, dz));
            contribution = contribution + Vec3::new(bx, by, bz).hadamard(radiance) * mis_weight(bsdf_pdf, pdf);
        }
        let contribution = self.probe.tap_rgb(Stage::Emission, lanes, contribution);
        self.out.add(lanes.slot, contribution, active);
        if P::ACTIVE {
            self.note_ends(lanes);
        }
    }

    fn add_rest(&mut self) {
        if !self.missed.is_empty() {
            self.add_environment();
            self.missed.clear();
        }
    }

    /// Shades the packets that have filled.
    fn shade_full<T: Traversal>(&mut self) {
        let full = self.hits.full();
        if full > 0 {
            for first in (0..full).step_by(R::WIDTH) {
                self.shade_at::<T>(first);
            }
            self.hits.keep_rest();
        }
    }

    fn shade_rest<T: Traversal>(&mut self) {
        if !self.hits.is_empty() {
            self.shade_at::<T>(0);
            self.hits.clear();
        }
    }

    fn shade_at<T: Traversal>(&mut self, first: usize) {
        self.shade(first);
        if self.shadows.len() >= self.pool {
            self.trace_shadows::<T>();
        }
    }

    /// One vertex of the paths of a packet of hits.
    #[inline(never)]
    fn shade(&mut self, first: usize) {
        let arrived = self.hits.rows(first);
        let mut paths = unpack_hits(|k| self.hits.field(k, first), arrived);
        self.counters.shaded(arrived);
        let shadows = self.shadows.len();
        path::vertex(self.world, self.shade, &mut paths, self.out, &mut self.shadows, self.probe);
        self.counters.shadow_rays += (self.shadows.len() - shadows) as u64;
        if P::ACTIVE {
            self.note_ends(paths.lanes(arrived & !paths.alive));
        }
        if paths.alive.any() {
            paths.bounce = paths.bounce + R::one();
            self.next.push(paths.alive, &pack(&paths));
        }
    }

    /// Adds what no shadow ray of this generation finds hidden.
    fn trace_shadows<T: Traversal>(&mut self) {
        for first in (0..self.shadows.len()).step_by(R::WIDTH * together::<R>()) {
            self.trace_some_shadows::<T>(first);
        }
        self.shadows.clear();
        self.tap_ends();
    }

    /// Of the packets from `first` on.
    #[inline(never)]
    fn trace_some_shadows<T: Traversal>(&mut self, first: usize) {
        let count = (self.shadows.len() - first).div_ceil(R::WIDTH).min(together::<R>());
        let none = R::Mask::splat(false);
        let mut rays = [Ray::new(Vec3::zero(), Vec3::zero(), R::zero()); TOGETHER];
        let (mut active, mut occluded) = ([none; TOGETHER], [none; TOGETHER]);
        for k in 0..count {
            let first = first + k * R::WIDTH;
            (rays[k], active[k]) = (shadow_ray(&self.shadows.fields(0, first)), self.shadows.rows(first));
        }
        self.world.occluded_many::<R, T::Shadow>(&rays[..count], &active[..count], &mut occluded[..count]);
        for (k, occluded) in occluded.into_iter().enumerate().take(count) {
            self.add_unhidden::<T>(first + k * R::WIDTH, active[k], occluded);
        }
    }

    /// Of the packet from `first` on.
    #[inline(always)]
    fn add_unhidden<T: Traversal>(&mut self, first: usize, carries: R::Mask, occluded: R::Mask) {
        let [r, g, b, slot, bounce] = self.shadows.fields(CONTRIBUTION, first);
        let (world, contribution) = (self.world, Vec3::new(r, g, b));
        let lanes = |active| Lanes::<R> { slot: slot.to_bits(), bounce, active };
        let occluded = self.probe.tap_mask(Stage::Shadow, lanes(carries), occluded);
        self.out.add(slot.to_bits(), contribution, carries & !occluded);
        let hidden = carries & occluded;
        if world.plan.cutouts && hidden.any() {
            let ray = shadow_ray(&self.shadows.fields(0, first));
            let clear = cutout::transmittance::<R, T::Bounce>(world, &ray, hidden);
            let clear = self.probe.tap(Stage::Shadow, lanes(hidden), clear);
            self.out.add(slot.to_bits(), contribution * clear, hidden);
        }
    }

    fn note_ends(&mut self, lanes: Lanes<R>) {
        for lane in super::tile::lanes_of(lanes.active.bits()) {
            self.ended.push((lanes.slot.lane(lane), lanes.bounce.lane(lane)));
        }
    }

    /// Shows the probe what paths found that have ended and of which no shadow ray is out.
    fn tap_ends(&mut self) {
        if self.world.plan.path_reuse {
            // Its own path is not all that a sample will have found.
            return self.ended.clear();
        }
        for (slot, bounce) in self.ended.drain(..) {
            let lanes = Lanes::<f32> { slot: Bits::splat(slot), bounce, active: true };
            let rgb = &mut self.out.rgb[slot as usize];
            *rgb = self.probe.tap_rgb(Stage::Radiance, lanes, Vec3::splat(*rgb)).lane(0);
        }
    }
}
