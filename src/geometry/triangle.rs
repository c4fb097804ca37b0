//! The watertight ray–triangle test (Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection").

use super::Ray;
use super::slab::{own_hi, own_lo, slab};
use crate::lane::{Bits, Mask, Real};

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
    pub axes: [R::Bits; 3],
    pub shear: Shear<R>,
}

/// The transform that puts the ray on the z axis: origin and shear in the order of [`RaySetup::axes`].
#[derive(Clone, Copy, Debug)]
pub struct Shear<R> {
    pub origin: [R; 3],
    /// d_x/d_z, d_y/d_z, 1/d_z.
    pub scale: [R; 3],
}

/// Three vertices, three coordinates each.
pub type Vertices<R> = [[R; 3]; 3];

impl<R: Real> RaySetup<R> {
    #[inline(always)]
    pub fn new(ray: &Ray<R>) -> Self {
        let origin = [ray.origin.x, ray.origin.y, ray.origin.z];
        let direction = [ray.direction.x, ray.direction.y, ray.direction.z];
        let length = direction.map(R::abs);
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
        let d = [1, 2, 0].map(|r| rotated_real(direction, r));
        let o = [1, 2, 0].map(|r| rotated_real(origin, r));
        let k = [
            rotated(axis(1), axis(2), axis(0)),
            rotated(axis(2), axis(0), axis(1)),
            rotated(axis(0), axis(1), axis(2)),
        ];
        let swap = d[2].lt(R::zero());
        let swapped = |v: [R; 3]| [R::select(swap, v[1], v[0]), R::select(swap, v[0], v[1]), v[2]];
        let (d, o) = (swapped(d), swapped(o));
        Self {
            origin,
            direction,
            inverse: direction.map(R::recip),
            negative: direction.map(|d| sign_bit(d)),
            axes: [R::Bits::select(swap, k[1], k[0]), R::Bits::select(swap, k[0], k[1]), k[2]],
            shear: Shear { origin: o, scale: [d[0] / d[2], d[1] / d[2], d[2].recip()] },
        }
    }
    /// Bounds in the order (near, far) that this ray meets them.
    #[inline(always)]
    pub fn near_far(&self, lo: [R; 3], hi: [R; 3]) -> ([R; 3], [R; 3]) {
        let pick = |a: [R; 3], b: [R; 3]| core::array::from_fn(|k| R::select(self.negative[k], a[k], b[k]));
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

/// Where the edge test and the plane put a hit, before the own box has its say.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit<R: Real> {
    pub mask: R::Mask,
    pub t: R,
    /// Unnormalised weights of vertices 1 and 2, and the sum of all three.
    v_edge: R,
    w_edge: R,
    det: R,
}

impl<R: Real> TriangleHit<R> {
    /// Weights of vertices 1 and 2.
    #[inline(always)]
    pub fn weights(&self) -> (R, R) {
        (self.v_edge / self.det, self.w_edge / self.det)
    }
}

/// Lanes where the ray passes the edge test and 0 < t ≤ `t_best`. `None` where no lane of `active` does.
///
/// `v` is in the order of [`RaySetup::axes`]. The products of an edge function are plain: shared edges then give
/// exactly opposite values, and monotone rounding never flips a sign, so no ray passes between two triangles. (One
/// fused multiply-add there loses 4.5 % of edge hits.) Zero counts as inside.
#[inline(always)]
pub fn intersect_triangle<R: Real>(
    shear: &Shear<R>,
    v: Vertices<R>,
    t_best: R,
    active: R::Mask,
) -> Option<TriangleHit<R>> {
    let [ox, oy, oz] = shear.origin;
    let [sx, sy, sz] = shear.scale;
    let moved = |p: [R; 3]| {
        let z = p[2] - oz;
        [sx.neg_mul_add(z, p[0] - ox), sy.neg_mul_add(z, p[1] - oy), z]
    };
    let (a, b, c) = (moved(v[0]), moved(v[1]), moved(v[2]));
    let u_edge = c[0] * b[1] - c[1] * b[0];
    let v_edge = a[0] * c[1] - a[1] * c[0];
    let w_edge = b[0] * a[1] - b[1] * a[0];
    let least = u_edge.min_or(v_edge).min_or(w_edge);
    let most = u_edge.max_or(v_edge).max_or(w_edge);
    let zero = R::zero();
    let inside = (least.ge(zero) | most.le(zero)) & active;
    if inside.none() {
        return None;
    }
    let det = (u_edge + v_edge) + w_edge;
    let depth = u_edge.mul_add(sz * a[2], v_edge.mul_add(sz * b[2], w_edge * (sz * c[2])));
    // A zero determinant gives an infinity or NaN. Neither passes: depth/0 = +∞ needs t_best = ∞, so it is named.
    let t = depth / det;
    let mask = inside & t.gt(zero) & t.le(t_best) & !det.eq(zero);
    if mask.none() { None } else { Some(TriangleHit { mask, t, v_edge, w_edge, det }) }
}

/// The own box of a triangle per lane, from vertices in world order.
#[inline(always)]
pub fn own_box<R: Real>(v: Vertices<R>) -> ([R; 3], [R; 3]) {
    (
        core::array::from_fn(|k| own_lo(v[0][k], v[1][k], v[2][k])),
        core::array::from_fn(|k| own_hi(v[0][k], v[1][k], v[2][k])),
    )
}
