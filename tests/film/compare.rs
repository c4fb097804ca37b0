//! `octolux compare` against numbers worked out by hand.

use super::SplitMix;
use clap::Parser;
use octolux::film::exr_write::write_rows;
use octolux::film::{Attribute, Film, FilmChannels, VarianceValidity, write_exr};
use octolux::report::compare::{CompareArgs, CompareError, Place, compare_command, run};
use octolux::report::diff::{NON_FINITE, colour};
use octolux::report::sidak::sidak_bound;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const WITH_VARIANCE: [&str; 6] = ["R", "G", "B", "variance.R", "variance.G", "variance.B"];

/// An image of one row: `pixels[x]` holds a value for each of `WITH_VARIANCE`, or for R, G, B alone.
fn image<const C: usize>(folder: &TempDir, name: &str, pixels: &[[f32; C]], validity: Option<&str>) -> PathBuf {
    let path = folder.path().join(name);
    let attributes: Vec<(String, Attribute)> =
        validity.map(|text| ("variance_validity".into(), text.into())).into_iter().collect();
    write_rows(&path, (pixels.len(), 1), &WITH_VARIANCE[..C], &attributes, |_, planes| {
        for (x, pixel) in pixels.iter().enumerate() {
            pixel.iter().enumerate().for_each(|(c, &value)| planes[c * pixels.len() + x] = value);
        }
    })
    .unwrap();
    path
}

fn args(a: &Path, b: &Path) -> CompareArgs {
    CompareArgs { a: a.into(), b: b.into(), json: None, max_relmse: None, diff: None, quiet: true }
}

fn close(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 8.0 * f64::EPSILON * expected.abs(), "{value} is not {expected}");
}

#[test]
fn metrics_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let a = image(&folder, "a.exr", &[[1.0, 2.0, 3.0], [0.0, 0.5, 0.0]], None);
    let b = image(&folder, "b.exr", &[[1.0, 1.0, 1.0], [0.5, 0.5, 0.0]], None);
    let result = run(&args(&a, &b)).unwrap();
    close(result.rmse, (5.25f64 / 6.0).sqrt());
    close(result.relmse, (1.0 / 1.01 + 4.0 / 1.01 + 0.25 / 0.26) / 6.0);
    let ratios = result.mean_ratio.map(Option::unwrap);
    ratios.into_iter().zip([1.0 / 1.5, 2.5 / 1.5, 3.0]).for_each(|(ratio, expected)| close(ratio, expected));
    assert_eq!((result.max_abs_difference, result.max_at), (2.0, Some(Place { x: 0, y: 0, channel: 2 })));
    assert!(!result.identical && result.z.is_none() && result.non_finite == 0);
    assert_eq!(result.notes, ["no z-scores: A has no variance"]);

    let same = run(&args(&b, &b)).unwrap();
    assert!(same.identical && same.within(0.0));
    assert_eq!((same.rmse, same.relmse, same.max_at), (0.0, 0.0, None));
}

#[test]
fn values_that_are_not_finite_are_left_out_and_fail_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    let a = image(&folder, "a.exr", &[[f32::NAN, 2.0, 1.0], [1.0, 1.0, 1.0]], None);
    let b = image(&folder, "b.exr", &[[1.0, f32::INFINITY, 1.0], [1.0, 2.0, 1.0]], None);
    let result = run(&args(&a, &b)).unwrap();
    close(result.rmse, 0.5);
    assert_eq!((result.non_finite, result.within(1e9)), (2, false));
}

