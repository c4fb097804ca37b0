//! Where light paths start: at a point of an emitter chosen by power, in a direction by cosine.

use super::super::pattern;
use super::super::world::World;
use super::LightPaths;
use super::ratio::light_starts;
use super::rows::Walk;
use super::wave::LightJob;
use crate::geometry::{Hit, Ray, SurfacePoint, inner_weights, offset_origin, sphere_point, triangle_point};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::light::LightSample;
use crate::sampling::dimensions::*;
use crate::sampling::{Frame, Sampler, Site, warp};

/// Sets the numbers of light paths apart from those of the camera's: the fraction of √5.
const LIGHT_SEED: u64 = 0x3c6e_f372_fe94_f82b;

/// Paths `next …` of a job, in as many lanes as it has left.
#[inline(never)]
pub fn start<R: Real>(world: &World, paths: &LightPaths, job: &LightJob, next: u32) -> Walk<R> {
    let lanes = (job.count - next).min(R::WIDTH as u32);
    let alive = R::Mask::from_bits(((1u64 << lanes) - 1) as u32);
    let mut rng = Sampler::<R>::idle();
    let mut slot = R::Bits::splat(0);
    for lane in 0..lanes {
        // All paths of all samples make one sequence, so that they fill the lights and directions evenly together.
        let number = u64::from(job.sample) * u64::from(paths.count) + u64::from(job.first + next + lane);
        let (high, low) = ((number >> 32) as u32, number as u32);
        rng.seed_lane(world.sampler, lane as usize, world.seed ^ LIGHT_SEED, Site::alone(high), low);
        slot.set_lane(lane as usize, next + lane);
    }
    // In the place of bounce 0: the light.
    let u = rng.bounce_dims(world.sampler, R::zero());
    let position = [u[LIGHT_POSITION], u[LIGHT_POSITION + 1]];
    let Some(lights) = &world.lights else { return idle(rng, slot) };
    let (primitive, radiance, place) = lights.choose_emitter(position, u[LIGHT_CHOICE]);
    let (at, ng) = point(world, primitive, place, alive);
    let mut light = LightSample { ng, radiance, primitive, place, ..LightSample::none() };
    if world.plan.patterned_lights {
        pattern::look_up(world, &mut light, alive);
    }
    let [_, row] = world.tags.fetch::<R>(primitive, alive);
    let density = paths.start_density(world, primitive, row, alive);
    let local = warp::cosine_hemisphere([u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]]);
    let direction = Frame::from_normal(ng).to_world(local);
    let each = light_starts(density, paths.number::<R>());
    let ray = Ray { origin: offset_origin(at.p, at.error, ng, direction), direction, t_max: R::splat(f32::INFINITY) };
    Walk {
        ray,
        beta: light.radiance * each,
        ratio: each,
        emitter: primitive,
        emitter_cos: local.z,
        alive: alive & density.gt(R::zero()),
        ..idle(rng, slot)
    }
}

/// On its way nowhere.
fn idle<R: Real>(rng: Sampler<R>, slot: R::Bits) -> Walk<R> {
    Walk {
        ray: Ray::new(Vec3::zero(), Vec3::zero(), R::zero()),
        hit: Hit::miss(R::zero()),
        beta: Vec3::zero(),
        rng,
        ratio: R::zero(),
        bounce: R::one(),
        emitter: R::Bits::splat(0),
        emitter_cos: R::zero(),
        slot,
        alive: R::Mask::splat(false),
    }
}

/// The point at a [place](LightSample::place) on an emitter, and the normal of the side that emits.
#[inline(always)]
fn point<R: Real>(world: &World, primitive: R::Bits, place: [R; 2], active: R::Mask) -> (SurfacePoint<R>, Vec3<R>) {
    let spheres = if world.plan.spheres { world.on_sphere::<R>(primitive) & active } else { R::Mask::splat(false) };
    let triangle = world.triangles.fetch::<R>(primitive, active & !spheres);
    let (b1, b2) = inner_weights(&triangle, place[0], place[1]);
    let (mut at, mut ng) = (triangle_point(&triangle, b1, b2), triangle.ng);
    if spheres.any() {
        let sphere = world.sphere_at(primitive, spheres);
        let near = warp::uniform_sphere(place).mul_add(sphere.radius, sphere.center);
        let (on_sphere, normal) = sphere_point(&sphere, near);
        at.p = Vec3::select(spheres, on_sphere.p, at.p);
        at.error = Vec3::select(spheres, on_sphere.error, at.error);
        ng = Vec3::select(spheres, normal, ng);
    }
    (at, ng)
}
