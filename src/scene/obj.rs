//! Wavefront OBJ through tobj: read, triangulated as fans, placed and appended to the scene's mesh.

use super::error::SceneError;
use super::notes::Notes;
use super::obj_feed::{Feed, Lines};
use super::obj_outline::Outline;
use super::transform::{Transform, unit};
use super::{Mesh, NO_NORMAL};
use glam::DVec3;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};

/// A parsed OBJ file. The material index of a model counts in [`Outline::materials`].
pub(super) struct Obj {
    pub outline: Outline,
    models: Vec<tobj::Model>,
}

/// How far the reading of a file may be ahead of tobj, in chunks: with 8, each woke the other for every chunk, and they took
/// turns on one core.
const CHUNKS_AHEAD: usize = 256;

/// Reads and checks an OBJ file; libraries are not opened.
pub(super) fn read(file: &Path, notes: &mut Notes) -> Result<Obj, SceneError> {
    let opened = File::open(file).map_err(|error| SceneError::unreadable(file, &error))?;
    if let Ok(metadata) = opened.metadata()
        && metadata.is_dir()
    {
        return Err(SceneError::whole(file, "is a folder", "name an .obj file"));
    }
    let source = BufReader::with_capacity(1 << 16, opened);
    let (sender, receiver) = sync_channel(CHUNKS_AHEAD);
    let (outline, parsed) = std::thread::scope(|scope| {
        let feeding = scope.spawn(move || Feed::new(file).send(source, &sender));
        let parsed = parse(receiver);
        (feeding.join(), parsed)
    });
    let mut outline = outline.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    outline.warn(file, notes);
    if let Some(error) = outline.error.take().or_else(|| outline.beyond_the_end(file)) {
        return Err(error);
    }
    let late = "define all `v` and `vn` lines before the faces that use them";
    let (models, _) = parsed.map_err(|error| SceneError::whole(file, format!("cannot be read: {error}"), late))?;
    if outline.triangles == 0 {
        return Err(SceneError::whole(file, "holds no faces", "export polygons (`f` lines)"));
    }
    Ok(Obj { outline, models })
}

/// Takes the receiver along: where tobj gives up, the feed is to stop.
fn parse(lines: Receiver<std::io::Result<String>>) -> tobj::LoadResult {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    tobj::load_obj_buf(&mut Lines::new(lines), &options, |number| {
        let name = number.to_string_lossy().into_owned();
        let material = tobj::Material { name: name.clone(), ..Default::default() };
        Ok((vec![material], [(name, 0)].into_iter().collect()))
    })
}

/// How a mesh joins the scene.
pub(super) struct Placement<'a> {
    pub file: &'a Path,
    pub transform: Option<&'a Transform>,
    /// Ignore vertex normals.
    pub flat: bool,
    /// The scene's material for each of [`Outline::materials`].
    pub materials: &'a [u32],
    /// For faces that name none.
    pub default_material: u32,
}

/// Appends a file's triangles in file order.
pub(super) fn append(mesh: &mut Mesh, obj: Obj, place: &Placement) -> Result<(), SceneError> {
    let Obj { outline, models } = obj;
    let total = mesh.triangles.len() + outline.triangles;
    if total > u32::MAX as usize - 1 || mesh.positions.len() + 3 * outline.triangles > u32::MAX as usize - 1 {
        return Err(SceneError::whole(place.file, "the scene's meshes exceed 32-bit indices", "use smaller meshes"));
    }
    mesh.triangles.reserve(outline.triangles);
    mesh.material.reserve(outline.triangles);
    let mirrors = place.transform.is_some_and(Transform::mirrors);
    let mut seen = 0;
    for model in models {
        let tobj::Mesh { positions, indices, normals, normal_indices, material_id, .. } = model.mesh;
        let count = indices.len() / 3;
        let material = material_id.and_then(|id| place.materials.get(id)).copied().unwrap_or(place.default_material);
        let base = append_positions(mesh, &positions, place)?;
        mesh.triangles.extend(triples(&indices, mirrors).map(|triangle| triangle.map(|i| base + i)));
        mesh.material.resize(mesh.triangles.len(), material);
        if !place.flat && (!normals.is_empty() || !all_flat(&outline, seen, count)) {
            check_normals(&normal_indices, indices.len(), place.file)?;
            let corners = Corners { normals: &normals, indices: &normal_indices, first: seen, mirrors };
            append_normals(mesh, &outline, &corners, place.transform);
        }
        seen += count;
    }
    if !mesh.normals.is_empty() {
        mesh.normal_indices.resize(mesh.triangles.len(), [NO_NORMAL; 3]);
    }
    Ok(())
}

