//! Against arithmetic that shares nothing with `src`: Cramer's rule and the quadratic formula in f64.

use super::equivalence::random_rays;
use super::support::*;
use octolux::accel::{Brute, Packet, Preset, Single};
use octolux::geometry::MISS;
use octolux::lane::{f32x8, f32x16};

type V = [f64; 3];
fn wide(v: [f32; 3]) -> V {
    v.map(f64::from)
}
fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn length(a: V) -> f64 {
    dot(a, a).sqrt()
}

/// A crossing, and how clearly it is inside (> 0) or outside (< 0), as a distance in world units.
struct Crossing {
    t: f64,
    u: f64,
    v: f64,
    clear: f64,
    /// How fast t moves with a displacement of the surface: 1/|cos θ|, in lengths of the direction.
    slope: f64,
}

fn triangle(o: V, d: V, p: [V; 3]) -> Option<Crossing> {
    let (a, b) = (sub(p[1], p[0]), sub(p[2], p[0]));
    let n = cross(a, b);
    let area2 = length(n);
    let cos = dot(n, d) / (area2 * length(d));
    // Seen edge-on, or next to no area: the crossing is not well defined in f32.
    if area2.is_nan() || area2 < 1e-5 || cos.abs() < 0.02 {
        return None;
    }
    let t = dot(sub(p[0], o), n) / dot(d, n);
    let x = [0, 1, 2].map(|k| o[k] + t * d[k]);
    let side = |i: usize| {
        let (from, to) = (p[i], p[(i + 1) % 3]);
        let edge = sub(to, from);
        dot(cross(edge, sub(x, from)), n) / (area2 * length(edge))
    };
    let edges = [side(0), side(1), side(2)];
    let weight = |i: usize| edges[i] * length(sub(p[(i + 1) % 3], p[i])) / area2;
    Some(Crossing {
        t,
        u: weight(2),
        v: weight(0),
        clear: edges.into_iter().fold(f64::INFINITY, f64::min),
        slope: 1.0 / (cos.abs() * length(d)),
    })
}

/// Does the line of the ray enter the ball around a triangle?
fn passes_near(o: V, d: V, p: [V; 3]) -> bool {
    let radius = length(sub(p[1], p[0])).max(length(sub(p[2], p[0]))) + PLACE;
    length(cross(sub(p[0], o), d)) < radius * length(d)
}

/// Bound on how far the f32 test may misplace a triangle: its own box margin.
const PLACE: f64 = 1.0 / 524_288.0;

/// t, tolerance, primitive, u, v.
type Certain = (f64, f64, u32, f64, f64);

