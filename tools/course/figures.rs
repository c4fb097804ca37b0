//! Mean |error| of one estimate on the hemisphere against its number of directions.

use octolux::estimate::bmc::{Covariance, Mean, Measure, PointSet, Points, SetRecipe, point_sets};
use octolux::lane::Vec3;
use octolux::light::EnvironmentMap;
use octolux::report::plot::{Curve, Guide, Plot, Point, Scale};
use octolux::scene::Scene;
use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// Estimates behind each mean, as in the course.
const MC_ESTIMATES: usize = 2500;
const BMC_ESTIMATES: usize = 10;
const COUNTS: [usize; 9] = [20, 30, 40, 50, 60, 70, 80, 90, 100];

/// L of ∫ L cosθ.
struct Integrand {
    name: &'static str,
    file: &'static str,
    radiance: Box<dyn Fn([f64; 3]) -> f64>,
    exact: f64,
}

fn integrands(scene: &Scene) -> Vec<Integrand> {
    let plain = |name, file, exact, radiance: fn([f64; 3]) -> f64| Integrand {
        name,
        file,
        radiance: Box::new(radiance),
        exact,
    };
    let mut all = vec![
        plain("∫ cosθ = π", "cos", PI, |_| 1.0),
        plain("∫ cos³θ cosθ = 2π/5", "cos4", TAU / 5.0, |w| w[2].powi(3)),
    ];
    if let Some(map) = scene.environment.as_ref().and_then(EnvironmentMap::build) {
        // +y is up there.
        let radiance = move |[x, y, z]: [f64; 3]| {
            let light = map.radiance::<f32>(Vec3::new(x as f32, z as f32, -y as f32));
            f64::from(light.x + light.y + light.z) / 3.0
        };
        let exact = by_quadrature(&radiance);
        all.push(Integrand { name: "∫ sky cosθ", file: "sky", radiance: Box::new(radiance), exact });
    }
    all
}

/// The midpoint rule in sin²θ and φ: a million directions, cosine-weighted.
fn by_quadrature(radiance: &dyn Fn([f64; 3]) -> f64) -> f64 {
    const SIDE: usize = 1024;
    let cell = |i: usize, j: usize| {
        let (u, phi) = ((i as f64 + 0.5) / SIDE as f64, (j as f64 + 0.5) / SIDE as f64 * TAU);
        let (sin, cos) = (u.sqrt(), (1.0 - u).sqrt());
        radiance([sin * phi.cos(), sin * phi.sin(), cos])
    };
    let sum: f64 = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))).map(|(i, j)| cell(i, j)).sum();
    PI * sum / (SIDE * SIDE) as f64
}

#[derive(Clone, Copy)]
struct Method {
    name: &'static str,
    importance: bool,
    covariance: Option<Covariance>,
    points: Points,
}

const MC: Method = Method { name: "mc", importance: false, covariance: None, points: Points::Random };
const MC_IS: Method = Method { name: "mc-is", importance: true, ..MC };
const BMC: Method = Method { name: "bmc", covariance: Some(Covariance::SOBOLEV), ..MC };
const BMC_IS: Method = Method { name: "bmc-is", importance: true, ..BMC };
const BMC_IS_LATTICE: Method = Method { name: "bmc-is, fibonacci", points: Points::Fibonacci, ..BMC_IS };

impl Method {
    /// The same in all figures.
    fn look(&self) -> usize {
        [MC, MC_IS, BMC, BMC_IS].iter().position(|m| m.name == self.name).unwrap_or(4)
    }

    /// Mean |error| and its standard error.
    fn error(&self, n: usize, integrand: &Integrand) -> (f64, f64) {
        let sets = if self.covariance.is_some() { BMC_ESTIMATES } else { MC_ESTIMATES };
        let measure = if self.importance { Measure::COSINE } else { Measure::UNIFORM };
        let recipe = SetRecipe {
            points: self.points,
            n,
            sets,
            measure,
            covariance: self.covariance,
            mean: Mean::Constant,
            seed: n as u64,
        };
        let errors: Vec<f64> =
            point_sets(&recipe).iter().map(|set| (self.estimate(set, integrand) - integrand.exact).abs()).collect();
        let mean = errors.iter().sum::<f64>() / sets as f64;
        let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (sets - 1) as f64;
        (mean, (variance / sets as f64).sqrt())
    }

    fn estimate(&self, set: &PointSet, integrand: &Integrand) -> f64 {
        let value = |(i, w): (usize, &f32)| {
            let direction = set.directions.each_ref().map(|axis| f64::from(axis[i]));
            let known = if self.importance { 1.0 } else { direction[2] };
            f64::from(*w) * (integrand.radiance)(direction) * known
        };
        set.weights.iter().enumerate().map(value).sum()
    }
}

pub fn write(scene: &Scene, folder: &Path) -> Result<(), Box<dyn Error>> {
    let practices: [(&str, &[Method]); 3] =
        [("p2", &[MC]), ("p3", &[MC, BMC]), ("p4", &[MC, MC_IS, BMC, BMC_IS, BMC_IS_LATTICE])];
    for integrand in integrands(scene) {
        for (practice, methods) in practices {
            let title = format!("{}: {}", practice.to_uppercase(), integrand.name);
            let mut plot =
                Plot::new(title, ("directions", Scale::Log), ("mean |error|", Scale::Log)).guide(Guide::slope(-0.5));
            for method in methods {
                let found: Vec<(f64, f64)> = COUNTS.iter().map(|&n| method.error(n, &integrand)).collect();
                let shown = |k: usize| format!("{:.2e} ± {:.0e}", found[k].0, found[k].1);
                println!(
                    "{practice} {:4} {:18} n = 20: {}  40: {}  100: {}",
                    integrand.file,
                    method.name,
                    shown(0),
                    shown(2),
                    shown(8)
                );
                // A constant is exact for some: rounding is all that is left, and a logarithm wants something.
                let point = |(n, (y, s)): (&usize, &(f64, f64))| {
                    let y = y.max(1e-9);
                    Point { x: *n as f64, y, lo: (y - s).max(0.5 * y), hi: y + s }
                };
                let points = COUNTS.iter().zip(&found).map(point).collect();
                plot = plot.curve(Curve::new(method.name, points).styled(method.look()));
            }
            std::fs::write(folder.join(format!("{practice}-{}.svg", integrand.file)), plot.svg_file())?;
        }
    }
    Ok(())
}
