//! The course's first renderer: ambient light, and lights without extent with their shadows. No light goes on from a
//! surface to the next.
//!
//! L = Le + a·ρ + Σ_l V f(wo, wl) cosθ E_l with f the material's (for Phong its lobe), ρ its reflectance, a the ambient
//! radiance (Phong 1975, "Illumination for Computer Generated Pictures"; normalised as `bsdf::Phong` is).

use super::cutout;
use super::direct::light_ray;
use super::material::AllModels;
use super::path::same_side;
use super::surface::Surface;
use super::tile::Counters;
use super::world::World;
use crate::accel::{Built, Shadow, Stream};
use crate::geometry::Ray;
use crate::lane::{Mask, Real, Vec3};
use crate::sampling::Frame;

/// Radiance towards the viewer of the surfaces in `found`, of the background elsewhere.
#[inline(never)]
pub fn shade<R: Real>(
    world: &World,
    ray: &Ray<R>,
    surface: &mut Surface<R>,
    found: R::Mask,
    counters: &mut Counters,
) -> Vec3<R> {
    let outward = -ray.direction;
    if world.plan.shading_normals {
        surface.face(outward);
    }
    let frame = Frame::from_normal(surface.ns);
    let wo = frame.to_local(outward);
    let ambient = surface.material.albedo().hadamard(Vec3::splat(world.integrator.ambient));
    let mut radiance = surface.emitted(ray.direction, found) + ambient.masked(found);
    let faces = found & same_side(wo.z, surface.ng.dot(outward));
    let lights = world.lights.as_ref();
    for index in 0..lights.map_or(0, |lights| lights.delta_count()) {
        let Some(light) = lights.and_then(|lights| lights.delta_light(index, surface.at.p)) else { continue };
        let wi = frame.to_local(light.wi);
        let lit = faces & light.pdf.gt(R::zero()) & same_side(wi.z, surface.ng.dot(light.wi));
        let f_cos = surface.material.eval::<AllModels>(&world.plan, wo, wi, lit).value;
        let mut contribution = f_cos.hadamard(light.radiance);
        if world.plan.shading_normals {
            contribution = contribution * surface.terminator(light.wi, wi.z, wo.z);
        }
        let carries = lit & contribution.max_component().gt(R::zero());
        if carries.any() {
            counters.shadow(carries);
            let clear = cutout::visible::<R, Built<Shadow>, Built<Stream>>(world, &light_ray(surface, &light), carries);
            radiance = radiance + (contribution * clear).masked(carries);
        }
    }
    radiance + world.background(ray.direction, !found)
}
