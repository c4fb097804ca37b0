//! Hyper-parameters from a fixed pilot of the scene.

use crate::accel::{Built, Packet};
use crate::estimate::bmc::{Evidence, Measure, Points, grid, polar_points, rank as rank_covariances};
use crate::geometry::{MISS, Ray};
use crate::kernel::surface::Surface;
use crate::kernel::view::towards_viewer;
use crate::kernel::world::World;
use crate::lane::{Bits, Vec3};
use crate::sampling::Frame;

/// Pixels along each side of the film whose centres are looked through.
const PIXELS: u32 = 8;
/// Directions at each hit: the same everywhere, about the normal.
const DIRECTIONS: usize = 64;

/// How well each covariance explains the light that arrives at first hits, best first; empty where it is constant or
/// nothing is hit. Emitters and environment as directions see them: what is estimated where there is one bounce.
pub fn rank(world: &World) -> Vec<Evidence> {
    let polar = polar_points(Points::Fibonacci, Measure::COSINE, DIRECTIONS, 0, 0);
    let unit: Vec<[f64; 3]> = polar
        .iter()
        .map(|&[cos, turn]| {
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let (s, c) = (std::f64::consts::TAU * turn).sin_cos();
            [sin * c, sin * s, cos]
        })
        .collect();
    let place = |k: u32, side: u32| (k as f32 + 0.5) * side as f32 / PIXELS as f32;
    let pixels =
        (0..PIXELS * PIXELS).map(|i| [place(i % PIXELS, world.film.width), place(i / PIXELS, world.film.height)]);
    let functions: Vec<Vec<f64>> = pixels.filter_map(|pixel| arriving(world, pixel, &unit)).collect();
    let varied = functions.iter().any(|y| y.iter().any(|v| *v != y[0]));
    if varied { rank_covariances(&grid(), &unit, &functions) } else { Vec::new() }
}

/// The mean over the channels of what arrives at the hit seen through a pixel.
fn arriving(world: &World, [x, y]: [f32; 2], directions: &[[f64; 3]]) -> Option<Vec<f64>> {
    let camera = world.camera.ray::<f32>(x, y);
    let hit = world.closest::<f32, Built<Packet>>(&camera, true);
    let surface = (hit.primitive.lane(0) != MISS).then(|| Surface::at(world, &camera, &hit, true))?;
    let frame = Frame::from_normal(towards_viewer(surface.ns, camera.direction));
    let light = |w: &[f64; 3]| {
        let [x, y, z] = w.map(|x| x as f32);
        let direction = frame.to_world(Vec3::new(x, y, z));
        let ray = Ray { origin: surface.leave(direction), direction, t_max: f32::INFINITY };
        let hit = world.closest::<f32, Built<Packet>>(&ray, true);
        let missed = hit.primitive.lane(0) == MISS;
        let met = Surface::at(world, &ray, &hit, !missed);
        let radiance = world.background(direction, missed) + met.emitted(direction, !missed);
        f64::from(radiance.x + radiance.y + radiance.z) / 3.0
    };
    Some(directions.iter().map(light).collect())
}
