//! The rays of a [`Stream`](super::Stream) that are in flight, and their stacks.

use super::lanes::Lanes;
use super::node::Child;
use super::tree::{OneHit, STACK};
use crate::geometry::{MISS, Ray, RaySetup};
use crate::lane::{Mask, Real};
use std::cell::RefCell;

/// Rays in flight at most.
pub const RAYS: usize = 64;

/// Places below every stack whose entries are always open and lead nowhere, so that there is always one to take.
pub const FLOOR: usize = 8;

/// Children that a ray may be [given](Flight::give) before it sets out.
const GIVEN: usize = 64;

/// Children still to visit, for each ray.
pub struct Stacks {
    pub t_near: [[f32; FLOOR + GIVEN + STACK]; RAYS],
    pub child: [[u32; FLOOR + GIVEN + STACK]; RAYS],
}

/// The rays in flight.
#[repr(C, align(64))]
pub struct Flight {
    pub lanes: Lanes<RAYS>,
    pub best: [OneHit; RAYS],
    /// First free place of each ray's stack.
    pub top: [u32; RAYS],
    pub stacks: Stacks,
}

const NO_HIT: OneHit = OneHit { t: 0.0, primitive: MISS, u: 0.0, v: 0.0 };

thread_local! {
    // Too large to clear for every packet, and what a walk leaves behind is never read.
    pub static FLIGHT: RefCell<Flight> = const {
        RefCell::new(Flight {
            lanes: Lanes::ZERO,
            best: [NO_HIT; RAYS],
            top: [FLOOR as u32; RAYS],
            stacks: Stacks {
                t_near: [[0.0; FLOOR + GIVEN + STACK]; RAYS],
                child: [[0; FLOOR + GIVEN + STACK]; RAYS],
            },
        })
    };
}

impl Flight {
    /// Lays out the packet of rays `first` …, none of which has hit anything or been given a child.
    #[inline(always)]
    pub fn board<R: Real>(&mut self, first: usize, setup: &RaySetup<R>, t_max: R) {
        self.lanes.set(first, setup, t_max);
        let t = self.lanes.t_max;
        for i in first..first + R::WIDTH {
            self.best[i % RAYS] = OneHit { t: t[i % RAYS], ..NO_HIT };
        }
        self.empty_stacks(first, R::WIDTH);
    }

    /// Of `count` rays from `first` on.
    #[inline(always)]
    pub fn empty_stacks(&mut self, first: usize, count: usize) {
        for i in first..first + count {
            self.stacks.t_near[i][..FLOOR].fill(f32::NEG_INFINITY);
            self.stacks.child[i][..FLOOR].fill(Child::NONE.0);
            self.top[i] = FLOOR as u32;
        }
    }

    /// Leaves `child` to each of the rays `first` + `bits`, on which they will find it. False, and nothing done, where
    /// one has been given as many as it can take.
    #[inline(always)]
    pub fn give(&mut self, first: usize, bits: u32, child: Child) -> bool {
        let rays = || super::lanes::ones(bits).map(|lane| (first + lane) % RAYS);
        if rays().any(|i| self.top[i] as usize >= FLOOR + GIVEN) {
            return false;
        }
        for i in rays() {
            let top = self.top[i] as usize;
            // Open whatever is hit before.
            self.stacks.t_near[i][top] = 0.0;
            self.stacks.child[i][top] = child.0;
            self.top[i] = top as u32 + 1;
        }
        true
    }
}

/// Lays out packets; their live lanes as bits.
#[inline(always)]
pub fn board<R: Real>(flight: &mut Flight, rays: &[Ray<R>], active: &[R::Mask]) -> u64 {
    let mut bits = 0;
    for (k, (ray, active)) in rays.iter().zip(active).enumerate() {
        let first = k * R::WIDTH;
        flight.board(first, &RaySetup::new(ray), ray.t_max);
        bits |= u64::from((*active & ray.usable()).bits()) << first;
    }
    bits
}
