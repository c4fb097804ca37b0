//! What arrives along the rays of a hit.

use super::Vertex;
use super::draw::Directions;
use crate::accel::{Built, Shadow, Stream};
use crate::geometry::{MISS, Ray};
use crate::kernel::AsBuilt;
use crate::kernel::cutout;
use crate::kernel::material::AllModels;
use crate::kernel::path::Paths;
use crate::kernel::probe::NoProbe;
use crate::kernel::surface::Surface;
use crate::kernel::tile::{Counters, SampleBuffer};
use crate::kernel::wave::Wave;
use crate::kernel::world::World;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3};

/// A density so small beside any light's that a hit on a light counts for nothing: its samples have it.
const LEFT_TO_LIGHT_SAMPLES: f32 = 1e-30;

/// Rays that leave a hit.
pub(super) struct Leaving<R: Real> {
    pub ray: Ray<R>,
    /// Those that there are.
    pub carries: R::Mask,
    /// Those for which lights that they meet count: the others have light samples.
    pub direct: R::Mask,
}

/// The contributions of the rays of one hit, by index.
pub(super) struct Beams {
    values: [Vec<f32>; 3],
    count: usize,
    /// Where continued paths write their radiance.
    paths: SampleBuffer,
    scratch: Vec<f64>,
}

/// Light scattered towards the viewer, and the variance of that as its estimator believes it (0 where nobody asks).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Estimate {
    pub radiance: [f64; 3],
    pub variance: [f64; 3],
}

impl Estimate {
    pub fn add(&mut self, other: Self) {
        let sum = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        self.radiance = sum(self.radiance, other.radiance);
        self.variance = sum(self.variance, other.variance);
    }
}

impl Beams {
    pub fn new(count: usize) -> Self {
        let padded = count.next_multiple_of(MAX_WIDTH);
        Beams {
            values: std::array::from_fn(|_| vec![0.0; padded]),
            count,
            paths: SampleBuffer::default(),
            scratch: Vec::new(),
        }
    }

    /// Ends an estimate: what the rays brought, by their sum in the order of indices. `set` has their weights; without
    /// one they are samples of equal rank.
    pub fn settle(&mut self, set: Option<&Directions>, believes: bool) -> Estimate {
        let mut found = Estimate { radiance: self.sum(), variance: [0.0; 3] };
        if believes {
            found.variance = self.variance(set);
        }
        self.clear();
        found
    }

    /// The posterior's, or that of a sum of n independent terms: n s².
    #[inline(never)]
    fn variance(&mut self, set: Option<&Directions>) -> [f64; 3] {
        let Beams { values, count, scratch, .. } = self;
        values.each_ref().map(|terms| {
            let terms = &terms[..*count];
            set.and_then(|set| set.variance(terms, scratch)).unwrap_or_else(|| {
                let n = *count as f64;
                let mean = terms.iter().map(|&t| f64::from(t)).sum::<f64>() / n;
                let squares: f64 = terms.iter().map(|&t| (f64::from(t) - mean).powi(2)).sum();
                if *count > 1 { squares * n / (n - 1.0) } else { 0.0 }
            })
        })
    }

    /// What each ray of this estimate brought, by channel.
    pub fn terms(&self) -> [&[f32]; 3] {
        self.values.each_ref().map(|channel| &channel[..self.count])
    }

    /// Forgets this estimate.
    pub fn clear(&mut self) {
        self.values.iter_mut().for_each(|channel| channel.fill(0.0));
    }

    /// Adds to rays `first …`.
    #[inline(always)]
    pub fn put<R: Real>(&mut self, first: usize, value: Vec3<R>) {
        for (channel, value) in self.values.iter_mut().zip([value.x, value.y, value.z]) {
            let place = &mut channel[first..first + R::WIDTH];
            (R::load(place) + value).store(place);
        }
    }

    fn sum(&self) -> [f64; 3] {
        let mut sums = [0.0f64; 3];
        let [r, g, b] = &self.values;
        for ((r, g), b) in r.iter().zip(g).zip(b) {
            sums = [sums[0] + f64::from(*r), sums[1] + f64::from(*g), sums[2] + f64::from(*b)];
        }
        sums
    }

    /// Adds throughput · light for the lanes that carry something.
    #[inline(always)]
    pub fn add<R: Real>(
        &mut self,
        world: &World,
        vertex: &Vertex<R>,
        first: usize,
        rays: Leaving<R>,
        throughput: Vec3<R>,
        counters: &mut Counters,
    ) {
        let goes_on = world.max_bounces > 1.0;
        let carries = if goes_on { rays.carries } else { rays.carries & rays.direct };
        if carries.none() {
            return;
        }
        counters.traced(false, carries);
        let arriving = if goes_on {
            self.continued::<R>(world, vertex, first, &rays, counters)
        } else {
            seen::<R>(world, vertex, first, &rays.ray, carries)
        };
        self.put(first, throughput.hadamard(arriving).masked(carries));
    }

    /// Paths that go on from the first hit.
    #[inline(never)]
    fn continued<R: Real>(
        &mut self,
        world: &World,
        vertex: &Vertex<R>,
        first: usize,
        rays: &Leaving<R>,
        counters: &mut Counters,
    ) -> Vec3<R> {
        let Leaving { ray, carries, direct } = rays;
        let (carries, direct) = (*carries, *direct);
        let out = &mut self.paths;
        out.reset(R::WIDTH, false);
        let rng = vertex.numbers(first).0;
        let hit = cutout::closest::<R, Built<Stream>>(world, ray, &rng, R::one(), carries);
        let mut paths = Paths::begin(*ray, hit, rng, R::Bits::from_fn(|lane| lane as u32), carries);
        paths.bsdf_pdf = R::select(direct, R::splat(f32::INFINITY), R::splat(LEFT_TO_LIGHT_SAMPLES));
        paths.bounce = R::one();
        let mut start = Some(paths);
        Wave::<R, AllModels, NoProbe>::new(world, &AllModels, 1, out, counters, &mut NoProbe)
            .run::<AsBuilt>(|_| start.take());
        Vec3::from_fn(|lane| out.rgb[lane])
    }
}

/// The lights that rays meet.
#[inline(always)]
fn seen<R: Real>(world: &World, vertex: &Vertex<R>, first: usize, ray: &Ray<R>, active: R::Mask) -> Vec3<R> {
    if !world.plan.area_lights {
        // Whatever stands in the way is dark.
        if !world.plan.environment {
            return Vec3::zero();
        }
        let clear = cutout::visible::<R, Built<Shadow>, Built<Stream>>(world, ray, active);
        return world.background(ray.direction, clear.gt(R::zero())) * clear;
    }
    let hit = if world.plan.cutouts {
        cutout::closest::<R, Built<Stream>>(world, ray, &vertex.numbers(first).0, R::one(), active)
    } else {
        world.closest::<R, Built<Stream>>(ray, active)
    };
    let missed = hit.primitive.eq(R::Bits::splat(MISS)) & active;
    let found = active & !missed;
    let [_, light_row] = world.tags.fetch::<R>(hit.primitive, found);
    let emitting = found & light_row.gt(R::zero());
    let mut radiance = world.background(ray.direction, missed);
    if emitting.any() {
        radiance = radiance + Surface::at(world, ray, &hit, emitting).emitted(ray.direction, emitting);
    }
    radiance
}
