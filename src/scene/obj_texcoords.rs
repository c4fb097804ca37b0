//! Texture coordinates of an OBJ file: read in a second pass, and only where a texture is worn.

use super::error::SceneError;
use super::notes::Notes;
use super::statements::Statements;
use super::{Mesh, NO_TEXCOORD};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Appends the texture coordinates of the triangles from `first` on, which came from `file`, where `wears_texture`
/// holds of their material.
pub(super) fn append(
    mesh: &mut Mesh,
    file: &Path,
    first: usize,
    mirrors: bool,
    wears_texture: impl Fn(&u32) -> bool,
    notes: &mut Notes,
) -> Result<(), SceneError> {
    mesh.texcoord_indices.resize(first, [NO_TEXCOORD; 3]);
    let unreadable = |error| SceneError::unreadable(file, &error);
    let source = BufReader::with_capacity(1 << 16, File::open(file).map_err(unreadable)?);
    let mut statements = Statements::new(source);
    let base = mesh.texcoords.len();
    let mut corners = Vec::new();
    while let Some((line, text)) = statements.read().map_err(unreadable)? {
        let text = text.trim();
        let (key, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let words = rest.split_whitespace().take_while(|word| !word.starts_with('#'));
        match key {
            "vt" => mesh.texcoords.push(coordinates(words)),
            "f" => {
                corners.clear();
                corners.extend(words.map(|corner| index(corner, base, mesh.texcoords.len())));
                for i in 2..corners.len() {
                    let wears = mesh.material.get(mesh.texcoord_indices.len()).is_some_and(&wears_texture);
                    let triangle = [corners[0], corners[i - 1], corners[i]];
                    if wears && triangle.contains(&NO_TEXCOORD) {
                        notes.not_honoured(
                            file,
                            line,
                            "f",
                            "a face without texture coordinates reads its textures at (0, 0)",
                        );
                    }
                    let [a, b, c] = if wears { triangle } else { [NO_TEXCOORD; 3] };
                    mesh.texcoord_indices.push(if mirrors { [a, c, b] } else { [a, b, c] });
                }
            }
            _ => {}
        }
    }
    let in_range = |&corner: &u32| corner == NO_TEXCOORD || (corner as usize) < mesh.texcoords.len();
    if mesh.texcoord_indices.len() != mesh.triangles.len() || !mesh.texcoord_indices.iter().flatten().all(in_range) {
        return Err(SceneError::whole(file, "changed while it was read", "render again"));
    }
    Ok(())
}

/// u and v. Exporters write NaN for degenerate faces: it reads 0, as does a missing v.
fn coordinates<'a>(words: impl Iterator<Item = &'a str>) -> [f32; 2] {
    let mut numbers = words.map(|word| word.parse().ok().filter(|x: &f32| x.is_finite()).unwrap_or(0.0));
    [numbers.next().unwrap_or(0.0), numbers.next().unwrap_or(0.0)]
}

/// The index of a corner's coordinates, if it has any; the first pass has judged it. `now` are known so far, those of
/// the file from `base` on.
fn index(corner: &str, base: usize, now: usize) -> u32 {
    match corner.split('/').nth(1).and_then(|word| word.parse::<i64>().ok()) {
        Some(index) if index > 0 => u32::try_from(base as i64 + index - 1).unwrap_or(NO_TEXCOORD),
        Some(index) if index < 0 => u32::try_from(now as i64 + index).unwrap_or(NO_TEXCOORD),
        _ => NO_TEXCOORD,
    }
}
