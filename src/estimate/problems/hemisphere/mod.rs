//! ∫ F(ω) dω over the hemisphere: constant, powers of the cosine, skies with and without edges.

mod density;
mod field;
mod gather;
mod learned;
mod panorama;

pub use density::Density;
pub use field::{Field, Lobe, Sky, integrate};
pub use learned::Learned;
pub use panorama::Panorama;

use super::{Problem, unknown_method};
use crate::estimate::biased::{clamped, pilot_reuse, ratio};
use crate::estimate::method::{Integrand, Method, Shared, mean_over};
use crate::estimate::points::{Points, lane_unit};
use crate::estimate::study::Quantity;
use crate::estimate::tensor::{Rule, product};
use crate::kernel::Width;
use crate::lane::{Bits, Real, f32x8, f32x16};
use crate::scene::EnvironmentImage;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// The names that [`hemisphere`] knows.
pub const HEMISPHERE_FUNCTIONS: [&str; 6] = ["constant", "cosine", "cos3", "sky", "edge", "sun"];

/// F/p at directions of a density: a mean over the unit square.
struct Over {
    field: Arc<Field>,
    density: Density,
}

impl Over {
    fn lanes<R: Real>(&self, bits: &[Vec<u32>], values: &mut [f64]) {
        for (block, out) in values.chunks_mut(R::WIDTH).enumerate() {
            let u = [0, 1].map(|d| lane_unit::<R>(R::Bits::load(&bits[d][block * R::WIDTH..])));
            let (w, pdf) = self.density.sample(u);
            // cosθ cancels before it can be a small denominator.
            let value = match &self.density {
                Density::Cosine => self.field.lanes(w, true) * R::splat(PI as f32),
                Density::Uniform => self.field.lanes(w, false) * R::splat(TAU as f32),
                _ => self.field.lanes(w, false) / pdf,
            };
            // A direction below the horizon carries nothing.
            let value = value.masked(w.z.gt(R::zero()));
            out.iter_mut().enumerate().for_each(|(lane, out)| *out = f64::from(value.lane(lane)));
        }
    }
}

impl Integrand for Over {
    fn dimensions(&self) -> usize {
        2
    }

    /// Uniform in (cosθ, φ), whatever the density: what product quadrature works on.
    fn at(&self, x: &[f64]) -> f64 {
        let sin = ((1.0 - x[0]) * (1.0 + x[0])).max(0.0).sqrt();
        let (s, c) = (TAU * x[1]).sin_cos();
        TAU * self.field.at([sin * c, sin * s, x[0]], false)
    }

    fn fill(&self, width: Width, bits: &[Vec<u32>], values: &mut [f64]) {
        match width {
            Width::One => self.lanes::<f32>(bits, values),
            Width::Eight => self.lanes::<f32x8>(bits, values),
            Width::Sixteen => self.lanes::<f32x16>(bits, values),
        }
    }
}

pub struct Hemisphere {
    quantity: Quantity,
    field: Arc<Field>,
    width: Width,
}

/// One of [`HEMISPHERE_FUNCTIONS`]; `exponent` is n of cosⁿθ, `seed` picks the sky.
///
/// # Errors
/// There is no such function.
pub fn hemisphere(name: &str, exponent: f64, seed: u64, width: Width) -> Result<Hemisphere, String> {
    if !(0.0..=1000.0).contains(&exponent) {
        return Err(format!("an exponent of {exponent}; give one from 0 to 1000"));
    }
    let sky = |edit: fn(Sky, u64) -> Sky| Field::Sky(edit(Sky::random(seed), seed));
    let (field, formula) = match name {
        "constant" => (Field::Power(0.0), "∫ 1 dω".to_owned()),
        "cosine" => (Field::Power(exponent), format!("∫ cos^{exponent} θ dω")),
        "cos3" => (Field::Power(4.0), "∫ cos³θ cosθ dω".to_owned()),
        "sky" => (sky(|sky, _| sky), format!("∫ L cosθ dω, sky {seed}")),
        "edge" => (sky(Sky::with_edge), format!("∫ L V cosθ dω, sky {seed} behind an edge")),
        "sun" => (sky(Sky::with_sun), format!("∫ L cosθ dω, sky {seed} with a sun of 6°")),
        _ => {
            return Err(format!(
                "no function {name:?} on the hemisphere; there are {}",
                HEMISPHERE_FUNCTIONS.join(", ")
            ));
        }
    };
    Ok(Hemisphere::new(name, formula, field, width))
}

