//! Error, bias and variance over seeds: by hand, by brute force, and by simulation.

use super::coverage::normal;
use crate::stats::{Rng, z_bound};
use octolux::report::converge::{Accumulator, LARGEST_TRUSTED_SHARE, Moments, Split};
use octolux::report::fit::Estimate;

/// An image of one row: the same plane for each channel.
fn grey(values: &[f32]) -> [Vec<f32>; 3] {
    std::array::from_fn(|_| values.to_vec())
}

fn borrowed(image: &[Vec<f32>; 3]) -> [&[f32]; 3] {
    image.each_ref().map(Vec::as_slice)
}

fn split(reference: &[f32], images: &[Vec<f32>], noise: f64, weight: impl Fn(f64) -> f64) -> Split {
    let reference = grey(reference);
    let mut accumulator = Accumulator::new(borrowed(&reference));
    images.iter().for_each(|image| accumulator.add(borrowed(&grey(image))));
    accumulator.moments(weight).split(noise)
}

#[test]
fn a_small_case_by_hand() {
    // d = (1, 3), (2, 0), (0, 0) over two pixels.
    let images = [vec![2.0, 5.0], vec![3.0, 2.0], vec![1.0, 2.0]];
    let s = split(&[1.0, 2.0], &images, 0.5, |_| 1.0);
    // Squares 10, 4, 0 over two values: 5, 2, 0.
    assert!((s.error.value - (7.0 / 3.0 - 0.5)).abs() < 1e-12);
    // Pairs: d1·d2 = 2, others 0: three pairs of mean 2/3, over two values.
    assert!((s.bias_squared.unwrap().value - (1.0 / 3.0 - 0.5)).abs() < 1e-12);
    // Variances of (1, 2, 0) and (3, 0, 0) are 1 and 3.
    assert!((s.variance.unwrap().value - 2.0).abs() < 1e-12);
    // 9 of 14, in one channel of three alike.
    assert!((s.largest_share - 9.0 / 14.0 / 3.0).abs() < 1e-12);
    let two = split(&[1.0, 2.0], &images[..2], 0.0, |_| 1.0);
    assert_eq!((two.bias_squared, two.variance), (None, None));
}

#[test]
fn parts_are_those_of_brute_force_over_pairs() {
    let mut rng = Rng::new(31);
    let reference: Vec<f32> = (0..50).map(|_| rng.f32()).collect();
    let images: Vec<Vec<f32>> = (0..6).map(|_| (0..50).map(|_| rng.f32()).collect()).collect();
    let weight = |r: f64| 1.0 / (r * r + 0.01);
    let pairs = |seeds: &[usize]| {
        let mut sum = 0.0;
        for &s in seeds {
            for &t in seeds.iter().filter(|&&t| t != s) {
                for i in 0..50 {
                    let r = f64::from(reference[i]);
                    sum += weight(r) * (f64::from(images[s][i]) - r) * (f64::from(images[t][i]) - r) / 50.0;
                }
            }
        }
        sum / (seeds.len() * (seeds.len() - 1)) as f64
    };
    let bias = split(&reference, &images, 0.0, weight).bias_squared.unwrap();
    let all: Vec<usize> = (0..6).collect();
    assert!((bias.value - pairs(&all)).abs() < 1e-10 * bias.value.abs().max(1.0), "{bias:?}");
    let without: Vec<f64> =
        all.iter().map(|&s| pairs(&all.iter().copied().filter(|&t| t != s).collect::<Vec<_>>())).collect();
    let mean = without.iter().sum::<f64>() / 6.0;
    let jackknife = (5.0 / 6.0 * without.iter().map(|x| (x - mean).powi(2)).sum::<f64>()).sqrt();
    assert!((bias.standard_error - jackknife).abs() < 1e-9 * jackknife, "{bias:?} {jackknife}");
}

/// Images with bias .2 and variance .25 against a reference with variance .09 of its own.
struct Trial {
    rng: Rng,
}

impl Trial {
    const VALUES: usize = 300;