/// Returns the index of the first position appended.
fn append_positions(mesh: &mut Mesh, positions: &[f32], place: &Placement) -> Result<u32, SceneError> {
    let base = mesh.positions.len() as u32;
    let points = positions.as_chunks::<3>().0;
    match place.transform {
        None => mesh.positions.extend_from_slice(points),
        Some(transform) => {
            mesh.positions.reserve(points.len());
            for &point in points {
                mesh.positions.push(transform.point(point).ok_or_else(|| {
                    SceneError::whole(
                        place.file,
                        format!("vertex {point:?} leaves single precision under its `transform`"),
                        "use smaller coordinates or a smaller scale",
                    )
                })?);
            }
        }
    }
    Ok(base)
}

/// Index triples; a mirrored triangle changes two corners, so that its front stays where its normals point.
fn triples(indices: &[u32], mirrors: bool) -> impl Iterator<Item = [u32; 3]> + '_ {
    indices.as_chunks::<3>().0.iter().map(move |&[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] })
}

/// The normals of one model.
struct Corners<'a> {
    normals: &'a [f32],
    indices: &'a [u32],
    /// The first triangle's index in the file.
    first: usize,
    mirrors: bool,
}

fn append_normals(mesh: &mut Mesh, outline: &Outline, corners: &Corners, transform: Option<&Transform>) {
    let base = mesh.normals.len() as u32;
    // Where a normal of the file went; those without a direction went nowhere.
    let mut kept = Vec::with_capacity(corners.normals.len() / 3);
    for &normal in corners.normals.as_chunks::<3>().0 {
        let normal = DVec3::from(normal.map(f64::from));
        let placed = unit(transform.map_or(normal, |transform| transform.normal(normal)));
        kept.push(placed.map_or(NO_NORMAL, |_| mesh.normals.len() as u32));
        mesh.normals.extend(placed);
    }
    if mesh.normals.len() == base as usize {
        return;
    }
    let count = corners.indices.len() / 3;
    mesh.normal_indices.resize(mesh.triangles.len() - count, [NO_NORMAL; 3]);
    let mut runs = outline.flat.iter().skip_while(|run| run.end <= corners.first).peekable();
    for (i, triangle) in triples(corners.indices, corners.mirrors).enumerate() {
        let triangle_in_file = corners.first + i;
        while runs.next_if(|run| run.end <= triangle_in_file).is_some() {}
        let invented = runs.peek().is_some_and(|run| run.contains(&triangle_in_file));
        let placed = triangle.map(|corner| kept[corner as usize]);
        let shaded_flat = invented || placed.contains(&NO_NORMAL);
        mesh.normal_indices.push(if shaded_flat { [NO_NORMAL; 3] } else { placed });
    }
}

/// Do all of these triangles lack normals?
fn all_flat(outline: &Outline, first: usize, count: usize) -> bool {
    count == 0 || outline.flat.iter().any(|run| run.start <= first && first + count <= run.end)
}

/// tobj drops normals that a face names before the file has any.
fn check_normals(normal_indices: &[u32], corners: usize, file: &Path) -> Result<(), SceneError> {
    if normal_indices.len() == corners {
        return Ok(());
    }
    Err(SceneError::whole(
        file,
        "faces name normals before any is defined",
        "define all `vn` lines before the faces that use them",
    ))
}
