//! Intersection by trying everything.

use super::vec3::V3;
use octolux::scene::{NO_NORMAL, Scene};

/// Where a ray meets the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f64,
    /// Triangles in file order, then spheres in file order.
    pub prim: usize,
    /// Barycentric: p = (1 − u − v) p0 + u p1 + v p2. 0 on spheres.
    pub u: f64,
    pub v: f64,
}

/// The nearest hit with t > 0, both sides of everything; among equal t the lower primitive. For many rays through one
/// scene: [`Geometry::new`] once, then [`Geometry::trace`].
pub fn closest_hit(scene: &Scene, origin: [f64; 3], dir: [f64; 3]) -> Option<Hit> {
    Geometry::new(scene).trace(origin, dir, 0.0)
}

struct Triangle {
    p: [V3; 3],
    /// Not normalised: its length is twice the area. Counter-clockwise seen from its tip.
    n: V3,
    normals: Option<[V3; 3]>,
    material: usize,
}

struct Ball {
    center: V3,
    radius: f64,
    material: usize,
}

/// A scene's surfaces in f64.
pub struct Geometry {
    triangles: Vec<Triangle>,
    balls: Vec<Ball>,
    /// Rays that leave a surface ignore what is nearer than this: a billionth of the largest coordinate, 10⁷ roundings
    /// of a position.
    pub t_min: f64,
}

/// What shading needs to know about a hit.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub p: V3,
    /// Geometric normal: counter-clockwise side, outside of spheres.
    pub ng: V3,
    /// Shading normal: the vertex normals' barycentric mean, normalised; `ng` where there are none.
    pub ns: V3,
    pub material: usize,
}

impl Geometry {
    pub fn new(scene: &Scene) -> Self {
        let mesh = &scene.mesh;
        let triangles: Vec<_> = (0..mesh.triangles.len())
            .map(|i| {
                let p = mesh.triangles[i].map(|j| V3::of(mesh.positions[j as usize]));
                let normals = mesh
                    .normal_indices
                    .get(i)
                    .filter(|n| !n.contains(&NO_NORMAL))
                    .map(|n| n.map(|j| V3::of(mesh.normals[j as usize])));
                let n = (p[1] - p[0]).cross(p[2] - p[0]);
                Triangle { p, n, normals, material: mesh.material[i] as usize }
            })
            .collect();
        let balls: Vec<_> = scene
            .spheres
            .iter()
            .map(|s| Ball { center: V3::of(s.center), radius: s.radius.into(), material: s.material as usize })
            .collect();
        let largest = |v: V3| v.0.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        let points = triangles.iter().flat_map(|t| t.p).map(largest);
        let extent = points
            .chain(balls.iter().map(|b| largest(b.center) + b.radius))
            .fold(largest(V3::of(scene.camera.position)), f64::max);
        Geometry { triangles, balls, t_min: 1e-9 * extent }
    }

    /// The nearest hit with t > `t_min`, for callers without a vector type of ours.
    pub fn trace(&self, origin: [f64; 3], dir: [f64; 3], t_min: f64) -> Option<Hit> {
        self.closest(V3(origin), V3(dir), t_min)
    }

    /// The nearest hit with t > `t_min`.
    pub fn closest(&self, o: V3, d: V3, t_min: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for prim in 0..self.len() {
            let nearer = self.hit(prim, o, d, t_min).filter(|h| best.is_none_or(|b| h.t < b.t));
            best = nearer.or(best);
        }
        best
    }

    /// Is anything between `t_min` and `t_max`?
    pub fn occluded(&self, o: V3, d: V3, t_min: f64, t_max: f64) -> bool {
        (0..self.len()).any(|prim| self.hit(prim, o, d, t_min).is_some_and(|h| h.t < t_max))
    }

    /// Number of primitives.
    pub fn len(&self) -> usize {
        self.triangles.len() + self.balls.len()
    }

