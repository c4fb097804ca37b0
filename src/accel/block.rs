//! Leaves: eight triangles side by side.

use super::interval::{Interval, Segments};
use super::lanes::ones;
use super::leaf::{EdgeValues, Found, Leaf};
use super::node::Planes;
use super::tree::{Block, OneHit, OneRay, PacketRay};
use crate::geometry::plane_normal;
use crate::geometry::slab::{own_hi, own_lo};
use crate::geometry::{Edges, Hit, MISS, RaySetup, Vertices, edges, largest, own_box, pass_edges};
use crate::lane::{Bits, Mask, Real, axes, u32x8};

/// Eight triangles: coordinates by vertex and axis, so that a single ray's choice of axes is a choice of arrays.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct TriangleBlock {
    v: [[[f32; 8]; 3]; 3],
    /// [`MISS`] in empty places, which come last. Their vertices are NaN: no ray passes their edges.
    id: [u32; 8],
}

impl TriangleBlock {
    pub fn new(ids: &[u32], vertices: impl Fn(usize) -> [[f32; 3]; 3]) -> Self {
        let mut block = Self { v: [[[f32::NAN; 8]; 3]; 3], id: [MISS; 8] };
        for (place, id) in ids.iter().enumerate() {
            for (vertex, p) in vertices(*id as usize).iter().enumerate() {
                for (axis, x) in p.iter().enumerate() {
                    block.v[vertex][axis][place] = *x;
                }
            }
            block.id[place] = *id;
        }
        block
    }

    /// Vertices from place `i` on, their coordinates in the given order.
    #[inline(always)]
    fn load<E: Real>(&self, order: [usize; 3], i: usize) -> Vertices<E> {
        axes(|vertex| axes(|k| E::load(&self.v[vertex][order[k]][i..])))
    }
    /// Own boxes.
    #[inline(always)]
    pub fn own_boxes<E: Real>(&self, planes: &mut Planes) {
        for i in (0..8).step_by(E::WIDTH) {
            let (lo, hi) = own_box(self.load::<E>([0, 1, 2], i));
            for k in 0..3 {
                lo[k].store(&mut planes[k][i..]);
                hi[k].store(&mut planes[k][8 + i..]);
            }
        }
    }
    /// Vertices as seen from `origin`, their coordinates in the given order, which is the origin's.
    #[inline(always)]
    pub fn moved<E: Real>(&self, order: [usize; 3], origin: [f32; 3], moved: &mut [[[f32; 8]; 3]; 3]) {
        for i in (0..8).step_by(E::WIDTH) {
            let v = self.load::<E>(order, i);
            for vertex in 0..3 {
                for k in 0..3 {
                    (v[vertex][k] - E::splat(origin[k])).store(&mut moved[vertex][k][i..]);
                }
            }
        }
    }
    /// Components of the normals, and the largest of each.
    #[inline(always)]
    pub fn normals<E: Real>(&self, columns: &mut [[f32; 8]; 4]) {
        for i in (0..8).step_by(E::WIDTH) {
            let normal = plane_normal(self.load::<E>([0, 1, 2], i));
            for k in 0..3 {
                normal[k].store(&mut columns[k][i..]);
            }
            largest(normal).store(&mut columns[3][i..]);
        }
    }
    /// A coordinate of a vertex of triangle `i` in every lane.
    #[inline(always)]
    pub fn splat_one<R: Real>(&self, vertex: usize, axis: usize, i: usize) -> R {
        R::splat(self.v[vertex][axis][i])
    }
    /// Triangle `i` in every lane.
    #[inline(always)]
    pub fn splat<R: Real>(&self, order: [usize; 3], i: usize) -> Vertices<R> {
        axes(|vertex| axes(|k| R::splat(self.v[vertex][order[k]][i])))
    }

    /// Lanes from place `i` on that the ray passes between the edges of.
    #[inline(always)]
    fn edges_one<E: Real>(&self, ray: &OneRay<E>, i: usize) -> Edges<E> {
        edges(&ray.setup.shear, self.load(ray.order, i), E::Mask::splat(true))
    }

