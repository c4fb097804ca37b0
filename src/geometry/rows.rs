//! One row per primitive, fetched per lane and transposed.

use crate::lane::{Bits, Real, Vec3, array, axes};

/// A table of rows of `N` values that lanes fetch by index. Row 0 starts a cache line, so that rows of 4, 8 or 16 lie
/// within one each.
#[derive(Debug)]
pub struct Rows<const N: usize> {
    values: Vec<f32>,
    /// Where row 0 starts: vectors are aligned to 4 bytes only.
    start: usize,
    /// The same values column by column, zeros after the last row, where a column fits [`FEW`] places; else empty.
    columns: Vec<[f32; FEW]>,
}

/// A column of so many values lies in two registers of 16 lanes, or of 8 if there are at most half as many: a field of all
/// lanes is then a permutation of them or two, where a row a lane would have to be read and transposed.
const FEW: usize = 32;

impl<const N: usize> Rows<N> {
    /// Row 0 exists even in an empty table (zeros), so that dead lanes have something to read.
    pub fn new(rows: &[[f32; N]]) -> Self {
        const LINE: usize = 64 / size_of::<f32>();
        let count = rows.len().max(1) * N;
        let mut values: Vec<f32> = Vec::with_capacity(count + LINE);
        let start = values.as_ptr().align_offset(64) % LINE;
        values.resize(start, 0.0);
        values.extend_from_slice(rows.as_flattened());
        values.resize(start + count, 0.0);
        let column = |c: usize| array::from_fn(|r| rows.get(r).map_or(0.0, |row: &[f32; N]| row[c]));
        let columns = if rows.len() <= FEW { (0..N).map(column).collect() } else { Vec::new() };
        Self { values, start, columns }
    }
    #[inline(always)]
    fn rows(&self) -> &[[f32; N]] {
        self.values[self.start..].as_chunks().0
    }
    /// How many there are, one at least.
    #[inline]
    pub fn count(&self) -> usize {
        self.rows().len()
    }
    /// Row `index`. Domain: below [`Rows::count`].
    #[inline]
    pub fn row(&self, index: usize) -> &[f32; N] {
        &self.rows()[index]
    }
    pub fn bytes(&self) -> usize {
        core::mem::size_of_val(self.values.as_slice()) + core::mem::size_of_val(self.columns.as_slice())
    }
    /// Column `c` of row `index.lane(i)` in lane `i`; lanes that are not `valid` read row 0. Domain: indices of valid lanes
    /// below the number of rows; past the end it panics, or gives another row where there are few.
    #[inline(always)]
    pub fn fetch<R: Real>(&self, index: R::Bits, valid: R::Mask) -> [R; N] {
        let index = R::Bits::select(valid, index, R::Bits::splat(0));
        let rows = self.rows();
        match <&[[f32; FEW]; N]>::try_from(self.columns.as_slice()) {
            Ok(columns) if R::PERMUTES && rows.len() <= R::WIDTH => {
                array::from_fn(|c| R::load(&columns[c]).permute(index))
            }
            Ok(columns) if R::PERMUTES && rows.len() <= 2 * R::WIDTH => permuted(columns, index),
            _ => R::fetch_rows(rows, index),
        }
    }
}

/// What [`Rows::fetch`] gives, of at most twice as many rows as there are lanes.
#[inline(always)]
fn permuted<R: Real, const N: usize>(columns: &[[f32; FEW]; N], index: R::Bits) -> [R; N] {
    let width = R::Bits::splat(R::WIDTH as u32);
    let low = (index & width).eq(R::Bits::splat(0));
    array::from_fn(|c| {
        let half = |first: usize| R::load(&columns[c][first..]).permute(index);
        R::select(low, half(0), half(R::WIDTH))
    })
}

impl<const N: usize> Default for Rows<N> {
    fn default() -> Self {
        Self::new(&[])
    }
}

impl<const N: usize> Clone for Rows<N> {
    /// Aligned anew.
    fn clone(&self) -> Self {
        Self::new(self.rows())
    }
}

/// What shading reads of each triangle: 64 bytes.
#[derive(Clone, Debug, Default)]
pub struct TriangleRows(Rows<16>);

/// A triangle per lane.
#[derive(Clone, Copy, Debug)]
pub struct TriangleAt<R> {
    pub p0: Vec3<R>,
    /// p1 − p0, rounded.
    pub e1: Vec3<R>,
    /// p2 − p0, rounded.
    pub e2: Vec3<R>,
    /// Unit geometric normal along e1 × e2: towards whoever sees the vertices counter-clockwise. Zero where the
    /// triangle has no area.
    pub ng: Vec3<R>,
    pub area: R,
}

impl TriangleRows {
    /// `triangles` index `positions` (panics past the end).
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let rows: Vec<_> = triangles.iter().map(|t| triangle_row(array::map(*t, |i| positions[i as usize]))).collect();
        Self(Rows::new(&rows))
    }
    pub fn bytes(&self) -> usize {
        self.0.bytes()
    }
    /// Domain of valid lanes: triangles (not spheres, not a miss).
    #[inline(always)]
    pub fn fetch<R: Real>(&self, primitive: R::Bits, valid: R::Mask) -> TriangleAt<R> {
        let [px, py, pz, ax, ay, az, bx, by, bz, nx, ny, nz, area, ..] = self.0.fetch::<R>(primitive, valid);
        TriangleAt {
            p0: Vec3::new(px, py, pz),
            e1: Vec3::new(ax, ay, az),
            e2: Vec3::new(bx, by, bz),
            ng: Vec3::new(nx, ny, nz),
            area,
        }
    }
}

/// Normal and area in f64: once per triangle, and slivers cancel badly in f32.
fn triangle_row([p0, p1, p2]: [[f32; 3]; 3]) -> [f32; 16] {
    let edge = |p: [f32; 3]| axes(|k| f64::from(p[k]) - f64::from(p0[k]));
    let (a, b) = (edge(p1), edge(p2));
    let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    let n = if length > 0.0 { axes(|k| (n[k] / length) as f32) } else { [0.0; 3] };
    let (e1, e2) = (axes(|k| a[k] as f32), axes(|k| b[k] as f32));
    let area = (0.5 * length) as f32;
    [p0[0], p0[1], p0[2], e1[0], e1[1], e1[2], e2[0], e2[1], e2[2], n[0], n[1], n[2], area, 0.0, 0.0, 0.0]
}

/// What shading reads of each sphere: 16 bytes.
#[derive(Clone, Debug, Default)]
pub struct SphereRows(Rows<4>);

/// A sphere per lane.
#[derive(Clone, Copy, Debug)]
pub struct SphereAt<R> {
    pub center: Vec3<R>,
    pub radius: R,
}

impl SphereRows {
    pub fn new(spheres: &[([f32; 3], f32)]) -> Self {
        let rows: Vec<_> = spheres.iter().map(|(c, r)| [c[0], c[1], c[2], *r]).collect();
        Self(Rows::new(&rows))
    }
    pub fn bytes(&self) -> usize {
        self.0.bytes()
    }
    /// `index` counts spheres from 0: the primitive less the number of triangles.
    #[inline(always)]
    pub fn fetch<R: Real>(&self, index: R::Bits, valid: R::Mask) -> SphereAt<R> {
        let [x, y, z, radius] = self.0.fetch::<R>(index, valid);
        SphereAt { center: Vec3::new(x, y, z), radius }
    }
}
