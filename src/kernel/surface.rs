//! From a hit to a surface: point, normals, material, of all lanes at once.

use super::maps;
use super::material::MaterialAt;
use super::world::World;
use crate::geometry::{Hit, Ray, SurfacePoint, inner_weights, offset_origin, sphere_point, triangle_point};
use crate::lane::{Mask, Real, Vec3};

/// The least cosine between the viewer and a shading normal that does not face him: about 89°.
pub(super) const LEAST_FACING: f32 = 1.0 / 64.0;

/// Where a packet's rays met the scene.
///
/// What is called with a reference to it keeps all of it in memory: the functions that are not inlined get copies.
#[derive(Clone, Copy)]
pub struct Surface<R: Real> {
    /// The point and how far off it may be, in the kernel's unit.
    pub at: SurfacePoint<R>,
    /// Unit geometric normal: front of triangles (counter-clockwise), outside of spheres.
    pub ng: Vec3<R>,
    /// Unit shading normal.
    pub ns: Vec3<R>,
    /// Images already applied.
    pub material: MaterialAt<R>,
    /// Lanes that hit a sphere.
    pub on_sphere: R::Mask,
    /// What light sampling keeps of this primitive: see [`Lights::emitter_pdf_row`](crate::light::Lights::emitter_pdf_row). Above 0
    /// where it emits.
    pub light_row: R,
}

impl<R: Real> Surface<R> {
    /// Reads the rows of the lanes in `active`, all of which have a hit.
    #[inline(always)]
    pub fn at(world: &World, ray: &Ray<R>, hit: &Hit<R>, active: R::Mask) -> Self {
        let mut on_sphere = R::Mask::splat(false);
        if world.plan.spheres {
            on_sphere = world.on_sphere::<R>(hit.primitive) & active;
        }
        let on_triangle = active & !on_sphere;
        let triangle = world.triangles.fetch::<R>(hit.primitive, on_triangle);
        let (u, v) = inner_weights(&triangle, hit.u, hit.v);
        let mut surface = Surface {
            at: triangle_point(&triangle, u, v),
            ng: triangle.ng,
            ns: triangle.ng,
            material: MaterialAt::black(),
            on_sphere,
            light_row: R::zero(),
        };
        if world.plan.vertex_normals {
            surface.interpolate_normal(world, hit, on_triangle);
        }
        if on_sphere.any() {
            surface.place_on_sphere(world, ray, hit);
        }
        if world.plan.light_transport {
            let [material, light_row] = world.tags.fetch::<R>(hit.primitive, active);
            surface.material = world.materials.fetch::<R>(material.to_int(), active);
            surface.light_row = light_row;
            if world.plan.textures {
                let mut mapped = surface;
                maps::apply(world, &mut mapped, hit, material.to_int(), -ray.direction, active);
                surface = mapped;
            }
        }
        surface
    }

    /// Barycentric interpolation of the vertex normals, renormalised.
    #[inline(always)]
    fn interpolate_normal(&mut self, world: &World, hit: &Hit<R>, on_triangle: R::Mask) {
        let [ax, ay, az, bx, by, bz, cx, cy, cz] = world.normals.fetch::<R>(hit.primitive, on_triangle);
        let w = R::one() - hit.u - hit.v;
        let sum = Vec3::new(cx, cy, cz).mul_add(hit.v, Vec3::new(bx, by, bz).mul_add(hit.u, Vec3::new(ax, ay, az) * w));
        // Opposite vertex normals may cancel: the geometric normal then serves.
        let length_squared = sum.length_squared();
        let usable = length_squared.gt(R::splat(1e-12));
        let unit = sum * R::select(usable, length_squared, R::one()).sqrt().recip();
        self.ns = Vec3::select(usable & on_triangle, unit, self.ng);
    }

    #[inline(always)]
    fn place_on_sphere(&mut self, world: &World, ray: &Ray<R>, hit: &Hit<R>) {
        let sphere = world.sphere_at(hit.primitive, self.on_sphere);
        let (at, normal) = sphere_point(&sphere, ray.at(hit.t));
        self.at.p = Vec3::select(self.on_sphere, at.p, self.at.p);
        self.at.error = Vec3::select(self.on_sphere, at.error, self.at.error);
        self.ng = Vec3::select(self.on_sphere, normal, self.ng);
        self.ns = Vec3::select(self.on_sphere, normal, self.ns);
    }

