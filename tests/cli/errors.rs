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
    // Where a link leads there is nothing yet.
    std::os::unix::fs::symlink("b.state", scratch.path("link.exr")).unwrap();
    for rays in ["rays.tri", "rays.S.rays"] {
        std::fs::write(scratch.path(rays), "recorded").unwrap();
    }
    for arguments in [
        &["render", "scene.toml", "-o", "scene.toml"][..],
        &["render", "scene.toml", "--png", "folder/../scene.toml"],
        &["render", "scene.toml", "--json", "./scene.toml"],
        &["render", "scene.toml", "-o", "b", "--png", "b"],
        &["render", "scene.toml", "-o", "b.exr", "--json", "folder/../b.exr"],
        &["render", "scene.toml", "-o", "b.exr", "--state", "./b.exr"],
        &["render", "scene.toml", "--resume", "a.state", "-o", "a.state", "--spp", "4"],
        &["render", "scene.toml", "--resume", "a.state", "--state", "b.state", "-o", "a.state", "--spp", "4"],
        &["merge", "a.state", "-o", "a.state"],
        &["merge", "a.state", "-o", "b", "--png", "b"],
        &["render", "scene.toml", "-o", "link.exr", "--state", "b.state"],
        &["bench", "rays", "rays", "--json", "rays.tri"],
        &["bench", "rays", "rays", "--sets", "P,S", "--json", "rays.S.rays"],
    ] {
        let said = refused(&scratch, arguments);
        assert!(said.contains("would be written over") && said.lines().count() == 1, "{arguments:?}: {said}");
        assert_eq!(kept, ["scene.toml", "a.state"].map(|file| std::fs::read(scratch.path(file)).unwrap()));
        for unwritten in ["b", "b.exr", "b.state"] {
            assert!(!scratch.path(unwritten).exists(), "{arguments:?}");
        }
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

/// Meshes, their libraries, images and environments are as much a part of a scene as its own file.
#[test]
fn nothing_is_written_over_what_a_scene_names() {
    let scratch = Scratch::new();
    scratch.run(&["render", "scene.toml", "--spp", "2", "--size", "8x4", "-o", "sky.exr", "--png", "a.png", "--quiet"]);
    let lit = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    let lit = lit.replace("radiance = [0.2, 0.3, 0.5]", "file = \"sky.exr\"").replace("[0.6, 0.5, 0.4]", "\"a.png\"");
    std::fs::write(scratch.path("lit.toml"), lit).unwrap();
    std::fs::write(scratch.path("m.mtl"), "newmtl floor\nKd .5 .5 .5\nmap_Kd a.png\n").unwrap();
    let model = "v -3 0 3\nv 3 0 3\nv 3 0 -3\nvt 0 0\nusemtl floor\nf 1/1 2/1 3/1\n";
    std::fs::write(scratch.path("floor.obj"), model).unwrap();
    std::fs::write(scratch.path("model.obj"), format!("mtllib m.mtl\n{model}")).unwrap();
    let named = ["lit.toml", "floor.obj", "sky.exr", "a.png", "model.obj", "m.mtl"];
    let kept = named.map(|file| std::fs::read(scratch.path(file)).unwrap());
    for arguments in [
        &["render", "lit.toml", "-o", "floor.obj"][..],
        &["render", "lit.toml", "-o", "./sky.exr"],
        &["render", "lit.toml", "--png", "a.png"],
        &["render", "lit.toml", "-o", "b.exr", "--json", "floor.obj"],
        &["render", "model.obj", "-o", "m.mtl"],
        &["render", "model.obj", "-o", "model.obj"],
        &["render", "model.obj", "--png", "a.png"],
        &[
            "render",
            "scene.toml",
            "--size",
            "8x4",
            "--ladder",
            "1",
            "--png",
            "b.png",
            "-o",
            "sky.exr",
            "--reference",
            "sky.exr",
        ],
        &["info", "lit.toml", "--json", "lit.toml"],
        &["info", "lit.toml", "--json", "floor.obj"],
        &["bench", "lit.toml", "--json", "floor.obj"],
        &["compare", "sky.exr", "sky.exr", "--diff", "sky.exr"],
        &["compare", "sky.exr", "sky.exr", "--json", "sky.exr"],
        &["estimate", "hemisphere", "--image", "sky.exr", "--json", "sky.exr"],
    ] {
        let said = refused(&scratch, arguments);
        assert!(said.contains("would be written over") && said.lines().count() == 1, "{arguments:?}: {said}");
        assert!(kept == named.map(|file| std::fs::read(scratch.path(file)).unwrap()), "{arguments:?}");
        assert!(!scratch.path("b.exr").exists() && !scratch.path("b.png").exists(), "{arguments:?}");
    }
}

/// As long as a name may be, a file can be written; where none can, that is known before hours of rendering.
#[test]
fn what_cannot_be_written_is_known_before_rendering() {
    let scratch = Scratch::new();
    let longest = "x".repeat(251) + ".exr";
    assert_eq!(scratch.run(&["render", "scene.toml", "--spp", "1", "-o", &longest]).status.code(), Some(0));
    assert!(scratch.path(&longest).is_file());
    let longer = "x".repeat(252) + ".exr";
    for file in [longer.as_str(), "/proc/octolux.exr"] {
        let said = refused(&scratch, &["render", "scene.toml", "--spp", "1", "--time", "1000", "-o", file]);
        assert!(said.contains("cannot write") && said.lines().count() == 1, "{said}");
        assert!(!said.contains("render"), "{said}");
    }
}

/// A file that nobody may write to stays as it is, be it named or the one that an image is written to where none is, and be the user
/// one whom no mode stops.
#[test]
fn a_read_only_file_stays() {
    let scratch = Scratch::new();
    assert_eq!(
        scratch.run(&["render", "scene.toml", "--spp", "1", "-o", "scene.exr", "--quiet"]).status.code(),
        Some(0)
    );
    let mut permissions = std::fs::metadata(scratch.path("scene.exr")).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(scratch.path("scene.exr"), permissions).unwrap();
    let kept = std::fs::read(scratch.path("scene.exr")).unwrap();
    std::fs::rename(scratch.path("scene.toml"), scratch.path("scene.2.toml")).unwrap();
    std::fs::copy(scratch.path("scene.exr"), scratch.path("scene.2.exr")).unwrap();
    for arguments in [
        &["render", "scene.2.toml", "--spp", "1"][..],
        &["render", "scene.2.toml", "--spp", "1", "-o", "scene.exr"],
        &["info", "scene.2.toml", "--json", "scene.exr"],
    ] {
        let said = refused(&scratch, arguments);
        assert!(said.contains("read-only") && said.lines().count() == 1, "{arguments:?}: {said}");
        assert!(std::fs::read(scratch.path("scene.exr")).unwrap() == kept, "{arguments:?}");
        assert!(std::fs::read(scratch.path("scene.2.exr")).unwrap() == kept, "{arguments:?}");
    }
}

/// The same of a folder of results, before anything is computed for them.
#[test]
fn a_read_only_report_stays() {
    let scratch = Scratch::new();
    let estimate = ["estimate", "pi", "--samples", "1,4", "--repeats", "4", "-o", "study"];
    let converge =
        ["converge", "scene.toml", "--spp", "1,4", "--seeds", "2", "--reference", "r.exr", "--quiet", "-o", "errors"];
    let reference = ["render", "scene.toml", "--spp", "4", "-o", "r.exr", "--quiet"];
    assert_eq!(scratch.run(&reference).status.code(), Some(0));
    for (arguments, file) in
        [(&estimate[..], "study/report.html"), (&[&converge[..], &["--resume"]].concat(), "errors/report.html")]
    {
        let arguments = arguments.to_vec();
        assert_eq!(scratch.run(&arguments).status.code(), Some(0), "{arguments:?}");
        let mut permissions = std::fs::metadata(scratch.path(file)).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(scratch.path(file), permissions).unwrap();
        let said = refused(&scratch, &arguments);
        assert!(
            said.contains(file) && said.contains("read-only") && said.lines().count() == 1,
            "{arguments:?}: {said}"
        );
    }
}

/// A link to a file that is not there yet leads to where that file will be.
#[cfg(unix)]
#[test]
fn links_to_nothing_are_followed() {
    let scratch = Scratch::new();
    std::fs::create_dir(scratch.path("far")).unwrap();
    std::os::unix::fs::symlink("far/next.exr", scratch.path("link.exr")).unwrap();
    std::os::unix::fs::symlink("../there.exr", scratch.path("far/next.exr")).unwrap();
    assert_eq!(scratch.run(&["render", "scene.toml", "--spp", "1", "-o", "link.exr"]).status.code(), Some(0));
    assert!(scratch.path("link.exr").is_symlink() && scratch.path("far/next.exr").is_symlink());
    assert!(std::fs::symlink_metadata(scratch.path("there.exr")).unwrap().is_file());
}

/// A line repeats what is wrong, not a megabyte of it.
#[test]
fn long_words_are_shortened() {
    let scratch = Scratch::new();
    let word = "x".repeat(1 << 20);
    std::fs::write(scratch.path("floor.obj"), format!("v 0 0 {word}\n")).unwrap();
    let said = refused(&scratch, &["render", "scene.toml", "-o", "a.exr"]);
    assert!(said.len() < 2000 && said.contains("floor.obj:1: ") && said.contains("is not a finite number"), "{said}");
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
        &["bench", "scene.toml", "--seconds", "nan"],
        &["bench", "scene.toml", "--seconds", "1e300"],
        &["bench", "scene.toml", "--threads", "0"],
        &["bench", "scene.toml", "--json", "no/such/folder.json"],
        &["render", "scene.toml", "--png", "a.png", "--exposure", "nan"],
        &["render", "scene.toml", "--png", "a.png", "--ladder", "1,2", "--unbiased"],
        &["render", "scene.toml", "--spp", "1", "--save-every", "5"],
        &["estimate", "interval", "--f", "1/x", "--range", "0,1"],
        &["converge", "scene.toml", "-o", "study", "--variants", "x: --unbiased"],
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
    let mut runner = TestRunner::new(Config { cases: 60, failure_persistence: None, ..Config::default() });
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
