//! The gather estimator: at the first hit n directions with the weights of a Monte Carlo or a Bayesian estimator.
//!
//! L_r = ∫ L_i f cosθ = ∫ g p with p known (1 or cosθ) and g = L_i f cosθ / p: Σ w_i g_i, where w_i = P/n, or the weights
//! that the posterior of a Gaussian process over g gives. The n rays of a hit leave one origin as packets: the lanes are
//! directions. Each ray's light goes to its index, and a hit's sum is taken in the order of indices.
//!
//! Ray i of a sample draws its numbers from a child key of the sample's, a block for every bounce as a path does.

mod draw;
mod lobe;
mod pilot;
mod shrink;
mod tables;
mod trace;
mod worker;

pub use tables::{GatherReport, GatherTables};

use super::material::MaterialAt;
use super::path::same_side;
use super::surface::Surface;
use super::tile::{CameraQueue, Counters, Job, SampleBuffer, lanes_of};
use super::view::towards_viewer;
use super::world::World;
use crate::accel::{Built, Packet};
use crate::geometry::MISS;
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::sampling::dimensions::*;
use crate::sampling::{Frame, Sampler, SamplerKind, child_key, sample_key};
use crate::scene::Material;
use tables::Family;
use worker::Worker;

/// The first hit of one camera sample, the same in every lane.
struct Vertex<R: Real> {
    surface: Surface<R>,
    frame: Frame<R>,
    wo: Vec3<R>,
    /// Of the camera sample.
    key: u64,
    /// The sample's numbers for this hit.
    u: [f32; BOUNCE],
    /// The number of the first ray: rays about the normal and about the mirror direction have numbers of their own.
    first_ray: usize,
}

/// Of the rays about the mirror direction.
const LOBE_RAYS: usize = 1 << 30;

impl<R: Real> Vertex<R> {
    /// The same hit with other random numbers.
    fn again(&self, key: u64, u: [f32; BOUNCE]) -> Self {
        Vertex { surface: self.surface.in_all_lanes(0), key, u, ..*self }
    }

    /// The generators of rays `first …`, and their numbers for this hit.
    #[inline(always)]
    fn numbers(&self, first: usize) -> (Sampler<R>, [R; BOUNCE]) {
        let mut rng = Sampler::independent(|lane| child_key(self.key, (self.first_ray + first + lane) as u32));
        let u = rng.bounce_dims(SamplerKind::Independent, R::zero());
        (rng, u)
    }
}

/// Where the directions of an estimate lie, and what scatters their light.
struct About<'a, R: Real> {
    family: &'a Family,
    material: &'a MaterialAt<R>,
    /// What of it is gathered elsewhere, and taken off here.
    without: Option<&'a MaterialAt<R>>,
    /// About the mirror direction, in the frame of the normal; `None`: about the normal.
    lobe: Option<Frame<R>>,
}

/// The tables of a world that is complete but for them.
pub fn prepare(world: &mut World, materials: &[Material]) {
    world.gather = Some(GatherTables::new(world, materials));
    shrink::shrink(world);
}

/// Renders all samples of a job. Nothing where the world has no tables for it.
pub fn render<R: Real>(world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters) {
    let Some(tables) = &world.gather else { return };
    visit::<R>(&mut Worker::new(world, tables, None), world, job, out, counters);
}

/// The first hits of a job, one after the other.
fn visit<R: Real>(worker: &mut Worker, world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters) {
    let mut queue = CameraQueue::<R>::new(world, job);
    while let Some(mut packet) = queue.next_packet::<Built<Packet>>(true) {
        counters.traced(true, packet.active);
        counters.shaded(packet.active);
        let missed = packet.hit.primitive.eq(R::Bits::splat(MISS)) & packet.active;
        let found = packet.active & !missed;
        let mut surface = Surface::at(world, &packet.ray, &packet.hit, found);
        let mut radiance =
            world.background(packet.ray.direction, missed) + surface.emitted(packet.ray.direction, found);
        if out.features.is_some() {
            let normal = towards_viewer(surface.ns, packet.ray.direction);
            let distance = packet.hit.t * R::splat(world.unit);
            out.write_features(packet.slot, surface.material.albedo(), normal, distance, found);
        }
        let u = packet.rng.bounce_dims(SamplerKind::Independent, R::zero());
        let outward = -packet.ray.direction;
        if world.plan.shading_normals {
            surface.face(outward);
        }
        let frame = Frame::from_normal(surface.ns);
        let wo = frame.to_local(outward);
        let scatters = found & same_side(wo.z, surface.ng.dot(outward));
        let scatters = if world.max_bounces > 0.0 { scatters } else { R::Mask::splat(false) };
        for lane in lanes_of(scatters.bits()) {
            let vector = |v: &Vec3<R>| Vec3::splat(v.lane(lane));
            let vertex = Vertex {
                surface: surface.in_all_lanes(lane),
                frame: Frame {
                    tangent: vector(&frame.tangent),
                    bitangent: vector(&frame.bitangent),
                    normal: vector(&frame.normal),
                },
                wo: vector(&wo),
                key: slot_key(world, job, packet.slot.lane(lane)),
                u: u.map(|u| u.lane(lane)),
                first_ray: 0,
            };
            if worker.watch.is_some() {
                shrink::look::<R>(worker, &vertex, counters);
                continue;
            }
            let gathered = worker.estimate::<R>(vertex, counters);
            let own = radiance.lane(lane);
            radiance.set_lane(lane, std::array::from_fn(|c| own[c] + gathered.radiance[c] as f32));
            if world.plan.posterior {
                out.write_posterior(packet.slot.lane(lane), gathered.variance.map(|v| v as f32));
            }
        }
        out.add(packet.slot, radiance, packet.active);
    }
}

/// The key of the sample that writes to a slot.
fn slot_key(world: &World, job: &Job, slot: u32) -> u64 {
    let (pixel, sample) = (slot / job.samples, slot % job.samples);
    let (x, y) = (job.x + pixel % job.width, job.y + pixel / job.width);
    sample_key(world.seed, y * world.film.width + x, job.first_sample + sample)
}