/// What f64 says of a ray: certain hits as (t, tolerance, primitive, u, v), and whether anything is too close to call.
fn oracle(shapes: &Shapes, ray: &OneRay) -> (Vec<Certain>, bool) {
    let (o, d, t_max) = (wide(ray.o), wide(ray.d), f64::from(ray.t_max));
    let (mut hits, mut doubtful) = (Vec::new(), false);
    for i in 0..shapes.triangles.len() {
        let p = shapes.vertices(i).map(wide);
        let Some(c) = triangle(o, d, p) else {
            doubtful |= passes_near(o, d, p);
            continue;
        };
        let tolerance = PLACE * c.slope;
        // A displacement across the ray moves the crossing in the plane by up to 1/cos as much.
        let blur = 2.0 * PLACE * c.slope * length(d);
        let (near_edge, near_end) = (c.clear.abs() < blur, c.t.abs() < tolerance || (c.t - t_max).abs() < tolerance);
        if c.clear < -blur || c.t < -tolerance || c.t > t_max + tolerance {
            continue;
        }
        if near_edge || near_end {
            doubtful = true;
        } else {
            hits.push((c.t, tolerance, i as u32, c.u, c.v));
        }
    }
    for (i, (center, radius)) in shapes.spheres.iter().enumerate() {
        let (f, r) = (sub(o, wide(*center)), f64::from(*radius));
        let (a, b, c) = (dot(d, d), dot(f, d), dot(f, f) - r * r);
        let across = sub(f, d.map(|x| x * b / a));
        let depth = r * r - dot(across, across);
        if depth.abs() < 0.05 * r * r || c.abs() < 1e-4 * r {
            doubtful |= depth > -0.05 * r * r;
            continue;
        }
        if depth < 0.0 {
            continue;
        }
        let root = (depth / a).sqrt();
        let (near, far) = (-b / a - root, -b / a + root);
        let t = if near > 0.0 { near } else { far };
        let tolerance = 10.0 * PLACE / a.sqrt();
        if t > 0.0 && t < t_max + tolerance {
            if (t - t_max).abs() < tolerance {
                doubtful = true;
            } else {
                hits.push((t, tolerance, (shapes.triangles.len() + i) as u32, 0.0, 0.0));
            }
        }
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    (hits, doubtful)
}

#[test]
fn hits_are_those_of_f64() {
    let mut rng = Random::new(11);
    let (mut judged, mut judged_hits, mut total) = (0, 0, 0);
    for (triangles, spheres, size) in [(40, 0, 0.4), (300, 12, 0.25), (0, 60, 0.0)] {
        let mut shapes = Shapes::random(triangles, spheres, size, &mut rng);
        // Slivers are doubtful by construction, and would make every ray so.
        shapes.triangles.retain(|t| {
            let p = t.map(|k| wide(shapes.positions[k as usize]));
            length(cross(sub(p[1], p[0]), sub(p[2], p[0]))) > 1e-5
        });
        let accel = shapes.everything(Preset::Medium);
        let rays = random_rays(6000, &mut rng);
        let answers = [
            ask::<f32, Brute>(&accel, &rays, |_| true),
            ask::<f32x8, Single>(&accel, &rays, |_| true),
            ask::<f32x16, Packet>(&accel, &rays, |_| true),
        ];
        for (i, ray) in rays.iter().enumerate() {
            total += 1;
            let (hits, doubtful) = oracle(&shapes, ray);
            let contested = hits.len() > 1 && hits[1].0 - hits[0].0 < hits[0].1 + hits[1].1;
            for (found, any) in answers.each_ref().map(|a| a[i]) {
                // Whatever else is in doubt, a certain hit means that something is hit, and not beyond it.
                if let Some(first) = hits.first() {
                    assert!(any && found.1 != MISS, "ray {i} {ray:?} misses {first:?}");
                    assert!(f64::from(f32::from_bits(found.0)) < first.0 + first.1, "ray {i} {ray:?} passes {first:?}");
                }
                if doubtful || contested {
                    continue;
                }
                match hits.first() {
                    None => assert!(!any && found.1 == MISS, "ray {i} {ray:?} hits {found:?}"),
                    Some((t, tolerance, primitive, u, v)) => {
                        assert_eq!(found.1, *primitive, "ray {i} {ray:?}");
                        let error = (f64::from(f32::from_bits(found.0)) - t).abs();
                        assert!(error < *tolerance, "ray {i} {ray:?}: t off by {error}, {tolerance} allowed");
                        if (*primitive as usize) < shapes.triangles.len() {
                            let p = shapes.vertices(*primitive as usize).map(wide);
                            let at =
                                |u: f64, v: f64| [0, 1, 2].map(|k| u * (p[1][k] - p[0][k]) + v * (p[2][k] - p[0][k]));
                            let (fu, fv) = (f64::from(f32::from_bits(found.2)), f64::from(f32::from_bits(found.3)));
                            let off = length(sub(at(fu, fv), at(*u, *v)));
                            assert!(off < tolerance * length(wide(ray.d)) * 2.0, "ray {i}: point off by {off}");
                        }
                    }
                }
            }
            judged += usize::from(!doubtful && !contested);
            judged_hits += usize::from(!doubtful && !contested && !hits.is_empty());
        }
    }
    println!("{judged} of {total} rays judged in full, {judged_hits} of them hits");
    assert!(judged * 10 > total * 5, "only {judged} of {total} rays were clear enough to judge");
    assert!(judged_hits > 3000, "only {judged_hits} hits judged");
}
