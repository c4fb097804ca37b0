//! What the gather kernel reads: point sets and weights made once for a picture.

use super::draw::Directions;
use super::lobe::{Glossy, lobes_of};
use super::{Vertex, pilot};
use crate::estimate::bmc::{
    Covariance, Evidence, Mean, Measure, PointSet, Rules, SetRecipe, Verdict, fibonacci, point_sets,
};
use crate::kernel::world::World;
use crate::lane::{MAX_WIDTH, Real};
use crate::sampling::dimensions::BSDF_LOBE;
use crate::scene::{Gather, GatherCovariance, GatherPdf, GatherWeights, Material};
use std::time::Instant;

/// Prepared data of the gather kernel.
pub struct GatherTables {
    pub(super) settings: Gather,
    /// `None`: equal weights.
    pub(super) covariance: Option<Covariance>,
    pub(super) rules: Rules,
    /// The golden-ratio sequence, padded.
    pub(super) lattice: Vec<f32>,
    /// About the normal.
    pub(super) base: Family,
    /// About the mirror direction, and the lobes that each is for. Empty unless the pdf is `lobe`.
    pub(super) lobes: Vec<Family>,
    pub(super) lobe_kinds: Vec<Glossy>,
    pub report: GatherReport,
}

/// Point sets of one p.
pub(super) struct Family {
    pub measure: Measure,
    /// Prior variance of the integral at σ_f² = 1.
    pub self_energy: f64,
    /// Its place: 0 about the normal, then the lobes in order.
    pub number: usize,
    /// λ of its weights, see [`crate::estimate::bmc::Pilot`].
    pub shrinkage: f64,
    /// As kernels read them; empty where points are drawn at each hit.
    sets: Vec<Directions>,
    /// What they are made from, until λ is known.
    made: Vec<PointSet>,
}

/// What was made, and whether it may be trusted.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct GatherReport {
    /// To make the tables.
    pub seconds: f64,
    /// As scene files have it.
    pub method: &'static str,
    /// A hit.
    pub directions: u32,
    /// Of Bayesian methods.
    pub covariance: Option<Covariance>,
    /// The covariances tried on the pilot, best first.
    pub evidence: Vec<Evidence>,
    /// Point sets that hits share.
    pub sets: usize,
    /// p of the sets about the mirror direction.
    pub lobes: Vec<Measure>,
    /// Sets whose posterior was refused, and which have equal weights instead.
    pub equal_weights: usize,
    /// Sets whose posterior was ill-conditioned but passed.
    pub damped: usize,
    /// How far weights are drawn towards equal ones, 0 to 1: of the sets about the normal, then of those of the lobes in order.
    pub shrinkage: Vec<f64>,
    /// Rays of the pilot that found it.
    pub pilot_rays: u64,
}

impl GatherTables {
    /// `world` is complete but for these tables.
    pub fn new(world: &World, materials: &[Material]) -> Self {
        let start = Instant::now();
        let settings = world.integrator.gather;
        let rules = Rules::new();
        let (covariance, evidence) = match settings.covariance {
            _ if !settings.method.is_bayesian() => (None, Vec::new()),
            GatherCovariance::Given(covariance) => (Some(covariance), Vec::new()),
            GatherCovariance::Fitted => {
                let evidence = pilot::rank(world);
                (Some(evidence.first().map_or(Covariance::SOBOLEV, |best| best.covariance)), evidence)
            }
        };
        let mut report = GatherReport {
            method: settings.method.name(),
            directions: settings.samples,
            covariance,
            evidence,
            ..GatherReport::default()
        };
        let mut number = 0;
        let mut family = |measure| {
            number += 1;
            Family::new(world, measure, number - 1, covariance, &rules, &mut report)
        };
        let base = family(if settings.pdf == GatherPdf::Uniform { Measure::UNIFORM } else { Measure::COSINE });
        let lobe_kinds = if settings.pdf == GatherPdf::Lobe { lobes_of(materials) } else { Vec::new() };
        let lobes: Vec<Family> = lobe_kinds.iter().map(|lobe| family(lobe.measure())).collect();
        report.lobes = lobes.iter().map(|family| family.measure).collect();
        report.seconds = start.elapsed().as_secs_f64();
        if report.equal_weights > 0 {
            let (bad, all) = (report.equal_weights, report.sets);
            log::warn!(
                "gather: {bad} of {all} point sets are ill-conditioned under {covariance:?}; they weigh equally"
            );
        }
        let lattice = fibonacci(settings.samples.next_multiple_of(MAX_WIDTH as u32) as usize, [0.0; 2]);
        let lattice = lattice.iter().map(|[_, turn]| *turn as f32).collect();
        GatherTables { settings, covariance, rules, lattice, base, lobes, lobe_kinds, report }
    }

    /// About the normal, then the lobes.
    pub(super) fn families(&mut self) -> impl Iterator<Item = &mut Family> {
        std::iter::once(&mut self.base).chain(&mut self.lobes)
    }

    /// Directions an estimate.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.settings.samples as usize
    }
}

impl Family {
    fn new(
        world: &World,
        measure: Measure,
        number: usize,
        covariance: Option<Covariance>,
        rules: &Rules,
        report: &mut GatherReport,
    ) -> Self {
        let settings = world.integrator.gather;
        let sets = match settings.weights {
            GatherWeights::PerHit => Vec::new(),
            GatherWeights::Shared => point_sets(&SetRecipe {
                points: settings.points,
                n: settings.samples as usize,
                sets: settings.sets as usize,
                measure,
                covariance,
                mean: Mean::Constant,
                seed: world.seed,
            }),
        };
        let verdicts =
            |verdict| sets.iter().filter_map(PointSet::conditioning).filter(|c| c.verdict == verdict).count();
        report.sets += sets.len();
        report.equal_weights += verdicts(Verdict::EqualWeights);
        report.damped += verdicts(Verdict::Damped);
        Family {
            measure,
            self_energy: covariance.map_or(0.0, |k| measure.self_energy(k, rules)),
            number,
            shrinkage: 0.0,
            sets: directions(&sets, measure, world.plan.posterior),
            made: sets,
        }
    }

    /// Draws the weights towards equal ones, once. `believes` keeps posteriors.
    pub fn shrink(&mut self, intensity: f64, believes: bool) {
        let (measure, made) = (self.measure, std::mem::take(&mut self.made));
        self.shrinkage = intensity;
        if intensity > 0.0 {
            let sets: Vec<PointSet> = made.into_iter().map(|set| set.shrunk(intensity, measure.total())).collect();
            self.sets = directions(&sets, measure, believes);
        }
    }

    /// The directions for a hit: one of the sets, or `drawn` filled anew. `fresh`: anew whatever there is, and equally weighted.
    #[inline(always)]
    pub fn at<'a, R: Real>(
        &'a self,
        tables: &GatherTables,
        vertex: &Vertex<R>,
        drawn: &'a mut Directions,
        fresh: bool,
    ) -> &'a Directions {
        if self.sets.is_empty() || fresh {
            drawn.draw(tables, self, vertex, tables.covariance.filter(|_| !fresh));
            return drawn;
        }
        let choice = (vertex.u[BSDF_LOBE] * self.sets.len() as f32) as usize;
        &self.sets[choice.min(self.sets.len() - 1)]
    }
}

fn directions(sets: &[PointSet], measure: Measure, believes: bool) -> Vec<Directions> {
    sets.iter().map(|set| Directions::from_set(set, measure, believes)).collect()
}
