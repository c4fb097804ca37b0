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
    let mut texels = Vec::with_capacity(width * height);
    for row in 0..height {
        let planes = image.rgb().map(|plane| &plane[row * width..][..width]);
        let texel = |column: usize| core::array::from_fn(|k| planes[k][column] * scale[k]);
        texels.extend((0..width).map(texel));
        let scaled = texels[row * width..].as_flattened();
        if !(planes.into_iter().all(holds_radiance) && holds_radiance(scaled)) {
            let unsound = |i: &usize| {
                let written = planes.map(|plane| plane[*i]);
                !(holds_radiance(&written) && holds_radiance(&scaled[3 * i..][..3]))
            };
            let column = (0..width).find(unsound).unwrap_or_default();
            let written = planes.map(|plane| plane[column]);
            return Err(SceneError::whole(
                file,
                format!("texel at column {column}, row {row} is {written:?}: radiance is finite and >= 0"),
                "mend the image, or lower `radiance` if scaling overflows",
            ));
        }
    }
    Ok(EnvironmentImage { width, height, texels, rotation: 0.0 })
}

/// Are all finite and ≥ 0? Without a branch, so that a register of values is looked at at once.
fn holds_radiance(channels: &[f32]) -> bool {
    channels.iter().fold(true, |all, c| all & c.is_finite() & (*c >= 0.0))
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
