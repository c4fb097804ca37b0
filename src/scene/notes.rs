//! What a load has to say besides its result.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Warnings (at most one a key, sent to [`log::warn!`]) and assumptions (kept for [`Scene::assumptions`]).
///
/// And the files that were read, for [`Scene::files`].
///
/// [`Scene::assumptions`]: super::Scene::assumptions
/// [`Scene::files`]: super::Scene::files
#[derive(Default)]
pub(super) struct Notes {
    warned: BTreeSet<String>,
    pub assumptions: Vec<String>,
    pub files: Vec<PathBuf>,
}

impl Notes {
    /// Warns of a key that was read but is not honoured; says nothing on its later occurrences.
    pub fn not_honoured(&mut self, file: &Path, line: usize, key: &str, why: &str) {
        if self.warned.insert(key.to_owned()) {
            log::warn!("{}:{line}: `{key}` is not honoured: {why}", file.display());
        }
    }

    /// Records an assumption once.
    pub fn assume(&mut self, sentence: String) {
        if !self.assumptions.contains(&sentence) {
            self.assumptions.push(sentence);
        }
    }
}
