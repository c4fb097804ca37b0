//! A model without a scene file: camera and light are assumed, and the assumptions said.

use super::error::SceneError;
use super::materials::Materials;
use super::mesh_file::add_obj;
use super::notes::Notes;
use super::surroundings::Surroundings;
use super::toml_file::DEFAULT_FILM;
use super::{Camera, Environment, Integrator, Material, Mesh, Scene, Sphere};
use glam::DVec3;
use std::path::Path;

/// Full vertical field of view outside a model, in degrees.
const OUTSIDE_VFOV: f64 = 40.0;
/// Full vertical field of view inside a room, in degrees: wide, as there is no stepping back.
const INSIDE_VFOV: f64 = 60.0;
/// From where a model is looked at: from the front (+z), a little right and above.
const OUTSIDE_VIEW: DVec3 = DVec3::new(0.5, 0.35, 1.0);
/// How much of the picture is left free around a model.
const MARGIN: f64 = 1.05;
/// The rounding of a camera that is put up with, as a fraction of its distance: well inside the margin.
const ROUNDING: f64 = 0.02;
/// Eye height as a fraction of a room's: about 1.6 m under a ceiling at 2.6 m.
const EYE_HEIGHT: f64 = 0.6;
/// How far back from the middle towards the wall the camera stands in a room.
const STEP_BACK: f64 = 0.8;

/// Loads an OBJ file and completes it to a scene.
pub(super) fn load(file: &Path, notes: &mut Notes) -> Result<Scene, SceneError> {
    let mut mesh = Mesh::default();
    let mut materials = Materials::default();
    add_obj(&mut mesh, &mut materials, notes, file, None, false)?;
    let (mut materials, _) = materials.finish();
    let around = Surroundings::of(&mesh);
    let is_room = around.is_room();
    let view = if is_room { inside(&around, notes) } else { outside(&around, notes) };
    let lost = || {
        let message = "no camera can frame the model: its extent is lost in single precision";
        SceneError::whole(file, message, "place it near the origin, at a moderate scale")
    };
    let camera = view.camera().ok_or_else(lost)?;
    let mut spheres = Vec::new();
    let mut environment = None;
    if !materials.iter().any(Material::emits) {
        if is_room {
            let (lamp, material) = lamp(&around, &view, materials.len() as u32, notes);
            if !(lamp.radius > 0.0 && material.emission[0].is_finite()) {
                return Err(lost());
            }
            spheres.push(lamp);
            materials.push(material);
        } else {
            notes.assume("nothing emits: a constant environment of radiance 1 lights the model".to_owned());
            environment = Some(Environment::Constant([1.0; 3]));
        }
    }
    Ok(Scene {
        name: String::new(),
        camera,
        film: DEFAULT_FILM,
        integrator: Integrator::default(),
        environment,
        delta_lights: Vec::new(),
        mesh,
        spheres,
        materials,
        assumptions: Vec::new(),
    })
}

/// The nearest place along [`OUTSIDE_VIEW`] from which all corners of the bounding box are in a square picture.
fn outside(around: &Surroundings, notes: &mut Notes) -> View {
    let backward = OUTSIDE_VIEW.normalize();
    let right = DVec3::Y.cross(backward).normalize();
    let up = backward.cross(right);
    let slope = (OUTSIDE_VFOV / 2.0).to_radians().tan() / MARGIN;
    let distance = around.corners().into_iter().map(|corner| {
        let from_center = corner - around.center();
        from_center.dot(backward) + from_center.dot(right).abs().max(from_center.dot(up).abs()) / slope
    });
    let distance = distance.fold(0.0, f64::max);
    // A model of no extent is a point, seen from anywhere.
    let distance = if distance > 0.0 { distance } else { 1.0 };
    notes.assume(format!("the camera frames the bounding box from outside: +y is up, vfov {OUTSIDE_VFOV}"));
    View { position: around.center() + backward * distance, look_at: around.center(), vfov: OUTSIDE_VFOV, behind: 0.0 }
}

/// Inside a room, back from the middle along its longest horizontal axis.
fn inside(around: &Surroundings, notes: &mut Notes) -> View {
    let size = around.size();
    let middle = around.center() + DVec3::Y * ((EYE_HEIGHT - 0.5) * size.y);
    let (axis, half, name) =
        if size.x >= size.z { (DVec3::X, size.x / 2.0, 'x') } else { (DVec3::Z, size.z / 2.0, 'z') };
    let free = |direction| around.nearest(middle, direction).map_or(half, |hit| hit.t);
    // Of the two ends, the one with more space to step back.
    let (behind, back, sign) =
        if free(-axis) >= free(axis) { (free(-axis), -axis, '+') } else { (free(axis), axis, '-') };
    notes.assume(format!(
        "the model encloses its centre: the camera stands inside at {:.0} % of its height and looks along {sign}{name}: \
         +y is up, vfov {INSIDE_VFOV}",
        EYE_HEIGHT * 100.0
    ));
    View {
        position: middle + back * (behind * STEP_BACK),
        look_at: middle,
        vfov: INSIDE_VFOV,
        behind: behind * (1.0 - STEP_BACK),
    }
}

/// A small lamp behind and above the camera that gives the middle of the room about irradiance 1: a third of what a constant
/// environment of radiance 1 gives, because the walls near the lamp get more, and gloss reflects it.
fn lamp(around: &Surroundings, view: &View, material: u32, notes: &mut Notes) -> (Sphere, Material) {
    let &View { position, look_at: middle, behind, .. } = view;
    let backward = (position - middle).normalize();
    // Small enough to stay clear of the wall behind and of the ceiling.
    let radius = 0.2 * behind.min((1.0 - EYE_HEIGHT) * around.size().y);
    let center = position + (backward + DVec3::Y) * (2.0 * radius);
    // A sphere of radiance L irradiates a patch that faces it from distance d by π L (r/d)².
    let radiance = ((center.distance(middle) / radius).powi(2) / std::f64::consts::PI) as f32;
    notes.assume(format!(
        "nothing emits: a spherical lamp behind the camera, radius {radius:.3}, radiance {radiance:.3}, lights the room"
    ));
    let emission = [radiance; 3];
    let material_of_lamp = Material { name: "lamp".to_owned(), emission, ..Material::default() };
    (Sphere { center: center.as_vec3().to_array(), radius: radius as f32, material }, material_of_lamp)
}

/// A camera in double precision.
struct View {
    position: DVec3,
    look_at: DVec3,
    vfov: f64,
    /// In a room: from the camera to the wall behind it.
    behind: f64,
}

impl View {
    /// `None` where rounding to single precision moves the view by more than the picture has room for.
    fn camera(&self) -> Option<Camera> {
        let [position, look_at] = [self.position, self.look_at].map(|p| p.as_vec3());
        let error = (position.as_dvec3() - self.position).length() + (look_at.as_dvec3() - self.look_at).length();
        (error <= ROUNDING * self.position.distance(self.look_at)).then_some(Camera {
            position: position.to_array(),
            look_at: look_at.to_array(),
            up: [0.0, 1.0, 0.0],
            vfov: self.vfov as f32,
            lens_radius: 0.0,
            focus_distance: 1.0,
        })
    }
}
