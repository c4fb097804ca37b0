//! Texels, their decoding, and what lies between them, against formulas in f64.

use super::*;
use crate::renders::{self};
use crate::stats::Rng;
use octolux::kernel::TextureTable;
use octolux::lane::{Mask, Real, f32x8, f32x16};
use octolux::scene::Maps;

/// Values of a byte image, by its decoding rule in f64.
fn decoded(byte: u8, srgb: bool) -> f64 {
    let c = f64::from(byte) / 255.0;
    if !srgb {
        c
    } else if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

fn table(texture: &Texture) -> TextureTable {
    let maps = Maps { colour: Some(texture.clone()), ..Maps::default() };
    TextureTable::new(&[Material { maps, ..Material::default() }])
}

fn look_up<R: Real>(table: &TextureTable, u: f32, v: f32) -> [f32; 4] {
    let all = R::Mask::splat(true);
    let texel = table.look_up(R::one(), [R::splat(u), R::splat(v)], all);
    let first = texel.map(|c| c.lane(0).to_bits());
    for lane in 1..R::WIDTH {
        assert_eq!(first, texel.map(|c| c.lane(lane).to_bits()), "lane {lane} at {u}, {v}");
    }
    first.map(f32::from_bits)
}

/// Texel centres, seams, corners, far repeats, and numbers that are none.
fn coordinates() -> Vec<[f32; 2]> {
    let mut rng = Rng::new(3);
    let special = [0.0, 1.0, -1.0, 0.5, 1.0 - f32::EPSILON / 2.0, -1e-9, 1e-9, 7.25, -3.75, 1e4, 0.1, 0.9];
    let mut all: Vec<_> = special.iter().flat_map(|&u| special.iter().map(move |&v| [u, v])).collect();
    all.extend((0..4000).map(|_| [4.0 * rng.f32() - 2.0, 4.0 * rng.f32() - 2.0]));
    all
}

/// The bilinear interpolant at exactly this (f32) place.
fn expected(texel: impl Fn(i64, i64) -> [f64; 3], size: [i64; 2], uv: [f32; 2]) -> [f64; 3] {
    let x = f64::from(uv[0]).rem_euclid(1.0) * size[0] as f64 - 0.5;
    let y = f64::from(uv[1]).rem_euclid(1.0) * size[1] as f64 - 0.5;
    let (left, bottom) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - bottom);
    std::array::from_fn(|k| {
        let at = |dx: i64, dy: i64| {
            let column = (left as i64 + dx).rem_euclid(size[0]);
            // v = 0 is the bottom edge, row 0 the top.
            let row = size[1] - 1 - (bottom as i64 + dy).rem_euclid(size[1]);
            texel(column, row)[k]
        };
        let low = at(0, 0) * (1.0 - fx) + at(1, 0) * fx;
        let high = at(0, 1) * (1.0 - fx) + at(1, 1) * fx;
        low * (1.0 - fy) + high * fy
    })
}

fn check(name: &str, texture: &Texture, texel: impl Fn(i64, i64) -> [f64; 3]) {
    let table = table(texture);
    let size = [i64::from(texture.image.width), i64::from(texture.image.height)];
    for uv in coordinates() {
        let found = look_up::<f32>(&table, uv[0], uv[1]);
        assert_eq!(found.map(f32::to_bits), look_up::<f32x8>(&table, uv[0], uv[1]).map(f32::to_bits), "{name} {uv:?}");
        assert_eq!(found.map(f32::to_bits), look_up::<f32x16>(&table, uv[0], uv[1]).map(f32::to_bits), "{name} {uv:?}");
        let expected = expected(&texel, size, uv);
        // The place is rounded once to a fraction of [0, 1] and once in texels; values change by at most 1 a texel.
        let longest = size[0].max(size[1]) as f64;
        let allowed = (2.0 * longest + 8.0) / 16_777_216.0;
        for k in 0..3 {
            let off = (f64::from(found[k]) - expected[k]).abs();
            assert!(off <= allowed, "{name} at {uv:?}, channel {k}: {} for {}", found[k], expected[k]);
        }
    }
}

fn bytes(width: u32, height: u32, channels: usize, srgb: bool) -> (Texture, Vec<u8>) {
    let mut rng = Rng::new(u64::from(width * height) + channels as u64);
    let count = (width * height) as usize * channels;
    let texels: Vec<u8> = (0..count).map(|_| (rng.f64() * 256.0) as u8).collect();
    let image = Image { width, height, channels, texels: Texels::Bytes(texels.clone()) };
    (Texture::new(Arc::new(image), srgb), texels)
}

#[test]
fn between_texels_repeating() {
    for (width, height) in [(1, 1), (2, 1), (1, 3), (5, 7), (64, 16)] {
        for srgb in [false, true] {
            let (texture, texels) = bytes(width, height, 3, srgb);
            let at = |x: i64, y: i64| -> [f64; 3] {
                let first = 3 * (y as usize * width as usize + x as usize);
                std::array::from_fn(|k| decoded(texels[first + k], srgb))
            };
            check(&format!("{width}×{height}, sRGB {srgb}"), &texture, at);
        }
    }
}

