//! Pipes, terminals and words that are no files: who reads, who does not, and what has no room.

use super::{Scratch, text};
use std::process::{Command, Output, Stdio};

fn octolux(scratch: &Scratch) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("octolux"));
    command.current_dir(scratch.folder.path());
    command
}

/// `octolux … | head`: the command ends as others do whose reader is gone, and says nothing.
#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let scratch = Scratch::new();
    for arguments in [&["info", "scene.toml"][..], &["estimate", "die", "--repeats", "2"], &["completions", "bash"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = octolux(&scratch)
            .args(arguments)
            .stdout(writer)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
            .wait_with_output()
            .unwrap();
        assert_eq!((output.status.code(), text(&output.stderr)), (Some(141), String::new()), "{arguments:?}");
    }
}

/// `octolux render … 2>&1 | head -1`: what is told of the work is lost, the image is not.
#[test]
fn an_image_is_written_though_nobody_reads_how_it_goes() {
    let scratch = Scratch::new();
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let status = octolux(&scratch)
        .args(["render", "scene.toml", "--size", "8x8", "--spp", "4", "--explain", "-o", "a.exr"])
        .stderr(writer)
        .status()
        .unwrap();
    assert!(status.success() && scratch.folder.path().join("a.exr").is_file(), "{status}");
}

/// `octolux render nothing.toml 2>&1 | head -0`: a script still sees that it failed.
#[test]
fn an_error_that_nobody_reads_is_still_one() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let status = Command::new(assert_cmd::cargo::cargo_bin("octolux"))
        .args(["render", "there_is_no_such_scene.toml", "-o", "a.exr"])
        .stderr(writer)
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(2), "{status}");
}

/// `octolux … > /dev/full`: a line and an exit code, no panic.
#[test]
fn a_full_disk_behind_standard_output_is_an_error() {
    let scratch = Scratch::new();
    let into_full = |arguments: &[&str]| -> Output {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        octolux(&scratch).args(arguments).stdout(full).stderr(Stdio::piped()).output().unwrap()
    };
    for arguments in [
        &["info", "scene.toml"][..],
        &["completions", "zsh"],
        &["render", "scene.toml", "--spp", "1", "-o", "a.exr", "--quiet", "--json", "-"],
        &["replay", "scene.toml", "--pixel", "1,1"],
    ] {
        let output = into_full(arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains("stdout") && said.lines().count() == 1, "{arguments:?}: {said}");
    }
}

/// What is written into a pipe is what would stand in a file.
#[test]
fn images_and_reports_go_into_pipes() {
    let scratch = Scratch::new();
    let render = ["render", "scene.toml", "--spp", "2", "--quiet"];
    let piped = |more: &[&str]| {
        let output = octolux(&scratch).args(render).args(more).output().unwrap();
        assert!(output.status.success(), "{more:?}: {}", text(&output.stderr));
        output.stdout
    };
    piped(&["-o", "a.exr", "--png", "a.png"]);
    assert!(piped(&["--png", "/dev/stdout"]) == std::fs::read(scratch.path("a.png")).unwrap());
    std::fs::write(scratch.path("b.exr"), piped(&["-o", "/dev/stdout"])).unwrap();
    let image = |name: &str| octolux::film::read_exr(&scratch.path(name)).unwrap().rgb().map(<[f32]>::to_vec);
    assert!(image("a.exr") == image("b.exr"));
    let report = piped(&["-o", "a.exr", "--json", "/dev/stdout"]);
    assert!(serde_json::from_slice::<serde_json::Value>(&report).is_ok());
}

/// A folder's name need not be UTF-8.
#[cfg(unix)]
#[test]
fn names_that_are_no_text_end_no_study() {
    use std::os::unix::ffi::OsStrExt;
    let scratch = Scratch::new();
    let folder = std::ffi::OsStr::from_bytes(b"caf\xe9");
    let studies = [
        &["estimate", "pi", "--samples", "4", "--repeats", "3", "--methods", "mc"][..],
        &["converge", "scene.toml", "--spp", "1,2", "--seeds", "2", "--quiet"],
    ];
    for study in studies {
        let output = octolux(&scratch).args(study).arg("-o").arg(folder).output().unwrap();
        assert!(output.status.success(), "{study:?}: {}", text(&output.stderr));
        std::fs::remove_dir_all(scratch.folder.path().join(folder)).unwrap();
    }
}
