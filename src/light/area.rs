//! The emitting primitives: one row each, chosen by power.

use super::alias::MAX_ENTRIES;
use super::by_power::ByPower;
use super::expected::Lamp;
use super::grid::{ChoiceGrid, MANY_LIGHTS, Receivers};
use super::inversion::Choice;
use super::pairs::{self, Paired};
use super::reach::{FEW_EMITTERS, Reach};
use super::row::{CENTER, E1, E2, LaneRows, NG, P0, PDF_ROW, RADIANCE, RADIUS, Row, row};
use super::sample::LightPoint;
use super::slope::{self, Sloped, Slopes};
use super::sphere::sphere_pdf;
use super::triangle::triangle_pdf;
use super::{Emitter, EmitterShape, LightError};
use crate::geometry::Rows;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3, array};
use crate::sampling::warp;
use glam::DVec3;
use std::f64::consts::PI;

/// A point on an area light.
pub(super) struct AreaSample<R: Real> {
    pub point: LightPoint<R>,
    pub radiance: Vec3<R>,
    pub primitive: R::Bits,
    /// See [`LightSample::place`](super::LightSample::place).
    pub place: [R; 2],
}

/// A place on a light that was chosen.
struct Place<R: Real> {
    row: R::Bits,
    primitive: R::Bits,
    is_sphere: R::Mask,
    /// See [`LightSample::place`](super::LightSample::place).
    at: [R; 2],
    /// See [`Sloped`].
    stretch: R,
}

pub(super) struct AreaLights {
    /// In the order of [`Paired`].
    rows: Rows<16>,
    /// The primitive of each row; and as bits, beside its corner, see [`Paired::corners`].
    primitives: Vec<u32>,
    names: Rows<2>,
    /// So many pairs of rows come first, each a lamp of its own; every other row is one.
    pairs: usize,
    /// `None` where lamps are sampled evenly.
    slopes: Option<Slopes>,
    first_sphere: usize,
    choice: ByPower,
    /// Of each lamp, by power, area lights' share left out.
    probability: Vec<f64>,
    grid: Option<Grid>,
}

/// A grid, and which lamp each primitive of the scene is of; 0 for those that are of none.
struct Grid {
    choice: ChoiceGrid,
    lamp_of: Vec<u32>,
}

impl AreaLights {
    /// `None` where nothing emits. `share` is the probability with which area lights are chosen at all.
    pub(super) fn build(mut emitters: Vec<Emitter>, share: f64) -> Result<Option<Self>, LightError> {
        emitters.retain(|e| e.power() > 0.0);
        if emitters.is_empty() {
            return Ok(None);
        }
        if emitters.len() > MAX_ENTRIES {
            return Err(LightError::TooMany { count: emitters.len(), most: MAX_ENTRIES });
        }
        let Paired { emitters, corners, pairs } = Paired::of(emitters);
        let first_sphere = emitters.partition_point(|e| !e.is_sphere());
        let power = |e: &[Emitter]| e.iter().map(Emitter::power).sum::<f64>();
        let (paired, single) = emitters.split_at(2 * pairs);
        let powers: Vec<f64> = paired.chunks(2).chain(single.chunks(1)).map(power).collect();
        let (choice, probability) = ByPower::build(&powers);
        let of_row = |i: usize| probability[lamp_of(i, pairs)] * if i < 2 * pairs { 0.5 } else { 1.0 };
        let rows: Vec<Row> = emitters.iter().enumerate().map(|(i, e)| row(e, of_row(i) * share)).collect();
        let primitives: Vec<u32> = emitters.iter().map(|e| e.primitive).collect();
        let names: Vec<[f32; 2]> =
            primitives.iter().zip(corners).map(|(&p, corner)| [f32::from_bits(p), corner]).collect();
        let (rows, names) = (Rows::new(&rows), Rows::new(&names));
        Ok(Some(Self { rows, primitives, names, pairs, slopes: None, first_sphere, choice, probability, grid: None }))
    }

