//! Writes the procedural parts of `scenes/`: the plates of veach, the sky and the ring of sun-sky, the courtyard, the
//! sky of course.
//!
//! `cargo run --release --example make_scenes [FOLDER]`; the folder is `scenes` unless given. The files are committed:
//! this is needed only to change them, and running it again gives the same bytes.

mod courtyard;
mod mesh;
mod plates;
mod ring;
mod sky;

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| default.to_string()));
    std::fs::create_dir_all(folder.join("veach"))?;
    std::fs::create_dir_all(folder.join("sun-sky"))?;
    std::fs::write(folder.join("veach/plates.obj"), plates::obj())?;
    std::fs::write(folder.join("sun-sky/ring.obj"), ring::obj())?;
    std::fs::create_dir_all(folder.join("course"))?;
    sky::write_without_sun(&folder.join("course/sky.exr"))?;
    sky::write(&folder.join("sun-sky/sky.exr"))?;
    std::fs::create_dir_all(folder.join("courtyard"))?;
    std::fs::write(folder.join("courtyard/ball.obj"), courtyard::ball())?;
    courtyard::write(&folder.join("courtyard"))
}
