//! `octolux info`: what a scene holds, what the plan makes of it and what memory that takes.

use super::CliError;
use super::scene_args::SceneArgs;
use super::targets::{check_apart, check_folders, write_json};
use crate::kernel::{Setup, World};
use crate::plan::{Force, Plan};
use crate::scene::{Environment, Image, NO_NORMAL, Scene};
use std::fmt;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct InfoArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// As JSON; `-` writes it to standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

/// What a scene holds.
#[derive(serde::Serialize)]
struct Info {
    scene: String,
    width: u32,
    height: u32,
    integrator: String,
    max_bounces: u32,
    triangles: usize,
    smooth_triangles: usize,
    vertices: usize,
    spheres: usize,
    /// Corners of the box around all primitives, in the scene's unit; none in an empty scene.
    bounds: Option<[[f32; 3]; 2]>,
    materials: Vec<MaterialInfo>,
    textures: Vec<TextureInfo>,
    lights: LightInfo,
    memory: Memory,
    seconds: Seconds,
    plan: Plan,
}

#[derive(serde::Serialize)]
struct MaterialInfo {
    name: String,
    model: String,
    emits: bool,
    primitives: usize,
}

/// An image, and which materials wear it as what.
#[derive(serde::Serialize)]
struct TextureInfo {
    file: String,
    width: u32,
    height: u32,
    channels: usize,
    bytes: usize,
    worn_as: Vec<String>,
}

#[derive(serde::Serialize)]
struct LightInfo {
    emitting_primitives: usize,
    without_extent: usize,
    environment: String,
}

/// Bytes that the kernel reads, what the process took at most, and what a render's film adds a pixel.
#[derive(serde::Serialize)]
struct Memory {
    tree_bytes: usize,
    list_bytes: usize,
    row_bytes: usize,
    peak_bytes: Option<u64>,
    film_bytes: u64,
}

#[derive(serde::Serialize)]
struct Seconds {
    load: f64,
    setup: f64,
}

pub fn run(args: &InfoArgs) -> Result<bool, CliError> {
    check_folders(args.json.as_deref().filter(|path| *path != Path::new("-")))?;
    let (scene, world, times) = args.scene.world(Force::default(), false, args.quiet)?;
    check_apart(args.json.as_deref(), scene.files.iter().map(PathBuf::as_path))?;
    let info = Info::new(&scene, &world, Seconds { load: times.load, setup: times.setup });
    match &args.json {
        Some(path) => write_json(&info, Some(path))?,
        None => print!("{info}"),
    }
    Ok(true)
}

impl Info {
    fn new(scene: &Scene, world: &World, seconds: Seconds) -> Self {
        let mut worn = vec![0; scene.materials.len()];
        let of_primitives = scene.mesh.material.iter().copied().chain(scene.spheres.iter().map(|s| s.material));
        of_primitives.for_each(|material| worn[material as usize] += 1);
        let materials: Vec<MaterialInfo> = scene
            .materials
            .iter()
            .zip(worn)
            .map(|(material, primitives)| MaterialInfo {
                name: material.name.clone(),
                model: first_word(&format!("{:?}", material.bsdf)),
                emits: material.emission.iter().any(|&e| e > 0.0),
                primitives,
            })
            .collect();
        let environment = match &scene.environment {
            None => "none".to_string(),
            Some(Environment::Constant(c)) => format!("constant {c:?}"),
            Some(Environment::Image(image)) => format!("{} × {} image", image.width, image.height),
        };
        let lights = LightInfo {
            emitting_primitives: materials.iter().filter(|m| m.emits).map(|m| m.primitives).sum(),
            without_extent: scene.delta_lights.len(),
            environment,
        };
        let Setup { tree, row_bytes, .. } = &world.setup;
        let pixels = u64::from(scene.film.width) * u64::from(scene.film.height);
        Info {
            scene: scene.name.clone(),
            width: scene.film.width,
            height: scene.film.height,
            integrator: first_word(&format!("{:?}", scene.integrator.kind)),
            max_bounces: scene.integrator.max_bounces,
            triangles: scene.mesh.triangles.len(),
            smooth_triangles: scene.mesh.normal_indices.iter().filter(|n| n[0] != NO_NORMAL).count(),
            vertices: scene.mesh.positions.len(),
            spheres: scene.spheres.len(),
            bounds: bounds(scene),
            materials,
            textures: textures(scene),
            lights,
            memory: Memory {
                tree_bytes: tree.node_bytes + tree.block_bytes,
                list_bytes: tree.list_bytes,
                row_bytes: *row_bytes,
                peak_bytes: crate::process::peak_memory_bytes(),
                // Six f64 sums.
                film_bytes: 48 * pixels,
            },
            seconds,
            plan: world.plan.clone(),
        }
    }
}

