//! What tobj is given to read: an OBJ file line by line, checked, and in a canonical form.
//!
//! tobj names no line in its errors, accepts NaN, panics on some bad indices, and invents normals and materials where
//! a face has none. So each line is judged here first, where its number is known, and only what octolux renders goes
//! on: `v`, `vn`, `f`, and a number in place of each material's name. Judging takes as long as tobj does, so it has a thread of its own.

use super::domain::FINITE;
use super::error::SceneError;
use super::obj_outline::{MaterialUse, Outline, PolygonRun};
use super::obj_words::{MOST, Wrong, broken, fail, indices, is_plain, number, words};
use super::statements::Statements;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::{BufRead, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender};

/// Bytes that are sent at once, about.
const CHUNK: usize = 1 << 15;

/// Makes canonical lines of an OBJ file's, some at a time.
pub(super) struct Feed<'a> {
    file: &'a Path,
    numbers: HashMap<String, usize>,
    current: Option<usize>,
    smoothing: bool,
    /// Where the statement at hand starts.
    line: usize,
    ready: String,
}

impl<'a> Feed<'a> {
    /// Of a file of that name.
    pub fn new(file: &'a Path) -> Self {
        Self { file, numbers: HashMap::new(), current: None, smoothing: false, line: 0, ready: String::new() }
    }

    /// Sends what the file holds to a reader on another thread, up to its end or an error, or as far as it listens.
    pub fn send(mut self, source: impl BufRead, lines: &SyncSender<std::io::Result<String>>) -> Outline {
        let mut outline = Outline::default();
        let mut statements = Statements::new(source);
        loop {
            let chunk = self.refill(&mut statements, &mut outline).map(|()| std::mem::take(&mut self.ready));
            let last = chunk.as_ref().map_or(true, String::is_empty);
            if lines.send(chunk).is_err() || last {
                return outline;
            }
        }
    }

    /// Puts the next canonical lines into `ready`; leaves it empty at the end of the file and after an error.
    fn refill(&mut self, source: &mut Statements<impl BufRead>, outline: &mut Outline) -> std::io::Result<()> {
        self.ready.reserve(CHUNK + 256);
        while self.ready.len() < CHUNK && outline.error.is_none() {
            let Some((line, text)) = source.read()? else { break };
            self.line = line;
            if let Err((message, mend)) = self.judge(&text, outline) {
                outline.error = Some(SceneError::at(self.file, self.line, message, mend));
            }
            if outline.error.is_some() {
                self.ready.clear();
            }
        }
        Ok(())
    }

    fn judge(&mut self, text: &str, outline: &mut Outline) -> Result<(), Wrong> {
        let text = text.trim();
        let (key, rest) = text.split_at(text.bytes().position(|b| b.is_ascii_whitespace()).unwrap_or(text.len()));
        match key {
            "" => Ok(()),
            comment if comment.starts_with('#') => Ok(()),
            "v" => self.position(rest, outline),
            "vn" => self.normal(rest, outline),
            "vt" => texcoord(rest, outline),
            "f" => self.face(rest, outline),
            "usemtl" => self.material(rest.trim(), outline),
            "mtllib" if rest.trim().is_empty() => fail("`mtllib` names no file", "name the .mtl file after it"),
            "mtllib" => {
                outline.libraries.push(rest.trim().to_owned());
                Ok(())
            }
            "s" => {
                self.smoothing = !matches!(rest.trim(), "0" | "off");
                Ok(())
            }
            "o" | "g" => Ok(()),
            _ => {
                let line_or_point = matches!(key, "l" | "p");
                let why = if line_or_point { "lines and points have no area" } else { "only polygons are rendered" };
                outline.pass_over(key, self.line, why);
                Ok(())
            }
        }
    }

    fn position(&mut self, rest: &str, outline: &mut Outline) -> Result<(), Wrong> {
        let (mut words, mut word) = (words(rest), "");
        for _ in 0..3 {
            word = words.next().ok_or_else(|| broken("a vertex has three coordinates", "give x, y and z"))?;
            if !is_plain(word) && number(word).and_then(|x| FINITE.admit(x)).is_none() {
                return fail(format!("`{word}` is not a finite number"), "give finite vertex coordinates");
            }
        }
        match words.next().map(number) {
            None | Some(Some(1.0)) => {}
            _ => outline.pass_over("v", self.line, "what follows x y z (weight or colour) is not used"),
        }
        self.put_up_to("v", rest, word);
        outline.positions += 1;
        within_32_bits(outline.positions, "vertices")
    }

    fn normal(&mut self, rest: &str, outline: &mut Outline) -> Result<(), Wrong> {
        let (mut words, mut word) = (words(rest), "");
        for _ in 0..3 {
            word = words.next().ok_or_else(|| broken("a normal has three components", "give x, y and z"))?;
            // NaN and infinity pass: exporters write them for degenerate faces, which are then shaded flat.
            if !is_plain(word) && number(word).is_none() {
                return fail(format!("`{word}` is not a number"), "give three numbers, or leave the normal out");
            }
        }
        self.put_up_to("vn", rest, word);
        outline.normals += 1;
        within_32_bits(outline.normals, "normals")
    }

