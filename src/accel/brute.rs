//! All lanes against every primitive in turn: no tree, no stack.

use super::block::{keep_sphere, keep_triangle, test_sphere};
use super::{Accel, Brute, Mode};
use crate::geometry::{Bounds, Edges, Hit, RaySetup, Rows, edges, largest, plane_normal};
use crate::lane::{Bits, Mask, Real, axes};

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
    /// The largest component of the normal.
    normal_size: f32,
}

#[derive(Clone, Debug, Default)]
pub struct TriangleList {
    rows: Vec<TriangleRow>,
    /// The own boxes once more, for lanes to fetch: lower corner, upper corner, two fillers.
    boxes: Rows<8>,
}

#[derive(Clone, Debug, Default)]
pub struct SphereList {
    spheres: Vec<([f32; 3], f32)>,
    first: u32,
}

impl TriangleList {
    pub fn new(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let row = |v: [[f32; 3]; 3]| {
            let Bounds { lo, hi } = Bounds::of_triangle(v);
            let normal = plane_normal(v);
            let normal_size = largest(normal);
            TriangleRow { vertices: v.map(|[x, y, z]| [x, y, z, 0.0]), lo, hi, normal, normal_size }
        };
        let rows: Vec<_> = triangles.map(row).collect();
        let boxes: Vec<_> =
            rows.iter().map(|r| [r.lo[0], r.lo[1], r.lo[2], r.hi[0], r.hi[1], r.hi[2], 0.0, 0.0]).collect();
        Self { boxes: Rows::new(&boxes), rows }
    }
    pub fn bytes(&self) -> usize {
        core::mem::size_of_val(self.rows.as_slice()) + self.boxes.bytes()
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

impl TriangleList {
    /// Own boxes are looked at once, for the winners: where the winner of the bare distances passes its box and lies
    /// behind the box's front, it is the winner of the exact test too, since that only ever removes hits or moves them
    /// away. The few other lanes are done again, exactly.
    #[inline(always)]
    fn closest<R: Real>(&self, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        let mut best = *hit;
        let mut sum = R::one();
        for (i, row) in self.rows.iter().enumerate() {
            let (edges, mask, t) = row.pass(setup, best.t, active);
            // In order of their index, so that the lower keeps a tie.
            let mask = mask & t.lt(best.t);
            let [u, v] = edges.weights;
            best.replace(mask, Hit { t, primitive: R::Bits::splat(i as u32), u, v });
            sum = R::select(mask, edges.sum, sum);
        }
        (best.u, best.v) = (best.u / sum, best.v / sum);
        let found = best.valid() & active;
        let [lx, ly, lz, hx, hy, hz, ..] = self.boxes.fetch::<R>(best.primitive, found);
        let (t_near, t_far) = setup.slab([lx, ly, lz], [hx, hy, hz]);
        let doubtful = found & !(t_near.le(t_far) & t_near.le(best.t));
        if doubtful.any() {
            self.closest_exact(setup, doubtful, hit);
        }
        hit.replace(found & !doubtful, best);
    }

    #[cold]
    #[inline(never)]
    fn closest_exact<R: Real>(&self, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        let t_max = hit.t;
        for (i, row) in self.rows.iter().enumerate() {
            if let Some(found) = row.test(setup, hit.t, active) {
                keep_triangle(found, i as u32, t_max, hit);
            }
        }
    }
}

impl TriangleRow {
    /// The edge test and the distance, without the own box. No branch: what some lane of 16 does next is anybody's
    /// guess, and a wrong guess costs as much as the work it saves.
    #[inline(always)]
    fn pass<R: Real>(&self, setup: &RaySetup<R>, t_best: R, active: R::Mask) -> (Edges<R>, R::Mask, R) {
        let turned = axes(|vertex| axes(|k| R::lookup4(&self.vertices[vertex], setup.order[k])));
        let edges = edges(&setup.shear, turned, active);
        let v0 = axes(|k| R::splat(self.vertices[0][k]));
        let normal = axes(|k| R::splat(self.normal[k]));
        let (mask, t) = edges.distances(setup, v0, normal, R::splat(self.normal_size), t_best);
        (edges, mask, t)
    }

    #[inline(always)]
    fn test<R: Real>(&self, setup: &RaySetup<R>, t_best: R, active: R::Mask) -> Option<(Edges<R>, R::Mask, R)> {
        let (edges, mask, t) = self.pass(setup, t_best, active);
        if mask.none() {
            return None;
        }
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
        accel.triangles.closest(setup, active, hit);
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
        for row in &accel.triangles.rows {
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
