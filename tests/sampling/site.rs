//! Pixels of a block: nets each, nearly nets together, and else without relation.

use super::nets::quality;
use octolux::lane::{Bits, Real, f32x8, f32x16};
use octolux::sampling::site::{PLACES, apart};
use octolux::sampling::sobol::{self, Key, PairSet};
use octolux::sampling::{Sampler, SamplerKind, Site, dimensions};

type One = <f32 as Real>::Bits;

const SEED: u64 = 19;
/// What a path draws of a bounce.
const DRAWN: usize = dimensions::ROTATION;

/// All numbers of a sample up to the first bounce.
fn numbers(kind: SamplerKind, seed: u64, site: Site, sample: u32) -> Vec<f32> {
    let mut sampler = Sampler::<f32>::idle();
    sampler.seed_lane(kind, 0, seed, site, sample);
    let camera = sampler.camera_dims(kind, true);
    camera.into_iter().chain(sampler.bounce_dims(kind, 0.0).into_iter().take(DRAWN)).collect()
}

/// Sobol's first pair of 2^m points at each of the last `places`, which differ in the highest bits of their number.
fn shifted(places: u32, m: u32) -> Vec<[u32; 2]> {
    let digits = |x: One| x.reverse_bits().lane(0);
    let point = |place: u32, i: u32| {
        let shift = apart::<f32>(One::splat(place));
        [0, 1].map(|d| digits(sobol::sobol_reversed::<f32>(One::splat(i), d) ^ shift[d]))
    };
    let step = PLACES / places;
    (0..places).flat_map(|k| (0..1 << m).map(move |i| point(k * step, i))).collect()
}

/// By counting points in boxes; the expected t were found from the ranks of the generator matrices, elsewhere.
#[test]
fn shifts_make_nets_of_all_places() {
    for (places, expected) in [
        (64, [1, 1, 1, 0, 1, 2, 1, 2, 2, 2]),
        (32, [1, 1, 2, 2, 1, 2, 3, 1, 1, 1]),
        (16, [1, 2, 1, 1, 0, 1, 2, 1, 2, 1]),
        (8, [0, 1, 2, 3, 1, 1, 1, 1, 1, 1]),
        (4, [1, 2, 2, 2, 0, 0, 1, 2, 0, 1]),
        (2, [0, 1, 1, 1, 1, 1, 1, 1, 1, 1]),
    ] {
        for (m, t) in (0..).zip(expected) {
            assert_eq!(quality(&shifted(places, m)), t, "{places} places, 2^{m} points each");
        }
    }
}

/// A set shuffles indices and places and scrambles: all that keeps the quality, of the block and of aligned parts of it.
#[test]
fn sets_keep_the_quality() {
    for (seed, part, m) in [(1u64, 0..64, 0), (2, 0..64, 3), (3, 0..64, 6), (4, 0..64, 8), (5, 2..16, 3), (6, 1..8, 4)]
    {
        let key = Key::<f32>::from_fn(|_| octolux::sampling::sample_key(seed, 5, 0));
        let set = PairSet::new(key, One::splat(seed as u32 % 7));
        // Places that agree in their lower bits.
        let (lowest, places) = (part.start, part.end);
        let of_place = |k: u32| One::splat(lowest + k * (PLACES / places));
        let point =
            |k: u32, i: u32| set.pair(set.shuffle(One::splat(i.reverse_bits())), of_place(k)).map(|x| x.lane(0));
        let points: Vec<_> = (0..places).flat_map(|k| (0..1 << m).map(move |i| point(k, i))).collect();
        assert_eq!(quality(&points), quality(&shifted(places, m)), "set {seed}, {places} places, 2^{m} points");
    }
}

