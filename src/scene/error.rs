//! What is wrong with an input file, said in one line.

use std::path::{Path, PathBuf};

/// An input that cannot be rendered. Displayed as the one line `FILE:LINE: what is wrong; what to do`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", one_line(file, *line, message, mend))]
pub struct SceneError {
    /// The path as it was reached from the path the user gave.
    pub file: PathBuf,
    /// Counted from 1; `None` where the whole file is meant.
    pub line: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub mend: String,
}

impl SceneError {
    /// An error at a line of a file.
    pub fn at(file: &Path, line: usize, message: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { file: file.to_path_buf(), line: Some(line), message: message.into(), mend: mend.into() }
    }

    /// An error that concerns a file as a whole.
    pub fn whole(file: &Path, message: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { file: file.to_path_buf(), line: None, message: message.into(), mend: mend.into() }
    }

    /// A file that could not be read.
    pub(super) fn unreadable(file: &Path, error: &std::io::Error) -> Self {
        Self::whole(file, format!("cannot be read: {error}"), "check the path and its permissions")
    }
}

/// Characters at the beginning and at the end of what a line repeats of a file.
const KEPT: [usize; 2] = [400, 100];

/// Names in files may hold control characters, or be a million characters long; they must not break the promise of a single line.
fn one_line(file: &Path, line: Option<usize>, message: &str, mend: &str) -> String {
    let place = line.map(|line| format!(":{line}")).unwrap_or_default();
    let (message, mend) = (shortened(message), shortened(mend));
    format!("{}{place}: {message}; {mend}", file.display()).replace(|c: char| c.is_control(), " ")
}

/// Without its middle, where it is long.
fn shortened(text: &str) -> String {
    let [head, tail] = KEPT;
    let length = text.chars().count();
    if length <= head + tail {
        return text.to_owned();
    }
    let start: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(length - tail).collect();
    format!("{start} … {end}")
}