/// Each image once, in the order of the materials.
fn textures(scene: &Scene) -> Vec<TextureInfo> {
    let mut images: Vec<(*const Image, TextureInfo)> = Vec::new();
    for material in &scene.materials {
        for (role, texture) in material.maps.named() {
            let (image, use_) = (&*texture.image, format!("{role} of {}", material.name));
            match images.iter_mut().find(|(known, _)| std::ptr::eq(*known, image)) {
                Some((_, info)) => info.worn_as.push(use_),
                None => {
                    let &Image { width, height, channels, .. } = image;
                    let (file, bytes) = (texture.file.0.clone(), image.memory());
                    images.push((image, TextureInfo { file, width, height, channels, bytes, worn_as: vec![use_] }));
                }
            }
        }
    }
    images.into_iter().map(|(_, info)| info).collect()
}

/// The name of a variant from its `Debug` text.
pub fn first_word(debug: &str) -> String {
    debug.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("").to_lowercase()
}

fn bounds(scene: &Scene) -> Option<[[f32; 3]; 2]> {
    let spheres = scene.spheres.iter().flat_map(|s| [s.center.map(|c| c - s.radius), s.center.map(|c| c + s.radius)]);
    let mut points = scene.mesh.positions.iter().copied().chain(spheres);
    let first = points.next()?;
    Some(points.fold([first, first], |[low, high], p| {
        [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
    }))
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Info { scene, width, height, integrator, max_bounces, triangles, vertices, .. } = self;
        writeln!(f, "{scene}: {width} × {height}, {integrator}, at most {max_bounces} bounces")?;
        let smooth = self.smooth_triangles;
        writeln!(
            f,
            "geometry: {triangles} triangles ({smooth} smooth), {vertices} vertices, {} spheres",
            self.spheres
        )?;
        if let Some([low, high]) = self.bounds {
            writeln!(f, "bounds: {low:?} to {high:?}")?;
        }
        let LightInfo { emitting_primitives, without_extent, environment } = &self.lights;
        writeln!(
            f,
            "lights: {emitting_primitives} emitting primitives, {without_extent} without extent, environment {environment}"
        )?;
        writeln!(f, "materials: {}", self.materials.len())?;
        for MaterialInfo { name, model, emits, primitives } in &self.materials {
            let emits = if *emits { ", emits" } else { "" };
            writeln!(f, "  {name:24} {model}{emits}, on {primitives} primitives")?;
        }
        if !self.textures.is_empty() {
            writeln!(f, "textures: {}", self.textures.len())?;
        }
        for TextureInfo { file, width, height, channels, bytes, worn_as } in &self.textures {
            let kilo = *bytes as f64 / 1e3;
            writeln!(f, "  {file}: {width} × {height}, {channels} channels, {kilo:.1} kB; {}", worn_as.join(", "))?;
        }
        let mega = |bytes: u64| bytes as f64 / 1e6;
        let Memory { tree_bytes, list_bytes, row_bytes, peak_bytes, film_bytes } = self.memory;
        writeln!(
            f,
            "memory: {:.1} MB tree, {:.1} MB lists, {:.1} MB rows; a film of {:.1} MB; {:.0} MB at most so far",
            mega(tree_bytes as u64),
            mega(list_bytes as u64),
            mega(row_bytes as u64),
            mega(film_bytes),
            mega(peak_bytes.unwrap_or(0))
        )?;
        writeln!(f, "seconds: {:.3} load, {:.3} build", self.seconds.load, self.seconds.setup)?;
        write!(f, "{}", self.plan.explain())
    }
}