    /// Radiance that the lanes of `found` emit back along a ray, from their front side.
    #[inline(always)]
    pub fn emitted(&self, direction: Vec3<R>, found: R::Mask) -> Vec3<R> {
        self.material.emission.masked(found & self.ng.dot(direction).lt(R::zero()))
    }

    /// Where a ray towards `w` leaves.
    #[inline(always)]
    pub fn leave(&self, w: Vec3<R>) -> Vec3<R> {
        offset_origin(self.at.p, self.at.error, self.ng, w)
    }

    /// Puts the shading normal on the side of the geometric one, and turns it towards a viewer who sees that side but not
    /// its own, until he just does: rims of smooth models would else be black (Keller et al. 2017, "The Iray Light
    /// Transport Simulation and Rendering System", appendix A.3, in its simplest form). Normals that agree stay bit for bit.
    #[inline(always)]
    pub fn face(&mut self, wo: Vec3<R>) {
        self.ns = facing(self.ng, self.ns, wo);
    }

    /// What a reflecting BSDF is multiplied by towards `wi` (its cosine to the shading normal `wi_z`, that of `wo` `wo_z`),
    /// so that light fades out before it grazes the geometry instead of being cut off along the edges of facets: the shadow
    /// terminator. 1 where the normals agree, and where light is transmitted.
    ///
    /// G + G² − G³ of G = min(1, (ng·wi)/((ns·wi)(ng·ns))) (Chiang, Li, Burley 2019, "Taming the Shadow Terminator"). Taken
    /// because it is a factor in [0, 1] of the BSDF: whatever samples directions stays unbiased, no energy is gained, and
    /// no ray moves. Moving its origin onto a smooth surface (Hanika 2021, "Hacking the Shadow Terminator") keeps more
    /// light, but may carry it through a wall, and it lights facets that face away, which do not count here.
    #[inline(always)]
    pub fn terminator(&self, wi: Vec3<R>, wi_z: R, wo_z: R) -> R {
        softening(self.ng, self.ns, wi, wi_z, wo_z)
    }

    /// The ray that leaves towards a unit direction.
    #[inline(always)]
    pub fn ray_towards(&self, direction: Vec3<R>) -> Ray<R> {
        Ray { origin: self.leave(direction), direction, t_max: R::splat(f32::INFINITY) }
    }

    /// The surface of one lane, in every lane.
    #[inline(always)]
    pub fn in_all_lanes(&self, lane: usize) -> Self {
        let vector = |v: &Vec3<R>| Vec3::splat(v.lane(lane));
        Surface {
            at: SurfacePoint { p: vector(&self.at.p), error: vector(&self.at.error) },
            ng: vector(&self.ng),
            ns: vector(&self.ns),
            material: self.material.in_all_lanes(lane),
            on_sphere: R::Mask::splat(self.on_sphere.lane(lane)),
            light_row: R::splat(self.light_row.lane(lane)),
        }
    }
}

/// See [`Surface::face`].
#[inline(never)]
fn facing<R: Real>(ng: Vec3<R>, ns: Vec3<R>, wo: Vec3<R>) -> Vec3<R> {
    let seen = ng.dot(wo);
    let towards = wo * R::one().copysign(seen);
    let ns = Vec3::select(ng.dot(ns).lt(R::zero()), -ns, ns);
    let missing = seen.abs().min_or(R::splat(LEAST_FACING)) - ns.dot(towards);
    let turned = towards.mul_add(missing, ns).normalize();
    Vec3::select(missing.gt(R::zero()), turned, ns)
}

/// See [`Surface::terminator`].
#[inline(never)]
pub(super) fn softening<R: Real>(ng: Vec3<R>, ns: Vec3<R>, wi: Vec3<R>, wi_z: R, wo_z: R) -> R {
    let g = (ng.dot(wi) / (wi_z * ng.dot(ns))).abs().min_or(R::one());
    let softened = g * (g * (R::one() - g) + R::one());
    let reflects = (wi_z * wo_z).gt(R::zero());
    R::select(reflects, softened, R::one())
}