#[test]
fn z_scores_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let valid = Some("independent: yes");
    let a = image(&folder, "a.exr", &[[3.0, 1.0, 5.0, 0.25, 1.0, 0.0], [1.0, 1.0, 1.0, 0.0, 0.0, 2.25]], valid);
    let b = image(&folder, "b.exr", &[[2.0, 3.0, 4.0, 0.0, 3.0, 0.0], [1.0, 1.0, 10.0, 0.0, 0.0, 0.0]], valid);
    let z = run(&args(&a, &b)).unwrap().z.unwrap();
    // z: 2, −1 and −6; 5 against 4 without variance is unexplained, equal values without variance are nothing.
    assert_eq!((z.tested, z.unexplained, z.max_abs, z.beyond_bound), (3, 1, 6.0, 1));
    assert_eq!(z.max_at, Place { x: 1, y: 0, channel: 2 });
    let mean: f64 = -5.0 / 3.0;
    close(z.mean, mean);
    let squares = [2.0, -1.0, -6.0].map(|v: f64| (v - mean).powi(2)).iter().sum::<f64>();
    close(z.standard_deviation, (squares / 2.0).sqrt());
}

#[test]
fn z_scores_need_variances_that_are_valid() {
    let folder = tempfile::tempdir().unwrap();
    let pixel = [[1.0f32, 1.0, 1.0, 1.0, 1.0, 1.0]];
    let good = image(&folder, "good.exr", &pixel, Some(VarianceValidity::Independent.text()));
    for text in [None, Some(VarianceValidity::Correlated.text()), Some(VarianceValidity::Stopped.text()), Some("?")] {
        let other = image(&folder, "other.exr", &pixel, text);
        for (result, which) in [(run(&args(&good, &other)), "B"), (run(&args(&other, &good)), "A")] {
            let result = result.unwrap();
            assert!(result.z.is_none());
            assert!(result.notes[0].starts_with(&format!("no z-scores: {which}")), "{:?}", result.notes);
        }
    }
}

#[test]
fn sidak_bounds_are_those_of_the_tables() {
    // numerics.md, three decimals; one test is the two-sided 1 % point of the normal distribution.
    for (tests, bound) in [(1, 2.576), (100, 3.889), (65_536, 5.248), (1_048_576, 5.738)] {
        assert!((sidak_bound(tests) - bound).abs() <= 5e-4, "{tests}: {}", sidak_bound(tests));
    }
    assert_eq!(sidak_bound(0), sidak_bound(1));
    assert!(sidak_bound(u64::MAX).is_finite());
}

/// 64×64 pixels of `samples` uniform values in [0, 1) plus `shift`.
fn noise(folder: &TempDir, name: &str, seed: u64, samples: usize, shift: f32) -> PathBuf {
    let mut film = Film::new(64, 64, 64, FilmChannels::Colour, 0);
    let mut random = SplitMix(seed);
    let slots: Vec<[f32; 3]> = (0..64 * 64 * samples).map(|_| std::array::from_fn(|_| random.unit() + shift)).collect();
    film.tiles_mut()[0].add_samples(0, samples, &slots, &[]);
    let path = folder.path().join(name);
    let attributes = [("seed".to_owned(), seed.into()), ("samples".to_owned(), (samples as u64).into())];
    write_exr(&film, &path, &attributes, VarianceValidity::Independent).unwrap();
    path
}

#[test]
fn z_scores_of_two_renders_are_standard_normal_and_see_a_bias() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (noise(&folder, "a.exr", 1, 256, 0.0), noise(&folder, "b.exr", 2, 256, 0.0));
    let result = run(&args(&a, &b)).unwrap();
    assert_eq!(result.notes, ["samples per pixel: A 256, B 256"]);
    let z = result.z.unwrap();
    let tested = 3.0 * 64.0 * 64.0;
    assert_eq!((z.tested as f64, z.beyond_bound, z.unexplained), (tested, 0, 0));
    // Three tests at 1 % family-wise; an estimated variance of 2·255 degrees of freedom widens z by 1/(2·255).
    let bound = sidak_bound(3);
    assert!(z.mean.abs() <= bound / tested.sqrt(), "{}", z.mean);
    assert!((z.standard_deviation - 1.0).abs() <= bound / (2.0 * tested).sqrt() + 1.0 / 510.0);

    // √(2/12/256) is the noise of a difference: .026. A shift of 6 of these puts most values beyond the bound of 4.9.
    let biased = noise(&folder, "c.exr", 3, 256, 0.16);
    let z = run(&args(&biased, &b)).unwrap().z.unwrap();
    assert!(z.beyond_bound > z.tested / 2 && z.mean > 5.0);

    // Skewed samples, which these are not, would go beyond the bound here: nobody knows, so it is said.
    let fewer = noise(&folder, "d.exr", 4, 128, 0.0);
    let notes = run(&args(&fewer, &a)).unwrap().notes;
    assert!(notes.iter().any(|note| note.starts_with("128 samples against 256")), "{notes:?}");

    let again = run(&args(&a, &a)).unwrap();
    assert!(again.notes.iter().any(|note| note.contains("both used seed 1")));
}

