//! Closed meshes to look out of, and the worlds made of them.

use super::random::Random;
use crate::kernel::{Prepare, World};
use crate::plan::{Force, GeometryMode, Plan};
use crate::scene::{Bsdf, Camera, FilmSize, Integrator, IntegratorKind, Material, Mesh, Scene, Sphere};
use std::f64::consts::{PI, TAU};

/// Vertices in f64, to be placed and rounded, and triangles between them.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub positions: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    pub fn push(&mut self, corners: [[f64; 3]; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    /// A ball of radius 1 of `rings` × 2·`rings` quads with shared vertices, those but the poles moved
    /// in or out at random by up to `dents`.
    pub fn ball(rings: usize, dents: f64) -> Self {
        let mut rng = Random::new(21);
        let columns = 2 * rings;
        let mut ball = Shape::default();
        for (i, j) in (0..=rings).flat_map(|i| (0..columns).map(move |j| (i, j))) {
            let (theta, phi) = (PI * i as f64 / rings as f64, TAU * j as f64 / columns as f64);
            let pole = i == 0 || i == rings;
            let r = if pole { 1.0 } else { 1.0 + dents * f64::from(rng.signed()) };
            let sin = if pole { 0.0 } else { theta.sin() };
            ball.positions.push([r * sin * phi.cos(), r * theta.cos(), r * sin * phi.sin()]);
        }
        for (i, j) in (0..rings).flat_map(|i| (0..columns).map(move |j| (i, j))) {
            let at = |i: usize, j: usize| (i * columns + j % columns) as u32;
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
            if i > 0 {
                ball.triangles.push([a, b, c]);
            }
            if i + 1 < rings {
                ball.triangles.push([b, d, c]);
            }
        }
        ball
    }

    /// The cube [−1, 1]³, each face cut along `cuts` (ascending, from −1 to 1) on both of its axes; vertices are equal
    /// where they meet, not shared. Faces look inwards.
    pub fn cube(cuts: &[f64]) -> Self {
        let mut cube = Shape::default();
        for face in 0..6 {
            let point = |a: f64, b: f64| {
                let mut v = [0.0; 3];
                let side = if face % 2 == 0 { -1.0 } else { 1.0 };
                (v[face / 2], v[(face / 2 + 1) % 3], v[(face / 2 + 2) % 3]) = (side, a, b);
                v
            };
            for (a, b) in cuts.windows(2).flat_map(|a| cuts.windows(2).map(move |b| (a, b))) {
                let inwards = |[p, q, r]: [[f64; 3]; 3]| if face % 2 == 0 { [p, q, r] } else { [p, r, q] };
                cube.push(inwards([point(a[0], b[0]), point(a[1], b[0]), point(a[0], b[1])]));
                cube.push(inwards([point(a[1], b[0]), point(a[1], b[1]), point(a[0], b[1])]));
            }
        }
        cube
    }

    /// p ↦ `scale`·(`center` + `radius`·p), rounded to f32.
    pub fn placed(&self, center: [f64; 3], radius: f64, scale: f64) -> Placed {
        let place = |p: &[f64; 3]| [0, 1, 2].map(|k| (scale * (center[k] + radius * p[k])) as f32);
        let positions = self.positions.iter().map(place).collect();
        Placed { positions, triangles: self.triangles.clone(), center: center.map(|c| (scale * c) as f32) }
    }
}

/// A mesh in a scene's own unit.
#[derive(Clone, Debug)]
pub struct Placed {
    pub positions: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub center: [f32; 3],
}

impl Placed {
    pub fn vertices(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Prepared as a scene file's meshes are: rescaled, and with the lists or the tree.
    pub fn world(&self, geometry: GeometryMode) -> World {
        world(&scene(self.positions.clone(), self.triangles.clone(), Vec::new(), self.center), geometry)
    }
}

/// White Lambert under no light, seen by a camera at `position`.
pub fn scene(
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    spheres: Vec<([f32; 3], f32)>,
    position: [f32; 3],
) -> Scene {
    let bsdf = Bsdf::Diffuse { reflectance: [1.0; 3] };
    let white = Material { name: "white".into(), bsdf, ..Material::default() };
    let mut look_at = position;
    look_at[2] = look_at[2].next_down() - 1.0;
    Scene {
        name: "catalogue".into(),
        camera: Camera { position, look_at, up: [0.0, 1.0, 0.0], vfov: 90.0, lens_radius: 0.0, focus_distance: 1.0 },
        film: FilmSize { width: 8, height: 8 },
        integrator: Integrator { kind: IntegratorKind::Path, max_bounces: 7, max_depth: 1.0, ..Integrator::default() },
        environment: None,
        delta_lights: Vec::new(),
        mesh: Mesh { material: vec![0; triangles.len()], positions, triangles, ..Mesh::default() },
        spheres: spheres.into_iter().map(|(center, radius)| Sphere { center, radius, material: 0 }).collect(),
        materials: vec![white],
        assumptions: Vec::new(),
        files: Vec::new(),
    }
}

/// The scene with everything kept, traversed as told.
///
/// # Panics
/// The catalogue's scenes have fewer lights than the light table holds.
pub fn world(scene: &Scene, geometry: GeometryMode) -> World {
    let plan = Plan::new(scene, Force { general: true, geometry: Some(geometry) }, false);
    World::new(scene, plan, Prepare::default()).unwrap_or_else(|error| unreachable!("{error}"))
}
