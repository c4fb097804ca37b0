//! Which of many lights, by where the receiver is and which way it faces.
//!
//! Power alone does not tell what a lamp at the other end of the room, or behind the receiver's back, contributes. The
//! bounds of the surfaces are divided into cubic cells; each that holds some, for each of the six ways its surfaces
//! may face most, has a table of the lights, in proportion to what they would send to a few points there if nothing
//! stood between, and for a part by power, so that no lamp is forgotten that a point off those would see. A look-up
//! is two fetches and inverts a cumulative sum (unlike the descent of a light tree: Conty Estevez & Kulla 2018); the
//! density of a lamp that a ray runs into is read from the same table.

use super::expected::{Facing, Lamp, Senders};
use super::inversion::{Choice, Inversion};
use crate::lane::{Bits, Real, Vec3};
use glam::DVec3;
use rayon::prelude::*;

/// Fewer emitting primitives than this are chosen by power: two may be one lamp.
pub const MANY_LIGHTS: usize = 3;
/// Entries of all tables together, at most: 4.5 bytes each.
const MOST_ENTRIES: usize = 1 << 22;
/// Cells along the longest side of the bounds that are tried.
const CELLS: [usize; 7] = [32, 24, 16, 12, 8, 6, 4];
/// The part of the draws by power.
const BY_POWER: f64 = 0.1;
/// Ways a surface may face most: the axes, either way.
const FACES: usize = 6;

/// What may receive light, in kernel units.
pub struct Receivers<'a> {
    /// Of vertices, in the kernel's unit.
    pub positions: &'a [[f32; 3]],
    /// Three indices into the positions each.
    pub triangles: &'a [[u32; 3]],
    /// Centre and radius, in the kernel's unit.
    pub spheres: &'a [([f32; 3], f32)],
}

/// See the module.
pub(super) struct ChoiceGrid {
    low: [f32; 3],
    per_unit: f32,
    cells: [usize; 3],
    /// The table of each cell and face; 0, by power, where nothing was expected.
    table_of: Vec<u32>,
    choice: Inversion,
    /// Of each light: numbers of the grid → times its probability by power.
    to_ratio: Vec<f32>,
}

struct Cells {
    low: DVec3,
    size: f64,
    count: [usize; 3],
    facing: Vec<Facing>,
}

impl ChoiceGrid {
    /// `None` where lights are too many for tables of a useful number.
    pub(super) fn build(lamps: &[Lamp], receivers: &Receivers) -> Option<Self> {
        let (low, high) = receivers.bounds()?;
        let side = (high - low).max_element();
        let most = MOST_ENTRIES / lamps.len();
        let fits = |&along: &usize| {
            let cells = Cells::of(receivers, low, high, side / along as f64);
            (cells.occupied().count() < most).then_some(cells)
        };
        let cells = Some(side).filter(|s| *s > 0.0 && s.is_finite()).and_then(|_| CELLS.iter().find_map(fits))?;
        Some(Self::tabulate(lamps, &cells))
    }

    fn tabulate(lamps: &[Lamp], cells: &Cells) -> Self {
        let mut table_of = vec![0; cells.facing.len()];
        let mut rows = vec![None];
        for place in cells.occupied() {
            table_of[place] = rows.len() as u32;
            rows.push(Some(&cells.facing[place]));
        }
        let mut choice = Inversion::new(rows.len(), lamps.len());
        let senders = Senders::new(lamps, cells.low, cells.size);
        choice.tables().into_par_iter().zip(&rows).for_each_init(
            || senders.room(),
            |weights, (mut table, row)| {
                weigh(lamps, &senders, row.as_deref(), weights);
                table.fill(&weights[..lamps.len()]);
            },
        );
        let ratio = |lamp: &Lamp| if lamp.probability > 0.0 { (1.0 / lamp.probability / GRID) as f32 } else { 0.0 };
        ChoiceGrid {
            low: cells.low.as_vec3().to_array(),
            per_unit: (1.0 / cells.size) as f32,
            cells: cells.count,
            table_of,
            choice,
            to_ratio: lamps.iter().map(ratio).collect(),
        }
    }

