//! s²/n against a two-pass oracle.

use super::{SplitMix, filled, radiance, rendered};
use octolux::film::FilmChannels;

/// Two passes in f64 about the mean.
fn two_pass_variance_of_mean(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / ((n - 1.0) * n)
}

/// What the error of s²/n may be: Σx and Σx² carry at most one rounding for each sample added, so n Σx² − (Σx)² is off
/// by at most 3 n u · n Σx² (u = 2⁻⁵³, first order), and s²/n is that over n²(n − 1).
fn tolerance(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let squares: f64 = values.iter().map(|v| v * v).sum();
    3.0 * n * f64::EPSILON / 2.0 * squares / (n * (n - 1.0))
}

#[test]
fn variance_equals_the_two_pass_value() {
    for samples in [2u64, 3, 64, 65, 1000, 5000] {
        let film = rendered((3, 2), 2, FilmChannels::Colour, samples, 77);
        for (x, y) in [(0, 0), (2, 1)] {
            let variance = film.variance_of_mean(x, y).unwrap();
            for (c, variance) in variance.into_iter().enumerate() {
                let values: Vec<f64> = (0..samples).map(|s| f64::from(radiance(x, y, s)[c])).collect();
                let oracle = two_pass_variance_of_mean(&values);
                assert!((variance - oracle).abs() <= tolerance(&values), "{samples}: {variance} {oracle}");
                assert!(tolerance(&values) < 1e-9 * oracle, "a tolerance that sees nothing");
            }
        }
    }
}

#[test]
fn small_variance_on_a_large_mean_survives() {
    // In f32 sums this reads 508.9 (numerics.md); the true variance of u/1 is 1/12.
    let mut random = SplitMix(7);
    let noise: Vec<f32> = (0..4096).map(|_| 10_000.0 + random.unit()).collect();
    let film = filled((1, 1), noise.len(), |_, _, s| [noise[s]; 3]);
    let values: Vec<f64> = noise.iter().map(|&v| f64::from(v)).collect();
    let (variance, oracle) = (film.variance_of_mean(0, 0).unwrap()[0], two_pass_variance_of_mean(&values));
    assert!((variance - oracle).abs() <= tolerance(&values));
    assert!(tolerance(&values) < 0.01 * oracle, "a tolerance that sees nothing");
}

#[test]
fn constant_input_has_no_negative_variance() {
    let mut random = SplitMix(3);
    for samples in [2usize, 3, 7, 64, 100, 129, 1000] {
        let values: Vec<f32> = (0..64).map(|_| random.unit() * 1e3).collect();
        let film = filled((64, 1), samples, |x, _, _| [values[x as usize], f32::MAX, 1e-30]);
        for x in 0..64 {
            let variance = film.variance_of_mean(x, 0).unwrap();
            let inputs = [values[x as usize], f32::MAX, 1e-30];
            for (v, input) in variance.into_iter().zip(inputs) {
                let bound = tolerance(&vec![f64::from(input); samples]);
                assert!(v >= 0.0 && v <= bound, "{samples} x {input}: {v}");
            }
        }
    }
}

#[test]
fn one_sample_has_no_variance() {
    let film = filled((1, 1), 1, |_, _, _| [1.0, 2.0, 3.0]);
    assert_eq!((film.variance_of_mean(0, 0), film.relative_error()), (None, None));
    assert_eq!(film.mean(0, 0), [1.0, 2.0, 3.0]);
}

#[test]
fn relative_error_by_hand() {
    // Samples 0 and 2: mean 1, s² = 2, var = 1, so 1/1.01; a constant 3 has none. Two pixels, three channels.
    let film = filled((2, 1), 2, |x, _, s| if x == 0 { [2.0 * s as f32, 3.0, 3.0] } else { [3.0; 3] });
    let expected = (1.0f64 / 1.01 / 6.0).sqrt();
    assert!((film.relative_error().unwrap() - expected).abs() <= 4.0 * f64::EPSILON * expected);
}

/// An estimate of something else is added to the mean, and its variance to that of the mean.
#[test]
fn estimates_are_added_with_their_variances() {
    for samples in [2u64, 37, 64, 100, 256] {
        let mut film = rendered((3, 2), 2, FilmChannels::ColourAndAovs, samples, 50);
        let before = film.clone();
        let added = |x: u32, y: u32, c: usize| [0.5 + f64::from(x) + 10.0 * c as f64, 0.01 * f64::from(1 + y)];
        film.tiles_mut().iter_mut().for_each(|tile| tile.add_estimate(|x, y| [0, 1, 2].map(|c| added(x, y, c))));
        for (y, x) in (0..2).flat_map(|y| (0..3).map(move |x| (y, x))) {
            let (mean, variance) = (before.mean(x, y), before.variance_of_mean(x, y).unwrap());
            let (with, variance_with) = (film.mean(x, y), film.variance_of_mean(x, y).unwrap());
            for c in 0..3 {
                let ([more, more_variance], scale) = (added(x, y, c), mean[c] + 30.0);
                assert!((with[c] - mean[c] - more).abs() < 1e-13 * scale, "{samples}: {} {}", with[c], mean[c] + more);
                let error = variance_with[c] - variance[c] - more_variance;
                assert!(error.abs() < 1e-11 * (variance[c] + scale * scale), "{samples}: off by {error}");
            }
            assert_eq!(film.pixel(x, y).aovs(), before.pixel(x, y).aovs());
        }
    }
}
