//! `octolux converge`: files, figures, variants, resuming, interruption.

use super::{Scratch, text};
use octolux::film::read_exr;
use octolux::report::converge::{Budget, ConvergeReport, NoiseSource, REPORT_FORMAT};
use octolux::report::metrics::compare;
use std::collections::BTreeSet;

/// Runs a study that must succeed and reads its report.
fn study(scratch: &Scratch, folder: &str, arguments: &[&str]) -> ConvergeReport {
    let common = ["converge", "scene.toml", "-o", folder, "--quiet"];
    let output = scratch.run(&[&common, arguments].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    report(scratch, folder)
}

fn report(scratch: &Scratch, folder: &str) -> ConvergeReport {
    let json = std::fs::read(scratch.path(folder).join("report.json")).unwrap();
    serde_json::from_slice(&json).unwrap()
}

/// Bits of all errors of all rows.
fn errors(report: &ConvergeReport) -> Vec<[u64; 4]> {
    let rows = report.variants.iter().flat_map(|v| &v.rows);
    rows.map(|r| [r.mse.value, r.relmse.value, r.relmse.hi, r.mae.value].map(f64::to_bits)).collect()
}

#[test]
fn a_study_writes_its_files_and_errors_fall_as_theory_says() {
    let scratch = Scratch::new();
    let variants = "sixteen: --lanes 16; one: --lanes 1 --threads 1";
    let report = study(&scratch, "out", &["--spp", "4,16,64", "--seeds", "6", "--variants", variants]);
    for file in ["report.json", "errors.csv", "report.html", "rmse-samples.svg", "relmse-seconds.svg", "cells.json"] {
        assert!(scratch.path("out").join(file).metadata().unwrap().len() > 100, "{file}");
    }
    assert_eq!((report.format, report.cells, report.cells_done), (REPORT_FORMAT, 36, 36));
    assert_eq!((report.variants[0].lanes, report.variants[1].lanes, report.variants[1].threads), (16, 1, 1));
    assert_eq!(report.same_images(), [["sixteen", "one"]]);
    // The lamp is small and sampled: the slope of independent samples within five standard errors.
    let slope = report.variants[0].relmse_by_samples.unwrap().exponent;
    assert!((slope.value + 1.0).abs() < 5.0 * slope.standard_error + 0.02, "{slope:?}");
    let csv = std::fs::read_to_string(scratch.path("out").join("errors.csv")).unwrap();
    let columns: BTreeSet<usize> = csv.lines().map(|line| line.split(',').count()).collect();
    assert_eq!((csv.lines().count(), columns.len()), (1 + 6, 1), "{csv}");
    let html = std::fs::read_to_string(scratch.path("out").join("report.html")).unwrap();
    assert!(html.contains("data:image/png;base64,") && html.contains("bit for bit"));
    // One curve for both against samples, two against time.
    let curves = |name: &str| {
        let svg = std::fs::read_to_string(scratch.path("out").join(name)).unwrap();
        (svg.matches("<polyline").count(), svg.contains("sixteen = one"))
    };
    assert_eq!((curves("rmse-samples.svg"), curves("rmse-seconds.svg")), ((1, true), (2, false)));
}

#[test]
fn a_variant_may_be_another_scene_and_its_flags_replace_the_common_ones() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    std::fs::write(scratch.path("dark.toml"), scene.replace("emission = [20, 18, 15]", "emission = [2, 1.8, 1.5]"))
        .unwrap();
    let variants = ["--variants", "lit: ; dark: dark.toml --lanes 8", "--spp", "64", "--seeds", "3"];
    let report = study(&scratch, "out", &[&variants[..], &["--", "--lanes", "16", "--threads", "1"]].concat());
    let [lit, dark] = &report.variants[..] else { panic!("two variants") };
    assert_eq!((lit.lanes, dark.lanes, lit.threads, dark.threads), (16, 8, 1, 1));
    // The reference is the first scene's: the other one is off by more than any noise, and that is called bias.
    let bias = |row: &octolux::report::converge::Row| row.relative_bias_squared.unwrap();
    assert!(bias(&dark.rows[0]).lo > 0.0 && bias(&lit.rows[0]).value < 0.01 * bias(&dark.rows[0]).value);
}

