//! What every target does with a scene that may load.

use octolux::kernel::{Prepare, World};
use octolux::plan::{Force, Plan};
use octolux::scene::load;
use std::path::Path;
use std::sync::OnceLock;

/// A folder of this process, with what scene files refer to.
pub fn folder() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    FOLDER
        .get_or_init(|| {
            let folder = tempfile::tempdir().expect("a scratch folder");
            std::fs::write(folder.path().join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a scratch file");
            folder
        })
        .path()
}

/// A scene that loads can be prepared; one that does not is refused in one line.
pub fn load_and_prepare(path: &Path) {
    match load(path) {
        Ok(scene) => {
            let plan = Plan::new(&scene, Force::default(), false);
            let _ = World::new(&scene, plan, Prepare::default());
        }
        Err(error) => {
            let shown = error.to_string();
            assert!(!shown.contains(char::is_control), "{shown:?}");
            assert!(error.line != Some(0), "{shown:?}");
        }
    }
}
