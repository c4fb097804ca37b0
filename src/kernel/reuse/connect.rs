//! First vertices of a group against the second vertices of all its paths.

use super::{ROW, Row, Shared, VALID};
use crate::geometry::{Ray, SurfacePoint, shadow_ray};
use crate::kernel::material::MaterialAt;
use crate::kernel::path::{Traversal, mis_weight};
use crate::kernel::probe::{Lanes, Probe, Stage};
use crate::kernel::queue::Queue;
use crate::kernel::shade::Shade;
use crate::kernel::surface::{LEAST_FACING, softening};
use crate::kernel::tile::{Counters, SampleBuffer};
use crate::kernel::world::World;
use crate::lane::{Bits, Mask, Real, Vec3, array};
use crate::sampling::Frame;

/// Packets of segments traced together.
const TOGETHER: usize = 8;
/// Sums are made of so many parts, whatever the number of lanes.
const PARTS: usize = 16;
/// No two vertices are nearer, in units of the kernel: rounding alone is more. Its fourth power is a normal number.
const LEAST_DISTANCE_SQUARED: f32 = 1e-16;

/// Pixels that share, at one of their samples.
pub struct Group<R: Real> {
    /// First vertices and their slots.
    first: Queue<R, { ROW + 1 }>,
    scattering: Queue<R, ROW>,
    /// Is every first vertex Lambert?
    lambert: bool,
    finds: Vec<Find>,
    /// A row a find: density with which each first vertex finds it, 0 past the last, and where a find is not
    /// [plain](Find::plain), what each would scatter of one unit, by channel.
    density: Vec<f32>,
    value: [Vec<f32>; 3],
}

/// What one path found.
struct Find {
    slot: u32,
    /// Of a second vertex that is not Lambert: which, and is it the path's own way on (or else its light sample)?
    lobe: Option<(usize, bool)>,
    /// Radiance; later over the sum of densities.
    found: [f32; 3],
    /// Do all first vertices scatter it by their albedo times their density?
    plain: bool,
}

/// Segments that wait to be traced together.
struct Segments<R: Real> {
    rays: [Ray<R>; TOGETHER],
    active: [R::Mask; TOGETHER],
    /// Where in the tables their packets are, and do they have values there?
    places: [(usize, bool); TOGETHER],
    count: usize,
}

impl<R: Real> Group<R> {
    pub fn new(pixels: usize) -> Self {
        let room = pixels.next_multiple_of(PARTS);
        Group {
            first: Queue::new(room),
            scattering: Queue::new(room),
            lambert: true,
            finds: Vec::with_capacity(2 * pixels),
            density: Vec::new(),
            value: [const { Vec::new() }; 3],
        }
    }

    /// With the first vertices of `slots` and no find.
    pub fn begin(&mut self, slots: &[u32], shared: &Shared) {
        self.first.clear();
        self.scattering.clear();
        self.finds.clear();
        self.lambert = true;
        for slots in slots.chunks(R::WIDTH) {
            let slot = R::Bits::from_fn(|lane| slots[lane.min(slots.len() - 1)]);
            let row = R::fetch_rows(&shared.first, slot);
            let valid = row[VALID].gt(R::zero()) & R::Mask::from_bits(((1u64 << slots.len()) - 1) as u32);
            self.first.push(valid, &array::from_fn(|k| if k < ROW { row[k] } else { R::from_bits(slot) }));
            if !shared.scattering.is_empty() {
                let row = R::fetch_rows(&shared.scattering, slot);
                self.lambert = self.lambert && (valid & !material_of(&row).is_lambert()).none();
                self.scattering.push(valid, &row);
            }
        }
    }

    /// Adds what the path of a slot found.
    pub fn add(&mut self, slot: u32, lobe: Option<(usize, bool)>, found: [f32; 3]) {
        self.finds.push(Find { slot, lobe, found, plain: false });
    }

    /// Adds to each pixel what it would have scattered of all finds.
    pub fn connect<T: Traversal, S: Shade, P: Probe>(
        &mut self,
        world: &World,
        out: &mut SampleBuffer,
        counters: &mut Counters,
        probe: &mut P,
    ) {
        if self.first.is_empty() || self.finds.is_empty() {
            return;
        }
        let stride = self.first.len().next_multiple_of(PARTS);
        for table in core::iter::once(&mut self.density).chain(&mut self.value) {
            let room = stride * self.finds.len();
            if table.len() < room {
                table.resize(room, 0.0);
            }
        }
        self.weigh::<T, S>(world, &out.shared, stride, counters);
        for (find, row) in self.finds.iter_mut().zip(self.density.chunks_exact(stride)) {
            let sum = in_parts(row);
            let scale = if sum > 0.0 { sum.recip() } else { 0.0 };
            find.found = find.found.map(|x| x * scale);
        }
        self.scatter(stride, out, probe);
    }

