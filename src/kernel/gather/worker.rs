//! The estimate at one first hit.

use super::draw::Directions;
use super::lobe::{self, Parts};
use super::shrink::Watch;
use super::tables::GatherTables;
use super::trace::{Beams, Estimate, Leaving};
use super::{About, LOBE_RAYS, Vertex};
use crate::accel::{Built, Shadow, Stream};
use crate::geometry::Ray;
use crate::kernel::cutout;
use crate::kernel::direct::{behind, light_ray};
use crate::kernel::material::AllModels;
use crate::kernel::path::same_side;
use crate::kernel::pattern;
use crate::kernel::tile::Counters;
use crate::kernel::world::World;
use crate::lane::{Mask, Real, Vec3};
use crate::sampling::Frame;
use crate::sampling::dimensions::*;
use crate::scene::{GatherLights, GatherPdf};

/// What a thread keeps between hits.
pub(super) struct Worker<'a> {
    world: &'a World,
    tables: &'a GatherTables,
    drawn: Directions,
    beams: Beams,
    /// In a pilot: every set is turned, all weights are equal, and what the others would have given is noted.
    pub watch: Option<Watch>,
}

impl<'a> Worker<'a> {
    pub fn new(world: &'a World, tables: &'a GatherTables, watch: Option<Watch>) -> Self {
        let (drawn, beams) = (Directions::new(tables.count()), Beams::new(tables.count()));
        Worker { world, tables, drawn, beams, watch }
    }
}

