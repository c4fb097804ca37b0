//! A density learned from a pilot of the integrand: a histogram over cells of equal solid angle.

use super::field::Field;
use crate::estimate::rules::Gauss;
use crate::lane::{MAX_WIDTH, Real, Vec3, math};
use crate::sampling::{ONE_BELOW, sample_key};
use std::f64::consts::TAU;

/// Cells in cosθ and in φ.
const ROWS: usize = 16;
const COLUMNS: usize = 32;
/// Pilot evaluations in each cell, and the key that sets them apart from every study's.
const EACH: usize = 8;
const PILOT_KEY: u64 = 0x7069_6c6f_7420_6f66;
/// The part of the density that is uniform, whatever the pilot missed: F/p is bounded by F's largest value times 2π over
/// this (defensive mixture, Hesterberg 1995).
const UNIFORM_SHARE: f64 = 0.1;

/// p is constant in each cell, ∝ √(mean F²) there: the best that such a density can be, which is not the mean of F
/// (Rath et al. 2020, "Variance-Aware Path Guiding", eq. 10).
#[derive(Debug, PartialEq)]
pub struct Learned {
    /// Per steradian, row by row from the horizon.
    density: Vec<f64>,
    /// Probability below the upper edge of each row, and of each cell within its row.
    rows: Vec<f64>,
    cells: Vec<f64>,
}

impl Learned {
    /// Evaluations that the pilot costs.
    pub const PILOT: usize = ROWS * COLUMNS * EACH;

    /// From a pilot with random numbers of its own: for any study the density is fixed beforehand, and the estimate
    /// unbiased.
    pub fn new(field: &Field) -> Self {
        let mean_square = |cell: usize| {
            let square = |i: usize| {
                let key = sample_key(PILOT_KEY, cell as u32, i as u32);
                let inside = [key as u32, (key >> 32) as u32].map(|b| (f64::from(b) + 0.5) * f64::powi(2.0, -32));
                field.at(direction(cell, inside), false).powi(2)
            };
            (0..EACH).map(square).sum::<f64>() / EACH as f64
        };
        let seen: Vec<f64> = (0..ROWS * COLUMNS).map(mean_square).collect();
        let learned: Vec<f64> = (0..ROWS * COLUMNS).map(|cell| filtered(&seen, cell).sqrt()).collect();
        let sum: f64 = learned.iter().sum();
        let even = 1.0 / (ROWS * COLUMNS) as f64;
        // Of a function that the pilot saw nothing of nothing is learned.
        let share = |l: &f64| if sum > 0.0 { UNIFORM_SHARE * even + (1.0 - UNIFORM_SHARE) * l / sum } else { even };
        let probability: Vec<f64> = learned.iter().map(share).collect();
        let mut below = 0.0;
        let (mut rows, mut cells) = (Vec::new(), Vec::new());
        for row in probability.chunks(COLUMNS) {
            let total: f64 = row.iter().sum();
            below += total;
            rows.push(below);
            let mut left = 0.0;
            cells.extend(row.iter().map(|p| {
                left += p / total;
                left
            }));
        }
        let solid_angle = TAU * even;
        Self { density: probability.iter().map(|p| p / solid_angle).collect(), rows, cells }
    }

    /// Per steradian.
    pub fn at(&self, w: [f64; 3]) -> f64 {
        let turn = (w[1].atan2(w[0]) / TAU).rem_euclid(1.0);
        let place = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        self.density[place(w[2], ROWS) * COLUMNS + place(turn, COLUMNS)]
    }

    /// (cosθ, φ/2π) of two numbers in [0, 1), and the density there.
    fn invert(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let (row, up) = find(&self.rows, u[0]);
        let (column, right) = find(&self.cells[row * COLUMNS..(row + 1) * COLUMNS], u[1]);
        let place = [(row as f64 + up) / ROWS as f64, (column as f64 + right) / COLUMNS as f64];
        (place, self.density[row * COLUMNS + column])
    }

    /// A direction's cosθ and φ/2π, and its density. Lane by lane, so that it is the same at any width.
    #[inline(always)]
    pub fn sample<R: Real>(&self, u: [R; 2]) -> (R, R, R) {
        let mut found = [[0.0f32; 3]; MAX_WIDTH];
        for (lane, found) in found.iter_mut().enumerate().take(R::WIDTH) {
            let ([cos, turn], density) = self.invert(u.map(|u| f64::from(u.lane(lane))));
            // Rounding may reach 1, which is no position in a turn.
            *found = [cos as f32, (turn as f32).min(ONE_BELOW), density as f32];
        }
        let [cos, turn, density] = [0, 1, 2].map(|k| R::from_fn(|lane| found[lane][k]));
        (cos, turn, density)
    }

    /// ∫ F²/p: cell by cell, by Gauss where F is smooth, by 32² midpoints where it has edges.
    pub fn second_moment(&self, field: &Field) -> f64 {
        let gauss = Gauss::new(if field.is_smooth() { 8 } else { 1 });
        let panels = if field.is_smooth() { 1 } else { 32 };
        let square = |cell: usize, x: f64, y: f64| field.at(direction(cell, [x, y]), false).powi(2);
        let mean = |cell: usize| {
            let row = |x: f64| gauss.integrate([0.0, 1.0], panels, |y| square(cell, x, y));
            gauss.integrate([0.0, 1.0], panels, row)
        };
        let solid_angle = TAU / (ROWS * COLUMNS) as f64;
        self.density.iter().enumerate().map(|(cell, p)| solid_angle * mean(cell) / p).sum()
    }
}

/// Half of a cell's own value, half of the mean of those around it: where an edge crosses a cell the pilot may have missed
/// what is bright there (filtering as in Müller 2019, "Practical Path Guiding in Production", § 2).
fn filtered(seen: &[f64], cell: usize) -> f64 {
    let (row, column) = (cell / COLUMNS, cell % COLUMNS);
    let rows = row.saturating_sub(1)..=(row + 1).min(ROWS - 1);
    let around = rows.flat_map(|r| (0..3).map(move |k| r * COLUMNS + (column + COLUMNS + k - 1) % COLUMNS));
    let (sum, count) = around.filter(|&c| c != cell).fold((0.0, 0.0), |(s, n), c| (s + seen[c], n + 1.0));
    0.5 * seen[cell] + 0.5 * sum / count
}

/// The place of `u` among cumulative probabilities, and how far inside it lies.
fn find(cumulative: &[f64], u: f64) -> (usize, f64) {
    let i = cumulative.partition_point(|&above| above <= u).min(cumulative.len() - 1);
    let low = if i == 0 { 0.0 } else { cumulative[i - 1] };
    (i, ((u - low) / (cumulative[i] - low)).clamp(0.0, 1.0))
}

/// The direction at a position inside a cell.
fn direction(cell: usize, [x, y]: [f64; 2]) -> [f64; 3] {
    let cos = ((cell / COLUMNS) as f64 + x) / ROWS as f64;
    let (s, c) = (TAU * ((cell % COLUMNS) as f64 + y) / COLUMNS as f64).sin_cos();
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    [sin * c, sin * s, cos]
}

/// From polar coordinates, in lanes.
#[inline(always)]
pub fn spherical<R: Real>(cos: R, turn: R) -> Vec3<R> {
    let cos = cos.min_or(R::splat(ONE_BELOW));
    let sin = ((R::one() - cos) * (R::one() + cos)).safe_sqrt();
    let (s, c) = math::sincos_2pi(turn);
    Vec3::new(sin * c, sin * s, cos)
}
