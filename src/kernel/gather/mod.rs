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
mod tables;
mod trace;

pub use tables::{GatherReport, GatherTables};

use super::cutout;
use super::material::{AllModels, MaterialAt};
use super::path::{Traversal, light_ray, same_side};
use super::pattern;
use super::surface::Surface;
use super::tile::{CameraQueue, Counters, Job, SampleBuffer, lanes_of};
use super::view::towards_viewer;
use super::world::World;
use crate::geometry::{MISS, Ray};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::sampling::dimensions::*;
use crate::sampling::{Frame, Sampler, SamplerKind, child_key, sample_key};
use crate::scene::{GatherLights, GatherPdf};
use draw::Directions;
use lobe::Parts;
use tables::Family;
use trace::{Beams, Estimate};

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
    /// About the mirror direction, in the frame of the normal; `None`: about the normal.
    lobe: Option<Frame<R>>,
}

/// What a worker keeps between hits.
struct Worker<'a> {
    world: &'a World,
    tables: &'a GatherTables,
    drawn: Directions,
    beams: Beams,
}

/// Renders all samples of a job. Nothing where the world has no tables for it.
pub fn render<R: Real, T: Traversal>(world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters) {
    let Some(tables) = &world.gather else { return };
    let mut worker =
        Worker { world, tables, drawn: Directions::new(tables.count()), beams: Beams::new(tables.count()) };
    let mut queue = CameraQueue::<R>::new(world, job);
    while let Some(mut packet) = queue.next_packet::<T::Camera>(true) {
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
            let gathered = worker.estimate::<R, T>(vertex, counters);
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

impl Worker<'_> {
    fn estimate<R: Real, T: Traversal>(&mut self, mut vertex: Vertex<R>, counters: &mut Counters) -> Estimate {
        let (tables, believes) = (self.tables, self.world.plan.posterior);
        let sampled = tables.settings.lights == GatherLights::Sampled;
        let mut found = Estimate::default();
        let delta = vertex.surface.material.is_delta::<AllModels>().any();
        if !delta && self.world.lights.is_some() && (sampled || self.world.plan.delta_lights) {
            self.add_lights::<R, T>(&vertex, sampled, counters);
            found.add(self.beams.settle(None, believes));
        }
        if !vertex.surface.material.gathers().any() {
            self.scatter::<R, T>(&vertex, sampled, counters);
            found.add(self.beams.settle(None, believes));
        } else if !sampled || self.world.max_bounces > 1.0 {
            self.turn(&mut vertex);
            if tables.settings.pdf == GatherPdf::Lobe {
                found.add(self.gather_parts::<R, T>(&mut vertex, sampled, counters));
            } else {
                let material = vertex.surface.material.in_all_lanes(0);
                let about_normal = About { family: &tables.base, material: &material, lobe: None };
                found.add(self.gather::<R, T>(&vertex, &about_normal, sampled, counters));
            }
        }
        found
    }

    /// A Lambert base about the normal, a glossy lobe about the mirror direction.
    #[inline(never)]
    fn gather_parts<R: Real, T: Traversal>(
        &mut self,
        vertex: &mut Vertex<R>,
        sampled: bool,
        counters: &mut Counters,
    ) -> Estimate {
        let tables = self.tables;
        let mut found = Estimate::default();
        let Parts { base, lobe } = Parts::of(&vertex.surface.material, &self.world.plan);
        if let Some(material) = &base {
            let about = About { family: &tables.base, material, lobe: None };
            found.add(self.gather::<R, T>(vertex, &about, sampled, counters));
        }
        if let Some((material, kind)) = &lobe {
            let family = kind.nearest(&tables.lobe_kinds).map_or(&tables.base, |i| &tables.lobes[i]);
            vertex.first_ray = LOBE_RAYS;
            let mirror = lobe::mirror_frame(vertex, tables.settings.rotate);
            let about = About { family, material, lobe: Some(mirror) };
            found.add(self.gather::<R, T>(vertex, &about, sampled, counters));
        }
        found
    }

    /// Turns the tangents about the normal.
    #[inline(always)]
    fn turn<R: Real>(&self, vertex: &mut Vertex<R>) {
        if !self.tables.settings.rotate {
            return;
        }
        let (sin, cos) = crate::lane::math::sincos_2pi(R::splat(vertex.u[ROTATION]));
        let Frame { tangent, bitangent, normal } = vertex.frame;
        let turned = tangent.mul_add(cos, bitangent * sin);
        vertex.frame = Frame { tangent: turned, bitangent: bitangent.mul_add(cos, tangent * -sin), normal };
        vertex.wo = Vec3::new(
            vertex.wo.x.mul_add(cos, vertex.wo.y * sin),
            vertex.wo.y.mul_add(cos, vertex.wo.x * -sin),
            vertex.wo.z,
        );
    }

    /// Weighted directions of a point set.
    fn gather<R: Real, T: Traversal>(
        &mut self,
        vertex: &Vertex<R>,
        about: &About<R>,
        sampled: bool,
        counters: &mut Counters,
    ) -> Estimate {
        let Worker { world, tables, drawn, beams } = self;
        let set = about.family.at(tables, vertex, drawn);
        let surface = &vertex.surface;
        let up = R::one().copysign(vertex.wo.z);
        let direct = R::Mask::splat(!sampled);
        for first in (0..tables.count()).step_by(R::WIDTH) {
            let active = first_lanes::<R>(tables.count() - first);
            let [x, y, z, weight, p] = set.load::<R>(first);
            let wi = match &about.lobe {
                None => Vec3::new(x, y, z * up),
                Some(mirror) => mirror.to_world(Vec3::new(x, y, z)),
            };
            let direction = vertex.frame.to_world(wi);
            let keep = active & same_side(wi.z, surface.ng.dot(direction));
            let f_cos = about.material.eval::<AllModels>(&world.plan, vertex.wo, wi, keep).value;
            let mut weight = weight / p;
            if world.plan.shading_normals {
                weight = weight * surface.terminator(direction, wi.z, vertex.wo.z);
            }
            let throughput = f_cos * weight;
            let ray = Ray { origin: surface.leave(direction), direction, t_max: R::splat(f32::INFINITY) };
            let carries = keep & throughput.max_component().abs().gt(R::zero());
            beams.add::<R, T>(world, vertex, first, &ray, throughput, carries, direct, counters);
        }
        beams.settle(Some(set), world.plan.posterior)
    }

    /// Directions that the material draws: a delta lobe has no others, and glass has some on both sides.
    fn scatter<R: Real, T: Traversal>(&mut self, vertex: &Vertex<R>, sampled: bool, counters: &mut Counters) {
        let Worker { world, tables, beams, .. } = self;
        let surface = &vertex.surface;
        let share = R::splat(tables.count() as f32).recip();
        for first in (0..tables.count()).step_by(R::WIDTH) {
            let active = first_lanes::<R>(tables.count() - first);
            let (_, u) = vertex.numbers(first);
            let u_direction = [u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]];
            let material = &surface.material;
            let sample = material.sample::<AllModels>(&world.plan, vertex.wo, u[BSDF_LOBE], u_direction, active);
            let direction = vertex.frame.to_world(sample.wi);
            let keep = active & sample.valid & same_side(sample.wi.z, surface.ng.dot(direction));
            let mut share = share;
            if world.plan.shading_normals {
                let softened = surface.terminator(direction, sample.wi.z, vertex.wo.z);
                share = share * R::select(sample.delta, R::one(), softened);
            }
            let throughput = sample.weight * share;
            let direct = sample.delta | R::Mask::splat(!sampled);
            let ray = Ray { origin: surface.leave(direction), direction, t_max: R::splat(f32::INFINITY) };
            let carries = keep & throughput.max_component().gt(R::zero());
            beams.add::<R, T>(world, vertex, first, &ray, throughput, carries, direct, counters);
        }
    }

    /// n light samples. Unless lights are `sampled`, those without extent alone: the others are seen.
    fn add_lights<R: Real, T: Traversal>(&mut self, vertex: &Vertex<R>, sampled: bool, counters: &mut Counters) {
        let Worker { world, tables, beams, .. } = self;
        let surface = &vertex.surface;
        let share = R::splat(tables.count() as f32).recip();
        for first in (0..tables.count()).step_by(R::WIDTH) {
            let active = first_lanes::<R>(tables.count() - first);
            let (_, u) = vertex.numbers(first);
            let u_position = [u[LIGHT_POSITION], u[LIGHT_POSITION + 1]];
            let Some(mut light) = world.sample_light(surface.at.p, None, u[LIGHT_CHOICE], u_position, active) else {
                return;
            };
            if world.plan.patterned_lights {
                pattern::look_up(world, &mut light, u_position, active);
            }
            let wi = vertex.frame.to_local(light.wi);
            let lit = active & light.pdf.gt(R::zero()) & same_side(wi.z, surface.ng.dot(light.wi));
            let lit = if sampled { lit } else { lit & light.is_delta() };
            let f_cos = surface.material.eval::<AllModels>(&world.plan, vertex.wo, wi, lit).value;
            let mut weight = share / light.pdf;
            if world.plan.shading_normals {
                weight = weight * surface.terminator(light.wi, wi.z, vertex.wo.z);
            }
            let contribution = f_cos.hadamard(light.radiance) * weight;
            let carries = lit & contribution.max_component().gt(R::zero());
            if carries.none() {
                continue;
            }
            counters.shadow(carries);
            let clear = cutout::visible::<R, T::Shadow, T::Bounce>(world, &light_ray(surface, &light), carries);
            beams.put(first, (contribution * clear).masked(carries));
        }
    }
}

/// As many lanes as there are directions left.
#[inline(always)]
fn first_lanes<R: Real>(left: usize) -> R::Mask {
    R::Mask::from_bits(((1u64 << left.min(R::WIDTH)) - 1) as u32)
}
