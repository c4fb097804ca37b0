//! The pinhole of the scene format.

use super::vec3::V3;
use octolux::scene::Scene;

/// Origin and unit direction through film coordinates (x, y) in pixels: (0, 0) is the top left corner of the image.
pub fn camera_ray(scene: &Scene, x: f64, y: f64) -> ([f64; 3], [f64; 3]) {
    let camera = &scene.camera;
    let origin = V3::of(camera.position);
    let forward = (V3::of(camera.look_at) - origin).unit();
    let right = forward.cross(V3::of(camera.up)).unit();
    let up = right.cross(forward);
    let (w, h) = (f64::from(scene.film.width), f64::from(scene.film.height));
    let half_height = (f64::from(camera.vfov).to_radians() / 2.0).tan();
    let half_width = half_height * w / h;
    let dir = forward + right * ((2.0 * x / w - 1.0) * half_width) + up * ((1.0 - 2.0 * y / h) * half_height);
    (origin.0, dir.unit().0)
}
