//! What stands in the lines of an OBJ file: numbers, and the indices of corners.

use super::obj_outline::{KINDS, Outline};

/// More of anything than this is an error: indices must fit 32 bits with [`NO_NORMAL`](super::NO_NORMAL) left over.
pub(super) const MOST: usize = u32::MAX as usize - 1;

/// What is wrong, and what to do.
pub(super) type Wrong = (String, String);

/// Judges the indices of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`: which there are.
pub(super) fn indices(corner: &str, line: usize, outline: &mut Outline) -> Result<[bool; 3], Wrong> {
    let defined = [outline.positions, outline.texcoords, outline.normals];
    let mut found = [false; 3];
    let (mut kind, mut rest) = (0, corner);
    loop {
        let (index, length) = leading_index(rest);
        if kind > 2 {
            return fail(format!("face corner `{corner}` has too many parts"), "write vertex[/texture[/normal]]");
        }
        if length > 0 {
            let what = KINDS[kind];
            let Some(index) = index else {
                let word = &rest[..length];
                return fail(format!("`{word}` is not a {what} index"), "write a whole number, from 1 or negative");
            };
            let absolute = if index < 0 { defined[kind] as i64 + 1 + index.max(-(MOST as i64)) } else { index };
            if absolute <= 0 || absolute > MOST as i64 {
                return fail(
                    format!("{what} {index} does not exist: {} are defined so far", defined[kind]),
                    "count from 1, or back from -1 for the latest",
                );
            }
            found[kind] = true;
            if absolute as usize > outline.largest[kind].0 {
                outline.largest[kind] = (absolute as usize, line);
            }
        }
        if length == rest.len() {
            return Ok(found);
        }
        rest = &rest[length + 1..];
        kind += 1;
    }
}

/// The whole number up to a `/` or the end, if that is one, and how many bytes are before it.
fn leading_index(text: &str) -> (Option<i64>, usize) {
    /// So many digits are no more than 64 bits hold.
    const SURE: usize = 18;
    let (mut value, mut digits, mut length) = (0i64, true, 0);
    for byte in text.bytes().take_while(|&byte| byte != b'/') {
        let digit = byte.wrapping_sub(b'0');
        digits &= digit < 10;
        value = value.wrapping_mul(10).wrapping_add(i64::from(digit));
        length += 1;
    }
    let index = if digits && length <= SURE { Some(value) } else { text[..length].parse().ok() };
    (index, length)
}

/// The words of a line of numbers; a comment may end it.
pub(super) fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_ascii_whitespace().take_while(|word| !word.starts_with('#'))
}

/// Is a word surely a finite number, being short and of digits with a point and a sign at most? (To read it takes longer.)
pub(super) fn is_plain(word: &str) -> bool {
    const SHORT: usize = 32;
    let unsigned = word.strip_prefix('-').unwrap_or(word).as_bytes();
    let (mut digits, mut points) = (0, 0);
    for byte in unsigned {
        digits += usize::from(byte.is_ascii_digit());
        points += usize::from(*byte == b'.');
    }
    digits > 0 && points <= 1 && digits + points == unsigned.len() && unsigned.len() <= SHORT
}

/// As tobj will read it: in single precision.
pub(super) fn number(word: &str) -> Option<f64> {
    word.parse::<f32>().ok().map(f64::from)
}

pub(super) fn broken(message: impl Into<String>, mend: impl Into<String>) -> Wrong {
    (message.into(), mend.into())
}

pub(super) fn fail<T>(message: impl Into<String>, mend: impl Into<String>) -> Result<T, Wrong> {
    Err(broken(message, mend))
}
