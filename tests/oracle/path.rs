//! The path loop.

use super::bsdf::{self, bsdf_eval, is_delta};
use super::camera::lens_ray;
use super::environment::environment_radiance;
use super::geometry::{Geometry, Surface};
use super::image::{Image, Region};
use super::light::{Emitters, delta_light, emission};
use super::vec3::{Frame, V3};
use crate::stats::{Moments, Rng};
use octolux::scene::{Bsdf, Scene};
use rayon::prelude::*;

/// How a Lambert surface finds the emitters. (Metals and glass always find them by chance: their own sampling is the
/// better one more often than not, and each light path is counted by exactly one strategy.)
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direct {
    /// A point uniform by area on an emitter chosen by power.
    Area,
    /// By chance. For enclosures that emit everywhere, where 1/distance² has no variance in corners.
    Hits,
}

/// Renders `spp` independent samples a pixel of a region, path integrator, `scene.integrator.max_bounces` scattering
/// events. Every number follows from `seed` and the pixel.
pub fn render(scene: &Scene, region: Region, spp: u32, seed: u64) -> Image {
    Renderer::new(scene).render(region, spp, seed)
}

/// Above this part of the scene's area emitting, chance finds light well enough.
const MOSTLY_EMITTING: f64 = 0.1;

pub struct Renderer<'a> {
    scene: &'a Scene,
    geometry: Geometry,
    emitters: Emitters,
    direct: Direct,
}

