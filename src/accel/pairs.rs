//! Triangles for brute force: pairs that share an edge share its work, and groups of pairs their vertices.

use super::corners::{Corner, Moved, Vertices};
use super::lanes::ones;
use super::node::Planes;
use crate::geometry::{Bounds, Edges, RaySetup, SharedEdge, largest, meet_plane, plane_normal};
use crate::lane::{Bits, Real, axes};
use core::ops::Range;

/// What a triangle has of its own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Facet {
    normal: [f32; 3],
    /// The largest component of the normal.
    normal_size: f32,
    /// The own box.
    lo: [f32; 3],
    hi: [f32; 3],
}

/// A triangle (p, q, r), or it and the next, (p, r, s), as a quadrilateral is triangulated: they share two vertices, the
/// edge between them and the point their planes are measured from. Each keeps its own plane: bent pairs are welcome.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// x, y, z and a filler, as in [`Vertices`].
    pub vertices: [[f32; 4]; 4],
    pub facets: [Facet; 2],
    /// The first triangle's index.
    pub first: u32,
    /// Is there a second?
    pub both: bool,
    /// Are the normals the same, bit for bit?
    flat: bool,
    corners: [Corner; 4],
}

/// Pairs in order, in groups.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    pub list: Vec<Pair>,
    groups: Vec<(Vertices, Range<usize>)>,
    /// Around the own boxes of eight pairs at a time: see [`Node::planes`](super::node::Node::planes).
    planes: Vec<Planes>,
}

/// What [`Pairs::sieve`] finds of a packet and a triangle.
pub struct Sifted<R: Real> {
    pub index: u32,
    /// One less than the bits of t, where the ray passes between the edges, meets the plane at no low angle, and t > 0; else
    /// no less than that of any t.
    pub key: R::Bits,
    /// Unnormalised weights of vertices 1 and 2, and the sum of all three.
    pub weights: [R; 2],
    pub sum: R,
}

/// The sign of zero, of every number below it, and of no other.
const SIGN: u32 = 1 << 31;

/// Pairs of a list of 64 at most, as bits.
#[derive(Clone, Copy)]
pub struct Met(u64);

impl Met {
    #[inline(always)]
    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }
    /// Those of a range, which is not empty.
    #[inline(always)]
    fn of_range(self, range: &Range<usize>) -> u64 {
        self.0 & (u64::MAX >> (64 - range.end.clamp(1, 64))) & (u64::MAX << (range.start % 64))
    }
    /// Of the eight pairs from 8·`k` on.
    #[inline(always)]
    pub fn of_eight(self, k: usize) -> u32 {
        (self.0 >> (8 * k)) as u32 & 0xff
    }
}

impl Facet {
    fn new(v: [[f32; 3]; 3]) -> Self {
        let Bounds { lo, hi } = Bounds::of_triangle(v);
        let normal = plane_normal(v);
        Facet { normal, normal_size: largest(normal), lo, hi }
    }

    #[inline(always)]
    pub fn distances<R: Real>(&self, e: &Edges<R>, setup: &RaySetup<R>, v0: [R; 3]) -> (R::Mask, R) {
        e.distances(setup, v0, axes(|k| R::splat(self.normal[k])), R::splat(self.normal_size))
    }

    /// The key of the plane's distance, and a word whose sign says that the plane is met at a low angle.
    #[inline(always)]
    fn meet<R: Real>(&self, setup: &RaySetup<R>, way: [R; 3]) -> (R::Bits, R::Bits) {
        let (t, steepness) = meet_plane(setup, way, axes(|k| R::splat(self.normal[k])), R::splat(self.normal_size));
        (t.to_bits() - R::Bits::splat(1), steepness.to_bits())
    }

    pub fn bounds(&self) -> [[f32; 3]; 2] {
        [self.lo, self.hi]
    }
}

impl Pairs {
    pub fn new(triangles: &[[[f32; 3]; 3]]) -> Self {
        let mut pairs = Pairs::default();
        let mut i = 0;
        while i < triangles.len() {
            let [p, q, r] = triangles[i];
            let next = triangles.get(i + 1).filter(|next| next[0] == p && next[1] == r);
            pairs.push(i as u32, [p, q, r], next.map(|next| next[2]));
            i += 1 + usize::from(next.is_some());
        }
        pairs.planes = pairs.list.chunks(8).map(planes).collect();
        pairs
    }

    /// The pairs in order, without those whose own boxes no lane enters: `entered` tells of eight boxes, given with their number
    /// among the eights, as bits. Calls `visit` with each until it returns true.
    #[inline(always)]
    pub fn visit_met(&self, entered: impl Fn(usize, &Planes) -> u32, mut visit: impl FnMut(&Pair) -> bool) {
        for (k, planes) in self.planes.iter().enumerate() {
            for i in ones(entered(k, planes)) {
                if self.list.get(8 * k + i).is_some_and(&mut visit) {
                    return;
                }
            }
        }
    }

    /// Those that `entered` tells of, where there are no more than 64.
    #[inline(always)]
    pub fn met(&self, entered: impl Fn(&Planes) -> u32) -> Option<Met> {
        if self.list.len() > u64::BITS as usize {
            return None;
        }
        let mut bits = 0;
        for (k, planes) in self.planes.iter().enumerate() {
            bits |= u64::from(entered(planes)) << (8 * k);
        }
        Some(Met(bits))
    }

