//! One OBJ file joins the scene: its triangles, and the materials they wear.

use super::error::SceneError;
use super::materials::Materials;
use super::notes::Notes;
use super::obj::{self, Placement};
use super::transform::Transform;
use super::{Mesh, NO_TEXCOORD, obj_texcoords, polygons};
use std::path::Path;

/// Reads `file` and appends it to `mesh`, with texture coordinates where a texture is worn. `flat` ignores vertex
/// normals.
pub(super) fn add_obj(
    mesh: &mut Mesh,
    materials: &mut Materials,
    notes: &mut Notes,
    file: &Path,
    transform: Option<&Transform>,
    flat: bool,
) -> Result<(), SceneError> {
    notes.files.push(file.to_path_buf());
    let mut read = obj::read(file, notes)?;
    let polygons = std::mem::take(&mut read.outline.polygons);
    let indices = materials.of_mesh(file, &read.outline, notes)?;
    let default_material = if read.outline.has_bare_faces { materials.grey(file, notes)? } else { u32::MAX };
    let first = mesh.triangles.len();
    obj::append(mesh, read, &Placement { file, transform, flat, materials: &indices, default_material })?;
    let mirrors = transform.is_some_and(Transform::mirrors);
    let textured: Vec<bool> = materials.used().iter().map(|material| material.maps.any()).collect();
    let wears_texture = |&material: &u32| textured[material as usize];
    if mesh.material[first..].iter().any(wears_texture) {
        obj_texcoords::append(mesh, file, first, mirrors, wears_texture, notes)?;
    }
    if !mesh.texcoords.is_empty() {
        mesh.texcoord_indices.resize(mesh.triangles.len(), [NO_TEXCOORD; 3]);
    }
    polygons::cut_concave(mesh, &polygons, first, mirrors);
    Ok(())
}
