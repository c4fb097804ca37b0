//! Means over square blocks of an image.

use super::reference::Reference;
use super::replicates::Replicates;
use crate::stats::{self, Moments};

/// The reference sums thousands of samples a pixel in f32: where it looks straight at a uniform environment of radiance
/// 1, its five images with such pixels read .99994 to 1.
const REFERENCE_SUMS: f64 = 1e-4;

/// A block this much darker than the image counts as black: only the reference's thousands of samples may have caught the
/// edge of something bright.
const BLACK: f64 = 1e-5;

/// Mean over the pixels of a block.
fn block_mean(pixels: &[[f64; 3]], (width, height): (u32, u32), sides: u32, block: u32, c: usize) -> f64 {
    let (w, h) = (width / sides, height / sides);
    let (x0, y0) = (block % sides * w, block / sides * h);
    let rows = (y0..y0 + h).flat_map(|y| (x0..x0 + w).map(move |x| y * width + x));
    rows.map(|i| pixels[i as usize][c]).sum::<f64>() / f64::from(w * h)
}

/// Panics unless the mean of every block agrees with the reference, as one of `tests` means. `sides` × `sides` blocks;
/// 1 is the whole image.
pub fn check(replicates: &Replicates, reference: &Reference, name: &str, sides: u32, tests: usize) {
    let size = (replicates.width, replicates.height);
    assert_eq!(size, (reference.width, reference.height), "{name}: sizes");
    assert!(size.0.is_multiple_of(sides) && size.1.is_multiple_of(sides), "{name}: blocks of whole pixels");
    let pixels_in_block = f64::from(size.0 * size.1 / (sides * sides));
    let bound = stats::t_bound(tests, (replicates.images.len() - 1) as f64);
    let all = (0..3).map(|c| block_mean(&replicates.sample_variance, size, 1, 0, c)).sum::<f64>() / 3.0;
    let mut visible = Vec::new();
    let mut worst = (0.0f64, String::new());
    for (block, c) in (0..sides * sides).flat_map(|block| (0..3).map(move |c| (block, c))) {
        let ours: Moments = replicates.images.iter().map(|image| block_mean(image, size, sides, block, c)).collect();
        let expected = block_mean(&reference.pixels, size, sides, block, c);
        let noise = if sides == 1 {
            reference.mean_error[c]
        } else {
            // Both trace paths with the same strategies: where our samples vary more than on average, so do its.
            let here = block_mean(&replicates.sample_variance, size, sides, block, c);
            reference.rmse_floor * (here / all / pixels_in_block).sqrt()
        };
        let error = ours.std_error().hypot(noise);
        let off = ours.mean - expected;
        let allowed = bound * error + REFERENCE_SUMS * expected + BLACK * reference.mean[c];
        visible.push(allowed / expected.max(1e-3));
        if off.abs() / allowed >= worst.0 {
            let (x, y) = (block % sides, block / sides);
            let text = format!(
                "block {x},{y} of {sides}×{sides}, channel {c}: mean {:.6e} for {expected:.6e}, off by {:+.2} standard errors of \
                 {error:.2e}, {bound:.2} allowed as one of {tests} tests",
                ours.mean,
                off / error
            );
            worst = (off.abs() / allowed, text);
        }
    }
    visible.sort_by(f64::total_cmp);
    let percent = |at: usize| 100.0 * visible[at];
    println!(
        "{name}, {sides}×{sides} blocks: a bias of {:.2} % (best block) {:.2} % (median) {:.2} % (worst) would be seen; worst: {}",
        percent(0),
        percent(visible.len() / 2),
        percent(visible.len() - 1),
        worst.1
    );
    assert!(worst.0 <= 1.0, "{name}: {}", worst.1);
}
