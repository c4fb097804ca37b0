//! The textbook forms, in f32: what each case of the catalogue gives without its care. Printed beside the result, so that
//! a reader sees what the case is for and that it can fail.

use super::rays::OneRay;

/// Does the test of Möller and Trumbore (1997), ε = 1e-8 on the determinant, hit any triangle? On coordinates as the
/// scene has them, without rescaling: the ray is taken back to them.
pub fn moller_trumbore(ray: &OneRay, triangles: &[[[f32; 3]; 3]], scale: f32) -> bool {
    let back = |v: [f32; 3]| v.map(|x| x / scale);
    let (o, d) = (back(ray.o), back(ray.d));
    triangles.iter().any(|[a, b, c]| {
        let (e1, e2) = (sub(*b, *a), sub(*c, *a));
        let p = cross(d, e2);
        let determinant = dot(e1, p);
        if determinant.abs() <= 1e-8 || determinant.is_nan() {
            return false;
        }
        let s = sub(o, *a);
        let u = dot(s, p) / determinant;
        let q = cross(s, e1);
        let v = dot(d, q) / determinant;
        let t = dot(e2, q) / determinant;
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
    })
}

pub fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
