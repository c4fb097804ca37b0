//! What the gather kernel reads: point sets and weights made once for a picture.

use super::draw::Directions;
use super::{Vertex, pilot};
use crate::estimate::bmc::{
    Covariance, Evidence, Mean, Measure, PointSet, Rules, SetRecipe, Verdict, fibonacci, point_sets,
};
use crate::kernel::world::World;
use crate::lane::{MAX_WIDTH, Real};
use crate::sampling::dimensions::BSDF_LOBE;
use crate::scene::{Gather, GatherCovariance, GatherPdf, GatherWeights};
use std::time::Instant;

/// Prepared data of the gather kernel.
pub struct GatherTables {
    pub(super) settings: Gather,
    pub(super) measure: Measure,
    /// `None`: equal weights.
    pub(super) covariance: Option<Covariance>,
    /// Prior variance of the integral at σ_f² = 1.
    pub(super) self_energy: f64,
    pub(super) rules: Rules,
    /// The golden-ratio sequence, padded.
    pub(super) lattice: Vec<f32>,
    /// Empty where points are drawn at each hit.
    sets: Vec<Directions>,
    pub report: GatherReport,
}

/// What was made, and whether it may be trusted.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct GatherReport {
    pub seconds: f64,
    pub method: &'static str,
    pub directions: u32,
    /// Of Bayesian methods.
    pub covariance: Option<Covariance>,
    /// The covariances tried on the pilot, best first.
    pub evidence: Vec<Evidence>,
    pub sets: usize,
    /// Sets whose posterior was refused, and which have equal weights instead.
    pub equal_weights: usize,
    /// Sets whose posterior was ill-conditioned but passed.
    pub damped: usize,
}

impl GatherTables {
    /// `world` is complete but for these tables.
    pub fn new(world: &World) -> Self {
        let start = Instant::now();
        let settings = world.integrator.gather;
        let measure = if settings.pdf == GatherPdf::Uniform { Measure::UNIFORM } else { Measure::COSINE };
        let rules = Rules::new();
        let (covariance, evidence) = match settings.covariance {
            _ if !settings.method.is_bayesian() => (None, Vec::new()),
            GatherCovariance::Given(covariance) => (Some(covariance), Vec::new()),
            GatherCovariance::Fitted => {
                let evidence = pilot::rank(world);
                (Some(evidence.first().map_or(Covariance::SOBOLEV, |best| best.covariance)), evidence)
            }
        };
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
        let lattice = fibonacci(settings.samples.next_multiple_of(MAX_WIDTH as u32) as usize, [0.0; 2]);
        let verdicts =
            |verdict| sets.iter().filter_map(PointSet::conditioning).filter(|c| c.verdict == verdict).count();
        let report = GatherReport {
            seconds: start.elapsed().as_secs_f64(),
            method: settings.method.name(),
            directions: settings.samples,
            covariance,
            evidence,
            sets: sets.len(),
            equal_weights: verdicts(Verdict::EqualWeights),
            damped: verdicts(Verdict::Damped),
        };
        if report.equal_weights > 0 {
            let (bad, all) = (report.equal_weights, report.sets);
            log::warn!(
                "gather: {bad} of {all} point sets are ill-conditioned under {covariance:?}; they weigh equally"
            );
        }
        GatherTables {
            settings,
            measure,
            covariance,
            self_energy: covariance.map_or(0.0, |k| measure.self_energy(k, &rules)),
            rules,
            lattice: lattice.iter().map(|[_, turn]| *turn as f32).collect(),
            sets: sets.iter().map(Directions::from_set).collect(),
            report,
        }
    }

    /// Directions an estimate.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.settings.samples as usize
    }

    #[inline(always)]
    pub(super) fn is_cosine(&self) -> bool {
        self.settings.pdf != GatherPdf::Uniform
    }

    /// p, where the weights already hold it.
    #[inline(always)]
    pub(super) fn density<R: Real>(&self, cos: R) -> R {
        if self.is_cosine() { cos } else { R::one() }
    }

    /// The directions for a hit: one of the sets, or `drawn` filled anew.
    #[inline(always)]
    pub(super) fn at<'a, R: Real>(&'a self, vertex: &Vertex<R>, drawn: &'a mut Directions) -> &'a Directions {
        if self.sets.is_empty() {
            drawn.draw(self, vertex);
            return drawn;
        }
        let choice = (vertex.u[BSDF_LOBE] * self.sets.len() as f32) as usize;
        &self.sets[choice.min(self.sets.len() - 1)]
    }
}
