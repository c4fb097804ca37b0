//! The film: 2²⁷ samples on a pixel, radiances from 1e-30 to 1e30, small variances on large means.

use super::{Effort, Row};
use crate::film::{FilmChannels, Rect, TileFilm};

const GROUP: &str = "film";
/// Half an ulp of f64, relative.
const U: f64 = f64::EPSILON / 2.0;

pub fn rows(effort: Effort) -> Vec<Row> {
    let log = effort.pick(20, 27, 27);
    [accumulate(log, 1.0), accumulate(20, 1e30), accumulate(20, 1e-30)].concat()
}

/// 2^`log` samples, in turn .1 and .3 times `unit`.
fn accumulate(log: u32, unit: f32) -> Vec<Row> {
    const PASS: usize = 1 << 16;
    let pair = [0.1f32, 0.3].map(|x| x * unit);
    let samples: Vec<[f32; 3]> = (0..PASS).map(|i| [pair[i % 2]; 3]).collect();
    let mut tile = TileFilm::new(Rect { x: 0, y: 0, width: 1, height: 1 }, FilmChannels::Colour, 0);
    let (mut single, mut single_square) = (0f32, 0f32);
    for pass in 0..1u64 << (log - 16) {
        tile.add_samples(pass * PASS as u64, PASS, &samples, &[]);
        for s in &samples {
            single += s[0];
            single_square += s[0] * s[0];
        }
    }
    let n = (1u64 << log) as f64;
    let [a, b] = pair.map(f64::from);
    let (mean, variance) = (0.5 * (a + b), 0.25 * (a - b).powi(2) * n / (n - 1.0));
    let pixel = tile.pixel(0, 0);
    let mean_error = (pixel.mean()[0] / mean - 1.0).abs() / U;
    let of_mean = pixel.variance_of_mean().map_or(f64::NAN, |v| v[0]);
    let variance_error = (of_mean * n / variance - 1.0).abs() / U;
    let naive_mean = f64::from(single) / n / mean - 1.0;
    let naive_variance = (f64::from(single_square) - f64::from(single).powi(2) / n) / n / variance - 1.0;
    // 63 additions in a block, one a level of the tree, the division; the variance is a difference five times smaller than
    // its terms, each square rounded once more.
    let bound = 63.0 + f64::from(log) - 6.0 + 1.0;
    let times = if unit == 1.0 { String::new() } else { format!(" of {unit:e}") };
    vec![
        Row::new(GROUP, format!("mean of 2^{log} samples{times}"), 1 << log, mean_error, bound, "u of f64")
            .naive(format!("f32 sum: {:+.1} %", 100.0 * naive_mean)),
        Row::new(
            GROUP,
            format!("variance of 2^{log} samples{times}"),
            1 << log,
            variance_error,
            2.0 * 5.0 * (bound + 2.0),
            "u of f64",
        )
        .naive(format!("f32 sums: {:+.1} %", 100.0 * naive_variance)),
    ]
}
