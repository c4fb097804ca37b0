//! Many rays as one, with bounds instead of numbers.

use super::node::{Node, Planes};
use crate::geometry::RaySetup;
use crate::geometry::slab::FAR_PAD;
use crate::lane::{Bits, Mask, Real, axes};

/// Bounds of what the rays of a packet do, for testing eight boxes against all of them at once.
///
/// Every lane's distance to a plane is fl(fl(plane − o)·inverse) with o and inverse between the bounds here; rounding is
/// monotone, so the extremes over the four corners bound it as computed: a child this drops no lane enters.
#[derive(Clone, Copy)]
pub struct Interval<E: Real> {
    /// The origin bound that makes planes near early and planes far late.
    near_origin: [E; 3],
    far_origin: [E; 3],
    lowest: [E; 3],
    highest: [E; 3],
    /// 1 where the directions are negative.
    negative: [usize; 3],
}

impl<E: Real> Interval<E> {
    /// `None` where the lanes' signs differ or a component of a direction is so small that its inverse is infinite.
    #[inline(always)]
    pub fn new<R: Real>(setup: &RaySetup<R>, negative: Option<[usize; 3]>, active: R::Mask) -> Option<Self> {
        Self::around(core::slice::from_ref(setup), &[active], negative?)
    }

    /// Of packets whose active lanes all have these signs; see [`Interval::new`].
    #[inline(always)]
    pub fn around<R: Real>(setups: &[RaySetup<R>], active: &[R::Mask], negative: [usize; 3]) -> Option<Self> {
        let infinity = R::splat(f32::INFINITY);
        // Lane by lane over the packets first: to go across lanes takes longer.
        let extremes = |of: fn(&RaySetup<R>) -> [R; 3]| {
            let mut bounds = [[infinity; 3], [-infinity; 3]];
            for (p, setup) in setups.iter().enumerate() {
                let (x, active) = (of(setup), active[p]);
                bounds[0] = axes(|k| R::select(active, x[k], infinity).min_or(bounds[0][k]));
                bounds[1] = axes(|k| R::select(active, x[k], -infinity).max_or(bounds[1][k]));
            }
            (axes(|k| bounds[0][k].lowest()), axes(|k| bounds[1][k].highest()))
        };
        let (lowest, highest) = extremes(|setup| setup.inverse);
        if (0..3).any(|k| !lowest[k].is_finite() || !highest[k].is_finite()) {
            return None;
        }
        let (o_lowest, o_highest) = extremes(|setup| setup.origin);
        Some(Self {
            near_origin: axes(|k| E::splat(if negative[k] != 0 { o_lowest[k] } else { o_highest[k] })),
            far_origin: axes(|k| E::splat(if negative[k] != 0 { o_highest[k] } else { o_lowest[k] })),
            lowest: axes(|k| E::splat(lowest[k])),
            highest: axes(|k| E::splat(highest[k])),
            negative,
        })
    }

    /// Where all rays start, if it is one point.
    #[inline(always)]
    pub fn origin(&self) -> Option<[f32; 3]> {
        let (near, far) = (axes(|k| self.near_origin[k].lane(0)), axes(|k| self.far_origin[k].lane(0)));
        (near == far).then_some(near)
    }

    /// Where the first lane may enter boxes, and the last leave them: a lane enters only those where the first is not
    /// greater.
    #[inline(always)]
    pub fn slab(&self, lo: [E; 3], hi: [E; 3], t_best: f32) -> (E, E) {
        self.slab_of(axes(|k| if self.negative[k] != 0 { (hi[k], lo[k]) } else { (lo[k], hi[k]) }), t_best)
    }

    /// [`Interval::slab`] of eight boxes by their [`Planes`].
    #[inline(always)]
    fn slab_in(&self, planes: &Planes, t_best: f32) -> (E, E) {
        let plane = |k: usize, upper: usize| E::load(&planes[k][8 * upper..]);
        self.slab_of(axes(|k| (plane(k, self.negative[k]), plane(k, 1 - self.negative[k]))), t_best)
    }

