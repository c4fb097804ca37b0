//! [`Best`] where no mask chooses between floats.

use crate::accel::flight::RAYS;
use crate::accel::leaves::Keep;
use crate::accel::tree::OneHit;
use crate::geometry::{Hit, MISS};
use crate::lane::{Bits, MAX_WIDTH, Real};
use core::hint::select_unpredictable;

/// A row for each ray: the bits of the primitive's number, the distance, u and v. After them those that were found last.
#[repr(C, align(64))]
pub struct Best([[f32; 4]; RAYS + MAX_WIDTH]);

impl Best {
    pub const NONE: Self = Self([[0.0; 4]; RAYS + MAX_WIDTH]);

    /// Of ray `i`, or how far it looks.
    #[inline(always)]
    pub fn t(&self, i: usize) -> f32 {
        self.0[i][1]
    }

    /// See [`OneHit::key`].
    #[inline(always)]
    fn key(&self, row: usize) -> u64 {
        let [primitive, t, ..] = self.0[row];
        u64::from(t.to_bits()) << 32 | u64::from(primitive.to_bits())
    }

    /// Ray `i` keeps what was found at `place` if that is better than its best.
    #[inline(always)]
    fn choose(&mut self, i: usize, place: usize) {
        let found = RAYS + place;
        self.0[i] = self.0[select_unpredictable(self.key(found) < self.key(i), found, i)];
    }

    /// Nothing yet, of the packet of rays `first` …, which look as far as `t_max`.
    #[inline(always)]
    pub fn miss<R: Real>(&mut self, first: usize, t_max: R) {
        let miss = R::from_bits(R::Bits::splat(MISS));
        if let Some((rows, _)) = self.0[first..].split_first_chunk_mut() {
            R::store_rows(&[miss, t_max, R::zero(), R::zero()], rows);
        }
    }

    /// Of the packet of rays `first` …
    #[inline(always)]
    pub fn packet<R: Real>(&self, first: usize) -> Hit<R> {
        let rows = R::Bits::from_fn(|lane| (first + lane) as u32);
        let [primitive, t, u, v] = R::fetch_rows(&self.0, rows);
        Hit { t, primitive: primitive.to_bits(), u, v }
    }
}

impl Keep for Best {
    #[inline(always)]
    fn eight<E: Real>(&mut self, rays: [usize; 8], found: Hit<E>) {
        let Hit { t, primitive, u, v } = found;
        if let Some((rows, _)) = self.0[RAYS..].split_first_chunk_mut() {
            E::store_rows(&[E::from_bits(primitive), t, u, v], rows);
        }
        for (place, i) in rays.into_iter().enumerate() {
            self.choose(i, place);
        }
    }

    #[inline(always)]
    fn one(&mut self, i: usize, found: OneHit) {
        self.0[RAYS] = [f32::from_bits(found.primitive), found.t, found.u, found.v];
        self.choose(i, 0);
    }
}
