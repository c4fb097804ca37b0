//! Scenes written as values, renders of them, and what whole images say. For tests of the whole renderer.

mod image;
mod set;

pub use image::{assert_image_mean, image_mean};
pub use set::{Point, Set};

use octolux::film::Film;
use octolux::kernel::{self, Prepare, Width, World};
use octolux::plan::{Force, Plan};
use octolux::render::adaptive::adaptive_tile;
use octolux::render::{self, Budget, JobKernel, Options, Outcome, Progress};
use octolux::sampling::SamplerKind;
use octolux::scene::Scene;
use std::sync::OnceLock;

/// The scene prepared as its plan says.
pub fn world(scene: &Scene, seed: u64) -> World {
    forced(scene, seed, Force::default())
}

/// The scene prepared with something forced.
pub fn forced(scene: &Scene, seed: u64, force: Force) -> World {
    sampled(scene, seed, force, SamplerKind::Independent)
}

/// The same with a sampler of one's choice.
pub fn sampled(scene: &Scene, seed: u64, force: Force, sampler: SamplerKind) -> World {
    let options = Prepare { seed, sampler, ..Prepare::default() };
    World::new(scene, Plan::new(scene, force, false), options).expect("the scene's lights fit the light table")
}

/// How a render is carried out; none of it may leave a trace in the bits.
#[derive(Clone, Copy, Debug)]
pub struct How {
    pub width: Width,
    pub tile: u32,
}

impl Default for How {
    fn default() -> Self {
        How { width: Width::native(), tile: 16 }
    }
}

/// Renders on the threads that all tests share.
pub fn film(world: &World, samples: u64) -> Film {
    film_on(shared_pool(), world, samples, How::default())
}

pub fn film_on(pool: &rayon::ThreadPool, world: &World, samples: u64, how: How) -> Film {
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    let film = render::render(world, &options(how, budget, false), pool, &mut Progress::quiet()).film;
    assert_eq!(film.samples(), samples);
    assert_eq!(film.discarded().count, 0, "samples that are not finite: {:?}", film.discarded());
    film
}

fn options(how: How, budget: Budget, adaptive: bool) -> Options {
    Options { budget, width: how.width, tile: how.tile, aovs: false, output_seconds: 0.0, adaptive }
}

/// With samples divided by a pilot, `samples` a pixel on average; by a kernel of one's own if there is one.
pub fn adaptive(world: &World, samples: u64, width: Width, kernel: Option<JobKernel>) -> Outcome {
    adaptive_on(shared_pool(), world, samples, width, kernel)
}

pub fn adaptive_on(
    pool: &rayon::ThreadPool,
    world: &World,
    samples: u64,
    width: Width,
    kernel: Option<JobKernel>,
) -> Outcome {
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    adaptive_within(pool, world, budget, width, kernel)
}

/// Until the relative error is at most `error`.
pub fn adaptive_to(world: &World, error: f64) -> Outcome {
    let budget = Budget { error: Some(error), ..Budget::default() };
    adaptive_within(shared_pool(), world, budget, Width::native(), None)
}

/// By some kernel, within a budget.
pub fn adaptive_by(world: &World, budget: Budget, kernel: JobKernel) -> Outcome {
    adaptive_within(shared_pool(), world, budget, Width::native(), Some(kernel))
}

/// The same of equal samples.
pub fn even_by(world: &World, budget: Budget, kernel: JobKernel) -> Outcome {
    let options = options(How { width: Width::native(), tile: 4 }, budget, false);
    let film = render::empty_film(world, &options, 0);
    render::render_by(kernel, film, world, &options, shared_pool(), &mut Progress::quiet(), &mut ())
}

fn adaptive_within(
    pool: &rayon::ThreadPool,
    world: &World,
    budget: Budget,
    width: Width,
    kernel: Option<JobKernel>,
) -> Outcome {
    let options = options(How { width, tile: adaptive_tile(world) }, budget, true);
    let film = render::empty_film(world, &options, 0);
    let of_world = kernel::select(world, width);
    render::render_by(kernel.unwrap_or(&of_world), film, world, &options, pool, &mut Progress::quiet(), &mut ())
}

fn shared_pool() -> &'static rayon::ThreadPool {
    static POOL: OnceLock<rayon::ThreadPool> = OnceLock::new();
    POOL.get_or_init(|| {
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        render::thread_pool(threads).expect("the system gives threads")
    })
}
