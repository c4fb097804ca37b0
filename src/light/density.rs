//! The table behind sampling an image: which cell between four texel centres.
//!
//! The density wanted is the bilinear interpolant of weights given at the centres, 0 at the poles. A cell is chosen by
//! a table of its row and that row's table of columns; the position in the cell follows from its corners. The factor
//! that turns the interpolant into the density is kept per cell, computed from the tables as rounded: 12 bytes a cell.

use super::alias::{self, Builder, Slot};
use crate::lane::{Bits, Mask, Real, prefetch};
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
        if south { rows.map(|r| self.height - 1 - r) } else { rows }
    }

    /// Row cells are numbered from north to south, one more than rows.
    #[inline(always)]
    fn row_cell(self, row: usize, south: bool) -> usize {
        if south { self.height - row } else { row }
    }
}

/// See the module.
pub(super) struct Density {
    shape: Shape,
    rows: Vec<Slot>,
    columns: Vec<Slot>,
    /// pdf_ω · sin θ / interpolated weight.
    scale: Vec<f32>,
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
    /// `weight(row, column)` ≥ 0 at the texel centres, not all 0.
    pub(super) fn build(shape: Shape, weight: impl Fn(usize, usize) -> f32 + Sync) -> Self {
        let Shape { width, height } = shape;
        let mut columns = vec![Slot::default(); (height + 1) * width];
        let mut scale = vec![0.0f32; (height + 1) * width];
        let lines = columns.par_chunks_mut(width).zip(scale.par_chunks_mut(width)).enumerate();
        let line_mass: Vec<f64> = lines
            .map_init(Scratch::default, |scratch, (j, (slots, scale))| {
                scratch.line(shape, j, &weight, slots, scale) * cell_height(shape, j)
            })
            .collect();

        let heaviest = line_mass.iter().fold(0.0, |a: f64, &b| a.max(b));
        let relative: Vec<f32> = line_mass.iter().map(|m| (m / heaviest) as f32).collect();
        let mut rows = vec![Slot::default(); height + 1];
        Builder::default().fill(&relative, &mut rows);
        let mut row_probability = vec![0.0; height + 1];
        alias::probabilities(&rows, &mut row_probability);
        for (j, line) in scale.chunks_exact_mut(width).enumerate() {
            let per_area = row_probability[j] * height as f64 / cell_height(shape, j) * width as f64;
            let factor = per_area / (2.0 * PI * PI);
            line.iter_mut().for_each(|s| *s = (f64::from(*s) * factor) as f32);
        }
        Self { shape, rows, columns, scale }
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.rows) + size_of_val(&*self.columns) + size_of_val(&*self.scale)
    }

    #[inline(always)]
    pub(super) fn choose<R: Real>(&self, u_choice: R, u: [R; 2]) -> Cell<R> {
        let Shape { width, height } = self.shape;
        let [fine_0, keep_row] = alias::fresh(u_choice, u[0], u[1]);
        let [fine_1, keep_column] = alias::fresh(u[1], fine_0, keep_row);
        let (place, _) = alias::place(height + 1, u_choice, fine_0);
        let cell = alias::resolve(place, keep_row, |i| self.rows[place.lane(i) as usize]);
        let (place, x) = alias::place(width, u[0], fine_1);
        let slot = |i: usize| self.columns[cell.lane(i) as usize * width + place.lane(i) as usize];
        let column = alias::resolve(place, keep_column, slot);
        let south = (R::from_int(cell) + R::from_int(cell)).gt(R::splat(height as f32));
        let row = R::Bits::select(south, R::Bits::splat(height as u32) - cell, cell);
        Cell { column, row, south, x, y: u[1] }
    }

    /// Starts to fetch what [`Density::scale`] will read.
    #[inline(always)]
    pub(super) fn prefetch_scale(&self, row: usize, column: usize, south: bool) {
        prefetch(self.scale.as_ptr().wrapping_add(self.shape.row_cell(row, south) * self.shape.width + column));
    }

    #[inline(always)]
    pub(super) fn scale<R: Real>(&self, row: R::Bits, column: R::Bits, south: R::Mask) -> R {
        R::from_fn(|i| {
            let cell = self.shape.row_cell(row.lane(i) as usize, south.lane(i));
            self.scale[cell * self.shape.width + column.lane(i) as usize]
        })
    }
}

/// In rows of texels: the cells at the poles reach only half a row.
fn cell_height(shape: Shape, j: usize) -> f64 {
    if j == 0 || j == shape.height { 0.5 } else { 1.0 }
}

#[derive(Default)]
struct Scratch {
    builder: Builder,
    weights: Vec<f32>,
    probability: Vec<f64>,
}

impl Scratch {
    /// One row of cells: fills its table, leaves P(column | row) / mean weight in `scale`, returns the sum of the means.
    fn line(
        &mut self,
        shape: Shape,
        j: usize,
        weight: &impl Fn(usize, usize) -> f32,
        slots: &mut [Slot],
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
        let total = self.builder.fill(&self.weights, slots);
        self.probability.resize(width, 0.0);
        alias::probabilities(slots, &mut self.probability);
        for ((scale, &weight), &p) in scale.iter_mut().zip(&self.weights).zip(&self.probability) {
            *scale = if weight > 0.0 { (p / f64::from(weight)) as f32 } else { 0.0 };
        }
        total
    }
}
