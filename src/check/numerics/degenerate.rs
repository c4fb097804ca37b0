//! Scenes with nothing, with one thing, with the same thing many times, with things that have no area.

use super::random::Random;
use super::rays::{Both, Hits, OneRay, Verdict, ask};
use super::shapes::{Shape, scene, world};
use super::{Effort, Row};
use crate::geometry::MISS;
use crate::plan::GeometryMode;
use rayon::prelude::*;

const GROUP: &str = "degenerate scenes";

pub fn rows(effort: Effort) -> Vec<Row> {
    let rays = effort.pick(2_000, 20_000, 400_000);
    vec![empty(rays), single(rays), doubled(rays), coincident(effort.pick(10_000, 100_000, 100_000)), flat(rays / 10)]
}

fn worlds(shape: &Shape) -> Both {
    let placed = shape.placed([0.0; 3], 1.0, 1.0);
    Both { lists: placed.world(GeometryMode::Brute), tree: placed.world(GeometryMode::Tree) }
}

fn towards(o: [f32; 3], target: [f32; 3]) -> OneRay {
    OneRay { o, d: [0, 1, 2].map(|k| target[k] - o[k]) }
}

/// Asks in jobs of 1024 rays; returns what all traversals said and the hits.
fn ask_all(worlds: &Both, rays: &[OneRay]) -> (Verdict, Hits) {
    let parts: Vec<_> = rays.par_chunks(1024).map(|rays| ask(worlds, rays)).collect();
    parts.into_iter().fold((Verdict::default(), Vec::new()), |(verdict, mut hits), (v, h)| {
        hits.extend(h);
        (verdict.and(v), hits)
    })
}

fn row(case: &str, verdict: &Verdict, wrong: usize) -> Row {
    let row =
        Row::never(GROUP, case, verdict.rays, verdict.unequal + wrong as u64, "wrong hits, or modes that disagree");
    row.at(verdict.first.clone().filter(|_| verdict.unequal > 0).unwrap_or_default())
}

fn empty(count: usize) -> Row {
    let mut rng = Random::new(41);
    let worlds = Both {
        lists: world(&scene(Vec::new(), Vec::new(), Vec::new(), [0.0; 3]), GeometryMode::Brute),
        tree: world(&scene(Vec::new(), Vec::new(), Vec::new(), [0.0; 3]), GeometryMode::Tree),
    };
    let rays: Vec<_> = (0..count).map(|_| OneRay { o: rng.point(1.9), d: rng.direction() }).collect();
    let (verdict, hits) = ask_all(&worlds, &rays);
    row("empty scene: every ray misses", &verdict, hits.iter().filter(|h| h.1 != MISS).count())
}

/// One triangle, at points of it 2⁻²⁰ and more inside and outside of its edges.
fn single(count: usize) -> Row {
    let mut rng = Random::new(42);
    let v = [[-1.1, -0.9, 0.4], [1.2, -0.8, 0.3], [0.1, 1.3, -0.6]];
    let mut shape = Shape::default();
    shape.push(v);
    let inside = |i: usize| i.is_multiple_of(2);
    let rays: Vec<_> = (0..count)
        .map(|i| {
            // The smallest weight is ±margin; 2⁻¹⁹ of an edge is 16 ulp of the coordinates.
            let margin = f64::from(rng.log_uniform(-19.0, -3.0)) * if inside(i) { 1.0 } else { -1.0 };
            let rest = 1.0 - margin;
            let s = f64::from(rng.unit()).clamp(0.15, 0.85) * rest;
            let mut weights = [margin, s, rest - s];
            weights.rotate_left(rng.below(3));
            let target = [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * v[c][k]).sum::<f64>() as f32);
            let d = rng.direction();
            let normal = [0.04f32, 0.41, 0.91];
            let side = if (0..3).map(|k| d[k] * normal[k]).sum::<f32>() < 0.0 { -1.0 } else { 1.0 };
            // Steeply, so that an ulp along the ray is no more than an ulp across.
            towards([0, 1, 2].map(|k| target[k] + 0.5 * (side * normal[k] + 0.3 * d[k])), target)
        })
        .collect();
    let (verdict, hits) = ask_all(&worlds(&shape), &rays);
    let wrong = hits.iter().enumerate().filter(|(i, h)| (h.1 != MISS) != inside(*i)).count();
    row("one triangle: hit inside, missed outside", &verdict, wrong)
}

/// Each triangle of a ball twice: the first is the one that is hit.
fn doubled(count: usize) -> Row {
    let mut rng = Random::new(43);
    let mut ball = Shape::ball(8, 0.1);
    let n = ball.triangles.len();
    // The copies in another order and in blocks far from the first.
    (0..n).for_each(|i| ball.triangles.push(ball.triangles[(i * 7) % n]));
    let rays: Vec<_> = (0..count).map(|_| OneRay { o: rng.point(0.4), d: rng.direction() }).collect();
    let (verdict, hits) = ask_all(&worlds(&ball), &rays);
    let wrong = hits.iter().filter(|h| h.1 as usize >= n).count();
    row("coplanar duplicates: the first of equals wins", &verdict, wrong)
}

/// More coincident triangles than any split can part, behind ten others.
fn coincident(copies: usize) -> Row {
    let mut rng = Random::new(44);
    let mut shape = Shape::default();
    for _ in 0..10 {
        let p = rng.point(0.9).map(f64::from);
        shape.push([p, [p[0] + 0.1, p[1], p[2]], [p[0], p[1] + 0.1, p[2]]]);
    }
    (0..copies).for_each(|_| shape.push([[-0.5, -0.5, 1.6], [0.5, -0.5, 1.6], [0.0, 0.7, 1.6]]));
    let rays: Vec<_> =
        (0..64).map(|_| towards(rng.point(1.0), [0.1 * rng.signed(), 0.2 * rng.signed(), 1.6])).collect();
    let (verdict, hits) = ask_all(&worlds(&shape), &rays);
    row(&format!("{copies} coincident triangles"), &verdict, hits.iter().filter(|h| h.1 > 10).count())
}

/// Points, lines and boxes without volume along one line; rays meet the triangles that have area.
fn flat(count: usize) -> Row {
    let mut rng = Random::new(45);
    let mut shape = Shape::default();
    for i in 0..1000 {
        let x = 1.5 * 0.98f64.powi(i);
        match i % 4 {
            0 => shape.push([[x, 0.0, 0.0]; 3]),
            1 => shape.push([[x, -0.1, 0.0], [x, 0.1, 0.0], [x, 0.0, 0.0]]),
            2 => shape.push([[x, -0.1, -0.1], [x, 0.1, -0.1], [x, 0.0, 0.1]]),
            _ => shape.push([[x, -0.1, 0.0], [x * 0.98, 0.1, 0.0], [x, 0.1, 0.0]]),
        }
    }
    let rays: Vec<_> = (0..count)
        .map(|_| OneRay { o: [1.8, 0.02 * rng.signed(), 0.04 * rng.signed()], d: [-1.0, 0.0, 0.0] })
        .collect();
    let (verdict, hits) = ask_all(&worlds(&shape), &rays);
    // The first with area that faces the ray is triangle 2, whatever lies flat before it.
    let wrong = hits.iter().filter(|h| h.1 != 2).count();
    row("points, lines and flat boxes", &verdict, wrong)
}
