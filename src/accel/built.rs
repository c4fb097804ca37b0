//! What there is to walk: a mode where trees were built, the lists where not. For kernels of which one copy should serve both.

use super::{Accel, Brute, Mode};
use crate::geometry::{Hit, Ray, RaySetup};
use crate::lane::Real;
use core::marker::PhantomData;

/// `M` through trees, [`Brute`] where there are none.
#[derive(Clone, Copy, Debug)]
pub struct Built<M>(PhantomData<M>);

impl<M: Mode> Mode for Built<M> {
    const TREE: bool = M::TREE;

    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        if accel.has_trees { M::closest(accel, setup, active, hit) } else { Brute::closest(accel, setup, active, hit) }
    }

    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        if accel.has_trees { M::any(accel, setup, t_max, active) } else { Brute::any(accel, setup, t_max, active) }
    }

    fn closest_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], hits: &mut [Hit<R>]) {
        if accel.has_trees {
            M::closest_many(accel, rays, active, hits)
        } else {
            Brute::closest_many(accel, rays, active, hits)
        }
    }

    fn any_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
        if accel.has_trees {
            M::any_many(accel, rays, active, found)
        } else {
            Brute::any_many(accel, rays, active, found)
        }
    }
}
