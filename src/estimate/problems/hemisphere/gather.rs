//! Bayesian Monte Carlo on the hemisphere: fixed sets of directions with their weights, turned at random about the normal.

use super::Field;
use crate::estimate::bmc::{Covariance, Mean, Measure, Pilot, PointSet, Points, SetRecipe, Verdict, point_sets};
use crate::estimate::method::{Claim, Method, Prepared, Single};
use crate::kernel::Width;
use crate::lane::{MAX_WIDTH, Real, Vec3, f32x8, f32x16, math};
use crate::sampling::sample_key;
use std::sync::Arc;

/// The variant that a name of the form `bmc[-is][-zero][-seL|-sobolevS|-equal][-unshrunk][-random|-owen|-fibonacci]` asks
/// for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Variant {
    /// Directions ∝ cosθ, the process models F/cosθ; else uniform ones, and it models F.
    importance: bool,
    mean: Mean,
    covariance: Option<Covariance>,
    points: Points,
    /// Weights by a pilot between the posterior's and equal ones. Not for a zero mean, whose weights have another sum.
    shrunk: bool,
}

impl Variant {
    pub fn parse(name: &str) -> Option<Self> {
        let mut words = name.split('-');
        let mut variant = Self {
            importance: false,
            mean: Mean::Constant,
            covariance: Some(Covariance::SOBOLEV),
            points: Points::Fibonacci,
            shrunk: true,
        };
        if words.next() != Some("bmc") {
            return None;
        }
        for word in words {
            let number = |prefix: &str, default: f64| match word.strip_prefix(prefix)? {
                "" => Some(default),
                digits => digits.parse().ok(),
            };
            match word {
                "is" => variant.importance = true,
                "zero" => variant.mean = Mean::Zero,
                "equal" => variant.covariance = None,
                "unshrunk" => variant.shrunk = false,
                "random" => variant.points = Points::Random,
                "owen" => variant.points = Points::Owen,
                "fibonacci" => variant.points = Points::Fibonacci,
                _ => {
                    let sobolev =
                        number("sobolev", Covariance::SMOOTHNESS).map(|smoothness| Covariance::Sobolev { smoothness });
                    let squared = || number("se", 0.5).map(|length| Covariance::SquaredExponential { length });
                    variant.covariance = Some(sobolev.or_else(squared)?.check().ok()?);
                }
            }
        }
        Some(variant)
    }
}

/// Sets of a study: few where their weights cost much.
fn sets(n: usize) -> usize {
    if n <= 256 { 16 } else { 4 }
}

/// More points than this cost more than their worth: the weights of n points cost n³.
const MOST_POINTS: usize = 1024;

pub(super) fn method(name: &str, variant: Variant, field: Arc<Field>, width: Width) -> Method {
    Method::new(name, Claim::Biased, move |n| {
        if n > MOST_POINTS {
            return None;
        }
        let (sets, notes) = variant.sets(n, &field);
        let note = (!notes.is_empty()).then(|| notes.join("; "));
        let field = field.clone();
        let run = move |key: u64, _: usize| {
            let set = &sets[(key >> 32) as usize % sets.len()];
            let turn = turn_of(key);
            let value = match width {
                Width::One => weighted::<f32>(&set.directions, &set.weights, turn, &field, variant.importance),
                Width::Eight => weighted::<f32x8>(&set.directions, &set.weights, turn, &field, variant.importance),
                Width::Sixteen => weighted::<f32x16>(&set.directions, &set.weights, turn, &field, variant.importance),
            };
            Single { value, standard_error: None }
        };
        Some(Prepared { note, ..Prepared::new(n, run) })
    })
}

/// Turns of each set in the pilot, and the key that sets them apart from every study's.
const PILOT_TURNS: usize = 8;
const PILOT_KEY: u64 = 0x7368_7269_6e6b_6167;

impl Variant {
    /// Point sets with their weights, and what is to be said of them.
    fn sets(self, n: usize, field: &Field) -> (Vec<PointSet>, Vec<String>) {
        let Variant { points, covariance, mean, importance, shrunk } = self;
        let measure = if importance { Measure::COSINE } else { Measure::UNIFORM };
        let recipe = SetRecipe { points, n, sets: sets(n), measure, covariance, mean, seed: 0 };
        let sets = point_sets(&recipe);
        let stiff = sets.iter().filter_map(PointSet::conditioning).find(|c| c.verdict != Verdict::Posterior);
        let mut notes: Vec<String> = stiff.map(|c| c.to_string()).into_iter().collect();
        let mut sets: Vec<PointSet> = sets.into_iter().map(padded).collect();
        if shrunk && covariance.is_some() && mean == Mean::Constant && n > 1 {
            let estimates = sets.len() * PILOT_TURNS;
            let others = point_sets(&SetRecipe { sets: estimates, covariance: None, seed: PILOT_KEY, ..recipe });
            let others: Vec<PointSet> = others.into_iter().map(padded).collect();
            let intensity = intensity(&sets, &others, field, importance);
            sets = sets.into_iter().map(|set| set.shrunk(intensity, measure.total())).collect();
            let (percent, cost) = (100.0 * intensity, 2 * estimates * n);
            notes.push(format!("shrunk by {percent:.1} % on a pilot of {cost} evaluations, not counted in n"));
        }
        (sets, notes)
    }
}

/// λ of [`Pilot`]: each set at turns of its own, with equal weights and with its own, beside as many sets that are not used
/// again. Lanes leave no trace: eight will do.
fn intensity(sets: &[PointSet], others: &[PointSet], field: &Field, importance: bool) -> f64 {
    let estimate = |set: &PointSet, weights: &[f32], k: usize| {
        let turn = turn_of(sample_key(PILOT_KEY, (k / sets.len()) as u32, (k % sets.len()) as u32));
        weighted::<f32x8>(&set.directions, weights, turn, field, importance)
    };
    let reference: f64 = others.iter().enumerate().map(|(k, set)| estimate(set, &set.weights, k)).sum();
    let pair = |k: usize| {
        let set = &sets[k % sets.len()];
        [&others[k].weights, &set.weights].map(|weights| estimate(set, weights, k))
    };
    let mut pilot = Pilot::default();
    pilot.add(reference / others.len() as f64, &(0..others.len()).map(pair).collect::<Vec<_>>());
    pilot.intensity()
}

/// A number in [0, 1) of a key.
fn turn_of(key: u64) -> f32 {
    (key as u32 >> 8) as f32 * (1.0 / (1u32 << 24) as f32)
}

/// Σ w_i F(Rω_i) in index order, R a turn about the normal.
fn weighted<R: Real>(directions: &[Vec<f32>; 3], weights: &[f32], turn: f32, field: &Field, over_cosine: bool) -> f64 {
    let (sin, cos) = math::sincos_2pi(R::splat(turn));
    let mut sum = 0.0;
    for first in (0..weights.len()).step_by(R::WIDTH) {
        let [x, y, z] = [0, 1, 2].map(|axis| R::load(&directions[axis][first..]));
        let turned = Vec3::new(cos.mul_add(x, -(sin * y)), sin.mul_add(x, cos * y), z);
        let value = field.lanes(turned, over_cosine);
        for (lane, weight) in weights[first..].iter().take(R::WIDTH).enumerate() {
            sum += f64::from(*weight) * f64::from(value.lane(lane));
        }
    }
    sum
}

/// Rows as long as the widest lanes want them; what is added is never summed.
fn padded(mut set: PointSet) -> PointSet {
    let length = set.weights.len().next_multiple_of(MAX_WIDTH);
    for row in &mut set.directions {
        row.resize(length, 1.0);
    }
    set
}
