//! The groups of a job: which pixels share, and which of their paths.

use super::connect::Group;
use super::{Second, Shared};
use crate::kernel::path::Traversal;
use crate::kernel::probe::{Lanes, Probe, Stage};
use crate::kernel::shade::Shade;
use crate::kernel::tile::{Counters, Job, SampleBuffer};
use crate::kernel::world::World;
use crate::lane::{Bits, Real, Vec3};
use crate::sampling::sample_key;

/// Side of the blocks of pixels that share. Of 4, 16 and blocks of 16 by 4 none was better on all scenes; pixels further
/// apart (every other one of a block twice as large) or blocks that move from sample to sample were worse on all.
pub const REUSE_SIDE: u32 = 8;
const PIXELS: usize = (REUSE_SIDE * REUSE_SIDE) as usize;

/// So many finds of a group at Lambert vertices are shared, about. Measured: where segments are cheap 32 are as good, through
/// a tree 8 to 16.
const MOST_FINDS: f32 = 20.0;

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

/// Chooses whose finds are shared: about [`MOST_FINDS`] of those at Lambert vertices, each with a probability in proportion to its
/// radiance, by one number for all (systematic sampling), and carrying the more. The others are few.
fn choose<R: Real>(group: &mut Group<R>, slots: &[u32], shared: &Shared, rgb: &[[f32; 3]], key: u64) {
    let count = shared.slots() as usize;
    let radiance = |slot: u32| rgb[count + slot as usize];
    let brightness = |[r, g, b]: [f32; 3]| r + g + b;
    let lambert = |slot: u32| shared.second[slot as usize][Second::KIND] == Second::LAMBERT;
    let total: f32 = slots.iter().filter(|&&slot| lambert(slot)).map(|&slot| brightness(radiance(slot))).sum();
    let scale = MOST_FINDS / total;
    let mut walk = (key >> 40) as f32 * (1.0 / (1u32 << 24) as f32);
    for &slot in slots {
        let second = &shared.second[slot as usize];
        match second[Second::KIND] {
            Second::LAMBERT => {
                let found = radiance(slot);
                let probability = (brightness(found) * scale).min(1.0);
                walk += probability;
                if walk >= 1.0 {
                    walk -= 1.0;
                    let share = probability.recip();
                    group.add(slot, None, found.map(|x| x * share));
                }
            }
            Second::LOBES => {
                for (place, half) in [(Second::LIGHT, 1), (Second::BOUNCE, 2)] {
                    let found = rgb[half * count + slot as usize];
                    if second[place] != 0.0 && brightness(found) > 0.0 {
                        group.add(slot, Some((second[place] as usize - 1, place == Second::BOUNCE)), found);
                    }
                }
            }
            _ => {}
        }
    }
}
