//! The triangles of a small scene, every one of which is tested: roughly, and exactly where that leaves doubt.

use super::block::keep_triangle;
use super::interval::{Interval, Segments};
use super::node::Planes;
use super::pairs::{Facet, Met, Pairs};
use super::tree::common_octant;
use crate::geometry::{Edges, Hit, MISS, RaySetup, Rows, SharedEdge, first_of_pair, second_of_pair};
use crate::lane::array::{from_fn, map};
use crate::lane::{Bits, Mask, Real, axes};

/// Any-hit packets whose [segments](Segments) are about one of this many pairs of triangles, or fewer, are tested exactly against
/// those. Found by measuring.
const FEW: usize = 3;

/// What is known of a packet as a whole.
#[derive(Clone, Copy)]
enum Around<'a, E: Real> {
    Nothing,
    Rays(&'a Interval<E>),
    Pairs(Met),
}

impl<E: Real> Around<'_, E> {
    /// Of the boxes of the eight pairs from 8·`k` on those that some lane may enter before `t_max`, as bits.
    #[inline(always)]
    fn entered(self, k: usize, planes: &Planes, t_max: f32) -> u32 {
        match self {
            Around::Nothing => 0xff,
            Around::Rays(interval) => interval.entered(planes, t_max),
            Around::Pairs(met) => met.of_eight(k),
        }
    }
}

/// The triangles of a small scene, in order.
#[derive(Clone, Debug, Default)]
pub struct TriangleList {
    pairs: Pairs,
    /// The own boxes once more, for lanes to fetch: lower corner, upper corner, two fillers.
    boxes: Rows<8>,
}

impl TriangleList {
    pub fn new(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let pairs = Pairs::new(&triangles.collect::<Vec<_>>());
        let facets = pairs.list.iter().flat_map(|pair| &pair.facets[..1 + usize::from(pair.both)]);
        let boxes = facets.map(Facet::bounds).map(|[lo, hi]| [lo[0], lo[1], lo[2], hi[0], hi[1], hi[2], 0.0, 0.0]);
        let boxes = Rows::new(&boxes.collect::<Vec<_>>());
        Self { pairs, boxes }
    }

    pub fn bytes(&self) -> usize {
        self.pairs.bytes() + self.boxes.bytes()
    }

    /// Where lanes of `found` enter the own boxes of their triangles, and whether they do.
    #[inline(always)]
    fn enter<R: Real>(&self, setup: &RaySetup<R>, primitive: R::Bits, found: R::Mask) -> (R::Mask, R) {
        let [lx, ly, lz, hx, hy, hz, ..] = self.boxes.fetch::<R>(primitive, found);
        let (t_near, t_far) = setup.slab([lx, ly, lz], [hx, hy, hz]);
        (found & t_near.le(t_far), t_near)
    }

    /// Rays that go into the same octant are tested exactly, against the few triangles that their bounds meet. Of others
    /// own boxes are looked at once, for the winners: where the winner of the bare distances passes its box and lies
    /// behind the box's front, it is the winner of the exact test too, since that only ever removes hits or moves them
    /// away. The few other lanes are done again, exactly.
    #[inline(always)]
    pub fn closest<R: Real>(&self, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        if let Some(interval) = bounds(setup, active) {
            return self.closest_exact(setup, Around::Rays(&interval), active, hit);
        }
        let one = R::Bits::splat(1);
        let mut best = hit.t.to_bits() - one;
        let (mut primitive, mut weights, mut sum) = (R::Bits::splat(MISS), [R::zero(); 2], R::one());
        let low = self.pairs.sieve(setup, None, |sifted| {
            // In order of their index, so that the lower keeps a tie.
            let closer = sifted.key.lt(best);
            best = R::Bits::select(closer, sifted.key, best);
            primitive = R::Bits::select(closer, R::Bits::splat(sifted.index), primitive);
            weights = from_fn(|k| R::select(closer, sifted.weights[k], weights[k]));
            sum = R::select(closer, sifted.sum, sum);
        });
        let (u, v) = Edges::normalised(weights, sum);
        let best = Hit { t: R::from_bits(best + one), primitive, u, v };
        let found = best.valid() & active;
        let (enters, t_near) = self.enter(setup, primitive, found);
        let doubtful = (active & is_set::<R>(low)) | (found & !(enters & t_near.le(best.t)));
        if doubtful.any() {
            self.closest_exact(setup, Around::Nothing, doubtful, hit);
        }
        hit.replace(found & !doubtful, best);
    }

