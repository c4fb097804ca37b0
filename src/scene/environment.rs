//! Latitude-longitude environment images from OpenEXR files.

use super::EnvironmentImage;
use super::error::SceneError;
use exr::meta::{MetaData, header::Header};
use exr::prelude::{ReadChannels, ReadLayers};
use std::io::Cursor;
use std::path::Path;

/// The most texels of an environment: 32,768 × 16,384.
const MOST_TEXELS: usize = 1 << 29;
/// The most a file is believed to shrink by compression. OpenEXR's methods bottom out near 1,030:1 (ZIP) on constant
/// images.
const BEST_COMPRESSION: usize = 4096;

/// Reads the first layer with channels R, G and B (16- or 32-bit), multiplied by `scale`.
///
/// # Errors
/// A file that cannot be read, lacks the channels, claims more than it can hold, or holds a texel that is negative or
/// not finite (before or after scaling).
pub(super) fn read(file: &Path, scale: [f32; 3]) -> Result<EnvironmentImage, SceneError> {
    let bytes = std::fs::read(file).map_err(|error| SceneError::unreadable(file, &error))?;
    let broken = |error: exr::error::Error| {
        let mend = "give a latitude-longitude OpenEXR image with channels R, G and B";
        SceneError::whole(file, format!("is not a readable OpenEXR image: {error}"), mend)
    };
    let headers = MetaData::read_from_buffered(Cursor::new(&bytes), false).map_err(broken)?.headers;
    for header in &headers {
        check_claims(header, bytes.len()).map_err(|message| SceneError::whole(file, message, "give another image"))?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| EnvironmentImage {
                width: size.width(),
                height: size.height(),
                texels: vec![[0.0; 3]; size.area()],
                rotation: 0.0,
            },
            |image: &mut EnvironmentImage, at, (r, g, b): (f32, f32, f32)| {
                image.texels[at.y() * image.width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(&bytes))
        .map_err(broken)?;
    scaled(image.layer_data.channel_data.pixels, scale, file)
}

impl EnvironmentImage {
    /// Reads a latitude-longitude OpenEXR file as it is.
    ///
    /// # Errors
    /// As for a scene's environment.
    pub fn load(file: &Path) -> Result<Self, SceneError> {
        read(file, [1.0; 3])
    }
}

/// A header is believed before anything is allocated by it, so it must be credible.
fn check_claims(header: &Header, file_bytes: usize) -> Result<(), String> {
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    let texels = width.checked_mul(height).filter(|&texels| texels <= MOST_TEXELS);
    let Some(texels) = texels else {
        return Err(format!("claims {width} x {height} texels; at most {MOST_TEXELS} are read"));
    };
    let claimed = texels.saturating_mul(header.channels.bytes_per_pixel);
    if claimed / BEST_COMPRESSION > file_bytes {
        return Err(format!("claims {width} x {height} texels, but the file has only {file_bytes} bytes"));
    }
    Ok(())
}

fn scaled(mut image: EnvironmentImage, scale: [f32; 3], file: &Path) -> Result<EnvironmentImage, SceneError> {
    for (i, texel) in image.texels.iter_mut().enumerate() {
        let written = *texel;
        for (channel, factor) in texel.iter_mut().zip(scale) {
            *channel *= factor;
        }
        let is_radiance = |c: &f32| c.is_finite() && *c >= 0.0;
        if !(written.iter().all(is_radiance) && texel.iter().all(is_radiance)) {
            let (column, row) = (i % image.width, i / image.width);
            return Err(SceneError::whole(
                file,
                format!("texel at column {column}, row {row} is {written:?}: radiance is finite and >= 0"),
                "mend the image, or lower `radiance` if scaling overflows",
            ));
        }
    }
    Ok(image)
}
