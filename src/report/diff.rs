//! A picture of where A differs from B.

use std::path::Path;

use crate::film::{ExrImage, FilmError, png};

/// Yellow-green: a value that is NaN or infinite.
pub const NON_FINITE: [u8; 3] = [160, 255, 0];

/// Writes the relative difference of A from B in false colour.
///
/// Legend: **black** equal; **red** A is brighter, **blue** A is darker. The magnitude is d = the root mean square over
/// channels of (a − b)/√(b² + 0.01), of which relMSE is the mean square; brightness is √d: 1 % shows as a tenth of full,
/// 10 % as a third, 100 % and more as full. The sign is that of Σ (a − b). [`NON_FINITE`] marks values that are none.
///
/// # Errors
/// The file cannot be written. The images must have one size; what lies outside `b` reads as not finite.
pub fn write_diff(a: &ExrImage, b: &ExrImage, path: &Path) -> Result<(), FilmError> {
    let (planes_a, planes_b) = (a.rgb(), b.rgb());
    png::write_with(path, (a.width, a.height), |x, y| {
        let i = y as usize * a.width as usize + x as usize;
        let value = |plane: &[f32]| f64::from(plane.get(i).copied().unwrap_or(f32::NAN));
        colour(planes_a.map(value), planes_b.map(value))
    })
}

/// The colour of one pixel by the legend of [`write_diff`].
pub fn colour(a: [f64; 3], b: [f64; 3]) -> [u8; 3] {
    let (mut squares, mut sign) = (0.0, 0.0);
    for c in 0..3 {
        let difference = a[c] - b[c];
        squares += difference * difference / (b[c] * b[c] + 0.01);
        sign += difference;
    }
    if !squares.is_finite() {
        return NON_FINITE;
    }
    let level = (255.0 * (squares / 3.0).sqrt().min(1.0).sqrt()).round() as u8;
    // The weaker channel keeps faint differences from vanishing on a dark ground.
    let faint = level / 3;
    if sign >= 0.0 { [level, faint, faint] } else { [faint, faint, level] }
}
