//! The paths of a worker on their way: rays are traced, packets of hits shaded, shadow rays traced, generation by
//! generation.
//!
//! After every step lanes fall away: rays miss, vertices are unlit, paths end. What is left is moved together, so that
//! each step runs on full packets. Paths that ended make room for camera samples (regeneration) until the job runs out.
//! A path's contributions are added to its slot in its own order, whatever company it was in: the sums are the same at
//! any width.

use super::cutout;
use super::path::{self, Paths, Traversal, mis_weight};
use super::probe::{Lanes, Probe, Stage};
use super::queue::Queue;
use super::rows::{GOING, HIT, MISSED, SHADOW, pack, pack_hits, pack_shadows, shadow_ray, unpack, unpack_hits};
use super::shade::Shade;
use super::tile::{CameraQueue, Counters, Job, SampleBuffer};
use super::world::World;
use crate::geometry::{Hit, Ray};
use crate::lane::{Bits, Mask, Real, Vec3};
use core::marker::PhantomData;

/// Paths of a worker on their way at once: they and what waits stay in the second cache; 128 were up to 5 % slower.
const POOL: usize = 512;

/// Packets traced together.
const TOGETHER: usize = 8;

/// Renders all samples of a job into `out`.
pub fn render<R: Real, T: Traversal, S: Shade, P: Probe>(
    world: &World,
    shade: &S,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
    probe: &mut P,
) {
    let mut camera = CameraQueue::<R>::new(world, job);
    let mut wave = Wave::<R, T, S, P>::new(world, shade, POOL, out, counters, probe);
    wave.run(|counters| {
        let packet = camera.next_packet::<T::Camera>(true)?;
        counters.traced(true, packet.active);
        Some(Paths::begin(packet.ray, packet.hit, packet.rng, packet.slot, packet.active))
    });
}

/// See the module.
pub(super) struct Wave<'a, R: Real, T, S, P> {
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
    hits: Queue<R, HIT>,
    missed: Queue<R, MISSED>,
    shadows: Queue<R, SHADOW>,
    /// Slots and last bounces of paths that ended in this generation; only for a probe.
    ended: Vec<(u32, f32)>,
    kinds: PhantomData<T>,
}

impl<'a, R: Real, T: Traversal, S: Shade, P: Probe> Wave<'a, R, T, S, P> {
    /// Nothing on its way; room for `pool` paths, and one packet at least.
    pub fn new(
        world: &'a World,
        shade: &'a S,
        pool: usize,
        out: &'a mut SampleBuffer,
        counters: &'a mut Counters,
        probe: &'a mut P,
    ) -> Self {
        // Hits that wait are fewer than a packet: so there are always paths to go on with, or room for more.
        let pool = pool.max(R::WIDTH);
        let room = pool + 2 * R::WIDTH;
        Wave {
            world,
            shade,
            out,
            counters,
            probe,
            pool,
            going: Queue::new(room),
            next: Queue::new(room),
            hits: Queue::new(2 * R::WIDTH),
            missed: Queue::new(2 * R::WIDTH),
            shadows: Queue::new(room),
            ended: Vec::new(),
            kinds: PhantomData,
        }
    }

    /// Takes paths that have been traced from `camera` as long as it has any, and follows all to their end.
    pub fn run(&mut self, mut camera: impl FnMut(&mut Counters) -> Option<Paths<R>>) {
        let mut more = true;
        loop {
            core::mem::swap(&mut self.going, &mut self.next);
            for first in (0..self.going.len()).step_by(R::WIDTH * TOGETHER) {
                self.trace(first);
            }
            self.going.clear();
            while more && self.next.len() + self.hits.len() < self.pool {
                match camera(self.counters) {
                    Some(paths) => self.arrive(paths),
                    None => more = false,
                }
            }
            if !more {
                self.shade_rest();
            }
            self.trace_shadows();
            if !more && self.next.is_empty() {
                break;
            }
        }
        while !self.missed.is_empty() {
            self.add_environment();
        }
        self.tap_ends();
    }

    /// Traces the packets from `first` on.
    fn trace(&mut self, first: usize) {
        let count = (self.going.len() - first).div_ceil(R::WIDTH).min(TOGETHER);
        let nowhere = Ray::new(Vec3::zero(), Vec3::zero(), R::zero());
        let (mut rays, mut active) = ([nowhere; TOGETHER], [R::Mask::splat(false); TOGETHER]);
        let mut hits = [Hit::miss(R::zero()); TOGETHER];
        for k in 0..count {
            let (row, alive) = self.going.packet(first + k * R::WIDTH);
            (rays[k], active[k]) = (unpack(&row, alive).ray, alive);
            self.counters.traced(false, alive);
        }
        self.world.closest_many::<R, T::Bounce>(&rays[..count], &active[..count], &mut hits[..count]);
        for (k, hit) in hits[..count].iter().enumerate() {
            let (row, alive) = self.going.packet(first + k * R::WIDTH);
            let mut paths = unpack(&row, alive);
            paths.hit = cutout::stopping::<R, T::Bounce>(self.world, &paths.ray, &paths.rng, paths.bounce, *hit, alive);
            self.arrive(paths);
        }
    }