    /// A line of the words of `rest` as they stand, the `last` of which is a part of it: one copy, not one a word.
    fn put_up_to(&mut self, key: &str, rest: &str, last: &str) {
        let end = last.as_ptr().addr() - rest.as_ptr().addr() + last.len();
        self.ready.push_str(key);
        self.ready.push_str(&rest[..end]);
        self.ready.push('\n');
    }

    fn face(&mut self, rest: &str, outline: &mut Outline) -> Result<(), Wrong> {
        let (mut corners, mut with_normal, mut with_texture, mut last) = (0, 0, false, "");
        for corner in words(rest) {
            last = corner;
            let [position, texture, normal] = indices(corner, self.line, outline)?;
            if !position {
                return fail(format!("face corner `{corner}` names no vertex"), "write vertex[/texture[/normal]]");
            }
            corners += 1;
            with_normal += usize::from(normal);
            with_texture |= texture;
        }
        if corners < 3 {
            return fail(format!("a face has at least 3 corners, this one {corners}"), "remove it or complete it");
        }
        if with_texture {
            self.ready.push('f');
            words(rest).for_each(|corner| self.put_untextured(corner));
            self.ready.push('\n');
        } else {
            self.put_up_to("f", rest, last);
        }
        if with_normal < corners {
            if self.smoothing {
                outline.pass_over("s", self.line, "faces without normals are shaded flat");
            }
            let run = outline.triangles..outline.triangles + corners - 2;
            match outline.flat.last_mut() {
                Some(last) if last.end == run.start => last.end = run.end,
                _ => outline.flat.push(run),
            }
        }
        match self.current {
            Some(current) => outline.materials[current].worn = true,
            None => outline.has_bare_faces = true,
        }
        if corners > 3 {
            let first = outline.triangles;
            match outline.polygons.last_mut() {
                Some(run) if run.corners == corners && run.first + run.faces * (corners - 2) == first => run.faces += 1,
                _ => outline.polygons.push(PolygonRun { first, faces: 1, corners }),
            }
        }
        outline.triangles += corners - 2;
        within_32_bits(outline.triangles, "triangles")
    }

    /// A corner that was judged, without its texture coordinate.
    fn put_untextured(&mut self, corner: &str) {
        let mut parts = corner.split('/');
        self.ready.push(' ');
        self.ready.push_str(parts.next().unwrap_or_default());
        if let Some(normal) = parts.nth(1).filter(|normal| !normal.is_empty()) {
            self.ready.push_str("//");
            self.ready.push_str(normal);
        }
    }

    fn material(&mut self, name: &str, outline: &mut Outline) -> Result<(), Wrong> {
        if name.is_empty() {
            return fail("`usemtl` names no material", "name one after it, or remove the line");
        }
        let number = match self.numbers.get(name) {
            Some(&number) => number,
            None => {
                let number = outline.materials.len();
                self.numbers.insert(name.to_owned(), number);
                outline.materials.push(MaterialUse { name: name.to_owned(), line: self.line, worn: false });
                // tobj knows a material once a library has defined it: a new number announces itself.
                let _ = writeln!(self.ready, "mtllib {number}");
                number
            }
        };
        // tobj closes the group of faces here and looks up all they named.
        if self.current != Some(number) {
            outline.error = outline.beyond_the_end(self.file);
        }
        let _ = writeln!(self.ready, "usemtl {number}");
        self.current = Some(number);
        Ok(())
    }
}

fn texcoord(rest: &str, outline: &mut Outline) -> Result<(), Wrong> {
    if words(rest).next().and_then(number).is_none() {
        return fail("a texture coordinate starts with a number", "give u and v");
    }
    outline.texcoords += 1;
    within_32_bits(outline.texcoords, "texture coordinates")
}

fn within_32_bits(count: usize, what: &str) -> Result<(), Wrong> {
    if count > MOST { fail(format!("more than {MOST} {what}"), "split the model") } else { Ok(()) }
}

/// What tobj reads: the lines that a [`Feed`] sends.
pub(super) struct Lines {
    sent: Receiver<std::io::Result<String>>,
    ready: String,
    taken: usize,
}

impl Lines {
    pub fn new(sent: Receiver<std::io::Result<String>>) -> Self {
        Lines { sent, ready: String::new(), taken: 0 }
    }
}

impl Read for Lines {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let mut available = self.fill_buf()?;
        let count = available.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Lines {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.taken == self.ready.len() {
            // The feed is gone when all is sent.
            self.ready = self.sent.recv().unwrap_or(Ok(String::new()))?;
            self.taken = 0;
        }
        Ok(&self.ready.as_bytes()[self.taken..])
    }

    fn consume(&mut self, count: usize) {
        self.taken = (self.taken + count).min(self.ready.len());
    }
}
