//! Lanes that wait for company: what a packet leaves partly empty is gathered here until it fills one.

use crate::lane::{Mask, Real, array};
use core::marker::PhantomData;
use std::cell::RefCell;

thread_local! {
    /// Memory of queues that are gone, for those of the next job: fresh memory would be cleared each time.
    static SPARE: RefCell<Vec<Vec<f32>>> = const { RefCell::new(Vec::new()) };
}

/// Values in a line of cache.
const LINE: usize = 64 / size_of::<f32>();

/// From one field to the next in the queues of a [wave](super::wave): 35 lines of cache, an odd number, so that the fields of a
/// row fall into different sets.
pub const ROOM: usize = 560;

/// Rows of `N` values, one field after the other in memory, so that a packet of them is `N` loads. `S` values lie from one
/// field to the next: the rows and a register past the last fit into them. (It is a constant so that bounds are tested once a
/// packet, not once a field.)
pub struct Queue<R, const N: usize, const S: usize = ROOM> {
    values: Vec<f32>,
    /// Where the first field starts: packets are to start with a line of cache, and vectors are aligned to 4 bytes only.
    start: usize,
    len: usize,
    lanes: PhantomData<R>,
}

impl<R: Real, const N: usize, const S: usize> Queue<R, N, S> {
    /// Empty.
    pub fn new() -> Self {
        const { assert!(S.is_multiple_of(LINE)) };
        let needed = N * S + LINE;
        let mut values = SPARE.with_borrow_mut(Vec::pop).unwrap_or_default();
        if values.len() < needed {
            values.resize(needed, 0.0);
        }
        let start = values.as_ptr().align_offset(64) % LINE;
        Queue { values, start, len: 0, lanes: PhantomData }
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

    #[inline(always)]
    fn table(&self) -> &[[f32; S]] {
        self.values[self.start..][..N * S].as_chunks().0
    }

    #[inline(always)]
    fn table_mut(&mut self) -> &mut [[f32; S]] {
        self.values[self.start..][..N * S].as_chunks_mut().0
    }

    /// Appends the lanes of `mask`, in order. Panics where there is no room.
    #[inline(always)]
    pub fn push(&mut self, mask: R::Mask, row: &[R; N]) {
        let (bits, len) = (mask.bits(), self.len);
        let table = self.table_mut();
        // All fields at constant places, so that the row need not be in memory.
        let mut k = 0;
        while k < N {
            row[k].compress(bits).store(&mut table[k][len..][..R::WIDTH]);
            k += 1;
        }
        self.len += bits.count_ones() as usize;
    }

    /// Appends the lanes of `mask` of the packet of `rows` that starts with its row `first`, with more values each.
    #[inline(always)]
    pub fn push_longer<const K: usize, const M: usize, const T: usize>(
        &mut self,
        mask: R::Mask,
        rows: &Queue<R, K, T>,
        first: usize,
        more: [R; M],
    ) {
        const { assert!(K + M == N) };
        let (bits, len) = (mask.bits(), self.len);
        // Once, so that the loops have no bounds to test.
        assert!(first <= T - R::WIDTH && len <= S - R::WIDTH);
        let (source, table) = (rows.table(), self.table_mut());
        let mut k = 0;
        while k < K {
            R::load(&source[k][first..][..R::WIDTH]).compress(bits).store(&mut table[k][len..][..R::WIDTH]);
            k += 1;
        }
        while k < N {
            more[k - K].compress(bits).store(&mut table[k][len..][..R::WIDTH]);
            k += 1;
        }
        self.len += bits.count_ones() as usize;
    }

    /// The packet of rows from `first` on, and which of its lanes are rows.
    #[inline(always)]
    pub fn packet(&self, first: usize) -> ([R; N], R::Mask) {
        (self.fields(0, first), self.rows(first))
    }

    /// One value of each row of the packet from `first` on.
    #[inline(always)]
    pub fn field(&self, field: usize, first: usize) -> R {
        R::load(&self.table()[field][first..][..R::WIDTH])
    }

    /// `K` values from `field` on of the packet of rows from `first` on.
    #[inline(always)]
    pub fn fields<const K: usize>(&self, field: usize, first: usize) -> [R; K] {
        array::from_fn(|k| self.field(field + k, first))
    }

    /// Which lanes of the packet from `first` on are rows.
    #[inline(always)]
    pub fn rows(&self, first: usize) -> R::Mask {
        R::Mask::from_bits(((1u64 << (self.len - first).min(R::WIDTH)) - 1) as u32)
    }

    /// Rows that fill packets.
    pub fn full(&self) -> usize {
        self.len - self.len % R::WIDTH
    }

    /// Forgets the rows that fill packets.
    pub fn keep_rest(&mut self) {
        let full = self.full();
        for field in self.table_mut() {
            R::load(&field[full..][..R::WIDTH]).store(field);
        }
        self.len -= full;
    }
}

impl<R, const N: usize, const S: usize> Drop for Queue<R, N, S> {
    fn drop(&mut self) {
        // At the end of a thread there is no place for it.
        let _ = SPARE.try_with(|spare| spare.borrow_mut().push(core::mem::take(&mut self.values)));
    }
}