    #[inline(never)]
    fn closest_exact<R: Real>(
        &self,
        setup: &RaySetup<R>,
        around: Around<'_, R::Eight>,
        active: R::Mask,
        hit: &mut Hit<R>,
    ) {
        let t_max = hit.t;
        self.visit_exact(setup, around, t_max, active, |i, edges, mask, t| {
            keep_triangle((edges, mask, t), i, t_max, hit);
            false
        });
    }

    /// Lanes of `active` with a hit before `t_max`. A packet that is somewhere in particular, or goes into one octant, is
    /// tested exactly, against the few triangles about its segments or ahead of it. Others are sieved, by the triangles about
    /// their segments, and as in [`TriangleList::closest`] the own box of one hit is looked at.
    #[inline(always)]
    pub fn any<R: Real>(&self, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        let mut met = None;
        if R::WIDTH > 1 {
            if (active & !t_max.is_finite()).none() {
                let segments = Segments::<R::Eight>::new(setup, t_max, active);
                met = self.pairs.met(|planes| segments.meet(planes));
                if let Some(met) = met.filter(|met| met.count() * FEW <= self.pairs.list.len()) {
                    return self.any_exact(setup, Around::Pairs(met), t_max, active);
                }
            }
            if let Some(interval) = Interval::new(setup, common_octant(setup, active), active) {
                return self.any_exact(setup, Around::Rays(&interval), t_max, active);
            }
        }
        let end = t_max.to_bits() - R::Bits::splat(1);
        let mut primitive = R::Bits::splat(MISS);
        let low = self.pairs.sieve(setup, met, |sifted| {
            primitive = R::Bits::select(sifted.key.lt(end), R::Bits::splat(sifted.index), primitive);
        });
        let found = active & !primitive.eq(R::Bits::splat(MISS));
        let (enters, t_near) = self.enter(setup, primitive, found);
        let sure = enters & t_near.lt(t_max);
        let doubtful = (found | (active & is_set::<R>(low))) & !sure;
        if doubtful.none() {
            return sure;
        }
        sure | self.any_exact(setup, met.map_or(Around::Nothing, Around::Pairs), t_max, doubtful)
    }

    #[inline(never)]
    fn any_exact<R: Real>(
        &self,
        setup: &RaySetup<R>,
        around: Around<'_, R::Eight>,
        t_max: R,
        active: R::Mask,
    ) -> R::Mask {
        let mut open = active;
        self.visit_exact(setup, around, t_max, active, |_, _, mask, t| {
            open = open & !(mask & t.lt(t_max));
            open.none()
        });
        active & !open
    }

    /// Calls `visit` with each triangle's index, its edge test, and the lanes it is hit in and where, in order, until it
    /// returns true; not with triangles that no lane hits.
    #[inline(always)]
    fn visit_exact<R: Real>(
        &self,
        setup: &RaySetup<R>,
        around: Around<'_, R::Eight>,
        t_max: R,
        active: R::Mask,
        mut visit: impl FnMut(u32, Edges<R>, R::Mask, R) -> bool,
    ) {
        let farthest = R::select(active, t_max, R::zero()).highest();
        self.pairs.visit_met(
            |k, planes| around.entered(k, planes, farthest),
            |pair| {
                let v0 = axes(|k| R::splat(pair.vertices[0][k]));
                let moved = |i: usize| setup.shear.apply(axes(|k| R::lookup4(&pair.vertices[i], setup.order[k])));
                let (p, r) = (moved(0), moved(2));
                let shared = SharedEdge::new(p, r);
                for (k, facet) in pair.facets[..1 + usize::from(pair.both)].iter().enumerate() {
                    let edges = match k {
                        0 => first_of_pair(p, moved(1), r, shared, active),
                        _ => second_of_pair(p, r, moved(3), shared, active),
                    };
                    let (mask, t) = facet.distances(&edges, setup, v0);
                    if mask.none() {
                        continue;
                    }
                    let (lo, hi) = (map(facet.bounds()[0], R::splat), map(facet.bounds()[1], R::splat));
                    let (t_near, t_far) = setup.slab(lo, hi);
                    if visit(pair.first + k as u32, edges, mask & t_near.le(t_far), t_near.max_or(t)) {
                        return true;
                    }
                }
                false
            },
        );
    }
}

/// Bounds of the packet, where its lanes go into the same octant. Alone, a ray has none: a scalar test of a box for each
/// pair is no gain.
#[inline(always)]
fn bounds<R: Real>(setup: &RaySetup<R>, active: R::Mask) -> Option<Interval<R::Eight>> {
    if R::WIDTH == 1 { None } else { Interval::new(setup, common_octant(setup, active), active) }
}

/// Lanes with the sign bit set.
#[inline(always)]
fn is_set<R: Real>(word: R::Bits) -> R::Mask {
    !word.lt(R::Bits::splat(1 << 31))
}
