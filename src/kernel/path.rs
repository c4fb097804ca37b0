//! The path estimator: emission, next-event estimation and scattering at every vertex, combined by multiple
//! importance sampling (Veach 1997, chapter 9; power heuristic), with unbiased Russian roulette.
//!
//! What happens at one vertex, for the paths of a packet: [`Wave`](super::wave::Wave) brings them there and sends them on.
//! Every random number is a function of (seed, pixel, sample, dimension), and a path adds to its own slot: which lane it
//! ran in leaves no trace.

use super::direct::{by_lights_alone, sample_direct};
use super::light_paths::ratio::{Arrival, reversed_pdf, weight_against};
use super::probe::{Lanes, Probe, Stage};
use super::queue::Queue;
use super::reuse;
use super::roulette::roulette;
use super::rows::SHADOW;
use super::shade::Shade;
use super::surface::Surface;
use super::tile::SampleBuffer;
use super::world::World;
use crate::accel::Mode;
use crate::bsdf::Sample;
use crate::geometry::{Hit, Ray};
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::light::{sphere_pdf, triangle_pdf};
use crate::sampling::dimensions::*;
use crate::sampling::{Frame, Sampler};

/// How a kernel finds geometry.
pub trait Traversal: 'static {
    /// For camera rays, which are coherent.
    type Camera: Mode;
    /// For rays after a bounce.
    type Bounce: Mode;
    /// For shadow rays.
    type Shadow: Mode;
}

/// The paths of one packet.
#[derive(Clone, Copy)]
pub struct Paths<R: Real> {
    pub ray: Ray<R>,
    pub hit: Hit<R>,
    pub beta: Vec3<R>,
    pub rng: Sampler<R>,
    /// Solid-angle pdf with which the ray was sampled; infinite for camera rays and after a delta.
    pub bsdf_pdf: R,
    /// Product of the relative indices of refraction along the path, squared.
    pub eta_squared: R,
    pub bounce: R,
    /// From which [table](crate::light::Lights::table_at) of lights the vertex chose that the ray left.
    pub table: R::Bits,
    pub slot: R::Bits,
    pub alive: R::Mask,
}

impl<R: Real> Paths<R> {
    /// Paths about to leave along `ray`, as a camera's.
    #[inline(always)]
    pub(super) fn begin(ray: Ray<R>, hit: Hit<R>, rng: Sampler<R>, slot: R::Bits, alive: R::Mask) -> Self {
        Paths {
            ray,
            hit,
            beta: Vec3::all(R::one()),
            rng,
            bsdf_pdf: R::splat(f32::INFINITY),
            eta_squared: R::one(),
            bounce: R::zero(),
            table: R::Bits::splat(0),
            slot,
            alive,
        }
    }

    #[inline(always)]
    pub(super) fn lanes(&self, active: R::Mask) -> Lanes<R> {
        Lanes { slot: self.slot, bounce: self.bounce, active }
    }
}

/// A vertex of each path of a packet, ready to scatter: what is there, from where it is seen, and its random numbers.
pub(super) struct PathVertex<'a, R: Real, S> {
    pub world: &'a World,
    pub shade: &'a S,
    pub surface: &'a Surface<R>,
    /// About the shading normal.
    pub frame: Frame<R>,
    /// Whence the path came, in the frame.
    pub wo: Vec3<R>,
    pub u: [R; BOUNCE],
}

/// What lanes do at a vertex.
#[derive(Clone, Copy)]
pub(super) struct Doing<R: Real> {
    /// Scatter light samples.
    pub lit: R::Mask,
    /// And a ray by the material, which may find the same light.
    pub scatter: R::Mask,
    /// Keep what comes of either for all pixels of their block.
    pub shared: R::Mask,
}

