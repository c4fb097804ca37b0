//! The rays of a [`Stream`](super::Stream) that are in flight, and their stacks.

use super::best::Best;
use super::lanes::Lanes;
use super::leaf::EdgeValues;
use super::lists::{Chosen, Lists};
use super::node::Child;
use super::tree::STACK;
use super::visits::Visits;
use crate::geometry::{Ray, RaySetup};
use crate::lane::{Mask, Real};
use std::cell::RefCell;

/// Rays in flight at most. Found by measuring, with 64 and 96.
pub const RAYS: usize = 128;

/// Rays as bits.
pub type Rays = u128;

/// Places below every stack whose entries are always open and lead to [`Child::DONE`], so that there is always one to
/// take.
pub const FLOOR: usize = 8;

/// Places of one ray's stack.
const PLACES: usize = FLOOR + STACK;

/// Primitives between whose edges rays passed in the blocks where they are.
pub struct Candidates {
    /// Of each block.
    pub edges: [EdgeValues; RAYS],
    /// 8 times the ray's and block's place in the list of blocks, and the place in the block. There is room for a
    /// register past all.
    pub words: [u32; 8 * RAYS + 8],
}

impl Candidates {
    /// The place in the list of blocks, and the place in the block.
    #[inline(always)]
    pub fn at(&self, at: usize) -> (usize, usize) {
        let word = self.words[at] as usize;
        (word / 8 % RAYS, word % 8)
    }
}

/// Children still to visit, the stacks of all rays one after another.
pub struct Stacks {
    pub t_near: [f32; RAYS * PLACES],
    pub child: [u32; RAYS * PLACES],
}

/// The rays in flight.
#[repr(C, align(64))]
pub struct Flight {
    pub lanes: Lanes<RAYS>,
    pub best: Best,
    /// First free place of each ray's stack.
    pub top: [u32; RAYS],
    pub candidates: Candidates,
    pub lists: Lists,
    pub chosen: Chosen,
    pub visits: Visits,
    pub stacks: Stacks,
    /// Have the stacks their floors? Nothing is ever written there again.
    floored: bool,
}

thread_local! {
    // Too large to clear for every packet, and what a walk leaves behind is never read. On the heap: each thread of the process
    // would have its own, written when it begins, whether it traces or not.
    pub static FLIGHT: RefCell<Box<Flight>> = RefCell::new(Box::new(Flight {
        lanes: Lanes::ZERO,
        best: Best::NONE,
        lists: Lists::EMPTY,
        chosen: Chosen::NONE,
        visits: Visits::NONE,
        top: [0; RAYS],
        candidates: Candidates { edges: [EdgeValues::ZERO; RAYS], words: [0; 8 * RAYS + 8] },
        stacks: Stacks { t_near: [0.0; RAYS * PLACES], child: [0; RAYS * PLACES] },
        floored: false,
    }));
}

impl Flight {
    /// Lays out the packet of rays `first` …, for any hits.
    #[inline(always)]
    pub fn for_any<R: Real>(&mut self, first: usize, setup: &RaySetup<R>, t_max: R) {
        self.lanes.set(first, setup, t_max);
    }

    /// Lays out the packet of rays `first` …, none of which has hit anything, for closest hits.
    #[inline(always)]
    pub fn for_closest<R: Real>(&mut self, first: usize, setup: &RaySetup<R>, t_max: R) {
        self.lanes.set(first, setup, t_max);
        self.best.miss(first, t_max);
        self.empty_stacks(first, R::WIDTH);
    }

    /// Of `count` rays from `first` on.
    #[inline(always)]
    pub fn empty_stacks(&mut self, first: usize, count: usize) {
        if !self.floored {
            self.lay_floors();
        }
        for (i, top) in self.top.iter_mut().enumerate().skip(first).take(count) {
            *top = (i * PLACES + FLOOR) as u32;
        }
    }

    #[cold]
    fn lay_floors(&mut self) {
        for i in 0..RAYS {
            self.stacks.t_near[i * PLACES..][..FLOOR].fill(f32::NEG_INFINITY);
            self.stacks.child[i * PLACES..][..FLOOR].fill(Child::DONE.0);
        }
        self.floored = true;
    }
}

/// Lays out packets by [`Flight::for_closest`] or [`Flight::for_any`]; their live lanes as bits.
#[inline(always)]
pub fn board<R: Real>(
    flight: &mut Flight,
    rays: &[Ray<R>],
    active: &[R::Mask],
    lay_out: impl Fn(&mut Flight, usize, &RaySetup<R>, R),
) -> Rays {
    let mut bits = 0;
    for (k, (ray, active)) in rays.iter().zip(active).enumerate() {
        let first = k * R::WIDTH;
        lay_out(flight, first, &RaySetup::new(ray), ray.t_max);
        bits |= Rays::from((*active & ray.usable()).bits()) << first;
    }
    bits
}

/// Those of packet `k`.
#[inline(always)]
pub fn packet_of<R: Real>(bits: Rays, k: usize) -> R::Mask {
    R::Mask::from_bits((bits >> (k * R::WIDTH)) as u32 & (u32::MAX >> (32 - R::WIDTH)))
}
