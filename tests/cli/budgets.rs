//! `--spp`, `--time`, `--error`, Ctrl-C: the first to be reached stops, and the report says which.

use super::Scratch;
use octolux::render::StoppedBy;
use octolux::render::budget::{Budget, Pacer};

/// Runs a pacer against passes that take `seconds_per_sample`, and returns the pass sizes and what stopped it.
fn simulate(budget: Budget, seconds_per_sample: f64) -> (Vec<u64>, StoppedBy, f64) {
    simulate_from(0, budget, seconds_per_sample, 0.0)
}

/// The same of a render that holds `done` samples, and whose image takes `output` seconds to write.
fn simulate_from(mut done: u64, budget: Budget, seconds_per_sample: f64, output: f64) -> (Vec<u64>, StoppedBy, f64) {
    let mut pacer = Pacer::new(budget);
    let (mut now, mut passes) = (0.0, Vec::new());
    loop {
        match pacer.next(done, now, output) {
            Err(reason) => return (passes, reason, now),
            Ok(samples) => {
                let seconds = samples as f64 * seconds_per_sample;
                now += seconds;
                done += samples;
                passes.push(samples);
                pacer.learn(samples, seconds, done);
            }
        }
    }
}

#[test]
fn passes_after_calibration_are_equal_and_at_most_five_percent() {
    for seconds_per_sample in [1e-4, 3e-3, 0.02, 0.3] {
        let limit = 10.0;
        let (passes, reason, end) = simulate(Budget { seconds: Some(limit), ..Budget::default() }, seconds_per_sample);
        assert_eq!(reason, StoppedBy::Time);
        let most = (0.05 * limit / seconds_per_sample).max(1.0);
        assert!(passes.iter().all(|&p| p as f64 <= most), "{passes:?}");
        let settled = &passes[passes.len() / 2..];
        assert!(settled.iter().all(|p| p == settled.last().unwrap()), "{passes:?}");
        assert!(end <= limit && end >= 0.95 * limit, "used {end} of {limit} at {seconds_per_sample}");
    }
}

#[test]
fn no_pass_crosses_a_block_of_64_once_sizes_settle() {
    let (passes, _, _) = simulate(Budget { samples: Some(1000), ..Budget::default() }, 1e-3);
    let mut done = 0;
    for &p in &passes[..passes.len() - 1] {
        assert_eq!(done / 64, (done + p - 1) / 64, "{passes:?}");
        done += p;
    }
    assert_eq!(passes.iter().sum::<u64>(), 1000);
}

#[test]
fn a_sample_longer_than_a_twentieth_may_end_late_by_less_than_itself() {
    for seconds_per_sample in [0.06, 0.11, 0.155, 0.19, 0.24] {
        let budget = Budget { seconds: Some(1.0), ..Budget::default() };
        let (passes, _, rendered) = simulate_from(0, budget, seconds_per_sample, 0.2);
        let end = rendered + 0.2;
        assert!(rendered <= 1.0 && end >= 0.95 && end <= 1.0 + seconds_per_sample, "{seconds_per_sample}: {end}");
        assert!(passes.iter().all(|&p| p == 1));
    }
}

#[test]
fn a_resumed_render_comes_back_to_blocks_and_powers_of_two() {
    let budget = Budget { samples: Some(5000), ..Budget::default() };
    for held in [1, 37, 64, 100, 4096 + 17] {
        let (passes, reason, _) = simulate_from(held, budget, 1e-4, 0.0);
        assert_eq!(reason, StoppedBy::Samples);
        let ends: Vec<u64> = passes.iter().scan(held, |done, p| Some(std::mem::replace(done, *done + p) + p)).collect();
        for (end, pass) in ends.iter().zip(&passes) {
            assert_eq!((end - pass) / 64, (end - 1) / 64, "{held}: {passes:?}");
        }
        let powers = (0..13).map(|i| 1 << i).filter(|&n: &u64| n > held);
        powers.for_each(|n| assert!(ends.contains(&n), "{held}: {n} in {ends:?}"));
        assert!(passes.len() < 110, "{held}: it climbs to whole blocks: {passes:?}");
    }
}

#[test]
fn time_stops_a_render_near_its_limit() {
    let scratch = Scratch::new();
    let report = scratch.json(&["render", "scene.toml", "-o", "a.exr", "--time", "0.5", "--json", "-", "--quiet"]);
    assert_eq!(report["stopped_by"], "time");
    let wall = report["wall_seconds"].as_f64().unwrap();
    // Generous: other tests share the cores. The figures that count are measured, not tested.
    assert!((0.3..2.0).contains(&wall), "{wall}");
}

/// Reading the scene may take all the time there is: the image is then late, but it is there.
#[test]
fn time_that_is_over_before_the_first_sample_leaves_one_sample_a_pixel() {
    let budget = Budget { seconds: Some(1.0), ..Budget::default() };
    assert_eq!(Pacer::new(budget).next(0, 7.0, 0.2), Ok(1));
    assert_eq!(Pacer::paced(budget, 1e-3).next(0, 7.0, 0.2), Ok(1));
    assert_eq!(Pacer::new(budget).next(5, 7.0, 0.2), Err(StoppedBy::Time));
    let scratch = Scratch::new();
    for more in [&[][..], &["--adaptive"], &["--unbiased", "--error", "0.1"]] {
        let arguments = ["render", "scene.toml", "-o", "a.exr", "--time", "1e-9", "--json", "-", "--quiet"];
        let report = scratch.json(&[&arguments[..], more].concat());
        assert_eq!((&report["stopped_by"], &report["samples_per_pixel"]), (&"time".into(), &1.into()), "{more:?}");
        assert!(scratch.path("a.exr").exists());
        std::fs::remove_file(scratch.path("a.exr")).unwrap();
    }
}