    /// Fills the tables.
    fn weigh<T: Traversal, S: Shade>(
        &mut self,
        world: &World,
        shared: &Shared,
        stride: usize,
        counters: &mut Counters,
    ) {
        let mut segments = Segments::new();
        for (k, find) in self.finds.iter_mut().enumerate() {
            let second = Second::of(&shared.second[find.slot as usize]);
            let lobe = find.lobe.map(|(lobe, bounce)| (&shared.lobes[lobe], bounce));
            find.plain = self.lambert && lobe.is_none() && !world.plan.shading_normals;
            for first in (0..stride).step_by(R::WIDTH) {
                let at = k * stride + first;
                if first >= self.first.len() {
                    R::zero().store(&mut self.density[at..]);
                    continue;
                }
                let vertex = First::of(&self.first, first);
                let valid = self.first.rows(first);
                let (density, value) = if find.plain {
                    (vertex.plain_density(&second, valid), None)
                } else {
                    let scattering = array::from_fn(|k| self.scattering.field(k, first));
                    let (density, value) = vertex.scatter::<S>(world, &scattering, &second, lobe, valid);
                    (density, Some(value))
                };
                density.store(&mut self.density[at..]);
                for (table, value) in self.value.iter_mut().zip(value.map(|v| [v.x, v.y, v.z]).into_iter().flatten()) {
                    value.store(&mut table[at..]);
                }
                let ray = shadow_ray(vertex.left, &second.at, second.ng);
                if segments.add(ray, density.gt(R::zero()), at, !find.plain) {
                    segments.trace::<T>(world, &mut self.density, &mut self.value, counters);
                }
            }
        }
        segments.trace::<T>(world, &mut self.density, &mut self.value, counters);
    }

    /// Sums over the finds.
    fn scatter<P: Probe>(&self, stride: usize, out: &mut SampleBuffer, probe: &mut P) {
        for first in (0..self.first.len()).step_by(R::WIDTH) {
            let (mut plain, mut sum) = (Vec3::<R>::zero(), Vec3::<R>::zero());
            for (k, find) in self.finds.iter().enumerate() {
                let (at, found) = (k * stride + first, Vec3::splat(find.found));
                if find.plain {
                    plain = found.mul_add(R::load(&self.density[at..]), plain);
                } else {
                    let [x, y, z] = [0, 1, 2].map(|c| R::load(&self.value[c][at..]));
                    sum = sum + found.hadamard(Vec3::new(x, y, z));
                }
            }
            let [x, y, z] = self.first.fields(12, first);
            let sum = sum + plain.hadamard(Vec3::new(x, y, z));
            let (slot, active) = (self.first.field(ROW, first).to_bits(), self.first.rows(first));
            let sum = probe.tap_rgb(Stage::Shared, Lanes { slot, bounce: R::zero(), active }, sum);
            out.add(slot, sum, active);
        }
    }
}

/// The sum of a row, in an order that is the same at any number of lanes.
fn in_parts(row: &[f32]) -> f32 {
    let mut sums = [0f32; PARTS];
    for part in row.chunks_exact(PARTS) {
        for (sum, x) in sums.iter_mut().zip(part) {
            *sum += x;
        }
    }
    let mut half = PARTS / 2;
    while half > 0 {
        for i in 0..half {
            sums[i] += sums[i + half];
        }
        half /= 2;
    }
    sums[0]
}

fn material_of<R: Real>(row: &[R; ROW]) -> MaterialAt<R> {
    MaterialAt::from_row(array::from_fn(|k| row[4 + k]))
}

/// A second vertex, in every lane.
struct Second<R: Real> {
    at: SurfacePoint<R>,
    ng: Vec3<R>,
    ns: Vec3<R>,
}

impl<R: Real> Second<R> {
    #[inline(always)]
    fn of(row: &Row) -> Self {
        let vector = |k: usize| Vec3::splat([row[k], row[k + 1], row[k + 2]]);
        Second { at: SurfacePoint { p: vector(0), error: vector(3) }, ng: vector(6), ns: vector(9) }
    }
}

/// First vertices.
struct First<R: Real> {
    p: Vec3<R>,
    left: Vec3<R>,
    ng: Vec3<R>,
    ns: Vec3<R>,
}

impl<R: Real> First<R> {
    #[inline(always)]
    fn of<const N: usize>(rows: &Queue<R, N>, first: usize) -> Self {
        let vector = |k: usize| Vec3::new(rows.field(k, first), rows.field(k + 1, first), rows.field(k + 2, first));
        First { p: vector(0), left: vector(3), ng: vector(6), ns: vector(9) }
    }

    /// The way to a second vertex, its length squared, that times the cosine there, and which lanes see its side of the
    /// surface from theirs.
    #[inline(always)]
    fn way(&self, second: &Second<R>, valid: R::Mask) -> (Vec3<R>, R, R, R::Mask) {
        let way = second.at.p - self.p;
        let squared = way.length_squared();
        let (seen, zero) = (-second.ng.dot(way), R::zero());
        let valid = valid & squared.gt(R::splat(LEAST_DISTANCE_SQUARED)) & seen.gt(zero) & self.ng.dot(way).gt(zero);
        (way, squared, seen, valid)
    }

