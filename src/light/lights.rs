//! All lights of a scene: the choice between them, and their common density.

use super::area::{AreaLights, AreaSample};
use super::delta::{DeltaLights, Extent};
use super::sample::LightSample;
use super::{Emitter, EnvironmentMap, LightError, Reach, Receivers};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::sampling::rescale;
use crate::scene::{DeltaLight, Environment};

/// How often the environment is sampled where there are other lights too. Fixed, because its power reaching a point
/// depends on what hides it, which nothing known at load tells; with multiple importance sampling the worst case is a
/// factor of 2 in the light samples' variance.
pub const ENVIRONMENT_PROBABILITY: f32 = 0.5;

/// The least part of the draws that lights without extent get beside area lights, and these beside them. In between, both
/// get theirs by power.
const LEAST_SHARE: f64 = 0.25;

/// Everything in a scene that emits and can be sampled.
pub struct Lights {
    area: Option<AreaLights>,
    environment: Option<EnvironmentMap>,
    delta: Option<DeltaLights>,
    /// A multiple of 2⁻²⁴, as the number it is compared with.
    delta_probability: f32,
    /// 0, 1, or [`ENVIRONMENT_PROBABILITY`].
    environment_probability: f32,
    /// The probability that is left to area lights, and their power.
    area_share: (f32, f64),
}

impl Lights {
    /// Emitters without area or radiance are dropped, as is a black environment.
    pub fn build(emitters: Vec<Emitter>, environment: Option<&Environment>) -> Result<Self, LightError> {
        let unit = Extent { scale: 1.0, radius: 1.0 };
        Self::with_delta(emitters, environment.and_then(EnvironmentMap::build), &[], unit)
    }

