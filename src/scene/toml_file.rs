//! `scene.toml`.

use super::domain::{FIELD_OF_VIEW, FINITE, NON_NEGATIVE, POSITIVE};
use super::draft::Draft;
use super::error::SceneError;
use super::load::beside;
use super::materials::Materials;
use super::mesh_file::add_obj;
use super::notes::Notes;
use super::toml_integrator::{IntegratorTable, integrator};
use super::toml_light::{DirectionalTable, EnvironmentTable, PointTable, SpotTable, delta_lights, environment};
use super::toml_material::MaterialTable;
use super::toml_text::{Numbers, TomlText};
use super::transform::Transform;
use super::{Camera, FilmSize, Mesh, Scene, Sphere};
use glam::DVec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneTable {
    camera: CameraTable,
    film: Option<FilmTable>,
    integrator: Option<IntegratorTable>,
    environment: Option<Spanned<EnvironmentTable>>,
    #[serde(default)]
    mesh: Vec<MeshTable>,
    #[serde(default)]
    sphere: Vec<SphereTable>,
    #[serde(default)]
    point_light: Vec<PointTable>,
    #[serde(default)]
    directional_light: Vec<DirectionalTable>,
    #[serde(default)]
    spot_light: Vec<SpotTable>,
    #[serde(default)]
    materials: BTreeMap<Spanned<String>, MaterialTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    position: Spanned<Numbers<3>>,
    look_at: Spanned<Numbers<3>>,
    up: Option<Spanned<Numbers<3>>>,
    vfov: Option<Spanned<f64>>,
    lens_radius: Option<Spanned<f64>>,
    focus_distance: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FilmTable {
    width: Option<Spanned<i64>>,
    height: Option<Spanned<i64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshTable {
    file: Spanned<String>,
    #[serde(default)]
    flat: bool,
    transform: Option<Spanned<Numbers<16>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SphereTable {
    center: Spanned<Numbers<3>>,
    radius: Spanned<f64>,
    material: Spanned<String>,
}

/// Film size where the scene does not say.
pub(super) const DEFAULT_FILM: FilmSize = FilmSize { width: 512, height: 512 };

/// Loads a scene file and the files it names.
pub(super) fn load(file: &Path, notes: &mut Notes) -> Result<Scene, SceneError> {
    let bytes = std::fs::read(file).map_err(|error| SceneError::unreadable(file, &error))?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
        SceneError::at(file, line, "is not UTF-8 text", "save the file as UTF-8")
    })?;
    let text = TomlText { file, text };
    let table: SceneTable = toml::from_str(text.text).map_err(|error| text.complaint(&error))?;
    let camera = camera(&table.camera, &text)?;
    let film = film(table.film.as_ref(), &text)?;
    let integrator = integrator(table.integrator.as_ref(), &text)?;
    let mut materials = Materials::new(defined_materials(&table.materials, &text)?);
    let spheres = spheres(&table.sphere, &mut materials, notes, &text)?;
    notes.files.extend(table.environment.as_ref().and_then(|table| table.as_ref().image(file)));
    // A view shows geometry: an environment image would be read for nothing.
    let lit = table.environment.filter(|_| integrator.kind.transports_light());
    let delta_lights = || delta_lights(&table.point_light, &table.directional_light, &table.spot_light, &text);
    let mut mesh = Mesh::default();
    let mut meshes =
        || table.mesh.iter().try_for_each(|table| add_mesh(table, &mut mesh, &mut materials, notes, &text));
    let mut sky = Ok(None);
    // Decoding an image takes about as long as reading a mesh of its size, which keeps two threads busy: by all the others.
    let meshes = rayon::in_place_scope(|scope| {
        scope.spawn(|_| sky = lit.map(|table| environment(&table, &text)).transpose());
        meshes()
    });
    let environment = sky?;
    let delta_lights = delta_lights()?;
    meshes?;
    let (materials, unused) = materials.finish();
    for name in unused {
        log::warn!("{}: material `{name}` is defined but nothing wears it", file.display());
    }
    Ok(Scene {
        name: String::new(),
        camera,
        film,
        integrator,
        environment,
        delta_lights,
        mesh,
        spheres,
        materials,
        assumptions: Vec::new(),
        files: Vec::new(),
    })
}

fn camera(table: &CameraTable, text: &TomlText) -> Result<Camera, SceneError> {
    let position = text.vector("position", &table.position, &FINITE)?;
    let look_at = text.vector("look_at", &table.look_at, &FINITE)?;
    let up = table.up.as_ref().map_or(Ok([0.0, 1.0, 0.0]), |up| text.vector("up", up, &FINITE))?;
    let vfov = table.vfov.as_ref().map_or(Ok(40.0), |vfov| text.number("vfov", vfov, &FIELD_OF_VIEW))?;
    let [position64, look_at64, up64] = [position, look_at, up].map(|v| DVec3::from(v.map(f64::from)));
    let Some(forward) = (look_at64 - position64).try_normalize() else {
        let message = "the camera stands at its target (`look_at` is `position`)";
        return Err(text.error(table.look_at.span(), message, "look at another point"));
    };
    // Rounding to single precision turns the frame about the axis by some ε/sin: below 1e-4, by a visible milliradian.
    let parallel = up64.try_normalize().is_none_or(|up| up.cross(forward).length() < 1e-4);
    if parallel {
        let place = table.up.as_ref().map_or(table.look_at.span(), Spanned::span);
        return Err(text.error(place, "`up` is zero or parallel to the viewing direction", "give another `up`"));
    }
    let number = |key, value: &Option<Spanned<f64>>, domain, default| {
        value.as_ref().map_or(Ok(default), |value| text.number(key, value, domain))
    };
    let lens_radius = number("lens_radius", &table.lens_radius, &NON_NEGATIVE, 0.0)?;
    if let Some(idle) = table.focus_distance.as_ref().filter(|_| lens_radius == 0.0) {
        text.warn_idle(idle.span(), "focus_distance", "a pinhole has all in focus; give it a `lens_radius`");
    }
    let focus_distance = number("focus_distance", &table.focus_distance, &POSITIVE, 1.0)?;
    Ok(Camera { position, look_at, up, vfov, lens_radius, focus_distance })
}

fn film(table: Option<&FilmTable>, text: &TomlText) -> Result<FilmSize, SceneError> {
    let Some(table) = table else { return Ok(DEFAULT_FILM) };
    let side = |key: &str, value: &Option<Spanned<i64>>, default: u32| {
        let Some(value) = value else { return Ok(default) };
        match u32::try_from(*value.as_ref()) {
            Ok(side) if (1..=FilmSize::LONGEST_SIDE).contains(&side) => Ok(side),
            _ => Err(text.error(
                value.span(),
                format!("a film cannot have `{key}` = {}", value.as_ref()),
                format!("give 1 to {} pixels", FilmSize::LONGEST_SIDE),
            )),
        }
    };
    let width = side("width", &table.width, DEFAULT_FILM.width)?;
    let height = side("height", &table.height, DEFAULT_FILM.height)?;
    let size = FilmSize { width, height };
    if !size.is_possible() {
        let place = table.width.as_ref().or(table.height.as_ref()).map_or(0..0, Spanned::span);
        let message = format!("a film of {width} x {height} pixels does not fit in memory");
        return Err(text.error(place, message, format!("give at most {} pixels", FilmSize::MOST_PIXELS)));
    }
    Ok(size)
}

fn defined_materials(
    tables: &BTreeMap<Spanned<String>, MaterialTable>,
    text: &TomlText,
) -> Result<BTreeMap<String, Draft>, SceneError> {
    let read = |(name, table): (&Spanned<String>, &MaterialTable)| {
        if name.as_ref().trim().is_empty() {
            return Err(text.error(name.span(), "a material without a name", "name it: [materials.NAME]"));
        }
        Ok((name.as_ref().clone(), table.read(name.as_ref(), text)?))
    };
    tables.iter().map(read).collect()
}

fn spheres(
    tables: &[SphereTable],
    materials: &mut Materials,
    notes: &mut Notes,
    text: &TomlText,
) -> Result<Vec<Sphere>, SceneError> {
    let read = |table: &SphereTable| {
        let center = text.vector("center", &table.center, &FINITE)?;
        let radius = text.number("radius", &table.radius, &POSITIVE)?;
        if center.iter().any(|c| !(c.abs() + radius).is_finite()) {
            return Err(text.error(table.radius.span(), "the sphere leaves single precision", "use smaller lengths"));
        }
        let name = table.material.as_ref();
        let material = materials.defined(name, notes).unwrap_or_else(|| {
            let bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
            let key = if bare { name.clone() } else { format!("{name:?}") };
            let mend = format!("add [materials.{key}], or name another");
            Err(text.error(table.material.span(), format!("material `{name}` is not defined"), mend))
        })?;
        Ok(Sphere { center, radius, material })
    };
    tables.iter().map(read).collect()
}

fn add_mesh(
    table: &MeshTable,
    mesh: &mut Mesh,
    materials: &mut Materials,
    notes: &mut Notes,
    text: &TomlText,
) -> Result<(), SceneError> {
    let path = named_file(&table.file, "an .obj model", "obj", text)?;
    let transform = match &table.transform {
        None => None,
        Some(rows) => {
            if rows.as_ref().0.iter().any(|&element| FINITE.admit(element).is_none()) {
                return Err(text.error(rows.span(), "`transform` holds numbers that are not finite", "mend them"));
            }
            let transform = Transform::from_rows(rows.as_ref().0);
            Some(transform.map_err(|(message, mend)| text.error(rows.span(), message, mend))?)
        }
    };
    add_obj(mesh, materials, notes, &path, transform.as_ref(), table.flat)
}

/// The path of a file that the scene names: it must exist, and be of the kind that is read there.
pub(super) fn named_file(
    name: &Spanned<String>,
    kind: &str,
    extension: &str,
    text: &TomlText,
) -> Result<PathBuf, SceneError> {
    let path = beside(text.file, name.as_ref());
    if !path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension)) {
        let message = format!("`{}` is not {kind}", name.as_ref());
        return Err(text.error(name.span(), message, format!("name a .{extension} file")));
    }
    match path.metadata() {
        Ok(metadata) if metadata.is_file() => Ok(path),
        Ok(_) => Err(text.error(name.span(), format!("`{}` is not a file", path.display()), format!("name {kind}"))),
        Err(error) => {
            let message = format!("`{}` cannot be read: {error}", path.display());
            Err(text.error(name.span(), message, "mend the path; it counts from the scene file's folder"))
        }
    }
}
