//! One OBJ file joins the scene: its triangles, and the materials they wear.

use super::Mesh;
use super::error::SceneError;
use super::materials::Materials;
use super::notes::Notes;
use super::obj::{self, Placement};
use super::transform::Transform;
use std::path::Path;

/// Reads `file` and appends it to `mesh`. `flat` ignores vertex normals.
pub(super) fn add_obj(
    mesh: &mut Mesh,
    materials: &mut Materials,
    notes: &mut Notes,
    file: &Path,
    transform: Option<&Transform>,
    flat: bool,
) -> Result<(), SceneError> {
    let read = obj::read(file, notes)?;
    let indices = materials.of_mesh(file, &read.outline, notes)?;
    let default_material = if read.outline.has_bare_faces { materials.grey(file, notes) } else { u32::MAX };
    obj::append(mesh, read, &Placement { file, transform, flat, materials: &indices, default_material })
}