#[test]
fn error_stops_at_a_doubling_and_says_that_it_is_biased() {
    let scratch = Scratch::new();
    let run = |target: &str, more: &[&str]| {
        let arguments =
            [&["render", "scene.toml", "-o", "a.exr", "--json", "-", "--quiet", "--error", target], more].concat();
        scratch.json(&arguments)
    };
    let report = run("0.03", &[]);
    assert_eq!(report["stopped_by"], "error");
    assert!(report["claim"].as_str().unwrap().contains("sequentially stopped, bias O(1/n)"));
    assert!(report["relative_error"].as_f64().unwrap() <= 0.03);
    let samples = report["samples_per_pixel"].as_u64().unwrap();
    assert!(samples >= 64 && samples.is_power_of_two(), "{samples}");

    let report = run("0.03", &["--unbiased"]);
    assert_eq!(report["stopped_by"], "samples");
    let error = report["relative_error"].as_f64().unwrap();
    // The count came from a pilot of 64 samples, whose variance estimate is itself uncertain by some percent.
    assert!(error < 0.03 * 1.3, "{error}");

    assert_eq!(run("1e-9", &["--spp", "128"])["stopped_by"], "samples");
}

#[cfg(unix)]
#[test]
fn ctrl_c_writes_what_there_is_and_succeeds() {
    let scratch = Scratch::new();
    let binary = assert_cmd::cargo::cargo_bin("octolux");
    let mut child = std::process::Command::new(binary)
        .current_dir(scratch.folder.path())
        .args([
            "render",
            "scene.toml",
            "-o",
            "a.exr",
            "--spp",
            "4000000000",
            "--json",
            "a.json",
            "--quiet",
            "--size",
            "256x256",
        ])
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(child.id() as i32), nix::sys::signal::Signal::SIGINT).unwrap();
    let asked = std::time::Instant::now();
    assert!(child.wait().unwrap().success());
    let answered = asked.elapsed().as_secs_f64();
    assert!(answered < 5.0, "one second is the aim on a quiet machine; it took {answered}");
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(scratch.path("a.json")).unwrap()).unwrap();
    assert_eq!(report["stopped_by"], "interrupt");
    assert!(octolux::film::read_exr(&scratch.path("a.exr")).is_ok());
}

/// Each sample of this scene takes a thousand rays: the first pass is not over when Ctrl-C comes, and most tiles are black.
#[test]
fn ctrl_c_in_the_first_pass_leaves_no_black_tiles() {
    let scratch = Scratch::new();
    let scene = std::fs::read_to_string(scratch.path("scene.toml")).unwrap();
    let slow = format!("{scene}\n[integrator]\nkind = \"gather\"\nsamples = 1024\n");
    std::fs::write(scratch.path("slow.toml"), slow).unwrap();
    std::fs::write(scratch.path("a.exr"), "an image of yesterday").unwrap();
    let output = scratch.interrupted(&["render", "slow.toml", "-o", "a.exr", "--size", "2048x2048", "--quiet"]);
    let said = super::text(&output.stderr);
    // Whoever waits for an image must see that there is none.
    assert!(said.contains("nothing was written") && output.status.code() == Some(2), "{said}");
    assert_eq!(std::fs::read(scratch.path("a.exr")).unwrap(), b"an image of yesterday");
}

/// Scenes may take minutes to read and trees to be built: here one takes for ever.
#[test]
fn ctrl_c_while_a_scene_is_read_ends_at_once() {
    let scratch = Scratch::new();
    assert!(std::process::Command::new("mkfifo").arg(scratch.path("endless.toml")).status().unwrap().success());
    std::fs::write(scratch.path("a.exr"), "an image of yesterday").unwrap();
    for command in [&["render", "endless.toml", "-o", "a.exr"][..], &["converge", "endless.toml", "-o", "out"]] {
        let output = scratch.interrupted(command);
        let said = super::text(&output.stderr);
        assert!(said.contains("nothing was written") && output.status.code() == Some(2), "{said}");
    }
    assert_eq!(std::fs::read(scratch.path("a.exr")).unwrap(), b"an image of yesterday");
}

/// The pilot of a fixed number takes a part of the time alone, and rates are of the seconds that made the image.
#[test]
fn a_pilot_leaves_time_for_the_image() {
    let scratch = Scratch::new();
    let report = scratch.json(&[
        "render",
        "scene.toml",
        "--error",
        "0.0001",
        "--unbiased",
        "--time",
        "2",
        "-o",
        "a.exr",
        "--json",
        "-",
        "--quiet",
    ]);
    let seconds = |name: &str| report[name].as_f64().unwrap();
    let (all, pilot) = (seconds("render_seconds"), seconds("discarded_seconds"));
    assert!(pilot > 0.0 && pilot < 0.5 * all, "{pilot} of {all}");
    let rate = seconds("paths") / (all - pilot);
    assert!((seconds("paths_per_second") / rate - 1.0).abs() < 1e-6, "{report}");
}
