//! All lanes against every primitive in turn: no tree, no stack.

use super::sphere_block::{keep_sphere, test_sphere};
use super::{Accel, Brute, Mode};
use crate::geometry::{Hit, RaySetup};
use crate::lane::{Mask, Real, axes};

#[derive(Clone, Debug, Default)]
pub struct SphereList {
    spheres: Vec<([f32; 3], f32)>,
    first: u32,
}

impl SphereList {
    pub fn new(spheres: &[([f32; 3], f32)], first: u32) -> Self {
        Self { spheres: spheres.to_vec(), first }
    }
    pub fn bytes(&self) -> usize {
        core::mem::size_of_val(self.spheres.as_slice())
    }
}

#[inline(always)]
fn test_listed<R: Real>(
    sphere: &([f32; 3], f32),
    setup: &RaySetup<R>,
    t_best: R,
    active: R::Mask,
) -> Option<(R::Mask, R)> {
    test_sphere(setup, axes(|k| R::splat(sphere.0[k])), R::splat(sphere.1), t_best, active)
}

impl Mode for Brute {
    const TREE: bool = false;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        let t_max = hit.t;
        if active.none() {
            return;
        }
        accel.triangles.closest(setup, active, hit);
        for (i, sphere) in accel.spheres.spheres.iter().enumerate() {
            if let Some((mask, t)) = test_listed(sphere, setup, hit.t, active) {
                keep_sphere(mask, t, accel.spheres.first + i as u32, t_max, hit);
            }
        }
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        if active.none() {
            return active;
        }
        let mut open = active & !accel.triangles.any(setup, t_max, active);
        for sphere in &accel.spheres.spheres {
            if let Some((mask, t)) = test_listed(sphere, setup, t_max, open) {
                open = open & !(mask & t.lt(t_max));
            }
        }
        active & !open
    }
}
