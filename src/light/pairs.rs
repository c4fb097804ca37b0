//! Two triangles that make a parallelogram, sampled as one lamp.
//!
//! The unit square is cut along a diagonal, and each half is mapped onto a triangle by an affine map; the two agree on the edge
//! between them. So what a low-discrepancy sampler puts into the square it puts into the lamp, without the fold that one
//! triangle needs ([`warp::uniform_triangle`]) and without first dividing the numbers between two. Each triangle gets half
//! of the draws and keeps the density of its own area: how nearly the pair makes a parallelogram is a matter of variance alone.

use super::{Emitter, EmitterShape};
use crate::lane::{Real, array};
use crate::sampling::warp;
use glam::{DVec3, Vec3};

/// How far, of the longer side, vertices of a pair may be from where a parallelogram has them.
const CLOSE: f64 = 1.0 / 4096.0;

/// How far, of their sum, the areas of a pair may differ: each has half of the draws. (Thin ones are close by the above, whatever
/// their areas.)
const ALIKE: f64 = 1.0 / 64.0;

/// In place of a corner: a triangle by itself, or a sphere.
pub(super) const ALONE: f32 = -1.0;

/// Emitters in the order of their rows.
pub(super) struct Paired {
    /// The triangles of pairs, two after two; single triangles; spheres; each in order of their primitives.
    pub emitters: Vec<Emitter>,
    /// Which vertex of a paired triangle is opposite the edge of both; [`ALONE`].
    pub corners: Vec<f32>,
    pub pairs: usize,
}

impl Paired {
    /// Pairs emitters that follow each other, as triangles of one polygon do, if they shine alike.
    pub fn of(mut emitters: Vec<Emitter>) -> Self {
        emitters.sort_by_key(|e| (e.is_sphere(), e.primitive));
        let (mut paired, mut corners, mut single) = (Vec::new(), Vec::new(), Vec::new());
        let mut rest = &emitters[..];
        while let [first, after @ ..] = rest {
            rest = after;
            match after.first().and_then(|second| Some((second, opposite_corners(first, second)?))) {
                Some((second, [a, b])) => {
                    paired.extend([*first, *second]);
                    corners.extend([a as f32, b as f32]);
                    rest = &after[1..];
                }
                None => single.push(*first),
            }
        }
        let pairs = paired.len() / 2;
        paired.extend(single);
        corners.resize(paired.len(), ALONE);
        Paired { emitters: paired, corners, pairs }
    }
}

/// The vertex of each that is opposite their edge; `None` unless they make a parallelogram that shines alike all over.
fn opposite_corners(first: &Emitter, second: &Emitter) -> Option<[usize; 2]> {
    let (a, b) = (vertices(first)?, vertices(second)?);
    let [area, other] = [first.area(), second.area()];
    if first.radiance != second.radiance || (area - other).abs() > ALIKE * (area + other) {
        return None;
    }
    let longest = (0..3).map(|i| a[i].distance(a[(i + 1) % 3])).fold(0.0, f64::max);
    let near = |p: DVec3, q: DVec3| p.distance(q) <= CLOSE * longest;
    let at = |corner: usize, k: usize| (corner + k) % 3;
    let fits = |&[i, j]: &[usize; 2]| {
        let (next, last) = (a[at(i, 1)], a[at(i, 2)]);
        // Seen from the front, the other triangle goes along the edge the other way.
        near(next, b[at(j, 2)]) && near(last, b[at(j, 1)]) && near(next + last - a[i], b[j])
    };
    (0..9).map(|k| [k / 3, k % 3]).find(fits)
}

fn vertices(emitter: &Emitter) -> Option<[DVec3; 3]> {
    let EmitterShape::Triangle { p0, e1, e2 } = emitter.shape else { return None };
    let [p0, e1, e2] = [p0, e1, e2].map(|v| Vec3::from(v).as_dvec3());
    Some([p0, p0 + e1, p0 + e2])
}

/// Lanes whose numbers lie in the half of the square that is the second triangle's.
#[inline(always)]
pub(super) fn in_second<R: Real>(u: [R; 2]) -> R::Mask {
    (u[0] + u[1]).gt(R::one())
}

/// Weights of vertices 1 and 2 at the point of a paired triangle for two numbers of its half, `corner` being its vertex there.
#[inline(always)]
pub(super) fn paired_weights<R: Real>(u: [R; 2], second: R::Mask, corner: R) -> [R; 2] {
    let [next, last] = array::map(u, |x| R::select(second, R::one() - x, x));
    // Rounding may make it negative.
    let here = (R::one() - next - last).max_or(R::zero());
    let (is_0, is_1) = (corner.eq(R::zero()), corner.eq(R::one()));
    [R::select(is_0, next, R::select(is_1, here, last)), R::select(is_0, last, R::select(is_1, next, here))]
}

/// The same of any triangle.
#[inline(always)]
pub(super) fn weights<R: Real>(u: [R; 2], second: R::Mask, corner: R) -> [R; 2] {
    let (alone, paired) = (warp::uniform_triangle(u), paired_weights(u, second, corner));
    let is_alone = corner.lt(R::zero());
    array::from_fn(|k| R::select(is_alone, alone[k], paired[k]))
}
