//! The illumination integral at one point of a picture, for estimators on their own: what the directions of a density
//! carry to the viewer. Directions come from a density alone, as in a lecture; the path estimator combines them.

use super::direct::{behind, light_ray};
use super::material::AllModels;
use super::path::{mis_weight, same_side};
use super::pattern;
use super::surface::Surface;
use super::world::World;
use crate::accel::{Built, Shadow, Stream};
use crate::geometry::{Hit, MISS, Ray};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::light::{sphere_pdf, triangle_pdf};
use crate::sampling::{Frame, warp};
use std::f32::consts::{PI, TAU};

/// What directions are drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Technique {
    /// Over the hemisphere of the viewer.
    Uniform,
    /// With density cosθ/π.
    Cosine,
    /// The material's own sampling.
    Bsdf,
    /// Points on lights.
    Light,
    /// One of each of the last two, by the power heuristic.
    Mis,
}

impl Technique {
    /// Numbers a sample needs.
    pub fn dimensions(self) -> usize {
        match self {
            Technique::Uniform | Technique::Cosine => 2,
            Technique::Bsdf | Technique::Light => 3,
            Technique::Mis => 6,
        }
    }
}

/// A point that a pixel shows.
#[derive(Clone, Copy, Debug)]
pub struct PixelPoint {
    ray: Ray<f32>,
    hit: Hit<f32>,
}

impl PixelPoint {
    /// What the centre of a pixel shows.
    ///
    /// # Errors
    /// It shows no surface, or one that density-sampled directions cannot light; the message says which.
    pub fn find(world: &World, x: u32, y: u32) -> Result<Self, &'static str> {
        let ray = world.camera.ray::<f32>(x as f32 + 0.5, y as f32 + 0.5);
        let hit = closest::<f32>(world, &ray, true);
        if hit.primitive.lane(0) == MISS {
            return Err("shows no surface");
        }
        let surface = Surface::at(world, &ray, &hit, true);
        if surface.material.has_delta() {
            return Err("shows a smooth mirror, glass or coat, whose reflection no density but its own finds");
        }
        Ok(Self { ray, hit })
    }

    /// Luminance that one sample of the technique carries to the viewer, over its density: reflected light of everything
    /// with extent that is seen directly from the point, in the scene's units.
    #[inline(never)]
    pub fn sample<R: Real>(&self, world: &World, technique: Technique, u: [R; 6]) -> R {
        let all = R::Mask::splat(true);
        let (ray, hit) = self.in_all_lanes::<R>();
        let mut surface = Surface::at(world, &ray, &hit, all);
        if world.plan.shading_normals {
            surface.face(-ray.direction);
        }
        let frame = Frame::from_normal(surface.ns);
        let view = View { world, wo: frame.to_local(-ray.direction), surface, frame };
        let rgb = match technique {
            Technique::Uniform | Technique::Cosine => uniform_or_cosine(&view, technique, [u[0], u[1]]),
            Technique::Bsdf => bsdf(&view, [u[0], u[1], u[2]], false),
            Technique::Light => light(&view, [u[0], u[1], u[2]], false),
            Technique::Mis => bsdf(&view, [u[0], u[1], u[2]], true) + light(&view, [u[3], u[4], u[5]], true),
        };
        // Rec. 709.
        let weights = Vec3::splat([0.2126, 0.7152, 0.0722]);
        rgb.dot(weights)
    }

    fn in_all_lanes<R: Real>(&self) -> (Ray<R>, Hit<R>) {
        let v = |v: Vec3<f32>| Vec3::splat([v.x, v.y, v.z]);
        let ray = Ray { origin: v(self.ray.origin), direction: v(self.ray.direction), t_max: R::splat(self.ray.t_max) };
        let hit = Hit {
            t: R::splat(self.hit.t),
            primitive: R::Bits::splat(self.hit.primitive.lane(0)),
            u: R::splat(self.hit.u),
            v: R::splat(self.hit.v),
        };
        (ray, hit)
    }
}

/// The point in all lanes, as the viewer sees it.
struct View<'a, R: Real> {
    world: &'a World,
    surface: Surface<R>,
    frame: Frame<R>,
    wo: Vec3<R>,
}

fn closest<R: Real>(world: &World, ray: &Ray<R>, active: R::Mask) -> Hit<R> {
    world.closest::<R, Built<Stream>>(ray, active)
}

/// Reflected to the viewer's side, by both normals.
#[inline(always)]
fn reflects<R: Real>(surface: &Surface<R>, wo: Vec3<R>, wi: Vec3<R>, direction: Vec3<R>) -> R::Mask {
    same_side(wo.z, wi.z) & same_side(wi.z, surface.ng.dot(direction))
}