#[test]
fn images_of_different_sizes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let a = image(&folder, "a.exr", &[[1.0; 3]; 2], None);
    let b = image(&folder, "b.exr", &[[1.0; 3]; 3], None);
    let error = run(&args(&a, &b)).unwrap_err();
    assert!(matches!(error, CompareError::Sizes { size_a: (2, 1), size_b: (3, 1), .. }));
    let expected = format!("{}: 3x1 pixels, but {} has 2x1", b.display(), a.display());
    assert!(error.to_string().starts_with(&expected), "{error}");
    assert!(matches!(run(&args(&a, &folder.path().join("none.exr"))), Err(CompareError::Film(_))));
}

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    compare: CompareArgs,
}

#[test]
fn the_command_writes_json_and_picture_and_judges() {
    let folder = tempfile::tempdir().unwrap();
    let a = image(&folder, "a.exr", &[[2.0; 3], [1.0; 3]], None);
    let b = image(&folder, "b.exr", &[[1.0; 3], [1.0; 3]], None);
    let (json, diff) = (folder.path().join("out.json"), folder.path().join("diff.png"));
    let parse = |limit: &str| {
        let words: [&std::ffi::OsStr; 9] = [
            "compare".as_ref(),
            a.as_ref(),
            b.as_ref(),
            "--json".as_ref(),
            json.as_ref(),
            "--max-relmse".as_ref(),
            limit.as_ref(),
            "--diff".as_ref(),
            diff.as_ref(),
        ];
        Cli::try_parse_from(words).map(|cli| cli.compare)
    };
    // relMSE is half of 1/1.01.
    assert!(compare_command(&parse("0.4951").unwrap()).unwrap());
    assert!(!compare_command(&parse("0.4950").unwrap()).unwrap());
    assert!(parse("-1").is_err() && parse("NaN").is_err() && parse("inf").is_err());

    let written: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    close(written["relmse"].as_f64().unwrap(), 0.5 / 1.01);
    assert_eq!((written["max_at"]["x"].as_u64(), written["z"].is_null()), (Some(0), true));
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&diff).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    assert_eq!(bytes, [254, 84, 84, 0, 0, 0], "1/√1.01 brighter is √.995 of full red; equal is black");
}

#[test]
fn the_difference_picture_follows_its_legend() {
    assert_eq!(colour([0.0; 3], [0.0; 3]), [0, 0, 0]);
    assert_eq!(colour([10.0; 3], [1.0; 3]), [255, 85, 85]);
    assert_eq!(colour([0.0; 3], [10.0; 3]), [85, 85, 255]);
    assert_eq!(colour([f64::NAN, 0.0, 0.0], [0.0; 3]), NON_FINITE);
    // 4 % of a large value: √.04 of full.
    assert_eq!(colour([104.0; 3], [100.0; 3]), [51, 17, 17]);
}

#[test]
fn the_summary_is_readable() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (noise(&folder, "a.exr", 1, 4, 0.0), noise(&folder, "b.exr", 2, 4, 0.0));
    let text = run(&args(&a, &b)).unwrap().to_string();
    for word in ["64x64", "RMSE", "relMSE", "mean A/B", "max |A-B|", "12288 tested", "beyond bound"] {
        assert!(text.contains(word), "{word} is missing in\n{text}");
    }
    assert!(text.contains("4 samples are few"), "{text}");
}
