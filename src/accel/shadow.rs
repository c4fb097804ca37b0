//! Shadow rays: together while they go the same way, else each on its own.

use super::{Accel, Mode, Packet, Shadow, Single, Stream};
use crate::geometry::{Hit, Ray, RaySetup};
use crate::lane::{Mask, Real};

/// Rays that start within this of each other, per axis, count as neighbours.
const NEIGHBOURS: f32 = 1.0 / 32.0;

/// Do the rays start beside each other and go into the same octant?
#[inline(always)]
fn coherent<R: Real>(setup: &RaySetup<R>, active: R::Mask) -> bool {
    let all = active.bits();
    let same_octant = (0..3).all(|k| {
        let negative = (setup.negative[k] & active).bits();
        negative == 0 || negative == all
    });
    let among = |value: R, other: f32| R::select(active, value, R::splat(other));
    let spread = |o: R| among(o, f32::NEG_INFINITY).highest() - among(o, f32::INFINITY).lowest();
    same_octant && setup.origin.iter().all(|&o| spread(o) <= NEIGHBOURS)
}

impl Mode for Shadow {
    const TREE: bool = true;

    #[inline(always)]
    fn closest<R: Real>(accel: &Accel, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        Stream::closest(accel, setup, active, hit)
    }

    #[inline(always)]
    fn any<R: Real>(accel: &Accel, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        if coherent(setup, active) {
            Packet::any(accel, setup, t_max, active)
        } else {
            Stream::any(accel, setup, t_max, active)
        }
    }

    /// Packets whose lanes have parted go together.
    #[inline(always)]
    fn any_many<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
        if R::WIDTH == 1 {
            return Single::any_many(accel, rays, active, found);
        }
        for at in (0..rays.len()).step_by(TOGETHER) {
            let end = rays.len().min(at + TOGETHER);
            shadow_packets(accel, &rays[at..end], &active[at..end], &mut found[at..end]);
        }
    }
}

/// Packets of shadow rays looked at together.
const TOGETHER: usize = 8;

#[inline(always)]
fn shadow_packets<R: Real>(accel: &Accel, rays: &[Ray<R>], active: &[R::Mask], found: &mut [R::Mask]) {
    let mut parted = ([rays[0]; TOGETHER], [R::Mask::splat(false); TOGETHER], [0; TOGETHER]);
    let mut count = 0;
    for (k, (ray, active)) in rays.iter().zip(active).enumerate() {
        let (setup, usable) = (RaySetup::new(ray), *active & ray.usable());
        if coherent(&setup, usable) {
            found[k] = Packet::any(accel, &setup, ray.t_max, usable);
        } else {
            (parted.0[count], parted.1[count], parted.2[count]) = (*ray, *active, k);
            count += 1;
        }
    }
    let mut hidden = [R::Mask::splat(false); TOGETHER];
    Stream::any_many(accel, &parted.0[..count], &parted.1[..count], &mut hidden[..count]);
    for (k, hidden) in parted.2.iter().zip(hidden).take(count) {
        found[*k] = hidden;
    }
}
