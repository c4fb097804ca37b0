//! The film against plain f64 loops, its files against their formats, and comparisons against hand-computed numbers.

mod compare;
mod discarded;
mod exr;
mod files;
mod png;
mod shares;
mod state;
mod sums;
mod variance;

use octolux::film::{AovSample, Film, FilmChannels, TileFilm};
use std::path::PathBuf;

/// SplitMix64 (Steele, Lea, Flood 2014): a generator that shares nothing with the crate's own.
pub struct SplitMix(pub u64);

impl SplitMix {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 * (1.0 / 16_777_216.0)
    }
}

/// Radiance of (pixel, sample) as a function of these alone, over 24 binary orders of magnitude so that the order of
/// additions shows in the last bits.
pub fn radiance(x: u32, y: u32, sample: u64) -> [f32; 3] {
    let mut random = SplitMix((u64::from(x) << 40) ^ (u64::from(y) << 20) ^ sample ^ 0x5eed);
    std::array::from_fn(|_| random.unit() * (random.unit() * 16.0).exp2())
}

pub fn aov(x: u32, y: u32, sample: u64) -> AovSample {
    let [r, g, b] = radiance(x, y, sample ^ (1 << 50));
    AovSample { albedo: [r, g, b], normal: [r - g, g - b, b - r], depth: r + g, posterior: [r * r, g * g, b * b] }
}

/// Adds samples `first … first + count − 1` of a tile in one call.
pub fn add(tile: &mut TileFilm, first: u64, count: usize) {
    let rect = tile.rect();
    let slots = |f: &mut dyn FnMut(u32, u32, u64)| {
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                (0..count as u64).for_each(|s| f(x, y, first + s));
            }
        }
    };
    let (mut colours, mut aovs) = (Vec::new(), Vec::new());
    slots(&mut |x, y, s| colours.push(radiance(x, y, s)));
    if tile.channels().has_aovs() {
        slots(&mut |x, y, s| aovs.push(aov(x, y, s)));
    }
    tile.add_samples(first, count, &colours, &aovs);
}

/// A film with `samples` samples, added in passes of `pass`.
pub fn rendered(size: (u32, u32), tile: u32, channels: FilmChannels, samples: u64, pass: usize) -> Film {
    let mut film = Film::new(size.0, size.1, tile, channels, 0);
    for tile in film.tiles_mut() {
        while tile.next_sample() < samples {
            let first = tile.next_sample();
            add(tile, first, pass.min((samples - first) as usize));
        }
    }
    film
}

/// A film filled with `value(x, y, sample)`.
pub fn filled(size: (u32, u32), samples: usize, value: impl Fn(u32, u32, usize) -> [f32; 3]) -> Film {
    let mut film = Film::new(size.0, size.1, 16, FilmChannels::Colour, 0);
    for tile in film.tiles_mut() {
        let rect = tile.rect();
        let mut slots = Vec::new();
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                slots.extend((0..samples).map(|s| value(x, y, s)));
            }
        }
        tile.add_samples(0, samples, &slots, &[]);
    }
    film
}

/// The reference material, which is not part of the repository.
pub fn shared() -> Option<PathBuf> {
    let levels = ["..", "../..", "../../.."];
    let found = levels.iter().map(|up| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(up).join("shared"));
    let found = found.into_iter().find(|path| path.is_dir());
    if found.is_none() {
        println!("skipped: ../shared is not there");
    }
    found
}
