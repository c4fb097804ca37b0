//! Packets that go the same way, through the tree as one (Overbeck, Ramamoorthi, Mark 2008, "Large Ray Packets for
//! Real-time Whitted Ray Tracing"): what is bounded for all of their rays at once costs no more than for one packet's. Of a
//! far tree's small triangles each packet meets others: there each goes on its own, and where the tree lies in memory, a step
//! in turn, so that what one needs next is fetched while the others move.

use super::block::{TriangleBlock, better};
use super::interval::Interval;
use super::lanes::ones;
use super::leaf::Leaf;
use super::node::{Child, Planes};
use super::tree::{Block, STACK, Tree};
use crate::geometry::slab::slab;
use crate::geometry::{Edges, Hit, MISS, RaySetup, Shear, edges};
use crate::lane::array::{from_fn, map};
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, axes};
use std::cell::RefCell;

/// Packets that go together, or side by side, at most. Found by measuring, with 2.
pub const PACKETS: usize = 4;

/// Triangles of a block times packets.
const CANDIDATES: usize = 8 * PACKETS;

/// What a walk works on: kept from one to the next because it would take longer to clear than to use.
#[repr(C, align(64))]
struct Scratch {
    stacks: [Stack; PACKETS],
    candidates: Candidates,
}

/// Children still to visit.
struct Stack {
    t_near: [f32; STACK],
    child: [u32; STACK],
}

/// Triangles of a block that some lanes of a packet pass between the edges of.
struct Candidates {
    /// Weights of vertices 1 and 2 and the sum of all three, by candidate and lane.
    values: [[[f32; MAX_WIDTH]; 3]; CANDIDATES],
    /// Lanes that pass.
    lanes: [u32; CANDIDATES],
    /// [`PACKETS`] times the place in the block, and the packet.
    which: [u32; CANDIDATES],
    /// Of the block's triangles.
    own_boxes: Planes,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = const {
        RefCell::new(Scratch {
            stacks: [const { Stack { t_near: [0.0; STACK], child: [0; STACK] } }; PACKETS],
            candidates: Candidates {
                values: [[[0.0; MAX_WIDTH]; 3]; CANDIDATES],
                lanes: [0; CANDIDATES],
                which: [0; CANDIDATES],
                own_boxes: [[0.0; 16]; 3],
            },
        })
    };
}

/// The best hits of a packet so far, not yet divided.
#[derive(Clone, Copy)]
struct Best<R: Real> {
    t: R,
    primitive: R::Bits,
    /// Weights of vertices 1 and 2, and the sum of all three.
    weights: [R; 2],
    sum: R,
}

/// `N` packets that go into one octant, along the same longest axis.
#[derive(Clone, Copy)]
pub struct Group<'a, R: Real, const N: usize> {
    setups: &'a [RaySetup<R>; N],
    active: [R::Mask; N],
    interval: Interval<R::Eight>,
    /// Where all rays start, if it is one point: in the order of axes.
    origin: Option<[f32; 3]>,
    /// [`RaySetup::order`].
    order: [usize; 3],
    /// 1 where the direction is negative, by axis.
    negative: [usize; 3],
}

impl<'a, R: Real, const N: usize> Group<'a, R, N> {
    /// `None` where they do not go together, or none is active.
    #[inline(always)]
    pub fn new(setups: &'a [RaySetup<R>; N], active: [R::Mask; N]) -> Option<Self> {
        let (leader, lane) = leader(&active)?;
        let order: [u32; 3] = axes(|k| setups[leader].order[k].lane(lane));
        let negative: [bool; 3] = axes(|k| setups[leader].negative[k].lane(lane));
        let mut same = true;
        for (setup, active) in setups.iter().zip(&active) {
            // Two axes leave one.
            let orders = (0..2).map(|k| setup.order[k].eq(R::Bits::splat(order[k])));
            let signs = (0..3).map(|k| !(setup.negative[k] ^ R::Mask::splat(negative[k])));
            let agree = orders.chain(signs).fold(*active, |all, mask| all & mask);
            same &= agree.bits() == active.bits();
        }
        let negative = axes(|k| usize::from(negative[k]));
        let interval = if same { Interval::around(setups, &active, negative) } else { None };
        let interval = interval?;
        let order = axes(|k| order[k] as usize % 3);
        let origin = interval.origin().map(|origin| axes(|k| origin[order[k]]));
        Some(Self { setups, active, interval, origin, order, negative })
    }