/// Grey repeats, alpha is never encoded, words are finer than bytes.
#[test]
fn kinds_of_texels() {
    for channels in [1, 2, 4] {
        let (texture, texels) = bytes(4, 4, channels, true);
        let table = table(&texture);
        for i in 0..16 {
            let (column, row) = (i % 4, i / 4);
            let centre = |k: u32| (k as f32 + 0.5) / 4.0;
            let found = look_up::<f32>(&table, centre(column), 1.0 - centre(row));
            let own = &texels[i as usize * channels..][..channels];
            let colour = |k: usize| decoded(own[if channels < 3 { 0 } else { k }], true) as f32;
            let alpha = if channels % 2 == 0 { decoded(own[channels - 1], false) as f32 } else { 1.0 };
            assert_eq!(found, [colour(0), colour(1), colour(2), alpha], "{channels} channels, texel {i}");
        }
    }
    let image = Image { width: 1, height: 1, channels: 2, texels: Texels::Words(vec![30_000, 20_000]) };
    let found = look_up::<f32>(&table(&Texture::new(Arc::new(image), true)), 0.0, 0.0);
    let linear = ((30_000.0 / 65_535.0 + 0.055) / 1.055f64).powf(2.4) as f32;
    assert_eq!(found, [linear, linear, linear, 20_000.0 / 65_535.0]);
}

#[test]
fn coordinates_that_are_no_numbers_read_something() {
    let (texture, _) = bytes(5, 7, 3, true);
    let table = table(&texture);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -3e38] {
        for uv in [[bad, 0.3], [0.3, bad], [bad, bad]] {
            // The value is not promised, the look-up's safety is.
            let _ = look_up::<f32>(&table, uv[0], uv[1]);
        }
    }
}

/// Scale and offset place the image; the tabulating look-up in f64 agrees.
#[test]
fn placed_images() {
    let (mut texture, _) = bytes(5, 7, 3, true);
    texture.scale = [2.5, -3.0];
    texture.offset = [0.25, 0.125];
    let table = table(&texture);
    let mut rng = Rng::new(9);
    for _ in 0..2000 {
        let uv = [2.0 * rng.f32() - 1.0, 2.0 * rng.f32() - 1.0];
        let found = look_up::<f32>(&table, uv[0], uv[1]);
        let expected = texture.at(uv.map(f64::from));
        for k in 0..3 {
            assert!((f64::from(found[k]) - expected[k]).abs() < 1e-5, "{uv:?}: {found:?} for {expected:?}");
        }
    }
}

/// A camera looking straight at a mapped quad sees the image upright: the first row of texels at the top.
#[test]
fn images_are_upright() {
    let mut set = Set::new([0.5, 0.5, 3.0], [0.5, 0.5, 0.0], 2.0 * (0.5f64 / 3.0).atan().to_degrees(), 4).bounces(0);
    let lamp = set.grey(0.0, 1.0);
    // Texels of a 4 × 4 image over a film of 4 × 4: pixel centres see texel centres.
    edit(&mut set, lamp).maps.emission = Some(image(4, 4, |x, y| [x as f32, y as f32, 1.0]));
    mapped_quad(&mut set, lamp, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let film = renders::film(&renders::world(&complete(set), 5), 4096);
    for (x, y) in [(1, 1), (2, 1), (1, 2), (2, 2)] {
        let mean = film.mean(x, y);
        // Between the seams the image is linear, and a pixel's mean is its centre's value.
        assert!((mean[0] - f64::from(x)).abs() < 0.03 && (mean[1] - f64::from(y)).abs() < 0.03, "{x}, {y}: {mean:?}");
        assert_eq!(mean[2], 1.0);
    }
}

/// A state file of another image must not be taken for one of this.
#[test]
fn a_texel_is_part_of_the_scenes_fingerprint() {
    let fingerprint = |value: f32, u: f32| {
        let mut set = Set::new([0.5, 0.5, 3.0], [0.5, 0.5, 0.0], 40.0, 4);
        let lamp = set.grey(0.0, 1.0);
        edit(&mut set, lamp).maps.emission =
            Some(image(4, 4, |x, y| if (x, y) == (3, 2) { [value; 3] } else { [1.0; 3] }));
        mapped_quad(&mut set, lamp, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        set.scene_mut().mesh.texcoords[2][0] = u;
        complete(set).fingerprint()
    };
    assert_eq!(fingerprint(1.0, 1.0), fingerprint(1.0, 1.0));
    assert_ne!(fingerprint(1.0, 1.0), fingerprint(0.5, 1.0));
    assert_ne!(fingerprint(1.0, 1.0), fingerprint(1.0, 0.5));
}
