//! Between which first and second vertices nothing is in the way.

use crate::accel::{Built, Shadow};
use crate::geometry::Ray;
use crate::kernel::tile::Counters;
use crate::kernel::wave::{TOGETHER, together};
use crate::kernel::world::World;
use crate::lane::{Mask, Real, Vec3};

/// Segments that wait to be traced together.
pub struct Segments<R: Real> {
    rays: [Ray<R>; TOGETHER],
    active: [R::Mask; TOGETHER],
    /// Where in the tables their packets are, and do they have values there?
    places: [(usize, bool); TOGETHER],
    count: usize,
}

impl<R: Real> Segments<R> {
    pub fn new() -> Self {
        let nowhere = Ray::new(Vec3::zero(), Vec3::zero(), R::zero());
        Segments {
            rays: [nowhere; TOGETHER],
            active: [R::Mask::splat(false); TOGETHER],
            places: [(0, false); TOGETHER],
            count: 0,
        }
    }

    /// Are there enough now?
    #[inline(always)]
    pub fn add(&mut self, ray: Ray<R>, active: R::Mask, place: usize, values: bool) -> bool {
        if active.any() {
            self.rays[self.count] = ray;
            self.active[self.count] = active;
            self.places[self.count] = (place, values);
            self.count += 1;
        }
        self.count == together::<R>()
    }

    /// Traces them; what is hidden is cleared in the tables.
    #[inline(always)]
    pub fn trace(&mut self, world: &World, density: &mut [f32], values: &mut [Vec<f32>; 3], counters: &mut Counters) {
        let mut occluded = [R::Mask::splat(false); TOGETHER];
        let count = core::mem::take(&mut self.count);
        world.occluded_many::<R, Built<Shadow>>(&self.rays[..count], &self.active[..count], &mut occluded[..count]);
        let segments = self.places.iter().zip(&self.active).zip(occluded).take(count);
        for ((&(at, has_values), &active), occluded) in segments {
            counters.shadow(active);
            let clear = |table: &mut [f32]| R::load(table).masked(!occluded).store(table);
            clear(&mut density[at..]);
            if has_values {
                values.iter_mut().for_each(|table| clear(&mut table[at..]));
            }
        }
    }
}
