//! Renders of one scene against its reference image.

use octolux::film::{Film, read_exr};
use octolux::kernel::{Prepare, Width, World};
use octolux::plan::{Force, Plan};
use octolux::render::{self, Budget, Options, Progress};
use octolux::scene;
use std::error::Error;
use std::path::Path;

/// How to render.
pub struct Settings {
    pub samples: u64,
    pub seeds: u64,
    pub pool: rayon::ThreadPool,
}

/// What the renders of one scene show.
#[derive(serde::Serialize)]
pub struct Measured {
    pub scene: String,
    pub samples_per_pixel: u64,
    pub seeds: u64,
    /// All renders together, rendering alone.
    pub seconds: f64,
    pub paths_per_second: f64,
    /// Mean over the renders of mean((x − r)²/(r² + 0.01)) − floor.
    pub relmse_minus_floor: f64,
    /// From the spread over the renders; absent for one.
    pub relmse_standard_error: Option<f64>,
    /// The reference's own noise.
    pub floor: f64,
    /// relMSE − floor at one sample per pixel.
    pub c: f64,
    pub mean_ratio: [f64; 3],
    /// Of the ratio: our noise and the reference's.
    pub mean_ratio_error: [f64; 3],
    pub discarded: u64,
}

/// The reference: image, and what its maker says about its noise.
struct Reference {
    planes: [Vec<f64>; 3],
    mean: [f64; 3],
    mean_error: [f64; 3],
    floor: f64,
}

impl Reference {
    fn load(folder: &Path, name: &str) -> Result<Self, Box<dyn Error>> {
        let image = read_exr(&folder.join(format!("{name}.exr")))?;
        let text = std::fs::read_to_string(folder.join(format!("{name}.json")))?;
        let facts: serde_json::Value = serde_json::from_str(&text)?;
        let number = |value: &serde_json::Value| value.as_f64().ok_or(format!("{name}.json: a number is missing"));
        let planes = image.rgb().map(|plane| plane.iter().map(|&x| f64::from(x)).collect::<Vec<_>>());
        let mean = std::array::from_fn(|c| planes[c].iter().sum::<f64>() / planes[c].len() as f64);
        let mut mean_error = [0.0; 3];
        for (c, error) in mean_error.iter_mut().enumerate() {
            *error = number(&facts["mean_sem"][c])?;
        }
        Ok(Reference { planes, mean, mean_error, floor: number(&facts["relmse_floor"])? })
    }

    fn relmse(&self, film: &Film) -> f64 {
        let mut sum = 0.0;
        for y in 0..film.height() {
            for x in 0..film.width() {
                let mean = film.mean(x, y);
                for (m, plane) in mean.into_iter().zip(&self.planes) {
                    let r = plane[(y * film.width() + x) as usize];
                    sum += (m - r).powi(2) / (r * r + 0.01);
                }
            }
        }
        sum / (3.0 * f64::from(film.width()) * f64::from(film.height()))
    }
}

/// Mean of an image and the variance of that mean.
fn image_mean(film: &Film) -> ([f64; 3], [f64; 3]) {
    let pixels = f64::from(film.width()) * f64::from(film.height());
    let (mut mean, mut variance) = ([0.0; 3], [0.0; 3]);
    for y in 0..film.height() {
        for x in 0..film.width() {
            let (m, v) = (film.mean(x, y), film.variance_of_mean(x, y).unwrap_or([f64::INFINITY; 3]));
            mean = std::array::from_fn(|c| mean[c] + m[c] / pixels);
            variance = std::array::from_fn(|c| variance[c] + v[c] / (pixels * pixels));
        }
    }
    (mean, variance)
}

pub fn measure(folder: &Path, name: &str, settings: &Settings) -> Result<Measured, Box<dyn Error>> {
    let reference = Reference::load(folder, name)?;
    let scene = scene::load(&folder.join(name).join("scene.toml"))?;
    if (scene.film.width * scene.film.height) as usize != reference.planes[0].len() {
        return Err(format!("{name}: scene and reference image differ in size").into());
    }
    let mut world = World::new(&scene, Plan::new(&scene, Force::default(), false), Prepare::default())?;
    let options = Options {
        budget: Budget { samples: Some(settings.samples), ..Budget::default() },
        width: Width::native(),
        tile: render::default_tile(scene.film.width, scene.film.height),
        aovs: false,
        output_seconds: 0.0,
        adaptive: false,
    };
    let (mut seconds, mut paths, mut discarded) = (0.0, 0, 0);
    let (mut relmse, mut mean, mut variance) = (Vec::new(), [0.0; 3], [0.0; 3]);
    for seed in 0..settings.seeds {
        world.seed = seed;
        let outcome = render::render(&world, &options, &settings.pool, &mut Progress::quiet());
        seconds += outcome.render_seconds;
        paths += outcome.counters.camera_rays;
        discarded += outcome.film.discarded().count;
        relmse.push(reference.relmse(&outcome.film));
        let (m, v) = image_mean(&outcome.film);
        let renders = settings.seeds as f64;
        mean = std::array::from_fn(|c| mean[c] + m[c] / renders);
        variance = std::array::from_fn(|c| variance[c] + v[c] / (renders * renders));
    }
    let (relmse, relmse_standard_error) = mean_and_error(&relmse);
    let error = |c: usize| (variance[c] + reference.mean_error[c].powi(2)).sqrt() / reference.mean[c];
    Ok(Measured {
        scene: name.to_string(),
        samples_per_pixel: settings.samples,
        seeds: settings.seeds,
        seconds,
        paths_per_second: paths as f64 / seconds,
        relmse_minus_floor: relmse - reference.floor,
        relmse_standard_error,
        floor: reference.floor,
        c: (relmse - reference.floor) * settings.samples as f64,
        mean_ratio: std::array::from_fn(|c| mean[c] / reference.mean[c]),
        mean_ratio_error: std::array::from_fn(error),
        discarded,
    })
}

fn mean_and_error(values: &[f64]) -> (f64, Option<f64>) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (values.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt()))
}
