//! Which rays of a [`Stream`](super::Stream) are at what.

use super::flight::RAYS;
use super::node::Child;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real};

/// What rays go to next: nodes to be tested, blocks to be tested, a child to be found. See [`Child::kind`].
pub const NODES: usize = 0;
pub const BLOCKS: usize = 1;
pub const POPS: usize = 2;
const KINDS: usize = 3;

/// Rays and their children are listed a register at a time, whatever follows the last.
pub const ROOM: usize = RAYS + MAX_WIDTH;

/// Rays by the [kind](Child::kind) of what they go to next, and that beside each: its address then does not wait for the
/// ray's number.
pub struct Lists {
    rays: [[u32; ROOM]; KINDS],
    children: [[u32; ROOM]; KINDS],
}

/// How long the lists are.
#[derive(Clone, Copy, Default)]
pub struct Counts([usize; KINDS]);

impl Counts {
    /// How many are in the list of `kind`, which is empty thereafter: what is listed while it is read overwrites what was
    /// read, since no list overtakes its reader.
    #[inline(always)]
    pub fn take(&mut self, kind: usize) -> usize {
        core::mem::take(&mut self.0[kind])
    }
    /// Are all rays done?
    #[inline(always)]
    pub fn none(self) -> bool {
        self.0 == [0; KINDS]
    }
}

impl Lists {
    pub const EMPTY: Self = Self { rays: [[0; ROOM]; KINDS], children: [[0; ROOM]; KINDS] };

    /// Lists the rays `first` + `bits`, which all go to `child`.
    #[inline(always)]
    pub fn add<R: Real>(&mut self, counts: &mut Counts, first: usize, bits: u32, child: Child) {
        let kind = child.kind() as usize;
        let rays = R::Bits::from_fn(|lane| (first + lane) as u32);
        let place = counts.0[kind];
        R::from_bits(rays).compress(bits).to_bits().store(&mut self.rays[kind][place..]);
        R::Bits::splat(child.0).store(&mut self.children[kind][place..]);
        counts.0[kind] += bits.count_ones() as usize;
    }

    /// Lists the first `count` rays of the list of `kind`, which was [taken](Counts::take), by the `children` they now go to.
    #[inline(always)]
    pub fn sort<E: Real>(&mut self, counts: &mut Counts, kind: usize, count: usize, children: &mut Chosen) {
        // Who is past the end goes nowhere.
        E::Bits::splat(Child::DONE.0).store(&mut children.0[count..]);
        for first in (0..count).step_by(E::WIDTH) {
            let rays = E::Bits::load(&self.rays[kind][first..]);
            let words = E::Bits::load(&children.0[first..]);
            let kinds = words.shr::<30>();
            for to in 0..KINDS {
                let bits = kinds.eq(E::Bits::splat(to as u32)).bits();
                let place = counts.0[to].min(RAYS);
                E::from_bits(rays).compress(bits).to_bits().store(&mut self.rays[to][place..]);
                E::from_bits(words).compress(bits).to_bits().store(&mut self.children[to][place..]);
                counts.0[to] += bits.count_ones() as usize;
            }
        }
    }

    /// What rays go to that were listed between two counts.
    #[inline(always)]
    pub fn listed(&self, kind: usize, before: Counts, after: Counts) -> &[u32] {
        &self.children[kind][before.0[kind]..after.0[kind]]
    }
    /// The first `count` rays of a list.
    #[inline(always)]
    pub fn rays(&self, kind: usize, count: usize) -> impl Iterator<Item = usize> + '_ {
        self.rays[kind][..count].iter().map(|ray| *ray as usize % RAYS)
    }
    /// The rays of a list and their children.
    #[inline(always)]
    pub fn of(&self, kind: usize) -> (&[u32; ROOM], &[u32; ROOM]) {
        (&self.rays[kind], &self.children[kind])
    }
}

/// The children that the rays of a list go to.
pub struct Chosen([u32; ROOM]);

impl Chosen {
    pub const NONE: Self = Self([0; ROOM]);

    /// Of its first `count` rays.
    #[inline(always)]
    pub fn of(&mut self, count: usize) -> &mut [u32] {
        &mut self.0[..count]
    }
}
