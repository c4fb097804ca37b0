//! The light paths of a job on their way, generation by generation, as [`Wave`](super::super::wave) leads camera paths:
//! what falls away is made up for, so that packets stay full. Splats of a path come in the path's own order.

use super::super::cutout;
use super::super::queue::Queue;
use super::super::tile::{Counters, lanes_of};
use super::super::wave::{POOL, TOGETHER, together};
use super::super::world::World;
use super::LightPaths;
use super::rows::*;
use super::start::start;
use super::vertex::vertex;
use crate::accel::{Built, Shadow, Stream};
use crate::geometry::{Hit, Ray};
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3};

/// Light paths to trace together.
#[derive(Clone, Copy, Debug)]
pub struct LightJob {
    /// The sample of the film that they belong to.
    pub sample: u32,
    /// The first of its light paths.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// What one vertex of a light path adds to a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// The path within its job.
    pub path: u32,
    /// Row by row from the top left.
    pub pixel: u32,
    /// Radiance.
    pub rgb: [f32; 3],
}

/// Traces a job's light paths and appends what they splat: those of one path in the path's order, paths in any.
pub fn trace<R: Real>(world: &World, job: &LightJob, splats: &mut Vec<Splat>, counters: &mut Counters) {
    let Some(paths) = world.light_paths else { return };
    let mut wave = LightWave::<R> {
        world,
        paths,
        splats,
        counters,
        going: Queue::new(),
        next: Queue::new(),
        hits: Queue::new(),
        links: Queue::new(),
    };
    wave.run(job);
}

struct LightWave<'a, R: Real> {
    world: &'a World,
    paths: LightPaths,
    splats: &'a mut Vec<Splat>,
    counters: &'a mut Counters,
    /// Rays to trace, of this generation and the next.
    going: Queue<R, GOING>,
    next: Queue<R, GOING>,
    /// Too few so far.
    hits: Queue<R, HIT, { 3 * MAX_WIDTH }>,
    links: Queue<R, LINK>,
}

impl<R: Real> LightWave<'_, R> {
    fn run(&mut self, job: &LightJob) {
        let mut started = 0;
        loop {
            core::mem::swap(&mut self.going, &mut self.next);
            for first in (0..self.going.len()).step_by(R::WIDTH * together::<R>()) {
                self.trace(first);
            }
            self.going.clear();
            while started < job.count && self.next.len() + self.hits.len() < POOL {
                let walk = start::<R>(self.world, &self.paths, job, started);
                self.next.push(walk.alive, &pack(&walk));
                started += R::WIDTH as u32;
            }
            if started >= job.count && !self.hits.is_empty() {
                self.shade_waiting();
                self.hits.clear();
            }
            self.trace_links();
            if started >= job.count && self.next.is_empty() {
                break;
            }
        }
    }

    /// Traces the packets from `first` on; those that hit are shaded as soon as they fill a packet.
    fn trace(&mut self, first: usize) {
        let count = (self.going.len() - first).div_ceil(R::WIDTH).min(together::<R>());
        let nowhere = Ray::new(Vec3::zero(), Vec3::zero(), R::zero());
        let (mut rays, mut active) = ([nowhere; TOGETHER], [R::Mask::splat(false); TOGETHER]);
        let mut hits = [Hit::miss(R::zero()); TOGETHER];
        for k in 0..count {
            let (row, alive) = self.going.packet(first + k * R::WIDTH);
            (rays[k], active[k]) = (unpack(&row, alive).ray, alive);
            self.counters.traced(false, alive);
        }
        self.world.closest_many::<R, Built<Stream>>(&rays[..count], &active[..count], &mut hits[..count]);
        for (k, hit) in hits[..count].iter().enumerate() {
            let (row, alive) = self.going.packet(first + k * R::WIDTH);
            let mut walk = unpack(&row, alive);
            walk.hit = cutout::stopping::<R, Built<Stream>>(self.world, &walk.ray, &walk.rng, walk.bounce, *hit, alive);
            let hit = alive & walk.hit.valid();
            if hit.all() {
                self.shade(walk);
            } else if hit.any() {
                self.hits.push(hit, &pack_hits(&walk));
                if self.hits.full() > 0 {
                    self.shade_waiting();
                    self.hits.keep_rest();
                }
            }
        }
    }

    /// A packet of hits that came one by one.
    #[inline(never)]
    fn shade_waiting(&mut self) {
        let (row, alive) = self.hits.packet(0);
        self.shade(unpack_hits(&row, alive));
    }

    /// One vertex of every path.
    #[inline(never)]
    fn shade(&mut self, mut walk: Walk<R>) {
        self.counters.shaded(walk.alive);
        if let Some(link) = vertex(self.world, &self.paths, &mut walk) {
            self.counters.shadow(link.carries);
            self.links.push(link.carries, &pack_link(&link, walk.slot));
        }
        if walk.alive.any() {
            walk.bounce = walk.bounce + R::one();
            self.next.push(walk.alive, &pack(&walk));
        }
        if self.links.len() >= POOL {
            self.trace_links();
        }
    }

    /// Splats what nothing hides from the camera.
    fn trace_links(&mut self) {
        for first in (0..self.links.len()).step_by(R::WIDTH * together::<R>()) {
            self.trace_some_links(first);
        }
        self.links.clear();
    }

    /// Of the packets from `first` on.
    #[inline(never)]
    fn trace_some_links(&mut self, first: usize) {
        let count = (self.links.len() - first).div_ceil(R::WIDTH).min(together::<R>());
        let none = R::Mask::splat(false);
        let mut rays = [Ray::new(Vec3::zero(), Vec3::zero(), R::zero()); TOGETHER];
        let (mut active, mut occluded) = ([none; TOGETHER], [none; TOGETHER]);
        for k in 0..count {
            let (row, carries) = self.links.packet(first + k * R::WIDTH);
            (rays[k], active[k]) = (link_ray(&row), carries);
        }
        self.world.occluded_many::<R, Built<Shadow>>(&rays[..count], &active[..count], &mut occluded[..count]);
        for (k, occluded) in occluded.into_iter().enumerate().take(count) {
            let (row, carries) = self.links.packet(first + k * R::WIDTH);
            let hidden = carries & occluded;
            let mut clear = R::one().masked(carries & !occluded);
            if self.world.plan.cutouts && hidden.any() {
                let share = cutout::transmittance::<R, Built<Stream>>(self.world, &rays[k], hidden);
                clear = R::select(hidden, share, clear);
            }
            self.splat(&row, clear);
        }
    }

    #[inline(always)]
    fn splat(&mut self, row: &[R; LINK], clear: R) {
        let [.., r, g, b, pixel, slot] = *row;
        let rgb = Vec3::new(r, g, b) * clear;
        let (pixel, slot) = (pixel.to_bits(), slot.to_bits());
        for lane in lanes_of(clear.gt(R::zero()).bits()) {
            self.splats.push(Splat { path: slot.lane(lane), pixel: pixel.lane(lane), rgb: rgb.lane(lane) });
        }
    }
}
