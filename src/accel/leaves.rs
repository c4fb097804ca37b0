//! Many rays at the blocks they have come to, a list of them at a time.

use super::flight::{Candidates, RAYS};
use super::lanes::Lanes;
use super::leaf::Found;
use super::lists::ROOM;
use super::node::Child;
use super::tree::{Block, OneHit, Tree};
use crate::geometry::{Hit, RaySetup};
use crate::lane::array::{from_fn, map};
use crate::lane::{Bits, Real};
use core::hint::select_unpredictable;

/// Fewer candidates than this are met one after another, more side by side. Found by measuring.
const FEW: usize = 4;

/// Is told of candidates: the rays, and how they hit; at [`OneHit::NEVER`] where they do not. Domain of `eight`: eight lanes
/// (rays of one lane go [one at a time](super::Single)).
pub trait Keep {
    fn eight<E: Real>(&mut self, rays: [usize; 8], found: Hit<E>);
    fn one(&mut self, ray: usize, found: OneHit);
}

/// Rays and the block of `tree` that each is at.
pub struct Leaves<'a, B> {
    pub tree: &'a Tree<B>,
    pub rays: &'a [u32; ROOM],
    pub children: &'a [u32; ROOM],
}

impl<'a, B: Block> Leaves<'a, B> {
    #[inline(always)]
    fn ray(&self, k: usize) -> usize {
        self.rays[k % RAYS] as usize % RAYS
    }
    #[inline(always)]
    fn block(&self, k: usize) -> &'a B {
        &self.tree.blocks[Child(self.children[k % RAYS]).index()]
    }

    /// Lists as candidates what the first `count` rays may hit; how many.
    #[inline(always)]
    pub fn edges<E: Real>(&self, count: usize, lanes: &Lanes<RAYS>, found: &mut Candidates) -> usize {
        let mut passed = [0u32; RAYS];
        let (rays, children, edges) = (&self.rays[..count], &self.children[..count], &mut found.edges[..count]);
        for k in 0..count {
            let block = &self.tree.blocks[Child(children[k]).index()];
            passed[k] = block.passed(&lanes.ray::<E>(rays[k] as usize % RAYS), &mut edges[k]);
        }
        let places = E::Bits::load(&[0, 1, 2, 3, 4, 5, 6, 7]);
        let mut len = 0;
        for (k, bits) in passed[..count].iter().enumerate() {
            let all = E::from_bits(places + E::Bits::splat(8 * k as u32));
            all.compress(*bits).to_bits().store(&mut found.words[len..]);
            len += bits.count_ones() as usize;
        }
        // Past the end stands the last again: a hit twice changes nothing.
        if len > 0 {
            E::Bits::splat(found.words[len - 1]).store(&mut found.words[len..]);
        }
        len
    }

    /// Meets the first `len` candidates.
    #[inline(always)]
    pub fn meet<E: Real>(&self, len: usize, lanes: &Lanes<RAYS>, found: &Candidates, keep: &mut impl Keep) {
        let eights = if len % 8 < FEW { len - len % 8 } else { len };
        for first in (0..eights).step_by(8) {
            self.meet_eight::<E>(first, lanes, found, keep);
        }
        for at in eights..len {
            let (k, place) = found.at(at);
            let i = self.ray(k);
            let (hit, found) = self.block(k).meet_one(place, &lanes.ray(i), &found.edges[k]);
            keep.one(i, OneHit { t: select_unpredictable(hit, found.t, OneHit::NEVER), ..found });
        }
    }

    /// Meets eight candidates from `first` on.
    #[inline(always)]
    fn meet_eight<E: Real>(&self, first: usize, lanes: &Lanes<RAYS>, found: &Candidates, keep: &mut impl Keep) {
        let eight: [_; 8] = from_fn(|l| found.at(first + l));
        let i = map(eight, |(k, _)| self.ray(k));
        let ray = lanes.gather::<E>(i);
        let blocks = map(eight, |(k, _)| self.block(k));
        let places = map(eight, |(_, place)| place);
        let found = Found { blocks, places, edges: map(eight, |(k, _)| &found.edges[k]) };
        let (hits, t, u, v) = B::meet(&found, &RaySetup::new(&ray));
        let t = E::select(hits & t.lt(ray.t_max), t, E::splat(OneHit::NEVER));
        keep.eight(i, Hit { t, primitive: E::Bits::from_fn(|l| blocks[l].id(places[l])), u, v });
    }
}