#[test]
fn errors_are_those_that_compare_finds() {
    let scratch = Scratch::new();
    let reference = ["render", "scene.toml", "-o", "ref.exr", "--spp", "1", "--seed", "77", "--quiet"];
    assert!(scratch.run(&reference).status.success());
    let report = study(&scratch, "out", &["--reference", "ref.exr", "--spp", "8", "--seeds", "3"]);
    // One sample has no variance layer.
    assert_eq!(report.reference.noise_source, NoiseSource::Unknown);
    let truth = read_exr(&scratch.path("ref.exr")).unwrap();
    let row = &report.variants[0].rows[0];
    let of_seed = |image: &str| {
        let image = read_exr(&scratch.path("out").join(image)).unwrap();
        compare(&image, &truth, ("a", "b")).unwrap()
    };
    let all: Vec<_> = row.seeds.iter().map(|seed| of_seed(&seed.image)).collect();
    let mean = |value: fn(&octolux::report::metrics::Comparison) -> f64| all.iter().map(value).sum::<f64>() / 3.0;
    assert!((row.mse.value - mean(|c| c.rmse * c.rmse)).abs() < 1e-12 * row.mse.value);
    assert!((row.relmse.value - mean(|c| c.relmse)).abs() < 1e-12 * row.relmse.value);
    // And the image is the one that `render` makes with that seed.
    let seed = row.seeds[0].seed.to_string();
    assert!(scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "8", "--seed", &seed]).status.success());
    let alone = read_exr(&scratch.path("a.exr")).unwrap();
    assert_eq!(alone.rgb(), read_exr(&scratch.path("out").join(&row.seeds[0].image)).unwrap().rgb());
}

/// The largest sample's share of the squared error of all seeds, from what `render` says of each.
#[test]
fn the_largest_sample_is_that_of_the_renders() {
    let scratch = Scratch::new();
    let report = study(&scratch, "out", &["--spp", "1,8", "--seeds", "3", "--reference-spp", "16"]);
    let [one, eight] = &report.variants[0].rows[..] else { panic!("two rows") };
    assert_eq!(one.largest_sample_share, None);
    let of_seed = |seed: u64| {
        let seed = seed.to_string();
        let render = ["render", "scene.toml", "-o", "a.exr", "--spp", "8", "--seed", &seed, "--json", "a.json"];
        assert!(scratch.run(&render).status.success());
        let json: serde_json::Value = serde_json::from_slice(&std::fs::read(scratch.path("a.json")).unwrap()).unwrap();
        let square = json["relative_error"].as_f64().unwrap().powi(2);
        (square, square * json["sample_shares"]["largest_of_error"].as_f64().unwrap())
    };
    let all: Vec<(f64, f64)> = eight.seeds.iter().map(|seed| of_seed(seed.seed)).collect();
    let largest = all.iter().map(|a| a.1).fold(0.0, f64::max);
    let expected = largest / all.iter().map(|a| a.0).sum::<f64>();
    let found = eight.largest_sample_share.expect("eight samples");
    assert!((found / expected - 1.0).abs() < 1e-12 && found > 0.0, "{found} for {expected}");
    assert_eq!([one, eight].map(|row| row.relmse_trusted), [one, eight].map(|row| row.doubts.is_empty()));
    let doubted = |row: &octolux::report::converge::Row| !row.doubts.is_empty();
    assert_eq!(report.variants[0].is_doubted(1e-3), doubted(one) || doubted(eight));
    let flagged = eight.doubts.iter().any(|doubt| doubt.contains("one sample makes up"));
    assert_eq!(flagged, found > octolux::film::shares::LARGEST_TRUSTED_OF_ERROR);
}

