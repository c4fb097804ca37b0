//! Writing a file so that a reader sees the old one or the whole new one, never a half.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::FilmError;

/// Runs `write` on a new file in the target's folder, then renames it to `path`. On an error the target is as it was
/// and the new file is removed. A link is followed; something that is no regular file (`/dev/null`, a pipe) is written
/// to directly, since renaming would replace it. A file that nobody may write to stays, which renaming would not heed either.
///
/// # Errors
/// The folder or target cannot be written, or `write` failed; the message names `path`.
pub fn write_beside<E: ToString>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), FilmError> {
    replace(path, false, write)
}

/// The same, and on the disk itself before the old file goes: a power cut, too, leaves the old or the new one.
///
/// # Errors
/// As [`write_beside`].
pub fn write_durably<E: ToString>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), FilmError> {
    replace(path, true, write)
}

/// Of a file that is kept from being written to.
const READ_ONLY: &str = "the file there is read-only; name another, or allow writing to it";

/// Can a file be written there? Known by making and removing one beside it: better before hours of work than after them.
///
/// # Errors
/// What a write would end with.
pub fn check_writable(path: &Path) -> Result<(), FilmError> {
    let target = end_of_links(path);
    // By the name as it is: what /dev/stdout leads to may have a name in no folder.
    let beside = match fs::metadata(path) {
        // A device or pipe: to open it may have effects of its own.
        Ok(meta) if !meta.is_file() => return Ok(()),
        Ok(meta) if meta.permissions().readonly() => return Err(FilmError::write(path, READ_ONLY)),
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(FilmError::write(path, error)),
        _ => create_beside(&target).map_err(|error| FilmError::write(path, error))?.0,
    };
    fs::remove_file(beside).map_err(|error| FilmError::write(path, error))
}

/// Is there something that can only be read or written from the first byte to the last: a pipe, a terminal? (Or a folder.) Opening a
/// pipe waits for somebody at its other end, and reading a device may never end.
pub(crate) fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|meta| !meta.is_file())
}

/// Where a link leads, be there a file or not.
pub(crate) fn end_of_links(path: &Path) -> PathBuf {
    // As many as Linux follows.
    const MOST_LINKS: usize = 40;
    let mut end = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&end) else { break };
        end = end.parent().unwrap_or(Path::new("")).join(next);
    }
    end
}

fn replace<E: ToString>(
    path: &Path,
    durable: bool,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), FilmError> {
    let existing = fs::metadata(path).ok();
    if existing.as_ref().is_some_and(fs::Metadata::is_dir) {
        return Err(FilmError::write(path, "it is a folder; name a file"));
    }
    if existing.as_ref().is_some_and(|meta| !meta.is_file()) {
        let file = OpenOptions::new().write(true).open(path).map_err(|error| FilmError::write(path, error))?;
        return run(path, file, write).map(drop);
    }
    if existing.as_ref().is_some_and(|meta| meta.permissions().readonly()) {
        return Err(FilmError::write(path, READ_ONLY));
    }
    // A link keeps pointing where it did: its target is what is replaced.
    let target = end_of_links(path);
    let (beside, file) = create_beside(&target).map_err(|error| FilmError::write(path, error))?;
    let written = run(path, file, write).and_then(|file| {
        if durable {
            file.sync_all().map_err(|error| FilmError::write(path, error))?;
        }
        if let Some(meta) = existing {
            fs::set_permissions(&beside, meta.permissions()).map_err(|error| FilmError::write(path, error))?;
        }
        fs::rename(&beside, &target).map_err(|error| FilmError::write(path, error))?;
        // The name is in the folder, which not every system lets one open and sync: then its own habits serve.
        let folder = target.parent().filter(|_| durable).and_then(|folder| File::open(folder).ok());
        folder.map_or(Ok(()), |folder| folder.sync_all().or(Ok(())))
    });
    if written.is_err() {
        // The first error is the one worth reporting.
        let _ = fs::remove_file(&beside);
    }
    written
}

fn run<E: ToString>(
    path: &Path,
    file: File,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<File, FilmError> {
    let mut buffered = BufWriter::with_capacity(1 << 16, file);
    write(&mut buffered).map_err(|error| FilmError::write(path, error))?;
    buffered.into_inner().map_err(|error| FilmError::write(path, error.error()))
}

/// Characters of a file's name in that of the one beside it: 200 bytes at most.
const NAME_KEPT: usize = 50;

/// A new file `.NAME.PID-COUNT.part`: unique among threads and processes, and recognisable if one is ever left.
fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = target.file_name().ok_or_else(|| io::Error::other("not a file name"))?;
    loop {
        let mut beside = OsString::from(".");
        // A name may be as long as its system lets one be: then there is no room for more.
        beside.push(name.to_string_lossy().chars().take(NAME_KEPT).collect::<String>());
        beside.push(format!(".{}-{}.part", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
        let beside = target.with_file_name(beside);
        match OpenOptions::new().write(true).create_new(true).open(&beside) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            result => return result.map(|file| (beside, file)),
        }
    }
}
