//! What can go wrong with films and their files, one line each.

use std::path::{Path, PathBuf};

/// An image could not be written or read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // fields: as the variant says
pub enum FilmError {
    #[error("{}: cannot write: {why}", path.display())]
    Write { path: PathBuf, why: String },
    #[error("{}: cannot read: {why}", path.display())]
    Read { path: PathBuf, why: String },
}

impl FilmError {
    pub(crate) fn write(path: &Path, why: impl ToString) -> Self {
        Self::Write { path: path.to_owned(), why: with_mend(why, "make room, or write elsewhere") }
    }

    pub(crate) fn read(path: &Path, why: impl ToString) -> Self {
        Self::Read { path: path.to_owned(), why: with_mend(why, "name an EXR image that can be read") }
    }
}

/// Two films, or two tiles, do not fit together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs)] // fields: as the variant says
pub enum MergeError {
    #[error("the films differ in size or channels")]
    Shape,
    #[error("its tiles are of another size and stand at different samples: resume it to the end of a pass first")]
    Tiles,
    #[error("both hold the block of samples that starts at {first_sample}; merge parts of different samples")]
    Overlap { first_sample: u64 },
    #[error(
        "one of the parts as far as this one ends inside a block of 64 and is not the last: the block of sample {first_sample} is unfinished"
    )]
    UnfinishedBlock { first_sample: u64 },
}

/// In one line. What says a mend of its own (after `; `) is given no other.
fn with_mend(why: impl ToString, mend: &str) -> String {
    let why = why.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    if why.contains("; ") { why } else { format!("{why}; {mend}") }
}
