//! What paths leave at their vertices.

use super::{LAMBERT, LOBES, ROW, place, rows_of, write};
use crate::bsdf::Sample;
use crate::kernel::maps;
use crate::kernel::path::Paths;
use crate::kernel::surface::{LEAST_FACING, Surface};
use crate::kernel::tile::{SampleBuffer, lanes_of};
use crate::kernel::world::World;
use crate::lane::{Bits, Mask, Real, Vec3};
use crate::light::LightSample;

/// Keeps first vertices that scatter, and not at the last event of a path, by a material without delta or transmission.
#[inline(never)]
pub fn keep_first<R: Real>(
    max_bounces: f32,
    surface: Surface<R>,
    paths: &Paths<R>,
    scatters: R::Mask,
    out: &mut SampleBuffer,
) {
    let albedo = surface.material.albedo();
    // A black surface sends no path on: it stands beside no other. A coat on black is taken for one.
    let first = scatters & paths.bounce.eq(R::zero()) & R::splat(max_bounces).gt(R::one());
    let first = first & surface.material.gathers() & albedo.max_component().gt(R::zero());
    if first.none() {
        return;
    }
    let wo = -paths.ray.direction;
    let side = R::one().copysign(surface.ng.dot(wo));
    let (p, ng, ns) = (surface.at.p, surface.ng * side, surface.ns * side);
    let (left, a) = (surface.leave(ng), albedo);
    let row = [p.x, p.y, p.z, left.x, left.y, left.z, ng.x, ng.y, ng.z, ns.x, ns.y, ns.z, a.x, a.y, a.z, R::one()];
    write(&mut out.shared.first, paths.slot, &row, first);
    if !out.shared.scattering.is_empty() {
        write(&mut out.shared.scattering, paths.slot, &directed(wo, R::zero(), &surface, R::zero()), first);
    }
}

/// A direction, a number, a material, and another number.
fn directed<R: Real>(w: Vec3<R>, x: R, surface: &Surface<R>, factor: R) -> [R; ROW] {
    let [kind, ax, ay, az, bx, by, bz, alpha, separable, c] = surface.material.row();
    [w.x, w.y, w.z, x, kind, ax, ay, az, bx, by, bz, alpha, separable, c, factor, R::zero()]
}

/// Lanes of `mask` for whose slot `is` holds.
fn lanes_where<R: Real>(slot: R::Bits, mask: R::Mask, is: impl Fn(usize) -> bool) -> R::Mask {
    let holds = lanes_of(mask.bits()).filter(|&lane| is(slot.lane(lane) as usize));
    R::Mask::from_bits(holds.fold(0, |bits, lane| bits | 1 << lane))
}

/// Paths arrive at a surface (whose shading normals have not been turned to them): what they find from here on is
/// everybody's where the surface is a second vertex and Lambert, or a third, beyond a lobe that was [kept](leave). Returns
/// the lanes at second vertices that are not Lambert.
#[inline(never)]
pub fn arrive<R: Real>(
    world: &World,
    surface: Surface<R>,
    paths: &mut Paths<R>,
    scatters: R::Mask,
    out: &mut SampleBuffer,
) -> R::Mask {
    let (one, none) = (R::one(), R::Mask::splat(false));
    let third = scatters & paths.bounce.eq(one + one);
    if third.any() && !out.shared.lobes.is_empty() {
        share_third(paths, third, out);
    }
    let second = scatters & paths.bounce.eq(one) & paths.bsdf_pdf.is_finite();
    if second.none() {
        return none;
    }
    let wo = -paths.ray.direction;
    let seen = surface.ng.dot(wo);
    // Normals are kept on the viewer's side; what a dielectric scatters depends on which of the two that is.
    let second = second & !(surface.material.is_dielectric() & seen.lt(R::zero()));
    let side = one.copysign(seen);
    let ns = Vec3::select(surface.ng.dot(surface.ns).lt(R::zero()), -surface.ns, surface.ns) * side;
    // A shading normal that is turned towards who looks is another to each; those of images have been turned already.
    let second =
        if world.plan.textures { second & !maps::bent::<R>(world, paths.hit.primitive, second) } else { second };
    let second = second & seen.abs().gt(R::zero()) & ns.dot(wo).ge(seen.abs().min_or(R::splat(LEAST_FACING)));
    let second = lanes_where::<R>(paths.slot, second, |slot| out.shared.first[slot][place::VALID] != 0.0);
    if second.none() {
        return none;
    }
    let lambert = surface.material.is_lambert();
    let kind = R::select(lambert, R::splat(LAMBERT), R::splat(LOBES));
    let (p, e, ng, zero) = (surface.at.p, surface.at.error, surface.ng * side, R::zero());
    let row = [p.x, p.y, p.z, e.x, e.y, e.z, ng.x, ng.y, ng.z, ns.x, ns.y, ns.z, kind, zero, zero, zero];
    write(&mut out.shared.second, paths.slot, &row, second);
    let shared = second & lambert;
    paths.slot = R::Bits::select(shared, paths.slot + R::Bits::splat(out.shared.slots()), paths.slot);
    paths.beta = Vec3::select(shared, Vec3::all(one), paths.beta);
    second & !lambert
}

