//! Scenes by hand.

use octolux::scene::*;

/// Builds a [`Scene`]: `SceneBuilder::new().camera(…).quad(…).build()`. Defaults: 1 × 1 pixel, black surroundings, path
/// integrator with 1 bounce.
#[derive(Clone, Debug)]
pub struct SceneBuilder {
    scene: Scene,
}

pub const LAMBERT: fn(f32) -> Bsdf = |rho| Bsdf::Diffuse { reflectance: [rho; 3] };

impl SceneBuilder {
    pub fn new() -> Self {
        let camera = Camera {
            position: [0.0; 3],
            look_at: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            vfov: 60.0,
            lens_radius: 0.0,
            focus_distance: 1.0,
        };
        SceneBuilder {
            scene: Scene {
                name: "by hand".to_string(),
                camera,
                film: FilmSize { width: 1, height: 1 },
                integrator: Integrator {
                    kind: IntegratorKind::Path,
                    max_bounces: 1,
                    max_depth: 1.0,
                    ..Integrator::default()
                },
                environment: None,
                delta_lights: Vec::new(),
                mesh: Mesh::default(),
                spheres: Vec::new(),
                materials: Vec::new(),
                assumptions: Vec::new(),
                files: Vec::new(),
            },
        }
    }

    /// `up` is chosen not to be parallel: y, or z for a camera looking along y.
    pub fn camera(mut self, position: [f32; 3], look_at: [f32; 3], vfov: f32) -> Self {
        let along_y = (0..3).all(|i| i == 1 || position[i] == look_at[i]);
        let up = if along_y { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        self.scene.camera = Camera { position, look_at, up, vfov, ..self.scene.camera };
        self
    }

    pub fn film(mut self, width: u32, height: u32) -> Self {
        self.scene.film = FilmSize { width, height };
        self
    }

    pub fn bounces(mut self, max_bounces: u32) -> Self {
        self.scene.integrator.max_bounces = max_bounces;
        self
    }

    pub fn environment(mut self, environment: Environment) -> Self {
        self.scene.environment = Some(environment);
        self
    }

    /// Constant and grey.
    pub fn sky(self, radiance: f32) -> Self {
        self.environment(Environment::Constant([radiance; 3]))
    }

    pub fn triangle(mut self, p: [[f32; 3]; 3], bsdf: Bsdf, emission: f32) -> Self {
        let material = self.material(bsdf, [emission; 3]);
        let mesh = &mut self.scene.mesh;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(p);
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.material.push(material);
        if !mesh.normal_indices.is_empty() {
            mesh.normal_indices.push([NO_NORMAL; 3]);
        }
        self
    }

    /// A triangle with unit vertex normals.
    pub fn smooth_triangle(mut self, p: [[f32; 3]; 3], n: [[f32; 3]; 3], bsdf: Bsdf, emission: f32) -> Self {
        self = self.triangle(p, bsdf, emission);
        let mesh = &mut self.scene.mesh;
        mesh.normal_indices.resize(mesh.triangles.len(), [NO_NORMAL; 3]);
        let first = mesh.normals.len() as u32;
        mesh.normals.extend(n);
        mesh.normal_indices[mesh.triangles.len() - 1] = [first, first + 1, first + 2];
        self
    }

    /// Two triangles; corners counter-clockwise seen from the front.
    pub fn quad(self, p: [[f32; 3]; 4], bsdf: Bsdf, emission: f32) -> Self {
        self.triangle([p[0], p[1], p[2]], bsdf, emission).triangle([p[0], p[2], p[3]], bsdf, emission)
    }

    /// An axis-aligned box from its six faces, in the order −x, +x, −y, +y, −z, +z; `inward` turns the fronts inside.
    pub fn cuboid(mut self, lo: [f32; 3], hi: [f32; 3], inward: bool, face: impl Fn(usize) -> (Bsdf, f32)) -> Self {
        for i in 0..6 {
            let (axis, upper) = (i / 2, i % 2 == 1);
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |s: bool, t: bool| {
                let mut p = [0.0; 3];
                p[axis] = if upper { hi[axis] } else { lo[axis] };
                p[a] = if s { hi[a] } else { lo[a] };
                p[b] = if t { hi[b] } else { lo[b] };
                p
            };
            // Counter-clockwise seen from the upper side of the axis.
            let mut p = [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
            if upper == inward {
                p.reverse();
            }
            let (bsdf, emission) = face(i);
            self = self.quad(p, bsdf, emission);
        }
        self
    }

    pub fn sphere(mut self, center: [f32; 3], radius: f32, bsdf: Bsdf, emission: f32) -> Self {
        let material = self.material(bsdf, [emission; 3]);
        self.scene.spheres.push(Sphere { center, radius, material });
        self
    }

    pub fn build(self) -> Scene {
        self.scene
    }

    fn material(&mut self, bsdf: Bsdf, emission: [f32; 3]) -> u32 {
        let materials = &mut self.scene.materials;
        let same = materials.iter().position(|m| m.bsdf == bsdf && m.emission == emission);
        same.unwrap_or_else(|| {
            materials.push(Material { name: format!("m{}", materials.len()), bsdf, emission, ..Material::default() });
            materials.len() - 1
        }) as u32
    }
}