impl<'a> Renderer<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let geometry = Geometry::new(scene);
        let emitters = Emitters::new(scene, &geometry);
        let direct = if emitters.area_fraction > MOSTLY_EMITTING { Direct::Hits } else { Direct::Area };
        Renderer { scene, geometry, emitters, direct }
    }

    pub fn direct(mut self, direct: Direct) -> Self {
        self.direct = direct;
        self
    }

    /// See [`render`].
    pub fn render(&self, region: Region, spp: u32, seed: u64) -> Image {
        let row = |y: u32| (region.x0..region.x1).map(move |x| self.pixel(x, y, spp, seed)).collect::<Vec<_>>();
        let pixels = (region.y0..region.y1).into_par_iter().flat_map_iter(row).collect();
        Image { region, pixels }
    }

    fn pixel(&self, x: u32, y: u32, spp: u32, seed: u64) -> [Moments; 3] {
        let mut rng = Rng::new(seed.wrapping_mul(0xD134_2543_DE82_EF95) ^ (u64::from(y) << 32 | u64::from(x)));
        let mut moments = [Moments::new(); 3];
        for _ in 0..spp {
            let (o, d) = lens_ray(self.scene, f64::from(x) + rng.f64(), f64::from(y) + rng.f64(), &mut rng);
            let radiance = self.radiance(V3(o), V3(d), &mut rng);
            assert!(radiance.0.iter().all(|c| c.is_finite()), "the oracle itself: {radiance:?} in pixel ({x}, {y})");
            moments.iter_mut().zip(radiance.0).for_each(|(m, c)| m.push(c));
        }
        moments
    }

    /// One sample of the radiance arriving at `o` from `d`.
    pub fn radiance(&self, mut o: V3, mut d: V3, rng: &mut Rng) -> V3 {
        let (mut sum, mut beta) = (V3::default(), V3([1.0; 3]));
        let mut t_min = 0.0;
        // Has the last vertex already counted what emitters send it?
        let mut counted = false;
        for bounce in 0.. {
            let Some(hit) = self.geometry.closest(o, d, t_min) else {
                return sum + beta.times(V3(environment_radiance(self.scene, d.0)));
            };
            let (mut surface, wo) = (self.geometry.surface(o, d, hit), -d);
            surface.ns = facing(&surface, wo);
            if !counted && wo.dot(surface.ng) > 0.0 {
                sum = sum + beta.times(emission(self.scene, surface.material));
            }
            if bounce == self.scene.integrator.max_bounces {
                break;
            }
            let bsdf = &self.scene.materials[surface.material].bsdf;
            counted = self.direct == Direct::Area && matches!(bsdf, Bsdf::Diffuse { .. });
            if counted {
                sum = sum + beta.times(self.sampled_light(&surface, bsdf, wo, rng));
            }
            if !sides_agree(&surface, wo) {
                break;
            }
            sum = sum + beta.times(self.delta_lights(&surface, bsdf, wo));
            let frame = Frame::about(surface.ns);
            let Some(sampled) = bsdf::sample(bsdf, frame.to_local(wo), rng) else { break };
            let wi = frame.to_world(sampled.wi);
            if !sides_agree(&surface, wi) {
                break;
            }
            beta = beta.times(sampled.weight);
            if !sampled.delta {
                beta = beta * terminator(&surface, wo, wi);
            }
            (o, d, t_min) = (surface.p, wi, self.geometry.t_min);
        }
        sum
    }

    /// Light from every light without extent, whatever the material: nothing else finds it.
    fn delta_lights(&self, surface: &Surface, bsdf: &Bsdf, wo: V3) -> V3 {
        let (frame, t_min) = (Frame::about(surface.ns), self.geometry.t_min);
        let mut sum = V3::default();
        for light in &self.scene.delta_lights {
            let (wi, distance, arriving) = delta_light(light, surface.p);
            if !sides_agree(surface, wi) {
                continue;
            }
            let f_cos = V3(bsdf_eval(bsdf, frame.to_local(wo).0, frame.to_local(wi).0)).times(arriving);
            let f_cos = f_cos * terminator(surface, wo, wi);
            if f_cos.max_component() > 0.0
                && !self.geometry.occluded(surface.p, wi, t_min, distance.unwrap_or(f64::INFINITY))
            {
                sum = sum + f_cos;
            }
        }
        sum
    }

    /// Light from one point on one emitter.
    fn sampled_light(&self, surface: &Surface, bsdf: &Bsdf, wo: V3, rng: &mut Rng) -> V3 {
        let Some(light) = self.emitters.sample(self.scene, &self.geometry, rng) else { return V3::default() };
        let to = light.p - surface.p;
        let distance = to.length();
        let wi = to * (1.0 / distance);
        let cos_light = -wi.dot(light.ng);
        let t_min = self.geometry.t_min;
        if cos_light <= 0.0 || distance <= 2.0 * t_min || !sides_agree(surface, wo) || !sides_agree(surface, wi) {
            return V3::default();
        }
        let frame = Frame::about(surface.ns);
        let f_cos = V3(bsdf_eval(bsdf, frame.to_local(wo).0, frame.to_local(wi).0));
        if f_cos.max_component() == 0.0 || self.geometry.occluded(surface.p, wi, t_min, distance - t_min) {
            return V3::default();
        }
        f_cos.times(light.emission) * terminator(surface, wo, wi) * (cos_light / (distance * distance * light.pdf_area))
    }
}

/// Is `w` on the same side of both normals?
fn sides_agree(surface: &Surface, w: V3) -> bool {
    w.dot(surface.ng) * w.dot(surface.ns) > 0.0
}

/// The shading normal on the side of the geometric one, and at 89.1° from `wo` (or as far as the geometric one, where that
/// is more) where it would face away further.
fn facing(surface: &Surface, wo: V3) -> V3 {
    let ns = surface.ns * surface.ns.dot(surface.ng).signum();
    let w = wo * wo.dot(surface.ng).signum();
    let least = w.dot(surface.ng).min(1.0 / 64.0);
    if ns.dot(w) >= least { ns } else { (ns + w * (least - ns.dot(w))).unit() }
}

/// How much of a reflected direction counts where it grazes the geometry: Chiang, Li, Burley 2019, with cosines.
pub fn terminator(surface: &Surface, wo: V3, wi: V3) -> f64 {
    let [g, s, tilt] = [wi.dot(surface.ng), wi.dot(surface.ns), surface.ng.dot(surface.ns)].map(f64::abs);
    if wo.dot(surface.ng) * wi.dot(surface.ng) < 0.0 || g >= s * tilt {
        return 1.0;
    }
    let ratio = g / (s * tilt);
    -ratio.powi(3) + ratio.powi(2) + ratio
}
