//! Texture files: PNG and JPEG through `image`, OpenEXR through the film's reader.

use super::texture::{Image, Texels};
use crate::film::exr_read;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The most texels of a texture: 32,768 × 32,768.
const MOST_TEXELS: u64 = 1 << 30;
/// A header is believed up to this many bytes whatever the file's length, and beyond up to [`BEST_COMPRESSION`].
const ALWAYS_BELIEVED: u64 = 1 << 24;
/// The most a file is believed to shrink by compression: deflate reaches 1,032:1.
const BEST_COMPRESSION: u64 = 2048;

/// Reads each file once, whoever asks.
#[derive(Default)]
pub(super) struct ImageFiles {
    read: HashMap<PathBuf, Arc<Image>>,
}

impl ImageFiles {
    /// The image in a file.
    ///
    /// # Errors
    /// What is wrong with it, to follow the file's name.
    pub fn read(&mut self, path: &Path) -> Result<Arc<Image>, String> {
        let key = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if let Some(image) = self.read.get(&key) {
            return Ok(image.clone());
        }
        let image = Arc::new(read(path)?);
        self.read.insert(key, image.clone());
        Ok(image)
    }
}

fn read(path: &Path) -> Result<Image, String> {
    if path.is_dir() {
        return Err("is a folder, not an image".to_owned());
    }
    let bytes = std::fs::read(path).map_err(|error| format!("cannot be read: {error}"))?;
    let is_exr = bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]);
    let image = if is_exr { decode_exr(&bytes) } else { decode(&bytes) }?;
    if image.width == 0 || image.height == 0 {
        return Err("holds no texels".to_owned());
    }
    Ok(image)
}

fn decode(bytes: &[u8]) -> Result<Image, String> {
    let broken = |error: image::ImageError| format!("is not a whole, valid image: {error}");
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(|error| format!("cannot be read: {error}"))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("is neither PNG, JPEG nor OpenEXR".to_owned());
    }
    // Memory is judged below, by what the file can hold.
    reader.limits(Limits::no_limits());
    let decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MOST_TEXELS {
        return Err(format!("claims {width} x {height} texels; at most {MOST_TEXELS} are read"));
    }
    if decoder.total_bytes() > ALWAYS_BELIEVED.max(bytes.len() as u64 * BEST_COMPRESSION) {
        return Err(format!("claims {width} x {height} texels, but the file has only {} bytes", bytes.len()));
    }
    let (channels, texels) = match DynamicImage::from_decoder(decoder).map_err(broken)? {
        DynamicImage::ImageLuma8(image) => (1, Texels::Bytes(image.into_raw())),
        DynamicImage::ImageLumaA8(image) => (2, Texels::Bytes(image.into_raw())),
        DynamicImage::ImageRgb8(image) => (3, Texels::Bytes(image.into_raw())),
        DynamicImage::ImageRgba8(image) => (4, Texels::Bytes(image.into_raw())),
        DynamicImage::ImageLuma16(image) => (1, Texels::Words(image.into_raw())),
        DynamicImage::ImageLumaA16(image) => (2, Texels::Words(image.into_raw())),
        DynamicImage::ImageRgb16(image) => (3, Texels::Words(image.into_raw())),
        DynamicImage::ImageRgba16(image) => (4, Texels::Words(image.into_raw())),
        other => return Err(format!("has texels of a kind that is not read ({:?})", other.color())),
    };
    Ok(Image { width, height, channels, texels })
}

fn decode_exr(bytes: &[u8]) -> Result<Image, String> {
    let image = exr_read::decode_colours(Cursor::new(bytes), bytes.len() as u64)?;
    let [r, g, b] = image.rgb();
    let alpha = image.channel("A");
    let mut values = Vec::with_capacity(r.len() * if alpha.is_some() { 4 } else { 3 });
    for i in 0..r.len() {
        values.extend([r[i], g[i], b[i]]);
        values.extend(alpha.map(|plane| plane[i]));
    }
    let channels = if alpha.is_some() { 4 } else { 3 };
    Ok(Image { width: image.width, height: image.height, channels, texels: Texels::Floats(values) })
}
