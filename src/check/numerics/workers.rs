//! The floating-point mode of the threads that compute.

use super::{Effort, Row};
use crate::lane::{Real, f32x8, f32x16, float_mode};
use std::hint::black_box;

/// On every worker: the mode by its register, and by what subnormals, ties and NaN do in lanes.
pub fn rows(_: Effort) -> Vec<Row> {
    let found = rayon::broadcast(|_| (float_mode::is_default(), misbehaves()));
    let count = |bad: usize| (found.len() as u64, bad as u64);
    let (threads, modes) = count(found.iter().filter(|(default, _)| !default).count());
    let (_, arithmetic) = count(found.iter().filter(|(_, bad)| *bad).count());
    vec![
        Row::never("workers", "floating-point mode is the default", threads, modes, "threads"),
        Row::never("workers", "subnormals kept, ties to even, at every width", threads, arithmetic, "threads"),
    ]
}

fn misbehaves() -> bool {
    wrong::<f32>() || wrong::<f32x8>() || wrong::<f32x16>()
}

fn wrong<R: Real>() -> bool {
    let lanes = |x: f32| R::splat(black_box(x));
    let smallest = f32::from_bits(1);
    let is = |got: R, expected: f32| (0..R::WIDTH).all(|i| got.lane(i).to_bits() == expected.to_bits());
    // FTZ loses the first, DAZ the second; the others know one rounding each.
    let kept = is(lanes(f32::MIN_POSITIVE) * lanes(0.5), f32::MIN_POSITIVE / 2.0)
        && is(lanes(smallest) * lanes(8_388_608.0), f32::MIN_POSITIVE)
        && is(lanes(1.0) + lanes(f32::EPSILON / 2.0), 1.0)
        && is(lanes(1.0 + f32::EPSILON) + lanes(f32::EPSILON / 2.0), 1.0 + 2.0 * f32::EPSILON)
        && is(lanes(-1.0) - lanes(0.75 * f32::EPSILON), -1.0 - f32::EPSILON);
    !kept
}
