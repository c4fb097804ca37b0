//! Lanes that wait for company: what a packet leaves partly empty is gathered here until it fills one.

use crate::lane::{Mask, Real};
use core::marker::PhantomData;

/// Rows of `N` values, one field after the other in memory, so that a packet of them is `N` loads.
pub struct Queue<R, const N: usize> {
    fields: Vec<f32>,
    /// From one field to the next.
    stride: usize,
    len: usize,
    lanes: PhantomData<R>,
}

impl<R: Real, const N: usize> Queue<R, N> {
    /// Empty, with room for `rows`.
    pub fn new(rows: usize) -> Self {
        // Whole registers are written and read past the last row.
        let stride = rows + R::WIDTH;
        Queue { fields: vec![0.0; N * stride], stride, len: 0, lanes: PhantomData }
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends the lanes of `mask`, in order. Panics where there is no room.
    #[inline(always)]
    pub fn push(&mut self, mask: R::Mask, row: &[R; N]) {
        let bits = mask.bits();
        for (field, value) in row.iter().enumerate() {
            value.compress(bits).store(&mut self.fields[field * self.stride..][..self.stride][self.len..]);
        }
        self.len += bits.count_ones() as usize;
    }

    /// The packet of rows from `first` on, and which of its lanes are rows.
    #[inline(always)]
    pub fn packet(&self, first: usize) -> ([R; N], R::Mask) {
        let row = crate::lane::array::from_fn(|field| R::load(&self.fields[field * self.stride + first..]));
        (row, first_lanes::<R>(self.len - first))
    }

    /// Takes the last rows, as many as make a packet.
    #[inline(always)]
    pub fn pop(&mut self) -> ([R; N], R::Mask) {
        let first = self.len.saturating_sub(R::WIDTH);
        let packet = self.packet(first);
        self.len = first;
        packet
    }
}

#[inline(always)]
fn first_lanes<R: Real>(count: usize) -> R::Mask {
    R::Mask::from_bits(((1u64 << count.min(R::WIDTH)) - 1) as u32)
}
