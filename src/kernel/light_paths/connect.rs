//! A vertex of a light path as the camera sees it.

use super::super::material::AllModels;
use super::super::path::same_side;
use super::super::surface::Surface;
use super::super::world::World;
use super::ratio::{light_connects, weight_against};
use super::rows::{Link, Walk};
use super::vertex::Vertex;
use crate::geometry::point_shadow_ray;
use crate::lane::{Mask, Real, Vec3};
use crate::light::{sphere_pdf, triangle_pdf};
use crate::sampling::dimensions::*;

/// The connection of each vertex with the camera; `None` where no lane has any.
#[inline(never)]
pub fn connect<R: Real>(world: &World, walk: &Walk<R>, vertex: &Vertex<R>, u: &[R; BOUNCE]) -> Option<Link<R>> {
    let surface = &vertex.surface;
    let eye = world.camera.eye(world.plan.lens, [u[LIGHT_POSITION], u[LIGHT_POSITION + 1]]);
    let way = eye - surface.at.p;
    let squared = way.length_squared();
    let outward = way * squared.sqrt().recip();
    let seen = world.camera.project(eye, -outward);
    let wo = vertex.frame.to_local(outward);
    let side = surface.ng.dot(outward);
    let smooth = surface.material.is_delta::<AllModels>();
    let reaches = vertex.active & seen.inside & !smooth & same_side(wo.z, side) & squared.gt(R::zero());
    if reaches.none() {
        return None;
    }
    // The camera's view of the vertex: radiance leaves towards it.
    let eval = surface.material.eval::<AllModels>(&world.plan, wo, vertex.wi, reaches);
    let importance = seen.importance * side.abs() / squared;
    let sampled = sampled_pdf(world, walk, surface, outward, reaches);
    let others = light_connects(vertex.ratio, sampled, eval.pdf, importance);
    let weight = weight_against(others, R::zero()) * importance / vertex.facing.abs();
    let contribution = walk.beta.hadamard(eval.value) * weight;
    let carries = reaches & contribution.max_component().gt(R::zero());
    carries.any().then(|| Link {
        ray: point_shadow_ray(surface.leave(outward), eye),
        contribution,
        pixel: seen.pixel,
        carries,
    })
}

/// The density with which a camera path that comes from `outward` samples, at the first vertex after a light, the point where the
/// light path started. 0 in lanes at other vertices.
#[inline(never)]
pub fn sampled_pdf<R: Real>(
    world: &World,
    walk: &Walk<R>,
    surface: &Surface<R>,
    outward: Vec3<R>,
    active: R::Mask,
) -> R {
    let first = active & walk.bounce.eq(R::one());
    if first.none() {
        return R::zero();
    }
    let [_, row] = world.tags.fetch::<R>(walk.emitter, first);
    let mut pdf = triangle_pdf(row, walk.hit.t, walk.emitter_cos);
    let spheres = if world.plan.spheres { world.on_sphere::<R>(walk.emitter) & first } else { R::Mask::splat(false) };
    if spheres.any() {
        let sphere = world.sphere_at(walk.emitter, spheres);
        pdf = R::select(spheres, sphere_pdf(row, sphere.center, sphere.radius, surface.at.p), pdf);
    }
    if let Some(lights) = world.lights.as_ref().filter(|lights| lights.has_grid()) {
        let away = surface.ng.dot(outward).lt(R::zero());
        let table = lights.table_at(surface.at.p, Vec3::select(away, -surface.ng, surface.ng));
        pdf = pdf * lights.choice_ratio(walk.emitter, table, first);
    }
    pdf.masked(first)
}
