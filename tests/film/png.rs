//! PNG previews against the sRGB formula.

use super::filled;
use octolux::film::png::srgb8;
use octolux::film::write_png;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// IEC 61966-2-1, linear to encoded, 0 … 255 unrounded.
fn encoded(linear: f64) -> f64 {
    255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn srgb_is_the_rounded_formula() {
    // The standard rounds the two branch points (.0031308, .04045), so that the curve and its inverse differ by up to
    // 3e-8 of full scale there.
    let slack = 255.0 * 3e-8;
    for i in 0..=200_000 {
        let linear = f64::from(i) / 200_000.0;
        let code = f64::from(srgb8(linear));
        assert!((code - encoded(linear)).abs() <= 0.5 + slack, "{linear}: {code}, {}", encoded(linear));
    }
}

#[test]
fn values_outside_the_range_are_clamped() {
    let cases =
        [(f64::NAN, 0), (-1.0, 0), (f64::NEG_INFINITY, 0), (-0.0, 0), (1.0, 255), (1e30, 255), (f64::INFINITY, 255)];
    cases.into_iter().for_each(|(linear, code)| assert_eq!(srgb8(linear), code, "{linear}"));
}

fn read(path: &Path) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    (info.width, info.height, bytes)
}

#[test]
fn pixels_are_exposed_and_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("preview.png");
    let value = |x: u32, y: u32| [x as f32 / 64.0, y as f32 / 64.0, (x + y) as f32 / 16.0];
    let film = filled((37, 21), 1, |x, y, _| value(x, y));
    for stops in [0.0f32, 1.5, -3.0] {
        write_png(&film, &path, stops).unwrap();
        let (width, height, bytes) = read(&path);
        assert_eq!((width, height), (37, 21));
        for (i, (x, y)) in (0..21).flat_map(|y| (0..37).map(move |x| (x, y))).enumerate() {
            for (c, linear) in value(x, y).into_iter().enumerate() {
                let wanted = encoded((f64::from(linear) * 2f64.powf(f64::from(stops))).clamp(0.0, 1.0));
                assert!((f64::from(bytes[3 * i + c]) - wanted).abs() <= 0.5 + 1e-5, "({x}, {y}) {c} at {stops}");
            }
        }
    }
    for stops in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        write_png(&film, &path, stops).unwrap();
        assert_eq!(read(&path).2[..3], [0, 0, 0], "a black pixel stays black at {stops} stops");
    }
}
