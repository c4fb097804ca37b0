//! The statements of OBJ and MTL: a line each, or several where a `\` ends all but the last.

use std::borrow::Cow;
use std::io::BufRead;

/// Reads statements one after the other.
pub(super) struct Statements<B> {
    source: B,
    lines_read: usize,
    raw: Vec<u8>,
}

impl<B: BufRead> Statements<B> {
    pub fn new(source: B) -> Self {
        Self { source, lines_read: 0, raw: Vec::new() }
    }

    /// The next statement on one line, and the number of the line that it starts on, from 1. `None` at the end.
    ///
    /// Only names and comments hold other than ASCII; a name in another encoding stays equal to itself.
    pub fn read(&mut self) -> std::io::Result<Option<(usize, Cow<'_, str>)>> {
        let first = self.lines_read + 1;
        self.raw.clear();
        loop {
            let start = self.raw.len();
            if self.source.read_until(b'\n', &mut self.raw)? == 0 {
                break;
            }
            self.lines_read += 1;
            if !is_continued(&self.raw[start..]) {
                break;
            }
            let end = self.raw.trim_ascii_end().len() - 1;
            self.raw.truncate(end);
            self.raw.push(b' ');
        }
        if self.lines_read < first {
            return Ok(None);
        }
        let bytes = if first == 1 { self.raw.strip_prefix("\u{feff}".as_bytes()) } else { None };
        Ok(Some((first, String::from_utf8_lossy(bytes.unwrap_or(&self.raw)))))
    }
}

/// Does the next line belong to this one? Not where the `\` ends a comment, such as one that names a Windows folder.
fn is_continued(line: &[u8]) -> bool {
    let words = || line.split(u8::is_ascii_whitespace);
    line.trim_ascii_end().ends_with(b"\\") && !words().any(|word| word.starts_with(b"#"))
}
