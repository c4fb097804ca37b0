//! First vertices of a group against the second vertices of all its paths.

use super::finds::{Find, Lobe};
use super::group::PIXELS;
use super::pairs::{First, Second, material_of};
use super::segments::Segments;
use super::{ROW, Row, Shared, place};
use crate::geometry::shadow_ray;
use crate::kernel::probe::{Lanes, Probe, Stage};
use crate::kernel::queue::Queue;
use crate::kernel::shade::Shade;
use crate::kernel::tile::{Counters, SampleBuffer};
use crate::kernel::world::World;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3, array};

/// Sums are made of so many parts, whatever the number of lanes.
pub const PARTS: usize = 16;

/// A find as all first vertices see it.
pub struct Seen<'a, R: Real> {
    second: Second<R>,
    lobe: Option<(&'a Row, Lobe)>,
    /// Do all first vertices scatter it by their albedo times their density?
    plain: bool,
}

/// Pixels that share, at one of their samples.
pub struct Group<R: Real> {
    /// First vertices and their slots.
    first: Queue<R, { ROW + 1 }, { PIXELS + MAX_WIDTH }>,
    scattering: Queue<R, ROW, { PIXELS + MAX_WIDTH }>,
    /// Is every first vertex Lambert?
    lambert: bool,
    pub finds: Vec<Find>,
    /// A row a find: density with which each first vertex finds it, 0 past the last, and where a find is not
    /// [plain](Find::plain), what each would scatter of one unit, by channel.
    density: Vec<f32>,
    value: [Vec<f32>; 3],
}

impl<R: Real> Group<R> {
    pub fn new() -> Self {
        Group {
            first: Queue::new(),
            scattering: Queue::new(),
            lambert: true,
            finds: Vec::with_capacity(2 * PIXELS),
            density: Vec::new(),
            value: [const { Vec::new() }; 3],
        }
    }

    /// With the first vertices of `slots`.
    pub fn begin(&mut self, slots: &[u32], shared: &Shared) {
        self.first.clear();
        self.scattering.clear();
        self.lambert = true;
        for slots in slots.chunks(R::WIDTH) {
            let slot = R::Bits::from_fn(|lane| slots[lane.min(slots.len() - 1)]);
            let row = R::fetch_rows(&shared.first, slot);
            let valid = row[place::VALID].gt(R::zero()) & R::Mask::from_bits(((1u64 << slots.len()) - 1) as u32);
            self.first.push(valid, &array::from_fn(|k| if k < ROW { row[k] } else { R::from_bits(slot) }));
            if !shared.scattering.is_empty() {
                let row = R::fetch_rows(&shared.scattering, slot);
                self.lambert = self.lambert && (valid & !material_of(&row).is_lambert()).none();
                self.scattering.push(valid, &row);
            }
        }
    }

    /// Adds to each pixel what it would have scattered of all finds.
    pub fn connect<S: Shade, P: Probe>(
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
        self.weigh::<S>(world, &out.shared, stride, counters);
        for (find, row) in self.finds.iter_mut().zip(self.density.chunks_exact(stride)) {
            let sum = in_parts(row);
            let scale = if sum > 0.0 { sum.recip() } else { 0.0 };
            find.found = array::map(find.found, |x| x * scale);
        }
        self.scatter(stride, out, probe);
    }

    /// First vertices.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// A find before [weighing](Self::connect).
    pub fn look<'a>(&self, world: &World, shared: &'a Shared, find: &Find) -> Seen<'a, R> {
        let lobe = find.lobe.map(|lobe| (&shared.lobes[lobe.row], lobe));
        let plain = self.lambert && lobe.is_none() && !world.plan.shading_normals;
        Seen { second: Second::of(&shared.second[find.slot as usize]), lobe, plain }
    }

    /// With what density the first vertices from `first` on find it, and what each scatters of one unit; that is its albedo
    /// times the density where there is no value.
    #[inline(always)]
    fn scattered<S: Shade>(
        &self,
        world: &World,
        vertex: &First<R>,
        seen: &Seen<R>,
        first: usize,
    ) -> (R, Option<Vec3<R>>) {
        let valid = self.first.rows(first);
        if seen.plain {
            return (vertex.plain_density(&seen.second, valid), None);
        }
        let scattering = array::from_fn(|k| self.scattering.field(k, first));
        let (density, value) = vertex.scatter::<S>(world, &scattering, &seen.second, seen.lobe, valid);
        (density, Some(value))
    }

    /// The same with the value in any case, and whatever is in the way.
    #[inline(always)]
    pub fn scattered_unhidden<S: Shade>(&self, world: &World, seen: &Seen<R>, first: usize) -> (R, Vec3<R>) {
        let (density, value) = self.scattered::<S>(world, &First::of(&self.first, first), seen, first);
        let [x, y, z] = self.first.fields(place::ALBEDO, first);
        (density, value.unwrap_or(Vec3::new(x, y, z) * density))
    }

    /// Fills the tables.
    fn weigh<S: Shade>(&mut self, world: &World, shared: &Shared, stride: usize, counters: &mut Counters) {
        let mut segments = Segments::new();
        for k in 0..self.finds.len() {
            let seen = self.look(world, shared, &self.finds[k]);
            self.finds[k].plain = seen.plain;
            for first in (0..stride).step_by(R::WIDTH) {
                let at = k * stride + first;
                if first >= self.first.len() {
                    R::zero().store(&mut self.density[at..]);
                    continue;
                }
                let vertex = First::of(&self.first, first);
                let (density, value) = self.scattered::<S>(world, &vertex, &seen, first);
                density.store(&mut self.density[at..]);
                for (table, value) in self.value.iter_mut().zip(value.map(|v| [v.x, v.y, v.z]).into_iter().flatten()) {
                    value.store(&mut table[at..]);
                }
                let ray = shadow_ray(vertex.left, &seen.second.at, seen.second.ng);
                if segments.add(ray, density.gt(R::zero()), at, !seen.plain) {
                    segments.trace(world, &mut self.density, &mut self.value, counters);
                }
            }
        }
        segments.trace(world, &mut self.density, &mut self.value, counters);
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
                    let [x, y, z] = array::from_fn(|c| R::load(&self.value[c][at..]));
                    sum = sum + found.hadamard(Vec3::new(x, y, z));
                }
            }
            let [x, y, z] = self.first.fields(place::ALBEDO, first);
            let sum = sum + plain.hadamard(Vec3::new(x, y, z));
            let (slot, active) = (self.first.field(ROW, first).to_bits(), self.first.rows(first));
            let sum = probe.tap_rgb(Stage::Shared, Lanes { slot, bounce: R::zero(), active }, sum);
            out.add(slot, sum, active);
        }
    }
}

/// The sum of a row, in an order that is the same at any number of lanes.
pub fn in_parts(row: &[f32]) -> f32 {
    let mut sums = [0f32; PARTS];
    for part in row.as_chunks::<PARTS>().0 {
        sums = array::from_fn(|k| sums[k] + part[k]);
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