/// What paths find at third vertices and after them.
fn share_third<R: Real>(paths: &mut Paths<R>, third: R::Mask, out: &SampleBuffer) {
    let slots = out.shared.slots() as usize;
    let second = &out.shared.second;
    let third = lanes_where::<R>(paths.slot, third, |slot| slot < slots && second[slot][place::WAY_ON] != 0.0);
    for lane in lanes_of(third.bits()) {
        let slot = paths.slot.lane(lane);
        let by_roulette = second[slot as usize][place::ROULETTE];
        paths.slot.set_lane(lane, slot + 2 * slots as u32);
        paths.beta.set_lane(lane, [by_roulette; 3]);
    }
}

/// Keeps light samples at second vertices that are not Lambert: returns what arrives there by each of them, over the
/// density of the sample, and the slots that it goes to. `scattered` of it would be the path's own.
#[inline(never)]
pub fn keep_light<R: Real>(
    surface: Surface<R>,
    light: &LightSample<R>,
    scattered: Vec3<R>,
    slot: R::Bits,
    shared: R::Mask,
    out: &mut SampleBuffer,
) -> (Vec3<R>, R::Bits) {
    // Nothing else finds a light without extent.
    let pdf = R::select(light.is_delta(), R::splat(f32::INFINITY), light.pdf);
    keep_lobe(&directed(light.wi, pdf, &surface, factor(scattered)), slot, shared, place::LIGHT, out);
    (light.radiance * light.pdf.recip(), slot + R::Bits::splat(out.shared.slots()))
}

/// Keeps by what directions paths leave second vertices that are not Lambert (the lanes of `shared`); `by_roulette` is
/// what that multiplied them by.
#[inline(never)]
pub fn leave<R: Real>(
    surface: Surface<R>,
    sample: &Sample<R>,
    paths: &Paths<R>,
    by_roulette: R,
    shared: R::Mask,
    out: &mut SampleBuffer,
) {
    let shared = shared & paths.alive & !sample.delta;
    if shared.none() {
        return;
    }
    keep_lobe(
        &directed(paths.ray.direction, R::zero(), &surface, factor(sample.weight)),
        paths.slot,
        shared,
        place::WAY_ON,
        out,
    );
    for lane in lanes_of(shared.bits()) {
        out.shared.second[paths.slot.lane(lane) as usize][place::ROULETTE] = by_roulette.lane(lane);
    }
}

/// Never 0: others may see more of the lobe.
fn factor<R: Real>(scattered: Vec3<R>) -> R {
    (scattered.x + scattered.y + scattered.z) * R::splat(1.0 / 3.0) + R::splat(0.05)
}

fn keep_lobe<R: Real>(values: &[R; ROW], slot: R::Bits, shared: R::Mask, at: usize, out: &mut SampleBuffer) {
    let rows = rows_of(values);
    for lane in lanes_of(shared.bits()) {
        out.shared.lobes.push(rows[lane]);
        out.shared.second[slot.lane(lane) as usize][at] = out.shared.lobes.len() as f32;
    }
}
