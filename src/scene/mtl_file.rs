//! Wavefront MTL files, their form checked statement by statement, through tobj.

use super::error::SceneError;
use super::mtl_maps;
use super::statements::Statements;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The materials of one MTL file.
pub(super) struct Library {
    pub file: PathBuf,
    entries: Vec<Entry>,
}

/// A material as it is written.
pub(super) struct Entry {
    pub parsed: tobj::Material,
    /// Where each key was set last.
    pub lines: BTreeMap<String, usize>,
    /// The values of texture statements.
    pub maps: BTreeMap<String, String>,
}

impl Library {
    /// Reads an MTL file and checks its form; whether values lie in their domain is asked of materials in use only.
    pub fn read(file: PathBuf) -> Result<Self, SceneError> {
        let bytes = std::fs::read(&file).map_err(|error| SceneError::unreadable(&file, &error))?;
        let (canonical, keys) = check(&file, &bytes)?;
        let (parsed, _) = tobj::load_mtl_buf(&mut canonical.as_bytes()).map_err(|error| {
            SceneError::whole(&file, format!("cannot be read: {error}"), "export the materials again")
        })?;
        let entries = parsed.into_iter().zip(keys);
        let entries = entries.map(|(parsed, Keys { lines, maps })| Entry { parsed, lines, maps }).collect();
        Ok(Self { file, entries })
    }

    /// The material of that name; the last one, where several bear it. `None` where there is none.
    pub fn entry(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().rfind(|entry| entry.parsed.name == name)
    }
}

const COLOURS: [&str; 5] = ["Ka", "Kd", "Ks", "Ke", "Tf"];
const SCALARS: [&str; 12] = ["Ns", "Ni", "d", "Tr", "Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor", "sharpness"];

/// The keys of one material: see [`Entry`].
#[derive(Default)]
struct Keys {
    lines: BTreeMap<String, usize>,
    maps: BTreeMap<String, String>,
}

/// Checks every statement. Returns a text that tobj reads without panicking (it does on a colour of fewer than three
/// numbers), and the keys of each material.
fn check(file: &Path, bytes: &[u8]) -> Result<(String, Vec<Keys>), SceneError> {
    let mut canonical = String::new();
    let mut materials: Vec<Keys> = Vec::new();
    let mut statements = Statements::new(bytes);
    while let Some((number, raw)) = statements.read().map_err(|error| SceneError::unreadable(file, &error))? {
        let (key, value) = raw.trim().split_once(char::is_whitespace).unwrap_or((raw.trim(), ""));
        let value = value.trim();
        if key.is_empty() || key.starts_with('#') {
            continue;
        }
        if key == "newmtl" {
            if value.is_empty() {
                return Err(SceneError::at(file, number, "`newmtl` without a name", "name the material"));
            }
            materials.push(Keys::default());
        }
        let Some(keys) = materials.last_mut() else {
            return Err(SceneError::at(file, number, format!("`{key}` before any `newmtl`"), "name a material first"));
        };
        keys.lines.insert(key.to_owned(), number);
        if mtl_maps::is_map(key) {
            keys.maps.insert(key.to_owned(), value.to_owned());
        }
        let value = canonical_value(key, value)
            .map_err(|(message, mend)| SceneError::at(file, number, format!("`{key}` {message}"), mend))?;
        canonical.push_str(&format!("{key} {value}\n"));
    }
    Ok((canonical, materials))
}

fn canonical_value(key: &str, value: &str) -> Result<String, (String, &'static str)> {
    let bare = value.split('#').next().unwrap_or_default();
    if COLOURS.contains(&key) {
        let words: Vec<&str> = bare.split_whitespace().collect();
        match words[..] {
            [grey] if finite(grey) => Ok(format!("{grey} {grey} {grey}")),
            [r, g, b] if [r, g, b].into_iter().all(finite) => Ok(format!("{r} {g} {b}")),
            _ => Err((
                format!("takes three finite numbers, not `{value}`"),
                "write red, green and blue, linear Rec. 709",
            )),
        }
    } else if SCALARS.contains(&key) {
        match bare.trim() {
            word if finite(word) => Ok(word.to_owned()),
            word => Err((format!("takes one finite number, not `{word}`"), "write a number")),
        }
    } else if key == "illum" {
        match bare.trim().parse::<u8>() {
            Ok(model) if model <= 10 => Ok(model.to_string()),
            _ => Err((format!("takes a whole number from 0 to 10, not `{value}`"), "write 2 for an opaque material")),
        }
    } else if key != "newmtl" && value.is_empty() {
        Err(("has no value".to_owned(), "give it one or remove the line"))
    } else {
        Ok(value.to_owned())
    }
}

fn finite(word: &str) -> bool {
    word.parse::<f32>().is_ok_and(f32::is_finite)
}
