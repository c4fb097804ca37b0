//! The watertight ray–triangle test: edges after Woop, Benthin, Wald 2013 ("Watertight Ray/Triangle Intersection"),
//! the distance from the triangle's plane.

use super::Ray;
use super::slab::{own_hi, own_lo, slab};
use crate::lane::{Bits, Mask, Real, Vec3, axes};

/// What the tests need of a ray, computed once per ray.
#[derive(Clone, Copy, Debug)]
pub struct RaySetup<R: Real> {
    pub origin: [R; 3],
    pub direction: [R; 3],
    /// 1/direction; ±∞ for ±0.
    pub inverse: [R; 3],
    /// Lanes whose direction has its sign bit set, by axis.
    pub negative: [R::Mask; 3],
    /// Which axes are x, y and z of the sheared space: z is the longest (ties: the lower), x and y follow in order,
    /// swapped for a negative z to keep the winding.
    pub order: [R::Bits; 3],
    pub shear: Shear<R>,
}

/// The transform that puts the ray on the z axis: origin and shear in the order of [`RaySetup::order`].
#[derive(Clone, Copy, Debug)]
pub struct Shear<R> {
    pub origin: [R; 3],
    /// d_x/d_z, d_y/d_z, 1/d_z.
    pub scale: [R; 3],
}

impl<R: Real> Shear<R> {
    #[inline(always)]
    pub fn apply(&self, p: [R; 3]) -> Moved<R> {
        let [x, y, z] = axes(|k| p[k] - self.origin[k]);
        [self.scale[0].neg_mul_add(z, x), self.scale[1].neg_mul_add(z, y), z]
    }
    /// x and y of [`Shear::apply`].
    #[inline(always)]
    pub fn across(&self, p: [R; 3]) -> [R; 2] {
        let [x, y, _] = self.apply(p);
        [x, y]
    }
}

/// Three vertices, three coordinates each.
pub type Vertices<R> = [[R; 3]; 3];

impl<R: Real> RaySetup<R> {
    #[inline(always)]
    pub fn new(ray: &Ray<R>) -> Self {
        let origin = [ray.origin.x, ray.origin.y, ray.origin.z];
        let direction = [ray.direction.x, ray.direction.y, ray.direction.z];
        let length = axes(|k| direction[k].abs());
        let y_longer = length[1].gt(length[0]);
        let z_longest = length[2].gt(length[1].max_or(length[0]));
        let axis = R::Bits::splat;
        // (kz, kx, ky) is a rotation of the axes.
        let rotated =
            |x: R::Bits, y: R::Bits, z: R::Bits| R::Bits::select(z_longest, z, R::Bits::select(y_longer, y, x));
        let rotated_real = |v: [R; 3], r: usize| {
            let at = |k: usize| v[(k + r) % 3];
            R::select(z_longest, at(2), R::select(y_longer, at(1), at(0)))
        };
        let d = axes(|k| rotated_real(direction, (k + 1) % 3));
        let o = axes(|k| rotated_real(origin, (k + 1) % 3));
        let k = [
            rotated(axis(1), axis(2), axis(0)),
            rotated(axis(2), axis(0), axis(1)),
            rotated(axis(0), axis(1), axis(2)),
        ];
        let swap = d[2].lt(R::zero());
        let swapped = |v: [R; 3]| [R::select(swap, v[1], v[0]), R::select(swap, v[0], v[1]), v[2]];
        let (d, o) = (swapped(d), swapped(o));
        let inverse = axes(|k| direction[k].recip());
        Self {
            origin,
            direction,
            inverse,
            negative: axes(|k| sign_bit(direction[k])),
            order: [R::Bits::select(swap, k[1], k[0]), R::Bits::select(swap, k[0], k[1]), k[2]],
            shear: Shear { origin: o, scale: [d[0] / d[2], d[1] / d[2], rotated_real(inverse, 0)] },
        }
    }
    /// The ray this was made of.
    #[inline(always)]
    pub fn ray(&self, t_max: R) -> Ray<R> {
        let vector = |v: [R; 3]| Vec3::new(v[0], v[1], v[2]);
        Ray::new(vector(self.origin), vector(self.direction), t_max)
    }
    /// Bounds in the order (near, far) that this ray meets them.
    #[inline(always)]
    pub fn near_far(&self, lo: [R; 3], hi: [R; 3]) -> ([R; 3], [R; 3]) {
        let pick = |a: [R; 3], b: [R; 3]| axes(|k| R::select(self.negative[k], a[k], b[k]));
        (pick(hi, lo), pick(lo, hi))
    }
    /// [`slab`] of a box given per lane.
    #[inline(always)]
    pub fn slab(&self, lo: [R; 3], hi: [R; 3]) -> (R, R) {
        let (near, far) = self.near_far(lo, hi);
        slab(near, far, self.origin, self.inverse)
    }
}