    fn split(&mut self) -> Split {
        let mut draw = |mean: f32, deviation: f32| -> Vec<f32> {
            (0..Self::VALUES).map(|_| mean + deviation * normal(&mut self.rng) as f32).collect()
        };
        let reference = draw(1.0, 0.3);
        let images: Vec<_> = (0..8).map(|_| draw(1.2, 0.5)).collect();
        split(&reference, &images, 0.09, |_| 1.0)
    }
}

/// 1,500 trials; a shift of the mean by a fifth of one trial's deviation would be found with probability beyond 99.9 %.
#[test]
fn error_bias_and_variance_are_unbiased_once_the_references_noise_is_off() {
    let mut trial = Trial { rng: Rng::new(32) };
    let splits: Vec<_> = (0..1_500).map(|_| trial.split()).collect();
    let check = |name: &str, values: Vec<f64>, truth: f64| {
        let e = Estimate::mean(&values);
        let z = (e.value - truth) / e.standard_error;
        assert!(z.abs() < z_bound(3), "{name}: {} instead of {truth}, z = {z:.2}", e.value);
    };
    check("error", splits.iter().map(|s| s.error.value).collect(), 0.04 + 0.25);
    check("bias", splits.iter().map(|s| s.bias_squared.unwrap().value).collect(), 0.04);
    check("variance", splits.iter().map(|s| s.variance.unwrap().value).collect(), 0.25);
}

/// The standard error of a coverage is .006 here: below .92 it would be found with a probability beyond 99.9 %. Above,
/// the jackknife's variance is too large on average (Efron & Stein 1981), and twice what it should be where pairs carry
/// no bias at all: never so much that the interval says nothing. The reference is exact, since its noise is one draw for
/// all seeds and no interval over seeds can hold it.
#[test]
fn intervals_of_bias_and_variance_cover_them() {
    const TRIALS: usize = 1_500;
    let mut rng = Rng::new(33);
    let (mut bias, mut variance) = (0, 0);
    for _ in 0..TRIALS {
        let images: Vec<Vec<f32>> =
            (0..8).map(|_| (0..100).map(|_| 1.2 + 0.5 * normal(&mut rng) as f32).collect()).collect();
        let s = split(&[1.0; 100], &images, 0.0, |_| 1.0);
        let covers = |e: Estimate, truth: f64| usize::from(e.lo <= truth && truth <= e.hi);
        bias += covers(s.bias_squared.unwrap(), 0.04);
        variance += covers(s.variance.unwrap(), 0.25);
    }
    for (name, hits) in [("bias", bias), ("variance", variance)] {
        let share = hits as f64 / TRIALS as f64;
        assert!((0.93..0.99).contains(&share), "{name}: {share}");
    }
}

/// Seeds whose squared errors are drawn from `square`.
fn shares_and_coverage(mean: f64, mut square: impl FnMut() -> f64) -> (f64, f64) {
    const TRIALS: usize = 1_000;
    let (mut flagged, mut covered) = (0, 0);
    for _ in 0..TRIALS {
        let mut moments = Moments { cross: vec![0.0; 8], values: 1_000, ..Moments::default() };
        for _ in 0..8 {
            let mut sum = 0.0;
            for _ in 0..moments.values {
                let value = square();
                sum += value;
                moments.largest = moments.largest.max(value);
            }
            moments.squares.push(sum);
        }
        let s = moments.split(0.0);
        flagged += usize::from(s.largest_share > LARGEST_TRUSTED_SHARE);
        covered += usize::from(s.error.lo <= mean && mean <= s.error.hi);
    }
    (flagged as f64 / TRIALS as f64, covered as f64 / TRIALS as f64)
}

#[test]
fn heavy_tails_whose_intervals_fail_are_flagged_and_light_ones_are_not() {
    let mut rng = Rng::new(34);
    let (flagged, covered) = shares_and_coverage(1.0, || normal(&mut rng).powi(2));
    assert!(flagged < 0.01 && (covered - 0.95).abs() < 0.025, "normal: {flagged} {covered}");
    let deviation = 2.5f64;
    let mean = (0.5 * deviation * deviation).exp();
    let (flagged, covered) = shares_and_coverage(mean, || (deviation * normal(&mut rng)).exp());
    assert!(flagged > 0.99 && covered < 0.92, "log-normal: {flagged} {covered}");
}