#[test]
fn a_made_reference_knows_its_noise() {
    let scratch = Scratch::new();
    let report = study(&scratch, "out", &["--spp", "16", "--seeds", "6", "--reference-spp", "64"]);
    assert_eq!(report.reference.noise_source, NoiseSource::Replicates);
    assert_eq!(report.reference.samples_per_pixel, Some(64));
    let row = &report.variants[0].rows[0];
    // A quarter of the variance at 16 samples; both are estimates with tails, hence the factor.
    let ratio = row.variance.unwrap().value / report.reference.noise.mse;
    assert!((2.0..8.0).contains(&ratio), "{ratio}");
    // No bias: the estimate may be anything that its interval and the noise of the reference allow.
    let bias = row.relative_bias_squared.unwrap();
    assert!(bias.lo < 0.3 * report.reference.noise.relmse, "{bias:?}");
}

#[test]
fn the_json_has_the_fields_of_its_version() {
    let scratch = Scratch::new();
    study(&scratch, "out", &["--spp", "1,2", "--seeds", "3", "--reference-spp", "8"]);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(scratch.path("out").join("report.json")).unwrap()).unwrap();
    let keys = |value: &serde_json::Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>().join(" ");
    assert_eq!(REPORT_FORMAT, 1, "raise it with the lists below");
    assert_eq!(
        keys(&json),
        "budgets cells cells_done command confidence first_seed format height kind machine reference scene seeds \
         variants wall_seconds width"
    );
    assert_eq!(
        keys(&json["variants"][0]),
        "arguments lanes load_seconds name relmse_by_samples relmse_by_seconds rows setup_seconds targets threads"
    );
    assert_eq!(
        keys(&json["variants"][0]["rows"][0]),
        "bias_squared budget discarded_samples doubts largest_relative_share largest_sample_share largest_share mae mse \
         paths rays relative_bias_squared relative_variance relmse relmse_trusted rmse rmse_trusted samples_per_pixel seconds \
         seeds time_to_unit_variance variance variant wall_seconds"
    );
    assert_eq!(keys(&json["variants"][0]["rows"][0]["relmse"]), "dof hi lo standard_error value");
    assert_eq!(json["variants"][0]["rows"][0]["budget"]["samples"], 1);
}

#[test]
fn a_resumed_study_has_the_figures_of_one_that_ran_through() {
    let scratch = Scratch::new();
    let whole = ["--spp", "1,4", "--seeds", "4", "--reference-spp", "16", "--variants", "a: ; b: --general"];
    let through = study(&scratch, "through", &whole);
    let part = ["--spp", "1,4", "--seeds", "2", "--reference-spp", "16", "--variants", "a: ; b: --general"];
    let first = study(&scratch, "parts", &part);
    let resumed = study(&scratch, "parts", &[&whole[..], &["--resume"]].concat());
    assert_eq!(errors(&through), errors(&resumed));
    assert_ne!(errors(&first), errors(&resumed));
    // What was there was not rendered again: times are those of the first session.
    let times = |report: &ConvergeReport| -> Vec<f64> {
        let rows = report.variants.iter().flat_map(|v| &v.rows);
        rows.flat_map(|row| row.seeds[..2].iter().map(|seed| seed.render_seconds)).collect()
    };
    assert_eq!(times(&first), times(&resumed));
}