/// The irradiance of an environment image on a plane that faces up.
///
/// # Errors
/// The image is black.
pub fn hemisphere_of_image(image: &EnvironmentImage, width: Width) -> Result<Hemisphere, String> {
    let field = Field::Panorama(Arc::new(Panorama::new(image)?));
    Ok(Hemisphere::new("environment", "∫ L cosθ dω, L the mean of the image's channels, +y up".into(), field, width))
}

const NAMES: [&str; 26] = [
    "mc",
    "mc-is",
    "stratified",
    "owen",
    "fibonacci",
    "bmc-is",
    "halton",
    "sobol",
    "bmc",
    "bmc-zero",
    "bmc-is-zero",
    "bmc-is-se",
    "bmc-is-owen",
    "bmc-is-random",
    "trapezoid",
    "simpson",
    "gauss",
    "mc:phong2",
    "mc:ggx0.5",
    "mc:learned",
    "owen:learned",
    "mc:mis",
    "owen:mis",
    "clamped",
    "ratio",
    "pilot-reuse",
];
const DEFAULTS: usize = 6;

impl Hemisphere {
    fn new(name: &str, formula: String, field: Field, width: Width) -> Self {
        let exact = field.exact();
        let (exact_error, source) = match &field {
            Field::Power(_) => (0.0, "2π/(n + 1)"),
            Field::Sky(_) => (1e-9 * exact, "quadrature in f64"),
            Field::Panorama(image) => (image.exact()[1], "midpoint rule, 2048²"),
        };
        let name = format!("hemisphere, {name}");
        let quantity = Quantity { name, formula, exact, exact_error, source: source.into() };
        Hemisphere { quantity, field: Arc::new(field), width }
    }

    pub fn field(&self) -> &Field {
        &self.field
    }

    /// Variance of one sample F/p.
    pub fn variance(&self, density: Density) -> f64 {
        // Where the power at the horizon makes ∫F²/p diverge no quadrature would notice.
        let at_horizon = |m: f64| match density {
            // Bounded below.
            Density::Learned(_) | Density::Uniform => 2.0 * m,
            Density::Cosine | Density::Ggx(_) | Density::Mis(..) => 2.0 * m - 1.0,
            Density::Phong(n) => 2.0 * m - n,
        };
        let m = if let Field::Power(m) = *self.field { m } else { 1.0 };
        if at_horizon(m) <= -1.0 {
            return f64::INFINITY;
        }
        let closed = match (&*self.field, &density) {
            (Field::Power(m), Density::Uniform) => Some(TAU * TAU / (2.0 * m + 1.0)),
            (Field::Power(m), Density::Cosine) => Some(TAU * PI / (2.0 * m)),
            (field, Density::Learned(learned)) => Some(learned.second_moment(field)),
            (Field::Power(m), Density::Phong(n)) => Some(TAU * TAU / ((n + 1.0) * (2.0 * m - n + 1.0))),
            _ => None,
        };
        let second = closed.unwrap_or_else(|| self.field.second_moment(|w| density.at(w)));
        // Rounding alone makes the best density's variance differ from 0.
        let variance = second - self.quantity.exact.powi(2);
        if variance.abs() < 1e-12 * second { 0.0 } else { variance }
    }

