//! What lights are expected to send to the surfaces of a cell, sixteen at a time.
//!
//! Only the proportions matter: strengths are relative to the strongest, lengths to a cell's side, so that single precision
//! holds them whatever a scene's units. Always at one width: the tables belong to the scene.

use crate::lane::{Real, Vec3, f32x16};
use glam::DVec3;

type R = f32x16;

/// A light as receivers see it from afar.
pub(super) struct Lamp {
    pub center: DVec3,
    /// Unit; `None` for one that shines all ways.
    pub normal: Option<DVec3>,
    /// Area as seen along the normal, or from anywhere.
    pub area: f64,
    /// Radiance, the mean over the channels.
    pub radiance: f64,
    /// With which it is chosen by power.
    pub probability: f64,
}

/// Surfaces of a cell: the sums of what lies there.
#[derive(Clone, Copy, Default)]
pub(super) struct Facing {
    pub normal: DVec3,
    pub point: DVec3,
    pub weight: f64,
}

/// The lights, a column each, as many as registers hold: those past the last send nothing.
pub(super) struct Senders {
    low: DVec3,
    size: f64,
    /// Sides of a cell from `low`.
    center: [Vec<f32>; 3],
    /// 0 for one that shines all ways.
    normal: [Vec<f32>; 3],
    /// 1 for those.
    all_ways: Vec<f32>,
    /// Of a cell's side.
    area: Vec<f32>,
    /// Radiance times area, of the strongest's.
    strength: Vec<f32>,
}

/// Points of a cell that stand for it.
const POINTS: usize = 4;

impl Senders {
    /// For cells of `size` from `low` on.
    pub fn new(lamps: &[Lamp], low: DVec3, size: f64) -> Self {
        let strength = |lamp: &Lamp| if lamp.probability > 0.0 { lamp.radiance * lamp.area } else { 0.0 };
        let strongest = lamps.iter().map(strength).fold(f64::MIN_POSITIVE, f64::max);
        let len = lamps.len().next_multiple_of(R::WIDTH);
        let column = |of: &dyn Fn(&Lamp) -> f64| {
            let mut column: Vec<f32> = lamps.iter().map(|lamp| of(lamp) as f32).collect();
            column.resize(len, 0.0);
            column
        };
        Self {
            low,
            size,
            center: std::array::from_fn(|k| column(&|lamp| (lamp.center[k] - low[k]) / size)),
            normal: std::array::from_fn(|k| column(&|lamp| lamp.normal.map_or(0.0, |n| n[k]))),
            all_ways: column(&|lamp| f64::from(lamp.normal.is_none())),
            area: column(&|lamp| lamp.area / (size * size)),
            strength: column(&|lamp| strength(lamp) / strongest),
        }
    }

    /// Room for what all lights send.
    pub fn room(&self) -> Vec<f32> {
        vec![0.0; self.strength.len()]
    }

    /// What each light sends to surfaces of a cell if nothing stands between, in one unit for all; the sum of that.
    pub fn send(&self, facing: &Facing, sent: &mut [f32]) -> f64 {
        let (mean, center) = (facing.normal / facing.weight, facing.point / facing.weight);
        let spread = (1.0 - mean.length_squared()).max(0.0).sqrt();
        let normal = mean.normalize_or_zero();
        let (s, t) = if normal == DVec3::ZERO { (DVec3::X, DVec3::Y) } else { normal.any_orthonormal_pair() };
        let center = (center - self.low) / self.size;
        let points: [Vec3<R>; POINTS] =
            [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(a, b)| splat(center + 0.25 * (a * s + b * t)));
        let (normal, spread) = (splat(normal), R::splat(spread as f32));
        let mut total = 0.0;
        for (first, sent) in sent.chunks_exact_mut(R::WIDTH).enumerate() {
            let lamps = self.register(first * R::WIDTH);
            let all = points.iter().fold(R::zero(), |all, point| all + lamps.arrives(*point, normal, spread));
            all.store(sent);
            total += sent.iter().map(|&x| f64::from(x)).sum::<f64>();
        }
        total
    }

    #[inline(always)]
    fn register(&self, first: usize) -> Register {
        let load = |column: &[f32]| R::load(&column[first..]);
        let vector = |columns: &[Vec<f32>; 3]| Vec3::new(load(&columns[0]), load(&columns[1]), load(&columns[2]));
        Register {
            center: vector(&self.center),
            normal: vector(&self.normal),
            all_ways: load(&self.all_ways),
            area: load(&self.area),
            strength: load(&self.strength),
        }
    }
}

/// As many lights as it holds.
struct Register {
    center: Vec3<R>,
    normal: Vec3<R>,
    all_ways: R,
    area: R,
    strength: R,
}

impl Register {
    /// About what arrives at `p` on surfaces that face along `normal`, give or take `spread` (a sine).
    #[inline(always)]
    fn arrives(&self, p: Vec3<R>, normal: Vec3<R>, spread: R) -> R {
        let (zero, one) = (R::zero(), R::one());
        let to = self.center - p;
        let squared = to.dot(to);
        // Close by, neither the lamp nor the cell is a point.
        let soft = (self.area * R::splat(0.25)).max_or(squared).max_or(R::splat(1.0 / 16.0));
        let direction = to * (one / squared.max_or(R::splat(f32::MIN_POSITIVE)).sqrt());
        let extent = (self.area / soft).sqrt().min_or(one);
        let towards = (extent - self.normal.dot(direction)).max_or(zero) / (one + extent);
        let leaving = <R as Real>::select(self.all_ways.gt(zero), one, towards);
        let tilt = (spread + extent).min_or(one);
        let arriving = (tilt + normal.dot(direction)).max_or(zero) / (one + tilt);
        self.strength * leaving * arriving / soft
    }
}

fn splat(v: DVec3) -> Vec3<R> {
    let [x, y, z] = v.as_vec3().to_array().map(R::splat);
    Vec3::new(x, y, z)
}
