//! Bayesian Monte Carlo on the hemisphere: fixed sets of directions with their weights, turned at random about the normal.

use super::Field;
use crate::estimate::bmc::{Covariance, Mean, Measure, PointSet, Points, SetRecipe, Verdict, point_sets};
use crate::estimate::method::{Claim, Method, Prepared, Single};
use crate::kernel::Width;
use crate::lane::{MAX_WIDTH, Real, Vec3, f32x8, f32x16, math};
use std::sync::Arc;

/// The variant that a name of the form bmc[-is][-zero][-seL|-sobolevS|-equal][-random|-owen|-fibonacci] asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Variant {
    /// Directions ∝ cosθ, the process models F/cosθ; else uniform ones, and it models F.
    importance: bool,
    mean: Mean,
    covariance: Option<Covariance>,
    points: Points,
}

impl Variant {
    pub fn parse(name: &str) -> Option<Self> {
        let mut words = name.split('-');
        let mut variant = Self {
            importance: false,
            mean: Mean::Constant,
            covariance: Some(Covariance::SOBOLEV),
            points: Points::Fibonacci,
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
        let measure = if variant.importance { Measure::COSINE } else { Measure::UNIFORM };
        let Variant { points, covariance, mean, .. } = variant;
        let sets = point_sets(&SetRecipe { points, n, sets: sets(n), measure, covariance, mean, seed: 0 });
        let stiff = sets.iter().filter_map(PointSet::conditioning).find(|c| c.verdict != Verdict::Posterior);
        let padded: Vec<PointSet> = sets.into_iter().map(padded).collect();
        let field = field.clone();
        let run = move |key: u64, _: usize| {
            let set = &padded[(key >> 32) as usize % padded.len()];
            let turn = (key as u32 >> 8) as f32 * (1.0 / (1u32 << 24) as f32);
            let value = match width {
                Width::One => weighted::<f32>(set, n, turn, &field, variant.importance),
                Width::Eight => weighted::<f32x8>(set, n, turn, &field, variant.importance),
                Width::Sixteen => weighted::<f32x16>(set, n, turn, &field, variant.importance),
            };
            Single { value, standard_error: None }
        };
        Some(Prepared { note: stiff.map(|c| c.to_string()), ..Prepared::new(n, run) })
    })
}

/// Σ w_i F(Rω_i) in index order, R a turn about the normal.
fn weighted<R: Real>(set: &PointSet, n: usize, turn: f32, field: &Field, over_cosine: bool) -> f64 {
    let (sin, cos) = math::sincos_2pi(R::splat(turn));
    let mut sum = 0.0;
    for first in (0..n).step_by(R::WIDTH) {
        let [x, y, z] = [0, 1, 2].map(|axis| R::load(&set.directions[axis][first..]));
        let turned = Vec3::new(cos.mul_add(x, -(sin * y)), sin.mul_add(x, cos * y), z);
        let value = field.lanes(turned, over_cosine);
        for (lane, weight) in set.weights[first..n].iter().take(R::WIDTH).enumerate() {
            sum += f64::from(*weight) * f64::from(value.lane(lane));
        }
    }
    sum
}

/// Rows as long as the widest lanes want them; what is added is never summed.
fn padded(mut set: PointSet) -> PointSet {
    let length = set.weights.len().next_multiple_of(MAX_WIDTH);
    for row in set.directions.iter_mut().chain([&mut set.weights]) {
        row.resize(length, 1.0);
    }
    set
}