    /// When the pilot of a learned density has paid for itself against the cosine: n samples by it err no more than
    /// n + pilot by the other.
    fn note_on_learning(&self) -> String {
        let learned = self.variance(Density::Learned(Arc::new(Learned::new(&self.field))));
        let (pilot, gain) = (Learned::PILOT as f64, self.variance(Density::Cosine) - learned);
        let pays = if gain > 0.0 { format!("from n = {:.0} on", pilot * learned / gain) } else { "never".to_owned() };
        format!(
            "  learned density: {learned:.7}; its pilot of {pilot} evaluations, not counted in n, pays {pays} against cosine"
        )
    }

    fn over(&self, density: Density) -> Shared {
        Arc::new(Over { field: self.field.clone(), density })
    }

    fn mean(&self, name: &str, points: Points, density: Density) -> Method {
        let method = mean_over(name, points, self.over(density.clone()), self.width);
        let variance = self.variance(density);
        // Of points that are not independent nothing is known but that no finite variance comes of an infinite one.
        if points != Points::Independent && variance.is_finite() {
            return method;
        }
        method.with_variance(move |n| variance / n as f64)
    }

    /// Points and density of names such as mc, mc-is, owen, owen:uniform, mc:phong20: points by themselves are
    /// cosine-distributed, but plain mc is the course's, uniform.
    fn points_and_density(&self, name: &str) -> Option<(Points, Density)> {
        let (points, density) = match name.split_once(':') {
            Some((points, density)) => (points, Density::parse(density, &self.field)?),
            None if name == "mc" => ("mc", Density::Uniform),
            None if name == "mc-is" => ("mc", Density::Cosine),
            None => (name, Density::Cosine),
        };
        Points::ALL.into_iter().find(|p| p.name() == points).map(|points| (points, density))
    }
}

impl Problem for Hemisphere {
    fn quantity(&self) -> Quantity {
        self.quantity.clone()
    }

    fn method_names(&self) -> (Vec<String>, usize) {
        let sun = matches!(*self.field, Field::Sky(Sky { sun: Some(_), .. }));
        (NAMES.iter().filter(|n| sun || !n.ends_with("mis")).map(|n| (*n).to_owned()).collect(), DEFAULTS)
    }

    fn method(&self, name: &str) -> Result<Method, String> {
        if let Some((points, density)) = self.points_and_density(name) {
            return Ok(self.mean(name, points, density));
        }
        if let Some(variant) = gather::Variant::parse(name) {
            return Ok(gather::method(name, variant, self.field.clone(), self.width));
        }
        let uniform = self.over(Density::Uniform);
        if let Some(rule) = Rule::ALL.into_iter().find(|r| r.name() == name) {
            return Ok(product(rule, uniform));
        }
        let cosine: Shared = Arc::new(Over { field: Arc::new(Field::Power(1.0)), density: Density::Uniform });
        match name {
            "clamped" => Ok(clamped(uniform, 1.5 * self.quantity.exact, self.width)),
            "pilot-reuse" => Ok(pilot_reuse(uniform, self.width)),
            "ratio" => Ok(ratio(uniform, cosine, PI, self.width)),
            _ => Err(unknown_method(self, name)),
        }
    }

    fn notes(&self) -> Vec<String> {
        let densities = [
            ("uniform density", Density::Uniform),
            ("cosine density", Density::Cosine),
            ("Phong lobe, n = 2", Density::Phong(2.0)),
            ("GGX, α = 0.5", Density::Ggx(0.5)),
        ];
        let mut notes = vec!["variance of one sample, ∫F²/p − I²:".to_owned()];
        notes.extend(densities.iter().map(|(name, d)| format!("  {name}: {:.7}", self.variance(d.clone()))));
        notes.push(self.note_on_learning());
        if let Some(mis) = Density::parse("mis", &self.field) {
            notes.push(format!("  cosine and the sun's cone, balance heuristic: {:.7}", self.variance(mis)));
        }
        // F ≥ 0 everywhere: sampling in proportion to it leaves nothing to chance.
        notes.push("  the best density, p* ∝ F: 0".into());
        notes
    }
}