    /// From now on lights can be chosen by place too, if they are many.
    pub(super) fn add_grid(&mut self, receivers: &Receivers) {
        if self.len() < MANY_LIGHTS {
            return;
        }
        let lamps: Vec<Lamp> = (0..self.probability.len()).map(|i| self.lamp(i)).collect();
        self.grid = ChoiceGrid::build(&lamps, receivers).map(|choice| {
            let mut of_primitive = vec![0; receivers.triangles.len() + receivers.spheres.len()];
            for (row, primitive) in self.primitives.iter().enumerate() {
                of_primitive[*primitive as usize] = lamp_of(row, self.pairs) as u32;
            }
            Grid { choice, lamp_of: of_primitive }
        });
    }

    /// From now on numbers of pairs can follow a [slope](Slopes), and where they are few, of single triangles.
    pub(super) fn add_slopes(&mut self) {
        let vertices = |row: usize| {
            let row = self.rows.row(row);
            let vector = |k: usize| DVec3::new(row[k].into(), row[k + 1].into(), row[k + 2].into());
            [vector(P0), vector(P0) + vector(E1), vector(P0) + vector(E2)]
        };
        let pair = |lamp: usize| {
            let (vertices, [_, corner]) = (vertices(2 * lamp), *self.names.row(2 * lamp));
            [0, 1, 2].map(|k| vertices[(corner as usize + k) % 3])
        };
        let singles = 2 * self.pairs..self.first_sphere;
        let singles = if singles.len() <= FEW_EMITTERS { singles } else { 0..0 };
        let lamps: Vec<_> = (0..self.pairs).map(pair).chain(singles.map(vertices).map(slope::of_triangle)).collect();
        self.slopes = (!lamps.is_empty()).then(|| Slopes::of(lamps.into_iter()));
    }

    fn lamp(&self, i: usize) -> Lamp {
        if i >= self.pairs {
            return self.lamp_of_row(i + self.pairs, self.probability[i]);
        }
        let [a, b] = [0, 1].map(|k| self.lamp_of_row(2 * i + k, self.probability[i]));
        Lamp { center: 0.5 * (a.center + b.center), area: a.area + b.area, ..a }
    }

    fn lamp_of_row(&self, i: usize, probability: f64) -> Lamp {
        let row = self.rows.row(i);
        let vector = |k: usize| glam::DVec3::new(row[k].into(), row[k + 1].into(), row[k + 2].into());
        let radiance = vector(RADIANCE).element_sum() / 3.0;
        if i < self.first_sphere {
            let (e1, e2) = (vector(E1), vector(E2));
            let (center, area) = (vector(P0) + (e1 + e2) / 3.0, 0.5 * e1.cross(e2).length());
            Lamp { center, normal: Some(vector(NG)), area, radiance, probability }
        } else {
            let area = PI * f64::from(row[RADIUS]).powi(2);
            Lamp { center: vector(CENTER), normal: None, area, radiance, probability }
        }
    }

    /// See [`Lights::reach`](super::Lights::reach); `share` as in [`AreaLights::build`].
    pub(super) fn reach(&self, share: f64) -> Option<Reach> {
        let shape = |i: usize| {
            let vector = |k: usize| std::array::from_fn(|axis| self.rows.row(i)[k + axis]);
            match i < self.first_sphere {
                true => EmitterShape::Triangle { p0: vector(P0), e1: vector(E1), e2: vector(E2) },
                false => EmitterShape::Sphere { center: vector(CENTER), radius: self.rows.row(i)[RADIUS] },
            }
        };
        let least = |i: usize| {
            let probability = self.probability[lamp_of(i, self.pairs)];
            let of_lamp = match &self.grid {
                None => probability * share,
                Some(_) => ChoiceGrid::least_probability(probability) * share,
            };
            if i < 2 * self.pairs { 0.5 * of_lamp } else { of_lamp }
        };
        Reach::of(&(0..self.len()).map(|i| (shape(i), least(i))).collect::<Vec<_>>())
    }

