//! Sums: against plain loops, and the same bits however the samples arrive.

use super::{add, aov, radiance, rendered};
use octolux::film::{Film, FilmChannels, MergeError, Rect, TileFilm};

const SIZE: (u32, u32) = (13, 7);

/// The documented order, written anew: plain sums in blocks of 64, power-of-two runs of blocks halved recursively,
/// largest run first, then the unfinished block.
fn documented_total(samples: &[f64]) -> f64 {
    let blocks: Vec<f64> = samples.chunks_exact(64).map(|block| block.iter().fold(0.0, |sum, x| sum + x)).collect();
    let rest = samples.chunks_exact(64).remainder().iter().fold(0.0, |sum, x| sum + x);
    let (mut total, mut left) = (0.0, blocks.as_slice());
    while !left.is_empty() {
        let run = 1 << left.len().ilog2();
        total += halved(&left[..run]);
        left = &left[run..];
    }
    total + rest
}

fn halved(blocks: &[f64]) -> f64 {
    match blocks {
        [one] => *one,
        more => halved(&more[..more.len() / 2]) + halved(&more[more.len() / 2..]),
    }
}

#[test]
fn film_sums_are_those_of_the_documented_order() {
    let mut differs_from_a_plain_loop = false;
    for samples in [1u64, 2, 63, 64, 65, 128, 200, 64 * 7, 64 * 13 + 5] {
        let film = rendered(SIZE, 4, FilmChannels::ColourAndAovs, samples, samples as usize);
        assert_eq!(film.samples(), samples);
        for (x, y) in [(0, 0), (12, 6), (4, 3), (7, 5)] {
            let pixel = film.pixel(x, y);
            for c in 0..3 {
                let values: Vec<f64> = (0..samples).map(|s| f64::from(radiance(x, y, s)[c])).collect();
                let squares: Vec<f64> = values.iter().map(|v| v * v).collect();
                assert_eq!(pixel.sum[c].to_bits(), documented_total(&values).to_bits(), "{samples} samples");
                assert_eq!(pixel.sum_of_squares[c].to_bits(), documented_total(&squares).to_bits());
                differs_from_a_plain_loop |= pixel.sum_of_squares[c] != squares.iter().sum::<f64>();
                assert_eq!(film.mean(x, y)[c], pixel.sum[c] / samples as f64);
            }
            let depths: Vec<f64> = (0..samples).map(|s| f64::from(aov(x, y, s).depth)).collect();
            let albedos: Vec<f64> = (0..samples).map(|s| f64::from(aov(x, y, s).albedo[1])).collect();
            let normals: Vec<f64> = (0..samples).map(|s| f64::from(aov(x, y, s).normal[2])).collect();
            let aovs = film.aovs(x, y).unwrap();
            assert_eq!(aovs.depth, documented_total(&depths) / samples as f64);
            assert_eq!(aovs.albedo[1], documented_total(&albedos) / samples as f64);
            assert_eq!(aovs.normal[2], documented_total(&normals) / samples as f64);
        }
    }
    assert!(differs_from_a_plain_loop, "the data cannot tell one order of additions from another");
}

#[test]
fn passes_of_any_size_give_the_same_bits() {
    let samples = 64 * 11 + 37;
    let whole = rendered(SIZE, 4, FilmChannels::ColourAndAovs, samples, samples as usize);
    for pass in [1, 3, 17, 63, 64, 65, 100, 129, 500] {
        assert!(whole == rendered(SIZE, 4, FilmChannels::ColourAndAovs, samples, pass), "passes of {pass}");
    }
}

#[test]
fn tiles_of_any_size_in_any_order_give_the_same_bits() {
    let samples = 64 * 3 + 5;
    let one = rendered(SIZE, 64, FilmChannels::Colour, samples, 50);
    for side in [1, 3, 4, 5, 8, 13] {
        let mut film = Film::new(SIZE.0, SIZE.1, side, FilmChannels::Colour, 0);
        film.tiles_mut().reverse();
        film.tiles_mut().iter_mut().for_each(|tile| add(tile, 0, samples as usize));
        film.tiles_mut().reverse();
        let pixels = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y)));
        pixels.for_each(|(x, y)| assert_eq!(film.pixel(x, y), one.pixel(x, y), "tiles of {side}"));
        assert_eq!(film.relative_error().map(f64::to_bits), one.relative_error().map(f64::to_bits));
    }
}

#[test]
fn tiles_cover_every_pixel_once() {
    for side in [1, 4, 13, 100] {
        let film = Film::new(SIZE.0, SIZE.1, side, FilmChannels::Colour, 0);
        let mut covered = vec![0; (SIZE.0 * SIZE.1) as usize];
        for rect in film.tiles().iter().map(TileFilm::rect) {
            for y in rect.y..rect.y + rect.height {
                (rect.x..rect.x + rect.width).for_each(|x| covered[(y * SIZE.0 + x) as usize] += 1);
            }
        }
        assert!(covered.iter().all(|&count| count == 1), "tiles of {side}");
    }
}

const RECT: Rect = Rect { x: 3, y: 9, width: 4, height: 2 };

