//! Which material a name means, and its index in the scene.

use super::draft::Draft;
use super::error::SceneError;
use super::image_file::ImageFiles;
use super::load::beside;
use super::mtl::{self, ASSUMED_GREY};
use super::mtl_file::Library;
use super::notes::Notes;
use super::obj_outline::{MaterialUse, Outline};
use super::{Bsdf, Material};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// The scene's materials as they come into use: [`Scene::materials`](super::Scene::materials) holds no others.
#[derive(Default)]
pub(super) struct Materials {
    used: Vec<Material>,
    /// The `[materials]` of a scene file.
    defined: BTreeMap<String, Draft>,
    images: ImageFiles,
    /// Index by the MTL file a material came from (none: `[materials]`, or the assumed grey) and its name.
    indices: HashMap<(Option<PathBuf>, String), u32>,
}

impl Materials {
    pub fn new(defined: BTreeMap<String, Draft>) -> Self {
        Self { defined, ..Self::default() }
    }

    /// A material of `[materials]`.
    pub fn defined(&mut self, name: &str, notes: &mut Notes) -> Option<Result<u32, SceneError>> {
        let draft = self.defined.get(name)?.clone();
        Some(self.index(None, draft, notes))
    }

    /// What a face is made of that names no material.
    pub fn grey(&mut self, file: &Path, notes: &mut Notes) -> Result<u32, SceneError> {
        notes.assume(format!("{}: faces without a material are diffuse, reflectance {ASSUMED_GREY}", file.display()));
        // No material can be defined under the empty name in an OBJ file.
        let grey = Material { bsdf: Bsdf::Diffuse { reflectance: [ASSUMED_GREY; 3] }, ..Material::default() };
        self.index(None, grey.into(), notes)
    }

    /// The index of each of an OBJ file's materials; those that no face wears get one that no triangle will bear.
    pub fn of_mesh(&mut self, file: &Path, outline: &Outline, notes: &mut Notes) -> Result<Vec<u32>, SceneError> {
        let libraries = Libraries::read(file, outline)?;
        notes.files.extend(libraries.read.iter().map(|library| library.file.clone()));
        outline
            .materials
            .iter()
            .map(|wanted| {
                if !wanted.worn {
                    return Ok(u32::MAX);
                }
                self.defined(&wanted.name, notes).unwrap_or_else(|| {
                    let (library, draft) = libraries.material(file, wanted, notes)?;
                    self.index(Some(library), draft, notes)
                })
            })
            .collect()
    }

    /// All materials in use, and the names of those defined in vain.
    pub fn finish(self) -> (Vec<Material>, Vec<String>) {
        let Self { used, mut defined, indices, .. } = self;
        for (origin, name) in indices.keys() {
            if origin.is_none() {
                defined.remove(name);
            }
        }
        (used, defined.into_keys().collect())
    }

    /// All materials in use so far.
    pub fn used(&self) -> &[Material] {
        &self.used
    }

    fn index(&mut self, origin: Option<PathBuf>, draft: Draft, notes: &mut Notes) -> Result<u32, SceneError> {
        let key = (origin, draft.material.name.clone());
        if let Some(&index) = self.indices.get(&key) {
            return Ok(index);
        }
        let index = self.used.len() as u32;
        self.used.push(draft.finish(&mut self.images, notes)?);
        self.indices.insert(key, index);
        Ok(index)
    }
}

/// The MTL files an OBJ file names: those that could be read, and why the others could not.
struct Libraries {
    read: Vec<Library>,
    missing: Vec<SceneError>,
}

impl Libraries {
    fn read(obj: &Path, outline: &Outline) -> Result<Self, SceneError> {
        let mut libraries = Self { read: Vec::new(), missing: Vec::new() };
        for path in outline.libraries.iter().flat_map(|name| library_paths(obj, name)) {
            match Library::read(path) {
                Ok(library) => libraries.read.push(library),
                // Without a line, the file itself is at fault: that matters only if a material is missed.
                Err(error) if error.line.is_none() => libraries.missing.push(error),
                Err(error) => return Err(error),
            }
        }
        for error in &libraries.missing {
            log::warn!("{}: {}: {}", obj.display(), error.file.display(), error.message);
        }
        Ok(libraries)
    }

    fn material(&self, obj: &Path, wanted: &MaterialUse, notes: &mut Notes) -> Result<(PathBuf, Draft), SceneError> {
        let found = |library: &Library| Some((library.file.clone(), mtl::material(library, &wanted.name, notes)?));
        match self.read.iter().rev().find_map(found) {
            Some((file, material)) => Ok((file, material?)),
            None => {
                let name = &wanted.name;
                let why = match (self.missing.first(), self.read.is_empty()) {
                    (Some(missing), _) => format!(" ({} {})", missing.file.display(), missing.message),
                    (None, true) => " (the file names no `mtllib`)".to_owned(),
                    (None, false) => String::new(),
                };
                Err(SceneError::at(
                    obj,
                    wanted.line,
                    format!("material `{name}` is not defined{why}"),
                    format!("add it to an MTL file named by `mtllib`, or [materials.{name}] to a scene file"),
                ))
            }
        }
    }
}

/// One `mtllib` line names one file with spaces in its name, or several without.
fn library_paths(obj: &Path, names: &str) -> Vec<PathBuf> {
    let whole = beside(obj, names);
    if whole.is_file() || !names.contains(char::is_whitespace) {
        return vec![whole];
    }
    names.split_whitespace().map(|name| beside(obj, name)).collect()
}
