//! Next-event estimation: light that comes straight from a light sample.

use super::light_paths::ratio::{Arrival, reversed_pdf, weight_against};
use super::path::{Doing, PathVertex, Paths, mis_weight, same_side};
use super::pattern;
use super::probe::{Lanes, Probe, Stage};
use super::queue::Queue;
use super::reuse;
use super::rows::{SHADOW, pack_shadows};
use super::shade::Shade;
use super::surface::Surface;
use super::tile::SampleBuffer;
use super::world::World;
use crate::geometry::{Ray, SurfacePoint, shadow_ray};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::light::LightSample;
use crate::sampling::dimensions::*;

/// Lanes at the last vertex of their path, where a ray by the material could find nothing but what light samples find as well.
#[inline(always)]
pub(super) fn by_lights_alone<R: Real>(
    world: &World,
    paths: &Paths<R>,
    surface: &Surface<R>,
    scatters: R::Mask,
) -> R::Mask {
    let Some(reach) = &world.reach else { return R::Mask::splat(false) };
    let last = scatters & (paths.bounce + R::one()).ge(R::splat(world.max_bounces)) & surface.material.is_lambert();
    if last.any() { last & reach.beyond(surface.at.p) } else { last }
}

/// Next-event estimation: a point on a light or a direction to the environment, and its contribution if it is seen, which a
/// shadow ray is to tell. Where no ray by the material goes out, nothing else is to find it.
#[inline(always)]
pub(super) fn sample_direct<R: Real, S: Shade, P: Probe>(
    at: &PathVertex<R, S>,
    paths: &Paths<R>,
    doing: Doing<R>,
    arrival: Option<&Arrival<R>>,
    shadows: &mut Queue<R, SHADOW>,
    out: &mut SampleBuffer,
    probe: &mut P,
) {
    let &PathVertex { world, shade, surface, frame, wo, u } = at;
    let lit = doing.lit & !shade.is_delta(world, &paths.hit, surface);
    if lit.none() {
        return;
    }
    let u_position = [u[LIGHT_POSITION], u[LIGHT_POSITION + 1]];
    let facing = if world.plan.sloped_lamps { lit_from(surface, wo) } else { Vec3::zero() };
    let mut light = shade.sample_light(world, [surface.at.p, facing], paths.table, u[LIGHT_CHOICE], u_position, lit);
    if world.plan.patterned_lights {
        pattern::look_up(world, &mut light, lit);
    }
    let wi = frame.to_local(light.wi);
    let pdf = probe.tap(Stage::LightPdf, paths.lanes(lit), light.pdf);
    let lit = lit & pdf.gt(R::zero()) & same_side(wi.z, surface.ng.dot(light.wi));
    let lit = if world.plan.spheres { lit & !behind(world, surface, &light) } else { lit };
    let eval = shade.eval(world, &paths.hit, surface, [wo, wi], lit);
    let mut weight = mis_weight(pdf, eval.pdf.masked(doing.scatter)) / pdf;
    if let Some(arrival) = arrival.filter(|_| lit.any()) {
        let back = reversed_pdf(world, shade, paths.hit, *surface, [wo, wi], lit);
        weight = weight_against(eval.pdf / pdf, arrival.at_sample(world, *surface, light, back, lit)) / pdf;
    }
    if world.plan.delta_lights || S::OWN_LIGHT {
        // Nothing else finds a light without extent.
        weight = R::select(light.is_delta(), pdf.recip(), weight);
    }
    if world.plan.shading_normals {
        weight = weight * surface.terminator(light.wi, wi.z, wo.z);
    }
    let mut contribution = paths.beta.hadamard(eval.value).hadamard(light.radiance) * weight;
    let mut slot = paths.slot;
    let shared = doing.shared & lit & (same_side(wi.z, wo.z) | surface.material.is_dielectric());
    if shared.any() {
        let (of_light, of_slot) =
            reuse::keep_light(*surface, &light, eval.value * (weight * pdf), paths.slot, shared, out);
        contribution = Vec3::select(shared, of_light, contribution);
        slot = R::Bits::select(shared, of_slot, slot);
    }
    let lanes = Lanes { slot, ..paths.lanes(lit) };
    let contribution = probe.tap_rgb(Stage::LightContribution, lanes, contribution);
    let carries = lit & contribution.max_component().gt(R::zero());
    if carries.any() {
        shadows.push(carries, &pack_shadows(&light_ray(surface, &light), contribution, slot, paths.bounce));
    }
}

/// The shading normal on the side of the viewer where no other is lit from; 0 elsewhere.
#[inline(always)]
fn lit_from<R: Real>(surface: &Surface<R>, wo: Vec3<R>) -> Vec3<R> {
    let facing = Vec3::select(wo.z.gt(R::zero()), surface.ns, -surface.ns);
    facing.masked(surface.material.is_lambert())
}

/// Lanes that lie behind the point of a sphere that was sampled. Spheres shine outwards; but of a point on the inside of one rounding
/// may say that it is outside. Where its rays leave is clear of that.
#[inline(always)]
pub(crate) fn behind<R: Real>(world: &World, surface: &Surface<R>, light: &LightSample<R>) -> R::Mask {
    let way = light.target - surface.leave(light.wi);
    world.on_sphere::<R>(light.primitive) & !way.dot(light.ng).lt(R::zero())
}

/// The shadow ray of a light sample: to a point moved off its light, or to infinity.
#[inline(always)]
pub(crate) fn light_ray<R: Real>(surface: &Surface<R>, light: &LightSample<R>) -> Ray<R> {
    let origin = surface.leave(light.wi);
    let to_point = shadow_ray(origin, &SurfacePoint { p: light.target, error: light.target_error }, light.ng);
    Ray {
        origin,
        direction: Vec3::select(light.is_environment, light.wi, to_point.direction),
        t_max: R::select(light.is_environment, R::splat(f32::INFINITY), to_point.t_max),
    }
}