/// A tile with samples `64·blocks.start … 64·blocks.end − 1`, and `more` of the next block.
fn range(blocks: std::ops::Range<u64>, more: usize) -> TileFilm {
    let mut tile = TileFilm::new(RECT, FilmChannels::Colour, blocks.start);
    let count = (blocks.end - blocks.start) as usize * 64 + more;
    add(&mut tile, blocks.start * 64, count);
    tile
}

#[test]
fn block_ranges_merge_bit_for_bit_in_any_order() {
    let whole = range(0..23, 11);
    let cuts = [0..3, 3..4, 4..11, 11..20, 20..23];
    let parts = |i: usize| range(cuts[i].clone(), if i == 4 { 11 } else { 0 });
    for order in [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [2, 0, 4, 1, 3], [3, 1, 4, 0, 2]] {
        let mut merged = parts(order[0]);
        order[1..].iter().for_each(|&i| merged.merge(parts(i)).unwrap());
        assert!(merged == whole, "order {order:?}");
        assert_eq!(merged.next_sample(), 23 * 64 + 11);
    }
}

#[test]
fn a_merged_tile_goes_on_like_any_other() {
    let mut merged = range(0..5, 0);
    merged.merge(range(5..6, 20)).unwrap();
    add(&mut merged, 6 * 64 + 20, 300);
    assert!(merged == range(0..11, 0));
}

#[test]
fn merging_with_nothing_changes_nothing() {
    let whole = range(0..2, 9);
    let mut left = whole.clone();
    left.merge(TileFilm::new(RECT, FilmChannels::Colour, 40)).unwrap();
    assert!(left == whole);
    let mut empty = TileFilm::new(RECT, FilmChannels::Colour, 40);
    empty.merge(whole.clone()).unwrap();
    assert!(empty == whole);
}

#[test]
fn merges_that_cannot_be_exact_are_refused_and_leave_the_tile_alone() {
    let cases = [
        (range(0..5, 0), range(4..6, 0), MergeError::Overlap { first_sample: 256 }),
        (range(0..5, 3), range(5..6, 0), MergeError::Overlap { first_sample: 320 }),
        (range(0..5, 3), range(5..5, 3), MergeError::Overlap { first_sample: 320 }),
        (range(0..5, 3), range(6..7, 0), MergeError::UnfinishedBlock { first_sample: 320 }),
        (range(8..9, 0), range(0..5, 3), MergeError::UnfinishedBlock { first_sample: 320 }),
    ];
    for (mut tile, other, error) in cases {
        let before = tile.clone();
        assert_eq!(tile.merge(other), Err(error));
        assert!(tile == before);
    }
    let elsewhere = TileFilm::new(Rect { x: 4, ..RECT }, FilmChannels::Colour, 0);
    assert_eq!(range(0..1, 0).merge(elsewhere), Err(MergeError::Shape));
}

#[test]
fn films_merge_tile_by_tile() {
    let mut first = Film::new(SIZE.0, SIZE.1, 4, FilmChannels::Colour, 0);
    let mut second = Film::new(SIZE.0, SIZE.1, 4, FilmChannels::Colour, 3);
    first.tiles_mut().iter_mut().for_each(|tile| add(tile, 0, 192));
    second.tiles_mut().iter_mut().for_each(|tile| add(tile, 192, 100));
    first.merge(second).unwrap();
    assert!(first == rendered(SIZE, 4, FilmChannels::Colour, 292, 292));
    assert_eq!(first.merge(Film::new(SIZE.0, SIZE.1 + 1, 4, FilmChannels::Colour, 9)), Err(MergeError::Shape));
}

/// Sums belong to pixels: parts rendered in tiles of other sizes merge to the bits of one film.
#[test]
fn films_of_other_tiles_merge() {
    let channels = FilmChannels::ColourAndAovs;
    let whole = rendered(SIZE, 4, channels, 292, 292);
    for (first_tile, second_tile) in [(4, 5), (4, 1), (4, 64), (4, 3)] {
        let mut first = rendered(SIZE, first_tile, channels, 192, 192);
        let mut second = Film::new(SIZE.0, SIZE.1, second_tile, channels, 3);
        second.tiles_mut().iter_mut().for_each(|tile| add(tile, 192, 100));
        first.merge(second).unwrap();
        assert!(first == whole, "tiles of {first_tile} and {second_tile}");
    }
    let mut uneven = Film::new(SIZE.0, SIZE.1, 5, channels, 3);
    add(&mut uneven.tiles_mut()[1], 192, 64);
    assert_eq!(rendered(SIZE, 4, channels, 192, 192).merge(uneven), Err(MergeError::Tiles));
}

#[test]
#[should_panic(expected = "samples are added in order")]
fn a_sample_out_of_order_is_a_fault() {
    add(&mut TileFilm::new(RECT, FilmChannels::Colour, 0), 1, 1);
}

#[test]
fn an_empty_film_reads_as_nothing() {
    let film = Film::new(2, 2, 8, FilmChannels::ColourAndAovs, 0);
    assert_eq!((film.samples(), film.mean(1, 1), film.variance_of_mean(1, 1)), (0, [0.0; 3], None));
    assert_eq!((film.aovs(0, 0).unwrap().depth, film.relative_error()), (0.0, None));
    assert_eq!(Film::new(0, 0, 8, FilmChannels::Colour, 0).relative_error(), None);
}
