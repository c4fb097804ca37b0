//! Random scenes and rays, and one way to ask every mode at every width.

use octolux::accel::{Accel, Brute, BuildOptions, Mode, Packet, Preset, Shadow, Single, Stream};
use octolux::geometry::{Hit, MISS, Ray};
use octolux::lane::{Bits, Mask, Real, Vec3, f32x8, f32x16};
use rand_xoshiro::Xoshiro128PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

pub struct Random(Xoshiro128PlusPlus);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / 16_777_216.0
    }
    /// Uniform in [−1, 1).
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }
    pub fn below(&mut self, n: usize) -> usize {
        self.0.next_u32() as usize % n
    }
    pub fn point(&mut self, scale: f32) -> [f32; 3] {
        [(); 3].map(|_| scale * self.signed())
    }
}

#[derive(Clone, Debug, Default)]
pub struct Shapes {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub spheres: Vec<([f32; 3], f32)>,
}

impl Shapes {
    pub fn push(&mut self, v: [[f32; 3]; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(v);
        self.triangles.push([first, first + 1, first + 2]);
    }
    pub fn vertices(&self, i: usize) -> [[f32; 3]; 3] {
        self.triangles[i].map(|k| self.positions[k as usize])
    }
    pub fn build(&self, options: BuildOptions) -> Accel {
        Accel::build(&self.positions, &self.triangles, &self.spheres, options)
    }
    pub fn everything(&self, preset: Preset) -> Accel {
        self.build(BuildOptions { lists: true, trees: true, preset })
    }
    /// Triangles of edge about `size` (with a share of slivers) and spheres, all inside (−1.9, 1.9).
    pub fn random(triangles: usize, spheres: usize, size: f32, rng: &mut Random) -> Self {
        let mut shapes = Self::default();
        for i in 0..triangles {
            let p = rng.point(1.5);
            let spread = if i % 16 == 3 { 0.3 } else { size };
            let mut v = [p; 3].map(|p| p.map(|x| x + spread * rng.signed()));
            if i % 11 == 5 {
                v[2] = v[1].map(|x| x + 1e-5 * rng.signed());
            }
            shapes.push(v);
        }
        for _ in 0..spheres {
            shapes.spheres.push((rng.point(1.5), 0.01 + 0.2 * rng.unit()));
        }
        shapes
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneRay {
    pub o: [f32; 3],
    pub d: [f32; 3],
    pub t_max: f32,
}

/// t, primitive, u, v as bits.
pub type Found = (u32, u32, u32, u32);

pub fn missed(ray: &OneRay) -> Found {
    (ray.t_max.to_bits(), MISS, 0, 0)
}

/// All rays through one mode at one width; rays that `live` denies are dead lanes.
pub fn ask<R: Real, M: Mode>(accel: &Accel, rays: &[OneRay], live: impl Fn(usize) -> bool) -> Vec<(Found, bool)> {
    let mut out = Vec::new();
    for (c, chunk) in rays.chunks(R::WIDTH).enumerate() {
        let at = |i: usize| chunk[i.min(chunk.len() - 1)];
        let ray = Ray::<R>::new(Vec3::from_fn(|i| at(i).o), Vec3::from_fn(|i| at(i).d), R::from_fn(|i| at(i).t_max));
        let bits = (0..chunk.len()).filter(|i| live(c * R::WIDTH + i)).fold(0, |bits, i| bits | 1 << i);
        let active = R::Mask::from_bits(bits);
        let hit = accel.trace::<R, M>(&ray, active);
        let any = accel.occluded::<R, M>(&ray, active);
        for i in 0..chunk.len() {
            let bits = |x: R| x.lane(i).to_bits();
            out.push(((bits(hit.t), hit.primitive.lane(i), bits(hit.u), bits(hit.v)), any.lane(i)));
        }
    }
    out
}

/// [`ask`] of all packets at once, as the path kernel does.
pub fn ask_many<R: Real, M: Mode>(accel: &Accel, rays: &[OneRay]) -> Vec<(Found, bool)> {
    let lanes = R::WIDTH;
    let at = |k: usize| rays[k.min(rays.len() - 1)];
    let starts = || (0..rays.len()).step_by(lanes);
    let packet = |first: usize| {
        let ray = |i: usize| at(first + i);
        Ray::<R>::new(Vec3::from_fn(|i| ray(i).o), Vec3::from_fn(|i| ray(i).d), R::from_fn(|i| ray(i).t_max))
    };
    let live = |first: usize| R::Mask::from_bits((0..lanes).fold(0, |b, i| b | u32::from(first + i < rays.len()) << i));
    let (packets, active): (Vec<_>, Vec<_>) = starts().map(|first| (packet(first), live(first))).unzip();
    let mut hits = vec![Hit::<R>::miss(R::zero()); packets.len()];
    let mut found = vec![R::Mask::splat(false); packets.len()];
    accel.trace_many::<R, M>(&packets, &active, &mut hits);
    accel.occluded_many::<R, M>(&packets, &active, &mut found);
    let one = |k: usize| {
        let (hit, lane) = (&hits[k / lanes], k % lanes);
        let bits = |x: R| x.lane(lane).to_bits();
        ((bits(hit.t), hit.primitive.lane(lane), bits(hit.u), bits(hit.v)), found[k / lanes].lane(lane))
    };
    (0..rays.len()).map(one).collect()
}

/// Asks every mode at every width and asserts that all agree with brute force at width 1, which is returned.
pub fn ask_all(accels: &[&Accel], rays: &[OneRay]) -> Vec<(Found, bool)> {
    let reference = ask::<f32, Brute>(accels[0], rays, |_| true);
    let same = |name: &str, got: Vec<(Found, bool)>| {
        for (i, (got, want)) in got.iter().zip(&reference).enumerate() {
            assert_eq!(got, want, "{name}: ray {i} {:?}", rays[i]);
        }
    };
    for (k, accel) in accels.iter().enumerate() {
        same(&format!("tree {k} brute 8"), ask::<f32x8, Brute>(accel, rays, |_| true));
        same(&format!("tree {k} brute 16"), ask::<f32x16, Brute>(accel, rays, |_| true));
        same(&format!("tree {k} single 1"), ask::<f32, Single>(accel, rays, |_| true));
        same(&format!("tree {k} single 8"), ask::<f32x8, Single>(accel, rays, |_| true));
        same(&format!("tree {k} single 16"), ask::<f32x16, Single>(accel, rays, |_| true));
        same(&format!("tree {k} stream 1"), ask::<f32, Stream>(accel, rays, |_| true));
        same(&format!("tree {k} stream 8"), ask::<f32x8, Stream>(accel, rays, |_| true));
        same(&format!("tree {k} stream 16"), ask::<f32x16, Stream>(accel, rays, |_| true));
        same(&format!("tree {k} packet 1"), ask::<f32, Packet>(accel, rays, |_| true));
        same(&format!("tree {k} packet 8"), ask::<f32x8, Packet>(accel, rays, |_| true));
        same(&format!("tree {k} packet 16"), ask::<f32x16, Packet>(accel, rays, |_| true));
        same(&format!("tree {k} shadow 1"), ask::<f32, Shadow>(accel, rays, |_| true));
        same(&format!("tree {k} shadow 8"), ask::<f32x8, Shadow>(accel, rays, |_| true));
        same(&format!("tree {k} shadow 16"), ask::<f32x16, Shadow>(accel, rays, |_| true));
        same(&format!("tree {k} streams 8"), ask_many::<f32x8, Stream>(accel, rays));
        same(&format!("tree {k} streams 16"), ask_many::<f32x16, Stream>(accel, rays));
        same(&format!("tree {k} packets 8"), ask_many::<f32x8, Packet>(accel, rays));
        same(&format!("tree {k} packets 16"), ask_many::<f32x16, Packet>(accel, rays));
        same(&format!("tree {k} shadows 1"), ask_many::<f32, Shadow>(accel, rays));
        same(&format!("tree {k} shadows 8"), ask_many::<f32x8, Shadow>(accel, rays));
        same(&format!("tree {k} shadows 16"), ask_many::<f32x16, Shadow>(accel, rays));
    }
    for (i, ((hit, any), ray)) in reference.iter().zip(rays).enumerate() {
        assert_eq!(hit.1 != MISS, *any, "closest and any hit disagree on ray {i} {ray:?}");
    }
    reference
}
