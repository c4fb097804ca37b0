//! The emitting primitives: one row each, chosen by power.

use super::alias::MAX_ENTRIES;
use super::by_power::ByPower;
use super::expected::Lamp;
use super::grid::{ChoiceGrid, Receivers};
use super::inversion::Choice;
use super::reach::Reach;
use super::sample::LightPoint;
use super::sphere::{self, sphere_pdf};
use super::triangle::{self, Triangle, triangle_pdf};
use super::{Emitter, EmitterShape, LightError};
use crate::geometry::Rows;
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3};
use std::f64::consts::PI;

/// What a lane needs to sample one emitter: one cache line.
///
/// Triangle: p0, e1, e2, unit front normal, radiance, choice probability / area.
/// Sphere: centre, radius, –, radiance, choice probability.
type Row = [f32; 16];

const P0: usize = 0;
const E1: usize = 3;
const E2: usize = 6;
const NG: usize = 9;
const CENTER: usize = 0;
const RADIUS: usize = 3;
const RADIANCE: usize = 12;
const PDF_ROW: usize = 15;

/// A point on an area light.
pub(super) struct AreaSample<R: Real> {
    pub point: LightPoint<R>,
    pub radiance: Vec3<R>,
    pub primitive: R::Bits,
    /// What the point on the light was sampled by.
    pub u: [R; 2],
}

pub(super) struct AreaLights {
    /// Triangles, then spheres, each in order of their primitive.
    rows: Rows<16>,
    /// The primitive of each row, and as bits.
    primitives: Vec<u32>,
    primitive_bits: Rows<1>,
    first_sphere: usize,
    choice: ByPower,
    /// Of each row, by power, area lights' share left out.
    probability: Vec<f64>,
    grid: Option<Grid>,
}

/// A grid, and which row each primitive of the scene is; 0 for those that are none.
struct Grid {
    choice: ChoiceGrid,
    row_of: Vec<u32>,
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
        emitters.sort_by_key(|e| (e.is_sphere(), e.primitive));
        let first_sphere = emitters.partition_point(|e| !e.is_sphere());
        let powers: Vec<f64> = emitters.iter().map(Emitter::power).collect();
        let (choice, probability) = ByPower::build(&powers);
        let rows: Vec<Row> = emitters.iter().zip(&probability).map(|(e, p)| row(e, p * share)).collect();
        let primitives: Vec<u32> = emitters.iter().map(|e| e.primitive).collect();
        let bits: Vec<[f32; 1]> = primitives.iter().map(|&primitive| [f32::from_bits(primitive)]).collect();
        let (rows, primitive_bits) = (Rows::new(&rows), Rows::new(&bits));
        Ok(Some(Self { rows, primitives, primitive_bits, first_sphere, choice, probability, grid: None }))
    }

    /// From now on lights can be chosen by place too, if they are many.
    pub(super) fn add_grid(&mut self, receivers: &Receivers) {
        let lamps: Vec<Lamp> = (0..self.len()).map(|i| self.lamp(i)).collect();
        self.grid = ChoiceGrid::build(&lamps, receivers).map(|choice| {
            let mut row_of = vec![0; receivers.triangles.len() + receivers.spheres.len()];
            for (row, primitive) in self.primitives.iter().enumerate() {
                row_of[*primitive as usize] = row as u32;
            }
            Grid { choice, row_of }
        });
    }

    fn lamp(&self, i: usize) -> Lamp {
        let row = self.rows.row(i);
        let vector = |k: usize| glam::DVec3::new(row[k].into(), row[k + 1].into(), row[k + 2].into());
        let radiance = vector(RADIANCE).element_sum() / 3.0;
        let probability = self.probability[i];
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
        let least = |i: usize| match &self.grid {
            None => self.probability[i] * share,
            Some(_) => ChoiceGrid::least_probability(self.probability[i]) * share,
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
        let Some(Grid { choice, row_of }) = &self.grid else { return R::one() };
        let row = R::Bits::from_fn(|i| if emitting.lane(i) { row_of[primitive.lane(i) as usize] } else { 0 });
        choice.ratio(table, row)
    }

    pub(super) fn len(&self) -> usize {
        self.primitives.len()
    }

    pub(super) fn memory(&self) -> usize {
        let grid = self.grid.as_ref().map_or(0, |grid| grid.choice.memory() + size_of_val(&*grid.row_of));
        self.rows.bytes() + size_of_val(&*self.primitives) + self.primitive_bits.bytes() + self.choice.memory() + grid
    }

    /// A point on a light as seen from `origin`: by power, or from a `table` of the grid.
    ///
    /// `u[0]` chooses the light, and what is left of it, extended by `fine`, is the first number of the point: neighbours
    /// in the list are then neighbours in the square of the two numbers, which lists the lamps' surfaces without a seam
    /// that a low-discrepancy sampler would not see. A lamp of two triangles is sampled as one.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, origin: Vec3<R>, table: Option<R::Bits>, u: [R; 2], fine: R) -> AreaSample<R> {
        let (Choice { entry: index, rest }, ratio) = match (&self.grid, table) {
            (Some(grid), Some(table)) => {
                let choice = grid.choice.choose(table, u[0], fine);
                let ratio = grid.choice.ratio(table, choice.entry);
                (choice, Some(ratio))
            }
            _ => (self.choice.choose(u, fine), None),
        };
        let u = [rest, u[1]];
        let rows = self.fetch(index);
        let mut point = if self.first_sphere == self.len() {
            rows.sample_triangle(origin, u)
        } else if self.first_sphere == 0 {
            rows.sample_sphere(origin, u)
        } else {
            let is_sphere = R::from_int(index).ge(R::splat(self.first_sphere as f32));
            LightPoint::select(is_sphere, rows.sample_sphere(origin, u), rows.sample_triangle(origin, u))
        };
        if let Some(ratio) = ratio {
            point.pdf = point.pdf * ratio;
        }
        AreaSample { point, radiance: rows.vector(RADIANCE), primitive: self.primitive::<R>(index), u }
    }

    /// A primitive chosen by power, its radiance, and what is left of `u` for the point on it.
    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, u: [R; 2], fine: R) -> (R::Bits, Vec3<R>, [R; 2]) {
        let Choice { entry: index, rest } = self.choice.choose(u, fine);
        (self.primitive::<R>(index), self.fetch::<R>(index).vector(RADIANCE), [rest, u[1]])
    }

    #[inline(always)]
    fn fetch<R: Real>(&self, index: R::Bits) -> LaneRows<R> {
        LaneRows(self.rows.fetch(index, R::Mask::splat(true)))
    }

    #[inline(always)]
    fn primitive<R: Real>(&self, index: R::Bits) -> R::Bits {
        let [bits] = self.primitive_bits.fetch::<R>(index, R::Mask::splat(true));
        bits.to_bits()
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
        let (triangles, spheres) = self.primitives.split_at(self.first_sphere);
        let on_sphere = || spheres.binary_search(&primitive).ok().map(|i| i + self.first_sphere);
        triangles.binary_search(&primitive).ok().or_else(on_sphere)
    }
}