    /// With which any table chooses a light of this `probability` by power, at least: its part by power, less what rounding
    /// to the grid of numbers may take at either end, and as much for sums in single precision.
    pub(super) fn least_probability(probability: f64) -> f64 {
        BY_POWER * probability * (1.0 - 1e-5) - 2.0 / GRID
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.table_of) + self.choice.bytes() + size_of_val(&*self.to_ratio)
    }

    /// The table for receivers at `p` that face along `n`.
    #[inline(always)]
    pub(super) fn locate<R: Real>(&self, p: Vec3<R>, n: Vec3<R>) -> R::Bits {
        let along = |x: R, k: usize| {
            let cell = ((x - R::splat(self.low[k])) * R::splat(self.per_unit)).floor();
            // NaN, in lanes without a receiver, gives way to 0.
            cell.max_or(R::zero()).min_or(R::splat((self.cells[k] - 1) as f32)).to_int()
        };
        let count = |k: usize| R::Bits::splat(self.cells[k] as u32);
        let cell = (along(p.z, 2) * count(1) + along(p.y, 1)) * count(0) + along(p.x, 0);
        let (x, y, z) = (n.x.abs(), n.y.abs(), n.z.abs());
        let is_x = x.ge(y) & x.ge(z);
        let is_y = !is_x & y.ge(z);
        let most = R::select(is_x, n.x, R::select(is_y, n.y, n.z));
        let axis =
            R::Bits::select(is_x, R::Bits::splat(0), R::Bits::select(is_y, R::Bits::splat(2), R::Bits::splat(4)));
        let face = axis + R::Bits::select(most.lt(R::zero()), R::Bits::splat(1), R::Bits::splat(0));
        let place = cell * R::Bits::splat(FACES as u32) + face;
        R::Bits::from_fn(|i| self.table_of[place.lane(i) as usize])
    }

    /// A light by `u`, which `fine` in [0, 1) extends.
    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, table: R::Bits, u: R, fine: R) -> Choice<R> {
        self.choice.choose(table, u, fine)
    }

    /// How many times likelier than by power a light is.
    #[inline(always)]
    pub(super) fn ratio<R: Real>(&self, table: R::Bits, light: R::Bits) -> R {
        let share = self.choice.share::<R>(table, light);
        R::from_int(share) * R::from_fn(|i| self.to_ratio[light.lane(i) as usize])
    }
}

const GRID: f64 = (1u32 << 24) as f64;

/// The weights of the lights for surfaces of a cell; by power without any.
fn weigh(lamps: &[Lamp], senders: &Senders, facing: Option<&Facing>, weights: &mut [f32]) {
    let total = facing.map_or(0.0, |facing| senders.send(facing, weights));
    let by_power = if total > 0.0 && total.is_finite() { BY_POWER } else { 1.0 };
    let by_place = if by_power < 1.0 { (1.0 - by_power) / total } else { 0.0 };
    for (weight, lamp) in weights.iter_mut().zip(lamps) {
        let part = if by_place > 0.0 { by_place * f64::from(*weight) } else { 0.0 };
        *weight = (part + by_power * lamp.probability) as f32;
    }
}

impl Receivers<'_> {
    fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let corners = self.triangles.iter().flatten().map(|&i| (dvec(self.positions[i as usize]), 0.0));
        let spheres = self.spheres.iter().map(|(c, r)| (dvec(*c), f64::from(*r)));
        corners.chain(spheres).map(|(p, r)| (p - r, p + r)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

impl Cells {
    fn of(receivers: &Receivers, low: DVec3, high: DVec3, size: f64) -> Self {
        let count = ((high - low) / size).to_array().map(|n| (n.ceil() as usize).max(1));
        let facing = vec![Facing::default(); count.iter().product::<usize>() * FACES];
        let mut cells = Cells { low, size, count, facing };
        for triangle in receivers.triangles {
            cells.add_triangle(triangle.map(|i| dvec(receivers.positions[i as usize])));
        }
        for (center, radius) in receivers.spheres {
            cells.add_sphere(dvec(*center), f64::from(*radius));
        }
        cells
    }

    fn occupied(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.facing.len()).filter(|&i| self.facing[i].weight > 0.0)
    }

    fn add_triangle(&mut self, [a, b, c]: [DVec3; 3]) {
        let cross = (b - a).cross(c - a);
        let area = 0.5 * cross.length();
        let normal = cross.normalize_or_zero();
        let reach = 0.5 * self.size * normal.abs().element_sum();
        let weight = area.min(self.size * self.size);
        self.for_cells(a.min(b).min(c), a.max(b).max(c), |center| {
            let above = normal.dot(center - a);
            (above.abs() <= reach).then(|| (center - normal * above, normal, weight))
        });
    }

    fn add_sphere(&mut self, center: DVec3, radius: f64) {
        let reach = 0.5 * self.size * 3f64.sqrt();
        let weight = (radius * radius).min(self.size * self.size);
        self.for_cells(center - radius, center + radius, |middle| {
            let out = middle - center;
            let normal = out.normalize_or(DVec3::Y);
            ((out.length() - radius).abs() <= reach).then(|| (center + normal * radius, normal, weight))
        });
    }

    /// What `surface` has near the centre of each cell between two corners counts, from either side.
    fn for_cells(&mut self, low: DVec3, high: DVec3, surface: impl Fn(DVec3) -> Option<(DVec3, DVec3, f64)>) {
        let cell = |p: DVec3| {
            let at = ((p - self.low) / self.size).to_array();
            [0, 1, 2].map(|k| (at[k].max(0.0) as usize).min(self.count[k] - 1))
        };
        let (from, to) = (cell(low), cell(high));
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let center = self.low + self.size * (DVec3::new(x as f64, y as f64, z as f64) + 0.5);
                    let Some((point, normal, weight)) = surface(center) else { continue };
                    let cell = (z * self.count[1] + y) * self.count[0] + x;
                    for normal in [normal, -normal] {
                        let facing = &mut self.facing[cell * FACES + face(normal)];
                        facing.normal += weight * normal;
                        facing.point += weight * point;
                        facing.weight += weight;
                    }
                }
            }
        }
    }
}

/// The axis a normal lies along most, and which way.
fn face(n: DVec3) -> usize {
    let a = n.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    2 * axis + usize::from(n[axis] < 0.0)
}

fn dvec(p: [f32; 3]) -> DVec3 {
    glam::Vec3::from(p).as_dvec3()
}
