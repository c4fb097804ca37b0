//! A torus with smooth normals, leaning on the ground.

use crate::mesh::{Obj, Vec3, add};
use std::f64::consts::TAU;

const AROUND: usize = 64;
const ACROSS: usize = 24;
const RADIUS: f64 = 0.62;
const THICKNESS: f64 = 0.17;
const CENTRE: Vec3 = [0.35, 0.60, -1.15];
/// Lean from upright, radians.
const LEAN: f64 = 0.62;

pub fn obj() -> String {
    let mut obj = Obj::new("Made by tools/make_scenes: a torus with vertex normals.", "ring.mtl");
    obj.line("o ring");
    for i in 0..AROUND {
        for j in 0..ACROSS {
            let (point, normal) = torus(i as f64 / AROUND as f64 * TAU, j as f64 / ACROSS as f64 * TAU);
            obj.vertex(add(CENTRE, lean(point)));
            obj.normal(lean(normal));
        }
    }
    obj.line("usemtl ring");
    let index = |i: usize, j: usize| i % AROUND * ACROSS + j % ACROSS + 1;
    for i in 0..AROUND {
        for j in 0..ACROSS {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            obj.line(&format!("f {a}//{a} {b}//{b} {c}//{c} {d}//{d}"));
        }
    }
    obj.finish()
}

/// Point and outward normal of a torus about the z axis.
fn torus(u: f64, v: f64) -> (Vec3, Vec3) {
    let normal = [v.cos() * u.cos(), v.cos() * u.sin(), v.sin()];
    let ring = [RADIUS * u.cos(), RADIUS * u.sin(), 0.0];
    (add(ring, normal.map(|x| x * THICKNESS)), normal)
}

/// Turns about the x axis.
fn lean([x, y, z]: Vec3) -> Vec3 {
    let (s, c) = LEAN.sin_cos();
    [x, c * y + s * z, -s * y + c * z]
}
