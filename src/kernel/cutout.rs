//! Cut-outs: surfaces that a ray meets with a probability, their opacity, and else passes as if they were not there.
//!
//! A path passes or stops by a number of its own, so that its throughput stays what it was: E(stops) = opacity. The
//! number is a hash of the sample's number for it at this bounce, the primitive and how many were passed before: the
//! same at any width and in any traversal mode, and independent from surface to surface. Passing is not a bounce: the
//! ray keeps its origin and density, t counts from there, and so MIS weights are those of the unhindered ray.
//!
//! A shadow ray takes the product of 1 − opacity over what it crosses. That is the expectation of the indicator that a
//! path's decisions give, so both kinds of sampling estimate the same integral, and the weights of multiple importance
//! sampling, which depend on the directions alone, still sum to 1: nothing is biased, and no noise is added.
//!
//! Traversal knows nothing of it: [`World::closest`] is asked again from behind each surface that is passed.

use super::maps::{on_sphere, on_triangle};
use super::texture::{OPACITY, OPACITY_MAP};
use super::world::World;
use crate::accel::Mode;
use crate::geometry::{Hit, Ray, SurfacePoint, offset_origin, sphere_point, triangle_point};
use crate::lane::{Bits, Mask, Real, Vec3, array};
use crate::sampling::{Sampler, mix3, to_unit};

/// What lies behind this many surfaces along one ray is not asked for: the last is then opaque.
const MAX_LAYERS: u32 = 1024;

/// The closest hits that stop their ray. `rng` is where the numbers of `bounce` begin; it is only looked at.
#[inline(always)]
pub fn closest<R: Real, M: Mode>(world: &World, ray: &Ray<R>, rng: &Sampler<R>, bounce: R, active: R::Mask) -> Hit<R> {
    stopping::<R, M>(world, ray, rng, bounce, world.closest::<R, M>(ray, active), active)
}

/// The same, of rays whose closest hits are known.
#[inline(always)]
pub fn stopping<R: Real, M: Mode>(
    world: &World,
    ray: &Ray<R>,
    rng: &Sampler<R>,
    bounce: R,
    hit: Hit<R>,
    active: R::Mask,
) -> Hit<R> {
    if world.plan.cutouts { pass::<R, M>(world, ray, || world.opacity_number(rng, bounce), hit, active) } else { hit }
}

/// Goes on behind what lanes pass. Directions are unit.
#[inline(never)]
fn pass<R: Real, M: Mode>(
    world: &World,
    ray: &Ray<R>,
    number: impl Fn() -> R,
    mut hit: Hit<R>,
    active: R::Mask,
) -> Hit<R> {
    let mut rest = *ray;
    let mut undecided = active & hit.valid();
    let mut u = None;
    for layer in 0..MAX_LAYERS {
        // Distances count from where the ray began, whatever it has passed.
        let near = ray.at(hit.t);
        let opacity = opacity(world, &near, &hit, undecided);
        let partial = undecided & opacity.lt(R::one());
        if partial.none() {
            break;
        }
        let u = *u.get_or_insert_with(&number);
        let passes = partial & decision(u, hit.primitive, layer).ge(opacity);
        if passes.none() {
            break;
        }
        let behind = leave(world, &near, &hit, ray.direction, passes);
        rest.origin = Vec3::select(passes, behind, rest.origin);
        let passed = (rest.origin - ray.origin).dot(ray.direction);
        let mut next = world.closest::<R, M>(&rest, passes);
        let found = passes & next.valid();
        next.t = R::select(found, next.t + passed, ray.t_max);
        hit.replace(passes, next);
        undecided = found;
    }
    hit
}

/// Uniform in [0, 1).
#[inline(always)]
fn decision<R: Real>(u: R, primitive: R::Bits, layer: u32) -> R {
    to_unit(mix3::<R>(u.to_bits(), primitive, R::Bits::splat(layer))[0])
}

