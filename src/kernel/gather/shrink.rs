//! How far weights are drawn towards equal ones, from a fixed pilot of the scene.
//!
//! The pilot is the estimator itself, with random numbers of its own and equal weights: at the first hits through some
//! pixels it makes estimates of all kinds that the render will make, continued paths, lobes and light samples among them,
//! and notes what the posterior's weights would have made of the same rays.

use super::draw::Directions;
use super::tables::Family;
use super::trace::Beams;
use super::worker::Worker;
use super::{Vertex, visit};
use crate::estimate::bmc::Pilot;
use crate::kernel::Width;
use crate::kernel::tile::{Counters, Job, SampleBuffer};
use crate::kernel::world::World;
use crate::lane::{Mask, Real, f32x8, f32x16};
use crate::sampling::dimensions::BSDF_LOBE;
use crate::sampling::{Sampler, SamplerKind, child_key};
use crate::scene::GatherShrinkage;
use rayon::prelude::*;

/// Pixels along each side of the film that are looked through.
const PIXELS: u32 = 8;
/// Estimates at a hit: as many as there are sets by default.
const ESTIMATES: u32 = 16;
/// The child of a sample's key whose children are the keys of its estimates; rays have numbers far below.
const TURNS: u32 = u32::MAX;
/// Sets the pilot's numbers apart from those of any render.
const PILOT_SEED: u32 = 0x7069_6c6f;

/// Estimates of one kind at one hit.
struct Seen {
    family: usize,
    /// By channel, with equal weights and with the posterior's.
    pairs: [Vec<[f64; 2]>; 3],
    /// By channel, with equal weights, of points that are not used again.
    others: [Vec<f64>; 3],
}

/// What a worker notes in a pilot.
#[derive(Default)]
pub(super) struct Watch {
    seen: Vec<Seen>,
    /// Are points drawn anew, for an estimate to compare with?
    pub fresh: bool,
}

impl Watch {
    /// Notes the estimate whose rays are in `beams`, made with equal weights.
    pub fn see(&mut self, family: &Family, set: &Directions, beams: &Beams) {
        let equal = f64::from(set.equal_weight(family.measure));
        let pair = |terms: &[f32]| {
            let add = |sum: [f64; 2], (term, w): (&f32, &f32)| {
                let term = f64::from(*term);
                [sum[0] + term, sum[1] + term * f64::from(*w) / equal]
            };
            terms.iter().zip(set.weights()).fold([0.0; 2], add)
        };
        let pairs = beams.terms().map(pair);
        let number = family.number;
        let place = self.seen.iter().position(|seen| seen.family == number).unwrap_or_else(|| {
            self.seen.push(Seen { family: number, pairs: Default::default(), others: Default::default() });
            self.seen.len() - 1
        });
        let seen = &mut self.seen[place];
        if self.fresh {
            seen.others.iter_mut().zip(pairs).for_each(|(all, [equal, _])| all.push(equal));
        } else {
            seen.pairs.iter_mut().zip(pairs).for_each(|(all, pair)| all.push(pair));
        }
    }
}

/// In a pilot: the estimates at a hit, each with a turn of its own, set after set, and as many of points of their own.
pub(super) fn look<R: Real>(worker: &mut Worker, vertex: &Vertex<R>, counters: &mut Counters) {
    if !vertex.surface.material.gathers().any() {
        return;
    }
    let keys = child_key(vertex.key, TURNS);
    for k in 0..2 * ESTIMATES {
        if let Some(watch) = &mut worker.watch {
            watch.fresh = k >= ESTIMATES;
        }
        let key = child_key(keys, k);
        let mut rng = Sampler::<f32>::independent(|_| key);
        let mut u = rng.bounce_dims(SamplerKind::Independent, 0.0);
        u[BSDF_LOBE] = ((k % ESTIMATES) as f32 + 0.5) / ESTIMATES as f32;
        worker.estimate::<R>(vertex.again(key, u), counters);
    }
}

/// Finds λ of each family of sets and draws their weights. Nothing without a process, or for a single direction.
pub(super) fn shrink(world: &mut World) {
    let start = std::time::Instant::now();
    let wanted = world.integrator.gather.shrinkage == GatherShrinkage::Pilot;
    let bayesian = world.gather.as_ref().is_some_and(|tables| tables.covariance.is_some() && tables.count() > 1);
    let mut report = (Vec::new(), 0);
    if wanted && bayesian {
        let seed = world.seed;
        world.seed = child_key(seed, PILOT_SEED);
        report = pilot(world);
        world.seed = seed;
    }
    let believes = world.plan.posterior;
    let Some(tables) = &mut world.gather else { return };
    for family in tables.families() {
        family.shrink(report.0.get(family.number).map_or(0.0, Pilot::intensity), believes);
    }
    tables.report.shrinkage = tables.families().map(|family| family.shrinkage).collect();
    tables.report.pilot_rays = report.1;
    tables.report.seconds += start.elapsed().as_secs_f64();
}

/// A [`Pilot`] for each family, and the rays that it took. Hits are summed in order: threads leave no trace.
fn pilot(world: &World) -> (Vec<Pilot>, u64) {
    let place = |k: u32, side: u32| (2 * k + 1) * side / (2 * PIXELS);
    let job = |i: u32| Job {
        x: place(i % PIXELS, world.film.width),
        y: place(i / PIXELS, world.film.height),
        width: 1,
        height: 1,
        first_sample: 0,
        samples: 1,
    };
    let looks: Vec<(Watch, u64)> = (0..PIXELS * PIXELS).into_par_iter().map(|i| watched(world, &job(i))).collect();
    let families = world.gather.as_ref().map_or(0, |tables| 1 + tables.lobes.len());
    let mut pilots = vec![Pilot::default(); families];
    let seen = looks.iter().flat_map(|look| &look.0.seen);
    for Seen { family, pairs, others } in seen {
        for (pairs, others) in pairs.iter().zip(others) {
            pilots[*family].add(others.iter().sum::<f64>() / others.len() as f64, pairs);
        }
    }
    (pilots, looks.iter().map(|look| look.1).sum())
}

/// Lanes leave no trace in what is seen: the fastest will do.
fn watched(world: &World, job: &Job) -> (Watch, u64) {
    match Width::native() {
        Width::Sixteen => look_through::<f32x16>(world, job),
        _ => look_through::<f32x8>(world, job),
    }
}

fn look_through<R: Real>(world: &World, job: &Job) -> (Watch, u64) {
    let (mut out, mut counters) = (SampleBuffer::default(), Counters::default());
    out.reset(job.slots(), false);
    let Some(tables) = &world.gather else { return Default::default() };
    let mut worker = Worker::new(world, tables, Some(Watch::default()));
    visit::<R>(&mut worker, world, job, &mut out, &mut counters);
    (worker.watch.unwrap_or_default(), counters.rays())
}
