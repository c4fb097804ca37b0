//! Ratios of densities, carried along paths of both kinds, that weight the three ways of finding a path of light.
//!
//! Let y₀ … y_k be its vertices from the light, z the camera. A light path finds it with density
//! N p(y₀) ∏ p→(y_i) for N paths a sample, and connects y_k to z; a camera path with p(y_k) ∏ p←(y_i), times p←(y₀) where
//! it runs into the light and times p_nee(y₀) where it samples it. All are per unit of area. Weights need quotients alone,
//! and these follow vertex by vertex from densities known there (Veach 1997, §10.2; in the form of Georgiev et al. 2012,
//! "Implementing Vertex Connection and Merging", with vertices merged nowhere and connected at the camera alone, so that one number
//! a path suffices). They are kept unsquared, so that they neither over- nor underflow.
//!
//! - Light paths carry q = p(camera path up to here, its density at this vertex left out)/p(light path up to here).
//! - Camera paths carry e, the same the other way round.
//!
//! Both are stored without the cosine of the arrival, which divides them: see [`Arrival::new`].
//!
//! What is called takes values, not references: where there are no light paths, nothing need be put into memory for it.
//!
//! At a delta the densities per solid angle have no value, but their quotient has: reversed directions fill η² cosθ dω alike
//! on both sides, so it is cosθ/(cosθ′ η²), with η the relative index crossed. (Some let it be 1. Weights that agree on that still sum to 1.)

use super::super::path::Paths;
use super::super::shade::Shade;
use super::super::surface::Surface;
use super::super::tile::{SampleBuffer, lanes_of};
use super::super::world::World;
use super::LightPaths;
use super::is_primitive;
use crate::bsdf::Sample;
use crate::geometry::Hit;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3};
use crate::light::LightSample;
use std::f32::consts::{FRAC_1_PI, PI};

/// The weight of a technique against two others, given their densities over its own. Infinity is fine.
#[inline(always)]
pub fn weight_against<R: Real>(a: R, b: R) -> R {
    b.mul_add(b, a.mul_add(a, R::one())).recip()
}

/// √(a² + b²) of a, b ≥ 0 whose squares may leave the range.
#[inline(always)]
pub fn hypot<R: Real>(a: R, b: R) -> R {
    let large = a.max_or(b);
    let ratio = (a.min_or(b) / large).masked(large.gt(R::zero()));
    large * ratio.mul_add(ratio, R::one()).sqrt()
}

/// The density of the scattered direction, and of the reversed one: of arriving where it left and leaving where it came from.
/// At a delta, numbers with the right quotient.
#[inline(always)]
pub fn forth_and_back<R: Real>(sample: &Sample<R>, from_z: R, back: R) -> [R; 2] {
    let at_delta = delta_quotient(from_z, sample.wi.z, sample.eta);
    [R::select(sample.delta, R::one(), sample.pdf), R::select(sample.delta, at_delta, back)]
}

/// The density of the reversed direction over that of a scattered one at a delta: `eta` is the index on the side of the scattered
/// direction, whose cosine is `to_z`, over that on the other.
#[inline(always)]
pub fn delta_quotient<R: Real>(from_z: R, to_z: R, eta: R) -> R {
    (from_z / (to_z * eta * eta)).abs()
}

/// q · cosine of the arrival of a path that starts: every direction of the cosine law, of `number` paths with `density` per unit
/// of area.
#[inline(always)]
pub fn light_starts<R: Real>(density: R, number: R) -> R {
    R::splat(PI) / (density * number)
}

/// The same at the next vertex, of a light path with `q` at this one that leaves at the cosine `cos`. `sampled` is the density with
/// which camera paths sample a light there (0 beyond the first vertex, and at deltas).
#[inline(always)]
pub fn light_leaves<R: Real>(q: R, sampled: R, cos: R, [forth, back]: [R; 2]) -> R {
    q * hypot(sampled, back) * cos / forth
}

/// Of a light path connected to the camera, the densities of camera paths over its own. `view` is the density per unit of area
/// with which a pixel sees the vertex.
#[inline(always)]
pub fn light_connects<R: Real>(q: R, sampled: R, back: R, view: R) -> R {
    q * hypot(sampled, back) * view
}

/// e · cosine of the arrival at a camera path's first hit, at distance `t` where pixels see the density `importance` per solid
/// angle.
#[inline(always)]
pub fn camera_starts<R: Real>(number: R, t: R, importance: R) -> R {
    number * (t * t) / importance
}

/// The same at the next vertex, of a camera path with `e` at this one that leaves at the cosine `cos`. At the first hit `back` is 1,
/// but 0 where it left by a delta: light paths are connected there.
#[inline(always)]
pub fn camera_leaves<R: Real>(e: R, cos: R, [forth, back]: [R; 2]) -> R {
    (e * back * cos / forth).masked(back.gt(R::zero()))
}

