//! The mean of an image and how far it may be from the truth.

use crate::stats;
use octolux::film::Film;

/// One channel of an image.
#[derive(Clone, Copy, Debug)]
pub struct ImageMean {
    pub mean: f64,
    pub std_error: f64,
}

/// Means of the channels. Their standard errors come from the samples' variance within each pixel, so that pixels may
/// differ in what they expect. (Where pixels share paths their errors go together, and the true standard errors are larger.)
pub fn image_mean(film: &Film) -> [ImageMean; 3] {
    let pixels = f64::from(film.width()) * f64::from(film.height());
    let (mut mean, mut variance) = ([0.0; 3], [0.0; 3]);
    for y in 0..film.height() {
        for x in 0..film.width() {
            let v = film.variance_of_mean(x, y).expect("two samples or more");
            for (c, m) in film.mean(x, y).into_iter().enumerate() {
                mean[c] += m / pixels;
                variance[c] += v[c] / (pixels * pixels);
            }
        }
    }
    std::array::from_fn(|c| ImageMean { mean: mean[c], std_error: variance[c].sqrt() })
}

/// Panics unless every channel's mean is `expected` ± (`abs_tol` + Šidák's bound for one of `tests` tests · standard
/// error). `abs_tol` is for rounding. Prints the bias that could have been seen.
#[track_caller]
pub fn assert_image_mean(name: &str, film: &Film, expected: [f64; 3], abs_tol: f64, tests: usize) {
    let bound = stats::z_bound(tests);
    for (c, ImageMean { mean, std_error }) in image_mean(film).into_iter().enumerate() {
        let (off, allowed) = (mean - expected[c], bound * std_error + abs_tol);
        println!("{name}, channel {c}: {mean:.6e} for {:.6e}; a bias of {allowed:.1e} would be seen", expected[c]);
        assert!(
            off.abs() <= allowed,
            "{name}, channel {c}: mean {mean:.8} for {:.8}: off by {off:+.3e}, {:.2} standard errors of {std_error:.2e}; \
             allowed {bound:.2} of them as one of {tests} tests, plus {abs_tol:.1e}",
            expected[c],
            off / std_error
        );
    }
}
