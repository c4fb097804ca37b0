//! Samples that are not finite.

use super::filled;
use octolux::film::{AovSample, DiscardedSample, Film, FilmChannels};

fn bad(x: u32, y: u32, s: usize) -> bool {
    (x * 31 + y * 17 + s as u32 * 7).is_multiple_of(11)
}

#[test]
fn each_is_dropped_counted_and_named() {
    let poisons = [[f32::NAN, 1.0, 1.0], [1.0, f32::INFINITY, 1.0], [1.0, 1.0, f32::NEG_INFINITY]];
    let value = |x: u32, y: u32, s: usize| [0.1 * x as f32, 0.2 * y as f32, 0.3 * s as f32];
    let (size, samples) = ((37, 19), 70);
    let film = filled(size, samples, |x, y, s| if bad(x, y, s) { poisons[s % 3] } else { value(x, y, s) });
    let clean = filled(size, samples, |x, y, s| if bad(x, y, s) { [0.0; 3] } else { value(x, y, s) });

    let mut named = Vec::new();
    for s in 0..samples {
        for y in 0..size.1 {
            let row = (0..size.0).filter(|&x| bad(x, y, s));
            named.extend(row.map(|x| DiscardedSample { x, y, sample: s as u64 }));
        }
    }
    let discarded = film.discarded();
    assert_eq!(discarded.count, named.len() as u64);
    assert_eq!(discarded.first, named[..16]);
    assert_eq!((discarded.aov_count, clean.discarded().count), (0, 0));
    for y in 0..size.1 {
        for x in 0..size.0 {
            assert_eq!(film.pixel(x, y), clean.pixel(x, y), "a dropped sample counts as zero and keeps its place");
        }
    }
}

#[test]
fn the_first_ones_do_not_depend_on_tiles_or_passes() {
    let discarded = |tile: u32, pass: usize| {
        let mut film = Film::new(20, 10, tile, FilmChannels::Colour, 0);
        for tile in film.tiles_mut() {
            let rect = tile.rect();
            for first in (0..90).step_by(pass) {
                let mut slots = Vec::new();
                for (y, x) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (y, x))) {
                    let samples = first..first + pass;
                    slots
                        .extend(samples.map(|s| if bad(rect.x + x, rect.y + y, s) { [f32::NAN; 3] } else { [1.0; 3] }));
                }
                tile.add_samples(first as u64, pass, &slots, &[]);
            }
        }
        film.discarded()
    };
    let one = discarded(64, 90);
    assert!(one.count > 16);
    assert_eq!(one, discarded(3, 15));
    assert_eq!(one, discarded(8, 1));
}

#[test]
fn a_bad_aov_is_dropped_alone() {
    let mut film = Film::new(1, 1, 1, FilmChannels::ColourAndAovs, 0);
    let good = AovSample { albedo: [0.5; 3], normal: [0.0, 0.0, 1.0], depth: 2.0, posterior: [0.0; 3] };
    let aovs = [good, AovSample { depth: f32::NAN, ..good }];
    film.tiles_mut()[0].add_samples(0, 2, &[[1.0; 3]; 2], &aovs);
    assert_eq!((film.discarded().count, film.discarded().aov_count), (0, 1));
    assert_eq!(film.mean(0, 0), [1.0; 3]);
    assert_eq!((film.aovs(0, 0).unwrap().depth, film.aovs(0, 0).unwrap().albedo), (1.0, [0.25; 3]));
}
