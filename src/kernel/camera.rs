//! The thin-lens camera in lanes.

use crate::geometry::Ray;
use crate::lane::{Bits, Real, Vec3, array};
use crate::sampling::warp;
use crate::scene::{self, FilmSize};

/// A camera ready for the kernel, in rescaled units.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    position: [f32; 3],
    /// Through the centre of the film.
    forward: [f32; 3],
    /// From the centre of the film to its right edge, at unit distance.
    right: [f32; 3],
    /// From the centre of the film to its top edge, at unit distance.
    up: [f32; 3],
    /// From the centre of the lens to its right and top edges; zero for a pinhole.
    lens: [[f32; 3]; 2],
    focus_distance: f32,
    /// 2 / film size in pixels.
    pixel: [f32; 2],
    /// The inverse: pixels to the right and down for a point at unit distance along `forward`.
    to_film: [[f32; 3]; 2],
    film: FilmSize,
    /// Pixels in a unit of area at unit distance.
    pixel_density: f32,
}

/// Where on the film the camera sees a point.
pub struct Seen<R: Real> {
    /// Row by row from the top left; 0 in lanes that are not `inside`.
    pub pixel: R::Bits,
    /// See [`Camera::importance`].
    pub importance: R,
    /// Lanes seen by some pixel.
    pub inside: R::Mask,
}

impl Camera {
    /// `scale` is the power of two by which the scene is rescaled.
    pub fn new(camera: &scene::Camera, film: FilmSize, scale: f32) -> Self {
        let v = |a: [f32; 3]| glam::DVec3::new(a[0] as f64, a[1] as f64, a[2] as f64);
        let forward = (v(camera.look_at) - v(camera.position)).normalize();
        let right = forward.cross(v(camera.up)).normalize();
        let up = right.cross(forward);
        let half_height = (camera.vfov as f64 / 2.0).to_radians().tan();
        let half_width = half_height * film.width as f64 / film.height as f64;
        let f = |a: glam::DVec3| [a.x as f32, a.y as f32, a.z as f32];
        Camera {
            position: camera.position.map(|x| x * scale),
            forward: f(forward),
            right: f(right * half_width),
            up: f(up * half_height),
            lens: [right, up].map(|axis| f(axis * (camera.lens_radius as f64 * scale as f64))),
            focus_distance: camera.focus_distance * scale,
            pixel: [2.0 / film.width as f32, 2.0 / film.height as f32],
            to_film: [
                f(right * (0.5 * film.width as f64 / half_width)),
                f(up * (-0.5 * film.height as f64 / half_height)),
            ],
            film,
            pixel_density: (film.width as f64 * film.height as f64 / (4.0 * half_width * half_height)) as f32,
        }
    }

    /// The density per solid angle with which a pixel's rays, from one point of the lens, take the unit direction `d`,
    /// where they do: 1/(A cos³θ) for a pixel of area A at unit distance.
    #[inline(always)]
    pub fn importance<R: Real>(&self, d: Vec3<R>) -> R {
        let cos = d.dot(Vec3::splat(self.forward));
        R::splat(self.pixel_density) / (cos * cos * cos)
    }

    /// A point of the lens, as [`Camera::lens_ray`] takes it.
    #[inline(always)]
    pub fn eye<R: Real>(&self, lens: bool, u: [R; 2]) -> Vec3<R> {
        let position = Vec3::splat(self.position);
        if lens { position + self.off_axis(u) } else { position }
    }

    /// The pixel whose rays from the point `eye` of the lens take the unit direction `d`.
    #[inline(always)]
    pub fn project<R: Real>(&self, eye: Vec3<R>, d: Vec3<R>) -> Seen<R> {
        let cos = d.dot(Vec3::splat(self.forward));
        let ahead = cos.gt(R::zero());
        // In the plane of focus all rays of a film position meet.
        let off_axis = (eye - Vec3::splat(self.position)) * R::splat(self.focus_distance.recip());
        let at_unit = d * cos.recip() + off_axis;
        let at = |axis: usize, size: u32| at_unit.dot(Vec3::splat(self.to_film[axis])) + R::splat(0.5 * size as f32);
        let (x, y) = (at(0, self.film.width), at(1, self.film.height));
        let (width, height) = (R::splat(self.film.width as f32), R::splat(self.film.height as f32));
        let inside = ahead & x.ge(R::zero()) & x.lt(width) & y.ge(R::zero()) & y.lt(height);
        let whole = |x: R| x.floor().masked(inside).to_int();
        let pixel = whole(y) * R::Bits::splat(self.film.width) + whole(x);
        Seen { pixel, importance: self.importance(d), inside }
    }

    /// Rays through film positions in pixels from the top left corner and the centre of the lens. Directions are unit.
    #[inline(always)]
    pub fn ray<R: Real>(&self, x: R, y: R) -> Ray<R> {
        let direction = self.through(x, y).normalize();
        Ray { origin: Vec3::splat(self.position), direction, t_max: R::splat(f32::INFINITY) }
    }

    /// The same from a point of the lens, uniform for uniform `u`: all rays of a film position meet in the plane of focus.
    #[inline(never)]
    pub fn lens_ray<R: Real>(&self, x: R, y: R, u: [R; 2]) -> Ray<R> {
        let off_axis = self.off_axis(u);
        let to_focus = self.through(x, y).mul_add(R::splat(self.focus_distance), -off_axis);
        let origin = Vec3::splat(self.position) + off_axis;
        Ray { origin, direction: to_focus.normalize(), t_max: R::splat(f32::INFINITY) }
    }

    /// From the centre of the lens to a point of it.
    #[inline(always)]
    fn off_axis<R: Real>(&self, u: [R; 2]) -> Vec3<R> {
        let [lens_x, lens_y] = warp::uniform_disk(u);
        let [right, up] = array::map(self.lens, Vec3::splat);
        right.mul_add(lens_x, up * lens_y)
    }

    /// Through a film position, reaching 1 along the viewing direction.
    #[inline(always)]
    fn through<R: Real>(&self, x: R, y: R) -> Vec3<R> {
        let sx = x.mul_add(R::splat(self.pixel[0]), R::splat(-1.0));
        let sy = y.neg_mul_add(R::splat(self.pixel[1]), R::one());
        Vec3::splat(self.right).mul_add(sx, Vec3::splat(self.up).mul_add(sy, Vec3::splat(self.forward)))
    }
}
