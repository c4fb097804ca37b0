//! What arrives along the rays of a hit.

use super::Vertex;
use crate::geometry::{MISS, Ray};
use crate::kernel::cutout;
use crate::kernel::material::AllModels;
use crate::kernel::path::{Paths, Traversal};
use crate::kernel::probe::NoProbe;
use crate::kernel::surface::Surface;
use crate::kernel::tile::{Counters, SampleBuffer};
use crate::kernel::wave::Wave;
use crate::kernel::world::World;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3};

/// A density so small beside any light's that a hit on a light counts for nothing: its samples have it.
const LEFT_TO_LIGHT_SAMPLES: f32 = 1e-30;

/// The contributions of the rays of one hit, by index.
pub(super) struct Beams {
    values: [Vec<f32>; 3],
    /// Where continued paths write their radiance.
    paths: SampleBuffer,
}

impl Beams {
    pub fn new(count: usize) -> Self {
        let padded = count.next_multiple_of(MAX_WIDTH);
        Beams { values: std::array::from_fn(|_| vec![0.0; padded]), paths: SampleBuffer::default() }
    }

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

    /// In the order of indices.
    pub fn sum(&self) -> [f32; 3] {
        let mut sums = [0.0f64; 3];
        let [r, g, b] = &self.values;
        for ((r, g), b) in r.iter().zip(g).zip(b) {
            sums = [sums[0] + f64::from(*r), sums[1] + f64::from(*g), sums[2] + f64::from(*b)];
        }
        sums.map(|sum| sum as f32)
    }

    /// Adds throughput · light for the lanes that carry something. Lights that rays meet count in `direct` lanes: the
    /// others have light samples.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn add<R: Real, T: Traversal>(
        &mut self,
        world: &World,
        vertex: &Vertex<R>,
        first: usize,
        ray: &Ray<R>,
        throughput: Vec3<R>,
        carries: R::Mask,
        direct: R::Mask,
        counters: &mut Counters,
    ) {
        let goes_on = world.max_bounces > 1.0;
        let carries = if goes_on { carries } else { carries & direct };
        if carries.none() {
            return;
        }
        counters.traced(false, carries);
        let arriving = if goes_on {
            self.continued::<R, T>(world, vertex, first, ray, carries, direct, counters)
        } else {
            seen::<R, T>(world, vertex, first, ray, carries)
        };
        self.put(first, throughput.hadamard(arriving).masked(carries));
    }

    /// Paths that go on from the first hit.
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    fn continued<R: Real, T: Traversal>(
        &mut self,
        world: &World,
        vertex: &Vertex<R>,
        first: usize,
        ray: &Ray<R>,
        carries: R::Mask,
        direct: R::Mask,
        counters: &mut Counters,
    ) -> Vec3<R> {
        let out = &mut self.paths;
        out.reset(R::WIDTH, false);
        let rng = vertex.numbers(first).0;
        let hit = cutout::closest::<R, T::Bounce>(world, ray, &rng, R::one(), carries);
        let mut paths = Paths::begin(*ray, hit, rng, R::Bits::from_fn(|lane| lane as u32), carries);
        paths.bsdf_pdf = R::select(direct, R::splat(f32::INFINITY), R::splat(LEFT_TO_LIGHT_SAMPLES));
        paths.bounce = R::one();
        let mut start = Some(paths);
        Wave::<R, T, AllModels, NoProbe>::new(world, 1, out, counters, &mut NoProbe).run(|_| start.take());
        Vec3::from_fn(|lane| out.rgb[lane])
    }
}

/// The lights that rays meet.
#[inline(always)]
fn seen<R: Real, T: Traversal>(
    world: &World,
    vertex: &Vertex<R>,
    first: usize,
    ray: &Ray<R>,
    active: R::Mask,
) -> Vec3<R> {
    if !world.plan.area_lights {
        // Whatever stands in the way is dark.
        if !world.plan.environment {
            return Vec3::zero();
        }
        let clear = cutout::visible::<R, T::Shadow, T::Bounce>(world, ray, active);
        return world.background(ray.direction, clear.gt(R::zero())) * clear;
    }
    let hit = if world.plan.cutouts {
        cutout::closest::<R, T::Bounce>(world, ray, &vertex.numbers(first).0, R::one(), active)
    } else {
        world.closest::<R, T::Bounce>(ray, active)
    };
    let missed = hit.primitive.eq(R::Bits::splat(MISS)) & active;
    let found = active & !missed;
    // Only what can be sampled emits: the rest has no area.
    let [_, light_row] = world.tags.fetch::<R>(hit.primitive, found);
    let emitting = found & light_row.gt(R::zero());
    let mut radiance = world.background(ray.direction, missed);
    if emitting.any() {
        radiance = radiance + Surface::at(world, ray, &hit, emitting).emitted(ray.direction, emitting);
    }
    radiance
}
