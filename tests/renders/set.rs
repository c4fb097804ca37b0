//! A scene under construction.

use octolux::scene::{
    Bsdf, Camera, DeltaLight, Environment, FilmSize, Integrator, IntegratorKind, Material, Mesh, NO_NORMAL, Scene,
    Sphere,
};

pub type Point = [f64; 3];

/// Builds a [`Scene`] from points in f64, rounded as they are handed over.
pub struct Set {
    scene: Scene,
}

impl Set {
    /// Nothing yet but a camera with a square film of `side` pixels; `path`, 7 bounces.
    pub fn new(position: Point, look_at: Point, vfov: f64, side: u32) -> Self {
        // Any direction that is not the viewing direction will do.
        let forward: Point = std::array::from_fn(|k| look_at[k] - position[k]);
        let upright = forward[1].abs() < 0.9 * forward.iter().map(|x| x * x).sum::<f64>().sqrt();
        let camera = Camera {
            position: single(position),
            look_at: single(look_at),
            up: if upright { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] },
            vfov: vfov as f32,
            lens_radius: 0.0,
            focus_distance: 1.0,
        };
        let integrator =
            Integrator { kind: IntegratorKind::Path, max_bounces: 7, max_depth: 1.0, ..Integrator::default() };
        let scene = Scene {
            name: "built by a test".into(),
            camera,
            film: FilmSize { width: side, height: side },
            integrator,
            environment: None,
            delta_lights: Vec::new(),
            mesh: Mesh::default(),
            spheres: Vec::new(),
            materials: Vec::new(),
            assumptions: Vec::new(),
            files: Vec::new(),
        };
        Set { scene }
    }

    pub fn bounces(mut self, max_bounces: u32) -> Self {
        self.scene.integrator.max_bounces = max_bounces;
        self
    }

    pub fn integrator(mut self, kind: IntegratorKind) -> Self {
        self.scene.integrator.kind = kind;
        self
    }

    pub fn environment(mut self, environment: Environment) -> Self {
        self.scene.environment = Some(environment);
        self
    }

    /// Environment of radiance 1.
    pub fn uniform_light(self) -> Self {
        self.environment(Environment::Constant([1.0; 3]))
    }

    /// Adds a light without extent.
    pub fn light(mut self, light: DeltaLight) -> Self {
        self.scene.delta_lights.push(light);
        self
    }

    pub fn lens(mut self, radius: f32, focus_distance: f32) -> Self {
        (self.scene.camera.lens_radius, self.scene.camera.focus_distance) = (radius, focus_distance);
        self
    }

    /// Returns the material's index.
    pub fn material(&mut self, bsdf: Bsdf, emission: [f32; 3]) -> u32 {
        let index = self.scene.materials.len() as u32;
        self.scene.materials.push(Material {
            name: format!("material {index}"),
            bsdf,
            emission,
            ..Material::default()
        });
        index
    }

    /// Lambert, with emission, the same in all channels.
    pub fn grey(&mut self, reflectance: f32, emission: f32) -> u32 {
        self.material(Bsdf::Diffuse { reflectance: [reflectance; 3] }, [emission; 3])
    }

    /// Counter-clockwise from the front.
    pub fn triangle(&mut self, material: u32, corners: [Point; 3]) {
        let mesh = &mut self.scene.mesh;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(single));
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.material.push(material);
        if !mesh.normals.is_empty() {
            mesh.normal_indices.push([NO_NORMAL; 3]);
        }
    }

    /// A triangle with a unit normal at each corner.
    pub fn smooth_triangle(&mut self, material: u32, corners: [Point; 3], normals: [Point; 3]) {
        self.triangle(material, corners);
        let mesh = &mut self.scene.mesh;
        let first = mesh.normals.len() as u32;
        mesh.normals.extend(normals.map(single));
        mesh.normal_indices.resize(mesh.triangles.len(), [NO_NORMAL; 3]);
        if let Some(last) = mesh.normal_indices.last_mut() {
            *last = [first, first + 1, first + 2];
        }
    }

    /// A planar quad, counter-clockwise from the front.
    pub fn quad(&mut self, material: u32, [a, b, c, d]: [Point; 4]) {
        self.triangle(material, [a, b, c]);
        self.triangle(material, [a, c, d]);
    }

    /// The six sides of a box, facing inwards: low and high x, y, z.
    pub fn room(&mut self, materials: [u32; 6], lo: Point, hi: Point) {
        for (material, [a, b, c, d]) in materials.into_iter().zip(sides(lo, hi)) {
            self.quad(material, [d, c, b, a]);
        }
    }

    /// The six sides of a box, facing outwards.
    pub fn block(&mut self, material: u32, lo: Point, hi: Point) {
        for side in sides(lo, hi) {
            self.quad(material, side);
        }
    }

    pub fn sphere(&mut self, material: u32, center: Point, radius: f64) {
        self.scene.spheres.push(Sphere { center: single(center), radius: radius as f32, material });
    }

    /// What there is so far.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// To change what no method here does.
    pub fn scene_mut(&mut self) -> &mut Scene {
        &mut self.scene
    }

    pub fn finish(self) -> Scene {
        self.scene
    }
}

fn single(p: Point) -> [f32; 3] {
    p.map(|x| x as f32)
}

/// Sides of a box, counter-clockwise seen from outside.
fn sides(lo: Point, hi: Point) -> [[Point; 4]; 6] {
    let corner = |i: usize| -> Point { std::array::from_fn(|k| if i >> k & 1 == 1 { hi[k] } else { lo[k] }) };
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]].map(|side| side.map(corner))
}
