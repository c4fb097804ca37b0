//! Scene files and models: what loads, what it becomes, and what is said of those that do not.

mod bad_images;
mod bad_obj;
mod bad_textures;
mod bad_toml;
mod bare_models;
mod meshes;
mod mutations;
mod references;
mod warnings;

use octolux::scene::{Scene, SceneError, load};
use std::path::{Path, PathBuf};

/// The reference material beside the repository, where there is any.
fn shared() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let found =
        ["..", "../..", "../../.."].map(|up| root.join(up).join("shared")).into_iter().find(|path| path.is_dir());
    if found.is_none() {
        println!("skipped: no folder `shared` beside the repository");
    }
    found
}

/// A folder of files that goes with the value.
struct Files(tempfile::TempDir);

impl Files {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a scratch folder");
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).expect("a scratch file");
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn load(&self, name: &str) -> Result<Scene, SceneError> {
        load(&self.path(name))
    }

    fn error(&self, name: &str) -> SceneError {
        self.load(name).expect_err("this scene must not load")
    }
}

/// A scene file that loads, to add to and to break.
const CAMERA: &str = "[camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\n";

/// One counter-clockwise triangle seen from +z.
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