/// Of a camera path that runs into a light, its density as a light path's over its own; `before` is e times the cosine there, which
/// that of the cosine law divides.
#[inline(always)]
pub fn camera_hits<R: Real>(before: R, density: R) -> R {
    before * density * R::splat(FRAC_1_PI)
}

/// The same of a camera path that samples a light with density `sampled` per solid angle, at the cosine `cos`.
#[inline(always)]
pub fn camera_samples<R: Real>(e: R, back: R, density: R, cos: R, sampled: R) -> R {
    (e * back * density * cos * R::splat(FRAC_1_PI) / sampled).masked(back.gt(R::zero()))
}

/// What camera paths know of light paths, where they have arrived.
pub struct Arrival<R: Real> {
    paths: LightPaths,
    /// e times the cosine of the arrival; 0 at first hits, whose light no light path brings, and where they leave it to light samples.
    before: R,
    /// e.
    here: R,
    /// Lanes at their first hit.
    first: R::Mask,
}

impl<R: Real> Arrival<R> {
    /// `None` where light is found by camera paths alone.
    #[inline(always)]
    pub fn new(world: &World, paths: &Paths<R>, surface: &Surface<R>, out: &SampleBuffer) -> Option<Self> {
        let light_paths = world.light_paths.filter(|_| !out.light_ratio.is_empty())?;
        Some(Self::at(world, light_paths, *paths, *surface, out))
    }

    #[inline(never)]
    fn at(world: &World, light_paths: LightPaths, paths: Paths<R>, surface: Surface<R>, out: &SampleBuffer) -> Self {
        let first = paths.bounce.eq(R::zero());
        // N over the density at the first hit of a ray through one pixel.
        let importance = world.camera.importance(paths.ray.direction);
        // Negative where the path left a Lambert vertex.
        let kept = R::gather(&out.light_ratio, paths.slot);
        let begun = camera_starts(light_paths.number::<R>(), paths.hit.t, importance);
        let cos = surface.ng.dot(paths.ray.direction).abs();
        let here = R::select(first, begun, kept.abs()) / cos;
        let brought = !first & (kept.gt(R::zero()) | R::Mask::splat(light_paths.everywhere));
        Arrival { paths: light_paths, before: kept.abs().masked(brought), here, first }
    }

    /// Of a path that runs into the light: its density as a light path's over its own.
    #[inline(never)]
    pub fn at_light(&self, world: &World, hit: Hit<R>, row: R, emitting: R::Mask) -> R {
        let density = self.paths.start_density(world, hit.primitive, row, emitting);
        camera_hits(self.before, density)
    }

    /// The same of a path that samples a light, in the direction `wi`; `back` is the material's density from there back
    /// to where the path came from.
    #[inline(never)]
    pub fn at_sample(&self, world: &World, surface: Surface<R>, light: LightSample<R>, back: R, lit: R::Mask) -> R {
        let starts = lit & is_primitive::<R>(light.primitive);
        let [_, row] = world.tags.fetch::<R>(light.primitive, starts);
        let density = self.paths.start_density(world, light.primitive, row, starts);
        let cos = surface.ng.dot(light.wi).abs();
        let back = R::select(self.first, R::one(), back);
        let brought = starts & (!surface.material.is_lambert() | R::Mask::splat(self.paths.everywhere));
        camera_samples(self.here, back, density, cos, light.pdf).masked(brought)
    }

    /// Keeps what the next vertex needs, of paths that go on along their rays; `from_z` is the cosine of where they came from,
    /// `back` the density of the reversed direction.
    #[inline(never)]
    pub fn leave(
        &self,
        surface: Surface<R>,
        sample: Sample<R>,
        [from_z, back]: [R; 2],
        paths: Paths<R>,
        out: &mut SampleBuffer,
    ) {
        let [forth, back] = forth_and_back(&sample, from_z, back);
        // The camera is seen from the first hit in any direction, but not by a delta.
        let back = R::select(self.first, R::one().masked(!sample.delta), back);
        let kept = camera_leaves(self.here, surface.ng.dot(paths.ray.direction).abs(), [forth, back]);
        let kept = R::select(surface.material.is_lambert(), -kept, kept);
        let (mut slots, mut values) = ([0; MAX_WIDTH], [0.0; MAX_WIDTH]);
        paths.slot.store(&mut slots);
        kept.store(&mut values);
        for lane in lanes_of(paths.alive.bits()) {
            out.light_ratio[slots[lane] as usize] = values[lane];
        }
    }
}

/// The density of the reversed direction at a camera path's vertex; 0 at deltas.
#[inline(never)]
pub fn reversed_pdf<R: Real, S: Shade>(
    world: &World,
    shade: &S,
    hit: Hit<R>,
    surface: Surface<R>,
    [wo, wi]: [Vec3<R>; 2],
    active: R::Mask,
) -> R {
    shade.eval(world, &hit, &surface, [wi, wo], active).pdf
}