    /// Triangle `i` in every lane, in the order of each.
    #[inline(always)]
    fn turned<R: Real>(&self, ray: &PacketRay<R>, i: usize) -> Vertices<R> {
        let world = self.splat([0, 1, 2], i);
        axes(|vertex| axes(|k| ray.pick(k, world[vertex])))
    }

    /// `turned` gives the vertices of a place in the packet's order.
    #[inline(always)]
    fn closest_turned<R: Real>(
        &self,
        ray: &PacketRay<R>,
        places: u32,
        active: R::Mask,
        hit: &mut Hit<R>,
        t_max: R,
        turned: impl Fn(usize) -> Vertices<R>,
    ) {
        for i in ones(places) {
            let i = i % 8;
            if let Some(found) = test_packet(ray.setup, turned(i), self.splat([0, 1, 2], i), hit.t, active) {
                keep_triangle(found, self.id[i], t_max, hit);
            }
        }
    }

    /// See [`TriangleBlock::closest_turned`].
    #[inline(always)]
    fn any_turned<R: Real>(
        &self,
        ray: &PacketRay<R>,
        places: u32,
        t_max: R,
        active: R::Mask,
        turned: impl Fn(usize) -> Vertices<R>,
    ) -> R::Mask {
        let mut open = active;
        for i in ones(places) {
            let i = i % 8;
            if let Some((_, mask, t)) = test_packet(ray.setup, turned(i), self.splat([0, 1, 2], i), t_max, open) {
                open = open & !(mask & t.lt(t_max));
                if open.none() {
                    break;
                }
            }
        }
        active & !open
    }
}

/// A triangle against a packet: candidates and their final distances.
#[inline(always)]
fn test_packet<R: Real>(
    setup: &RaySetup<R>,
    turned: Vertices<R>,
    world: Vertices<R>,
    t_best: R,
    active: R::Mask,
) -> Option<(Edges<R>, R::Mask, R)> {
    let edges = pass_edges(&setup.shear, turned, active)?;
    let (mask, t) = edges.distance(setup, world[0], plane_normal(world), t_best)?;
    let (lo, hi) = own_box(world);
    let (t_near, t_far) = setup.slab(lo, hi);
    Some((edges, mask & t_near.le(t_far), t_near.max_or(t)))
}

/// Does (t, primitive) beat the best so far?
#[inline(always)]
pub fn better<R: Real>(t: R, primitive: R::Bits, best_t: R, best_primitive: R::Bits) -> R::Mask {
    // Primitives are few enough (MOST_PRIMITIVES): as signed differences they compare right, and none is below MISS.
    let lower = !(primitive - best_primitive).shr::<31>().eq(R::Bits::splat(0));
    t.lt(best_t) | t.eq(best_t) & lower
}

/// Takes the hits of `mask` that beat the best so far.
#[inline(always)]
pub fn keep_triangle<R: Real>((edges, mask, t): (Edges<R>, R::Mask, R), primitive: u32, t_max: R, hit: &mut Hit<R>) {
    let primitive = R::Bits::splat(primitive);
    let mask = mask & t.lt(t_max) & better(t, primitive, hit.t, hit.primitive);
    if mask.any() {
        let (u, v) = edges.weights();
        hit.replace(mask, Hit { t, primitive, u, v });
    }
}

/// Places that are not empty, as bits.
#[inline(always)]
pub fn filled(id: &[u32; 8]) -> u32 {
    let empty = <u32x8 as Bits>::load(id).eq(<u32x8 as Bits>::splat(MISS));
    !empty.bits() & 0xff
}

