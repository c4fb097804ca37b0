//! Any hit, each ray on its own: whatever it hits ends it, so that its visits to nodes and blocks need know nothing of each
//! other, and have neither an order nor a stack for each ray.

use super::flight::{Flight, RAYS, Rays, packet_of};
use super::lanes::Lanes;
use super::leaves::{Keep, Leaves};
use super::lists::ROOM;
use super::node::Child;
use super::tree::{Block, MAX_DEPTH, OneHit, Tree};
use crate::geometry::Hit;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real};
use core::hint::select_unpredictable;

/// Nodes that are visited in one go. Found by measuring, with 32 and 128.
const TOGETHER: usize = 64;

/// Visits of a kind that may wait. Beyond that nodes are visited one at a time, so that each level of the tree leaves seven
/// more at most.
pub const MOST: usize = 4096;

/// A register is stored past the last.
const PLACES: usize = MOST + 7 * MAX_DEPTH + MAX_WIDTH;

/// Which list visits are in.
const NODES: usize = 0;
const BLOCKS: usize = 1;

/// Rays, and the child that each is to visit.
struct List {
    rays: [u32; PLACES],
    children: [u32; PLACES],
}

/// Visits to come.
pub struct Visits {
    lists: [List; 2],
    len: [usize; 2],
    /// Those that are being made.
    rays: [u32; ROOM],
    children: [u32; ROOM],
    open: Open,
}

/// 1 for each ray that has hit nothing, else 0.
struct Open([u32; RAYS]);

impl Keep for Open {
    #[inline(always)]
    fn eight<E: Real>(&mut self, rays: [usize; 8], found: Hit<E>) {
        let mut misses = [0; 8];
        found.t.to_bits().shr::<31>().store(&mut misses);
        for (i, miss) in rays.into_iter().zip(misses) {
            self.0[i] &= miss;
        }
    }

    #[inline(always)]
    fn one(&mut self, ray: usize, found: OneHit) {
        self.0[ray] &= u32::from(found.t.is_sign_negative());
    }
}

impl Visits {
    pub const NONE: Self = Self {
        lists: [const { List { rays: [0; PLACES], children: [0; PLACES] } }; 2],
        len: [0; 2],
        rays: [0; ROOM],
        children: [0; ROOM],
        open: Open([1; RAYS]),
    };

    /// The rays `first` + lanes of each entry are to visit its child: no more than [`MOST`] visits altogether.
    #[inline(always)]
    pub fn add<R: Real>(&mut self, first: usize, entries: impl Iterator<Item = (Child, u32)>) {
        let numbers = R::Bits::from_fn(|lane| lane as u32) + R::Bits::splat(first as u32);
        // Lengths in registers: each visit's place would wait for the last one's to be written.
        let [mut nodes, mut blocks] = self.len;
        for (child, lanes) in entries {
            let is_block = usize::from(child.is_leaf());
            let list = &mut self.lists[is_block];
            let place = select_unpredictable(is_block != 0, blocks, nodes);
            R::from_bits(numbers).compress(lanes).to_bits().store(&mut list.rays[place..]);
            R::Bits::splat(child.0).store(&mut list.children[place..]);
            let count = lanes.count_ones() as usize;
            blocks += count * is_block;
            nodes += count * (1 - is_block);
        }
        self.len = [nodes, blocks];
    }

    /// Takes up to `most` visits from the end of a list, less those of rays that have hit something; how many.
    #[inline(always)]
    fn take(&mut self, kind: usize, most: usize) -> usize {
        let (list, end) = (&self.lists[kind], self.len[kind]);
        let taken = end - end.min(most)..end;
        self.len[kind] = taken.start;
        let mut count = 0;
        for (ray, child) in list.rays[taken.clone()].iter().zip(&list.children[taken]) {
            self.rays[count % RAYS] = *ray;
            self.children[count % RAYS] = *child;
            count += self.open.0[*ray as usize % RAYS] as usize;
        }
        count
    }

    /// Visits to the children that the ray of visit `k`, to a node, enters.
    #[inline(always)]
    fn step<B: Block, E: Real>(&mut self, k: usize, len: &mut [usize; 2], tree: &Tree<B>, lanes: &Lanes<RAYS>) {
        let node = &tree.nodes[Child(self.children[k % RAYS]).index()];
        let i = self.rays[k % RAYS] as usize % RAYS;
        let bits = node.met(&lanes.crossing::<E>(i), E::splat(lanes.t_max[i]));
        let words = E::Bits::load(&node.children);
        let nodes = (words & E::Bits::splat(Child::LEAF)).eq(E::Bits::splat(0)).bits();
        for (list, (len, bits)) in self.lists.iter_mut().zip(len.iter_mut().zip([bits & nodes, bits & !nodes])) {
            E::from_bits(words).compress(bits).to_bits().store(&mut list.children[*len..]);
            E::Bits::splat(i as u32).store(&mut list.rays[*len..]);
            *len += bits.count_ones() as usize;
        }
    }

    /// Takes visits to nodes and makes them.
    #[inline(always)]
    fn nodes<B: Block, E: Real>(&mut self, tree: &Tree<B>, lanes: &Lanes<RAYS>) {
        let room = MOST.saturating_sub(self.len[NODES]) / 8;
        let count = self.take(NODES, room.clamp(1, TOGETHER));
        let (before, mut len) = (self.len, self.len);
        for k in 0..count {
            self.step::<B, E>(k, &mut len, tree, lanes);
        }
        self.len = len;
        if tree.far {
            let added = |kind: usize| &self.lists[kind].children[before[kind]..len[kind]];
            added(NODES).iter().for_each(|child| tree.prefetch_node(Child(*child)));
            added(BLOCKS).iter().for_each(|child| tree.prefetch_block(Child(*child)));
        }
    }
}

/// Makes the visits of the flight, and all that come of them: which rays of `bits` hit anything.
#[inline(always)]
pub fn any_of<B: Block, R: Real>(tree: &Tree<B>, flight: &mut Flight, bits: Rays) -> Rays {
    let Flight { lanes, candidates, visits, .. } = flight;
    visits.open = Open([1; RAYS]);
    while visits.len != [0; 2] {
        while visits.len[BLOCKS] > 0 {
            let count = visits.take(BLOCKS, RAYS);
            let leaves = Leaves { tree, rays: &visits.rays, children: &visits.children };
            let found = leaves.edges::<R::Eight>(count, lanes, candidates);
            leaves.meet::<R::Eight>(found, lanes, candidates, &mut visits.open);
        }
        visits.nodes::<B, R::Eight>(tree, lanes);
    }
    let mut hits = 0;
    for (k, open) in visits.open.0.chunks_exact(R::WIDTH).enumerate() {
        hits |= Rays::from(R::Bits::load(open).eq(R::Bits::splat(0)).bits()) << (k * R::WIDTH);
    }
    hits & bits
}

/// [`any_of`], from the root of the tree on.
#[inline(always)]
pub fn any_from_root<B: Block, R: Real>(tree: &Tree<B>, flight: &mut Flight, bits: Rays) -> Rays {
    if tree.root == Child::NONE {
        return 0;
    }
    for first in (0..RAYS).step_by(R::WIDTH) {
        let lanes = packet_of::<R>(bits, first / R::WIDTH).bits();
        flight.visits.add::<R>(first, core::iter::once((tree.root, lanes)));
    }
    any_of::<B, R>(tree, flight, bits)
}
