//! Pictures with their times and errors.

use octolux::estimate::bmc::Points;
use octolux::film::{Film, png};
use octolux::kernel::{Prepare, Width, World};
use octolux::plan::{Force, Plan};
use octolux::render::{self, Budget, Options, Progress};
use octolux::scene::{
    Bsdf, ConductorFresnel, Gather, GatherMethod, GatherPdf, GatherWeights, IntegratorKind, Masking, Scene,
};
use std::error::Error;
use std::path::Path;

/// The reference shares no number with what is held against it.
const REFERENCE_SEED: u64 = 1 << 40;
/// Renders of which the median time counts.
const TIMES: usize = 5;

struct Studio<'a> {
    scene: &'a Scene,
    pool: rayon::ThreadPool,
    reference: Film,
}

struct Picture {
    name: String,
    film: Film,
    seconds: f64,
}

impl<'a> Studio<'a> {
    fn new(scene: &'a Scene, samples: u64) -> Result<Self, Box<dyn Error>> {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        let pool = render::thread_pool(threads)?;
        let world = prepare(&one_bounce(scene), REFERENCE_SEED)?;
        let reference = film(&pool, &world, samples).0;
        println!("{:28} {:>9} {:>9} {:>8}", "", "seconds", "RMSE", "relMSE");
        Ok(Studio { scene, pool, reference })
    }

    fn gather(&self, name: &str, gather: Gather, times: usize) -> Result<Picture, Box<dyn Error>> {
        let mut scene = self.scene.clone();
        scene.integrator.kind = IntegratorKind::Gather;
        scene.integrator.max_bounces = 1;
        scene.integrator.gather = gather;
        self.picture(name, &scene, 1, times)
    }

    fn picture(&self, name: &str, scene: &Scene, samples: u64, times: usize) -> Result<Picture, Box<dyn Error>> {
        let world = prepare(scene, 0)?;
        let (first, seconds) = film(&self.pool, &world, samples);
        let mut all = vec![seconds];
        all.extend((1..times).map(|_| film(&self.pool, &world, samples).1));
        all.sort_by(f64::total_cmp);
        let picture = Picture { name: name.to_string(), film: first, seconds: all[all.len() / 2] };
        let (rmse, relmse) = self.errors(&picture.film);
        println!("{:28} {:9.4} {:9.5} {:8.1e}", picture.name, picture.seconds, rmse, relmse);
        Ok(picture)
    }

    /// RMSE and relMSE, the reference's own noise taken off.
    fn errors(&self, film: &Film) -> (f64, f64) {
        let (mut square, mut relative) = (0.0, 0.0);
        for (x, y) in (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y))) {
            let (a, b) = (film.mean(x, y), self.reference.mean(x, y));
            let noise = self.reference.variance_of_mean(x, y).unwrap_or_default();
            for c in 0..3 {
                let off = (a[c] - b[c]).powi(2) - noise[c];
                square += off;
                relative += off / (b[c] * b[c] + 0.01);
            }
        }
        let count = f64::from(3 * film.width() * film.height());
        ((square / count).max(0.0).sqrt(), relative / count)
    }
}

fn one_bounce(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    (scene.integrator.kind, scene.integrator.max_bounces) = (IntegratorKind::Path, 1);
    scene
}

fn prepare(scene: &Scene, seed: u64) -> Result<World, Box<dyn Error>> {
    prepare_with(scene, seed, false)
}

/// With features or without: what nobody looks at is not computed.
pub fn prepare_with(scene: &Scene, seed: u64, features: bool) -> Result<World, Box<dyn Error>> {
    let options = Prepare { seed, ..Prepare::default() };
    Ok(World::new(scene, Plan::new(scene, Force::default(), features), options)?)
}

fn film(pool: &rayon::ThreadPool, world: &World, samples: u64) -> (Film, f64) {
    film_with(pool, world, samples, false)
}

pub fn film_with(pool: &rayon::ThreadPool, world: &World, samples: u64, aovs: bool) -> (Film, f64) {
    let options = Options {
        budget: Budget { samples: Some(samples), ..Budget::default() },
        width: Width::native(),
        tile: render::default_tile(world.film.width, world.film.height),
        aovs,
        output_seconds: 0.0,
        adaptive: false,
    };
    let outcome = render::render(world, &options, pool, &mut Progress::quiet());
    (outcome.film, outcome.render_seconds)
}

