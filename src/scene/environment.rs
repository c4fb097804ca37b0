//! Latitude-longitude environment images from OpenEXR files.

use super::EnvironmentImage;
use super::error::SceneError;
use crate::film::exr_read;
use std::io::Cursor;
use std::path::Path;

/// The most texels of an environment: 32,768 × 16,384.
const MOST_TEXELS: usize = 1 << 29;

/// Reads the colours of an image as [`exr_read`] finds them, multiplied by `scale`.
///
/// # Errors
/// A file that cannot be read, has no colours, claims more than it can hold, or holds a texel that is negative or not
/// finite (before or after scaling).
pub(super) fn read(file: &Path, scale: [f32; 3]) -> Result<EnvironmentImage, SceneError> {
    let bytes = std::fs::read(file).map_err(|error| SceneError::unreadable(file, &error))?;
    let image = exr_read::decode_colours(Cursor::new(&bytes), bytes.len() as u64).map_err(|why| {
        SceneError::whole(file, why, "give a latitude-longitude OpenEXR image with channels R, G and B")
    })?;
    let (width, height) = (image.width as usize, image.height as usize);
    if width * height > MOST_TEXELS {
        let message = format!("has {width} x {height} texels; at most {MOST_TEXELS} are read");
        return Err(SceneError::whole(file, message, "give a smaller image"));
    }
    let [r, g, b] = image.rgb();
    let texels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect();
    scaled(EnvironmentImage { width, height, texels, rotation: 0.0 }, scale, file)
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
