//! The groups of a job: which pixels share, and which of their paths.

use super::connect::Group;
use super::{ALBEDO, FACTOR, Second, Shared, VALID};
use crate::kernel::path::Traversal;
use crate::kernel::probe::{Lanes, Probe, Stage};
use crate::kernel::shade::Shade;
use crate::kernel::tile::{Counters, Job, SampleBuffer};
use crate::kernel::world::World;
use crate::lane::{Bits, Real, Vec3, array};
use crate::sampling::sample_key;

/// Side of the blocks of pixels that share. Of 4, 16 and blocks of 16 by 4 none was better on all scenes; pixels further
/// apart (every other one of a block twice as large) or blocks that move from sample to sample were worse on all.
pub const REUSE_SIDE: u32 = 8;
const PIXELS: usize = (REUSE_SIDE * REUSE_SIDE) as usize;

/// So many finds of a group are shared, about: see [`number_of_finds`]. Measured.
const LEAST_FINDS: f64 = 2.0;
const MOST_FINDS: f64 = 24.0;
const BALANCE: f64 = 30.0;

/// Gives every pixel of a job its part of what the paths of its group found: blocks of pixels, at the same sample.
#[inline(never)]
pub fn connect<R: Real, T: Traversal, S: Shade, P: Probe>(
    world: &World,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
    probe: &mut P,
) {
    let mut group = Group::<R>::new(PIXELS);
    let mut slots = Vec::with_capacity(PIXELS);
    let (right, bottom) = (job.x + job.width, job.y + job.height);
    let start = |first: u32| (first / REUSE_SIDE * REUSE_SIDE) as usize;
    for y in (start(job.y)..bottom as usize).step_by(REUSE_SIDE as usize) {
        for x in (start(job.x)..right as usize).step_by(REUSE_SIDE as usize) {
            let (x, y) = (x as u32, y as u32);
            let (columns, rows) =
                (x.max(job.x)..(x + REUSE_SIDE).min(right), y.max(job.y)..(y + REUSE_SIDE).min(bottom));
            let pixel = rows.start * world.film.width + columns.start;
            for sample in 0..job.samples {
                let slot = |x: u32, y: u32| ((y - job.y) * job.width + x - job.x) * job.samples + sample;
                slots.clear();
                slots.extend(rows.clone().flat_map(|y| columns.clone().map(move |x| slot(x, y))));
                let key = sample_key(job.seed ^ SALT, pixel, job.first_sample + sample);
                group.begin(&slots, &out.shared);
                choose(&mut group, &slots, &out.shared, &out.rgb, key);
                group.connect::<T, S, P>(world, out, counters, probe);
            }
        }
    }
    out.rgb.truncate(job.slots());
    if P::ACTIVE {
        for (slot, rgb) in out.rgb.iter_mut().enumerate() {
            let lanes = Lanes::<f32> { slot: Bits::splat(slot as u32), bounce: 0.0, active: true };
            *rgb = probe.tap_rgb(Stage::Radiance, lanes, Vec3::splat(*rgb)).lane(0);
        }
    }
}

/// Tells the keys of choices from those of paths.
const SALT: u64 = 0x7265_7573_655f_6b65;

/// What a path found, and how much of it its own pixel would have, about.
struct Candidate {
    slot: u32,
    lobe: Option<(usize, bool)>,
    found: [f32; 3],
    /// In f64, like all that is made of it: squares of light stay in range.
    worth: f64,
}

/// Chooses what is shared: each find with a probability in proportion to its worth, by one number for all (systematic sampling),
/// and carrying the more.
fn choose<R: Real>(group: &mut Group<R>, slots: &[u32], shared: &Shared, rgb: &[[f32; 3]], key: u64) {
    let candidates = candidates(slots, shared, rgb);
    let total: f64 = candidates.iter().map(|candidate| candidate.worth).sum();
    let number = number_of_finds(slots, shared, rgb, &candidates);
    // Where no choice is needed all are shared as they are.
    let scale = if candidates.len() as f64 <= number { f64::INFINITY } else { number / total };
    let mut walk = (key >> 40) as f64 * (1.0 / (1u32 << 24) as f64);
    for Candidate { slot, lobe, found, worth } in candidates {
        let probability = (worth * scale).min(1.0);
        walk += probability;
        if walk >= 1.0 {
            walk -= 1.0;
            let share = probability.recip() as f32;
            group.add(slot, lobe, found.map(|x| x * share));
        }
    }
}

fn brightness([r, g, b]: [f32; 3]) -> f64 {
    (f64::from(r) + f64::from(g) + f64::from(b)) * (1.0 / 3.0)
}

/// All finds that hold anything.
fn candidates(slots: &[u32], shared: &Shared, rgb: &[[f32; 3]]) -> Vec<Candidate> {
    let count = shared.slots() as usize;
    let mut candidates = Vec::with_capacity(2 * slots.len());
    for &slot in slots {
        let second = &shared.second[slot as usize];
        let albedo = brightness(array::from_fn(|c| shared.first[slot as usize][ALBEDO + c]));
        let mut add = |part: usize, lobe: Option<(usize, bool)>| {
            let found = rgb[part * count + slot as usize];
            let factor = lobe.map_or(1.0, |(lobe, _)| f64::from(shared.lobes[lobe][FACTOR]));
            let worth = brightness(found) * albedo * factor;
            if worth > 0.0 {
                candidates.push(Candidate { slot, lobe, found, worth });
            }
        };
        if second[Second::KIND] == Second::LAMBERT {
            add(1, None);
        }
        for (place, part) in [(Second::LIGHT, 1), (Second::BOUNCE, 2)] {
            if second[place] != 0.0 {
                add(part, Some((second[place] as usize - 1, place == Second::BOUNCE)));
            }
        }
    }
    candidates
}

/// As many as balance the noise of finds with that of all else, at least [`LEAST_FINDS`]: n of them cost c n beside a path's a and
/// leave v/n beside the variance u of what is not shared, so √(a v / c u). Both variances are those among the group's pixels
/// now; a/c is measured, and so is how much less u is where even points add up.
fn number_of_finds(slots: &[u32], shared: &Shared, rgb: &[[f32; 3]], candidates: &[Candidate]) -> f64 {
    let (mut n, mut sum, mut squares) = (0.0f64, 0.0f64, 0.0f64);
    for &slot in slots.iter().filter(|&&slot| shared.first[slot as usize][VALID] != 0.0) {
        let own = brightness(rgb[slot as usize]);
        (n, sum, squares) = (n + 1.0, sum + own, squares + own * own);
    }
    let variance = |sum: f64, squares: f64| (squares - sum * sum / n.max(1.0)).max(0.0);
    let worth = |of: fn(f64) -> f64| candidates.iter().map(|candidate| of(candidate.worth)).sum::<f64>();
    let (found, own) = (variance(worth(|x| x), worth(|x| x * x)), variance(sum, squares));
    let balanced = BALANCE * (found / own).sqrt();
    // Not a number where neither varies.
    if balanced > LEAST_FINDS { balanced.min(MOST_FINDS) } else { LEAST_FINDS }
}
