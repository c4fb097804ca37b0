//! Images of the largest budget and where they are wrong, as PNG files for the page.

use super::ConvergeError;
use super::reference::Reference;
use super::run::Plan;
use super::store::Store;
use super::summary::{ConvergeReport, Row};
use crate::film::png::{srgb8, write_with};
use crate::film::{FilmError, read_exr};
use crate::report::diff::colour;
use crate::report::page::Image;
use std::path::Path;

/// Larger images are averaged down to this side: the page holds all of them.
const LARGEST_SIDE: u32 = 640;

/// What [`write()`] writes for so many variants, in the study's folder.
pub fn names(variants: usize) -> impl Iterator<Item = String> {
    let of_variant = |number| [format!("images/variant-{number}.png"), format!("images/variant-{number}-error.png")];
    std::iter::once("images/reference.png".to_owned()).chain((0..variants).flat_map(of_variant))
}

/// Writes `images/*.png` and returns them: reference, then image and error map of each variant.
pub fn write(
    plan: &Plan,
    store: &Store,
    reference: &Reference,
    report: &ConvergeReport,
) -> Result<Vec<Image>, ConvergeError> {
    let folder = plan.folder.join("images");
    std::fs::create_dir_all(&folder).map_err(|error| FilmError::write(&folder, error))?;
    let view = View::new(reference.width, reference.height);
    let truth = view.reduce(reference.rgb());
    let stops = plan.exposure.map_or_else(|| exposure(&truth), f64::from);
    let shown = |rgb: [f64; 3]| rgb.map(|value| srgb8(value * stops.exp2()));
    let path = folder.join("reference.png");
    let samples = reference.samples_per_pixel.map_or(String::new(), |n| format!("{n} samples a pixel, "));
    let caption = format!("{samples}exposure of all {stops:+} EV").replace('-', "−");
    let mut images = vec![view.image(&path, "reference".into(), caption, |i| shown(truth[i]))?];
    for (number, variant) in report.variants.iter().enumerate() {
        let Some((row, seed)) = variant.rows.last().and_then(|row| Some((row, row.seeds.first()?))) else { continue };
        let Some(cell) = store.cells.iter().find(|cell| cell.image == seed.image) else { continue };
        let image = view.reduce(read_exr(&store.path_of(cell))?.rgb());
        let path = |what: &str| folder.join(format!("variant-{number}{what}.png"));
        images.push(view.image(&path(""), variant.name.clone(), caption_of(row), |i| shown(image[i]))?);
        let error = "red: too bright, blue: too dark; 1 % shows as a tenth of full".to_owned();
        let name = format!("{}: error", variant.name);
        images.push(view.image(&path("-error"), name, error, |i| colour(image[i], truth[i]))?);
    }
    Ok(images)
}

/// Whole stops that bring the brightest channel of 95 % of the pixels to 1 or below, and of some above ½.
fn exposure(image: &[[f64; 3]]) -> f64 {
    let brightest = |rgb: &[f64; 3]| rgb.iter().copied().fold(0.0, f64::max);
    let mut values: Vec<f64> = image.iter().map(brightest).filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    match values.get(values.len() * 95 / 100) {
        // Plus zero: −0 would be printed as such.
        Some(&level) if level > 0.0 => (-level.log2()).floor().clamp(-30.0, 30.0) + 0.0,
        _ => 0.0,
    }
}

fn caption_of(row: &Row) -> String {
    format!("{} samples a pixel, {:.3} s, relMSE {:.2e}", row.samples_per_pixel, row.seconds.value, row.relmse.value)
}

/// How the full image is reduced: by boxes of `step` × `step` pixels.
struct View {
    width: u32,
    height: u32,
    step: u32,
}

impl View {
    fn new(width: u32, height: u32) -> Self {
        View { width, height, step: width.max(height).div_ceil(LARGEST_SIDE) }
    }

    fn size(&self) -> (u32, u32) {
        (self.width.div_ceil(self.step), self.height.div_ceil(self.step))
    }

    /// Means over the boxes, row-major.
    fn reduce(&self, planes: [&[f32]; 3]) -> Vec<[f64; 3]> {
        let (across, down) = self.size();
        let boxes = (0..down).flat_map(|y| (0..across).map(move |x| (x, y)));
        boxes.map(|(x, y)| planes.map(|plane| self.mean(plane, x, y))).collect()
    }

    fn mean(&self, plane: &[f32], x: u32, y: u32) -> f64 {
        let columns = x * self.step..((x + 1) * self.step).min(self.width);
        let rows = y * self.step..((y + 1) * self.step).min(self.height);
        let count = f64::from((columns.end - columns.start) * (rows.end - rows.start));
        let row = |y: u32| &plane[(y * self.width) as usize..][columns.start as usize..columns.end as usize];
        rows.flat_map(|y| row(y).iter().map(|&value| f64::from(value))).sum::<f64>() / count
    }

    fn image(
        &self,
        path: &Path,
        name: String,
        caption: String,
        colour: impl Fn(usize) -> [u8; 3] + Sync,
    ) -> Result<Image, FilmError> {
        let (across, down) = self.size();
        write_with(path, (across, down), |x, y| colour(y as usize * across as usize + x as usize))?;
        let png = std::fs::read(path)
            .map_err(|error| FilmError::read(path, format!("{error}; render anew, or allow reading it")))?;
        Ok(Image { name, caption, png })
    }
}
