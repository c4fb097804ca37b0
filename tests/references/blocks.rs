//! Means over parts of an image.

use super::reference::Reference;
use super::replicates::Replicates;
use crate::stats::{self, Moments};

/// The reference sums thousands of samples a pixel in f32: where it looks straight at a uniform environment of radiance
/// 1, its five images with such pixels read .99994 to 1.
const REFERENCE_SUMS: f64 = 1e-4;
/// A part this much darker than the image counts as black: only the reference's thousands of samples may have caught the
/// edge of something bright.
const BLACK: f64 = 1e-5;

/// Some of an image's pixels, by index.
pub struct Part {
    label: String,
    pixels: Vec<usize>,
}

impl Part {
    pub fn whole(reference: &Reference) -> Self {
        Part { label: "the whole image".into(), pixels: (0..reference.pixels.len()).collect() }
    }

    /// Pixels that stay below `limit` in the reference: where lamps in view rule the mean of the image.
    pub fn below(reference: &Reference, limit: f64) -> Self {
        let dim = |i: &usize| reference.pixels[*i].iter().all(|&x| x < limit);
        Part { label: format!("pixels below {limit}"), pixels: (0..reference.pixels.len()).filter(dim).collect() }
    }

    /// `sides` × `sides` blocks.
    pub fn blocks(reference: &Reference, sides: u32) -> Vec<Self> {
        let (width, height) = (reference.width, reference.height);
        assert!(width.is_multiple_of(sides) && height.is_multiple_of(sides), "blocks of whole pixels");
        let (w, h) = (width / sides, height / sides);
        let block = |bx: u32, by: u32| {
            let rows = by * h..(by + 1) * h;
            let pixels = rows.flat_map(|y| (bx * w..(bx + 1) * w).map(move |x| (y * width + x) as usize)).collect();
            Part { label: format!("block {bx},{by} of {sides}×{sides}"), pixels }
        };
        (0..sides).flat_map(|by| (0..sides).map(move |bx| (bx, by))).map(|(bx, by)| block(bx, by)).collect()
    }

    fn mean(&self, image: &[[f64; 3]], c: usize) -> f64 {
        self.pixels.iter().map(|&i| image[i][c]).sum::<f64>() / self.pixels.len() as f64
    }
}

/// Panics unless the mean over each part agrees with the reference in every channel, as one of `tests` means.
pub fn check(replicates: &Replicates, reference: &Reference, name: &str, parts: &[Part], tests: usize) {
    assert_eq!((replicates.width, replicates.height), (reference.width, reference.height), "{name}: sizes");
    let bound = stats::t_bound(tests, (replicates.images.len() - 1) as f64);
    let whole = Part::whole(reference);
    let variance = (0..3).map(|c| whole.mean(&replicates.sample_variance, c)).sum::<f64>() / 3.0;
    let mut visible = Vec::new();
    let mut worst = (0.0f64, String::new());
    for (part, c) in parts.iter().flat_map(|part| (0..3).map(move |c| (part, c))) {
        let ours: Moments = replicates.images.iter().map(|image| part.mean(image, c)).collect();
        let expected = part.mean(&reference.pixels, c);
        let noise = if part.pixels.len() == reference.pixels.len() {
            reference.mean_error[c]
        } else {
            // Both trace paths with the same strategies: where our samples vary more than on average, so do its.
            let here = part.mean(&replicates.sample_variance, c);
            reference.rmse_floor * (here / variance / part.pixels.len() as f64).sqrt()
        };
        let error = ours.std_error().hypot(noise);
        let off = ours.mean - expected;
        let allowed = bound * error + REFERENCE_SUMS * expected + BLACK * reference.mean[c];
        visible.push(100.0 * allowed / expected.max(1e-3));
        if off.abs() / allowed >= worst.0 {
            let text = format!(
                "{}, channel {c}: mean {:.6e} for {expected:.6e}, off by {:+.2} standard errors of {error:.2e}, {bound:.2} \
                 allowed as one of {tests} tests",
                part.label,
                ours.mean,
                off / error
            );
            worst = (off.abs() / allowed, text);
        }
    }
    visible.sort_by(f64::total_cmp);
    println!(
        "{name}, {} parts such as {}: a bias of {:.2} % (best), {:.2} % (median), {:.2} % (worst part) would be seen; worst: {}",
        parts.len(),
        parts[0].label,
        visible[0],
        visible[visible.len() / 2],
        visible[visible.len() - 1],
        worst.1
    );
    assert!(worst.0 <= 1.0, "{name}: {}", worst.1);
}