/// The share of light that reaches the end of each shadow ray, 0 in lanes that are not `active`: any hit of `S` hides it,
/// unless cut-outs let some of it through, which `B` then finds.
#[inline(always)]
pub fn visible<R: Real, S: Mode, B: Mode>(world: &World, ray: &Ray<R>, active: R::Mask) -> R {
    let occluded = world.occluded::<R, S>(ray, active);
    let clear = R::one().masked(active & !occluded);
    let hidden = active & occluded;
    if world.plan.cutouts && hidden.any() {
        clear + transmittance::<R, B>(world, ray, hidden).masked(hidden)
    } else {
        clear
    }
}

/// The share of light that reaches the end of each shadow ray of `active`, in all of which something is in the way.
#[inline(never)]
pub fn transmittance<R: Real, M: Mode>(world: &World, ray: &Ray<R>, active: R::Mask) -> R {
    let bounded = ray.t_max.is_finite();
    let end = ray.at(R::select(bounded, ray.t_max, R::zero()));
    let mut rest = *ray;
    let mut clear = R::one();
    let mut walking = active;
    for _ in 0..MAX_LAYERS {
        let hit = world.closest::<R, M>(&rest, walking);
        walking = walking & hit.valid();
        if walking.none() {
            return clear;
        }
        let near = rest.at(hit.t);
        clear = R::select(walking, clear * (R::one() - opacity(world, &near, &hit, walking)), clear);
        walking = walking & clear.gt(R::zero());
        let behind = leave(world, &near, &hit, rest.direction, walking);
        rest.origin = Vec3::select(walking, behind, rest.origin);
        // The end stays where it was put, clear of the light: it moves by a rounding of its coordinates, of which the
        // margin of `shadow_ray` is sixteen.
        rest.direction = Vec3::select(bounded, end - rest.origin, rest.direction);
        rest.t_max = R::select(bounded, R::one(), rest.t_max);
    }
    clear.masked(!walking)
}

/// Opacity at hits, 1 in lanes that are not `active`. `near` is where the ray met a sphere, more or less.
#[inline(never)]
fn opacity<R: Real>(world: &World, near: &Vec3<R>, hit: &Hit<R>, active: R::Mask) -> R {
    let [material, _] = world.tags.fetch::<R>(hit.primitive, active);
    let maps = world.textures.maps::<R>(material.to_int(), active);
    let mapped = active & maps[OPACITY_MAP].gt(R::zero());
    let mut opacity = R::select(active, maps[OPACITY], R::one());
    if mapped.any() {
        let spheres = mapped & world.on_sphere::<R>(hit.primitive);
        let mut uv = on_triangle(world, hit, mapped & !spheres).uv;
        if spheres.any() {
            let (_, normal) = sphere_point(&world.sphere_at(hit.primitive, spheres), *near);
            let of_sphere = on_sphere(normal);
            uv = array::from_fn(|k| R::select(spheres, of_sphere[k], uv[k]));
        }
        opacity = opacity * world.textures.look_up_number(maps[OPACITY_MAP], uv, mapped);
    }
    opacity
}

/// Where a ray along `direction` goes on behind its hit.
#[inline(never)]
fn leave<R: Real>(world: &World, near: &Vec3<R>, hit: &Hit<R>, direction: Vec3<R>, active: R::Mask) -> Vec3<R> {
    let spheres = active & world.on_sphere::<R>(hit.primitive);
    let triangle = world.triangles.fetch::<R>(hit.primitive, active & !spheres);
    let mut at = triangle_point(&triangle, hit.u, hit.v);
    let mut ng = triangle.ng;
    if spheres.any() {
        let (on_sphere, normal) = sphere_point(&world.sphere_at(hit.primitive, spheres), *near);
        at = SurfacePoint {
            p: Vec3::select(spheres, on_sphere.p, at.p),
            error: Vec3::select(spheres, on_sphere.error, at.error),
        };
        ng = Vec3::select(spheres, normal, ng);
    }
    offset_origin(at.p, at.error, ng, direction)
}
