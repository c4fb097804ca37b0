//! `--state`, `--resume`, `--samples`, `merge`: parts are the whole, and no accident loses what was saved.

use super::{Scratch, text};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use octolux::film::read_exr;
use octolux::render::State;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// Runs a command that must succeed.
fn done(scratch: &Scratch, arguments: &[&str]) {
    let output = scratch.run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
}

/// Runs one that must be refused in one line.
fn refused(scratch: &Scratch, arguments: &[&str]) -> String {
    let output = scratch.run(arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert_eq!(said.trim().lines().count(), 1, "{said}");
    said
}

fn render<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "scene.toml", "--quiet", "--aovs"][..], more].concat()
}

/// Every bit of the sums.
fn sums(scratch: &Scratch, state: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    State::load(&scratch.path(state)).unwrap().film.encode(&mut bytes).unwrap();
    bytes
}

/// Every bit of the image, variance and AOVs included.
fn pixels(scratch: &Scratch, image: &str) -> Vec<(String, Vec<u32>)> {
    let bits = |plane: Vec<f32>| plane.into_iter().map(f32::to_bits).collect();
    let image = read_exr(&scratch.path(image)).unwrap();
    assert!(image.variance().is_some() && image.channel("albedo.R").is_some());
    image.channels.into_iter().map(|(name, plane)| (name, bits(plane))).collect()
}

#[test]
fn ranges_merge_into_the_whole_in_any_order() {
    let scratch = Scratch::new();
    done(&scratch, &render(&["-o", "whole.exr", "--state", "whole.state", "--spp", "331"]));
    for (name, range) in [("a.state", "0..64"), ("b.state", "64..256"), ("c.state", "256..331")] {
        // Neither width nor threads nor the machine's pace may show.
        done(&scratch, &render(&["-o", "part.exr", "--state", name, "--samples", range, "--lanes", "1"]));
    }
    let (image, bits) = (pixels(&scratch, "whole.exr"), sums(&scratch, "whole.state"));
    for order in [["a", "b", "c"], ["c", "a", "b"], ["b", "c", "a"]] {
        let [a, b, c] = order.map(|part| format!("{part}.state"));
        done(&scratch, &["merge", &a, &b, &c, "-o", "merged.exr", "--state", "merged.state"]);
        assert!(bits == sums(&scratch, "merged.state"), "{order:?}");
        assert!(image == pixels(&scratch, "merged.exr"), "{order:?}");
    }
    let tiled = render(&["-o", "part.exr", "--state", "d.state", "--samples", "64..256", "--tile", "5"]);
    done(&scratch, &tiled);
    done(&scratch, &["merge", "a.state", "d.state", "c.state", "-o", "merged.exr", "--state", "merged.state"]);
    assert!(bits == sums(&scratch, "merged.state") && image == pixels(&scratch, "merged.exr"), "another tile");
    // The parts differ from each other, or the test would pass on copies.
    assert!(sums(&scratch, "a.state") != sums(&scratch, "b.state"));
    let said = refused(&scratch, &["merge", "a.state", "b.state", "a.state", "-o", "x.exr"]);
    assert!(said.contains("a.state") && said.contains("starts at 0"), "{said}");
    assert!(!scratch.path("x.exr").exists());
}

#[test]
fn a_resumed_render_is_the_uninterrupted_one() {
    let scratch = Scratch::new();
    done(&scratch, &render(&["-o", "whole.exr", "--state", "whole.state", "--spp", "200"]));
    done(&scratch, &render(&["-o", "part.exr", "--state", "part.state", "--spp", "37"]));
    done(&scratch, &render(&["-o", "part.exr", "--resume", "part.state", "--spp", "100", "--tile", "5"]));
    let report = scratch.json(&render(&["-o", "part.exr", "--resume", "part.state", "--spp", "200", "--json", "-"]));
    assert_eq!(report["resumed_samples"], 100);
    assert_eq!(report["samples_per_pixel"], 200);
    assert_eq!(report["paths"], 24 * 16 * 100);
    assert!(sums(&scratch, "whole.state") == sums(&scratch, "part.state"));
    assert!(pixels(&scratch, "whole.exr") == pixels(&scratch, "part.exr"));
    // There is nothing left to do, and the image is written all the same.
    done(&scratch, &render(&["-o", "again.exr", "--resume", "part.state", "--spp", "64"]));
    assert!(pixels(&scratch, "whole.exr") == pixels(&scratch, "again.exr"));
}