#[test]
fn places_fill_blocks_and_halve_them() {
    let width = 21;
    let sites: Vec<Site> =
        (0..16).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| Site::of_pixel(x, y, width)).collect();
    assert!(sites.iter().enumerate().all(|(i, site)| site.pixel == i as u32 && site.place < PLACES));
    let mut pairs: Vec<_> = sites.iter().map(|site| (site.block, site.place)).collect();
    pairs.sort_unstable();
    pairs.dedup();
    assert_eq!(pairs.len(), sites.len(), "no two pixels have the same place");
    assert_eq!(sites.iter().map(|site| site.block).max(), Some(5), "three blocks a row, two rows");
    let at = |x, y| Site::of_pixel(x, y, width).place;
    assert_eq!([at(8, 8), at(12, 8), at(8, 12), at(10, 8), at(8, 10), at(9, 8), at(8, 9)], [0, 1, 2, 4, 8, 16, 32]);
}

fn of_site_is_lane_by_lane<R: Real>() {
    // The third is where one word is full and another sequence of points begins.
    for first in [0, 40, (1 << 26) - 5, 1 << 26, u32::MAX - 15] {
        for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
            let site = Site::of_pixel(11, 5, 100);
            let mut packet = Sampler::<R>::of_site(kind, SEED, site, first);
            let (camera, bounce) = (packet.camera_dims(kind, true), packet.bounce_dims(kind, R::zero()));
            for lane in 0..R::WIDTH {
                let one = numbers(kind, SEED, site, first + lane as u32);
                let found: Vec<f32> = camera.iter().chain(&bounce[..DRAWN]).map(|u| u.lane(lane)).collect();
                assert_eq!(found, one, "{kind:?}, sample {first} + {lane}");
            }
        }
    }
}

#[test]
fn packets_of_a_site_are_lane_by_lane() {
    of_site_is_lane_by_lane::<f32x8>();
    of_site_is_lane_by_lane::<f32x16>();
}

/// Where samples are divided by what other pixels found, these must not know anything of the pixel's own.
#[test]
fn pixels_may_be_scrambled_for_themselves() {
    let site = Site::of_pixel(3, 2, 64);
    let of = |kind, site| numbers(kind, SEED, site, 9);
    assert_eq!(of(SamplerKind::SobolPixels, site), of(SamplerKind::Sobol, Site::alone(site.pixel)));
    assert_ne!(of(SamplerKind::SobolPixels, site), of(SamplerKind::Sobol, site));
}

/// Beyond the samples that one word has room for come others, not the same again.
#[test]
fn no_sample_comes_twice() {
    let site = Site::of_pixel(3, 2, 64);
    let of = |sample| numbers(SamplerKind::Sobol, SEED, site, sample);
    assert_ne!(of(77), of(77 + (1 << 26)));
    assert_ne!(of(1 << 26), of(2 << 26));
}

/// Different numbers of two pixels of a block have nothing to do with each other, though they share a scrambling: over 2¹⁴ blocks
/// their correlations are 0 within 5 standard errors of 1/√n. That of the same number is below 0 or 0: points avoid each other.
#[test]
fn different_numbers_of_a_blocks_pixels_are_uncorrelated() {
    let n = 1u32 << 14;
    let at = |block: u32, place| Site { pixel: 0, block, place };
    let rows: Vec<[Vec<f32>; 2]> = (0..n)
        .map(|k| [k % 64, (k * 29 + k / 64 + 1) % 64].map(|place| numbers(SamplerKind::Sobol, SEED, at(k, place), 3)))
        .collect();
    let dimensions = rows[0][0].len();
    for (a, b) in (0..dimensions).flat_map(|a| (0..dimensions).map(move |b| (a, b))) {
        let sum: f64 = rows.iter().map(|[u, v]| f64::from(u[a] - 0.5) * f64::from(v[b] - 0.5)).sum();
        let z = sum * 12.0 / f64::from(n).sqrt();
        assert!(if a == b { z < 5.0 } else { z.abs() < 5.0 }, "dimensions {a} and {b}: {z:.2} standard errors");
    }
}

