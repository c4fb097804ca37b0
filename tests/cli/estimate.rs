//! `octolux estimate`: files, JSON, refusals.

use super::{Scratch, text};

#[test]
fn a_study_writes_its_report() {
    let scratch = Scratch::new();
    let arguments = ["estimate", "hemisphere", "--f", "cos3", "--samples", "1,16", "--repeats", "50", "-o", "out"];
    let output = scratch.run(&arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("mc-is") && said.contains("bmc-is") && said.contains("exact 1.2566370614"), "{said}");
    let file = |name: &str| std::fs::read_to_string(scratch.path("out").join(name)).unwrap();
    assert!(file("report.html").contains("octolux estimate hemisphere"), "the command is in the page");
    assert!(file("rmse-samples.svg").starts_with("<svg") && file("rmse-seconds.svg").starts_with("<svg"));
    let csv = file("errors.csv");
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().count() == 13 && csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    let json: serde_json::Value = serde_json::from_str(&file("study.json")).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), 6);
}

/// Of the files that a study or a demonstration leaves, each alone in a folder may be somebody's; an earlier study is replaced.
#[test]
fn files_of_somebody_elses_are_not_written_over() {
    let scratch = Scratch::new();
    for (kind, expected, problem) in [
        ("study", 8, &["estimate", "die", "--methods", "mc,clamped", "--samples", "2,4", "--repeats", "20"][..]),
        ("shown", 7, &["estimate", "gp-1d", "--samples", "2"]),
    ] {
        let run = |folder: &str| {
            let output = scratch.run(&[problem, &["-o", folder]].concat());
            (output.status.code(), text(&output.stderr))
        };
        assert_eq!((run(kind).0, run(kind).0), (Some(0), Some(0)));
        let names: Vec<_> =
            std::fs::read_dir(scratch.path(kind)).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names.len(), expected, "{names:?}");
        for name in names {
            let folder = format!("{kind} {}", name.display());
            std::fs::create_dir(scratch.path(&folder)).unwrap();
            std::fs::write(scratch.path(&folder).join(&name), "{}").unwrap();
            let (code, said) = run(&folder);
            assert!(
                code == Some(2) && said.lines().count() == 1 && said.contains("another folder"),
                "{name:?}: {said}"
            );
            let files: Vec<_> = std::fs::read_dir(scratch.path(&folder)).unwrap().collect();
            assert_eq!((files.len(), std::fs::read(scratch.path(&folder).join(&name)).unwrap()), (1, b"{}".to_vec()));
        }
    }
}

/// The report is held against all that the scene is read from, not its own file alone.
#[test]
fn no_report_is_written_over_what_is_read() {
    let scratch = Scratch::new();
    let kept = std::fs::read(scratch.path("floor.obj")).unwrap();
    let common = ["estimate", "illumination", "--scene", "scene.toml", "--pixel", "3,13", "--samples", "1"];
    let output = scratch.run(&[&common[..], &["--repeats", "2", "--json", "floor.obj"]].concat());
    let said = text(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains("floor.obj: is read here"), "{said}");
    assert_eq!(std::fs::read(scratch.path("floor.obj")).unwrap(), kept);
}

#[test]
fn json_alone_goes_to_standard_output() {
    let scratch = Scratch::new();
    let study = scratch.json(&["estimate", "die", "--samples", "4", "--repeats", "20", "--json", "-"]);
    // Six sixths are not quite 1 in f64.
    assert!((study["quantity"]["exact"].as_f64().unwrap() - 3.5).abs() < 1e-14);
    let shown = scratch.json(&["estimate", "ohagan", "--json", "-"]);
    assert_eq!(shown["parts"].as_array().unwrap().len(), 2);
}

#[test]
fn what_belongs_to_the_user_is_taken() {
    let scratch = Scratch::new();
    let common = ["--samples", "16", "--repeats", "20", "--json", "-"];
    let exact = |arguments: &[&str]| {
        let all: Vec<&str> = ["estimate"].iter().chain(arguments).chain(&common).copied().collect();
        scratch.json(&all)["quantity"]["exact"].as_f64().unwrap()
    };
    assert!((exact(&["discrete", "--table", "-1:0.25,3:0.75"]) - 2.0).abs() < 1e-12);
    assert!((exact(&["continuous", "--density", "x/2", "--range", "0,2", "--f", "x^2"]) - 2.0).abs() < 1e-12);
    assert!((exact(&["continuous", "--density", "2*x", "--probability", "0,0.5"]) - 0.25).abs() < 1e-12);
    assert!((exact(&["interval", "--f", "x*exp(-x)", "--range", "-1,1"]) + 2.0 / 1f64.exp()).abs() < 1e-12);
    assert!((exact(&["cube-d", "--f", "corner", "--dimensions", "12"]) - 1.0).abs() < 1e-12);
    // The floor under the sky, beside the ball: white light 0.2, 0.3, 0.5 is what mostly arrives.
    assert!(exact(&["illumination", "--scene", "scene.toml", "--pixel", "3,13"]) > 0.0);
}

#[test]
fn wrong_problems_are_refused_in_one_line() {
    let scratch = Scratch::new();
    for (arguments, reason) in [
        (&["continuous", "--density", "3*x"][..], "1.5"),
        (&["continuous", "--density", "x+"], "expression"),
        (&["discrete"], "--table"),
        (&["discrete", "--table", "1:0.5,2:0.6"], "1.1"),
        (&["interval", "--f", "y"], "variable is x"),
        (&["interval", "--range", "1,0"], "range"),
        (&["cube-d", "--dimensions", "21"], "21 dimensions"),
        (&["hemisphere", "--methods", "magic"], "magic"),
        (&["hemisphere", "--f", "moon"], "moon"),
        (&["hemisphere", "--image", "scene.toml"], "scene.toml"),
        (&["hemisphere", "--image", "none.exr"], "none.exr"),
        (&["illumination"], "--scene"),
        (&["illumination", "--scene", "scene.toml", "--pixel", "99,0"], "outside"),
        (&["gp-1d", "--f", "ln(x-2)"], "ln(x-2)"),
        (&["gp-1d", "--samples", "100000"], "100000"),
        (&["pi", "--mode", "brute"], "--mode says nothing of pi: it is for illumination"),
        (&["ohagan", "--range", "0,2"], "it is for continuous, interval"),
        (&["die", "--f", "sky"], "gp-1d, ohagan"),
        (&["interval", "--sky", "3"], "hemisphere"),
        (&["hemisphere", "--sky", "3"], "--sky says nothing of --f cosine: it is for sky, edge, sun"),
        (&["hemisphere", "--f", "cos3", "--exponent", "3"], "--exponent says nothing of --f cos3: it is for cosine"),
        (&["ohagan", "--methods", "mc"], "--methods says nothing of ohagan"),
        (&["gp-1d", "--repeats", "10"], "--repeats says nothing of gp-1d"),
        (&["variance-rules", "--samples", "10"], "--samples says nothing of variance-rules"),
        (&["variance-rules", "--lanes", "8"], "--lanes says nothing of variance-rules"),
    ] {
        let all: Vec<&str> = ["estimate"].iter().chain(arguments).copied().collect();
        let output = scratch.run(&all);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(reason) && said.trim().lines().count() == 1, "{arguments:?}: {said}");
    }
}
