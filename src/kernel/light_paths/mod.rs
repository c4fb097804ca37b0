//! Paths from the lights, for what paths from the camera find badly: light that reaches a diffuse surface through glass
//! or by way of a mirror. Every vertex of theirs is connected to the camera, and what arrives is splatted.
//!
//! So a path of light may be found in three ways: by a camera path that runs into the light, by one that samples the light
//! (next-event estimation), and by a light path whose vertex next to the camera is connected. Each is weighted by the power
//! heuristic over all three, from ratios of densities that both kinds of paths carry along ([`ratio`]).
//!
//! Left alone, they leave to camera paths what comes straight from an emitter to a Lambert surface: a light sample finds it well
//! there, and a light path that comes to such a surface first is over at once. (Paths of light are then of two kinds, told by their
//! vertex next to the emitter, and the weights of each sum to 1.) Asked to be on, they bring all light.
//!
//! In every sample of the film as many light paths are traced as there are pixels; what they splat into a pixel is part of
//! that pixel's sample of the same number. Samples of a pixel are then as independent as before, and everything that is
//! known of a film's sums (their order, their variance, states, merging) holds unchanged.

mod connect;
pub mod ratio;
mod rows;
mod start;
mod vertex;
mod wave;

pub use wave::{LightJob, Splat, trace};

use super::world::World;
use crate::lane::{Bits, Mask, Real};
use crate::scene::LightPaths as Wish;
use std::f32::consts::PI;

/// What light paths are started by.
#[derive(Clone, Copy, Debug)]
pub struct LightPaths {
    /// Light paths in every sample of the film.
    pub count: u32,
    /// Do they bring what comes straight from an emitter to a Lambert surface, too? Light samples find that well.
    pub everywhere: bool,
    /// The density of a start per unit of area is an emitter's row of [`World::tags`] times this (over 4πr² on a sphere).
    per_row: f32,
    /// What a path carries when it starts, about: the unit of roulette.
    starts_with: f32,
}

impl LightPaths {
    /// `None` where the plan leaves them out, or nothing that may start one emits.
    pub fn of(world: &World) -> Option<Self> {
        let lights = world.lights.as_ref().filter(|_| world.plan.light_paths)?;
        let (share, power) = lights.area_lights()?;
        // On glass half as many have 1.08 times the error times seconds, twice as many (with samples divided) 1.13.
        let pixels = u64::from(world.film.width) * u64::from(world.film.height);
        let count = pixels.min(u64::from(u32::MAX)) as u32;
        let everywhere = world.integrator.light_paths == Wish::On;
        Some(LightPaths { count, everywhere, per_row: share.recip(), starts_with: (power / f64::from(count)) as f32 })
    }

    /// The number of paths, as their weights have it.
    #[inline(always)]
    fn number<R: Real>(&self) -> R {
        R::splat(self.count as f32)
    }

    /// The density per unit of area with which a path starts at a point of `primitive`, 0 where none does.
    #[inline(always)]
    pub(super) fn start_density<R: Real>(&self, world: &World, primitive: R::Bits, row: R, emitting: R::Mask) -> R {
        let density = row * R::splat(self.per_row);
        if !world.plan.spheres {
            return density;
        }
        let on_sphere = world.on_sphere::<R>(primitive) & emitting & is_primitive::<R>(primitive);
        if on_sphere.none() {
            return density;
        }
        let radius = world.sphere_at::<R>(primitive, on_sphere).radius;
        R::select(on_sphere, density / (radius * radius * R::splat(4.0 * PI)), density)
    }
}

/// Lanes that name a primitive: these are fewer than 2³¹, and what is none is counted down from 2³².
#[inline(always)]
pub(super) fn is_primitive<R: Real>(primitive: R::Bits) -> R::Mask {
    primitive.shr::<31>().eq(R::Bits::splat(0))
}