    /// π times the density, per area, of Lambert first and flat second vertices; 0 in lanes that are not valid.
    #[inline(always)]
    fn plain_density(&self, second: &Second<R>, valid: R::Mask) -> R {
        let (way, squared, seen, valid) = self.way(second, valid);
        let cos = self.ns.dot(way);
        (cos * seen / (squared * squared)).masked(valid & cos.gt(R::zero()))
    }

    /// Density per area (times that of the lobe, if it is the path's own way on), and what is scattered; both 0 in lanes
    /// that are not valid.
    #[inline(always)]
    fn scatter<S: Shade>(
        &self,
        world: &World,
        scattering: &[R; ROW],
        second: &Second<R>,
        lobe: Option<(&Row, bool)>,
        valid: R::Mask,
    ) -> (R, Vec3<R>) {
        let (way, squared, seen, valid) = self.way(second, valid);
        let length = squared.sqrt();
        let w = way * length.recip();
        // Where its shading normal would be turned to the first vertex, it is no shared one.
        let faces = -second.ns.dot(w);
        let valid = valid & faces.ge((seen / length).min_or(R::splat(LEAST_FACING))) & self.ns.dot(w).gt(R::zero());
        let frame = Frame::from_normal(self.ns);
        let wi = frame.to_local(w);
        let wo = frame.to_local(Vec3::new(scattering[0], scattering[1], scattering[2]));
        let geometry = seen / (squared * length);
        let eval = material_of(scattering).eval::<S::Models>(&world.plan, wo, wi, valid);
        let mut density = eval.pdf * geometry;
        let mut value = eval.value * geometry;
        if world.plan.shading_normals {
            value = value * softening(self.ng, self.ns, w, wi.z, wo.z);
        }
        if let Some((lobe, bounce)) = lobe {
            let (factor, pdf) = lobe_towards::<R, S>(world, second, lobe, bounce, -w, valid);
            (value, density) = (value.hadamard(factor), density * pdf);
        }
        let valid = valid & density.gt(R::zero());
        (density.masked(valid), value.masked(valid))
    }
}

/// What a lobe at a second vertex scatters towards `w`, and its density where it is a path's own way on (1 for a light
/// sample, whose weight against that is in the value).
#[inline(always)]
fn lobe_towards<R: Real, S: Shade>(
    world: &World,
    second: &Second<R>,
    lobe: &Row,
    bounce: bool,
    w: Vec3<R>,
    valid: R::Mask,
) -> (Vec3<R>, R) {
    let direction = Vec3::splat([lobe[0], lobe[1], lobe[2]]);
    let frame = Frame::from_normal(second.ns);
    let (wo, wi) = (frame.to_local(w), frame.to_local(direction));
    let material = material_of(&array::from_fn(|k| R::splat(lobe[k])));
    let eval = material.eval::<S::Models>(&world.plan, wo, wi, valid);
    let mut value = eval.value;
    if world.plan.shading_normals {
        value = value * softening(second.ng, second.ns, direction, wi.z, wo.z);
    }
    if bounce { (value, eval.pdf) } else { (value * mis_weight(R::splat(lobe[3]), eval.pdf), R::one()) }
}

impl<R: Real> Segments<R> {
    fn new() -> Self {
        let nowhere = Ray::new(Vec3::zero(), Vec3::zero(), R::zero());
        Segments {
            rays: [nowhere; TOGETHER],
            active: [R::Mask::splat(false); TOGETHER],
            places: [(0, false); TOGETHER],
            count: 0,
        }
    }

    /// Are there enough now?
    #[inline(always)]
    fn add(&mut self, ray: Ray<R>, active: R::Mask, place: usize, values: bool) -> bool {
        if active.any() {
            self.rays[self.count] = ray;
            self.active[self.count] = active;
            self.places[self.count] = (place, values);
            self.count += 1;
        }
        self.count == TOGETHER
    }

    /// Traces them; what is hidden is cleared in the tables.
    #[inline(always)]
    fn trace<T: Traversal>(
        &mut self,
        world: &World,
        density: &mut [f32],
        values: &mut [Vec<f32>; 3],
        counters: &mut Counters,
    ) {
        let mut occluded = [R::Mask::splat(false); TOGETHER];
        let count = core::mem::take(&mut self.count);
        world.occluded_many::<R, T::Shadow>(&self.rays[..count], &self.active[..count], &mut occluded[..count]);
        for k in 0..count {
            let (at, has_values) = self.places[k];
            counters.shadow(self.active[k]);
            let clear = |table: &mut [f32]| R::load(table).masked(!occluded[k]).store(table);
            clear(&mut density[at..]);
            if has_values {
                values.iter_mut().for_each(|table| clear(&mut table[at..]));
            }
        }
    }
}
