//! From a path to a [`Scene`].

use super::error::SceneError;
use super::notes::Notes;
use super::{Scene, bare_model, coincident, toml_file};
use std::path::Path;

/// Loads a scene file (`.toml`) or a bare model (`.obj`, with its MTL files).
///
/// Keys that are read but not honoured, materials defined but not used, and lamps that lie in one another are said through
/// [`log::warn!`].
///
/// # Errors
/// Everything that keeps the input from being rendered as written; see [`SceneError`].
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let mut notes = Notes::default();
    notes.files.push(path.to_path_buf());
    let mut scene = match extension.as_deref() {
        Some("toml") => toml_file::load(path, &mut notes)?,
        Some("obj") => bare_model::load(path, &mut notes)?,
        _ => return Err(SceneError::whole(path, "is neither a scene nor a model", "give a .toml or an .obj file")),
    };
    scene.name = path.display().to_string();
    scene.assumptions = notes.assumptions;
    scene.files = notes.files;
    coincident::warn(&scene);
    Ok(scene)
}

/// Joins the name of a file with the folder of the file that names it.
pub(super) fn beside(file: &Path, name: &str) -> std::path::PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}
