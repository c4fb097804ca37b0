//! The command line as a user meets it: files written, reports, exit codes, one-line errors.

mod adaptive;
mod bad_input;
mod budgets;
mod check;
mod converge;
mod errors;
mod estimate;
mod info;
mod ladder;
mod modes;
mod path_reuse;
mod render;
mod replay;
mod state;
mod streams;
mod usage;

use std::path::{Path, PathBuf};
use std::process::Output;

/// A scratch folder with a small scene in it.
pub struct Scratch {
    pub folder: tempfile::TempDir,
}

/// A lit floor with a metal ball and a lamp: three materials, a sphere, an environment.
const SCENE: &str = r#"
[camera]
position = [0, 1, 4]
look_at = [0, 0.5, 0]
up = [0, 1, 0]
vfov = 40

[film]
width = 24
height = 16

[environment]
radiance = [0.2, 0.3, 0.5]

[[mesh]]
file = "floor.obj"

[[sphere]]
center = [0, 0.5, 0]
radius = 0.5
material = "metal"

[[sphere]]
center = [0, 3, 0]
radius = 0.3
material = "lamp"

[materials.floor]
type = "diffuse"
reflectance = [0.6, 0.5, 0.4]

[materials.metal]
type = "conductor"
alpha = 0.2
eta = [0.2, 0.9, 1.1]
k = [3.9, 2.4, 2.1]

[materials.lamp]
type = "diffuse"
reflectance = [0, 0, 0]
emission = [20, 18, 15]
"#;

const FLOOR: &str = "v -3 0 3\nv 3 0 3\nv 3 0 -3\nv -3 0 -3\nusemtl floor\nf 1 2 3\nf 1 3 4\n";

impl Scratch {
    pub fn new() -> Self {
        let scratch = Scratch { folder: tempfile::tempdir().unwrap() };
        std::fs::write(scratch.path("scene.toml"), SCENE).unwrap();
        std::fs::write(scratch.path("floor.obj"), FLOOR).unwrap();
        scratch
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs octolux in the scratch folder.
    pub fn run(&self, arguments: &[&str]) -> Output {
        octolux(self.folder.path(), arguments)
    }

    /// Runs it, and interrupts it after a while.
    pub fn interrupted(&self, arguments: &[&str]) -> Output {
        let child = std::process::Command::new(assert_cmd::cargo::cargo_bin("octolux"))
            .current_dir(self.folder.path())
            .args(arguments)
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(1500));
        nix::sys::signal::kill(nix::unistd::Pid::from_raw(child.id() as i32), nix::sys::signal::Signal::SIGINT)
            .unwrap();
        child.wait_with_output().unwrap()
    }

    /// Runs it and parses what `--json -` printed.
    pub fn json(&self, arguments: &[&str]) -> serde_json::Value {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("standard output is JSON and nothing else")
    }
}

pub fn octolux(folder: &Path, arguments: &[&str]) -> Output {
    assert_cmd::Command::cargo_bin("octolux").unwrap().current_dir(folder).args(arguments).output().unwrap()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
