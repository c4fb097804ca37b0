//! The views: normals, distance, whether anything was hit, and the picture of [`phong`]. Camera rays alone go on.
//!
//! [`phong`]: super::phong

use super::probe::{Lanes, Probe, Stage};
use super::surface::Surface;
use super::tile::{CameraQueue, Counters, Job, SampleBuffer};
use super::world::World;
use crate::accel::{Built, Packet};
use crate::geometry::MISS;
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::scene::IntegratorKind;

/// The normal on the viewer's side.
#[inline(always)]
pub fn towards_viewer<R: Real>(n: Vec3<R>, direction: Vec3<R>) -> Vec3<R> {
    Vec3::select(n.dot(direction).gt(R::zero()), -n, n)
}

/// Renders all samples of a job: camera rays only. A miss reads 0 in every view.
pub fn render<R: Real, P: Probe>(
    world: &World,
    job: &Job,
    out: &mut SampleBuffer,
    counters: &mut Counters,
    probe: &mut P,
) {
    let mut queue = CameraQueue::<R>::new(world, job);
    while let Some(mut packet) = queue.next_packet::<Built<Packet>>(true) {
        counters.traced(true, packet.active);
        counters.shaded(packet.active);
        let lanes = Lanes { slot: packet.slot, bounce: R::zero(), active: packet.active };
        super::path::tap_hit(probe, lanes, &mut packet.hit);
        let found = packet.active & !packet.hit.primitive.eq(R::Bits::splat(MISS));
        let mut surface = Surface::at(world, &packet.ray, &packet.hit, found);
        let normal = towards_viewer(surface.ns, packet.ray.direction);
        let distance = packet.hit.t * R::splat(world.unit);
        if world.integrator.kind == IntegratorKind::Phong {
            let value = super::phong::shade::<R>(world, &packet.ray, &mut surface, found, counters);
            let value = probe.tap_rgb(Stage::Radiance, lanes, value);
            out.add(packet.slot, value, packet.active);
        } else {
            let value = geometry(world, normal, distance).masked(found);
            out.add(packet.slot, probe.tap_rgb(Stage::Radiance, lanes, value), packet.active);
        }
        if found.any() && out.features.is_some() {
            out.write_features(packet.slot, surface.material.albedo(), normal, distance, found);
        }
    }
}

/// What a view shows of a hit.
#[inline(always)]
fn geometry<R: Real>(world: &World, normal: Vec3<R>, distance: R) -> Vec3<R> {
    match world.integrator.kind {
        IntegratorKind::Normals => normal,
        IntegratorKind::Depth => {
            let depth = distance.neg_mul_add(R::splat(world.integrator.max_depth.recip()), R::one());
            Vec3::all(depth.max_or(R::zero()))
        }
        _ => Vec3::all(R::one()),
    }
}
