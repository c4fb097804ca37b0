//! What images say at a packet's hits: texture coordinates, the material's values, the shading normal.

use super::material::MaterialAt;
use super::surface::Surface;
use super::texture::*;
use super::world::World;
use crate::geometry::Hit;
use crate::lane::math::atan2;
use crate::lane::{Mask, Real, Vec3, array};
use core::f32::consts::{FRAC_1_PI, TAU};

/// Texture coordinates of points on triangles, and what the tangents follow from.
pub(super) struct Coordinates<R> {
    pub uv: [R; 2],
    /// How they change from vertex 0 to 1, and from 0 to 2.
    along: [[R; 2]; 2],
}

/// At points of triangles with weights `u` and `v` of vertices 1 and 2; other lanes read something finite.
#[inline(always)]
pub(super) fn on_triangle<R: Real>(world: &World, hit: &Hit<R>, valid: R::Mask) -> Coordinates<R> {
    let [ax, ay, bx, by, cx, cy, ..] =
        world.texcoords.fetch::<R>(hit.primitive, valid & R::Mask::splat(world.plan.texcoords));
    let along = [[bx - ax, by - ay], [cx - ax, cy - ay]];
    let at = |k: usize, origin: R| hit.u.mul_add(along[0][k], hit.v.mul_add(along[1][k], origin));
    Coordinates { uv: [at(0, ax), at(1, ay)], along }
}

/// On spheres: u turns about +y, .5 at +z; v rises from the lowest point to the highest.
#[inline(always)]
pub(super) fn on_sphere<R: Real>(n: Vec3<R>) -> [R; 2] {
    let u = atan2(n.x, n.z).mul_add(R::splat(1.0 / TAU), R::splat(0.5));
    let across = n.x.mul_add(n.x, n.z * n.z).sqrt();
    let v = atan2(across, -n.y) * R::splat(FRAC_1_PI);
    [u, v]
}

/// Applies the images of the materials that have any.
#[inline(never)]
pub(super) fn apply<R: Real>(
    world: &World,
    surface: &mut Surface<R>,
    hit: &Hit<R>,
    material: R::Bits,
    wo: Vec3<R>,
    active: R::Mask,
) {
    let maps = world.textures.maps::<R>(material, active);
    let active = active & maps[SHADES].gt(R::zero());
    if active.none() {
        return;
    }
    let coordinates = on_triangle(world, hit, active & !surface.on_sphere);
    let mut uv = coordinates.uv;
    if (surface.on_sphere & active).any() {
        let of_sphere = on_sphere(surface.ng);
        uv = array::from_fn(|k| R::select(surface.on_sphere, of_sphere[k], uv[k]));
    }
    shade(world, &mut surface.material, &maps, uv, active);
    let bent = active & maps[NORMAL].gt(R::zero());
    if bent.any() {
        let texel = world.textures.look_up(maps[NORMAL], uv, bent);
        let tangents = Tangents::at(world, surface, hit, &coordinates, bent);
        let strength = [maps[STRENGTH], maps[STRENGTH + 1]];
        surface.ns = tangents.bend(surface, texel, strength, wo, bent);
    }
}

/// Lanes of `active` in which an image says the shading normal, which is then turned towards the viewer.
#[inline(never)]
pub(super) fn bent<R: Real>(world: &World, primitive: R::Bits, active: R::Mask) -> R::Mask {
    let [material, _] = world.tags.fetch::<R>(primitive, active);
    active & world.textures.maps::<R>(material.to_int(), active)[NORMAL].gt(R::zero())
}

/// Colours, roughness, metal and emission.
#[inline(always)]
fn shade<R: Real>(world: &World, material: &mut MaterialAt<R>, maps: &[R; 16], uv: [R; 2], active: R::Mask) {
    let table = &world.textures;
    let colour = |slot: usize| {
        let [r, g, b, _] = table.look_up(maps[slot], uv, active);
        Vec3::new(r, g, b)
    };
    material.multiply(colour(COLOUR), colour(SPECULAR), active);
    material.emission = material.emission.hadamard(colour(EMISSION));
    let mapped = active & maps[ROUGHNESS].gt(R::zero());
    let roughness = table.look_up_number(maps[ROUGHNESS], uv, mapped);
    let alpha = roughness * roughness;
    let metal =
        active & maps[METALLIC].gt(R::zero()) & table.look_up_number(maps[METALLIC], uv, active).ge(R::splat(0.5));
    material.set_alpha(mapped, alpha);
    material.make_metal(metal, R::select(mapped, alpha, maps[METAL_ALPHA]));
}

/// Tangent and bitangent of texture coordinates, about the shading normal.
struct Tangents<R: Real> {
    tangent: Vec3<R>,
    bitangent: Vec3<R>,
    /// Lanes in which the coordinates span the surface.
    usable: R::Mask,
}

impl<R: Real> Tangents<R> {
    /// The tangent is the direction in which u grows and v does not, made orthogonal to the normal; the bitangent is
    /// on the side on which v grows.
    #[inline(always)]
    fn at(world: &World, surface: &Surface<R>, hit: &Hit<R>, coordinates: &Coordinates<R>, active: R::Mask) -> Self {
        let triangle = world.triangles.fetch::<R>(hit.primitive, active & !surface.on_sphere);
        let [[u1, v1], [u2, v2]] = coordinates.along;
        let determinant = u1.mul_add(v2, -(v1 * u2));
        let sign = R::one().copysign(determinant);
        let along_u = (triangle.e1 * v2 - triangle.e2 * v1) * sign;
        let n = surface.ns;
        let along_u = Vec3::select(surface.on_sphere, Vec3::new(n.z, R::zero(), -n.x), along_u);
        let sign = R::select(surface.on_sphere, R::one(), sign);
        let flat = along_u - n * along_u.dot(n);
        let length = flat.length();
        let tangent = flat * length.recip();
        // A tangent along the normal, or of no length at all, tells nothing.
        let longest = along_u.length();
        let usable = length.gt(longest * R::splat(1e-4)) & (surface.on_sphere | !determinant.eq(R::zero()));
        Tangents { tangent, bitangent: n.cross(tangent) * sign, usable }
    }

    /// The shading normal as an image has it. Where it would face away from a viewer who sees this side, it is turned
    /// until it just does not (Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System",
    /// appendix A.3, in its simplest form): such points would else be black.
    #[inline(always)]
    fn bend(&self, surface: &Surface<R>, texel: [R; 4], strength: [R; 2], wo: Vec3<R>, active: R::Mask) -> Vec3<R> {
        let signed = |c: R| c.mul_add(R::splat(2.0), R::splat(-1.0));
        let [x, y] = [signed(texel[0]) * strength[0], signed(texel[1]) * strength[1]];
        // Below the surface points nothing that was baked.
        let z = signed(texel[2]).max_or(R::splat(MIN_Z));
        let n = self.tangent.mul_add(x, self.bitangent.mul_add(y, surface.ns * z)).normalize();
        let side = R::one().copysign(surface.ng.dot(wo));
        let towards = wo * side;
        let missing = (R::splat(MIN_COS) - n.dot(towards)).max_or(R::zero());
        let n = towards.mul_add(missing, n).normalize();
        Vec3::select(active & self.usable & n.dot(n).is_finite(), n, surface.ns)
    }
}

/// The least z of a normal map's texel.
const MIN_Z: f32 = 1.0 / 256.0;
/// The least cosine between the bent normal and the viewer.
const MIN_COS: f32 = 1.0 / 64.0;
