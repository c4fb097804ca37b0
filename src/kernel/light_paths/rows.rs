//! Light paths and their connections as rows of a [`Queue`](super::super::queue::Queue).

use crate::geometry::{Hit, Ray};
use crate::lane::{Real, Vec3, array};
use crate::sampling::Sampler;

/// The light paths of one packet.
pub struct Walk<R: Real> {
    pub ray: Ray<R>,
    pub hit: Hit<R>,
    /// Radiance over density, over the number of paths.
    pub beta: Vec3<R>,
    pub rng: Sampler<R>,
    /// See [`ratio`](super::ratio): q times the cosine of the arrival.
    pub ratio: R,
    /// The number of the vertex the ray leads to: 1 for the first after the light.
    pub bounce: R,
    /// The primitive that the path started on and the cosine there.
    pub emitter: R::Bits,
    pub emitter_cos: R,
    /// Of the job.
    pub slot: R::Bits,
    pub alive: R::Mask,
}

/// Values a path keeps from vertex to vertex, and with its hit.
pub const GOING: usize = 18;
pub const HIT: usize = GOING + 4;
/// Of a connection.
pub const LINK: usize = 12;

#[inline(always)]
pub fn pack<R: Real>(walk: &Walk<R>) -> [R; GOING] {
    let (o, d, b) = (walk.ray.origin, walk.ray.direction, walk.beta);
    let [w0, w1, w2, w3] = array::map(walk.rng.words(), R::from_bits);
    let (slot, emitter) = (R::from_bits(walk.slot), R::from_bits(walk.emitter));
    let (ratio, bounce, cos) = (walk.ratio, walk.bounce, walk.emitter_cos);
    [o.x, o.y, o.z, d.x, d.y, d.z, b.x, b.y, b.z, w0, w1, w2, w3, ratio, bounce, cos, emitter, slot]
}

#[inline(always)]
pub fn pack_hits<R: Real>(walk: &Walk<R>) -> [R; HIT] {
    let mut row = [R::zero(); HIT];
    array::put(pack(walk), &mut row, 0);
    array::put([walk.hit.t, R::from_bits(walk.hit.primitive), walk.hit.u, walk.hit.v], &mut row, GOING);
    row
}

/// Paths that hit something.
#[inline(always)]
pub fn unpack_hits<R: Real>(row: &[R; HIT], alive: R::Mask) -> Walk<R> {
    let [going @ .., t, primitive, u, v] = row;
    Walk { hit: Hit { t: *t, primitive: primitive.to_bits(), u: *u, v: *v }, ..unpack(going, alive) }
}

/// Paths on their way, without a hit.
#[inline(always)]
pub fn unpack<R: Real>(row: &[R; GOING], alive: R::Mask) -> Walk<R> {
    let [ox, oy, oz, dx, dy, dz, bx, by, bz, w0, w1, w2, w3, ratio, bounce, emitter_cos, emitter, slot] = *row;
    let ray = Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_max: R::splat(f32::INFINITY) };
    Walk {
        hit: Hit::miss(ray.t_max),
        ray,
        beta: Vec3::new(bx, by, bz),
        rng: Sampler::from_words(array::map([w0, w1, w2, w3], R::to_bits)),
        ratio,
        bounce,
        emitter: emitter.to_bits(),
        emitter_cos,
        slot: slot.to_bits(),
        alive,
    }
}

/// A vertex seen by the camera, unless something is in the way.
pub struct Link<R: Real> {
    pub ray: Ray<R>,
    pub contribution: Vec3<R>,
    pub pixel: R::Bits,
    /// Lanes that carry something.
    pub carries: R::Mask,
}

#[inline(always)]
pub fn pack_link<R: Real>(link: &Link<R>, slot: R::Bits) -> [R; LINK] {
    let Ray { origin: o, direction: d, t_max } = link.ray;
    let c = link.contribution;
    [o.x, o.y, o.z, d.x, d.y, d.z, t_max, c.x, c.y, c.z, R::from_bits(link.pixel), R::from_bits(slot)]
}

#[inline(always)]
pub fn link_ray<R: Real>(row: &[R; LINK]) -> Ray<R> {
    let [ox, oy, oz, dx, dy, dz, t_max, ..] = *row;
    Ray { origin: Vec3::new(ox, oy, oz), direction: Vec3::new(dx, dy, dz), t_max }
}
