//! How much it matters to the pixels of a group which of the finds are chosen.

use super::Shared;
use super::connect::{Group, PARTS, in_parts};
use super::finds::{Find, brightness, total_worth};
use super::group::PIXELS;
use crate::kernel::shade::Shade;
use crate::kernel::world::World;
use crate::lane::Real;

/// Finds that stand for all. Of 2, 3, 6 and 8 none gave less error for its time.
const PROBES: usize = 4;
/// Every so many parts of the first vertices stand for all.
const STRIDE: usize = 2;

/// Variance of what a pixel would be given by a single find that stands for all, chosen in proportion to its worth; on average over
/// pixels. Neighbours on a Lambert surface see a find much alike, so that its worth says what it is to all of them, and few
/// finds do; in a glossy one each sees another part of what was found. By a few finds and first vertices, whatever is in the
/// way. Infinite where there are few finds: nothing is to be chosen.
pub fn spread<R: Real, S: Shade>(group: &Group<R>, world: &World, shared: &Shared) -> f64 {
    if group.finds.len() <= PROBES {
        return f64::INFINITY;
    }
    let all = total_worth(&group.finds);
    let mut sums = [[0f64; 2]; PIXELS];
    let rows = || (0..group.len()).filter(|row| (row / PARTS).is_multiple_of(STRIDE));
    let rows_seen = rows().count() as f64;
    for find in probes(&group.finds, all) {
        let seen = group.look(world, shared, find);
        let (mut density, mut value) = ([0f32; PIXELS], [0f32; PIXELS]);
        for first in rows().step_by(R::WIDTH) {
            let (found, scattered) = group.scattered_unhidden::<S>(world, &seen, first);
            found.store(&mut density[first..]);
            (scattered.x + scattered.y + scattered.z).store(&mut value[first..]);
        }
        let densities = f64::from(in_parts(&density)) * group.len() as f64 / rows_seen;
        let scale = brightness(find.found) * (1.0 / 3.0) * all / (find.worth * densities);
        // Found by none of these.
        if !scale.is_finite() {
            continue;
        }
        for (sum, value) in sums.iter_mut().zip(value) {
            let x = f64::from(value) * scale;
            *sum = [sum[0] + x, sum[1] + x * x];
        }
    }
    let variance = |[sum, squares]: [f64; 2]| (squares - sum * sum / PROBES as f64).max(0.0) / (PROBES - 1) as f64;
    rows().map(|row| variance(sums[row])).sum::<f64>() / rows_seen
}

/// Finds at even steps of the worth of `all`.
fn probes(finds: &[Find], all: f64) -> impl Iterator<Item = &Find> {
    let step = all / PROBES as f64;
    let (mut walk, mut next) = (0.0, 0.5 * step);
    finds.iter().flat_map(move |find| {
        walk += find.worth;
        let mut times = 0;
        while walk > next {
            (times, next) = (times + 1, next + step);
        }
        core::iter::repeat_n(find, times)
    })
}