    /// Rays have been traced: those that hit are shaded as soon as they fill a packet.
    #[inline(always)]
    fn arrive(&mut self, mut paths: Paths<R>) {
        let lanes = paths.lanes(paths.alive);
        path::tap_hit(self.probe, lanes, &mut paths.hit);
        let hit = paths.alive & paths.hit.valid();
        let missed = paths.alive & !hit;
        if missed.any() {
            self.leave(&paths, missed);
        }
        if hit.all() {
            self.shade(paths);
        } else if hit.any() {
            self.hits.push(hit, &pack_hits(&paths));
            if self.hits.len() >= R::WIDTH {
                self.shade_waiting();
            }
        }
    }

    /// Rays left the scene.
    #[inline(always)]
    fn leave(&mut self, paths: &Paths<R>, missed: R::Mask) {
        if self.world.plan.environment || S::OWN_LIGHT {
            let (d, b) = (paths.ray.direction, paths.beta);
            let slot = R::from_bits(paths.slot);
            self.missed.push(missed, &[d.x, d.y, d.z, b.x, b.y, b.z, paths.bsdf_pdf, slot, paths.bounce]);
            if self.missed.len() >= R::WIDTH {
                self.add_environment();
            }
        } else if P::ACTIVE {
            self.note_ends(paths.lanes(missed));
        }
    }

    /// Radiance of the environment for a packet of rays that left the scene.
    #[inline(never)]
    fn add_environment(&mut self) {
        let ([dx, dy, dz, bx, by, bz, bsdf_pdf, slot, bounce], active) = self.missed.pop();
        let lanes = Lanes { slot: slot.to_bits(), bounce, active };
        let (radiance, pdf) = self.shade.escaped(self.world, Vec3::new(dx, dy, dz));
        let contribution = Vec3::new(bx, by, bz).hadamard(radiance) * mis_weight(bsdf_pdf, pdf);
        let contribution = self.probe.tap_rgb(Stage::Emission, lanes, contribution);
        self.out.add(lanes.slot, contribution, active);
        if P::ACTIVE {
            self.note_ends(lanes);
        }
    }

    /// A packet of hits that came one by one.
    #[inline(never)]
    fn shade_waiting(&mut self) {
        let (row, alive) = self.hits.pop();
        self.shade(unpack_hits(&row, alive));
    }

    fn shade_rest(&mut self) {
        while !self.hits.is_empty() {
            self.shade_waiting();
        }
    }

    /// One vertex of every path.
    #[inline(never)]
    fn shade(&mut self, mut paths: Paths<R>) {
        self.counters.shaded(paths.alive);
        let arrived = paths.alive;
        if let Some(direct) = path::vertex(self.world, self.shade, &mut paths, self.out, self.probe) {
            self.counters.shadow(direct.carries);
            self.shadows.push(direct.carries, &pack_shadows(&direct, &paths));
        }
        if P::ACTIVE {
            self.note_ends(paths.lanes(arrived & !paths.alive));
        }
        if paths.alive.any() {
            paths.bounce = paths.bounce + R::one();
            self.next.push(paths.alive, &pack(&paths));
        }
        if self.shadows.len() >= self.pool {
            self.trace_shadows();
        }
    }

    /// Adds what no shadow ray of this generation finds hidden.
    fn trace_shadows(&mut self) {
        for first in (0..self.shadows.len()).step_by(R::WIDTH * TOGETHER) {
            self.trace_some_shadows(first);
        }
        self.shadows.clear();
        self.tap_ends();
    }

    /// Of the packets from `first` on.
    #[inline(never)]
    fn trace_some_shadows(&mut self, first: usize) {
        let count = (self.shadows.len() - first).div_ceil(R::WIDTH).min(TOGETHER);
        let none = R::Mask::splat(false);
        let mut rays = [Ray::new(Vec3::zero(), Vec3::zero(), R::zero()); TOGETHER];
        let (mut active, mut occluded) = ([none; TOGETHER], [none; TOGETHER]);
        for k in 0..count {
            let (row, carries) = self.shadows.packet(first + k * R::WIDTH);
            (rays[k], active[k]) = (shadow_ray(&row), carries);
        }
        self.world.occluded_many::<R, T::Shadow>(&rays[..count], &active[..count], &mut occluded[..count]);
        for (k, occluded) in occluded.into_iter().enumerate().take(count) {
            let (row, carries) = self.shadows.packet(first + k * R::WIDTH);
            self.add_unhidden(&row, carries, occluded);
        }
    }

    #[inline(always)]
    fn add_unhidden(&mut self, row: &[R; SHADOW], carries: R::Mask, occluded: R::Mask) {
        let [.., r, g, b, slot, bounce] = *row;
        let (world, contribution) = (self.world, Vec3::new(r, g, b));
        let lanes = |active| Lanes::<R> { slot: slot.to_bits(), bounce, active };
        let occluded = self.probe.tap_mask(Stage::Shadow, lanes(carries), occluded);
        self.out.add(slot.to_bits(), contribution, carries & !occluded);
        let hidden = carries & occluded;
        if world.plan.cutouts && hidden.any() {
            let clear = cutout::transmittance::<R, T::Bounce>(world, &shadow_ray(row), hidden);
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
        for (slot, bounce) in self.ended.drain(..) {
            let lanes = Lanes::<f32> { slot: Bits::splat(slot), bounce, active: true };
            let rgb = &mut self.out.rgb[slot as usize];
            *rgb = self.probe.tap_rgb(Stage::Radiance, lanes, Vec3::splat(*rgb)).lane(0);
        }
    }
}