    pub(super) fn has_grid(&self) -> bool {
        self.grid.is_some()
    }

    /// See [`Lights::table_at`](super::Lights::table_at).
    #[inline(always)]
    pub(super) fn table_at<R: Real>(&self, p: Vec3<R>, n: Vec3<R>) -> R::Bits {
        self.grid.as_ref().map_or(R::Bits::splat(0), |grid| grid.choice.locate(p, n))
    }

    /// See [`Lights::choice_ratio`](super::Lights::choice_ratio).
    #[inline(always)]
    pub(super) fn choice_ratio<R: Real>(&self, primitive: R::Bits, table: R::Bits, emitting: R::Mask) -> R {
        let Some(Grid { choice, lamp_of }) = &self.grid else { return R::one() };
        let lamp = R::Bits::from_fn(|i| if emitting.lane(i) { lamp_of[primitive.lane(i) as usize] } else { 0 });
        choice.ratio(table, lamp)
    }

    pub(super) fn len(&self) -> usize {
        self.primitives.len()
    }

    pub(super) fn memory(&self) -> usize {
        let grid = self.grid.as_ref().map_or(0, |grid| grid.choice.memory() + size_of_val(&*grid.lamp_of));
        let slopes = self.slopes.as_ref().map_or(0, Slopes::bytes);
        self.rows.bytes() + slopes + size_of_val(&*self.primitives) + self.names.bytes() + self.choice.memory() + grid
    }

    /// A point on a light as seen from `origin`: by power, or from a `table` of the grid; along slopes, where there are any, for
    /// a receiver that is lit from the side of `facing`.
    ///
    /// `u[0]` chooses the lamp, and what is left of it, extended by `fine`, is the first number of the point: neighbours
    /// in the list are then neighbours in the square of the two numbers, which lists the lamps' surfaces without a seam
    /// that a low-discrepancy sampler would not see. A lamp of two triangles is sampled [as one](Paired).
    #[inline(always)]
    pub(super) fn sample<R: Real>(
        &self,
        origin: Vec3<R>,
        facing: Option<Vec3<R>>,
        table: Option<R::Bits>,
        u: [R; 2],
        fine: R,
    ) -> AreaSample<R> {
        let (Choice { entry: lamp, rest }, ratio) = match (&self.grid, table) {
            (Some(grid), Some(table)) => {
                let choice = grid.choice.choose(table, u[0], fine);
                let ratio = grid.choice.ratio(table, choice.entry);
                (choice, Some(ratio))
            }
            _ => (self.choice.choose(u, fine), None),
        };
        let receiver = facing.map(|n| (origin, n));
        let Place { row, primitive, is_sphere, at, stretch } = self.place(lamp, receiver, [rest, u[1]]);
        let rows = self.fetch(row);
        let mut point = if self.first_sphere == self.len() {
            rows.sample_triangle(origin, at)
        } else if self.first_sphere == 0 {
            rows.sample_sphere(origin, at)
        } else {
            LightPoint::select(is_sphere, rows.sample_sphere(origin, at), rows.sample_triangle(origin, at))
        };
        if let Some(ratio) = ratio {
            point.pdf = point.pdf * ratio;
        }
        AreaSample { point, radiance: rows.vector(RADIANCE) * stretch, primitive, place: at }
    }

