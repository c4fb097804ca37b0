//! Directions with their weights, drawn anew at a hit or read from a set made beforehand.

use super::Vertex;
use super::tables::{Family, GatherTables};
use crate::estimate::bmc::{self, Covariance, Mean, Measure, Points, System, Weights};
use crate::lane::{Bits, MAX_WIDTH, Real, Vec3, math};
use crate::sampling::dimensions::BSDF_DIRECTION;
use crate::sampling::sobol::{self, Key};
use crate::sampling::{child_key, warp};

/// The child whose key scrambles a hit's own Owen points. Rays have lower numbers.
const SCRAMBLE: u32 = 1 << 31;

/// x, y, z about +z, weight, p; each padded to whole packets of any width.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    columns: [Vec<f32>; 5],
    count: usize,
    /// Behind the weights, where it is asked for and there is one.
    posterior: Option<Weights>,
}

impl Directions {
    pub fn new(count: usize) -> Self {
        let padded = count.next_multiple_of(MAX_WIDTH);
        Self { columns: std::array::from_fn(|_| vec![0.0; padded]), count, posterior: None }
    }

    /// `believes` keeps the posterior.
    pub fn from_set(set: &bmc::PointSet, measure: Measure, believes: bool) -> Self {
        let mut directions = Self::new(set.weights.len());
        directions.posterior = set.posterior.clone().filter(|_| believes);
        let [x, y, z] = &set.directions;
        for (column, values) in directions.columns.iter_mut().zip([x, y, z, &set.weights]) {
            column[..values.len()].copy_from_slice(values);
        }
        directions.fill_density(measure);
        directions
    }

    /// p of the directions.
    fn fill_density(&mut self, measure: Measure) {
        let [_, _, z, _, p] = &mut self.columns;
        for (p, z) in p.iter_mut().zip(z).take(self.count) {
            *p = match measure {
                Measure::UNIFORM => 1.0,
                Measure::COSINE => *z,
                _ => measure.density(f64::from(*z)) as f32,
            };
        }
    }

    /// P/n, as its weights would be if they were equal.
    pub fn equal_weight(&self, measure: Measure) -> f32 {
        (measure.total() / self.count as f64) as f32
    }

    /// Of its directions, in order.
    pub fn weights(&self) -> &[f32] {
        &self.columns[3][..self.count]
    }

    /// Variance of Σ w_i g_i given its terms, as the posterior has it; `None` where there is none.
    pub fn variance(&self, terms: &[f32], seen: &mut Vec<f64>) -> Option<f64> {
        let posterior = self.posterior.as_ref()?;
        seen.clear();
        // A weight of exactly 0 tells nothing of its g, which then counts as 0.
        let g = |(term, w): (&f32, &f32)| if *w == 0.0 { 0.0 } else { f64::from(*term) / f64::from(*w) };
        seen.extend(terms.iter().zip(&self.columns[3]).take(self.count).map(g));
        posterior.variance(seen)
    }

    #[inline(always)]
    pub fn load<R: Real>(&self, first: usize) -> [R; 5] {
        let column = |k: usize| R::load(&self.columns[k][first..first + R::WIDTH]);
        [column(0), column(1), column(2), column(3), column(4)]
    }

    /// Points of this hit's own, with the weights of a covariance or equal ones.
    #[inline(never)]
    pub fn draw<R: Real>(
        &mut self,
        tables: &GatherTables,
        family: &Family,
        vertex: &Vertex<R>,
        covariance: Option<Covariance>,
    ) {
        let equal = self.equal_weight(family.measure);
        self.columns[3][..self.count].fill(equal);
        for first in (0..self.count).step_by(R::WIDTH) {
            let u = numbers(tables, vertex, first, self.count);
            let w: Vec3<R> = match family.measure {
                Measure::COSINE => warp::cosine_hemisphere(u),
                Measure::UNIFORM => warp::uniform_hemisphere(u),
                lobe => about_axis(lobe, u),
            };
            for (column, value) in self.columns.iter_mut().zip([w.x, w.y, w.z]) {
                value.store(&mut column[first..first + R::WIDTH]);
            }
        }
        self.fill_density(family.measure);
        self.posterior = None;
        if let Some(covariance) = covariance {
            self.weigh(covariance, tables, family);
        }
    }

    /// Posterior weights, or equal ones where the system is ill-conditioned.
    fn weigh(&mut self, covariance: Covariance, tables: &GatherTables, family: &Family) {
        let [x, y, z, weights, _] = &mut self.columns;
        let unit: Vec<[f64; 3]> = (0..self.count).map(|i| [x[i], y[i], z[i]].map(f64::from)).collect();
        let lowest = if family.measure.has_horizon() { 0.0 } else { -1.0 };
        let theta = |w: &[f64; 3]| w[2].clamp(lowest, 1.0).acos();
        let system = System {
            gram: bmc::gram(covariance, &unit),
            z: unit.iter().map(|w| family.measure.embedding(covariance, theta(w), &tables.rules)).collect(),
            total: family.measure.total(),
            self_energy: family.self_energy,
        };
        let posterior = bmc::weights(&system, Mean::Constant, 0.0).shrunk(family.shrinkage, system.total);
        weights.iter_mut().zip(&posterior.w).for_each(|(to, w)| *to = *w as f32);
        self.posterior = Some(posterior);
    }
}

/// Directions distributed as a lobe about +z.
fn about_axis<R: Real>(lobe: Measure, u: [R; 2]) -> Vec3<R> {
    let z = R::from_fn(|lane| lobe.inverse_cdf(f64::from(u[0].lane(lane))) as f32);
    let r = ((R::one() - z) * (R::one() + z)).safe_sqrt();
    let (sin, cos) = math::sincos_2pi(u[1]);
    Vec3::new(r * cos, r * sin, z)
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
            let key = Key::<R>::from_fn(|_| child_key(vertex.key, SCRAMBLE + vertex.first_ray as u32));
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
