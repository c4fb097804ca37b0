//! What an OBJ file holds besides its numbers: learnt line by line while it is read.

use super::error::SceneError;
use super::notes::Notes;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// A `usemtl` name.
pub(super) struct MaterialUse {
    pub name: String,
    /// The line that named it first.
    pub line: usize,
    /// Does any face wear it?
    pub worn: bool,
}

/// Faces of the same number of corners, one after the other.
pub(super) struct PolygonRun {
    /// The first triangle's index in the file.
    pub first: usize,
    pub faces: usize,
    pub corners: usize,
}

/// What was learnt on the way.
#[derive(Default)]
pub(super) struct Outline {
    /// What the `mtllib` lines name.
    pub libraries: Vec<String>,
    /// In order of first use: tobj's material index.
    pub materials: Vec<MaterialUse>,
    /// Do faces come before the first `usemtl`?
    pub has_bare_faces: bool,
    /// Runs of triangles (in file order) without a normal at every corner.
    pub flat: Vec<Range<usize>>,
    /// Faces of four corners and more, in order.
    pub polygons: Vec<PolygonRun>,
    pub triangles: usize,
    pub positions: usize,
    pub normals: usize,
    pub texcoords: usize,
    /// The largest index of positions, texture coordinates and normals (from 1) that any face named, with its line.
    pub largest: [(usize, usize); 3],
    /// Keys that are not honoured: the first line of each, and why.
    passed_over: BTreeMap<String, (usize, &'static str)>,
    pub error: Option<SceneError>,
}

/// The kinds of index in a face corner, in the order they are written.
pub(super) const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl Outline {
    /// Notes a key that is not honoured, and why.
    pub fn pass_over(&mut self, key: &str, line: usize, why: &'static str) {
        if !self.passed_over.contains_key(key) {
            self.passed_over.insert(key.to_owned(), (line, why));
        }
    }

    /// Warns of what was passed over.
    pub fn warn(&self, file: &Path, notes: &mut Notes) {
        let mut passed_over: Vec<_> = self.passed_over.iter().collect();
        passed_over.sort_by_key(|(_, (line, _))| *line);
        passed_over.into_iter().for_each(|(key, (line, why))| notes.not_honoured(file, *line, key, why));
    }

    /// The error of an index beyond what has been defined, to be asked where a group of faces ends.
    pub fn beyond_the_end(&self, file: &Path) -> Option<SceneError> {
        let held = [self.positions, self.texcoords, self.normals];
        (0..3).find(|&kind| self.largest[kind].0 > held[kind]).map(|kind| {
            let ((index, line), what, held) = (self.largest[kind], KINDS[kind], held[kind]);
            SceneError::at(
                file,
                line,
                format!("{what} {index} does not exist: the file defines {held} up to where it is needed"),
                "mend the index, or define what it means before the face",
            )
        })
    }
}