    /// The closest hits; of lanes that are not active a miss at 0.
    #[inline(always)]
    pub fn closest(&self, tree: &Tree<TriangleBlock>, t_max: [R; N]) -> [Hit<R>; N] {
        SCRATCH.with_borrow_mut(|Scratch { stacks: [stack, ..], candidates }| {
            let mut best = self.misses(t_max);
            let mut t_best = farthest(&best);
            let mut len = stack.begin(tree.root);
            while let Some(last) = len.checked_sub(1) {
                len = self.visit(tree, stack, last, candidates, &mut best, &mut t_best);
            }
            map(best, Best::hit)
        })
    }

    #[inline(always)]
    fn misses(&self, t_max: [R; N]) -> [Best<R>; N] {
        // Nothing is nearer than 0.
        from_fn(|p| Best::miss(t_max[p].masked(self.active[p])))
    }

    /// Visits the child at `at`, the last on the stack; how many are on it then.
    ///
    /// By the bounds of the group alone: of rays so close nearly all enter what their bounds enter, and a test of each lane
    /// costs more than it spares.
    #[inline(always)]
    fn visit(
        &self,
        tree: &Tree<TriangleBlock>,
        stack: &mut Stack,
        at: usize,
        candidates: &mut Candidates,
        best: &mut [Best<R>; N],
        t_best: &mut f32,
    ) -> usize {
        let child = Child(stack.child[at]);
        if stack.t_near[at] > *t_best {
            return at;
        }
        if child.is_leaf() {
            let block = &tree.blocks[child.index()];
            let count = self.find(block, candidates, *t_best);
            if count > 0 {
                self.meet(block, candidates, count, best);
                *t_best = farthest(best);
            }
            return at;
        }
        let (bits, t_near, words) = self.interval.children(&tree.nodes[child.index()], *t_best);
        t_near.compress(bits).store(&mut stack.t_near[at..]);
        <R::Eight as Real>::from_bits(words).compress(bits).to_bits().store(&mut stack.child[at..]);
        let len = at + bits.count_ones() as usize;
        if tree.far {
            // The nearest child is next, unless other packets come first.
            let end = if tree.in_memory { len } else { len.max(at + 1) - 1 };
            stack.child[at..end].iter().for_each(|word| tree.prefetch(Child(*word)));
        }
        len
    }

    /// Lists the block's triangles that some packet passes between the edges of; how many.
    #[inline(always)]
    fn find(&self, block: &TriangleBlock, candidates: &mut Candidates, t_best: f32) -> usize {
        let places = block.places(Some(&self.interval), t_best);
        if places == 0 {
            return 0;
        }
        block.own_boxes::<R::Eight>(&mut candidates.own_boxes);
        if let Some(origin) = self.origin {
            // Of rays with one origin eight triangles are moved there at once, not each for every lane.
            let mut moved = [[[0.0; 8]; 3]; 3];
            block.moved::<R::Eight>(self.order, origin, &mut moved);
            self.pass(places, candidates, |setup, place| {
                let shear = Shear { origin: [R::zero(); 3], scale: setup.shear.scale };
                edges(&shear, axes(|v| axes(|k| R::splat(moved[v][k][place]))), R::Mask::splat(true))
            })
        } else {
            self.pass(places, candidates, |setup, place| {
                edges(&setup.shear, block.splat(self.order, place), R::Mask::splat(true))
            })
        }
    }

    /// Lists those of `places` that some packet passes between the edges of; how many.
    #[inline(always)]
    fn pass(&self, places: u32, candidates: &mut Candidates, edges: impl Fn(&RaySetup<R>, usize) -> Edges<R>) -> usize {
        // Which lanes pass is anybody's guess: no branch on it.
        let mut len = 0;
        for place in ones(places) {
            let place = place % 8;
            for (p, setup) in self.setups.iter().enumerate() {
                let edges = edges(setup, place);
                let at = len % CANDIDATES;
                let [w1, w2, sum] = &mut candidates.values[at];
                edges.weights[0].store(w1);
                edges.weights[1].store(w2);
                edges.sum.store(sum);
                let lanes = (edges.inside & self.active[p]).bits();
                candidates.lanes[at] = lanes;
                candidates.which[at] = (place * PACKETS + p) as u32;
                len += usize::from(lanes != 0);
            }
        }
        len
    }