    fn push(&mut self, first: u32, [p, q, r]: [[f32; 3]; 3], s: Option<[f32; 3]>) {
        let vertices = [p, q, r, s.unwrap_or(r)];
        let facets = [Facet::new([p, q, r]), s.map_or_else(Facet::default, |s| Facet::new([p, r, s]))];
        let place = |group: &mut (Vertices, Range<usize>)| group.0.place(vertices);
        let corners = self.groups.last_mut().and_then(place).or_else(|| {
            self.groups.push((Vertices::default(), self.list.len()..self.list.len()));
            self.groups.last_mut().and_then(place)
        });
        let (Some(corners), Some((_, range))) = (corners, self.groups.last_mut()) else { return };
        range.end += 1;
        self.list.push(Pair {
            vertices: vertices.map(|[x, y, z]| [x, y, z, 0.0]),
            facets,
            first,
            both: s.is_some(),
            flat: facets[0].normal.map(f32::to_bits) == facets[1].normal.map(f32::to_bits),
            corners,
        });
    }

    pub fn bytes(&self) -> usize {
        let groups: usize = self.groups.iter().map(|(vertices, _)| vertices.bytes()).sum();
        core::mem::size_of_val(self.list.as_slice()) + core::mem::size_of_val(self.planes.as_slice()) + groups
    }

    /// Shows `visit` every triangle in order, or those of the pairs of `met`. Own boxes are not looked at. Returns a word whose
    /// sign marks lanes that pass some triangle's edges and meet its plane at a low angle: whether and where they hit that one
    /// is not said.
    ///
    /// No branch on what a triangle was: what some lane of 16 does next is anybody's guess, and a wrong guess costs as
    /// much as the work it saves. Comparisons and minima, of which few fit a cycle, are replaced by arithmetic on signs.
    #[inline(always)]
    pub fn sieve<R: Real>(&self, setup: &RaySetup<R>, met: Option<Met>, mut visit: impl FnMut(Sifted<R>)) -> R::Bits {
        let mut low = R::Bits::splat(0);
        let mut moved = Moved::new();
        for (vertices, range) in &self.groups {
            moved.fill(vertices, &setup.shear, &setup.order);
            let Some(met) = met else {
                self.list[range.clone()].iter().for_each(|pair| pair.sift(setup, &moved, &mut low, &mut visit));
                continue;
            };
            let mut bits = met.of_range(range);
            while bits != 0 {
                self.list[bits.trailing_zeros() as usize].sift(setup, &moved, &mut low, &mut visit);
                bits &= bits - 1;
            }
        }
        low
    }
}

/// Bounds of up to eight pairs; an empty place is entered by no ray.
fn planes(pairs: &[Pair]) -> Planes {
    let mut planes = [[f32::INFINITY; 16]; 3];
    for (axis, planes) in planes.iter_mut().enumerate() {
        for (k, plane) in planes.iter_mut().enumerate() {
            let (upper, slot) = (k >= 8, k % 8);
            let empty = if upper { f32::NEG_INFINITY } else { f32::INFINITY };
            let facets = pairs.get(slot).map_or(&[][..], |pair| &pair.facets[..1 + usize::from(pair.both)]);
            let bounds = facets.iter().map(|f| if upper { f.hi[axis] } else { f.lo[axis] });
            *plane = bounds.fold(empty, if upper { f32::max } else { f32::min });
        }
    }
    planes
}

impl Pair {
    #[inline(always)]
    fn sift<R: Real>(
        &self,
        setup: &RaySetup<R>,
        moved: &Moved<R>,
        low: &mut R::Bits,
        visit: &mut impl FnMut(Sifted<R>),
    ) {
        let [p, q, r, s] = self.corners;
        let edge = |a: Corner, c: Corner| Signed::new(SharedEdge::across(moved.at(a), moved.at(c)));
        let way = axes(|k| R::splat(self.vertices[0][k]) - setup.origin[k]);
        let plane = self.facets[0].meet(setup, way);
        let shared = edge(p, r);
        visit(sift(self.first, plane, [edge(r, q), shared, edge(q, p)], low));
        if self.both {
            let plane = if self.flat { plane } else { self.facets[1].meet(setup, way) };
            visit(sift(self.first + 1, plane, [edge(s, r), edge(p, s), shared.turned()], low));
        }
    }
}

/// The value of an edge function, and words whose signs say that it is below zero, and above.
#[derive(Clone, Copy)]
struct Signed<R: Real> {
    value: R,
    below: R::Bits,
    above: R::Bits,
}

impl<R: Real> Signed<R> {
    #[inline(always)]
    fn new(edge: SharedEdge<R>) -> Self {
        let value = edge.as_edge1();
        // Neither sum is −0: a zero has no sign in either.
        Signed { value, below: (value + R::zero()).to_bits(), above: (R::zero() - value).to_bits() }
    }

    /// As [`SharedEdge::as_edge2`].
    #[inline(always)]
    fn turned(self) -> Self {
        Signed { value: R::from_bits(self.above), below: self.above, above: self.below }
    }
}

#[inline(always)]
fn sift<R: Real>(index: u32, (key, is_low): (R::Bits, R::Bits), edges: [Signed<R>; 3], low: &mut R::Bits) -> Sifted<R> {
    let [e0, e1, e2] = edges;
    // Inside where no edge is below zero or none is above, but not all are zero: then one sign is set.
    let inside = (e0.below | e1.below | e2.below) ^ (e0.above | e1.above | e2.above);
    *low = *low | (inside & is_low);
    let sign = R::Bits::splat(SIGN);
    let key = key | (((inside & sign) ^ sign) | (is_low & sign));
    Sifted { index, key, weights: [e1.value, e2.value], sum: (e0.value + e1.value) + e2.value }
}
