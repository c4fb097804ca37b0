//! Leaves: eight spheres side by side.

use super::block::{better, filled};
use super::interval::{Interval, Segments};
use super::lanes::ones;
use super::leaf::{EdgeValues, Found, Leaf};
use super::tree::{Block, OneHit, OneRay, PacketRay};
use crate::geometry::slab::{sphere_hi, sphere_lo};
use crate::geometry::{Hit, MISS, RaySetup, intersect_sphere};
use crate::lane::{Bits, Mask, Real, axes};

/// Eight spheres.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct SphereBlock {
    center: [[f32; 8]; 3],
    /// NaN in empty places, which come last: no hit.
    radius: [f32; 8],
    id: [u32; 8],
}

impl SphereBlock {
    /// `first` is the primitive number of sphere 0.
    pub fn new(ids: &[u32], first: u32, sphere: impl Fn(usize) -> ([f32; 3], f32)) -> Self {
        let mut block = Self { center: [[0.0; 8]; 3], radius: [f32::NAN; 8], id: [MISS; 8] };
        for (place, id) in ids.iter().enumerate() {
            let (center, radius) = sphere(*id as usize);
            for (axis, x) in center.iter().enumerate() {
                block.center[axis][place] = *x;
            }
            block.radius[place] = radius;
            block.id[place] = first + id;
        }
        block
    }
    #[inline(always)]
    fn test_packet<R: Real>(&self, ray: &PacketRay<R>, i: usize, t_best: R, active: R::Mask) -> Option<(R::Mask, R)> {
        let center = axes(|k| R::splat(self.center[k][i]));
        test_sphere(ray.setup, center, R::splat(self.radius[i]), t_best, active)
    }
}

impl Leaf for SphereBlock {
    #[inline(always)]
    fn passed<E: Real>(&self, _: &OneRay<E>, _: &mut EdgeValues) -> u32 {
        filled(&self.id)
    }
    #[inline(always)]
    fn id(&self, place: usize) -> u32 {
        self.id[place]
    }
    #[inline(always)]
    fn meet<E: Real>(found: &Found<'_, Self>, ray: &RaySetup<E>) -> (E::Mask, E, E, E) {
        let center = axes(|k| found.gather(|block, place| block.center[k][place]));
        let radius = found.gather(|block, place| block.radius[place]);
        let (far, all) = (E::splat(f32::INFINITY), E::Mask::splat(true));
        let (hits, t) = test_sphere(ray, center, radius, far, all).unwrap_or((E::Mask::splat(false), far));
        (hits, t, E::zero(), E::zero())
    }
    #[inline(always)]
    fn meet_one(&self, place: usize, ray: &OneRay<f32>, _: &EdgeValues) -> (bool, OneHit) {
        let center = axes(|k| self.center[k][place]);
        let found = test_sphere(&ray.setup, center, self.radius[place], ray.t_max, true);
        let (hit, t) = found.unwrap_or((false, 0.0));
        (hit & (t < ray.t_max), OneHit { t, primitive: self.id[place], u: 0.0, v: 0.0 })
    }
}

impl Block for SphereBlock {
    #[inline(always)]
    fn places<E: Real>(&self, _: Option<&Interval<E>>, _: f32) -> u32 {
        filled(&self.id)
    }
    #[inline(always)]
    fn places_about<E: Real>(&self, _: &Segments<E>) -> u32 {
        filled(&self.id)
    }
    #[inline(always)]
    fn closest_packet<R: Real>(&self, ray: &PacketRay<R>, places: u32, active: R::Mask, hit: &mut Hit<R>, t_max: R) {
        for i in ones(places) {
            if let Some((mask, t)) = self.test_packet(ray, i % 8, hit.t, active) {
                keep_sphere(mask, t, self.id[i % 8], t_max, hit);
            }
        }
    }
    #[inline(always)]
    fn any_packet<R: Real>(&self, ray: &PacketRay<R>, places: u32, t_max: R, active: R::Mask) -> R::Mask {
        let mut open = active;
        for i in ones(places) {
            if let Some((mask, t)) = self.test_packet(ray, i % 8, t_max, open) {
                open = open & !(mask & t.lt(t_max));
            }
        }
        active & !open
    }
}

/// Takes the hits of `mask` that beat the best so far.
#[inline(always)]
pub fn keep_sphere<R: Real>(mask: R::Mask, t: R, primitive: u32, t_max: R, hit: &mut Hit<R>) {
    let primitive = R::Bits::splat(primitive);
    let mask = mask & t.lt(t_max) & better(t, primitive, hit.t, hit.primitive);
    if mask.any() {
        hit.replace(mask, Hit { t, primitive, u: R::zero(), v: R::zero() });
    }
}

/// A sphere per lane: lanes with 0 < t ≤ `t_best` that pass the own box, and t.
#[inline(always)]
pub fn test_sphere<R: Real>(
    setup: &RaySetup<R>,
    center: [R; 3],
    radius: R,
    t_best: R,
    active: R::Mask,
) -> Option<(R::Mask, R)> {
    let t = intersect_sphere(setup.origin, setup.direction, center, radius);
    let mask = active & t.gt(R::zero()) & t.le(t_best);
    if mask.none() {
        return None;
    }
    let (t_near, t_far) = setup.slab(axes(|k| sphere_lo(center[k], radius)), axes(|k| sphere_hi(center[k], radius)));
    Some((mask & t_near.le(t_far), t_near.max_or(t)))
}
