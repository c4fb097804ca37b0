//! One scene, one seed, one number of samples: one image, bit for bit, however it is computed.

mod metamorphic;
pub mod scenes;
mod schedules;
mod shipped;

use octolux::film::Film;

/// Bits of mean and variance of every pixel.
fn bits(film: &Film) -> Vec<[u64; 6]> {
    let pixel = |x, y| {
        let (m, v) = (film.mean(x, y), film.variance_of_mean(x, y).unwrap_or_default());
        [m[0], m[1], m[2], v[0], v[1], v[2]].map(f64::to_bits)
    };
    (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

/// Panics, naming the first pixel, unless both films hold the same bits.
#[track_caller]
pub fn assert_same(name: &str, found: &Film, expected: &Film) {
    assert_eq!((found.width(), found.height()), (expected.width(), expected.height()), "{name}: size");
    let (found_bits, expected_bits) = (bits(found), bits(expected));
    let differing = found_bits.iter().zip(&expected_bits).filter(|(f, e)| f != e).count();
    if let Some(i) = found_bits.iter().zip(&expected_bits).position(|(f, e)| f != e) {
        let (x, y) = (i as u32 % found.width(), i as u32 / found.width());
        panic!(
            "{name}: {differing} pixels differ, first ({x}, {y}): {:?}, expected {:?}",
            found.mean(x, y),
            expected.mean(x, y)
        );
    }
}