#[test]
fn seconds_become_one_sample_count_for_all_seeds() {
    let scratch = Scratch::new();
    let report = study(&scratch, "out", &["--times", "0.1,0.05", "--seeds", "3", "--reference-spp", "64"]);
    assert_eq!(report.budgets, [Budget::Seconds(0.05), Budget::Seconds(0.1)]);
    let rows = &report.variants[0].rows;
    assert!(rows[1].samples_per_pixel > rows[0].samples_per_pixel);
    assert_eq!(rows[1].paths, rows[1].samples_per_pixel * 24 * 16);
    // Generous: other tests share the cores.
    assert!((0.02..1.0).contains(&rows[1].seconds.value), "{:?}", rows[1].seconds);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_finished_cells_and_resume_ends_the_study() {
    let scratch = Scratch::new();
    let arguments = ["converge", "scene.toml", "-o", "out", "--quiet", "--spp", "1,600", "--seeds", "12"];
    let rest = ["--reference-spp", "16", "--", "--threads", "1", "--size", "48x32"];
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("octolux"))
        .current_dir(scratch.folder.path())
        .args(arguments)
        .args(rest)
        .spawn()
        .unwrap();
    let finished = || {
        let text = std::fs::read_to_string(scratch.path("out/cells.json")).unwrap_or_default();
        text.matches("render_seconds").count()
    };
    for _ in 0..3_000 {
        if finished() >= 3 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(child.id() as i32), nix::sys::signal::Signal::SIGINT).unwrap();
    assert!(child.wait().unwrap().success());
    let interrupted = report(&scratch, "out");
    assert!((3..24).contains(&interrupted.cells_done), "{} cells", interrupted.cells_done);
    let html = std::fs::read_to_string(scratch.path("out/report.html")).unwrap();
    assert!(html.contains("Unfinished"));
    let output = scratch.run(&[&arguments[..], &["--resume"], &rest[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(report(&scratch, "out").cells_done, 24);
}

#[test]
fn what_cannot_be_studied_is_refused_in_one_line() {
    let scratch = Scratch::new();
    let refused = |arguments: &[&str], reason: &str| {
        let output = scratch.run(&[&["converge", "scene.toml", "-o", "out", "--quiet"], arguments].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(reason) && said.trim().lines().count() == 1, "{arguments:?}: {said}");
    };
    for flag in [
        "--spp 4",
        "--time 1",
        "--error 0.1",
        "--seed 3",
        "-o a.exr",
        "--png a.png",
        "--json a.json",
        "--state a",
        "--resume a",
        "--samples 0..64",
    ] {
        refused(&["--variants", &format!("a: {flag}")], "is not a variant's to say");
    }
    refused(&["--variants", "a: --lane 8"], "variant `a`: unexpected argument '--lane'");
    refused(&["--variants", "a: --lanes 5"], "8 and 16 lanes");
    refused(&["--variants", "a: --lanes 8; b: --lanes 8"], "same flags");
    refused(&["--variants", "a: --lanes 8; a: --lanes 1"], "same name");
    refused(&["--variants", "a: ; b: --size 8x8"], "only images of one size");
    refused(&["--variants", "a: nowhere.toml"], "nowhere.toml");
    refused(&["--reference", "nowhere.exr"], "nowhere.exr");
    assert!(scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "1", "--size", "8x8"]).status.success());
    refused(&["--reference", "a.exr"], "8x8 pixels, but the scene renders 24x16");
    std::fs::write(scratch.path("a.json"), "{\"relmse_floor\": -1.0, \"rmse_floor\": 0.1}").unwrap();
    refused(&["--reference", "a.exr", "--", "--size", "8x8"], "a noise is not below 0");
    std::fs::write(scratch.path("a.json"), "{\"relmse_floor\": \"none\"}").unwrap();
    refused(&["--reference", "a.exr", "--", "--size", "8x8"], "a.json");
    assert!(!scratch.path("out").exists(), "what is refused leaves no study behind");
    let small = ["converge", "scene.toml", "-o", "out", "--spp", "1,2", "--seeds", "2", "--quiet"];
    assert!(scratch.run(&small).status.success());
    refused(&["--spp", "1,2", "--seeds", "2", "--resume", "--", "--size", "8x8"], "another image size");
    let other = ["converge", "scene.toml", "-o", "new", "--quiet", "--reference", "a.exr", "--", "--size", "8x8"];
    let said = text(&scratch.run(&other).stderr);
    assert!(said.contains("a.json") && said.contains("relmse_floor"), "{said}");
}

/// An image of the name that a made reference gets may be somebody's only one.
#[test]
fn a_reference_of_somebody_elses_is_not_written_over() {
    let scratch = Scratch::new();
    std::fs::create_dir(scratch.path("out")).unwrap();
    scratch.run(&["render", "scene.toml", "--spp", "4", "-o", "out/reference.exr", "--quiet"]);
    let kept = std::fs::read(scratch.path("out/reference.exr")).unwrap();
    let arguments = ["converge", "scene.toml", "-o", "out", "--quiet", "--spp", "1,2", "--seeds", "2"];
    for sidecar in [None, Some("{\"relmse_floor\": 0.0, \"rmse_floor\": 0.0, \"spp\": 4}")] {
        sidecar.into_iter().for_each(|text| std::fs::write(scratch.path("out/reference.json"), text).unwrap());
        let output = scratch.run(&[&arguments[..], &["--resume"]].concat());
        let said = text(&output.stderr);
        assert_eq!((output.status.code(), said.lines().count()), (Some(2), 1), "{said}");
        assert!(said.contains("out/reference.exr") && said.contains("--reference"), "{said}");
        assert_eq!(std::fs::read(scratch.path("out/reference.exr")).unwrap(), kept);
    }
    let output = scratch.run(&[&arguments[..], &["--resume", "--reference", "out/reference.exr"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(std::fs::read(scratch.path("out/reference.exr")).unwrap(), kept);
}

/// Of the files that a study leaves, each alone in a folder may be somebody's; a folder whose cells were deleted, to start anew,
/// is a study's all the same.
#[test]
fn files_of_somebody_elses_are_not_written_over() {
    let scratch = Scratch::new();
    let run = |folder: &str| {
        let budget = ["--quiet", "--spp", "1", "--seeds", "1", "--reference-spp", "4"];
        let output = scratch.run(&[&["converge", "scene.toml", "-o", folder], &budget[..]].concat());
        (output.status.code(), text(&output.stderr))
    };
    assert_eq!(run("out").0, Some(0));
    let listed = |folder: &str| std::fs::read_dir(scratch.path(folder)).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<_> = listed("out").chain(listed("out/images")).filter(|path| path.is_file()).collect();
    assert_eq!(files.len(), 15);
    for (i, file) in files.iter().enumerate() {
        let folder = format!("{i}");
        let name = file.strip_prefix(scratch.path("out")).unwrap();
        let theirs = scratch.path(&folder).join(name);
        std::fs::create_dir_all(theirs.parent().unwrap()).unwrap();
        std::fs::write(&theirs, "mine").unwrap();
        let (code, said) = run(&folder);
        assert!(
            code == Some(2) && said.lines().count() == 1 && said.contains(name.to_str().unwrap()),
            "{name:?}: {said}"
        );
        assert_eq!(std::fs::read_to_string(&theirs).unwrap(), "mine");
        assert_eq!(listed(&folder).count(), 1, "nothing was made beside {name:?}");
    }
    std::fs::remove_file(scratch.path("out/cells.json")).unwrap();
    assert_eq!(run("out"), (Some(0), String::new()));
}

#[test]
fn a_folder_belongs_to_one_study() {
    let scratch = Scratch::new();
    let budget = ["--spp", "1", "--seeds", "1", "--reference-spp", "4"];
    study(&scratch, "out", &budget);
    let again = |more: &[&str]| {
        let common = ["converge", "scene.toml", "-o", "out", "--quiet"];
        let output = scratch.run(&[&common, &budget[..], more].concat());
        (output.status.code(), text(&output.stderr))
    };
    let (code, said) = again(&[]);
    assert!(code == Some(2) && said.contains("--resume"), "{said}");
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    std::fs::write(scratch.path("scene.toml"), scene.replace("vfov = 40", "vfov = 41")).unwrap();
    let (code, said) = again(&["--resume"]);
    assert!(code == Some(2) && said.contains("another state of the scene"), "{said}");
}

/// What is said of a target rests on rows; where these have their star, so has it.
#[test]
fn targets_that_rest_on_doubted_rows_have_their_star() {
    let scratch = Scratch::new();
    let study = ["converge", "scene.toml", "-o", "out", "--spp", "1,4,16", "--seeds", "2", "--reference-spp", "64"];
    let said = text(&scratch.run(&study).stdout);
    let targets =
        said.lines().find(|line| line.contains("slope by samples")).unwrap().split("; relMSE ").nth(1).unwrap();
    let (known, starred) = (targets.matches(" s [").count(), targets.matches(" *").count());
    assert!(known > 0 && starred == known, "two seeds are doubted: {said}");
}

/// Seeds in which no value of relMSE stands out may be those that missed what others find, of which the squared error tells.
#[test]
fn a_relmse_is_not_trusted_where_the_squared_error_is_not() {
    let scratch = Scratch::new();
    let report =
        study(&scratch, "out", &["--spp", "2", "--seeds", "3", "--reference-spp", "64", "--", "--size", "96x64"]);
    let row = &report.variants[0].rows[0];
    assert!(row.largest_share > 0.01 && row.largest_relative_share < 0.01, "{:?}", row.doubts);
    assert!(!row.rmse_trusted && !row.relmse_trusted, "{:?}", row.doubts);
}

/// Of a variance layer the noise of a reference is believed, and taken off every error.
#[test]
fn references_whose_variance_is_none_are_refused() {
    let scratch = Scratch::new();
    let names = ["B", "G", "R", "variance.B", "variance.G", "variance.R"];
    let validity = ("variance_validity".to_owned(), octolux::film::VarianceValidity::Independent.text().into());
    for (variance, is_refused) in [(1e-4, false), (-1e-4, true), (f32::NAN, true), (f32::INFINITY, true)] {
        let path = scratch.path("noisy.exr");
        octolux::film::exr_write::write_rows(&path, (24, 16), &names, std::slice::from_ref(&validity), |y, planes| {
            planes.fill(1.0);
            planes[3 * 24..].fill(1e-4);
            planes[3 * 24] = if y == 2 { variance } else { 1e-4 };
        })
        .unwrap();
        let command = ["converge", "scene.toml", "-o", "out", "--spp", "1,2", "--quiet", "--reference", "noisy.exr"];
        let said = text(&scratch.run(&command).stderr);
        assert_eq!(said.contains("its variance layer is negative or not finite"), is_refused, "{variance}: {said}");
        let _ = std::fs::remove_dir_all(scratch.path("out"));
    }
}

/// What is no number is left out of every mean: an image of nothing else would be met without an error.
#[test]
fn references_that_hold_what_is_no_number_are_refused() {
    let scratch = Scratch::new();
    for (file, value, why) in
        [("nan.exr", f32::NAN, "6 of its values"), ("infinite.exr", f32::INFINITY, "6 of its values")]
    {
        let names = ["R", "G", "B"];
        octolux::film::exr_write::write_rows(&scratch.path(file), (24, 16), &names, &[], |y, planes| {
            planes.fill(if y == 3 { 0.5 } else { 1.0 });
            if y == 3 {
                planes[..6].fill(value);
            }
        })
        .unwrap();
        for command in ["converge scene.toml -o out --spp 1,2", "render scene.toml -o s.exr --png s.png --ladder 1,2"] {
            let words: Vec<&str> = command.split(' ').chain(["--quiet", "--reference", file]).collect();
            let output = scratch.run(&words);
            let said = text(&output.stderr);
            assert_eq!((output.status.code(), said.trim().lines().count()), (Some(2), 1), "{said}");
            assert!(said.contains(why) && said.contains(file), "{said}");
        }
    }
}
