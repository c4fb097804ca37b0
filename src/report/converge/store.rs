//! The study's folder: finished cells and their images, kept so that a study can be broken off and taken up again.

use super::cell::{Budget, Cell, CellKey};
use super::run::Variant;
use super::write::NAMES;
use crate::film::FilmError;
use crate::film::beside::{check_writable, write_beside};
use crate::film::checksum::Checksum;
use crate::process;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Raised when the form of `cells.json` changes.
const FORMAT: u32 = 2;

#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error("{path}: cannot make the folder: {source}; choose another", path = .path.display())]
    Folder { path: PathBuf, source: std::io::Error },
    #[error("{path}: cannot read: {why}; delete it to start anew", path = .path.display())]
    Read { path: PathBuf, why: String },
    #[error("{path}: a study is here already; go on with it by --resume, or choose another folder", path = .path.display())]
    Occupied { path: PathBuf },
    #[error("{path}: is there already, and not made by a study; name another folder", path = .path.display())]
    Foreign { path: PathBuf },
    #[error("{path}: its cells were made {why}; choose another folder", path = .path.display())]
    Other { path: PathBuf, why: String },
}

/// What all cells of a folder have in common. Cells of different builds would mix their times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    pub format: u32,
    /// Of the program's file.
    pub build: String,
    /// Processor and cores.
    pub machine: String,
    pub width: u32,
    pub height: u32,
    /// Of each variant's scene as it was loaded.
    pub scenes: Vec<(String, String)>,
    /// Samples a pixel that a budget in seconds became, by variant.
    pub paced: Vec<(String, Budget, u64)>,
}

#[derive(Serialize, Deserialize)]
struct File {
    #[serde(flatten)]
    origin: Origin,
    cells: Vec<Cell>,
}

pub struct Store {
    folder: PathBuf,
    pub origin: Origin,
    pub cells: Vec<Cell>,
}

impl Store {
    /// Opens a folder, made if it is not there. With `resume` its cells are taken over.
    ///
    /// # Errors
    /// The folder cannot be made or holds another study.
    pub fn open(folder: &Path, variants: &[Variant], resume: bool) -> Result<Self, StoreError> {
        let film = variants.first().map_or((0, 0), |v| (v.world.film.width, v.world.film.height));
        let scenes = variants.iter().map(|v| (v.arguments.clone(), v.fingerprint.clone())).collect();
        let origin = Origin {
            format: FORMAT,
            build: build_id(),
            machine: machine(),
            width: film.0,
            height: film.1,
            scenes,
            paced: Vec::new(),
        };
        let mut store = Store { folder: folder.to_owned(), origin, cells: Vec::new() };
        let path = store.file();
        match std::fs::read_to_string(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => return Err(StoreError::Read { path, why: error.to_string() }),
            Ok(_) if !resume => return Err(StoreError::Occupied { path }),
            Ok(text) => {
                let read = |e: serde_json::Error| StoreError::Read { path: path.clone(), why: e.to_string() };
                store.take_over(serde_json::from_str(&text).map_err(read)?)?;
            }
        }
        let images = folder.join("cells");
        std::fs::create_dir_all(&images).map_err(|source| StoreError::Folder { path: images, source })?;
        // What the study ends in, before it begins.
        NAMES.iter().try_for_each(|name| check_writable(&folder.join(name)))?;
        check_writable(&store.file())?;
        Ok(store)
    }

    /// Takes the cells of an earlier session whose images are still there.
    fn take_over(&mut self, earlier: File) -> Result<(), StoreError> {
        let other = |why: &str| Err(StoreError::Other { path: self.file(), why: why.to_owned() });
        if earlier.origin.format != FORMAT || earlier.origin.build != self.origin.build {
            return other("by another build of octolux");
        }
        if earlier.origin.machine != self.origin.machine {
            return other("on another machine, or with another number of cores");
        }
        if (earlier.origin.width, earlier.origin.height) != (self.origin.width, self.origin.height) {
            return other("at another image size");
        }
        let differs = |(arguments, fingerprint): &(String, String)| {
            self.origin.scenes.iter().any(|(known, now)| known == arguments && now != fingerprint)
        };
        if earlier.origin.scenes.iter().any(differs) {
            return other("from another state of the scene");
        }
        let kept = earlier.origin.scenes.into_iter().filter(|(known, _)| self.fingerprint_of(known).is_none());
        let kept: Vec<_> = kept.collect();
        self.origin.scenes.extend(kept);
        self.origin.paced = earlier.origin.paced;
        self.cells = earlier.cells.into_iter().filter(|cell| self.folder.join(&cell.image).is_file()).collect();
        Ok(())
    }

    fn fingerprint_of(&self, arguments: &str) -> Option<&str> {
        self.origin.scenes.iter().find(|(known, _)| known == arguments).map(|(_, fingerprint)| fingerprint.as_str())
    }

    fn file(&self) -> PathBuf {
        self.folder.join("cells.json")
    }

    pub fn path_of(&self, cell: &Cell) -> PathBuf {
        self.folder.join(&cell.image)
    }

    pub fn find(&self, key: &CellKey) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.key == *key)
    }

    /// Adds a cell and writes the list.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&mut self, cell: Cell) -> Result<(), StoreError> {
        self.cells.push(cell);
        self.write()
    }

    pub fn write(&self) -> Result<(), StoreError> {
        let file = File { origin: self.origin.clone(), cells: self.cells.clone() };
        Ok(write_beside(&self.file(), |out| serde_json::to_writer_pretty(out, &file))?)
    }
}

/// A folder that holds no study, be it one whose cells were deleted, has none of the files of these names either: they are
/// somebody else's.
///
/// # Errors
/// Which one is there.
pub fn check_free(folder: &Path, names: impl Iterator<Item = String>) -> Result<(), StoreError> {
    let field = |file: &str, name: &str| {
        let json: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.join(file)).ok()?).ok()?;
        json.get(name).cloned()
    };
    let reported = || field("report.json", "kind").is_some_and(|kind| kind == "converge");
    if folder.join("cells.json").exists() || reported() || field("reference.json", "fingerprint").is_some() {
        return Ok(());
    }
    match names.map(|name| folder.join(name)).find(|path| path.exists()) {
        Some(path) => Err(StoreError::Foreign { path }),
        None => Ok(()),
    }
}

fn machine() -> String {
    let cpu = process::cpu_model().unwrap_or_default();
    format!("{cpu}, {} cores", process::allowed_cores().len())
}

/// The program's file, hashed; empty where it cannot be read.
pub fn build_id() -> String {
    let bytes = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
    checksum(&bytes)
}

/// In hexadecimal.
pub fn checksum(bytes: &[u8]) -> String {
    let mut sum = Checksum::default();
    sum.update(bytes);
    format!("{:016x}", sum.value())
}