#[test]
fn what_is_foreign_is_refused_and_named() {
    let scratch = Scratch::new();
    done(&scratch, &render(&["-o", "a.exr", "--state", "a.state", "--samples", "0..64"]));
    let resume = ["-o", "b.exr", "--resume", "a.state", "--spp", "128"];
    let with = |more: &[&str]| refused(&scratch, &[&render(&resume)[..], more].concat());
    assert!(with(&["--seed", "1"]).contains("--seed 0"));
    assert!(with(&["--size", "8x8"]).contains("--size 24x16"));
    let plain = ["render", "scene.toml", "--quiet", "-o", "b.exr", "--resume", "a.state", "--spp", "128"];
    assert!(refused(&scratch, &plain).contains("--aovs"));
    assert!(refused(&scratch, &render(&["--resume", "a.state"])).contains("--spp"), "a limit is asked for");
    assert!(refused(&scratch, &render(&["--state", "a.state"])).contains("--resume a.state"), "it is not overwritten");

    done(&scratch, &render(&["-o", "c.exr", "--state", "seed.state", "--samples", "64..128", "--seed", "1"]));
    assert!(refused(&scratch, &["merge", "a.state", "seed.state", "-o", "x.exr"]).contains("seed.state"));
    // One vertex moves by a hair.
    let floor = std::fs::read_to_string(scratch.path("floor.obj")).unwrap();
    std::fs::write(scratch.path("floor.obj"), floor.replacen("v -3 0 3", "v -3 1e-6 3", 1)).unwrap();
    assert!(with(&[]).contains("another scene"));
    std::fs::write(scratch.path("floor.obj"), &floor).unwrap();
    done(&scratch, &render(&resume));
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    std::fs::write(scratch.path("scene.toml"), scene.replace("0.6, 0.5, 0.4", "0.6, 0.5, 0.41")).unwrap();
    assert!(with(&[]).contains("another scene"));
}

/// What an earlier run claims less of, a later one that adds nothing does not claim more of; and file and report say the same.
#[test]
fn what_stopped_the_samples_stays_with_them() {
    let scratch = Scratch::new();
    done(&scratch, &render(&["-o", "a.exr", "--state", "a.state", "--error", "0.3"]));
    let claims = |more: &[&str]| {
        let report =
            scratch.json(&[&render(&["-o", "b.exr", "--resume", "a.state", "--json", "-"])[..], more].concat());
        let stopped_by = State::load(&scratch.path("a.state")).unwrap().head.stopped_by;
        (report["stopped_by"].as_str().unwrap().to_string(), format!("{stopped_by:?}").to_lowercase())
    };
    let both = |word: &str| (word.to_string(), word.to_string());
    assert_eq!(claims(&["--spp", "1"]), both("error"));
    // A fixed number in all forgets where it was halted.
    assert_eq!(claims(&["--spp", "256"]), both("samples"));
    assert_eq!(claims(&["--time", "0.3"]), both("time"));
    assert_eq!(claims(&["--error", "0.9"]), both("error"));
}

/// A state of something else is no place for a merged one.
#[test]
fn a_merged_state_takes_the_place_of_parts_alone() {
    let scratch = Scratch::new();
    done(&scratch, &render(&["-o", "a.exr", "--state", "a.state", "--samples", "0..64"]));
    done(&scratch, &render(&["-o", "a.exr", "--state", "b.state", "--samples", "64..128"]));
    done(&scratch, &render(&["-o", "a.exr", "--state", "other.state", "--samples", "0..64", "--seed", "3"]));
    let kept = std::fs::read(scratch.path("other.state")).unwrap();
    let merge = ["merge", "a.state", "b.state", "--quiet", "--state"];
    assert!(refused(&scratch, &[&merge[..], &["other.state"]].concat()).contains("none of the parts"));
    assert!(std::fs::read(scratch.path("other.state")).unwrap() == kept);
    done(&scratch, &render(&["-o", "a.exr", "--state", "c.state", "--samples", "128..192"]));
    let kept = std::fs::read(scratch.path("c.state")).unwrap();
    assert!(refused(&scratch, &[&merge[..], &["c.state"]].concat()).contains("none of the parts"));
    assert!(std::fs::read(scratch.path("c.state")).unwrap() == kept);
    // The same once more, over what it made before; and over a part.
    for place in ["whole.state", "whole.state", "./a.state"] {
        done(&scratch, &[&merge[..], &[place]].concat());
    }
}

