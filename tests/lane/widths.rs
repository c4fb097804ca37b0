//! The same bits at every width.

use octolux::lane::{Mask, Real, f32x8, f32x16};

/// A function of lanes, as a test sees it: values in, values out, at any width.
pub trait LaneFunction {
    fn call<R: Real>(&self, input: &[R]) -> Vec<R>;
}

/// A mask as a value: 1 where it holds.
pub fn truth<R: Real>(mask: R::Mask) -> R {
    R::select(mask, R::one(), R::zero())
}

fn run<R: Real>(f: &impl LaneFunction, rows: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let mut results = Vec::with_capacity(rows.len());
    for block in rows.chunks(R::WIDTH) {
        let row = |lane: usize| &block[lane.min(block.len() - 1)];
        let input: Vec<R> = (0..block[0].len()).map(|column| R::from_fn(|lane| row(lane)[column])).collect();
        let output = f.call::<R>(&input);
        results.extend((0..block.len()).map(|lane| output.iter().map(|value| value.lane(lane)).collect::<Vec<f32>>()));
    }
    results
}

/// Runs every row of arguments at widths 1, 8 and 16 and asserts equal bits (any NaN equals any NaN). Returns the
/// results of width 1.
pub fn assert_same_bits(f: &impl LaneFunction, rows: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let bits = |value: &f32| if value.is_nan() { f32::NAN.to_bits() } else { value.to_bits() };
    let scalar = run::<f32>(f, rows);
    for (width, other) in [(8, run::<f32x8>(f, rows)), (16, run::<f32x16>(f, rows))] {
        for ((row, one), many) in rows.iter().zip(&scalar).zip(&other) {
            let same = one.iter().map(bits).eq(many.iter().map(bits));
            assert!(same, "width 1 gives {one:?}, width {width} {many:?} for {row:?}");
        }
    }
    scalar
}

#[test]
fn a_lane_dependent_function_is_caught() {
    struct LaneIndex;
    impl LaneFunction for LaneIndex {
        fn call<R: Real>(&self, input: &[R]) -> Vec<R> {
            vec![input[0] + R::from_fn(|lane| lane as f32), truth::<R>(R::Mask::splat(true))]
        }
    }
    let rows = vec![vec![1.0]; 16];
    assert!(std::panic::catch_unwind(|| assert_same_bits(&LaneIndex, &rows)).is_err());
}
