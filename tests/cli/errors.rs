//! Bad input: one clear line, exit code 2, nothing written.

use super::{Scratch, text};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

/// Runs a command that must be refused, and returns its one line.
fn refused(scratch: &Scratch, arguments: &[&str]) -> String {
    let output = scratch.run(arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

#[test]
fn a_missing_scene_is_named() {
    let scratch = Scratch::new();
    let said = refused(&scratch, &["render", "nowhere.toml", "-o", "a.exr"]);
    assert_eq!(said.trim().lines().count(), 1, "{said}");
    assert!(said.contains("nowhere.toml"), "{said}");
}

#[test]
fn a_film_too_large_is_refused_wherever_its_size_is_given() {
    let scratch = Scratch::new();
    for command in [&["render", "-o", "a.exr"][..], &["info"], &["check"], &["replay", "--pixel", "0,0"]] {
        for size in ["65536x65536", "65537x1", "0x4", "16384x16385"] {
            let said = refused(&scratch, &[command, &["scene.toml", "--size", size]].concat());
            assert!(said.contains(size) && said.contains("268435456"), "{said}");
        }
    }
}

#[test]
fn nothing_is_written_over_what_is_read_or_written_here() {
    let scratch = Scratch::new();
    scratch.run(&["render", "scene.toml", "--spp", "2", "--state", "a.state", "-o", "a.exr", "--quiet"]);
    let kept = ["scene.toml", "a.state"].map(|file| std::fs::read(scratch.path(file)).unwrap());
    std::fs::create_dir(scratch.path("folder")).unwrap();
    for arguments in [
        &["render", "scene.toml", "-o", "scene.toml"][..],
        &["render", "scene.toml", "--png", "folder/../scene.toml"],
        &["render", "scene.toml", "--json", "./scene.toml"],
        &["render", "scene.toml", "-o", "b.exr", "--png", "b.exr"],
        &["render", "scene.toml", "-o", "b.exr", "--json", "folder/../b.exr"],
        &["render", "scene.toml", "-o", "b.exr", "--state", "./b.exr"],
        &["render", "scene.toml", "--resume", "a.state", "-o", "a.state", "--spp", "4"],
        &["render", "scene.toml", "--resume", "a.state", "--state", "b.state", "-o", "a.state", "--spp", "4"],
        &["merge", "a.state", "-o", "a.state"],
        &["merge", "a.state", "-o", "b.exr", "--png", "b.exr"],
    ] {
        let said = refused(&scratch, arguments);
        assert!(said.contains("would be written over") && said.lines().count() == 1, "{arguments:?}: {said}");
        assert_eq!(kept, ["scene.toml", "a.state"].map(|file| std::fs::read(scratch.path(file)).unwrap()));
        assert!(!scratch.path("b.exr").exists() && !scratch.path("b.state").exists(), "{arguments:?}");
    }
    // A state goes on in its own file, a merged one may take a part's place, and nothing is kept of what goes nowhere.
    for arguments in [
        &["render", "scene.toml", "--resume", "a.state", "--state", "a.state", "-o", "a.exr", "--spp", "4"][..],
        &["merge", "a.state", "--state", "a.state", "-o", "a.exr"],
        &["render", "scene.toml", "-o", "/dev/null", "--png", "/dev/null", "--spp", "1"],
    ] {
        assert_eq!(scratch.run(arguments).status.code(), Some(0), "{arguments:?}");
    }
}

#[test]
fn an_unknown_key_is_an_error_with_its_line() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap().replace("vfov", "fov");
    let line = 1 + scene.lines().position(|l| l.starts_with("fov")).unwrap();
    std::fs::write(scratch.path("bad.toml"), scene).unwrap();
    let said = refused(&scratch, &["render", "bad.toml", "-o", "a.exr"]);
    assert!(said.contains(&format!("bad.toml:{line}")), "line {line}: {said}");
    assert!(!scratch.path("a.exr").exists());
}

#[test]
fn a_missing_output_folder_is_found_before_rendering() {
    let scratch = Scratch::new();
    let start = std::time::Instant::now();
    let said = refused(&scratch, &["render", "scene.toml", "-o", "no/such/a.exr", "--spp", "1000000"]);
    assert!(said.contains("no/such"), "{said}");
    assert!(start.elapsed().as_secs_f64() < 10.0);
}

#[test]
fn a_failed_render_leaves_the_old_image() {
    let scratch = Scratch::new();
    assert!(scratch.run(&["render", "scene.toml", "-o", "a.exr", "--spp", "1"]).status.success());
    let before = std::fs::read(scratch.path("a.exr")).unwrap();
    std::fs::write(scratch.path("floor.obj"), "v 0 0 nonsense\n").unwrap();
    refused(&scratch, &["render", "scene.toml", "-o", "a.exr", "--spp", "1"]);
    assert_eq!(std::fs::read(scratch.path("a.exr")).unwrap(), before);
}

#[test]
fn arguments_out_of_range_are_refused() {
    let scratch = Scratch::new();
    for arguments in [
        &["render", "scene.toml", "--lanes", "4"][..],
        &["render", "scene.toml", "--size", "0x10"],
        &["render", "scene.toml", "--roulette", "0,1"],
        &["render", "scene.toml", "--roulette", "5,1.5"],
        &["render", "scene.toml", "--roulette", "NaN"],
        &["render", "scene.toml", "--spp", "0"],
        &["render", "scene.toml", "--time", "-1"],
        &["render", "scene.toml", "--time", "nan"],
        &["render", "scene.toml", "--unbiased"],
        &["render", "scene.toml", "--threads", "0"],
        &["replay", "scene.toml", "--pixel", "99,99"],
        &["check", "scene.toml", "--inject-fault", "nonsense"],
        &["bench"],
        &["compare", "scene.toml", "floor.obj"],
    ] {
        refused(&scratch, arguments);
    }
}

/// Sample indices have 32 bits: what asks for more is told so.
#[test]
fn more_samples_than_there_are_indices() {
    let scratch = Scratch::new();
    for arguments in [
        &["render", "scene.toml", "--spp", "4294967297"][..],
        &["render", "scene.toml", "--samples", "4294967296..4294967360"],
        &["render", "scene.toml", "--samples", "0..4294967297"],
        &["converge", "scene.toml", "-o", "d", "--spp", "4294967297"],
        &["replay", "scene.toml", "--pixel", "1,1", "--sample", "4294967296"],
    ] {
        let said = refused(&scratch, arguments);
        assert!(
            said.lines().next().is_some_and(|line| line.contains("4294967296") || line.contains("4294967295")),
            "{arguments:?}: {said}"
        );
    }
    // The last one there is.
    let last = ["render", "scene.toml", "--samples", "4294967232..4294967296", "-o", "a.exr", "--size", "2x2"];
    assert!(scratch.run(&last).status.success());
}

/// What a user may type for a number: refused with exit code 2 and one line of what is wrong, or taken.
#[test]
fn no_argument_panics() {
    let scratch = Scratch::new();
    let mut runner = TestRunner::new(Config { cases: 150, failure_persistence: None, ..Config::default() });
    let piece = prop::sample::select(vec![
        "",
        "0",
        "1",
        "64",
        "-1",
        "..",
        "x",
        ",",
        ":",
        ".",
        "e",
        "nan",
        "inf",
        "4294967296",
        "18446744073709551616",
        "1e400",
        "0x10",
        " ",
        "\u{e9}",
        "\u{7}",
        "128",
        "=",
        "\n",
        "1..2",
        "3x3",
    ]);
    let text = prop::collection::vec(piece, 0..5).prop_map(|pieces| pieces.concat());
    let options = [
        ("render", "--size"),
        ("render", "--samples"),
        ("render", "--time"),
        ("render", "--spp"),
        ("render", "--error"),
        ("render", "--save-every"),
        ("render", "--ladder"),
        ("replay", "--pixel"),
        ("converge", "--times"),
        ("converge", "--spp"),
        ("converge", "--variants"),
        ("estimate", "--samples"),
        ("bench", "--lanes"),
    ];
    let arguments = (text, prop::sample::select(options.to_vec()));
    let outcome = runner.run(&arguments, |(text, (command, option))| {
        let subject = if command == "estimate" { "pi" } else { "absent.toml" };
        let given = format!("{option}={text}");
        // Nothing is rendered: the scene is not there, which is said where the argument itself is good.
        let output = scratch.run(&[command, subject, &given, "-o", "none", "--json", "none/none.json"]);
        let said = super::text(&output.stderr);
        let message = said.split("\n\n").next().unwrap_or_default();
        prop_assert!(
            output.status.code() == Some(2) || (command == "estimate" && output.status.success()),
            "{given}: {said}"
        );
        prop_assert!(!said.contains("panicked"), "{given}: {said}");
        prop_assert!(message.trim_end().lines().count() <= 2 || text.contains('\n'), "{given}: {said}");
        Ok(())
    });
    outcome.unwrap_or_else(|error| panic!("{error}"));
}
