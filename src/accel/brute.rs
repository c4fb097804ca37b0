//! All lanes against every primitive in turn: no tree, no stack.

use super::block::{keep_sphere, keep_triangle, test_sphere};
use super::{Accel, Brute, Mode};
use crate::geometry::{Bounds, Edges, Hit, RaySetup, pass_edges, plane_normal};
use crate::lane::{Mask, Real, axes};

/// A triangle for broadcasting: 96 bytes.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
struct TriangleRow {
    /// x, y, z and a filler, so that a lane picks its axes by permuting one register.
    vertices: [[f32; 4]; 3],
    /// The own box.
    lo: [f32; 3],
    hi: [f32; 3],
    normal: [f32; 3],
}

#[derive(Clone, Debug, Default)]
pub struct TriangleList(Vec<TriangleRow>);

#[derive(Clone, Debug, Default)]
pub struct SphereList {
    spheres: Vec<([f32; 3], f32)>,
    first: u32,
}

impl TriangleList {
    pub fn new(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let row = |v: [[f32; 3]; 3]| {
            let Bounds { lo, hi } = Bounds::of_triangle(v);
            TriangleRow { vertices: v.map(|[x, y, z]| [x, y, z, 0.0]), lo, hi, normal: plane_normal(v) }
        };
        Self(triangles.map(row).collect())
    }
    pub fn bytes(&self) -> usize {
        core::mem::size_of_val(self.0.as_slice())
    }
}

impl SphereList {
    pub fn new(spheres: &[([f32; 3], f32)], first: u32) -> Self {
        Self { spheres: spheres.to_vec(), first }
    }
    pub fn bytes(&self) -> usize {
        core::mem::size_of_val(self.spheres.as_slice())
    }
}

impl TriangleRow {
    #[inline(always)]
    fn test<R: Real>(&self, setup: &RaySetup<R>, t_best: R, active: R::Mask) -> Option<(Edges<R>, R::Mask, R)> {
        let turned = axes(|vertex| axes(|k| R::lookup4(&self.vertices[vertex], setup.order[k])));
        let edges = pass_edges(&setup.shear, turned, active)?;
        let v0 = axes(|k| R::splat(self.vertices[0][k]));
        let (mask, t) = edges.distance(setup, v0, axes(|k| R::splat(self.normal[k])), t_best)?;
        let (t_near, t_far) = setup.slab(axes(|k| R::splat(self.lo[k])), axes(|k| R::splat(self.hi[k])));
        Some((edges, mask & t_near.le(t_far), t_near.max_or(t)))
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
        for (i, row) in accel.triangles.0.iter().enumerate() {
            if let Some(found) = row.test(setup, hit.t, active) {
                keep_triangle(found, i as u32, t_max, hit);
            }
        }
        for (i, sphere) in accel.spheres.spheres.iter().enumerate() {
            if let Some((mask, t)) = test_listed(sphere, setup, hit.t, active) {
                keep_sphere(mask, t, accel.spheres.first + i as u32, t_max, hit);
            }
        }
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        let mut open = active;
        if open.none() {
            return open;
        }
        for row in &accel.triangles.0 {
            if let Some((_, mask, t)) = row.test(setup, t_max, open) {
                open = open & !(mask & t.lt(t_max));
                if open.none() {
                    return active;
                }
            }
        }
        for sphere in &accel.spheres.spheres {
            if let Some((mask, t)) = test_listed(sphere, setup, t_max, open) {
                open = open & !(mask & t.lt(t_max));
            }
        }
        active & !open
    }
}
