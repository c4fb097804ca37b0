//! Functions on the hemisphere: powers of the cosine, and skies.

use super::panorama::Panorama;
use crate::estimate::bmc::{Covariance, Measure, Rules};
use crate::estimate::rules::Gauss;
use crate::lane::{Real, Vec3, math};
use crate::sampling::sample_key;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// F(ω), the whole integrand, cosine included.
#[derive(Clone, Debug)]
pub enum Field {
    /// cosᵐθ.
    Power(f64),
    /// L(ω) cosθ.
    Sky(Sky),
    /// The same under an image.
    Panorama(Arc<Panorama>),
}

/// Radiance from above: a constant and smooth lobes, cut off by a cap that hides what is beyond it, or with a sun.
#[derive(Clone, Debug)]
pub struct Sky {
    pub base: f64,
    pub lobes: Vec<Lobe>,
    /// Only directions within this cap see the sky: its axis and the cosine of its half-angle.
    pub visible: Option<([f64; 3], f64)>,
    /// A disc of uniform radiance beside the sky's: axis, cosine of the half-angle, radiance.
    pub sun: Option<([f64; 3], f64, f64)>,
}

/// amplitude · exp(λ(ω·axis − 1)).
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    pub axis: [f64; 3],
    pub sharpness: f64,
    pub amplitude: f64,
}

impl Sky {
    /// Eight lobes of every breadth in random directions above, under a dim base.
    pub fn random(seed: u64) -> Self {
        let number = |lobe: u32, what: u32| (sample_key(seed, lobe, what) >> 11) as f64 * f64::powi(2.0, -53);
        let lobe = |i: u32| {
            let axis = direction(1.2 * number(i, 0) - 0.2, number(i, 1));
            Lobe { axis, sharpness: 0.5 * 24f64.powf(number(i, 2)), amplitude: number(i, 3) }
        };
        Self { base: 0.1, lobes: (0..8).map(lobe).collect(), visible: None, sun: None }
    }

    /// The same behind an edge: a plane through the point, or nearly, hides about a half of the sky.
    pub fn with_edge(mut self, seed: u64) -> Self {
        let number = |what: u32| (sample_key(seed, 1000, what) >> 11) as f64 * f64::powi(2.0, -53);
        self.visible = Some((direction(0.6 * number(0), number(1)), 0.4 * number(2) - 0.2));
        self
    }

    /// The same with a sun of 6° radius as bright as makes it a third of all.
    pub fn with_sun(mut self, seed: u64) -> Self {
        let number = |what: u32| (sample_key(seed, 2000, what) >> 11) as f64 * f64::powi(2.0, -53);
        let radius = 6f64.to_radians();
        let cos = 0.3 + 0.65 * number(0);
        let sky = Field::Sky(self.clone()).exact();
        let radiance = 0.5 * sky / (PI * radius.sin().powi(2) * cos);
        self.sun = Some((direction(cos, number(1)), radius.cos(), radiance));
        self
    }

    pub fn radiance(&self, w: [f64; 3]) -> f64 {
        if self.visible.is_some_and(|(axis, cos)| dot(axis, w) < cos) {
            return 0.0;
        }
        let lobes = self.lobes.iter().map(|l| l.amplitude * (l.sharpness * (dot(l.axis, w) - 1.0)).exp());
        let sun = self.sun.filter(|(axis, cos, _)| dot(*axis, w) >= *cos).map_or(0.0, |sun| sun.2);
        self.base + lobes.sum::<f64>() + sun
    }

    /// In lanes.
    pub fn radiance_lanes<R: Real>(&self, w: Vec3<R>) -> R {
        let along = |axis: [f64; 3]| w.dot(Vec3::splat(axis.map(|a| a as f32)));
        let mut sum = R::splat(self.base as f32);
        for lobe in &self.lobes {
            let exponent = R::splat(lobe.sharpness as f32) * (along(lobe.axis) - R::one());
            sum = math::exp(exponent).mul_add(R::splat(lobe.amplitude as f32), sum);
        }
        if let Some((axis, cos, radiance)) = self.sun {
            sum = sum + R::splat(radiance as f32).masked(along(axis).ge(R::splat(cos as f32)));
        }
        match self.visible {
            Some((axis, cos)) => sum.masked(along(axis).ge(R::splat(cos as f32))),
            None => sum,
        }
    }
}

impl Field {
    /// F at a direction above the horizon, over cosθ where `over_cosine`.
    pub fn at(&self, w: [f64; 3], over_cosine: bool) -> f64 {
        match self {
            Field::Power(m) => w[2].max(0.0).powf(if over_cosine { m - 1.0 } else { *m }),
            Field::Sky(sky) => sky.radiance(w) * if over_cosine { 1.0 } else { w[2] },
            Field::Panorama(image) => image.radiance(w) * if over_cosine { 1.0 } else { w[2] },
        }
    }

    /// [`Field::at`] in lanes.
    #[inline(always)]
    pub fn lanes<R: Real>(&self, w: Vec3<R>, over_cosine: bool) -> R {
        match self {
            Field::Power(m) => power(w.z, if over_cosine { m - 1.0 } else { *m }),
            Field::Sky(sky) if over_cosine => sky.radiance_lanes(w),
            Field::Sky(sky) => sky.radiance_lanes(w) * w.z,
            Field::Panorama(image) if over_cosine => image.radiance_lanes(w),
            Field::Panorama(image) => image.radiance_lanes(w) * w.z,
        }
    }