#[test]
fn ranges_begin_at_blocks() {
    let scratch = Scratch::new();
    for range in ["1..64", "64..64", "128..64", "64", "-64..0", "0..4294967297"] {
        let argument = format!("--samples={range}");
        let output = scratch.run(&render(&["-o", "a.exr", &argument]));
        assert_eq!(output.status.code(), Some(2), "{range}: {}", text(&output.stderr));
    }
    assert!(!scratch.path("a.exr").exists());
}

/// A render without an end, saved often.
fn endless(scratch: &Scratch) -> Child {
    let arguments = ["-o", "a.exr", "--state", "a.state", "--save-every", "0.01", "--spp", "4000000000"];
    Command::new(assert_cmd::cargo::cargo_bin("octolux"))
        .current_dir(scratch.folder.path())
        .args(render(&arguments))
        .args(["--size", "160x120"])
        .spawn()
        .unwrap()
}

/// Waits until the state was written `times` times.
fn wait_for_saves(scratch: &Scratch, times: usize) {
    let (start, mut seen) = (Instant::now(), Vec::new());
    while seen.len() < times {
        assert!(start.elapsed() < Duration::from_secs(60), "no state after a minute");
        if let Ok(written) = std::fs::metadata(scratch.path("a.state")).and_then(|meta| meta.modified())
            && seen.last() != Some(&written)
        {
            seen.push(written);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Resumes `a.state` to the next whole block, and compares with a render without interruption.
fn resumes_to_the_same_bits(scratch: &Scratch) {
    let held = State::load(&scratch.path("a.state")).unwrap().film.samples();
    assert!(held > 0);
    let samples = (held + 65).to_string();
    let size = ["--size", "160x120", "--spp", &samples];
    done(scratch, &[&render(&["-o", "a.exr", "--resume", "a.state"])[..], &size].concat());
    done(scratch, &[&render(&["-o", "b.exr", "--state", "b.state"])[..], &size].concat());
    assert!(sums(scratch, "a.state") == sums(scratch, "b.state"), "{samples} samples");
    assert!(pixels(scratch, "a.exr") == pixels(scratch, "b.exr"));
}

#[test]
fn a_killed_render_leaves_its_last_state_and_image() {
    let scratch = Scratch::new();
    for saves in [1, 4] {
        let _ = std::fs::remove_file(scratch.path("a.state"));
        let mut child = endless(&scratch);
        wait_for_saves(&scratch, saves);
        child.kill().unwrap();
        assert!(!child.wait().unwrap().success());
        if saves > 1 {
            assert!(read_exr(&scratch.path("a.exr")).is_ok(), "written after an earlier save");
        }
        State::load(&scratch.path("a.state")).unwrap();
    }
    resumes_to_the_same_bits(&scratch);
}

#[test]
fn an_interrupted_render_resumes_though_its_tiles_stand_at_different_samples() {
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let scratch = Scratch::new();
        let mut child = endless(&scratch);
        wait_for_saves(&scratch, 2);
        kill(Pid::from_raw(child.id() as i32), signal).unwrap();
        assert!(child.wait().unwrap().success());
        resumes_to_the_same_bits(&scratch);
    }
}

/// A file-size limit stands in for a full disk: writing fails part of the way.
#[test]
fn a_full_disk_leaves_the_old_state_and_image() {
    let scratch = Scratch::new();
    done(&scratch, &render(&["-o", "a.exr", "--state", "a.state", "--spp", "64"]));
    let before = ["a.state", "a.exr"].map(|name| std::fs::read(scratch.path(name)).unwrap());
    let binary = assert_cmd::cargo::cargo_bin("octolux");
    let arguments = render(&["-o", "a.exr", "--resume", "a.state", "--spp", "128"]).join(" ");
    let script = format!("trap '' XFSZ; ulimit -f 4; exec {} {arguments}", binary.display());
    let output = Command::new("sh").current_dir(scratch.folder.path()).args(["-c", &script]).output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("cannot write") && said.trim().lines().count() == 1, "{said}");
    assert!(before == ["a.state", "a.exr"].map(|name| std::fs::read(scratch.path(name)).unwrap()));
    let left: Vec<_> = std::fs::read_dir(scratch.folder.path()).unwrap().flatten().map(|e| e.file_name()).collect();
    assert_eq!(left.len(), 4, "no half file is left: {left:?}");
    done(&scratch, &render(&["-o", "a.exr", "--resume", "a.state", "--spp", "128"]));
}