/// The mean over a block of a smooth function of two numbers errs far less than where each pixel is scrambled for itself, at any
/// number of samples; that of a pixel alone as much as ever.
#[test]
fn blocks_are_integrated_better() {
    let (x, y) = (dimensions::CAMERA + dimensions::BSDF_DIRECTION, dimensions::CAMERA + dimensions::BSDF_DIRECTION + 1);
    for samples in [1, 3, 8, 13] {
        // Mean squares of the errors of a block's and of a pixel's mean.
        let errors = |site: &dyn Fn(u32) -> Site, seed: u64| -> [f64; 2] {
            let pixel = |k: u32| {
                let f = |s: u32| {
                    let u = numbers(SamplerKind::Sobol, seed, site(k), s);
                    f64::from(u[x] * u[y]) - 0.25
                };
                (0..samples).map(f).sum::<f64>() / f64::from(samples)
            };
            let pixels: Vec<f64> = (0..64).map(pixel).collect();
            let squares: f64 = pixels.iter().map(|p| p * p).sum();
            [(pixels.iter().sum::<f64>() / 64.0).powi(2), squares / 64.0]
        };
        let over_seeds = |site: &dyn Fn(u32) -> Site| {
            (0..200).map(|seed| errors(site, seed)).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
        };
        let together = over_seeds(&|k| Site::of_pixel(k % 8, k / 8, 8));
        let alone = over_seeds(&|k| Site::alone(k));
        println!("{samples} samples: blocks {:.4}, pixels {:.3}", together[0] / alone[0], together[1] / alone[1]);
        assert!(together[0] < 0.3 * alone[0], "{samples} samples: {}", together[0] / alone[0]);
        assert!((together[1] / alone[1] - 1.0).abs() < 0.1, "{samples} samples: {}", together[1] / alone[1]);
    }
}

/// What two different numbers of a pixel do together is as random over the pixels of a block as if these were independent: if one's
/// digits said the other's for all of a block at once, its mean would be as bad as one pixel's, 64 times worse. By Walsh functions:
/// signs that the first digits of both numbers say, singly and in pairs. An order in which aligned blocks stay blocks turns the
/// highest bit of a place by a function of five others, so that 2 is what is left at best, and 4 where digits go by the next.
#[test]
fn what_numbers_do_together_is_independent_over_a_block() {
    let blocks = 1000u32;
    let digits = |u: f32| (u * 4.0) as u32;
    // Signs by the first digit, the second, and both.
    let sign = |u: f32, which: u32| if (digits(u) & which).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
    let all: Vec<Vec<Vec<f32>>> = (0..blocks)
        .map(|block| {
            (0..64)
                .map(|place| numbers(SamplerKind::Sobol, SEED, Site { pixel: 0, block, place }, block % 16))
                .collect()
        })
        .collect();
    // One of each set that paths draw from.
    let of_bounce = |d: usize| dimensions::CAMERA + d;
    let drawn = [
        dimensions::PIXEL,
        dimensions::LENS,
        of_bounce(dimensions::BSDF_DIRECTION),
        of_bounce(dimensions::LIGHT_POSITION),
        of_bounce(dimensions::LIGHT_CHOICE),
        of_bounce(dimensions::ROULETTE),
    ];
    let mut worst = (0.0, String::new());
    for (i, &a) in drawn.iter().enumerate() {
        for &b in &drawn[i + 1..] {
            for (m, n) in (1..4).flat_map(|m| (1..4).map(move |n| (m, n))) {
                let mean =
                    |block: &Vec<Vec<f32>>| block.iter().map(|u| sign(u[a], m) * sign(u[b], n)).sum::<f64>() / 64.0;
                let variance = all.iter().map(|block| mean(block).powi(2)).sum::<f64>() / f64::from(blocks) * 64.0;
                if variance > worst.0 {
                    worst = (variance, format!("dimensions {a} and {b}, digits {m} and {n}"));
                }
            }
        }
    }
    println!("{}: {:.2} of independent pixels' variance", worst.1, worst.0);
    assert!(worst.0 < 4.0, "{}: {:.2} of independent pixels' variance", worst.1, worst.0);
}
