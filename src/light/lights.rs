//! All lights of a scene: the choice between them, and their common density.

use super::area::AreaLights;
use super::sample::LightSample;
use super::{Emitter, EnvironmentMap, LightError};
use crate::lane::{Mask, Real, Vec3};
use crate::sampling::rescale;
use crate::scene::Environment;

/// How often the environment is sampled where there are area lights too. Fixed, because its power reaching a point
/// depends on what hides it, which nothing known at load tells; with multiple importance sampling the worst case is a
/// factor of 2 in the light samples' variance.
pub const ENVIRONMENT_PROBABILITY: f32 = 0.5;

/// Everything in a scene that emits and can be sampled.
pub struct Lights {
    area: Option<AreaLights>,
    environment: Option<EnvironmentMap>,
    /// 0, 1, or [`ENVIRONMENT_PROBABILITY`].
    environment_probability: f32,
}

impl Lights {
    /// Emitters without area or radiance are dropped, as is a black environment.
    pub fn build(emitters: Vec<Emitter>, environment: Option<&Environment>) -> Result<Self, LightError> {
        let environment = environment.and_then(EnvironmentMap::build);
        let has_density = environment.is_some();
        let any_area = emitters.iter().any(|e| e.power() > 0.0);
        let environment_probability = match (has_density, any_area) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => ENVIRONMENT_PROBABILITY,
        };
        let area = AreaLights::build(emitters, 1.0 - f64::from(environment_probability))?;
        Ok(Self { area, environment, environment_probability })
    }

    /// Does nothing emit?
    pub fn is_empty(&self) -> bool {
        self.area.is_none() && self.environment.is_none()
    }

    /// Emitting primitives that can be sampled.
    pub fn area_count(&self) -> usize {
        self.area.as_ref().map_or(0, AreaLights::len)
    }

    pub fn environment_map(&self) -> Option<&EnvironmentMap> {
        self.environment.as_ref()
    }

    /// Bytes held, the environment's image included.
    pub fn memory(&self) -> usize {
        self.area.as_ref().map_or(0, AreaLights::memory) + self.environment.as_ref().map_or(0, EnvironmentMap::memory)
    }

    /// Samples a direction from `p` (finite where `active`) to some light. `u_choice` and `u` are uniform in [0, 1).
    /// What lies between is not looked at.
    #[inline(always)]
    pub fn sample<R: Real>(&self, p: Vec3<R>, u_choice: R, u: [R; 2], active: R::Mask) -> LightSample<R> {
        let (area, environment) = match (&self.area, &self.environment) {
            (None, None) => return LightSample::none(),
            (Some(area), None) => return sample_area(area, p, u_choice, u).only(active),
            (None, Some(map)) => return sample_environment(map, u_choice, u, 1.0).only(active),
            (Some(area), Some(map)) => (area, map),
        };
        let split = R::splat(self.environment_probability);
        let to_environment = u_choice.lt(split);
        // One number for both choices: within either branch it is uniform again once stretched back to [0, 1).
        let from = R::select(to_environment, R::zero(), split);
        let stretched = rescale(u_choice, from, R::select(to_environment, split, R::one()));
        let area_lanes = active & !to_environment;
        let environment_lanes = active & to_environment;
        let mut sample = LightSample::none();
        if area_lanes.any() {
            sample = sample_area(area, p, stretched, u).only(area_lanes);
        }
        if environment_lanes.any() {
            let other = sample_environment(environment, stretched, u, self.environment_probability);
            sample = LightSample::select(environment_lanes, other.only(environment_lanes), sample);
        }
        sample
    }

    /// What a primitive keeps beside its shading data so that [`triangle_pdf`] and [`sphere_pdf`] need no look-up:
    /// choice probability / area for a triangle, choice probability for a sphere, 0 for one that is never sampled.
    /// Takes O(log lights): call it when preparing a scene.
    pub fn emitter_pdf_row(&self, primitive: u32) -> f32 {
        self.area.as_ref().map_or(0.0, |area| area.pdf_row(primitive))
    }

    /// The density with which [`Lights::sample`] from `origin` would have produced the point of `primitive` at
    /// distance `t`, where `cos` is the cosine between the light's front normal and the direction back (not read for
    /// spheres). The same value as [`triangle_pdf`] or [`sphere_pdf`] on a stored row, which the kernel should prefer:
    /// this looks the primitive up.
    pub fn pdf_area<R: Real>(&self, primitive: R::Bits, origin: Vec3<R>, t: R, cos: R) -> R {
        self.area.as_ref().map_or(R::zero(), |area| area.pdf(primitive, origin, t, cos))
    }

    /// Radiance arriving along the unit direction `d` from the environment, and the density with which
    /// [`Lights::sample`] yields `d`, the choice of light included. Zeros without an environment.
    #[inline(always)]
    pub fn environment<R: Real>(&self, d: Vec3<R>) -> (Vec3<R>, R) {
        self.environment.as_ref().map_or((Vec3::zero(), R::zero()), |map| {
            let (radiance, pdf) = map.radiance_and_pdf(d);
            (radiance, pdf * R::splat(self.environment_probability))
        })
    }

    /// Radiance arriving along the unit direction `d` from the environment.
    #[inline(always)]
    pub fn environment_radiance<R: Real>(&self, d: Vec3<R>) -> Vec3<R> {
        self.environment.as_ref().map_or(Vec3::zero(), |map| map.radiance(d))
    }
}

#[inline(always)]
fn sample_area<R: Real>(area: &AreaLights, p: Vec3<R>, u_choice: R, u: [R; 2]) -> LightSample<R> {
    let (point, radiance, primitive) = area.sample(p, u_choice, u);
    LightSample {
        wi: point.wi,
        target: point.target,
        target_error: point.target_error,
        ng: point.ng,
        distance: point.distance,
        radiance,
        pdf: point.pdf,
        is_environment: R::Mask::splat(false),
        primitive,
    }
}

#[inline(always)]
fn sample_environment<R: Real>(map: &EnvironmentMap, u_choice: R, u: [R; 2], share: f32) -> LightSample<R> {
    let (wi, radiance, pdf) = map.sample(u_choice, u);
    LightSample {
        wi,
        distance: R::splat(f32::INFINITY),
        radiance,
        pdf: pdf * R::splat(share),
        is_environment: R::Mask::splat(true),
        ..LightSample::none()
    }
}
