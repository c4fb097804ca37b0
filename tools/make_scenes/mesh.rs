//! Vectors enough for generators, and OBJ text.

use std::fmt::Write;

pub type Vec3 = [f64; 3];

pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(a: Vec3, s: f64) -> Vec3 {
    a.map(|x| x * s)
}

pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn normalize(a: Vec3) -> Vec3 {
    scale(a, 1.0 / (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt())
}

/// OBJ text under construction.
pub struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    pub fn new(comment: &str, mtllib: &str) -> Self {
        Obj { text: format!("# {comment}\nmtllib {mtllib}\n"), vertices: 0 }
    }

    /// A line as it is.
    pub fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    /// Returns the vertex's index, counted from 1 as OBJ does.
    pub fn vertex(&mut self, p: Vec3) -> usize {
        let [x, y, z] = p.map(tidy);
        let _ = writeln!(self.text, "v {x} {y} {z}");
        self.vertices += 1;
        self.vertices
    }

    pub fn normal(&mut self, n: Vec3) {
        let [x, y, z] = n.map(tidy);
        let _ = writeln!(self.text, "vn {x} {y} {z}");
    }

    /// A quad in the given material, counter-clockwise seen from its front.
    pub fn quad(&mut self, material: &str, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners.map(|p| self.vertex(p));
        let _ = writeln!(self.text, "usemtl {material}\nf {a} {b} {c} {d}");
    }

    pub fn finish(self) -> String {
        self.text
    }
}

/// Four decimals, and no negative zero.
fn tidy(x: f64) -> f64 {
    (x * 1e4).round() / 1e4 + 0.0
}
