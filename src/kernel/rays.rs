//! What kernels ask of the geometry.
//!
//! A kernel names a [`Mode`] for each class of its rays. Where the plan has rays of all classes walk the tree in one way
//! ([`GeometryMode::is_uniform`]), that goes before: looked at once a call, and here alone, so that no kernel is compiled again
//! for it.

use super::world::World;
use crate::accel::{Mode, Packet, Stream};
use crate::geometry::{Hit, Ray};
use crate::lane::{Mask, Real};
use crate::plan::GeometryMode;
use core::array::from_ref;

impl World {
    /// The closest hits. One copy a width and mode, called: kernels stay small, and profiles tell traversal apart.
    #[inline(never)]
    pub fn closest<R: Real, M: Mode>(&self, ray: &Ray<R>, active: R::Mask) -> Hit<R> {
        if M::TREE && self.plan.geometry.is_uniform() {
            let mut hits = [Hit::miss(ray.t_max)];
            self.closest_uniform(from_ref(ray), &[active], &mut hits);
            let [hit] = hits;
            return hit;
        }
        self.accel.trace::<R, M>(ray, active)
    }

    /// Is anything in the way?
    #[inline(never)]
    pub fn occluded<R: Real, M: Mode>(&self, ray: &Ray<R>, active: R::Mask) -> R::Mask {
        if M::TREE && self.plan.geometry.is_uniform() {
            let mut found = [R::Mask::splat(false)];
            self.occluded_uniform(from_ref(ray), &[active], &mut found);
            return found[0];
        }
        self.accel.occluded::<R, M>(ray, active)
    }

    /// [`World::closest`] of several packets.
    #[inline(never)]
    pub fn closest_many<R: Real, M: Mode>(&self, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
        if M::TREE && self.plan.geometry.is_uniform() {
            return self.closest_uniform(rays, active, hits);
        }
        self.accel.trace_many::<R, M>(rays, active, hits)
    }

    /// [`World::occluded`] of several packets.
    #[inline(never)]
    pub fn occluded_many<R: Real, M: Mode>(&self, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
        if M::TREE && self.plan.geometry.is_uniform() {
            return self.occluded_uniform(rays, active, found);
        }
        self.accel.occluded_many::<R, M>(rays, active, found)
    }

    /// [`World::closest_many`] in the one way of the plan. A copy a width.
    #[inline(never)]
    fn closest_uniform<R: Real>(&self, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
        match self.plan.geometry {
            GeometryMode::Packet => self.accel.trace_many::<R, Packet>(rays, active, hits),
            _ => self.accel.trace_many::<R, Stream>(rays, active, hits),
        }
    }

    /// [`World::occluded_many`] in the one way of the plan. A copy a width.
    #[inline(never)]
    fn occluded_uniform<R: Real>(&self, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
        match self.plan.geometry {
            GeometryMode::Packet => self.accel.occluded_many::<R, Packet>(rays, active, found),
            _ => self.accel.occluded_many::<R, Stream>(rays, active, found),
        }
    }
}