/// Lanes with the sign bit set, −0 included.
#[inline(always)]
fn sign_bit<R: Real>(x: R) -> R::Mask {
    !x.to_bits().shr::<31>().eq(R::Bits::splat(0))
}

/// Lanes whose ray passes between a triangle's edges, and what the test computed on the way.
#[derive(Clone, Copy, Debug)]
pub struct Edges<R: Real> {
    pub inside: R::Mask,
    /// Unnormalised weights of vertices 1 and 2, and the sum of all three.
    pub weights: [R; 2],
    pub sum: R,
    /// Along the ray's longest axis.
    depths: [R; 3],
}

/// A vertex in sheared space: x and y across the ray, z along its longest axis.
pub type Moved<R> = [R; 3];

/// The edge between two vertices as the triangles on its two sides compute it.
#[derive(Clone, Copy, Debug)]
pub struct SharedEdge<R>(R);

impl<R: Real> SharedEdge<R> {
    /// From `a` to `c`.
    ///
    /// The products of an edge function are plain: shared edges then give exactly opposite values, and monotone rounding
    /// never flips a sign, so no ray passes between two triangles. (One fused multiply-add there loses 4.5 % of edge hits.)
    #[inline(always)]
    pub fn new([ax, ay, _]: Moved<R>, [cx, cy, _]: Moved<R>) -> Self {
        Self::across([ax, ay], [cx, cy])
    }
    /// The same of vertices without their depths.
    #[inline(always)]
    pub fn across(a: [R; 2], c: [R; 2]) -> Self {
        Self(a[0] * c[1] - a[1] * c[0])
    }
    /// For a triangle whose vertices 0 and 2 are `a` and `c`.
    #[inline(always)]
    pub fn as_edge1(self) -> R {
        self.0
    }
    /// For a triangle whose vertices 0 and 1 are `a` and `c`.
    #[inline(always)]
    pub fn as_edge2(self) -> R {
        R::zero() - self.0
    }
}

/// The edge test of one triangle. Zero counts as inside.
#[inline(always)]
pub fn edges<R: Real>(shear: &Shear<R>, v: Vertices<R>, active: R::Mask) -> Edges<R> {
    let (a, b, c) = (shear.apply(v[0]), shear.apply(v[1]), shear.apply(v[2]));
    edges_of(a, b, c, SharedEdge::new(a, c).as_edge1(), SharedEdge::new(b, a).as_edge1(), active)
}

/// [`edges`], `None` where no lane of `active` passes.
#[inline(always)]
pub fn pass_edges<R: Real>(shear: &Shear<R>, v: Vertices<R>, active: R::Mask) -> Option<Edges<R>> {
    let edges = edges(shear, v, active);
    if edges.inside.none() { None } else { Some(edges) }
}

/// The edge test of (p, q, r) and of (p, r, s), whose common edge is computed once. Zero counts as inside.
#[inline(always)]
pub fn first_of_pair<R: Real>(p: Moved<R>, q: Moved<R>, r: Moved<R>, pr: SharedEdge<R>, active: R::Mask) -> Edges<R> {
    edges_of(p, q, r, pr.as_edge1(), SharedEdge::new(q, p).as_edge1(), active)
}

/// See [`first_of_pair`].
#[inline(always)]
pub fn second_of_pair<R: Real>(p: Moved<R>, r: Moved<R>, s: Moved<R>, pr: SharedEdge<R>, active: R::Mask) -> Edges<R> {
    edges_of(p, r, s, SharedEdge::new(p, s).as_edge1(), pr.as_edge2(), active)
}

#[inline(always)]
fn edges_of<R: Real>(a: Moved<R>, b: Moved<R>, c: Moved<R>, edge1: R, edge2: R, active: R::Mask) -> Edges<R> {
    let edge0 = SharedEdge::new(c, b).as_edge1();
    let least = edge0.min_or(edge1).min_or(edge2);
    let most = edge0.max_or(edge1).max_or(edge2);
    let inside = (least.ge(R::zero()) | most.le(R::zero())) & active;
    Edges { inside, weights: [edge1, edge2], sum: (edge0 + edge1) + edge2, depths: [a[2], b[2], c[2]] }
}

impl<R: Real> Edges<R> {
    /// Weights of vertices 1 and 2.
    #[inline(always)]
    pub fn weights(&self) -> (R, R) {
        Self::normalised(self.weights, self.sum)
    }

    /// Of triangles that were found inside in every lane.
    #[inline(always)]
    pub fn passed(weights: [R; 2], sum: R, depths: [R; 3]) -> Self {
        Self { inside: R::Mask::splat(true), weights, sum, depths }
    }

    /// Weights of vertices 1 and 2 from edge values and their sum. A zero has no sign: which one an edge value has depends
    /// on the triangle that it was computed for.
    #[inline(always)]
    pub fn normalised(weights: [R; 2], sum: R) -> (R, R) {
        (weights[0] / sum + R::zero(), weights[1] / sum + R::zero())
    }

