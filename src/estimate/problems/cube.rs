//! π by darts, and integrals over the unit cube of 1 to 20 dimensions.

use super::UnitProblem;
use crate::estimate::method::Integrand;
use crate::estimate::points::{MAX_DIMENSIONS, lane_unit};
use crate::estimate::study::Quantity;
use crate::kernel::Width;
use crate::lane::{Real, f32x8, f32x16, math};
use std::f64::consts::PI;
use std::sync::Arc;

/// 4 where a dart on the unit square hits the quarter disc.
struct Dart;

impl Integrand for Dart {
    fn dimensions(&self) -> usize {
        2
    }
    fn at(&self, x: &[f64]) -> f64 {
        if x[0] * x[0] + x[1] * x[1] < 1.0 { 4.0 } else { 0.0 }
    }
}

/// π as four times the area of the quarter disc. A sample is 4 with probability π/4: its variance is π(4 − π).
pub fn pi(width: Width) -> UnitProblem {
    UnitProblem {
        quantity: Quantity {
            name: "pi".into(),
            formula: "∫∫ 4·[x² + y² < 1] dx dy over the unit square".into(),
            exact: PI,
            exact_error: 0.0,
            source: "π".into(),
        },
        integrand: Arc::new(Dart),
        variance: PI * (4.0 - PI),
        importance: None,
        optimal_variance: Some(0.0),
        control: None,
        clamp: 2.0,
        rules: true,
        width,
    }
}

/// Functions on the cube, all with mean 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Function {
    /// ∏ (π/2) sin(πxᵢ): smooth.
    Sine,
    /// ∏ (½ + xᵢ): smooth, and multilinear, so that a product trapezoid is exact.
    Linear,
    /// 2·[Σxᵢ < d/2]: a jump across the axes.
    Diagonal,
    /// 2·[all xᵢ < 2^(−1/d)]: a jump along the axes.
    Corner,
}

/// The names that [`cube`] knows.
pub const CUBE_FUNCTIONS: [&str; 4] = ["sine", "linear", "diagonal", "corner"];

struct CubeFunction {
    function: Function,
    dimensions: usize,
}

impl CubeFunction {
    /// Where the corner ends.
    fn edge(&self) -> f64 {
        0.5f64.powf(1.0 / self.dimensions as f64)
    }

    fn variance(&self) -> f64 {
        let d = self.dimensions as i32;
        match self.function {
            Function::Sine => (PI * PI / 8.0).powi(d) - 1.0,
            Function::Linear => (13.0 / 12.0f64).powi(d) - 1.0,
            Function::Diagonal | Function::Corner => 1.0,
        }
    }

    /// How far the mean in single precision may be off.
    fn rounding(&self) -> f64 {
        let (d, half_ulp) = (self.dimensions as f64, f64::powi(2.0, -24));
        match self.function {
            // A factor's, and that of the product so far: each by half an ulp. The factor ½π is off by as much.
            Function::Sine => 3.0 * d * half_ulp,
            Function::Linear => 2.0 * d * half_ulp,
            // Sums near d/2 are off by half an ulp of it for each term after the first; their density is at most 1.
            Function::Diagonal => 2.0 * d * (d - 1.0) * half_ulp,
            // An edge is off by half an ulp along each axis.
            Function::Corner => d * half_ulp,
        }
    }

    fn lanes<R: Real>(&self, bits: &[Vec<u32>], values: &mut [f64]) {
        use crate::lane::Bits;
        let edge = R::splat(self.edge() as f32);
        let half = R::splat(0.5 * self.dimensions as f32);
        for (block, out) in values.chunks_mut(R::WIDTH).enumerate() {
            let coordinate = |row: &Vec<u32>| lane_unit::<R>(R::Bits::load(&row[block * R::WIDTH..]));
            let rows = &bits[..self.dimensions];
            let value = match self.function {
                Function::Sine => rows.iter().fold(R::one(), |p, row| {
                    let (sine, _) = math::sincos_2pi(coordinate(row) * R::splat(0.5));
                    p * (R::splat(std::f32::consts::FRAC_PI_2) * sine)
                }),
                Function::Linear => rows.iter().fold(R::one(), |p, row| p * (R::splat(0.5) + coordinate(row))),
                Function::Diagonal => {
                    let sum = rows.iter().fold(R::zero(), |s, row| s + coordinate(row));
                    R::splat(2.0).masked(sum.lt(half))
                }
                Function::Corner => {
                    let inside = |v: R, row| v.masked(coordinate(row).lt(edge));
                    rows.iter().fold(R::splat(2.0), inside)
                }
            };
            out.iter_mut().enumerate().for_each(|(lane, out)| *out = f64::from(value.lane(lane)));
        }
    }
}

impl Integrand for CubeFunction {
    fn dimensions(&self) -> usize {
        self.dimensions
    }

    fn at(&self, x: &[f64]) -> f64 {
        match self.function {
            Function::Sine => x.iter().map(|x| 0.5 * PI * (PI * x).sin()).product(),
            Function::Linear => x.iter().map(|x| 0.5 + x).product(),
            Function::Diagonal if x.iter().sum::<f64>() < 0.5 * self.dimensions as f64 => 2.0,
            Function::Corner if x.iter().all(|&x| x < self.edge()) => 2.0,
            _ => 0.0,
        }
    }

    fn fill(&self, width: Width, bits: &[Vec<u32>], values: &mut [f64]) {
        match width {
            Width::One => self.lanes::<f32>(bits, values),
            Width::Eight => self.lanes::<f32x8>(bits, values),
            Width::Sixteen => self.lanes::<f32x16>(bits, values),
        }
    }
}

/// Σ xᵢ over its mean: what the ratio estimator divides by.
struct Sum(usize);

impl Integrand for Sum {
    fn dimensions(&self) -> usize {
        self.0
    }
    fn at(&self, x: &[f64]) -> f64 {
        x.iter().sum::<f64>() / (0.5 * self.0 as f64)
    }
}

/// A function of `dimensions` numbers whose integral over the cube is 1.
///
/// # Errors
/// The name or the number of dimensions is none that is known.
pub fn cube(name: &str, dimensions: usize, width: Width) -> Result<UnitProblem, String> {
    let (function, formula) = match name {
        "sine" => (Function::Sine, "∫ ∏ (π/2) sin(πxᵢ) dx"),
        "linear" => (Function::Linear, "∫ ∏ (½ + xᵢ) dx"),
        "diagonal" => (Function::Diagonal, "∫ 2·[Σxᵢ < d/2] dx"),
        "corner" => (Function::Corner, "∫ 2·[all xᵢ < 2^(−1/d)] dx"),
        _ => return Err(format!("no function {name:?} on the cube; there are {}", CUBE_FUNCTIONS.join(", "))),
    };
    if !(1..=MAX_DIMENSIONS).contains(&dimensions) {
        return Err(format!("{dimensions} dimensions; give 1 to {MAX_DIMENSIONS}"));
    }
    let integrand = CubeFunction { function, dimensions };
    Ok(UnitProblem {
        quantity: Quantity {
            name: format!("cube-d, {name}, d = {dimensions}"),
            formula: formula.into(),
            exact: 1.0,
            exact_error: integrand.rounding(),
            source: "closed form".into(),
        },
        variance: integrand.variance(),
        integrand: Arc::new(integrand),
        importance: None,
        optimal_variance: Some(0.0),
        control: Some((Arc::new(Sum(dimensions)), 1.0)),
        clamp: 1.5,
        rules: true,
        width,
    })
}