/// One vertex of every path, all of which hit something: adds what it emits, samples a light, and scatters; lanes that go
/// on stay alive. Shadow rays of lanes that carry something are pushed. Inlined where the paths are unpacked, so that they
/// need not pass through memory.
#[inline(always)]
pub(super) fn vertex<R: Real, S: Shade, P: Probe>(
    world: &World,
    shade: &S,
    paths: &mut Paths<R>,
    out: &mut SampleBuffer,
    shadows: &mut Queue<R, SHADOW>,
    probe: &mut P,
) {
    let alive = paths.alive;
    let mut surface = Surface::at(world, &paths.ray, &paths.hit, alive);
    if out.features.is_some() {
        write_features(world, *paths, surface, alive, out);
    }
    let arrival = Arrival::new(world, paths, &surface, out);
    if world.plan.area_lights {
        add_emission(world, shade, paths, &surface, arrival.as_ref(), out, probe);
    }
    let scatters = alive & paths.bounce.lt(R::splat(world.max_bounces));
    let outward = -paths.ray.direction;
    let mut shared = R::Mask::splat(false);
    if world.plan.path_reuse {
        shared = reuse::arrive(world, surface, paths, scatters, out);
    }
    if world.plan.shading_normals {
        surface.face(outward);
    }
    let frame = Frame::from_normal(surface.ns);
    let wo = frame.to_local(outward);
    // A direction counts only where its sides against both normals agree; the viewer's no less than others.
    let facing = surface.ng.dot(outward);
    let scatters = scatters & same_side(wo.z, facing);
    if let Some(lights) = world.lights.as_ref().filter(|lights| lights.has_grid()) {
        let n = Vec3::select(facing.lt(R::zero()), -surface.ng, surface.ng);
        paths.table = lights.table_at(surface.at.p, n);
    }
    if world.plan.path_reuse {
        reuse::keep_first(world.max_bounces, surface, paths, scatters, out);
    }
    let scatter = scatters & !by_lights_alone(world, paths, &surface, scatters);
    let doing = Doing { lit: scatters, scatter, shared };
    let u = numbers(world, paths, scatter, probe);
    let at = PathVertex { world, shade, surface: &surface, frame, wo, u };
    if (world.lights.is_some() || S::OWN_LIGHT) && scatters.any() {
        sample_direct(&at, paths, doing, arrival.as_ref(), shadows, out, probe);
    }
    if scatter.none() && shared.none() {
        paths.alive = scatter;
        return;
    }
    let (sample, carried) = at.scatter(paths, doing, probe);
    if let Some(arrival) = arrival.filter(|_| paths.alive.any()) {
        let back = reversed_pdf(world, shade, paths.hit, surface, [wo, sample.wi], paths.alive & !sample.delta);
        arrival.leave(surface, sample, [wo.z, back], *paths, out);
    }
    let by_roulette = roulette(world, paths, carried, u[ROULETTE], probe);
    if shared.any() {
        reuse::leave(surface, &sample, paths, by_roulette, shared, out);
    }
}

/// The numbers of a vertex; of lanes that are not to scatter none but those for light samples.
#[inline(always)]
fn numbers<R: Real, P: Probe>(world: &World, paths: &mut Paths<R>, scatters: R::Mask, probe: &mut P) -> [R; BOUNCE] {
    let mut rng = paths.rng;
    let mut u = world.vertex_numbers(&mut rng, paths.bounce, scatters.any());
    paths.rng = rng;
    if P::ACTIVE {
        for k in [BSDF_LOBE, BSDF_DIRECTION, BSDF_DIRECTION + 1, ROULETTE] {
            u[k] = u[k].masked(scatters);
        }
        u[OPACITY] = R::zero();
        let lanes = paths.lanes(paths.alive);
        for x in &mut u {
            *x = probe.tap(Stage::Random, lanes, *x);
        }
    }
    u
}

#[inline(always)]
pub(super) fn tap_hit<R: Real, P: Probe>(probe: &mut P, lanes: Lanes<R>, hit: &mut Hit<R>) {
    hit.t = probe.tap(Stage::HitT, lanes, hit.t);
    hit.primitive = probe.tap(Stage::HitPrimitive, lanes, R::from_bits(hit.primitive)).to_bits();
    hit.u = probe.tap(Stage::HitU, lanes, hit.u);
    hit.v = probe.tap(Stage::HitV, lanes, hit.v);
}

/// Are both on the same, strictly one, side?
#[inline(always)]
pub(super) fn same_side<R: Real>(a: R, b: R) -> R::Mask {
    (a.gt(R::zero()) & b.gt(R::zero())) | (a.lt(R::zero()) & b.lt(R::zero()))
}

/// Power heuristic for one sample of each technique, in the form that neither over- nor underflows. Domain: `pdf` above 0, up to 1e30
/// or infinite (a delta: weight 1); `other` from 0.
#[inline(always)]
pub fn mis_weight<R: Real>(pdf: R, other: R) -> R {
    let ratio = other / pdf;
    ratio.mul_add(ratio, R::one()).recip()
}

