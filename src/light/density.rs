//! The table behind sampling an image: which cell between four texel centres.
//!
//! The density wanted is the bilinear interpolant of weights given at the centres, 0 at the poles. A cell is chosen by
//! a table of its row and that row's table of columns, both by inversion, so that a well-spread pair of numbers gives
//! well-spread directions; the position in the cell follows from its corners. The factor that turns the interpolant into
//! the density is computed per cell from the tables as rounded. Look-ups wait for the cache: so an entry is four bytes, and
//! the factor is kept by the caller beside the radiance it is read with.

use super::alias;
use super::inversion::{Inversion, Table};
use crate::lane::{Bits, Real, array};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Width and height in texels, each ≥ 1.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub width: usize,
    pub height: usize,
}

impl Shape {
    /// The rows of centres bounding row cell `row` counted from a pole: towards it, away from it. The cell at the
    /// pole repeats its only row.
    #[inline(always)]
    pub(super) fn corner_rows(self, row: usize, south: bool) -> [usize; 2] {
        let rows = [row.saturating_sub(1), row.min(self.height - 1)];
        if south { array::map(rows, |r| self.height - 1 - r) } else { rows }
    }

    /// Row cells are numbered from north to south, one more than rows.
    #[inline(always)]
    pub(super) fn row_cell(self, row: usize, south: bool) -> usize {
        if south { self.height - row } else { row }
    }
}

/// See the module.
pub(super) struct Density {
    shape: Shape,
    rows: Inversion,
    columns: Inversion,
}

/// A chosen cell, and what is left of the random numbers for the position in it: `x` between the columns, `y`
/// between the rows, both still uniform.
pub(super) struct Cell<R: Real> {
    pub column: R::Bits,
    /// Counted from the nearer pole.
    pub row: R::Bits,
    pub south: R::Mask,
    pub x: R,
    pub y: R,
}

impl Density {
    /// `weight(row, column)` ≥ 0 at the texel centres, not all 0. Also pdf_ω · sin θ / interpolated weight of each cell,
    /// row by row from the north, one row more than texels have.
    pub(super) fn build(shape: Shape, weight: impl Fn(usize, usize) -> f32 + Sync) -> (Self, Vec<f32>) {
        let Shape { width, height } = shape;
        let mut columns = Inversion::new(height + 1, width);
        let mut scale = vec![0.0f32; (height + 1) * width];
        let lines = columns.tables().into_par_iter().zip(scale.par_chunks_mut(width)).enumerate();
        let line_mass: Vec<f64> = lines
            .map_init(Scratch::default, |scratch, (j, (table, scale))| {
                scratch.line(shape, j, &weight, table, scale) * cell_height(shape, j)
            })
            .collect();

        let heaviest = line_mass.iter().fold(0.0, |a: f64, &b| a.max(b));
        let relative: Vec<f32> = line_mass.iter().map(|m| (m / heaviest) as f32).collect();
        let mut rows = Inversion::new(1, height + 1);
        let mut row_probability = Vec::new();
        for table in &mut rows.tables() {
            table.fill(&relative);
            row_probability.extend(table.probability());
        }
        for (j, line) in scale.chunks_exact_mut(width).enumerate() {
            let per_area = row_probability[j] * height as f64 / cell_height(shape, j) * width as f64;
            let factor = per_area / (2.0 * PI * PI);
            line.iter_mut().for_each(|s| *s = (f64::from(*s) * factor) as f32);
        }
        (Self { shape, rows, columns }, scale)
    }

    pub(super) fn memory(&self) -> usize {
        self.rows.bytes() + self.columns.bytes()
    }

    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, u: [R; 2]) -> Cell<R> {
        let [fine_0, fine_1] = alias::fresh(u[0], u[1], R::zero());
        let row = self.rows.choose(R::Bits::splat(0), u[1], fine_1);
        let column = self.columns.choose(row.entry, u[0], fine_0);
        let south = (R::from_int(row.entry) + R::from_int(row.entry)).gt(R::splat(self.shape.height as f32));
        let from_pole = R::Bits::select(south, R::Bits::splat(self.shape.height as u32) - row.entry, row.entry);
        // Positions are counted from the nearer pole too.
        let y = R::select(south, R::one() - row.rest, row.rest);
        Cell { column: column.entry, row: from_pole, south, x: column.rest, y }
    }
}

/// In rows of texels: the cells at the poles reach only half a row.
fn cell_height(shape: Shape, j: usize) -> f64 {
    if j == 0 || j == shape.height { 0.5 } else { 1.0 }
}

#[derive(Default)]
struct Scratch {
    weights: Vec<f32>,
}

impl Scratch {
    /// One row of cells: fills its table, leaves P(column | row) / mean weight in `scale`, returns the sum of the means.
    fn line(
        &mut self,
        shape: Shape,
        j: usize,
        weight: &impl Fn(usize, usize) -> f32,
        mut table: Table<'_>,
        scale: &mut [f32],
    ) -> f64 {
        let Shape { width, height } = shape;
        // At a pole the interpolant falls to 0.
        let at = |row: Option<usize>, column: usize| {
            row.map_or(0.0, |r| f64::from(weight(r, if column == width { 0 } else { column })))
        };
        let rows = [j.checked_sub(1), Some(j).filter(|&r| r < height)];
        let side = |column: usize| at(rows[0], column) + at(rows[1], column);
        self.weights.clear();
        let mut left = side(0);
        for column in 0..width {
            let right = side(column + 1);
            self.weights.push((0.25 * (left + right)) as f32);
            left = right;
        }
        let total = table.fill(&self.weights);
        for ((scale, &weight), p) in scale.iter_mut().zip(&self.weights).zip(table.probability()) {
            *scale = if weight > 0.0 { (p / f64::from(weight)) as f32 } else { 0.0 };
        }
        total
    }
}
