//! One first and one second vertex: with what density does the one find the other, and what does it scatter?

use super::finds::Lobe;
use super::{ROW, Row, place};
use crate::geometry::SurfacePoint;
use crate::kernel::material::MaterialAt;
use crate::kernel::path::mis_weight;
use crate::kernel::queue::Queue;
use crate::kernel::shade::Shade;
use crate::kernel::surface::{LEAST_FACING, softening};
use crate::kernel::world::World;
use crate::lane::{Real, Vec3, array};
use crate::sampling::Frame;

/// No two vertices are nearer, in units of the kernel: rounding alone is more. Its fourth power is a normal number.
const LEAST_DISTANCE_SQUARED: f32 = 1e-16;

/// The material of a row that begins with a direction and a number.
pub fn material_of<R: Real>(row: &[R; ROW]) -> MaterialAt<R> {
    MaterialAt::from_row(array::from_fn(|k| row[place::MATERIAL + k]))
}

/// A second vertex, in every lane.
pub struct Second<R: Real> {
    pub at: SurfacePoint<R>,
    pub ng: Vec3<R>,
    ns: Vec3<R>,
}

impl<R: Real> Second<R> {
    #[inline(always)]
    pub fn of(row: &Row) -> Self {
        let vector = |k: usize| Vec3::splat([row[k], row[k + 1], row[k + 2]]);
        Second { at: SurfacePoint { p: vector(0), error: vector(3) }, ng: vector(6), ns: vector(9) }
    }
}

/// First vertices.
pub struct First<R: Real> {
    p: Vec3<R>,
    /// Where rays leave.
    pub left: Vec3<R>,
    ng: Vec3<R>,
    ns: Vec3<R>,
}

impl<R: Real> First<R> {
    #[inline(always)]
    pub fn of<const N: usize, const S: usize>(rows: &Queue<R, N, S>, first: usize) -> Self {
        let vector = |k: usize| Vec3::new(rows.field(k, first), rows.field(k + 1, first), rows.field(k + 2, first));
        First { p: vector(0), left: vector(3), ng: vector(6), ns: vector(9) }
    }

    /// The way to a second vertex, its length squared, that times the cosine there, and which lanes see its side of the
    /// surface from theirs.
    #[inline(always)]
    fn way(&self, second: &Second<R>, valid: R::Mask) -> (Vec3<R>, R, R, R::Mask) {
        let way = second.at.p - self.p;
        let squared = way.length_squared();
        let (seen, zero) = (-second.ng.dot(way), R::zero());
        let valid = valid & squared.gt(R::splat(LEAST_DISTANCE_SQUARED)) & seen.gt(zero) & self.ng.dot(way).gt(zero);
        (way, squared, seen, valid)
    }

    /// π times the density, per area, of Lambert first and flat second vertices; 0 in lanes that are not valid.
    #[inline(always)]
    pub fn plain_density(&self, second: &Second<R>, valid: R::Mask) -> R {
        let (way, squared, seen, valid) = self.way(second, valid);
        let cos = self.ns.dot(way);
        (cos * seen / (squared * squared)).masked(valid & cos.gt(R::zero()))
    }

    /// Density per area (times that of the lobe, if it is the path's own way on), and what is scattered; both 0 in lanes
    /// that are not valid.
    #[inline(always)]
    pub fn scatter<S: Shade>(
        &self,
        world: &World,
        scattering: &[R; ROW],
        second: &Second<R>,
        lobe: Option<(&Row, Lobe)>,
        valid: R::Mask,
    ) -> (R, Vec3<R>) {
        let (way, squared, seen, valid) = self.way(second, valid);
        let length = squared.sqrt();
        let w = way * length.recip();
        // Where its shading normal would be turned to the first vertex, it is no shared one. (Of the way as it is, so that
        // equal normals give equal numbers.)
        let faces = -second.ns.dot(way);
        let valid = valid & faces.ge(seen.min_or(length * R::splat(LEAST_FACING))) & self.ns.dot(w).gt(R::zero());
        let frame = Frame::from_normal(self.ns);
        let wi = frame.to_local(w);
        let wo = frame.to_local(Vec3::new(scattering[0], scattering[1], scattering[2]));
        let geometry = seen / (squared * length);
        let eval = material_of(scattering).eval::<S::Models>(&world.plan, wo, wi, valid);
        let mut density = eval.pdf * geometry;
        let mut value = eval.value * geometry;
        if world.plan.shading_normals {
            value = value * softening(self.ng, self.ns, w, wi.z, wo.z);
        }
        if let Some((row, Lobe { way_on, .. })) = lobe {
            let (factor, pdf) = lobe_towards::<R, S>(world, second, row, way_on, -w, valid);
            (value, density) = (value.hadamard(factor), density * pdf);
        }
        let valid = valid & density.gt(R::zero());
        (density.masked(valid), value.masked(valid))
    }
}

/// What a lobe at a second vertex scatters towards `w`, and its density where it is a path's own way on (1 for a light
/// sample, whose weight against that is in the value).
#[inline(always)]
fn lobe_towards<R: Real, S: Shade>(
    world: &World,
    second: &Second<R>,
    lobe: &Row,
    way_on: bool,
    w: Vec3<R>,
    valid: R::Mask,
) -> (Vec3<R>, R) {
    let direction = Vec3::splat([lobe[0], lobe[1], lobe[2]]);
    let frame = Frame::from_normal(second.ns);
    let (wo, wi) = (frame.to_local(w), frame.to_local(direction));
    let material = material_of(&array::from_fn(|k| R::splat(lobe[k])));
    let eval = material.eval::<S::Models>(&world.plan, wo, wi, valid);
    let mut value = eval.value;
    if world.plan.shading_normals {
        value = value * softening(second.ng, second.ns, direction, wi.z, wo.z);
    }
    if way_on { (value, eval.pdf) } else { (value * mis_weight(R::splat(lobe[place::PDF]), eval.pdf), R::one()) }
}
