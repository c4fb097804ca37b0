//! Paths and rays as rows of a [`Queue`](super::queue::Queue).

use super::path::Paths;
use crate::geometry::{Hit, Ray};
use crate::lane::{Real, Vec3};
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
    let [w0, w1, w2, w3] = paths.rng.words().map(R::from_bits);
    let (slot, table) = (R::from_bits(paths.slot), R::from_bits(paths.table));
    let (pdf, eta, bounce) = (paths.bsdf_pdf, paths.eta_squared, paths.bounce);
    [o.x, o.y, o.z, d.x, d.y, d.z, b.x, b.y, b.z, pdf, slot, bounce, w0, w1, w2, w3, eta, table]
}

#[inline(always)]
pub fn pack_hit<R: Real>(hit: &Hit<R>) -> [R; HIT - GOING] {
    [hit.t, R::from_bits(hit.primitive), hit.u, hit.v]
}

#[inline(always)]
pub fn pack_shadows<R: Real>(ray: &Ray<R>, contribution: Vec3<R>, paths: &Paths<R>) -> [R; SHADOW] {
    let (o, d, c) = (ray.origin, ray.direction, contribution);
    [o.x, o.y, o.z, d.x, d.y, d.z, ray.t_max, c.x, c.y, c.z, R::from_bits(paths.slot), paths.bounce]
}

#[inline(always)]
pub fn shadow_ray<R: Real>(row: &[R; CONTRIBUTION]) -> Ray<R> {
    let [ox, oy, oz, dx, dy, dz, t_max] = *row;
    Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_max }
}

/// The ray of the first values of a path on its way.
#[inline(always)]
pub fn path_ray<R: Real>(row: &[R; 6]) -> Ray<R> {
    let [ox, oy, oz, dx, dy, dz] = *row;
    Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_max: R::splat(f32::INFINITY) }
}

/// Paths that hit something.
#[inline(always)]
pub fn unpack_hits<R: Real>(row: &[R; HIT], alive: R::Mask) -> Paths<R> {
    let [going @ .., t, primitive, u, v] = row;
    Paths { hit: Hit { t: *t, primitive: primitive.to_bits(), u: *u, v: *v }, ..unpack(going, alive) }
}

/// Paths on their way, without a hit.
#[inline(always)]
pub fn unpack<R: Real>(row: &[R; GOING], alive: R::Mask) -> Paths<R> {
    let [ox, oy, oz, dx, dy, dz, bx, by, bz, bsdf_pdf, slot, bounce, w0, w1, w2, w3, eta_squared, table] = *row;
    let ray = path_ray(&[ox, oy, oz, dx, dy, dz]);
    Paths {
        hit: Hit::miss(ray.t_max),
        ray,
        beta: Vec3::new(bx, by, bz),
        rng: Sampler::from_words([w0, w1, w2, w3].map(R::to_bits)),
        bsdf_pdf,
        eta_squared,
        bounce,
        table: table.to_bits(),
        slot: slot.to_bits(),
        alive,
    }
}
