//! Path reuse: pixels of a group share what their paths find after the first bounce (Bekaert, Sbert, Halton 2002,
//! "Accelerating Path Tracing by Re-Using Paths").
//!
//! Path k of a group sees its first vertex x_k and samples a second, y_k, with density p_k there. Every first vertex of the
//! group could have sampled y_k: with the balance heuristic over all of them (Veach 1997, chapter 9) pixel i estimates
//!
//! ```text
//! Σ_j f(x_i → y_j) V(x_i, y_j) L(y_j → x_i) / Σ_k p_k(y_j) V(x_k, y_j)
//! ```
//!
//! where f holds the BSDF and the cosines. It is unbiased whatever the x are, and no worse than a path of its own: a y_j that
//! only x_j could have found has the weight it had. What costs is a segment for each pair, and those of a group lie side by side.
//!
//! What of a path is shared, after it scattered at x_j by no delta:
//! - At a Lambert y_j all that it scatters, whose radiance is the same to every side of the surface that sees it.
//! - At other y_j its light sample, with the BSDF towards each x_i; and what the path finds beyond its next vertex z_j, which
//!   counts as sampled from all (x_k, y_j) by their BSDFs.
//!
//! Emission of y_j itself, and of a z_j met by way of a lobe, stays with the path that found it, as its share of the light (the
//! other is that of the light sample). So do paths that meet a delta, and those that meet a dielectric from behind. Errors of the
//! pixels of a group are correlated.

mod connect;
mod finds;
mod group;
mod pairs;
mod segments;
mod spread;
mod vertex;

pub use group::{REUSE_SIDE, connect};
pub(super) use vertex::{arrive, keep_first, keep_light, leave};

use crate::lane::{Bits, MAX_WIDTH, Mask, Real};

/// Values of a row.
const ROW: usize = 16;

/// A row of a table, of each lane.
type Row = [f32; ROW];

/// What the paths of a job leave to be shared, a row a slot.
#[derive(Default)]
pub struct Shared {
    /// First vertices: position, where rays leave, geometric and shading normal on the viewer's side, albedo; 1.
    first: Vec<Row>,
    /// Their direction to the viewer and material; empty where all that scatters is Lambert and flat.
    scattering: Vec<Row>,
    /// Second vertices: position and its error, normals on the viewer's side, [what](place) they are.
    second: Vec<Row>,
    /// A direction at a second vertex that is not Lambert, density of a light sample, BSDF, and [what it scatters](place::SEEN)
    /// of what comes from there.
    lobes: Vec<Row>,
}

/// Where in a row is what.
mod place {
    /// Of a first vertex.
    pub const ALBEDO: usize = 12;
    /// Not 0 where there is a first vertex.
    pub const VALID: usize = 15;
    /// Of a second vertex: [`LAMBERT`](super::LAMBERT), [`LOBES`](super::LOBES), or 0 where there is none.
    pub const KIND: usize = 12;
    /// Of a second vertex: 1 + the lobe of the light sample, 0 for none.
    pub const LIGHT: usize = 13;
    /// Of a second vertex: 1 + the lobe of the path's own way on, 0 for none.
    pub const WAY_ON: usize = 14;
    /// Of a second vertex: what roulette multiplied the path by that went on.
    pub const ROULETTE: usize = 15;
    /// Of a lobe: the density of a light sample.
    pub const PDF: usize = 3;
    /// Of a lobe or a first vertex's scattering: the first of the material's values.
    pub const MATERIAL: usize = 4;
    /// Of a lobe: how much it scatters to the path's own first vertex, about. By that finds are chosen.
    pub const SEEN: usize = 14;
}

/// A second vertex that scatters the same to every side.
const LAMBERT: f32 = 1.0;
/// One that does not: its lobes are kept.
const LOBES: f32 = 2.0;

impl Shared {
    /// Room for a job; `scattering` where materials are more than an albedo.
    pub fn begin(&mut self, slots: usize, scattering: bool) {
        let empty = |table: &mut Vec<Row>, rows: usize| {
            table.clear();
            table.resize(rows, [0.0; ROW]);
        };
        empty(&mut self.first, slots);
        empty(&mut self.scattering, if scattering { slots } else { 0 });
        empty(&mut self.second, slots);
        self.lobes.clear();
    }

    fn slots(&self) -> u32 {
        self.first.len() as u32
    }
}

/// The lanes of `values` as rows.
#[inline(always)]
fn rows_of<R: Real>(values: &[R; ROW]) -> [Row; MAX_WIDTH] {
    let mut rows = [[0.0; ROW]; MAX_WIDTH];
    R::store_rows(values, &mut rows);
    rows
}

/// Writes the lanes of `mask` to the rows of their slots.
#[inline(always)]
fn write<R: Real>(table: &mut [Row], slot: R::Bits, values: &[R; ROW], mask: R::Mask) {
    let rows = rows_of(values);
    for lane in super::tile::lanes_of(mask.bits()) {
        table[slot.lane(lane) as usize] = rows[lane];
    }
}
