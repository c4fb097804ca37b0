//! Which rays of a [`Stream`](super::Stream) are at what.

use super::flight::RAYS;

/// Rays by the [kind](Child::kind) of what they go to next: nodes to be tested, blocks to be tested, a child to be found,
/// nothing more.
pub struct Lists([u8; 4 * RAYS]);

/// How long the lists are, a byte each: in one word, which stays in a register.
#[derive(Clone, Copy, Default)]
pub struct Counts(u32);

pub const NODES: u32 = 0;
pub const BLOCKS: u32 = 1;
pub const POPS: u32 = 2;

impl Counts {
    /// How many are in the list of `kind`, which is empty thereafter: what is pushed while it is read overwrites what was
    /// read, since no list overtakes its reader.
    #[inline(always)]
    pub fn take(&mut self, kind: u32) -> usize {
        let count = self.0 >> (8 * kind) & 0xff;
        self.0 &= !(0xff << (8 * kind));
        count as usize
    }
    /// Are all rays done?
    #[inline(always)]
    pub fn none(self) -> bool {
        self.0 << 8 == 0
    }
}

impl Lists {
    pub const EMPTY: Self = Self([0; 4 * RAYS]);

    #[inline(always)]
    pub fn push(&mut self, counts: &mut Counts, ray: usize, kind: u32) {
        let shift = 8 * (kind & 3);
        let place = RAYS as u32 * (kind & 3) + (counts.0 >> shift & (RAYS as u32 - 1));
        self.0[place as usize] = ray as u8;
        counts.0 += 1 << shift;
    }
    #[inline(always)]
    pub fn at(&self, kind: u32, k: usize) -> usize {
        self.0[kind as usize * RAYS + k % RAYS] as usize % RAYS
    }
}
