//! Directions with their weights, drawn anew at a hit or read from a set made beforehand.

use super::Vertex;
use super::tables::GatherTables;
use crate::estimate::bmc::{self, Covariance, Mean, Points, System};
use crate::lane::{Bits, MAX_WIDTH, Real, Vec3};
use crate::sampling::dimensions::BSDF_DIRECTION;
use crate::sampling::sobol::{self, Key};
use crate::sampling::{child_key, warp};

/// The child whose key scrambles a hit's own Owen points. Rays have lower numbers.
const SCRAMBLE: u32 = 1 << 31;

/// x, y, z about +z, weight; each padded to whole packets of any width.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    columns: [Vec<f32>; 4],
    count: usize,
}

impl Directions {
    pub fn new(count: usize) -> Self {
        let padded = count.next_multiple_of(MAX_WIDTH);
        Self { columns: std::array::from_fn(|_| vec![0.0; padded]), count }
    }

    pub fn from_set(set: &bmc::PointSet) -> Self {
        let mut directions = Self::new(set.weights.len());
        let [x, y, z] = &set.directions;
        for (column, values) in directions.columns.iter_mut().zip([x, y, z, &set.weights]) {
            column[..values.len()].copy_from_slice(values);
        }
        directions
    }

    #[inline(always)]
    pub fn load<R: Real>(&self, first: usize) -> [R; 4] {
        let column = |k: usize| R::load(&self.columns[k][first..first + R::WIDTH]);
        [column(0), column(1), column(2), column(3)]
    }

    /// Points of this hit's own, with the weights that `tables` asks for.
    #[inline(never)]
    pub fn draw<R: Real>(&mut self, tables: &GatherTables, vertex: &Vertex<R>) {
        let equal = (tables.measure.total() / self.count as f64) as f32;
        self.columns[3][..self.count].fill(equal);
        for first in (0..self.count).step_by(R::WIDTH) {
            let u = numbers(tables, vertex, first, self.count);
            let w: Vec3<R> = if tables.is_cosine() { warp::cosine_hemisphere(u) } else { warp::uniform_hemisphere(u) };
            for (column, value) in self.columns.iter_mut().zip([w.x, w.y, w.z]) {
                value.store(&mut column[first..first + R::WIDTH]);
            }
        }
        if let Some(covariance) = tables.covariance {
            self.weigh(covariance, tables);
        }
    }

    /// Posterior weights, or equal ones where the system is ill-conditioned.
    fn weigh(&mut self, covariance: Covariance, tables: &GatherTables) {
        let [x, y, z, weights] = &mut self.columns;
        let unit: Vec<[f64; 3]> = (0..self.count).map(|i| [x[i], y[i], z[i]].map(f64::from)).collect();
        let embedding = |w: &[f64; 3]| tables.measure.embedding(covariance, w[2].clamp(0.0, 1.0).acos(), &tables.rules);
        let system = System {
            gram: bmc::gram(covariance, &unit),
            z: unit.iter().map(embedding).collect(),
            total: tables.measure.total(),
            self_energy: tables.self_energy,
        };
        let posterior = bmc::weights(&system, Mean::Constant, 0.0);
        weights.iter_mut().zip(&posterior.w).for_each(|(to, w)| *to = *w as f32);
    }
}

/// Two numbers in [0, 1) for each of the points `first …`.
#[inline(always)]
fn numbers<R: Real>(tables: &GatherTables, vertex: &Vertex<R>, first: usize, count: usize) -> [R; 2] {
    let index = R::Bits::from_fn(|lane| (first + lane) as u32);
    match tables.settings.points {
        Points::Random => {
            let (_, u) = vertex.numbers(first);
            [u[BSDF_DIRECTION], u[BSDF_DIRECTION + 1]]
        }
        Points::Owen => {
            let key = Key::<R>::from_fn(|_| child_key(vertex.key, SCRAMBLE));
            sobol::owen_2d::<R>(index, key, 0).map(|bits| sobol::to_unit::<R>(bits))
        }
        Points::Fibonacci => {
            let shift = [vertex.u[BSDF_DIRECTION], vertex.u[BSDF_DIRECTION + 1]].map(R::splat);
            let below = R::splat(crate::sampling::ONE_BELOW);
            let u = (R::from_int(index) + shift[0]) / R::splat(count as f32);
            let turn = R::load(&tables.lattice[first..first + R::WIDTH]) + shift[1];
            [u.min_or(below), (turn - turn.floor()).min_or(below)]
        }
    }
}