    /// ∫ F: closed forms for powers, lobes and suns; about the cap's axis where there is one.
    pub fn exact(&self) -> f64 {
        let sky = match self {
            Field::Power(m) => return TAU / (m + 1.0),
            Field::Panorama(image) => return image.exact()[0],
            Field::Sky(sky) => sky,
        };
        if sky.visible.is_some() {
            return integrate(sky.visible, |w| self.at(w, false));
        }
        let rules = Rules::new();
        let lobe = |l: &Lobe| {
            let k = Covariance::SquaredExponential { length: l.sharpness.sqrt().recip() };
            // Below the horizon a lobe's embedding is wanted too.
            match l.axis[2] >= 0.0 {
                true => l.amplitude * Measure::COSINE.embedding(k, l.axis[2].acos(), &rules),
                false => integrate(None, |w| w[2] * l.amplitude * (l.sharpness * (dot(l.axis, w) - 1.0)).exp()),
            }
        };
        let sun = sky.sun.map_or(0.0, |(axis, cos, radiance)| radiance * PI * (1.0 - cos * cos) * axis[2]);
        PI * sky.base + sky.lobes.iter().map(lobe).sum::<f64>() + sun
    }

    /// Has it derivatives of every order?
    pub fn is_smooth(&self) -> bool {
        match self {
            Field::Power(_) => true,
            Field::Sky(sky) => sky.visible.is_none() && sky.sun.is_none(),
            Field::Panorama(_) => false,
        }
    }

    /// ∫ F² / p over the hemisphere, p a smooth density.
    pub fn second_moment(&self, p: impl Fn([f64; 3]) -> f64) -> f64 {
        let Field::Sky(sky) = self else {
            return integrate(None, |w| self.at(w, false).powi(2) / p(w));
        };
        let without = Field::Sky(Sky { sun: None, ..sky.clone() });
        let below = integrate(sky.visible, |w| without.at(w, false).powi(2) / p(w));
        // The sun's disc by itself: its edge would fall between nodes.
        let sun = sky.sun.map_or(0.0, |(axis, cos, radiance)| {
            integrate(Some((axis, cos)), |w| {
                let dark = without.at(w, false);
                let bright = dark + radiance * w[2];
                (bright * bright - dark * dark) / p(w)
            })
        });
        below + sun
    }
}

/// ∫ f over the part of a cap that is above the horizon, by circles about the cap's axis: a circle that dips below it is
/// integrated over its arc above. To about 1e-10 for what is smooth inside.
pub fn integrate(cap: Option<([f64; 3], f64)>, f: impl Fn([f64; 3]) -> f64) -> f64 {
    let (axis, cos) = cap.unwrap_or(([0.0, 0.0, 1.0], 0.0));
    let gauss = Gauss::new(24);
    let [side, up] = frame(axis);
    let tilt = axis[2].clamp(-1.0, 1.0).acos();
    let ring = |gamma: f64| {
        let (s, c) = gamma.sin_cos();
        // z = a + b cos ψ, ψ from the direction in which circles rise.
        let (a, b) = (axis[2] * c, up[2] * s);
        let last = if a >= b {
            PI
        } else if a <= -b {
            return 0.0;
        } else {
            (-a / b).acos()
        };
        let at = |psi: f64| {
            let (sp, cp) = psi.sin_cos();
            f(std::array::from_fn(|k| axis[k] * c + s * (up[k] * cp + side[k] * sp)))
        };
        s * gauss.integrate([-last, last], 4, at)
    };
    // Circles begin to cut the horizon, or leave it, where they touch it.
    let end = cos.clamp(-1.0, 1.0).acos();
    let mut edges = vec![0.0, (FRAC_PI_2 - tilt).abs(), PI - (FRAC_PI_2 - tilt).abs(), end];
    edges.retain(|&e| e <= end);
    edges.sort_by(f64::total_cmp);
    let panel = |pair: &[f64]| {
        let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        // sin(πt/2) smooths the square roots at the ends.
        let inside = |t: f64| FRAC_PI_2 * half * (FRAC_PI_2 * t).cos() * ring(middle + half * (FRAC_PI_2 * t).sin());
        if half > 0.0 { gauss.integrate([-1.0, 1.0], 4, inside) } else { 0.0 }
    };
    edges.windows(2).map(panel).sum()
}

/// Two unit vectors that complete `axis`, the second as far up as can be.
fn frame(axis: [f64; 3]) -> [[f64; 3]; 2] {
    let flat = axis[0].hypot(axis[1]);
    let side = if flat > 1e-12 { [-axis[1] / flat, axis[0] / flat, 0.0] } else { [0.0, 1.0, 0.0] };
    // axis × side points up where the axis is not the normal itself.
    let up = [
        axis[1] * side[2] - axis[2] * side[1],
        axis[2] * side[0] - axis[0] * side[2],
        axis[0] * side[1] - axis[1] * side[0],
    ];
    [side, up]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn direction(cos: f64, turn: f64) -> [f64; 3] {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (TAU * turn).sin_cos();
    [sin * c, sin * s, cos]
}

/// x^m, x in (0, 1]: small whole powers by multiplication.
#[inline(always)]
fn power<R: Real>(x: R, m: f64) -> R {
    if m.fract() == 0.0 && (-1.0..=16.0).contains(&m) {
        return (0..m as u32).fold(if m < 0.0 { x.recip() } else { R::one() }, |p, _| p * x);
    }
    math::exp(math::ln(x) * R::splat(m as f32))
}