impl Leaf for TriangleBlock {
    #[inline(always)]
    fn passed<E: Real>(&self, ray: &OneRay<E>, edges: &mut EdgeValues) -> u32 {
        // No closure: it would be called, with the whole ray passed through memory.
        let (mut bits, mut i) = (0, 0);
        while i < 8 && (E::WIDTH == 8 || self.id[i] != MISS) {
            let values = self.edges_one(ray, i);
            edges.put(i, &values);
            bits |= values.inside.bits() << i;
            i += E::WIDTH;
        }
        bits
    }
    #[inline(always)]
    fn id(&self, place: usize) -> u32 {
        self.id[place]
    }
    #[inline(always)]
    fn meet<E: Real>(found: &Found<'_, Self>, ray: &RaySetup<E>) -> (E::Mask, E, E, E) {
        let v: Vertices<E> = axes(|vertex| axes(|k| found.gather(|block, place| block.v[vertex][k][place])));
        let is = |axis| ray.order[2].eq(Bits::splat(axis));
        let (is_y, is_z) = (is(1), is(2));
        let along = |p: [E; 3]| E::select(is_z, p[2], E::select(is_y, p[1], p[0]));
        let edges = found.edges(axes(|vertex| along(v[vertex]) - ray.shear.origin[2]));
        let normal = plane_normal(v);
        let (hits, t) = edges.distances(ray, v[0], normal, largest(normal));
        let (lo, hi) = own_box(v);
        let (t_near, t_far) = ray.slab(lo, hi);
        let (u, v) = edges.weights();
        (hits & t_near.le(t_far), t_near.max_or(t), u, v)
    }
    #[inline(always)]
    fn meet_one(&self, place: usize, ray: &OneRay<f32>, edges: &EdgeValues) -> (bool, OneHit) {
        let v: Vertices<f32> = axes(|vertex| axes(|k| self.v[vertex][k][place]));
        let depths = axes(|vertex| self.v[vertex][ray.order[2]][place] - ray.setup.shear.origin[2]);
        let edges = edges.at(place, depths);
        let normal = plane_normal(v);
        let (ahead, t) = edges.distances(&ray.setup, v[0], normal, largest(normal));
        let (lo, hi) = own_box(v);
        let (t_near, t_far) = ray.slab(lo, hi);
        let t = t_near.max_or(t);
        let (u, v) = edges.weights();
        (ahead & (t_near <= t_far) & (t < ray.t_max), OneHit { t, primitive: self.id[place], u, v })
    }
}

impl Block for TriangleBlock {
    #[inline(always)]
    fn places<E: Real>(&self, interval: Option<&Interval<E>>, t_best: f32) -> u32 {
        let filled = filled(&self.id);
        let Some(interval) = interval.filter(|_| E::WIDTH == 8) else { return filled };
        let v: Vertices<E> = self.load([0, 1, 2], 0);
        let lo = axes(|k| own_lo(v[0][k], v[1][k], v[2][k]));
        let hi = axes(|k| own_hi(v[0][k], v[1][k], v[2][k]));
        let (t_near, t_far) = interval.slab(lo, hi, t_best);
        t_near.le_bits(t_far) & filled
    }
    #[inline(always)]
    fn places_about<E: Real>(&self, segments: &Segments<E>) -> u32 {
        let filled = filled(&self.id);
        if E::WIDTH < 8 {
            return filled;
        }
        let (lo, hi) = own_box(self.load([0, 1, 2], 0));
        segments.meets(lo, hi) & filled
    }
    #[inline(always)]
    fn closest_packet<R: Real>(&self, ray: &PacketRay<R>, places: u32, active: R::Mask, hit: &mut Hit<R>, t_max: R) {
        // Two loops: a choice of order inside one would keep the vertices as scalars.
        match ray.order {
            Some(order) => self.closest_turned(ray, places, active, hit, t_max, |i| self.splat(order, i)),
            None => self.closest_turned(ray, places, active, hit, t_max, |i| self.turned(ray, i)),
        }
    }
    #[inline(always)]
    fn any_packet<R: Real>(&self, ray: &PacketRay<R>, places: u32, t_max: R, active: R::Mask) -> R::Mask {
        match ray.order {
            Some(order) => self.any_turned(ray, places, t_max, active, |i| self.splat(order, i)),
            None => self.any_turned(ray, places, t_max, active, |i| self.turned(ray, i)),
        }
    }
}
