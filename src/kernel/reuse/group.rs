//! The groups of a job: which pixels share.

use super::connect::Group;
use super::finds;
use super::spread::spread;
use crate::kernel::probe::{Lanes, Probe, Stage};
use crate::kernel::shade::Shade;
use crate::kernel::tile::{Counters, Job, SampleBuffer};
use crate::kernel::world::World;
use crate::lane::{Bits, Real, Vec3};
use crate::sampling::{sample_key, site};

/// Side of the blocks of pixels that share. Of 4, 16 and blocks of 16 by 4 none was better on all scenes; pixels further
/// apart (every other one of a block twice as large) or blocks that move from sample to sample were worse on all.
pub const REUSE_SIDE: u32 = 8;
// Of the same pixels are the points that are spread together.
const _: () = assert!(REUSE_SIDE == site::BLOCK_SIDE);
pub(super) const PIXELS: usize = (REUSE_SIDE * REUSE_SIDE) as usize;

/// Tells the keys of choices from those of paths.
const SALT: u64 = 0x7265_7573_655f_6b65;

/// Column and row in a block of its `k`-th pixel. Each eight fill 4×2 pixels and each sixteen 4×4, so that the segments of a packet
/// stay together; every other sixteen lie cornerwise, to stand for all (see [`spread`]).
fn place(k: u32) -> (u32, u32) {
    let (column, row, quarter) = (k & 1 | k >> 1 & 2, k >> 1 & 1 | k >> 2 & 2, k >> 4);
    (column + 4 * ((quarter ^ quarter >> 1) & 1), row + 4 * (quarter >> 1))
}

/// Gives every pixel of a job its part of what the paths of its group found: blocks of pixels, at the same sample.
#[inline(never)]
pub fn connect<R: Real, S: Shade, P: Probe>(
    world: &World,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
    probe: &mut P,
) {
    let mut group = Group::<R>::new();
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
                for (column, row) in (0..PIXELS as u32).map(place) {
                    if columns.contains(&(x + column)) && rows.contains(&(y + row)) {
                        slots.push(slot(x + column, y + row));
                    }
                }
                let key = sample_key(world.seed ^ SALT, pixel, job.first_sample + sample);
                group.begin(&slots, &out.shared);
                finds::collect(&slots, &out.shared, &mut out.rgb, &mut group.finds);
                let u = (key >> 40) as f64 * (1.0 / (1u32 << 24) as f64);
                let spread = spread::<R, S>(&group, world, &out.shared);
                let number = finds::balanced(&group.finds, spread, &slots, &out.shared, &out.rgb);
                finds::choose(&mut group.finds, number, u);
                group.connect::<S, P>(world, out, counters, probe);
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
