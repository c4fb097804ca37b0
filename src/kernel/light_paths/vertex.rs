//! One vertex of every light path of a packet.

use super::super::material::AllModels;
use super::super::path::same_side;
use super::super::surface::Surface;
use super::super::world::World;
use super::LightPaths;
use super::connect::{connect, sampled_pdf};
use super::ratio::{forth_and_back, light_leaves};
use super::rows::{Link, Walk};
use crate::lane::{Mask, Real, Vec3};
use crate::sampling::Frame;
use crate::sampling::dimensions::*;

/// Where light has arrived.
pub struct Vertex<R: Real> {
    pub surface: Surface<R>,
    pub frame: Frame<R>,
    /// Towards where the light came from, in the frame.
    pub wi: Vec3<R>,
    /// The cosine of `wi` to the geometric normal.
    pub facing: R,
    /// See [`ratio`](super::ratio): q.
    pub ratio: R,
    /// Lanes whose light counts.
    pub active: R::Mask,
}

/// Connects vertices to the camera and scatters; lanes that go on stay alive.
#[inline(never)]
pub fn vertex<R: Real>(world: &World, paths: &LightPaths, walk: &mut Walk<R>) -> Option<Link<R>> {
    let surface = Surface::at(world, &walk.ray, &walk.hit, walk.alive);
    let u = world.vertex_numbers(&mut walk.rng, walk.bounce, true);
    let backward = -walk.ray.direction;
    let frame = Frame::from_normal(surface.ns);
    let wi = frame.to_local(backward);
    let facing = surface.ng.dot(backward);
    let mut active = walk.alive & same_side(wi.z, facing);
    if !paths.everywhere {
        active = active & !(walk.bounce.eq(R::one()) & surface.material.is_lambert());
    }
    let ratio = walk.ratio / facing.abs();
    let vertex = Vertex { surface, frame, wi, facing, ratio, active };
    let link = if active.any() { connect(world, walk, &vertex, &u) } else { None };
    scatter(world, walk, &vertex, &u);
    roulette(world, paths, walk, u[ROULETTE]);
    link
}

/// Samples the material and sends the path on, or ends it. The scene's materials are two-sided or of glass, and all scatter
/// the same both ways, but that glass scales radiance by 1/η² where it is refracted: what light paths carry is not.
#[inline(always)]
fn scatter<R: Real>(world: &World, walk: &mut Walk<R>, vertex: &Vertex<R>, u: &[R; BOUNCE]) {
    let Vertex { surface, frame, wi, .. } = vertex;
    let goes = vertex.active & walk.bounce.lt(R::splat(world.max_bounces));
    let numbers = [u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]];
    let sample = surface.material.sample::<AllModels>(&world.plan, *wi, u[BSDF_LOBE], numbers, goes);
    let direction = frame.to_world(sample.wi);
    let side = surface.ng.dot(direction);
    let goes_on = goes & sample.valid & same_side(sample.wi.z, side);
    walk.beta = walk.beta.hadamard(sample.weight) * (sample.eta * sample.eta);
    walk.alive = goes_on & walk.beta.max_component().gt(R::zero());
    if walk.alive.none() {
        return;
    }
    let rough = walk.alive & !sample.delta;
    let back = if rough.any() {
        surface.material.eval::<AllModels>(&world.plan, sample.wi, *wi, rough).pdf
    } else {
        R::zero()
    };
    let sampled = sampled_pdf(world, walk, surface, direction, rough);
    walk.ratio = light_leaves(vertex.ratio, sampled, side.abs(), forth_and_back(&sample, wi.z, back));
    walk.ray = surface.ray_towards(direction);
}

/// As camera paths play it, by what is left of what the path started with.
#[inline(always)]
fn roulette<R: Real>(world: &World, paths: &LightPaths, walk: &mut Walk<R>, u: R) {
    let carried = walk.beta.max_component() / R::splat(paths.starts_with);
    let Some((plays, survival)) = world.roulette.survival(walk.bounce, carried, walk.alive) else { return };
    let survives = u.lt(survival);
    walk.alive = walk.alive & (survives | !plays);
    walk.beta = walk.beta * R::select(plays & survives, survival.recip(), R::one());
}