impl Worker<'_> {
    pub fn estimate<R: Real>(&mut self, mut vertex: Vertex<R>, counters: &mut Counters) -> Estimate {
        let (tables, believes) = (self.tables, self.world.plan.posterior);
        let sampled = tables.settings.lights == GatherLights::Sampled;
        let mut found = Estimate::default();
        let delta = vertex.surface.material.is_delta::<AllModels>().any();
        // A pilot looks at weights alone.
        if self.watch.is_none() && !delta && self.world.lights.is_some() && (sampled || self.world.plan.delta_lights) {
            self.add_lights::<R>(&vertex, sampled, counters);
            found.add(self.beams.settle(None, believes));
        }
        if !vertex.surface.material.gathers().any() {
            self.scatter::<R>(&vertex, sampled, counters);
            found.add(self.beams.settle(None, believes));
        } else if !sampled || self.world.max_bounces > 1.0 {
            self.turn(&mut vertex);
            if tables.settings.pdf == GatherPdf::Lobe {
                found.add(self.gather_parts::<R>(&mut vertex, sampled, counters));
            } else {
                let material = vertex.surface.material.in_all_lanes(0);
                let about_normal = About { family: &tables.base, material: &material, without: None, lobe: None };
                found.add(self.gather::<R>(&vertex, &about_normal, sampled, counters));
            }
        }
        found
    }

    /// A Lambert base about the normal, a glossy lobe about the mirror direction.
    #[inline(never)]
    fn gather_parts<R: Real>(&mut self, vertex: &mut Vertex<R>, sampled: bool, counters: &mut Counters) -> Estimate {
        let tables = self.tables;
        let mut found = Estimate::default();
        let Parts { base, lobe, below } = Parts::of(&vertex.surface.material, &self.world.plan);
        if let Some(material) = &base {
            let without = lobe.as_ref().filter(|_| below).map(|(material, _)| material);
            let about = About { family: &tables.base, material, without, lobe: None };
            found.add(self.gather::<R>(vertex, &about, sampled, counters));
        }
        if let Some((material, kind)) = &lobe {
            let family = kind.nearest(&tables.lobe_kinds).map_or(&tables.base, |i| &tables.lobes[i]);
            vertex.first_ray = LOBE_RAYS;
            let mirror = lobe::mirror_frame(vertex, tables.settings.rotate || self.watch.is_some());
            let about = About { family, material, without: None, lobe: Some(mirror) };
            found.add(self.gather::<R>(vertex, &about, sampled, counters));
        }
        found
    }

    /// Turns the tangents about the normal.
    #[inline(always)]
    fn turn<R: Real>(&self, vertex: &mut Vertex<R>) {
        if !self.tables.settings.rotate && self.watch.is_none() {
            return;
        }
        let (sin, cos) = crate::lane::math::sincos_2pi(R::splat(vertex.u[ROTATION]));
        let Frame { tangent, bitangent, normal } = vertex.frame;
        let turned = tangent.mul_add(cos, bitangent * sin);
        vertex.frame = Frame { tangent: turned, bitangent: bitangent.mul_add(cos, tangent * -sin), normal };
        vertex.wo = Vec3::new(
            vertex.wo.x.mul_add(cos, vertex.wo.y * sin),
            vertex.wo.y.mul_add(cos, vertex.wo.x * -sin),
            vertex.wo.z,
        );
    }

    /// Weighted directions of a point set.
    fn gather<R: Real>(
        &mut self,
        vertex: &Vertex<R>,
        about: &About<R>,
        sampled: bool,
        counters: &mut Counters,
    ) -> Estimate {
        let Worker { world, tables, drawn, beams, watch } = self;
        let fresh = watch.as_ref().is_some_and(|watch| watch.fresh);
        let set = about.family.at(tables, vertex, drawn, fresh);
        let equal = watch.is_some().then(|| R::splat(set.equal_weight(about.family.measure)));
        let surface = &vertex.surface;
        let up = R::one().copysign(vertex.wo.z);
        let direct = R::Mask::splat(!sampled);
        for first in (0..tables.count()).step_by(R::WIDTH) {
            let active = first_lanes::<R>(tables.count() - first);
            let [x, y, z, weight, p] = set.load::<R>(first);
            let wi = match &about.lobe {
                None => Vec3::new(x, y, z * up),
                Some(mirror) => mirror.to_world(Vec3::new(x, y, z)),
            };
            let direction = vertex.frame.to_world(wi);
            let keep = active & same_side(wi.z, surface.ng.dot(direction));
            let mut f_cos = about.material.eval::<AllModels>(&world.plan, vertex.wo, wi, keep).value;
            if let Some(elsewhere) = about.without {
                f_cos = f_cos - elsewhere.eval::<AllModels>(&world.plan, vertex.wo, wi, keep).value;
            }
            let mut weight = equal.unwrap_or(weight) / p;
            if world.plan.shading_normals {
                weight = weight * surface.terminator(direction, wi.z, vertex.wo.z);
            }
            let throughput = f_cos * weight;
            let ray = Ray { origin: surface.leave(direction), direction, t_max: R::splat(f32::INFINITY) };
            let carries = keep & throughput.max_component().abs().gt(R::zero());
            beams.add::<R>(world, vertex, first, Leaving { ray, carries, direct }, throughput, counters);
        }
        if let Some(watch) = watch {
            watch.see(about.family, set, beams);
        }
        beams.settle(Some(set), world.plan.posterior)
    }

    /// Directions that the material draws: a delta lobe has no others, and glass has some on both sides.
    fn scatter<R: Real>(&mut self, vertex: &Vertex<R>, sampled: bool, counters: &mut Counters) {
        let Worker { world, tables, beams, .. } = self;
        let surface = &vertex.surface;
        let share = R::splat(tables.count() as f32).recip();
        for first in (0..tables.count()).step_by(R::WIDTH) {
            let active = first_lanes::<R>(tables.count() - first);
            let (_, u) = vertex.numbers(first);
            let u_direction = [u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]];
            let material = &surface.material;
            let sample = material.sample::<AllModels>(&world.plan, vertex.wo, u[BSDF_LOBE], u_direction, active);
            let direction = vertex.frame.to_world(sample.wi);
            let keep = active & sample.valid & same_side(sample.wi.z, surface.ng.dot(direction));
            let mut share = share;
            if world.plan.shading_normals {
                let softened = surface.terminator(direction, sample.wi.z, vertex.wo.z);
                share = share * R::select(sample.delta, R::one(), softened);
            }
            let throughput = sample.weight * share;
            let direct = sample.delta | R::Mask::splat(!sampled);
            let ray = Ray { origin: surface.leave(direction), direction, t_max: R::splat(f32::INFINITY) };
            let carries = keep & throughput.max_component().gt(R::zero());
            beams.add::<R>(world, vertex, first, Leaving { ray, carries, direct }, throughput, counters);
        }
    }

    /// n light samples. Unless lights are `sampled`, those without extent alone: the others are seen.
    fn add_lights<R: Real>(&mut self, vertex: &Vertex<R>, sampled: bool, counters: &mut Counters) {
        let Worker { world, tables, beams, .. } = self;
        let surface = &vertex.surface;
        let share = R::splat(tables.count() as f32).recip();
        for first in (0..tables.count()).step_by(R::WIDTH) {
            let active = first_lanes::<R>(tables.count() - first);
            let (_, u) = vertex.numbers(first);
            let u_position = [u[LIGHT_POSITION], u[LIGHT_POSITION + 1]];
            let Some(mut light) = world.sample_light(surface.at.p, None, u[LIGHT_CHOICE], u_position, active) else {
                return;
            };
            if world.plan.patterned_lights {
                pattern::look_up(world, &mut light, active);
            }
            let wi = vertex.frame.to_local(light.wi);
            let lit = active & light.pdf.gt(R::zero()) & same_side(wi.z, surface.ng.dot(light.wi));
            let lit = lit & !behind(world, surface, &light);
            let lit = if sampled { lit } else { lit & light.is_delta() };
            let f_cos = surface.material.eval::<AllModels>(&world.plan, vertex.wo, wi, lit).value;
            let mut weight = share / light.pdf;
            if world.plan.shading_normals {
                weight = weight * surface.terminator(light.wi, wi.z, vertex.wo.z);
            }
            let contribution = f_cos.hadamard(light.radiance) * weight;
            let carries = lit & contribution.max_component().gt(R::zero());
            if carries.none() {
                continue;
            }
            counters.shadow(carries);
            let clear = cutout::visible::<R, Built<Shadow>, Built<Stream>>(world, &light_ray(surface, &light), carries);
            beams.put(first, (contribution * clear).masked(carries));
        }
    }
}

/// As many lanes as there are directions left.
#[inline(always)]
fn first_lanes<R: Real>(left: usize) -> R::Mask {
    R::Mask::from_bits(((1u64 << left.min(R::WIDTH)) - 1) as u32)
}
