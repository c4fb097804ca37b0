//! One ray, asked of every traversal that kernels use, at every width.

use crate::accel::{Brute, Mode, Packet, Shadow, Stream};
use crate::geometry::{MISS, Ray};
use crate::kernel::World;
use crate::lane::{Bits, Mask, Real, Vec3, f32x8, f32x16};

/// In the kernel's unit.
#[derive(Clone, Copy, Debug)]
pub struct OneRay {
    pub o: [f32; 3],
    pub d: [f32; 3],
}

/// The same scene with lists and with a tree.
pub struct Both {
    pub lists: World,
    pub tree: World,
}

/// t, primitive, u, v of each ray.
pub type Hits = Vec<(f32, u32, f32, f32)>;

/// Closest hits at width `R`.
pub fn closest<R: Real, M: Mode>(world: &World, rays: &[OneRay]) -> Hits {
    let mut hits = Vec::with_capacity(rays.len());
    packets::<R>(rays, |ray, active, count| {
        let hit = world.closest::<R, M>(ray, active);
        hits.extend((0..count).map(|i| (hit.t.lane(i), hit.primitive.lane(i), hit.u.lane(i), hit.v.lane(i))));
    });
    hits
}

/// Is anything hit, at width `R`?
pub fn any<R: Real, M: Mode>(world: &World, rays: &[OneRay]) -> Vec<bool> {
    let mut found = Vec::with_capacity(rays.len());
    packets::<R>(rays, |ray, active, count| {
        let hit = world.occluded::<R, M>(ray, active);
        found.extend((0..count).map(|i| hit.lane(i)));
    });
    found
}

fn packets<R: Real>(rays: &[OneRay], mut f: impl FnMut(&Ray<R>, R::Mask, usize)) {
    for chunk in rays.chunks(R::WIDTH) {
        let at = |i: usize| chunk[i.min(chunk.len() - 1)];
        let ray = Ray::new(Vec3::from_fn(|i| at(i).o), Vec3::from_fn(|i| at(i).d), R::splat(f32::INFINITY));
        f(&ray, R::Mask::from_bits(((1u64 << chunk.len()) - 1) as u32), chunk.len());
    }
}

/// What all traversals said of some rays.
#[derive(Clone, Default)]
pub struct Verdict {
    /// Answers "nothing hit", over traversals, widths and both questions.
    pub misses: u64,
    /// Rays whose hit is not, bit for bit, what lists give at width 1.
    pub unequal: u64,
    pub first: Option<String>,
    pub rays: u64,
}

impl Verdict {
    pub fn and(mut self, o: Self) -> Self {
        self.misses += o.misses;
        self.unequal += o.unequal;
        self.rays += o.rays;
        self.first = self.first.or(o.first);
        self
    }
}

/// Asks lists, packets and streams for the closest hit and for any, and shadow rays for any, at widths 1, 8 and 16.
pub fn ask(worlds: &Both, rays: &[OneRay]) -> (Verdict, Hits) {
    let reference = closest::<f32, Brute>(&worlds.lists, rays);
    let mut verdict = Verdict { rays: rays.len() as u64, ..Verdict::default() };
    verdict.hits("lists 1", rays, &reference, &reference);
    at_width::<f32>(worlds, rays, &reference, &mut verdict);
    at_width::<f32x8>(worlds, rays, &reference, &mut verdict);
    at_width::<f32x16>(worlds, rays, &reference, &mut verdict);
    (verdict, reference)
}

fn at_width<R: Real>(worlds: &Both, rays: &[OneRay], reference: &Hits, verdict: &mut Verdict) {
    if R::WIDTH > 1 {
        verdict.hits("lists", rays, &closest::<R, Brute>(&worlds.lists, rays), reference);
    }
    verdict.hits("packet", rays, &closest::<R, Packet>(&worlds.tree, rays), reference);
    verdict.hits("stream", rays, &closest::<R, Stream>(&worlds.tree, rays), reference);
    verdict.occlusion("lists any", rays, &any::<R, Brute>(&worlds.lists, rays), reference);
    verdict.occlusion("packet any", rays, &any::<R, Packet>(&worlds.tree, rays), reference);
    verdict.occlusion("stream any", rays, &any::<R, Stream>(&worlds.tree, rays), reference);
    verdict.occlusion("shadow", rays, &any::<R, Shadow>(&worlds.tree, rays), reference);
}

impl Verdict {
    fn hits(&mut self, name: &str, rays: &[OneRay], found: &Hits, reference: &Hits) {
        let bits = |h: &(f32, u32, f32, f32)| (h.0.to_bits(), h.1, h.2.to_bits(), h.3.to_bits());
        for (i, (found, expected)) in found.iter().zip(reference).enumerate() {
            self.note(name, &rays[i], found.1 == MISS, bits(found) != bits(expected));
        }
    }
    fn occlusion(&mut self, name: &str, rays: &[OneRay], found: &[bool], reference: &Hits) {
        for (i, (&found, expected)) in found.iter().zip(reference).enumerate() {
            self.note(name, &rays[i], !found, found != (expected.1 != MISS));
        }
    }
    fn note(&mut self, name: &str, ray: &OneRay, missed: bool, unequal: bool) {
        self.misses += u64::from(missed);
        self.unequal += u64::from(unequal);
        if (missed || unequal) && self.first.is_none() {
            self.first = Some(format!("{name}, {ray:?}"));
        }
    }
}
