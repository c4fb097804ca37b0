//! Scenes built in code.

use super::{
    Bsdf, Camera, DeltaLight, Environment, EnvironmentImage, FilmSize, Integrator, InvalidScene, Material, Mesh,
    NO_NORMAL, NO_TEXCOORD, Scene, Sphere,
};

/// Adds to a scene part by part. Nothing is looked at before [`SceneBuilder::build`].
///
/// ```
/// use octolux::scene::{Bsdf, Camera, SceneBuilder};
/// let mut scene = SceneBuilder::new(Camera::towards([0.0, 1.0, 4.0], [0.0; 3], 45.0), 64, 48);
/// let white = scene.material(Bsdf::Diffuse { reflectance: [0.7; 3] });
/// let lamp = scene.emitter([5.0; 3]);
/// let corners = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]];
/// scene.mesh(&corners, &[[0, 1, 2], [0, 2, 3]], white);
/// scene.sphere([0.0, 2.0, 0.0], 0.25, lamp);
/// assert_eq!(scene.build()?.mesh.triangles.len(), 2);
/// # Ok::<(), octolux::scene::InvalidScene>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneBuilder {
    scene: Scene,
}

impl Camera {
    /// A pinhole at `position` that looks at `look_at`, +y up; `vfov` is the full vertical field of view in degrees.
    pub fn towards(position: [f32; 3], look_at: [f32; 3], vfov: f32) -> Self {
        Camera { position, look_at, up: [0.0, 1.0, 0.0], vfov, lens_radius: 0.0, focus_distance: 1.0 }
    }
}

/// Opaque and without images.
impl From<Bsdf> for Material {
    fn from(bsdf: Bsdf) -> Self {
        Material { bsdf, ..Material::default() }
    }
}

impl SceneBuilder {
    /// Nothing before a camera, on a film of `width` × `height` pixels, for paths of at most seven bounces.
    pub fn new(camera: Camera, width: u32, height: u32) -> Self {
        let scene = Scene {
            name: "built in code".to_owned(),
            camera,
            film: FilmSize { width, height },
            integrator: Integrator::default(),
            environment: None,
            delta_lights: Vec::new(),
            mesh: Mesh::default(),
            spheres: Vec::new(),
            materials: Vec::new(),
            assumptions: Vec::new(),
            files: Vec::new(),
        };
        SceneBuilder { scene }
    }

    /// Adds a material; returns its index.
    pub fn material(&mut self, material: impl Into<Material>) -> u32 {
        self.scene.materials.push(material.into());
        self.scene.materials.len() as u32 - 1
    }

    /// Adds a black material that emits `radiance` from its front; returns its index.
    pub fn emitter(&mut self, radiance: [f32; 3]) -> u32 {
        self.material(Material { emission: radiance, ..Material::default() })
    }

    /// Adds triangles, counter-clockwise seen from their front: three indices into `positions` each.
    pub fn mesh(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]], material: u32) {
        self.mesh_with(positions, triangles, &[], &[], material);
    }

    /// The same with a unit shading normal and a texture coordinate for each position; either may be empty.
    pub fn mesh_with(
        &mut self,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        normals: &[[f32; 3]],
        texcoords: &[[f32; 2]],
        material: u32,
    ) {
        self.scene.mesh.add(positions, triangles, normals, texcoords, material);
    }

    /// Adds a sphere.
    pub fn sphere(&mut self, center: [f32; 3], radius: f32, material: u32) {
        self.scene.spheres.push(Sphere { center, radius, material });
    }

    /// Adds a light without extent.
    pub fn light(&mut self, light: DeltaLight) {
        self.scene.delta_lights.push(light);
    }

    /// The same radiance from everywhere outside.
    pub fn environment(&mut self, radiance: [f32; 3]) {
        self.scene.environment = Some(Environment::Constant(radiance));
    }

    /// Radiance from outside by an image.
    pub fn sky(&mut self, image: EnvironmentImage) {
        self.scene.environment = Some(Environment::Image(image));
    }

    /// How light is followed.
    pub fn integrator(&mut self, integrator: Integrator) {
        self.scene.integrator = integrator;
    }

    /// The scene so far.
    ///
    /// # Errors
    /// What is out of its domain first.
    pub fn build(&self) -> Result<Scene, InvalidScene> {
        self.scene.validate()?;
        Ok(self.scene.clone())
    }
}

impl Mesh {
    /// See [`SceneBuilder::mesh_with`].
    pub(super) fn add(
        &mut self,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        normals: &[[f32; 3]],
        texcoords: &[[f32; 2]],
        material: u32,
    ) {
        let before = self.triangles.len();
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(positions);
        self.triangles.extend(shifted(triangles, first));
        self.material.resize(self.triangles.len(), material);
        append(&mut self.normals, &mut self.normal_indices, normals, triangles, before, NO_NORMAL);
        append(&mut self.texcoords, &mut self.texcoord_indices, texcoords, triangles, before, NO_TEXCOORD);
    }
}

fn shifted(triangles: &[[u32; 3]], first: u32) -> impl Iterator<Item = [u32; 3]> {
    triangles.iter().map(move |corners| corners.map(|corner| corner.saturating_add(first)))
}

/// Vertex attributes of triangles after the first `before`, which have none yet if no mesh had.
fn append<T: Copy>(
    values: &mut Vec<T>,
    indices: &mut Vec<[u32; 3]>,
    added: &[T],
    triangles: &[[u32; 3]],
    before: usize,
    none: u32,
) {
    if added.is_empty() && values.is_empty() {
        return;
    }
    indices.resize(before, [none; 3]);
    match added.is_empty() {
        true => indices.resize(before + triangles.len(), [none; 3]),
        false => indices.extend(shifted(triangles, values.len() as u32)),
    }
    values.extend_from_slice(added);
}
