//! Triangles for brute force: pairs that share an edge share its work.

use super::block::keep_triangle;
use crate::geometry::{Bounds, Edges, Hit, RaySetup, Rows, SharedEdge, largest, plane_normal};
use crate::geometry::{first_of_pair, second_of_pair};
use crate::lane::{Bits, Mask, Real, axes};

/// What a triangle has of its own.
#[derive(Clone, Copy, Debug, Default)]
struct Facet {
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
struct FacetRow {
    /// x, y, z and a filler, so that a lane picks its axes by permuting one register.
    vertices: [[f32; 4]; 4],
    facets: [Facet; 2],
    /// The first triangle's index.
    first: u32,
    pair: bool,
}

/// The triangles of a small scene, in order.
#[derive(Clone, Debug, Default)]
pub struct TriangleList {
    rows: Vec<FacetRow>,
    /// The own boxes once more, for lanes to fetch: lower corner, upper corner, two fillers.
    boxes: Rows<8>,
}

impl Facet {
    fn new(v: [[f32; 3]; 3]) -> Self {
        let Bounds { lo, hi } = Bounds::of_triangle(v);
        let normal = plane_normal(v);
        Facet { normal, normal_size: largest(normal), lo, hi }
    }

    #[inline(always)]
    fn distances<R: Real>(&self, e: &Edges<R>, setup: &RaySetup<R>, v0: [R; 3]) -> (R::Mask, R) {
        e.distances(setup, v0, axes(|k| R::splat(self.normal[k])), R::splat(self.normal_size))
    }

    /// Lanes of `mask` that pass the own box, and the distance held to it.
    #[inline(always)]
    fn own_box<R: Real>(&self, setup: &RaySetup<R>, mask: R::Mask, t: R) -> (R::Mask, R) {
        let (t_near, t_far) = setup.slab(axes(|k| R::splat(self.lo[k])), axes(|k| R::splat(self.hi[k])));
        (mask & t_near.le(t_far), t_near.max_or(t))
    }
}

impl TriangleList {
    pub fn new(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let triangles: Vec<_> = triangles.collect();
        let corner = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let mut rows = Vec::new();
        let mut i = 0;
        while i < triangles.len() {
            let [p, q, r] = triangles[i];
            let next = triangles.get(i + 1).filter(|next| next[0] == p && next[1] == r);
            let s = next.map_or(r, |next| next[2]);
            rows.push(FacetRow {
                vertices: [p, q, r, s].map(corner),
                facets: [Facet::new([p, q, r]), next.map_or_else(Facet::default, |next| Facet::new(*next))],
                first: i as u32,
                pair: next.is_some(),
            });
            i += 1 + usize::from(next.is_some());
        }
        let boxes: Vec<_> = triangles.iter().map(|v| Bounds::of_triangle(*v)).collect();
        let boxes: Vec<_> =
            boxes.iter().map(|b| [b.lo[0], b.lo[1], b.lo[2], b.hi[0], b.hi[1], b.hi[2], 0.0, 0.0]).collect();
        Self { rows, boxes: Rows::new(&boxes) }
    }

    pub fn bytes(&self) -> usize {
        core::mem::size_of_val(self.rows.as_slice()) + self.boxes.bytes()
    }

    /// Calls `visit` with each triangle's index, facet, edge test and vertex 0, in order, until it returns true.
    #[inline(always)]
    fn visit<R: Real>(
        &self,
        setup: &RaySetup<R>,
        active: R::Mask,
        mut visit: impl FnMut(u32, &Facet, &Edges<R>, [R; 3]) -> bool,
    ) {
        for row in &self.rows {
            let v0 = axes(|k| R::splat(row.vertices[0][k]));
            let moved = |i: usize| setup.shear.apply(axes(|k| R::lookup4(&row.vertices[i], setup.order[k])));
            let (p, r) = (moved(0), moved(2));
            let shared = SharedEdge::new(p, r);
            if visit(row.first, &row.facets[0], &first_of_pair(p, moved(1), r, shared, active), v0) {
                return;
            }
            if row.pair && visit(row.first + 1, &row.facets[1], &second_of_pair(p, r, moved(3), shared, active), v0) {
                return;
            }
        }
    }

    /// Own boxes are looked at once, for the winners: where the winner of the bare distances passes its box and lies
    /// behind the box's front, it is the winner of the exact test too, since that only ever removes hits or moves them
    /// away. The few other lanes are done again, exactly.
    ///
    /// No branch on what a triangle was: what some lane of 16 does next is anybody's guess, and a wrong guess costs as
    /// much as the work it saves.
    #[inline(always)]
    pub fn closest<R: Real>(&self, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        let mut best = *hit;
        let mut sum = R::one();
        self.visit(setup, active, |i, facet, edges, v0| {
            let (mask, t) = facet.distances(edges, setup, v0);
            // In order of their index, so that the lower keeps a tie.
            let mask = mask & t.lt(best.t);
            let [u, v] = edges.weights;
            best.replace(mask, Hit { t, primitive: R::Bits::splat(i), u, v });
            sum = R::select(mask, edges.sum, sum);
            false
        });
        (best.u, best.v) = Edges::normalised([best.u, best.v], sum);
        let found = best.valid() & active;
        let [lx, ly, lz, hx, hy, hz, ..] = self.boxes.fetch::<R>(best.primitive, found);
        let (t_near, t_far) = setup.slab([lx, ly, lz], [hx, hy, hz]);
        let doubtful = found & !(t_near.le(t_far) & t_near.le(best.t));
        if doubtful.any() {
            self.closest_exact(setup, doubtful, hit);
        }
        hit.replace(found & !doubtful, best);
    }

    #[cold]
    #[inline(never)]
    fn closest_exact<R: Real>(&self, setup: &RaySetup<R>, active: R::Mask, hit: &mut Hit<R>) {
        let t_max = hit.t;
        self.visit(setup, active, |i, facet, edges, v0| {
            let (mask, t) = facet.distances(edges, setup, v0);
            if mask.any() {
                let (mask, t) = facet.own_box(setup, mask, t);
                keep_triangle((*edges, mask, t), i, t_max, hit);
            }
            false
        });
    }

    /// Lanes of `open` with a hit before `t_max`.
    #[inline(always)]
    pub fn any<R: Real>(&self, setup: &RaySetup<R>, t_max: R, active: R::Mask) -> R::Mask {
        let mut open = active;
        self.visit(setup, active, |_, facet, edges, v0| {
            let (mask, t) = facet.distances(edges, setup, v0);
            let mask = mask & open & t.lt(t_max);
            if mask.none() {
                return false;
            }
            let (mask, t) = facet.own_box(setup, mask, t);
            open = open & !(mask & t.lt(t_max));
            open.none()
        });
        active & !open
    }
}