/// The rows that the lanes look at, a register a field.
struct LaneRows<R>([R; 16]);

impl<R: Real> LaneRows<R> {
    #[inline(always)]
    fn field(&self, k: usize) -> R {
        self.0[k]
    }

    #[inline(always)]
    fn vector(&self, k: usize) -> Vec3<R> {
        Vec3::new(self.field(k), self.field(k + 1), self.field(k + 2))
    }

    #[inline(always)]
    fn sample_triangle(&self, origin: Vec3<R>, u: [R; 2]) -> LightPoint<R> {
        let light = Triangle { p0: self.vector(P0), e1: self.vector(E1), e2: self.vector(E2), ng: self.vector(NG) };
        triangle::sample(&light, self.field(PDF_ROW), origin, u)
    }

    #[inline(always)]
    fn sample_sphere(&self, origin: Vec3<R>, u: [R; 2]) -> LightPoint<R> {
        sphere::sample(self.vector(CENTER), self.field(RADIUS), self.field(PDF_ROW), origin, u)
    }
}

fn row(emitter: &Emitter, probability: f64) -> Row {
    let mut row = [0.0; 16];
    match emitter.shape {
        EmitterShape::Triangle { p0, e1, e2 } => {
            row[P0..P0 + 3].copy_from_slice(&p0);
            row[E1..E1 + 3].copy_from_slice(&e1);
            row[E2..E2 + 3].copy_from_slice(&e2);
            let normal = cross(e1, e2);
            let twice_area = length(normal);
            for k in 0..3 {
                row[NG + k] = (normal[k] / twice_area) as f32;
            }
            row[PDF_ROW] = (probability / (0.5 * twice_area)) as f32;
        }
        EmitterShape::Sphere { center, radius } => {
            row[CENTER..CENTER + 3].copy_from_slice(&center);
            row[RADIUS] = radius;
            row[PDF_ROW] = probability as f32;
        }
    }
    row[RADIANCE..RADIANCE + 3].copy_from_slice(&emitter.radiance);
    row
}

impl Emitter {
    /// Area in square units of the scene, in f64.
    pub fn area(&self) -> f64 {
        match self.shape {
            EmitterShape::Triangle { e1, e2, .. } => 0.5 * length(cross(e1, e2)),
            EmitterShape::Sphere { radius, .. } => 4.0 * PI * f64::from(radius) * f64::from(radius),
        }
    }

    /// π · area · radiance, the mean over the channels: what the light is chosen by. The mean, not luminance, because
    /// errors are measured per channel: a blue lamp deserves its samples.
    pub fn power(&self) -> f64 {
        let mean = self.radiance.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
        PI * self.area() * mean
    }

    fn is_sphere(&self) -> bool {
        matches!(self.shape, EmitterShape::Sphere { .. })
    }
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    let ([a0, a1, a2], [b0, b1, b2]) = (a.map(f64::from), b.map(f64::from));
    [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