    /// The same, with lights without extent.
    pub fn with_delta(
        emitters: Vec<Emitter>,
        environment: Option<EnvironmentMap>,
        delta: &[DeltaLight],
        extent: Extent,
    ) -> Result<Self, LightError> {
        let delta = DeltaLights::build(delta, extent)?;
        let area_power: f64 = emitters.iter().map(Emitter::power).filter(|&power| power > 0.0).sum();
        let delta_power = delta.as_ref().map_or(0.0, DeltaLights::power);
        let environment_probability = match (environment.is_some(), area_power > 0.0 || delta.is_some()) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => ENVIRONMENT_PROBABILITY,
        };
        let others = 1.0 - f64::from(environment_probability);
        let delta_share = match (delta.is_some(), area_power > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => (delta_power / (delta_power + area_power)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE),
        };
        let grid = f64::from(1u32 << 24);
        let delta_probability = (others * delta_share * grid).round() / grid;
        let share = others - delta_probability;
        let area = AreaLights::build(emitters, share)?;
        let delta_probability = delta_probability as f32;
        let area_share = (share as f32, area_power);
        Ok(Self { area, environment, delta, delta_probability, environment_probability, area_share })
    }

    /// Where area lights are many, lets [`Lights::sample_from`] choose them by where the receiver is. Of
    /// [`Lights::emitter_pdf_row`] and [`Lights::sample`] nothing changes.
    pub fn add_grid(&mut self, receivers: &Receivers) {
        if let Some(area) = &mut self.area {
            area.add_grid(receivers);
        }
    }

    /// Lets [`Lights::sample_from`] prefer, on lamps of two triangles, what sends more to the receiver. Densities stay those
    /// of even samples: see [`LightSample::radiance`].
    pub fn add_slopes(&mut self) {
        if let Some(area) = &mut self.area {
            area.add_slopes();
        }
    }

    /// Where light samples find all emitters as well as a Lambert surface ever could; `None` where that is not known, or
    /// something else than emitters shines with an extent.
    pub fn reach(&self) -> Option<Reach> {
        let (area, (share, _)) = (self.area.as_ref(), self.area_share);
        if self.environment.is_some() { None } else { area.and_then(|area| area.reach(f64::from(share))) }
    }

    /// Are lights chosen by place?
    pub fn has_grid(&self) -> bool {
        self.area.as_ref().is_some_and(AreaLights::has_grid)
    }

    /// The table of the grid for receivers at `p` whose geometric normal, towards the viewer, is `n`. 0 without a grid.
    #[inline(always)]
    pub fn table_at<R: Real>(&self, p: Vec3<R>, n: Vec3<R>) -> R::Bits {
        self.area.as_ref().map_or(R::Bits::splat(0), |area| area.table_at(p, n))
    }

    /// How many times likelier than [`Lights::emitter_pdf_row`] says a `table` of the grid makes `primitive`, an emitter
    /// where `emitting`. 1 without a grid.
    #[inline(always)]
    pub fn choice_ratio<R: Real>(&self, primitive: R::Bits, table: R::Bits, emitting: R::Mask) -> R {
        self.area.as_ref().map_or(R::one(), |area| area.choice_ratio(primitive, table, emitting))
    }

    /// Does nothing emit?
    pub fn is_empty(&self) -> bool {
        self.area.is_none() && self.environment.is_none() && self.delta.is_none()
    }

    /// Emitting primitives that can be sampled.
    pub fn area_count(&self) -> usize {
        self.area.as_ref().map_or(0, AreaLights::len)
    }

    /// Lights without extent that shine.
    pub fn delta_count(&self) -> usize {
        self.delta.as_ref().map_or(0, DeltaLights::len)
    }

    /// Light `index` < [`Lights::delta_count`] of those without extent, as seen from `p`, with pdf 1; pdf 0 where `p` is
    /// outside its cone.
    pub fn delta_light<R: Real>(&self, index: usize, p: Vec3<R>) -> Option<LightSample<R>> {
        Some(self.delta.as_ref()?.one(index, p))
    }

    /// What comes from outside.
    pub fn environment_map(&self) -> Option<&EnvironmentMap> {
        self.environment.as_ref()
    }

    /// Bytes held, the environment's image included.
    pub fn memory(&self) -> usize {
        self.area.as_ref().map_or(0, AreaLights::memory)
            + self.environment.as_ref().map_or(0, EnvironmentMap::memory)
            + self.delta.as_ref().map_or(0, DeltaLights::memory)
    }

    /// Samples a direction from `p` (finite where `active`) to some light. `u_choice` and `u` are uniform in [0, 1): `u`
    /// chooses the kind of light, the area light and the point or direction; `u_choice` chooses among lights without
    /// extent, and goes on where the digits of `u` end. What lies between is not looked at.
    #[inline(always)]
    pub fn sample<R: Real>(&self, p: Vec3<R>, u_choice: R, u: [R; 2], active: R::Mask) -> LightSample<R> {
        self.sample_from(p, None, None, u_choice, u, active)
    }

    /// The same, area lights from a table of [`Lights::table_at`], and along slopes, if there are any, for a receiver that is
    /// lit from the side of the unit normal `facing`, and counts its cosine; 0 for one that counts none.
    #[inline(always)]
    pub fn sample_from<R: Real>(
        &self,
        p: Vec3<R>,
        facing: Option<Vec3<R>>,
        table: Option<R::Bits>,
        u_choice: R,
        u: [R; 2],
        active: R::Mask,
    ) -> LightSample<R> {
        match (&self.area, &self.environment, &self.delta) {
            (None, None, None) => LightSample::none(),
            (Some(area), None, None) => sample_area(area, p, facing, table, u, u_choice).only(active),
            (None, Some(map), None) => sample_environment(map, u, 1.0).only(active),
            (None, None, Some(delta)) => delta.sample(p, u_choice, u, 1.0).only(active),
            _ => self.sample_one_kind(p, facing, table, u_choice, u, active),
        }
    }

    /// The first part of `u[0]` leads to lights without extent, the second to the environment, the rest to areas.
    #[inline(always)]
    fn sample_one_kind<R: Real>(
        &self,
        p: Vec3<R>,
        facing: Option<Vec3<R>>,
        table: Option<R::Bits>,
        u_choice: R,
        u: [R; 2],
        active: R::Mask,
    ) -> LightSample<R> {
        let delta_end = R::splat(self.delta_probability);
        let environment_end = R::splat(self.delta_probability + self.environment_probability);
        let to_delta = u[0].lt(delta_end);
        let to_environment = u[0].lt(environment_end) & !to_delta;
        // Within any branch the number is uniform again once stretched back to [0, 1).
        let from = R::select(to_delta, R::zero(), R::select(to_environment, delta_end, environment_end));
        let to = R::select(to_delta, delta_end, R::select(to_environment, environment_end, R::one()));
        let u = [rescale(u[0], from, to), u[1]];
        let mut sample = LightSample::none();
        let area_lanes = active & !to_delta & !to_environment;
        if let Some(area) = self.area.as_ref().filter(|_| area_lanes.any()) {
            sample = sample_area(area, p, facing, table, u, u_choice).only(area_lanes);
        }
        let environment_lanes = active & to_environment;
        if let Some(map) = self.environment.as_ref().filter(|_| environment_lanes.any()) {
            let other = sample_environment(map, u, self.environment_probability);
            sample = LightSample::select(environment_lanes, other.only(environment_lanes), sample);
        }
        let delta_lanes = active & to_delta;
        if let Some(delta) = self.delta.as_ref().filter(|_| delta_lanes.any()) {
            let other = delta.sample(p, u_choice, u, self.delta_probability);
            sample = LightSample::select(delta_lanes, other.only(delta_lanes), sample);
        }
        sample
    }

    /// An emitting primitive chosen by power among those with an area, for paths that start there, with its radiance, and a
    /// [place](LightSample::place) uniform on it; `fine` goes on where the digits of `u` end. Of no meaning where there is none.
    #[inline(always)]
    pub fn choose_emitter<R: Real>(&self, u: [R; 2], fine: R) -> (R::Bits, Vec3<R>, [R; 2]) {
        let area = self.area.as_ref();
        area.map_or((R::Bits::splat(0), Vec3::zero(), u), |area| area.choose(u, fine))
    }

    /// How often light samples go to area lights, which [`Lights::emitter_pdf_row`] includes, and the power of these, in the
    /// units of [`Emitter::power`]; `None` without any.
    pub fn area_lights(&self) -> Option<(f32, f64)> {
        self.area.as_ref().map(|_| self.area_share)
    }

    /// What a primitive keeps beside its shading data so that [`triangle_pdf`](super::triangle_pdf) and [`sphere_pdf`](super::sphere_pdf) need no look-up:
    /// choice probability / area for a triangle, choice probability for a sphere, 0 for one that is never sampled.
    /// Takes O(log lights): call it when preparing a scene.
    pub fn emitter_pdf_row(&self, primitive: u32) -> f32 {
        self.area.as_ref().map_or(0.0, |area| area.pdf_row(primitive))
    }

    /// The density with which [`Lights::sample`] from `origin` would have produced the point of `primitive` at
    /// distance `t`, where `cos` is the cosine between the light's front normal and the direction back (not read for
    /// spheres). The same value as [`triangle_pdf`](super::triangle_pdf) or [`sphere_pdf`](super::sphere_pdf) on a stored row, which the kernel should prefer:
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
fn sample_area<R: Real>(
    area: &AreaLights,
    p: Vec3<R>,
    facing: Option<Vec3<R>>,
    table: Option<R::Bits>,
    u: [R; 2],
    fine: R,
) -> LightSample<R> {
    let AreaSample { point, radiance, primitive, place } = area.sample(p, facing, table, u, fine);
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
        place,
    }
}

#[inline(always)]
fn sample_environment<R: Real>(map: &EnvironmentMap, u: [R; 2], share: f32) -> LightSample<R> {
    let (wi, radiance, pdf) = map.sample(u);
    LightSample {
        wi,
        distance: R::splat(f32::INFINITY),
        radiance,
        pdf: pdf * R::splat(share),
        is_environment: R::Mask::splat(true),
        ..LightSample::none()
    }
}
