//! Images over combinations of width, threads, tile size and plan.

use crate::film::Film;
use crate::kernel::{Width, World};
use crate::render::{self, Budget, Options, Progress};

/// One way to render.
#[derive(Clone, Debug, serde::Serialize)]
pub struct ImageCase {
    pub lanes: usize,
    pub threads: usize,
    pub tile: u32,
    /// Which of the given worlds.
    pub world: String,
    /// The first pixel whose sums differ, with both values of the first channel that does.
    pub difference: Option<PixelDifference>,
}

#[derive(Clone, Debug, serde::Serialize)]
pub struct PixelDifference {
    pub x: u32,
    pub y: u32,
    pub channel: usize,
    pub expected_bits: u64,
    pub found_bits: u64,
}

/// Renders each world at every width, with thread counts and tile sizes that change from case to case, and compares
/// mean and variance with the first world at width 1 on one thread. The combinations cover every value of each
/// setting, not their full product.
pub fn compare_images(
    worlds: &[(&str, &World)],
    samples: u64,
    widths: &[Width],
) -> Result<Vec<ImageCase>, rayon::ThreadPoolBuildError> {
    let Some(&(_, first)) = worlds.first() else { return Ok(Vec::new()) };
    let expected = render_film(first, Width::One, 1, 16, samples)?;
    let settings = [(1, 8), (2, 16), (3, 13), (2, 64)];
    let mut cases = Vec::new();
    for (w, &(name, world)) in worlds.iter().enumerate() {
        for (i, &width) in widths.iter().enumerate() {
            let (threads, tile) = settings[(w * widths.len() + i) % settings.len()];
            let film = render_film(world, width, threads, tile, samples)?;
            let difference = first_difference(&expected, &film);
            cases.push(ImageCase { lanes: width.lanes(), threads, tile, world: name.to_string(), difference });
        }
    }
    Ok(cases)
}

fn render_film(
    world: &World,
    width: Width,
    threads: usize,
    tile: u32,
    samples: u64,
) -> Result<Film, rayon::ThreadPoolBuildError> {
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    let options = Options { budget, width, tile, aovs: false, output_seconds: 0.0, adaptive: false };
    Ok(render::render(world, &options, &render::thread_pool(threads)?, &mut Progress::quiet()).film)
}

fn first_difference(expected: &Film, found: &Film) -> Option<PixelDifference> {
    let values = |film: &Film, x, y| {
        let pixel = film.pixel(x, y);
        let variance = pixel.variance_of_mean().unwrap_or_default();
        let mean = pixel.mean();
        [mean[0], mean[1], mean[2], variance[0], variance[1], variance[2]]
    };
    for y in 0..expected.height() {
        for x in 0..expected.width() {
            let (a, b) = (values(expected, x, y), values(found, x, y));
            if let Some(channel) = (0..6).find(|&c| a[c].to_bits() != b[c].to_bits()) {
                let (expected_bits, found_bits) = (a[channel].to_bits(), b[channel].to_bits());
                return Some(PixelDifference { x, y, channel, expected_bits, found_bits });
            }
        }
    }
    None
}
