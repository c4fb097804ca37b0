//! Veach's arrangement (1997, figure 9.2): four glossy plates below four lamps, each plate turned so that it mirrors
//! the row of lamps into the camera.

use crate::mesh::{Obj, Vec3, add, cross, normalize, scale, sub};

/// Where the scene file puts the camera, and the middle of its row of lamps.
const CAMERA: Vec3 = [0.0, 2.0, 15.0];
const LAMPS: Vec3 = [0.0, 0.0, 0.0];
/// Centres of the plates, (y, z), from the farthest to the nearest.
const CENTRES: [[f64; 2]; 4] = [[-2.4, -0.2], [-3.05, 1.0], [-3.55, 2.3], [-3.9, 3.7]];
const HALF_WIDTH: f64 = 4.0;
const HALF_DEPTH: f64 = 0.5;

pub fn obj() -> String {
    let mut obj = Obj::new(
        "Made by tools/make_scenes: four plates, a floor and a wall, facing up and towards the camera.",
        "plates.mtl",
    );
    for (i, [y, z]) in CENTRES.into_iter().enumerate() {
        obj.line(&format!("o plate{i}"));
        obj.quad(&format!("plate{i}"), plate([0.0, y, z]));
    }
    obj.line("o floor");
    obj.quad("wall", [[-10.0, -4.2, 10.0], [10.0, -4.2, 10.0], [10.0, -4.2, -2.5], [-10.0, -4.2, -2.5]]);
    obj.line("o wall");
    obj.quad("wall", [[-10.0, -4.2, -2.5], [10.0, -4.2, -2.5], [10.0, 8.0, -2.5], [-10.0, 8.0, -2.5]]);
    obj.finish()
}

/// The half vector between camera and lamps is the normal of a mirror that shows one to the other.
fn plate(centre: Vec3) -> [Vec3; 4] {
    let normal = normalize(add(normalize(sub(CAMERA, centre)), normalize(sub(LAMPS, centre))));
    let right = [1.0, 0.0, 0.0];
    let away = cross(normal, right);
    let corner = |x: f64, d: f64| add(centre, add(scale(right, x * HALF_WIDTH), scale(away, d * HALF_DEPTH)));
    // `away` points from the camera: right × away = normal only up to sign, so the order is judged by it.
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let faces = cross(sub(corners[1], corners[0]), sub(corners[3], corners[0]));
    let up = faces[0] * normal[0] + faces[1] * normal[1] + faces[2] * normal[2];
    if up > 0.0 { corners } else { [corners[3], corners[2], corners[1], corners[0]] }
}