    /// Meets the first `count` candidates.
    #[inline(always)]
    fn meet(&self, block: &TriangleBlock, candidates: &Candidates, count: usize, best: &mut [Best<R>; N]) {
        let mut normals = [[0.0; 8]; 4];
        block.normals::<R::Eight>(&mut normals);
        for k in 0..count {
            let k = k % CANDIDATES;
            let which = candidates.which[k] as usize;
            let (place, p) = (which / PACKETS % 8, which % PACKETS % N);
            let setup = &self.setups[p];
            let v0 = axes(|axis| block.splat_one(0, axis, place));
            let depths = axes(|vertex| block.splat_one::<R>(vertex, self.order[2], place) - setup.shear.origin[2]);
            let [w1, w2, sum] = axes(|i| R::load(&candidates.values[k][i]));
            let mut edges = Edges::passed([w1, w2], sum, depths);
            edges.inside = R::Mask::from_bits(candidates.lanes[k]);
            let normal = axes(|axis| R::splat(normals[axis][place]));
            let (hits, t) = edges.distances(setup, v0, normal, R::splat(normals[3][place]));
            let plane = |axis: usize, upper: usize| R::splat(candidates.own_boxes[axis][8 * upper + place]);
            let near = axes(|axis| plane(axis, self.negative[axis]));
            let far = axes(|axis| plane(axis, 1 - self.negative[axis]));
            let (t_near, t_far) = slab(near, far, setup.origin, setup.inverse);
            let primitive = R::Bits::splat(block.id(place));
            best[p].keep(hits & t_near.le(t_far), Best { t: t_near.max_or(t), primitive, weights: [w1, w2], sum });
        }
    }
}

/// The closest hits of packets that have a group each, a step of each in turn; what is given for others means nothing.
#[inline(always)]
pub fn side_by_side<R: Real, const N: usize>(
    groups: &[Option<Group<R, 1>>; N],
    tree: &Tree<TriangleBlock>,
    t_max: [R; N],
) -> [Hit<R>; N] {
    SCRATCH.with_borrow_mut(|Scratch { stacks, candidates }| {
        let mut best: [[Best<R>; 1]; N] =
            from_fn(|p| groups[p].as_ref().map_or([Best::miss(R::zero())], |group| group.misses([t_max[p]])));
        let mut t_best: [f32; N] = from_fn(|p| farthest(&best[p]));
        let mut len: [usize; N] = from_fn(|p| if groups[p].is_some() { stacks[p].begin(tree.root) } else { 0 });
        while len != [0; N] {
            for (p, group) in groups.iter().enumerate() {
                if let (Some(group), Some(last)) = (group, len[p].checked_sub(1)) {
                    len[p] = group.visit(tree, &mut stacks[p], last, candidates, &mut best[p], &mut t_best[p]);
                }
            }
        }
        from_fn(|p| best[p][0].hit())
    })
}

impl Stack {
    /// With the root alone on it, if there is one: how many are.
    #[inline(always)]
    fn begin(&mut self, root: Child) -> usize {
        (self.t_near[0], self.child[0]) = (0.0, root.0);
        usize::from(root != Child::NONE)
    }
}

impl<R: Real> Best<R> {
    #[inline(always)]
    fn miss(t: R) -> Self {
        Self { t, primitive: R::Bits::splat(MISS), weights: [R::zero(); 2], sum: R::one() }
    }

    #[inline(always)]
    fn hit(self) -> Hit<R> {
        let (u, v) = Edges::normalised(self.weights, self.sum);
        Hit { t: self.t, primitive: self.primitive, u, v }
    }

    /// Takes the lanes of `hits` that are nearer, or as near and of a lower primitive.
    #[inline(always)]
    fn keep(&mut self, hits: R::Mask, found: Self) {
        let wins = hits & better(found.t, found.primitive, self.t, self.primitive);
        self.t = R::select(wins, found.t, self.t);
        self.primitive = R::Bits::select(wins, found.primitive, self.primitive);
        self.weights = from_fn(|i| R::select(wins, found.weights[i], self.weights[i]));
        self.sum = R::select(wins, found.sum, self.sum);
    }
}

/// The first active packet and lane.
#[inline(always)]
fn leader<M: Mask>(active: &[M]) -> Option<(usize, usize)> {
    let packet = active.iter().position(|mask| mask.any())?;
    Some((packet, active[packet].bits().trailing_zeros() as usize % MAX_WIDTH))
}

/// Up to where some lane looks for hits.
#[inline(always)]
fn farthest<R: Real, const N: usize>(best: &[Best<R>; N]) -> f32 {
    best.iter().fold(R::zero(), |t, best| best.t.max_or(t)).highest()
}