    /// [`Edges::distances`] up to `t_best`, `None` where no lane has one.
    #[inline(always)]
    pub fn distance(&self, setup: &RaySetup<R>, v0: [R; 3], normal: [R; 3], t_best: R) -> Option<(R::Mask, R)> {
        let (mask, t) = self.distances(setup, v0, normal, largest(normal));
        let mask = mask & t.le(t_best);
        if mask.none() { None } else { Some((mask, t)) }
    }

    /// Distances to the plane through `v0` with [`plane_normal`] `normal` (both in world order; `normal_size` is its
    /// [`largest`] component), and the lanes where they are > 0.
    ///
    /// Not Woop's sum of weighted depths: the weights of a sliver carry an error of ε·length²/area, and with it t, so that
    /// rays hit the sliver they leave. The plane of a triangle is sure to ε·length wherever the triangle is, however
    /// thin. Seen from a low angle t is not (`STEEP`): `grazing_distance` has those.
    #[inline(always)]
    pub fn distances(&self, setup: &RaySetup<R>, v0: [R; 3], normal: [R; 3], normal_size: R) -> (R::Mask, R) {
        let (mut t, steepness) = meet_plane(setup, axes(|k| v0[k] - setup.origin[k]), normal, normal_size);
        let steep = steepness.ge(R::zero());
        let inside = self.inside & !self.sum.eq(R::zero());
        let mut hits = inside & t.gt(R::zero());
        let grazing = inside & !steep;
        if grazing.any() {
            let [a, b, c] = self.depths;
            let (hits_low, t_low) = grazing_distance(setup.shear.scale[2], a, b, c, t);
            hits = R::Mask::select(grazing, inside & hits_low, hits);
            t = R::select(grazing, t_low, t);
        }
        (hits, t)
    }
}

/// Of rays that meet the plane at a low angle the plane's distance is held to what the vertices' own `depths` allow:
/// with all of them ahead nothing is lost, and else (the origin is beside the triangle) a crossing at more than twice
/// the farthest is none. `scale` is 1 over the direction's component that depths are measured along.
///
/// By value: what it was given by reference would be written to memory for every ray, low or not.
#[cold]
fn grazing_distance<R: Real>(scale: R, a: R, b: R, c: R, plane: R) -> (R::Mask, R) {
    let vertices = [scale * a, scale * b, scale * c];
    let first = vertices[0].min_or(vertices[1]).min_or(vertices[2]);
    let last = vertices[0].max_or(vertices[1]).max_or(vertices[2]);
    let ahead = first.gt(R::zero());
    let crosses = plane.gt(R::zero()) & plane.le(last + last);
    // A plane without a normal is NaN: the nearest vertex is then as good a guess as any.
    let t = R::select(ahead, plane.max_or(first), plane).min_or(last);
    (ahead | crosses, t)
}

/// A ray meets a plane steeply where |n·d| is at least this share of max|n_k|·max|d_k|. t then is sure to
/// ε·length/`STEEP` = 2⁻¹⁸·length, and needs no help from the vertices. (1.5 % of the directions are less steep.)
const STEEP: f32 = 1.0 / 64.0;

/// Distance to the plane of `normal` through a point that lies `way` from the origin, and by how much it is met steeply: less
/// than zero where the angle is low.
#[inline(always)]
pub fn meet_plane<R: Real>(setup: &RaySetup<R>, way: [R; 3], normal: [R; 3], normal_size: R) -> (R, R) {
    let along = dot(normal, setup.direction);
    // A difference is zero between equals alone.
    let steepness = along.abs() - normal_size * (largest(setup.direction) * R::splat(STEEP));
    (dot(normal, way) / along, steepness)
}

/// The largest magnitude.
#[inline(always)]
pub fn largest<R: Real>(v: [R; 3]) -> R {
    v[0].abs().max_or(v[1].abs()).max_or(v[2].abs())
}

#[inline(always)]
fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// (v1 − v0) × (v2 − v0), each component within 1.5 ulp for the rounded edges.
#[inline(always)]
pub fn plane_normal<R: Real>(v: Vertices<R>) -> [R; 3] {
    let edge = |i: usize| Vec3::new(v[i][0] - v[0][0], v[i][1] - v[0][1], v[i][2] - v[0][2]);
    let n = edge(1).cross(edge(2));
    [n.x, n.y, n.z]
}

/// The own box of a triangle per lane, from vertices in world order.
#[inline(always)]
pub fn own_box<R: Real>(v: Vertices<R>) -> ([R; 3], [R; 3]) {
    (axes(|k| own_lo(v[0][k], v[1][k], v[2][k])), axes(|k| own_hi(v[0][k], v[1][k], v[2][k])))
}
