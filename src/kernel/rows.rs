//! Paths and rays as rows of a [`Queue`](super::queue::Queue).

use super::path::Paths;
use crate::geometry::{Hit, Ray};
use crate::lane::{Real, Vec3, array};
use crate::sampling::Sampler;

/// Values a path keeps from vertex to vertex, and with its hit.
pub const GOING: usize = 18;
pub const HIT: usize = GOING + 4;
/// Of a ray that left the scene: what a path keeps from its direction up to its bounce.
pub const MISSED: usize = 9;
/// Where these begin.
pub const DIRECTION: usize = 3;
/// Slot and bounce begin here.
pub const NAME: usize = 10;
/// Of a shadow ray.
pub const SHADOW: usize = CONTRIBUTION + 5;
/// Its ray ends and what it carries begins here.
pub const CONTRIBUTION: usize = 7;

#[inline(always)]
pub fn pack<R: Real>(paths: &Paths<R>) -> [R; GOING] {
    let (o, d, b) = (paths.ray.origin, paths.ray.direction, paths.beta);
    let [w0, w1, w2, w3] = array::map(paths.rng.words(), R::from_bits);
    let (slot, table) = (R::from_bits(paths.slot), R::from_bits(paths.table));
    let (pdf, eta, bounce) = (paths.bsdf_pdf, paths.eta_squared, paths.bounce);
    [o.x, o.y, o.z, d.x, d.y, d.z, b.x, b.y, b.z, pdf, slot, bounce, w0, w1, w2, w3, eta, table]
}

#[inline(always)]
pub fn pack_hit<R: Real>(hit: &Hit<R>) -> [R; HIT - GOING] {
    [hit.t, R::from_bits(hit.primitive), hit.u, hit.v]
}

#[inline(always)]
pub fn pack_shadows<R: Real>(ray: &Ray<R>, contribution: Vec3<R>, slot: R::Bits, bounce: R) -> [R; SHADOW] {
    let (o, d, c) = (ray.origin, ray.direction, contribution);
    [o.x, o.y, o.z, d.x, d.y, d.z, ray.t_max, c.x, c.y, c.z, R::from_bits(slot), bounce]
}

#[inline(always)]
pub fn shadow_ray<R: Real>(row: &[R; CONTRIBUTION]) -> Ray<R> {
    let [ox, oy, oz, dx, dy, dz, t_max] = *row;
    Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_max }
}

/// The ray of a path on its way, from the fields of its row.
#[inline(always)]
pub fn path_ray<R: Real>(field: impl Fn(usize) -> R) -> Ray<R> {
    let (origin, direction) = (Vec3::new(field(0), field(1), field(2)), Vec3::new(field(3), field(4), field(5)));
    Ray { origin, direction, t_max: R::splat(f32::INFINITY) }
}

/// Paths that hit something, from the fields of their rows. (One by one: an array of all would pass through memory.)
#[inline(always)]
pub fn unpack_hits<R: Real>(field: impl Fn(usize) -> R + Copy, alive: R::Mask) -> Paths<R> {
    let (t, primitive) = (field(GOING), field(GOING + 1).masked(alive).to_bits());
    let hit = Hit { t, primitive, u: field(GOING + 2), v: field(GOING + 3) };
    Paths { hit, ..unpack(field, alive) }
}

/// Paths on their way, without a hit. Past the last row a queue holds what jobs before left there: whatever is looked up by
/// is 0 in lanes that are no rows.
#[inline(always)]
pub fn unpack<R: Real>(field: impl Fn(usize) -> R + Copy, alive: R::Mask) -> Paths<R> {
    let ray = path_ray(field);
    Paths {
        hit: Hit::miss(ray.t_max),
        ray,
        beta: Vec3::new(field(6), field(7), field(8)),
        bsdf_pdf: field(9),
        slot: field(NAME).masked(alive).to_bits(),
        bounce: field(NAME + 1),
        rng: Sampler::from_words(array::from_fn(|k| field(12 + k).to_bits())),
        eta_squared: field(16),
        table: field(17).masked(alive).to_bits(),
        alive,
    }
}