/// Radiance of an emitter that a ray ran into, from its front side.
#[inline(always)]
fn add_emission<R: Real, S: Shade, P: Probe>(
    world: &World,
    shade: &S,
    paths: &Paths<R>,
    surface: &Surface<R>,
    arrival: Option<&Arrival<R>>,
    out: &mut SampleBuffer,
    probe: &mut P,
) {
    let cos_light = -surface.ng.dot(paths.ray.direction);
    let emitting = paths.alive & cos_light.gt(R::zero()) & surface.material.emission.max_component().gt(R::zero());
    if emitting.none() {
        return;
    }
    let mut pdf = triangle_pdf(surface.light_row, paths.hit.t, cos_light);
    let on_sphere = emitting & surface.on_sphere;
    if on_sphere.any() {
        let sphere = world.sphere_at(paths.hit.primitive, on_sphere);
        let of_sphere = sphere_pdf(surface.light_row, sphere.center, sphere.radius, paths.ray.origin);
        pdf = R::select(on_sphere, of_sphere, pdf);
    }
    if let Some(lights) = world.lights.as_ref().filter(|lights| lights.has_grid()) {
        pdf = pdf * lights.choice_ratio(paths.hit.primitive, paths.table, emitting);
    }
    let pdf = shade.scene_light_pdf(world, pdf);
    let weight = match arrival {
        None => mis_weight(paths.bsdf_pdf, pdf),
        Some(arrival) => {
            let light_path = arrival.at_light(world, paths.hit, surface.light_row, emitting);
            weight_against(pdf / paths.bsdf_pdf, light_path)
        }
    };
    let contribution = paths.beta.hadamard(surface.material.emission) * weight;
    let contribution = probe.tap_rgb(Stage::Emission, paths.lanes(emitting), contribution);
    out.add(paths.slot, contribution, emitting);
}

impl<R: Real, S: Shade> PathVertex<'_, R, S> {
    /// Samples the material and sends the path on, or ends it. Returns the sample, and what decides on the path's end: what it
    /// carries, or where it goes on for all pixels that share it, what it would if it began at this vertex. (What is left of it by
    /// the first vertex of its own pixel says nothing of what others see of it: may be nothing.)
    #[inline(always)]
    fn scatter<P: Probe>(&self, paths: &mut Paths<R>, doing: Doing<R>, probe: &mut P) -> (Sample<R>, Vec3<R>) {
        let PathVertex { world, shade, surface, frame, wo, u } = self;
        let numbers = [u[BSDF_LOBE], u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]];
        let sample = shade.sample(world, &paths.hit, surface, *wo, numbers, doing.scatter);
        let direction = frame.to_world(sample.wi);
        let goes_on = doing.scatter & sample.valid & same_side(sample.wi.z, surface.ng.dot(direction));
        let lanes = paths.lanes(goes_on);
        let mut weight = sample.weight;
        if world.plan.shading_normals {
            let softened = surface.terminator(direction, sample.wi.z, wo.z);
            weight = weight * R::select(sample.delta, R::one(), softened);
        }
        let weight = probe.tap_rgb(Stage::BsdfWeight, lanes, weight);
        let pdf = probe.tap(Stage::BsdfPdf, lanes, sample.pdf);
        paths.beta = paths.beta.hadamard(weight);
        paths.bsdf_pdf = R::select(sample.delta, R::splat(f32::INFINITY), pdf);
        paths.eta_squared = paths.eta_squared * sample.eta * sample.eta;
        let carried = Vec3::select(doing.shared & !sample.delta, weight, paths.beta);
        paths.alive = goes_on & carried.max_component().gt(R::zero());
        paths.ray = surface.ray_towards(direction);
        (sample, carried)
    }
}

/// Albedo, shading normal towards the viewer and distance of the first hit.
#[inline(never)]
fn write_features<R: Real>(
    world: &World,
    paths: Paths<R>,
    surface: Surface<R>,
    on_surface: R::Mask,
    out: &mut SampleBuffer,
) {
    let first = on_surface & paths.bounce.eq(R::zero());
    if first.any() {
        let normal = super::view::towards_viewer(surface.ns, paths.ray.direction);
        let distance = paths.hit.t * R::splat(world.unit);
        out.write_features(paths.slot, surface.material.albedo(), normal, distance, first);
    }
}
