//! Paths and rays as rows of a [`Queue`](super::queue::Queue).

use super::path::{Direct, Paths};
use crate::geometry::{Hit, Ray};
use crate::lane::{Real, Vec3};
use crate::sampling::Sampler;

/// Values a path keeps from vertex to vertex, and with its hit.
pub const GOING: usize = 18;
pub const HIT: usize = GOING + 4;
/// Of a ray that left the scene, and of a shadow ray.
pub const MISSED: usize = 9;
pub const SHADOW: usize = 12;

#[inline(always)]
pub fn pack<R: Real>(paths: &Paths<R>) -> [R; GOING] {
    let (o, d, b) = (paths.ray.origin, paths.ray.direction, paths.beta);
    let [w0, w1, w2, w3] = paths.rng.words().map(R::from_bits);
    let (slot, table) = (R::from_bits(paths.slot), R::from_bits(paths.table));
    let (pdf, eta, bounce) = (paths.bsdf_pdf, paths.eta_squared, paths.bounce);
    [o.x, o.y, o.z, d.x, d.y, d.z, b.x, b.y, b.z, w0, w1, w2, w3, pdf, eta, bounce, table, slot]
}

#[inline(always)]
pub fn pack_hits<R: Real>(paths: &Paths<R>) -> [R; HIT] {
    let mut row = [R::zero(); HIT];
    row[..GOING].copy_from_slice(&pack(paths));
    row[GOING..].copy_from_slice(&[paths.hit.t, R::from_bits(paths.hit.primitive), paths.hit.u, paths.hit.v]);
    row
}

#[inline(always)]
pub fn pack_shadows<R: Real>(direct: &Direct<R>, paths: &Paths<R>) -> [R; SHADOW] {
    let Ray { origin: o, direction: d, t_max } = direct.ray;
    let c = direct.contribution;
    [o.x, o.y, o.z, d.x, d.y, d.z, t_max, c.x, c.y, c.z, R::from_bits(paths.slot), paths.bounce]
}

#[inline(always)]
pub fn shadow_ray<R: Real>(row: &[R; SHADOW]) -> Ray<R> {
    let [ox, oy, oz, dx, dy, dz, t_max, ..] = *row;
    Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_max }
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
    let [ox, oy, oz, dx, dy, dz, bx, by, bz, w0, w1, w2, w3, bsdf_pdf, eta_squared, bounce, table, slot] = *row;
    let ray = Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_max: R::splat(f32::INFINITY) };
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
