//! `render --adaptive` and `converge` with it.

use super::{Scratch, text};
use octolux::film::read_exr;

#[test]
fn the_report_and_the_image_say_how_samples_were_divided() {
    let scratch = Scratch::new();
    // Of shared paths tiles are larger, and here too few to tell anything.
    let arguments = ["render", "scene.toml", "--adaptive", "--spp", "128", "-o", "a.exr", "--path-reuse", "off"];
    let report = scratch.json(&[&arguments[..], &["--json", "-", "--quiet"]].concat());
    let number = |key: &str| report["adaptive"][key].as_f64().unwrap();
    assert_eq!(number("pilot_samples"), 32.0);
    assert!(number("least") < 128.0 && number("most") > 128.0 && number("mean") <= 128.0, "{report}");
    assert_eq!(report["samples_per_pixel"].as_f64().unwrap(), number("mean").round());
    // Tiles that decide on each other have numbers of their own; those of shared paths are blocks that have them anyway.
    assert_eq!(report["sampler"], "sobol-pixels");
    let of_shared = ["render", "scene.toml", "--adaptive", "--spp", "128", "-o", "b.exr", "--json", "-", "--quiet"];
    assert_eq!(scratch.json(&of_shared)["sampler"], "sobol");
    let image = read_exr(&scratch.path("a.exr")).unwrap();
    let samples = image.channel("samples").expect("a channel with the numbers of samples");
    let mean = samples.iter().map(|&n| f64::from(n)).sum::<f64>() / samples.len() as f64;
    assert!((mean - number("mean")).abs() < 1e-9);
    // What a person reads says it, too.
    let said = text(&scratch.run(&["render", "scene.toml", "--adaptive", "--spp", "128", "-o", "a.exr"]).stderr);
    assert!(said.contains("adaptive:") && said.contains("bias as measured"), "{said}");
    // Too few are not divided, and that is said.
    let said = text(&scratch.run(&["render", "scene.toml", "--adaptive", "--spp", "4", "-o", "b.exr"]).stderr);
    assert!(said.contains("too small for a pilot") && !said.contains("bias as measured"), "{said}");
    // An even image has no such channel.
    scratch.run(&["render", "scene.toml", "--spp", "4", "-o", "b.exr", "--quiet"]);
    assert!(read_exr(&scratch.path("b.exr")).unwrap().channel("samples").is_none());
}

#[test]
fn what_cannot_be_divided_is_refused_in_one_line() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    let with = |name: &str, integrator: &str| {
        std::fs::write(scratch.path(name), format!("{scene}\n[integrator]\n{integrator}\n")).unwrap();
    };
    with("gather.toml", "kind = \"gather\"");
    let output = scratch.run(&["render", "gather.toml", "--adaptive", "-o", "a.exr"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("--adaptive") && said.contains("gather") && said.trim().lines().count() == 1, "{said}");
    assert!(!scratch.path("a.exr").exists());
    for other in [["--tile", "8"], ["--state", "a.state"], ["--samples", "0..64"], ["--ladder", "1,2"]] {
        let output = scratch.run(&[&["render", "scene.toml", "--adaptive", "--png", "a.png"][..], &other].concat());
        assert_eq!(output.status.code(), Some(2), "{other:?}: {}", text(&output.stderr));
    }
}

#[test]
fn seconds_may_be_the_budget() {
    let scratch = Scratch::new();
    let report =
        scratch.json(&["render", "scene.toml", "--adaptive", "--time", "0.5", "-o", "a.exr", "--json", "-", "--quiet"]);
    assert_eq!(report["stopped_by"], "time");
    // The pilot goes on while there is time, and is in the image: so its paths are counted once.
    assert!(report["adaptive"]["pilot_samples"].as_u64().unwrap() >= 16, "{report}");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let paths = number(&report["adaptive"]["mean"]) * 24.0 * 16.0;
    assert!((number(&report["paths"]) - paths).abs() < 0.5, "{report}");
}

#[test]
fn an_error_may_be_the_budget() {
    let scratch = Scratch::new();
    let report = scratch.json(&[
        "render",
        "scene.toml",
        "--adaptive",
        "--error",
        "0.03",
        "-o",
        "a.exr",
        "--json",
        "-",
        "--quiet",
    ]);
    assert_eq!(report["stopped_by"], "error");
    assert!(report["relative_error"].as_f64().unwrap() <= 0.03 && !report["adaptive"].is_null(), "{report}");
}

/// Nothing is rendered yet: a good image is not replaced by a black one.
#[test]
fn ctrl_c_during_the_pilot_leaves_the_image() {
    let scratch = Scratch::new();
    scratch.run(&["render", "scene.toml", "--spp", "4", "-o", "a.exr", "--quiet"]);
    let before = std::fs::read(scratch.path("a.exr")).unwrap();
    let output = scratch.interrupted(&[
        "render",
        "scene.toml",
        "--adaptive",
        "--spp",
        "4096",
        "--size",
        "1024x1024",
        "-o",
        "a.exr",
        "--quiet",
    ]);
    let said = text(&output.stderr);
    assert!(said.contains("nothing was written") && output.status.code() == Some(2), "{said}");
    assert!(std::fs::read(scratch.path("a.exr")).unwrap() == before);
}

#[test]
fn converge_measures_it_beside_even_samples() {
    let scratch = Scratch::new();
    let variants = "even:; adaptive: --adaptive";
    let output = scratch.run(&[
        "converge",
        "scene.toml",
        "-o",
        "study",
        "--spp",
        "64",
        "--seeds",
        "2",
        "--reference-spp",
        "256",
        "--quiet",
        "--variants",
        variants,
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report = std::fs::read_to_string(scratch.path("study/report.json")).unwrap();
    assert!(report.contains("--adaptive"), "the variant is named with its flags");
    // The pilot's paths are counted.
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    println!("{}", report["variants"][1]["rows"]);
}
