//! The best hits so far of the rays in flight. Whether one that was found is better is anybody's guess: no branch on it.
//!
//! With AVX-512, where one of two floats is chosen by a mask, a column for each value. Without, the compiler makes a branch of
//! that choice: rows, of which one is taken by its number. Found by measuring: on Zen 5 rows give ×.96 of the rays a second
//! of columns, on Zen 3 columns .92 to .98 of those of rows.

use super::flight::RAYS;
use super::leaves::Keep;
use super::tree::OneHit;
use crate::geometry::{Hit, MISS};
use crate::lane::{Bits, Real};

#[cfg(not(target_feature = "avx512vl"))]
pub use rows::Best;

/// A column for each value.
#[cfg(target_feature = "avx512vl")]
pub struct Best {
    t: [f32; RAYS],
    primitive: [u32; RAYS],
    u: [f32; RAYS],
    v: [f32; RAYS],
}

#[cfg(target_feature = "avx512vl")]
impl Best {
    pub const NONE: Self = Self { t: [0.0; RAYS], primitive: [0; RAYS], u: [0.0; RAYS], v: [0.0; RAYS] };

    /// Of ray `i`, or how far it looks.
    #[inline(always)]
    pub fn t(&self, i: usize) -> f32 {
        self.t[i]
    }

    /// Nothing yet, of the packet of rays `first` …, which look as far as `t_max`.
    #[inline(always)]
    pub fn miss<R: Real>(&mut self, first: usize, t_max: R) {
        let all = first..first + R::WIDTH;
        t_max.store(&mut self.t[all.clone()]);
        R::Bits::splat(MISS).store(&mut self.primitive[all.clone()]);
        R::zero().store(&mut self.u[all.clone()]);
        R::zero().store(&mut self.v[all]);
    }

    /// Of the packet of rays `first` …
    #[inline(always)]
    pub fn packet<R: Real>(&self, first: usize) -> Hit<R> {
        let all = first..first + R::WIDTH;
        Hit {
            t: R::load(&self.t[all.clone()]),
            primitive: R::Bits::load(&self.primitive[all.clone()]),
            u: R::load(&self.u[all.clone()]),
            v: R::load(&self.v[all]),
        }
    }
}

#[cfg(target_feature = "avx512vl")]
impl Keep for Best {
    #[inline(always)]
    fn eight<E: Real>(&mut self, rays: [usize; 8], found: Hit<E>) {
        let mut columns = [[0.0; 8]; 3];
        for (column, values) in columns.iter_mut().zip([found.t, found.u, found.v]) {
            values.store(column);
        }
        let [t, u, v] = columns;
        for (l, i) in rays.into_iter().enumerate() {
            self.one(i, OneHit { primitive: found.primitive.lane(l), t: t[l], u: u[l], v: v[l] });
        }
    }

    #[inline(always)]
    fn one(&mut self, i: usize, found: OneHit) {
        let mut best = OneHit { t: self.t[i], primitive: self.primitive[i], u: self.u[i], v: self.v[i] };
        best.keep(found);
        (self.t[i], self.primitive[i], self.u[i], self.v[i]) = (best.t, best.primitive, best.u, best.v);
    }
}

#[cfg(not(target_feature = "avx512vl"))]
mod rows {
    use super::{Bits, Hit, Keep, MISS, OneHit, RAYS, Real};
    use crate::lane::MAX_WIDTH;
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
}