/// From one set for the whole picture, whose pattern shows, to what costs most.
pub fn stages(scene: &Scene, reference: u64, folder: &Path) -> Result<(), Box<dyn Error>> {
    let studio = Studio::new(scene, reference)?;
    let one =
        Gather { method: GatherMethod::BmcIs, points: Points::Random, sets: 1, rotate: false, ..Gather::default() };
    let fresh = Gather { weights: GatherWeights::PerHit, rotate: false, ..one };
    let pictures = [
        studio.gather("1 one set", one, TIMES)?,
        studio.gather("2 one set, rotated", Gather { rotate: true, ..one }, TIMES)?,
        studio.gather("3 sixteen sets, rotated", Gather { rotate: true, sets: 16, ..one }, TIMES)?,
        studio.gather(
            "4 the same, fibonacci",
            Gather { rotate: true, sets: 16, points: Points::Fibonacci, ..one },
            TIMES,
        )?,
        studio.gather("5 a set of each hit's own", fresh, 1)?,
    ];
    side_by_side(&pictures, &folder.join("stages.png"))
}

/// The four methods at the scene's number of directions, and paths in the time of the last.
pub fn methods(scene: &Scene, reference: u64, folder: &Path) -> Result<(), Box<dyn Error>> {
    let studio = Studio::new(scene, reference)?;
    let samples = scene.integrator.gather.samples;
    let of = |method: GatherMethod| {
        let pdf = if method.is_importance() { GatherPdf::Cosine } else { GatherPdf::Uniform };
        let points = if method.is_bayesian() { Points::Fibonacci } else { Points::Random };
        let weights = if method.is_bayesian() { GatherWeights::Shared } else { GatherWeights::PerHit };
        let rotate = method.is_bayesian();
        Gather { samples, method, pdf, points, weights, rotate, ..Gather::default() }
    };
    let mut pictures = Vec::new();
    for method in [GatherMethod::Mc, GatherMethod::McIs, GatherMethod::Bmc, GatherMethod::BmcIs] {
        pictures.push(studio.gather(method.name(), of(method), TIMES)?);
    }
    side_by_side(&pictures, &folder.join("methods.png"))?;
    let seconds = pictures.last().map_or(0.0, |p| p.seconds);
    let path = one_bounce(scene);
    let trial = film(&studio.pool, &prepare(&path, 0)?, 16).1 / 16.0;
    let equal = ((seconds / trial).round() as u64).max(1);
    studio.picture(&format!("path, one bounce, {equal} spp"), &path, equal, TIMES)?;
    // Directions may be fewer and camera samples more.
    let mut split = scene.clone();
    split.integrator.kind = IntegratorKind::Gather;
    split.integrator.max_bounces = 1;
    split.integrator.gather = Gather { samples: (samples / 4).max(1), ..of(GatherMethod::BmcIs) };
    studio.picture("bmc-is, a quarter, 4 spp", &split, 4, TIMES)?;
    Ok(())
}

/// Glossy spheres: directions about the normal, and about the normal and the mirror direction.
pub fn lobes(scene: &Scene, reference: u64, folder: &Path) -> Result<(), Box<dyn Error>> {
    let phong = Bsdf::Phong { diffuse: [0.4, 0.3, 0.2], specular: [0.5; 3], exponent: 40.0 };
    let fresnel = ConductorFresnel::Schlick { f0: [0.9, 0.7, 0.4] };
    let metal = Bsdf::Conductor { alpha: 0.2, masking: Masking::Correlated, fresnel };
    for (name, bsdf) in [("phong", phong), ("metal", metal)] {
        let mut scene = scene.clone();
        for sphere in &scene.spheres {
            scene.materials[sphere.material as usize].bsdf = bsdf;
        }
        println!("{name}");
        let studio = Studio::new(&scene, reference)?;
        let samples = scene.integrator.gather.samples;
        let mut pictures = Vec::new();
        for (pdf, word) in [(GatherPdf::Cosine, "cosine"), (GatherPdf::Lobe, "lobe")] {
            for method in [GatherMethod::McIs, GatherMethod::BmcIs] {
                let gather = Gather { samples, method, pdf, ..Gather::default() };
                pictures.push(studio.gather(&format!("{}, {word}", method.name()), gather, TIMES)?);
            }
        }
        side_by_side(&pictures, &folder.join(format!("lobes-{name}.png")))?;
    }
    Ok(())
}

fn side_by_side(pictures: &[Picture], path: &Path) -> Result<(), Box<dyn Error>> {
    let Some(first) = pictures.first() else { return Ok(()) };
    let width = first.film.width();
    png::write_with(path, (width * pictures.len() as u32, first.film.height()), |x, y| {
        pictures[(x / width) as usize].film.mean(x % width, y).map(png::srgb8)
    })?;
    Ok(())
}
