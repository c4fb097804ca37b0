//! Polygons with a corner that turns inwards: cut into triangles that do not leave them.
//!
//! Faces come triangulated as fans about their first corner, which is right for convex ones. The others are cut anew,
//! ear by ear (Meisters 1975), into as many triangles in the same places, so that no index elsewhere changes.

use super::Mesh;
use super::obj_outline::PolygonRun;
use glam::{DVec2, DVec3};

/// A face of more corners stays a fan: cutting takes time quadratic in them.
const MOST_CORNERS: usize = 1 << 13;
/// A corner turns inwards where the sine of its turn is below this: rounded coordinates make straight edges waver.
const INWARDS: f64 = -1e-5;

/// Cuts the concave ones among the polygons of a file whose triangles start at `first` in the mesh.
pub(super) fn cut_concave(mesh: &mut Mesh, runs: &[PolygonRun], first: usize, mirrors: bool) {
    let mut ring = Vec::new();
    for run in runs.iter().filter(|run| run.corners <= MOST_CORNERS) {
        let triangles = run.corners - 2;
        for face in 0..run.faces {
            let at = first + run.first + face * triangles;
            corners(&mesh.triangles[at..at + triangles], mirrors, &mut ring);
            let points: Vec<DVec3> =
                ring.iter().map(|&v| DVec3::from(mesh.positions[v as usize].map(f64::from))).collect();
            let Some(flat) = flatten(&points) else { continue };
            if is_convex(&flat) {
                continue;
            }
            let cut = clip_ears(&flat);
            let Mesh { triangles: positions, normal_indices, texcoord_indices, .. } = mesh;
            for indices in [positions, normal_indices, texcoord_indices] {
                let Some(fan) = indices.get_mut(at..at + triangles) else { continue };
                corners(fan, mirrors, &mut ring);
                for (triangle, [a, b, c]) in fan.iter_mut().zip(&cut) {
                    *triangle = if mirrors { [ring[*a], ring[*c], ring[*b]] } else { [ring[*a], ring[*b], ring[*c]] };
                }
            }
        }
    }
}

/// The corners of a fan in the order of its file.
fn corners(fan: &[[u32; 3]], mirrors: bool, ring: &mut Vec<u32>) {
    let [second, third] = if mirrors { [2, 1] } else { [1, 2] };
    ring.clear();
    ring.extend([fan[0][0], fan[0][second]]);
    ring.extend(fan.iter().map(|triangle| triangle[third]));
}

/// The corners in the plane across their mean normal (Newell's), counter-clockwise. `None` where they span no area.
fn flatten(points: &[DVec3]) -> Option<Vec<DVec2>> {
    let origin = points[0];
    let next = |i: usize| points[(i + 1) % points.len()] - origin;
    let normal = (0..points.len()).map(|i| (points[i] - origin).cross(next(i))).sum::<DVec3>().try_normalize()?;
    let (x, y) = normal.any_orthonormal_pair();
    Some(points.iter().map(|&p| DVec2::new((p - origin).dot(x), (p - origin).dot(y))).collect())
}

/// The sine of the turn at b, signed: > 0 to the left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (to, from) = (b - a, c - b);
    let lengths = to.length() * from.length();
    if lengths > 0.0 { to.perp_dot(from) / lengths } else { 0.0 }
}

fn is_convex(p: &[DVec2]) -> bool {
    (0..p.len()).all(|i| turn(p[(i + p.len() - 1) % p.len()], p[i], p[(i + 1) % p.len()]) > INWARDS)
}

/// Triples of corners, as many as the polygon has corners less two. Where no ear is left (the polygon crosses itself),
/// the sharpest corner goes.
fn clip_ears(p: &[DVec2]) -> Vec<[usize; 3]> {
    let mut ring: Vec<usize> = (0..p.len()).collect();
    let mut cut = Vec::with_capacity(p.len() - 2);
    while ring.len() > 3 {
        let n = ring.len();
        let around = |i: usize| [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
        let ear = (0..n).find(|&i| is_ear(p, &ring, around(i)));
        let sharpness = |i: &usize| {
            let [a, b, c] = around(*i);
            turn(p[a], p[b], p[c])
        };
        let sharpest = || (0..n).max_by(|i, j| sharpness(i).total_cmp(&sharpness(j))).unwrap_or(0);
        let i = ear.unwrap_or_else(sharpest);
        cut.push(around(i));
        ring.remove(i);
    }
    cut.push([ring[0], ring[1], ring[2]]);
    cut
}

/// Does the corner b turn outwards, with no other corner in its triangle?
fn is_ear(p: &[DVec2], ring: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let [a, b, c] = [p[a], p[b], p[c]];
    if turn(a, b, c) <= -INWARDS {
        return false;
    }
    let inside = |q: DVec2| {
        // A slit to a hole passes through the same points twice.
        let is_corner = q == a || q == b || q == c;
        !is_corner && [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| (to - from).perp_dot(q - from) >= 0.0)
    };
    !ring.iter().any(|&i| inside(p[i]))
}
