//! [`Best`] where a mask chooses between floats.

use crate::accel::flight::RAYS;
use crate::accel::leaves::Keep;
use crate::accel::tree::OneHit;
use crate::geometry::{Hit, MISS};
use crate::lane::{Bits, Real};

/// A column for each value.
pub struct Best {
    t: [f32; RAYS],
    primitive: [u32; RAYS],
    u: [f32; RAYS],
    v: [f32; RAYS],
}

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