    /// From the planes that are near and far.
    #[inline(always)]
    fn slab_of(&self, planes: [(E, E); 3], t_best: f32) -> (E, E) {
        let (mut t_near, mut t_far) = (E::zero(), E::splat(f32::INFINITY));
        for (k, (near, far)) in planes.into_iter().enumerate() {
            let (near, far) = (near - self.near_origin[k], far - self.far_origin[k]);
            t_near = (near * self.lowest[k]).min_or(near * self.highest[k]).max_or(t_near);
            t_far = (far * self.lowest[k]).max_or(far * self.highest[k]).min_or(t_far);
        }
        (t_near, (t_far * E::splat(FAR_PAD)).min_or(E::splat(t_best)))
    }

    /// Of eight boxes those that some lane may enter before `t_best`, as bits.
    #[inline(always)]
    pub fn entered(&self, planes: &Planes, t_best: f32) -> u32 {
        let (t_near, t_far) = self.slab_in(planes, t_best);
        t_near.le_bits(t_far)
    }

    /// Slots of the children that some lane may enter before `t_best`, as bits in the octant's order, and that order.
    #[inline(always)]
    pub fn slots(&self, node: &Node, t_best: f32) -> (u32, E::Bits) {
        let (t_near, t_far) = self.slab_in(&node.planes, t_best);
        let order = E::Bits::unpack_octal(node.order[self.octant()]);
        (t_near.permute(order).le_bits(t_far.permute(order)), order)
    }

    /// As [`Interval::slots`], where the first lane enters them, and all the child words, in that order.
    #[inline(always)]
    pub fn children(&self, node: &Node, t_best: f32) -> (u32, E, E::Bits) {
        let (t_near, t_far) = self.slab_in(&node.planes, t_best);
        let order = E::Bits::unpack_octal(node.order[self.octant()]);
        let t_near = t_near.permute(order);
        let words = E::from_bits(E::Bits::load(&node.children)).permute(order).to_bits();
        (t_near.le_bits(t_far.permute(order)), t_near, words)
    }

    #[inline(always)]
    fn octant(&self) -> usize {
        self.negative[0] | self.negative[1] << 1 | self.negative[2] << 2
    }
}

/// The box that the segments of a packet lie in, for testing eight boxes against all of them at once.
///
/// A hit at t < t_max has, as computed, t_near ≤ t and 0 ≤ t_far for its own box: so on each axis fl(fl(near − o)·inverse) <
/// t_max, and the far plane is not behind o. The first puts near before o + t_max·d but for four roundings, which
/// [`SEGMENT_MARGIN`] covers.
pub struct Segments<E: Real> {
    lo: [E; 3],
    hi: [E; 3],
}

/// Of |o| and |o + t_max·d|: 16 half ulps.
const SEGMENT_MARGIN: f32 = 1.0 / 1_048_576.0;

impl<E: Real> Segments<E> {
    /// Of active lanes.
    #[inline(always)]
    pub fn new<R: Real>(setup: &RaySetup<R>, t_max: R, active: R::Mask) -> Self {
        let infinity = R::splat(f32::INFINITY);
        let ends = axes(|k| {
            let (from, to) = (setup.origin[k], setup.direction[k].mul_add(t_max, setup.origin[k]));
            // Without end, `to` is infinite and needs no margin, or NaN across the ray, where `from` wins over it.
            let reach = R::select(to.is_finite(), to, from).abs();
            let margin = (from.abs() + reach) * R::splat(SEGMENT_MARGIN);
            let (lo, hi) = (to.min_or(from) - margin, to.max_or(from) + margin);
            [R::select(active, lo, infinity).lowest(), R::select(active, hi, -infinity).highest()]
        });
        Self { lo: axes(|k| E::splat(ends[k][0])), hi: axes(|k| E::splat(ends[k][1])) }
    }

    /// Of eight boxes by their [`Planes`] those that some segment may meet, as bits.
    #[inline(always)]
    pub fn meet(&self, planes: &Planes) -> u32 {
        self.meets(axes(|k| E::load(&planes[k])), axes(|k| E::load(&planes[k][8..])))
    }

    /// Of boxes those that some segment may meet, as bits.
    #[inline(always)]
    pub fn meets(&self, lo: [E; 3], hi: [E; 3]) -> u32 {
        let both = axes(|k| lo[k].le(self.hi[k]) & self.lo[k].le(hi[k]));
        (both[0] & both[1] & both[2]).bits()
    }
}
