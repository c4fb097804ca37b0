//! 8-bit PNG previews: exposure, then the sRGB curve.

use std::io::Write;
use std::path::Path;
use std::sync::LazyLock;
use std::time::Instant;

use rayon::prelude::*;

use super::beside::write_beside;
use super::error::FilmError;
use super::sheet::Film;

/// Linear value to 8-bit sRGB (IEC 61966-2-1), rounded to nearest; below 0 and NaN give 0, above 1 gives 255.
///
/// The code is the number of thresholds that the value reaches, a threshold being the linear value half a code below
/// the next one: no `pow` for each pixel, and no platform's `pow` decides a bit.
pub fn srgb8(linear: f64) -> u8 {
    static THRESHOLDS: LazyLock<[f64; 255]> =
        LazyLock::new(|| std::array::from_fn(|code| srgb_to_linear((code as f64 + 0.5) / 255.0)));
    THRESHOLDS.partition_point(|&threshold| threshold <= linear) as u8
}

fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Writes the film's means as a PNG (beside `path` first, then renamed). `exposure` in stops: values are multiplied by
/// 2^exposure. Works in the current rayon pool.
///
/// # Errors
/// The file cannot be written; the message names `path`.
pub fn write_png(film: &Film, path: &Path, exposure: f32) -> Result<(), FilmError> {
    let factor = f64::from(exposure).exp2();
    write_with(path, (film.width(), film.height()), |x, y| film.mean(x, y).map(|value| srgb8(value * factor)))
}

/// Writes a PNG of sRGB bytes given by pixel, column then row; `colour` is called from several threads.
///
/// # Errors
/// As [`write_png`]; also for an empty image.
pub fn write_with(
    path: &Path,
    (width, height): (u32, u32),
    colour: impl Fn(u32, u32) -> [u8; 3] + Sync,
) -> Result<(), FilmError> {
    write_beside(path, |file| encode(file, (width, height), colour))
}

/// Seconds and bytes of encoding the uppermost `rows` rows in the current rayon pool: a measure of what [`write_png`]
/// will take.
pub fn trial(film: &Film, rows: u32, exposure: f32) -> (f64, usize) {
    let start = Instant::now();
    let factor = f64::from(exposure).exp2();
    let mut sink = Vec::new();
    let colour = |x, y| film.mean(x, y).map(|value| srgb8(value * factor));
    // What fails here fails again, and is reported, when the file is written.
    let _ = encode(&mut sink, (film.width(), rows.min(film.height())), colour);
    (start.elapsed().as_secs_f64(), sink.len())
}

fn encode(
    file: impl Write,
    (width, height): (u32, u32),
    colour: impl Fn(u32, u32) -> [u8; 3] + Sync,
) -> Result<(), png::EncodingError> {
    let mut bytes = vec![0u8; 3 * width as usize * height as usize];
    bytes.par_chunks_mut(3 * (width as usize).max(1)).enumerate().for_each(|(y, row)| {
        for (pixel, x) in row.chunks_exact_mut(3).zip(0u32..) {
            pixel.copy_from_slice(&colour(x, y as u32));
        }
    });
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()
}
