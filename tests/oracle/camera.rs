//! The thin lens of the scene format.

use super::vec3::V3;
use crate::stats::Rng;
use octolux::scene::Scene;

/// Origin and unit direction from the centre of the lens through film coordinates (x, y) in pixels: (0, 0) is the top left corner of the image.
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

/// The same from a random point of the lens: a point of the unit square that falls into its circle.
pub fn lens_ray(scene: &Scene, x: f64, y: f64, rng: &mut Rng) -> ([f64; 3], [f64; 3]) {
    let (origin, dir) = camera_ray(scene, x, y);
    let radius = f64::from(scene.camera.lens_radius);
    if radius == 0.0 {
        return (origin, dir);
    }
    let (origin, dir) = (V3(origin), V3(dir));
    let forward = (V3::of(scene.camera.look_at) - origin).unit();
    let focus = origin + dir * (f64::from(scene.camera.focus_distance) / dir.dot(forward));
    let [a, b] = loop {
        let point = [rng.range(-1.0, 1.0), rng.range(-1.0, 1.0)];
        if point[0].hypot(point[1]) < 1.0 {
            break point;
        }
    };
    let right = forward.cross(V3::of(scene.camera.up)).unit();
    let on_lens = origin + (right * a + right.cross(forward) * b) * radius;
    (on_lens.0, (focus - on_lens).unit().0)
}
