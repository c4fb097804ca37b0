//! A model without a scene file: camera and light are assumed, and the assumptions said.

use super::error::SceneError;
use super::materials::Materials;
use super::mesh_file::add_obj;
use super::notes::Notes;
use super::surroundings::Surroundings;
use super::toml_file::DEFAULT_FILM;
use super::{Camera, Environment, Integrator, Material, Mesh, Scene};
use glam::DVec3;
use std::f64::consts::PI;
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
/// Side of the panel that lights a room, as a fraction of the room's.
const PANEL_SIDE: f64 = 0.4;
/// From the ceiling to the panel, as a fraction of the room's height.
const PANEL_GAP: f64 = 0.01;
/// What the panel gives the middle of the room: a little more than a constant environment of radiance 1 does, as walls get
/// less.
const PANEL_IRRADIANCE: f64 = 1.2 * PI;
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
    let mut environment = None;
    if !materials.iter().any(Material::emits) {
        if is_room {
            Panel::of(&around, &view, notes).add(&mut mesh, &mut materials).ok_or_else(lost)?;
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
        spheres: Vec::new(),
        materials,
        assumptions: Vec::new(),
        files: Vec::new(),
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
    View { position: around.center() + backward * distance, look_at: around.center(), vfov: OUTSIDE_VFOV }
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
    View { position: middle + back * (behind * STEP_BACK), look_at: middle, vfov: INSIDE_VFOV }
}

/// A panel below the ceiling that lights the room from above: so large that its radiance is low, for a small lamp is mirrored
/// as a burnt spot, and what gloss throws of it onto matt walls is noise that takes thousands of samples.
struct Panel {
    low: DVec3,
    high: DVec3,
    radiance: f64,
}

impl Panel {
    fn of(around: &Surroundings, view: &View, notes: &mut Notes) -> Self {
        let (center, size) = (around.center(), around.size());
        let half = DVec3::new(size.x, 0.0, size.z) * (0.5 * PANEL_SIDE);
        let eye = view.look_at.y;
        let top = center.y + 0.5 * size.y;
        let over = |x: f64, z: f64| {
            let from = DVec3::new(center.x + x * half.x, eye, center.z + z * half.z);
            around.nearest(from, DVec3::Y).map_or(top, |hit| eye + hit.t)
        };
        let corners = [-1.0, 0.0, 1.0].map(|x| [-1.0, 0.0, 1.0].map(|z| over(x, z)));
        let ceiling = corners.into_iter().flatten().fold(top, f64::min);
        // Whatever hangs from the ceiling, the panel stays above the eye.
        let height = (ceiling - PANEL_GAP * size.y).max(0.5 * (eye + top));
        let middle = DVec3::new(center.x, height, center.z);
        let radiance = PANEL_IRRADIANCE / (PI * rectangle_form_factor(half.x, half.z, height - eye));
        notes.assume(format!(
            "nothing emits: a panel below the ceiling, {:.3} by {:.3}, radiance {radiance:.3}, lights the room",
            2.0 * half.x,
            2.0 * half.z
        ));
        Panel { low: middle - half, high: middle + half, radiance }
    }

    /// Adds it to a scene, facing down. `None` where it is lost in single precision.
    fn add(&self, mesh: &mut Mesh, materials: &mut Vec<Material>) -> Option<()> {
        let (low, high) = (self.low.as_vec3(), self.high.as_vec3());
        let radiance = self.radiance as f32;
        let extent = high - low;
        if !(extent.x > 0.0 && extent.z > 0.0 && radiance.is_finite() && extent.is_finite()) {
            return None;
        }
        let corners = [[low.x, low.z], [high.x, low.z], [high.x, high.z], [low.x, high.z]];
        let corners = corners.map(|[x, z]| [x, low.y, z]);
        mesh.add(&corners, &[[0, 1, 2], [0, 2, 3]], &[], &[], materials.len() as u32);
        materials.push(Material { name: "panel".to_owned(), emission: [radiance; 3], ..Material::default() });
        Some(())
    }
}

/// Share of what a point sees towards the centre of a parallel rectangle of half-sides a and b at distance h, weighted by the
/// cosine: four times that of a corner (Howell, catalogue of configuration factors, B-4).
fn rectangle_form_factor(a: f64, b: f64, h: f64) -> f64 {
    let (x, y) = (a / h, b / h);
    let (sx, sy) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    2.0 / PI * (x / sx * (y / sx).atan() + y / sy * (x / sy).atan())
}

/// A camera in double precision.
struct View {
    position: DVec3,
    look_at: DVec3,
    vfov: f64,
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