    /// A primitive chosen by power, its radiance, and the place on it.
    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, u: [R; 2], fine: R) -> (R::Bits, Vec3<R>, [R; 2]) {
        let Choice { entry: lamp, rest } = self.choice.choose(u, fine);
        let Place { row, primitive, at, .. } = self.place(lamp, None, [rest, u[1]]);
        (primitive, self.fetch::<R>(row).vector(RADIANCE), at)
    }

    /// The place that two numbers mean on a lamp. What none of the lamps needs is not computed.
    #[inline(always)]
    fn place<R: Real>(&self, lamp: R::Bits, receiver: Option<(Vec3<R>, Vec3<R>)>, mut u: [R; 2]) -> Place<R> {
        let (mut row, mut second, mut stretch) = (lamp, R::Mask::splat(false), R::one());
        if let (Some(slopes), Some((p, n))) = (&self.slopes, receiver) {
            let leans = lamp.lt(R::Bits::splat(slopes.len() as u32));
            let sloped: Sloped<R> = slopes.lean(lamp, leans, p, n, u);
            u = array::from_fn(|k| R::select(leans, sloped.u[k], u[k]));
            stretch = R::select(leans, sloped.stretch, stretch);
        }
        if self.pairs > 0 {
            let pairs = R::Bits::splat(self.pairs as u32);
            let paired = lamp.lt(pairs);
            second = paired & pairs::in_second(u);
            let one = R::Bits::select(second, R::Bits::splat(1), R::Bits::splat(0));
            row = lamp + R::Bits::select(paired, lamp + one, pairs);
        }
        let [primitive, corner] = self.names.fetch::<R>(row, R::Mask::splat(true));
        let mut at = u;
        if 2 * self.pairs == self.len() {
            at = pairs::paired_weights(u, second, corner);
        } else if self.pairs > 0 {
            at = pairs::weights(u, second, corner);
        } else if self.first_sphere > 0 {
            at = warp::uniform_triangle(u);
        }
        let is_sphere = !row.lt(R::Bits::splat(self.first_sphere as u32));
        if self.first_sphere < self.len() {
            at = array::from_fn(|k| R::select(is_sphere, u[k], at[k]));
        }
        Place { row, primitive: primitive.to_bits(), is_sphere, at, stretch }
    }

    #[inline(always)]
    fn fetch<R: Real>(&self, row: R::Bits) -> LaneRows<R> {
        LaneRows(self.rows.fetch(row, R::Mask::splat(true)))
    }

    /// See [`Lights::emitter_pdf_row`](super::Lights::emitter_pdf_row).
    pub(super) fn pdf_row(&self, primitive: u32) -> f32 {
        self.find(primitive).map_or(0.0, |i| self.rows.row(i)[PDF_ROW])
    }

    /// See [`Lights::pdf_area`](super::Lights::pdf_area).
    pub(super) fn pdf<R: Real>(&self, primitive: R::Bits, origin: Vec3<R>, t: R, cos: R) -> R {
        const NONE: Row = [0.0; 16];
        let found: [Option<usize>; MAX_WIDTH] =
            crate::lane::array::from_fn(|i| if i < R::WIDTH { self.find(primitive.lane(i)) } else { None });
        let field = |k: usize| R::from_fn(|i| found[i].map_or(&NONE, |at| self.rows.row(at))[k]);
        let sphere_lanes = (0..R::WIDTH).filter(|&i| found[i].is_some_and(|at| at >= self.first_sphere));
        let is_sphere = R::Mask::from_bits(sphere_lanes.fold(0, |bits, i| bits | 1 << i));
        let row = field(PDF_ROW);
        let center = Vec3::new(field(CENTER), field(CENTER + 1), field(CENTER + 2));
        let on_sphere = sphere_pdf(row, center, field(RADIUS), origin);
        R::select(is_sphere, on_sphere, triangle_pdf(row, t, cos)).masked(row.gt(R::zero()))
    }

    fn find(&self, primitive: u32) -> Option<usize> {
        let kinds = [0..2 * self.pairs, 2 * self.pairs..self.first_sphere, self.first_sphere..self.len()];
        kinds.into_iter().find_map(|rows| {
            let first = rows.start;
            self.primitives[rows].binary_search(&primitive).ok().map(|i| first + i)
        })
    }
}

/// The lamp that a row is of, where the first rows are `pairs`.
fn lamp_of(row: usize, pairs: usize) -> usize {
    if row < 2 * pairs { row / 2 } else { row - pairs }
}