fn uniform_or_cosine<R: Real>(view: &View<R>, technique: Technique, u: [R; 2]) -> Vec3<R> {
    let &View { world, ref surface, ref frame, wo } = view;
    let cosine = technique == Technique::Cosine;
    let up = if cosine { warp::cosine_hemisphere(u) } else { warp::uniform_hemisphere(u) };
    let density_reciprocal = if cosine { R::splat(PI) / up.z } else { R::splat(TAU) };
    // The hemisphere of the viewer.
    let wi = Vec3::new(up.x, up.y, up.z.copysign(wo.z));
    let direction = frame.to_world(wi);
    let active = reflects(surface, wo, wi, direction);
    let eval = surface.material.eval::<AllModels>(&world.plan, wo, wi, active);
    let (incident, _) = incident(world, surface, direction, active);
    let weight = density_reciprocal * softened(world, surface, direction, wi, wo);
    (eval.value.hadamard(incident) * weight).masked(active)
}

fn bsdf<R: Real>(view: &View<R>, u: [R; 3], combined: bool) -> Vec3<R> {
    let &View { world, ref surface, ref frame, wo } = view;
    let all = R::Mask::splat(true);
    let sample = surface.material.sample::<AllModels>(&world.plan, wo, u[0], [u[1], u[2]], all);
    let direction = frame.to_world(sample.wi);
    let active = sample.valid & reflects(surface, wo, sample.wi, direction);
    let (incident, light_pdf) = incident(world, surface, direction, active);
    let weight = if combined { mis_weight(sample.pdf, light_pdf) } else { R::one() };
    let weight = weight * softened(world, surface, direction, sample.wi, wo);
    (sample.weight.hadamard(incident) * weight).masked(active)
}

fn light<R: Real>(view: &View<R>, u: [R; 3], combined: bool) -> Vec3<R> {
    let &View { world, ref surface, ref frame, wo } = view;
    let all = R::Mask::splat(true);
    let Some(mut light) = world.sample_light(surface.at.p, None, u[0], [u[1], u[2]], all) else { return Vec3::zero() };
    if world.plan.patterned_lights {
        pattern::look_up(world, &mut light, all);
    }
    let wi = frame.to_local(light.wi);
    let active = light.pdf.gt(R::zero()) & !light.is_delta() & reflects(surface, wo, wi, light.wi);
    let active = active & !behind(world, surface, &light);
    if active.none() {
        return Vec3::zero();
    }
    let eval = surface.material.eval::<AllModels>(&world.plan, wo, wi, active);
    let ray = light_ray(surface, &light);
    let occluded = world.occluded::<R, Built<Shadow>>(&ray, active);
    let weight = if combined { mis_weight(light.pdf, eval.pdf) } else { R::one() };
    let weight = weight * softened(world, surface, light.wi, wi, wo);
    (eval.value.hadamard(light.radiance) * (weight / light.pdf)).masked(active & !occluded)
}

/// The shadow terminator, as the path estimator has it.
#[inline(always)]
fn softened<R: Real>(world: &World, surface: &Surface<R>, direction: Vec3<R>, wi: Vec3<R>, wo: Vec3<R>) -> R {
    if world.plan.shading_normals { surface.terminator(direction, wi.z, wo.z) } else { R::one() }
}

/// Radiance of what a direction sees, if it emits, and the density with which light sampling finds it.
fn incident<R: Real>(world: &World, from: &Surface<R>, direction: Vec3<R>, active: R::Mask) -> (Vec3<R>, R) {
    let ray = from.ray_towards(direction);
    let hit = closest::<R>(world, &ray, active);
    let missed = hit.primitive.eq(R::Bits::splat(MISS)) & active;
    let on_surface = active & !missed;
    let (mut radiance, mut pdf) = (Vec3::zero(), R::zero());
    if let Some(lights) = world.lights.as_ref().filter(|_| world.plan.environment) {
        let (sky, sky_pdf) = lights.environment(direction);
        (radiance, pdf) = (sky.masked(missed), sky_pdf.masked(missed));
    }
    if !world.plan.area_lights || on_surface.none() {
        return (radiance, pdf);
    }
    let seen = Surface::at(world, &ray, &hit, on_surface);
    let cos_light = -seen.ng.dot(direction);
    let emitting = on_surface & cos_light.gt(R::zero());
    let mut area_pdf = triangle_pdf(seen.light_row, hit.t, cos_light);
    let on_sphere = emitting & seen.on_sphere;
    if on_sphere.any() {
        let sphere = world.sphere_at(hit.primitive, on_sphere);
        let of_sphere = sphere_pdf(seen.light_row, sphere.center, sphere.radius, ray.origin);
        area_pdf = R::select(on_sphere, of_sphere, area_pdf);
    }
    (Vec3::select(emitting, seen.material.emission, radiance), R::select(emitting, area_pdf, pdf))
}
