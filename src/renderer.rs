//! From a scene to a film in one call, for programs.

use crate::film::Film;
use crate::kernel::{self, Counters, Job, Prepare, SampleBuffer, Width, World};
use crate::lane::{f32x8, f32x16};
use crate::light::LightError;
use crate::own::{self, Bsdf, Integrand, Light, Numbers, Own};
use crate::plan::{Force, Plan};
use crate::render::{self, Budget, JobKernel, Options, Progress};
use crate::sampling::SamplerKind;
use crate::scene::{IntegratorKind, InvalidScene, Scene};
use std::sync::Arc;

/// How to render a scene. The film's bits depend on the scene, the samples, the seed and the sampler alone.
///
/// ```
/// use octolux::scene::{Bsdf, Camera, SceneBuilder};
/// let mut scene = SceneBuilder::new(Camera::towards([0.0, 1.0, 5.0], [0.0, 1.0, 0.0], 40.0), 32, 32);
/// let clay = scene.material(Bsdf::Diffuse { reflectance: [0.8, 0.4, 0.2] });
/// scene.sphere([0.0, 1.0, 0.0], 1.0, clay);
/// scene.environment([1.0; 3]);
/// let film = octolux::Renderer::new(16).render(&scene.build()?)?;
/// assert!((film.mean(16, 16)[0] - 0.8).abs() < 0.05); // a convex body under an even sky shows its colour
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Renderer {
    samples: u64,
    prepare: Prepare,
    width: Width,
    threads: Option<usize>,
    tile: Option<u32>,
    numbers: Option<Arc<dyn Numbers>>,
}

/// A scene cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// Something in it is out of its domain.
    #[error(transparent)]
    Scene(#[from] InvalidScene),
    /// Its lights cannot be tabulated.
    #[error(transparent)]
    Lights(#[from] LightError),
    /// The operating system gives no threads.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// An own BSDF or light with an integrator that follows no paths.
    #[error("an own BSDF or light takes part in `path` and `direct`; this scene's integrator is {0:?}")]
    NoPaths(IntegratorKind),
}

impl Renderer {
    /// `samples` a pixel (at most [`MAX_SAMPLES`](render::budget::MAX_SAMPLES), at least 1), seed 0, Sobol' points, the
    /// build's fastest width, a thread a core.
    pub fn new(samples: u64) -> Self {
        let prepare = Prepare { sampler: SamplerKind::Sobol, ..Prepare::default() };
        Renderer { samples: samples.max(1), prepare, width: Width::native(), threads: None, tile: None, numbers: None }
    }

    /// Seed of every random number.
    pub fn seed(mut self, seed: u64) -> Self {
        self.prepare.seed = seed;
        self
    }

    /// How the samples of a pixel relate.
    pub fn sampler(mut self, sampler: SamplerKind) -> Self {
        self.prepare.sampler = sampler;
        self
    }

    /// Random numbers of the program's own, in place of seed and sampler. An integrator `gather` keeps its own.
    pub fn numbers(mut self, numbers: impl Numbers + 'static) -> Self {
        self.numbers = Some(Arc::new(numbers));
        self
    }

    /// Lanes to render in.
    pub fn lanes(mut self, width: Width) -> Self {
        self.width = width;
        self
    }

    /// Worker threads, at least 1.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads.max(1));
        self
    }

    /// Side of a tile in pixels, in 1 … 512.
    pub fn tile(mut self, side: u32) -> Self {
        self.tile = Some(side.clamp(1, 512));
        self
    }

    /// Renders a scene by its integrator.
    ///
    /// # Errors
    /// See [`RenderError`].
    pub fn render(&self, scene: &Scene) -> Result<Film, RenderError> {
        let world = self.world(scene, |plan| plan)?;
        self.run(&world, &kernel::select(&world, self.width))
    }

    /// Renders a scene by its integrator (`path` or `direct`) with a BSDF and a light of the program's own.
    ///
    /// # Errors
    /// See [`RenderError`].
    pub fn render_with<B: Bsdf, L: Light>(&self, scene: &Scene, own: &Own<B, L>) -> Result<Film, RenderError> {
        let kind = scene.integrator.kind;
        if !matches!(kind, IntegratorKind::Path | IntegratorKind::Direct) {
            return Err(RenderError::NoPaths(kind));
        }
        let width = self.width;
        self.run(
            &self.world(scene, Plan::with_light_samples_alone)?.without_light_paths(),
            &|world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters| {
                kernel::render_own(world, own, width, job, out, counters);
            },
        )
    }

    /// Averages a program's own integrand over the camera samples of a scene; the scene's integrator is not looked at.
    ///
    /// # Errors
    /// See [`RenderError`].
    pub fn integrate<I: Integrand>(&self, scene: &Scene, integrand: &I) -> Result<Film, RenderError> {
        let width = self.width;
        self.run(
            &self.world(scene, Plan::with_light_samples_alone)?.without_light_paths(),
            &|world: &World, job: &Job, out: &mut SampleBuffer, counters: &mut Counters| match width {
                Width::One => own::integrate::<f32, I>(integrand, world, job, out, counters),
                Width::Eight => own::integrate::<f32x8, I>(integrand, world, job, out, counters),
                Width::Sixteen => own::integrate::<f32x16, I>(integrand, world, job, out, counters),
            },
        )
    }

    fn world(&self, scene: &Scene, plan: impl Fn(Plan) -> Plan) -> Result<World, RenderError> {
        scene.validate()?;
        let world = World::new(scene, plan(Plan::new(scene, Force::default(), false)), self.prepare)?;
        Ok(match &self.numbers {
            None => world,
            Some(numbers) => world.with_numbers(numbers.clone()),
        })
    }

    fn run(&self, world: &World, kernel: JobKernel) -> Result<Film, RenderError> {
        let threads = self.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()));
        let pool = render::thread_pool(threads)?;
        let options = Options {
            budget: Budget { samples: Some(self.samples), ..Budget::default() },
            width: self.width,
            tile: self.tile.unwrap_or_else(|| render::default_tile(world.film.width, world.film.height)),
            aovs: false,
            output_seconds: 0.0,
            adaptive: false,
        };
        let film = render::empty_film(world, &options, 0);
        Ok(render::render_by(kernel, film, world, &options, &pool, &mut Progress::quiet(), &mut ()).film)
    }
}