    pub fn material(&self, prim: usize) -> usize {
        match self.triangles.get(prim) {
            Some(t) => t.material,
            None => self.balls[prim - self.triangles.len()].material,
        }
    }

    pub fn area(&self, prim: usize) -> f64 {
        match self.triangles.get(prim) {
            Some(t) => 0.5 * t.n.length(),
            None => 4.0 * std::f64::consts::PI * self.balls[prim - self.triangles.len()].radius.powi(2),
        }
    }

    /// A point uniform over a primitive's area, and its geometric normal, from two numbers in [0, 1).
    pub fn point_on(&self, prim: usize, u: [f64; 2]) -> (V3, V3) {
        match self.triangles.get(prim) {
            Some(t) => {
                // Folding the parallelogram's far half back.
                let [a, b] = if u[0] + u[1] > 1.0 { [1.0 - u[0], 1.0 - u[1]] } else { u };
                (t.p[0] + (t.p[1] - t.p[0]) * a + (t.p[2] - t.p[0]) * b, t.n.unit())
            }
            None => {
                let ball = &self.balls[prim - self.triangles.len()];
                let z = 1.0 - 2.0 * u[0];
                let (s, c) = (std::f64::consts::TAU * u[1]).sin_cos();
                let r = (1.0 - z * z).max(0.0).sqrt();
                let n = V3::new(r * c, r * s, z);
                (ball.center + n * ball.radius, n)
            }
        }
    }

    pub fn surface(&self, o: V3, d: V3, hit: Hit) -> Surface {
        match self.triangles.get(hit.prim) {
            Some(t) => {
                let w = [1.0 - hit.u - hit.v, hit.u, hit.v];
                let mix = |v: [V3; 3]| v[0] * w[0] + v[1] * w[1] + v[2] * w[2];
                let ng = t.n.unit();
                Surface { p: mix(t.p), ng, ns: t.normals.map_or(ng, |n| mix(n).unit()), material: t.material }
            }
            None => {
                let ball = &self.balls[hit.prim - self.triangles.len()];
                let n = (o + d * hit.t - ball.center).unit();
                Surface { p: ball.center + n * ball.radius, ng: n, ns: n, material: ball.material }
            }
        }
    }

    fn hit(&self, prim: usize, o: V3, d: V3, t_min: f64) -> Option<Hit> {
        match self.triangles.get(prim) {
            Some(t) => t.hit(o, d),
            None => self.balls[prim - self.triangles.len()].hit(o, d, t_min),
        }
        .filter(|&(t, ..)| t > t_min)
        .map(|(t, u, v)| Hit { t, prim, u, v })
    }
}

impl Triangle {
    /// Three signed volumes; a shared edge has the same magnitude seen from both sides, so no ray slips through it.
    fn hit(&self, o: V3, d: V3) -> Option<(f64, f64, f64)> {
        let [a, b, c] = self.p.map(|p| p - o);
        let (u, v, w) = (d.dot(c.cross(a)), d.dot(a.cross(b)), d.dot(b.cross(c)));
        let inside = u >= 0.0 && v >= 0.0 && w >= 0.0 || u <= 0.0 && v <= 0.0 && w <= 0.0;
        let (volume, facing) = (u + v + w, d.dot(self.n));
        (inside && volume != 0.0 && facing != 0.0).then(|| (a.dot(self.n) / facing, u / volume, v / volume))
    }
}

impl Ball {
    fn hit(&self, o: V3, d: V3, t_min: f64) -> Option<(f64, f64, f64)> {
        // From the point of the ray nearest to the centre: no cancellation for far spheres.
        let dd = d.dot(d);
        let middle = (self.center - o).dot(d) / dd;
        let off = o + d * middle - self.center;
        let square = self.radius * self.radius - off.dot(off);
        if square < 0.0 {
            return None;
        }
        let half = (square / dd).sqrt();
        let t = if middle - half > t_min { middle - half } else { middle + half };
        Some((t, 0.0, 0.0))
    }
}
