//! Do sampled directions follow the pdf that is claimed for them? Pearson's χ² test over the sphere.

use super::chi_squared::{self, ChiSquared};
use crate::bsdf::ALPHA_MIN;
use crate::estimate::rules::gauss_legendre;
use crate::lane::{Mask, Real, Vec3, f32x8};
use crate::own::Bsdf;
use crate::sampling::Xoshiro;
use std::f64::consts::TAU;
use std::fmt;

/// Nodes of the quadrature along a side of a cell, and how often a cell is quartered at most.
const NODES: usize = 6;
const DEPTH: u32 = 8;
/// Weight times pdf and value of one direction are computed in two ways: they may differ by this, relatively, where rounding
/// is all that sets them apart. Cosines near 0 and narrow lobes lose the most.
const AGREEMENT: f32 = 2e-2;

/// A χ² test of a direction sampler against its pdf.
///
/// The sphere is cut into cells of equal solid angle in (cosθ, φ); the pdf, per steradian, is integrated over each.
/// Samplers may reject: the missing mass is one more cell. A pdf that integrates to more than 1 fails by itself.
///
/// ```
/// use octolux::{check::DirectionTest, sampling::warp};
/// let sample = |[_, u, v]: [f32; 3]| { let w = warp::cosine_hemisphere([u, v]); Some([w.x, w.y, w.z]) };
/// let right = DirectionTest::default().run(sample, |w| warp::cosine_hemisphere_pdf(w[2]));
/// assert!(right.accepts(), "{right}");
/// let wrong = DirectionTest::default().run(sample, |w| if w[2] > 0.0 { std::f32::consts::FRAC_1_PI / 2.0 } else { 0.0 });
/// assert!(!wrong.accepts()); // uniform over the hemisphere, which these are not
/// ```
#[derive(Clone, Copy, Debug)]
pub struct DirectionTest {
    /// Draws, rejected ones included.
    pub samples: u32,
    /// Of the draws.
    pub seed: u64,
    /// In cosθ and in φ.
    pub cells: [usize; 2],
    /// Probability of rejecting a sampler that is right.
    pub significance: f64,
}

/// 200,000 samples in 16 × 32 cells; one in a thousand right samplers is rejected.
impl Default for DirectionTest {
    fn default() -> Self {
        DirectionTest { samples: 200_000, seed: 1, cells: [16, 32], significance: 1e-3 }
    }
}

/// What a test found; `Display` is for people.
#[derive(Clone, Debug)]
pub struct DirectionReport {
    /// Counts against expectations.
    pub chi_squared: ChiSquared,
    /// The pdf's integral over the sphere.
    pub pdf_total: f64,
    /// Draws that gave no direction.
    pub rejected: u32,
    /// Why it fails whatever the counts say: a direction that is not unit, a pdf above 1 in all, a weight that is not
    /// value/pdf.
    pub fault: Option<String>,
    significance: f64,
}

impl DirectionReport {
    /// Do the samples follow the pdf, as far as this many can tell?
    pub fn accepts(&self) -> bool {
        self.fault.is_none() && self.chi_squared.p_value >= self.significance
    }
}

impl fmt::Display for DirectionReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ChiSquared { statistic, dof, p_value } = self.chi_squared;
        let (total, rejected) = (self.pdf_total, self.rejected);
        write!(f, "χ² {statistic:.1} with {dof} degrees of freedom, p = {p_value:.2e}; ")?;
        write!(f, "the pdf integrates to {total:.5}, {rejected} draws rejected")?;
        self.fault.as_ref().map_or(Ok(()), |fault| write!(f, "; {fault}"))
    }
}

impl DirectionTest {
    /// Tests `sample`, which makes a unit direction of three numbers in [0, 1) or rejects them, against `pdf`, per
    /// steradian.
    pub fn run(
        &self,
        mut sample: impl FnMut([f32; 3]) -> Option<[f32; 3]>,
        pdf: impl Fn([f32; 3]) -> f32,
    ) -> DirectionReport {
        let mut rng = Xoshiro::<f32>::from_keys(|_| self.seed);
        let draws = (0..self.samples).map(|_| sample([rng.next_unit(), rng.next_unit(), rng.next_unit()]));
        self.compare(draws, pdf)
    }

    /// Tests a BSDF as seen from the unit direction `wo`: drawn in eight lanes, evaluated at width 1; also that weight · pdf
    /// is value. Directions drawn from a delta are not of a density: a BSDF that has one fails.
    pub fn bsdf(&self, bsdf: &impl Bsdf, wo: [f32; 3]) -> DirectionReport {
        let mut rng = Xoshiro::<f32x8>::from_keys(|lane| self.seed << 3 | lane as u64);
        let mut draws = Vec::with_capacity(self.samples.next_multiple_of(8) as usize);
        let mut fault = None;
        while draws.len() < self.samples as usize {
            let u: [f32x8; 3] = std::array::from_fn(|_| rng.next_unit());
            let drawn = bsdf.sample(Vec3::<f32x8>::splat(wo), u[0], [u[1], u[2]]);
            for lane in 0..f32x8::WIDTH {
                let wi = drawn.wi.lane(lane);
                if drawn.valid.lane(lane) {
                    let weighted = drawn.weight.lane(lane).map(|w| w * drawn.pdf.lane(lane));
                    let value = bsdf.eval::<f32>(Vec3::splat(wo), Vec3::splat(wi)).value.lane(0);
                    let delta = drawn.delta.lane(lane);
                    fault = fault.or_else(|| sample_fault(wi, weighted, value, delta));
                }
                draws.push(drawn.valid.lane(lane).then_some(wi));
            }
        }
        draws.truncate(self.samples as usize);
        let mut report = self.compare(draws.into_iter(), |wi| bsdf.eval::<f32>(Vec3::splat(wo), Vec3::splat(wi)).pdf);
        report.fault = report.fault.or(fault);
        report
    }

    fn compare(&self, draws: impl Iterator<Item = Option<[f32; 3]>>, pdf: impl Fn([f32; 3]) -> f32) -> DirectionReport {
        let [rows, columns] = self.cells.map(|n| n.max(1));
        let mut observed = vec![0u32; rows * columns + 1];
        let mut fault = None;
        for draw in draws {
            let cell = match draw {
                None => rows * columns,
                Some(w) => {
                    let squared: f32 = w.iter().map(|x| x * x).sum();
                    if (squared - 1.0).abs() > 1e-4 || squared.is_nan() {
                        fault.get_or_insert_with(|| format!("{w:?} is not a unit direction"));
                    }
                    cell(w, rows, columns)
                }
            };
            observed[cell] += 1;
        }
        let n = f64::from(self.samples);
        let (mut expected, error) = self.masses(rows, columns, pdf);
        let total: f64 = expected.iter().sum();
        expected.iter_mut().for_each(|mass| *mass *= n);
        expected.push((n * (1.0 - total)).max(0.0));
        // Room for the quadrature, and for a tenth of what the samples could tell.
        if total.is_nan() || total > 1.0 + error + 0.1 / n.sqrt() {
            fault.get_or_insert_with(|| "a pdf integrates to at most 1".to_owned());
        }
        DirectionReport {
            chi_squared: chi_squared::test(&observed, &expected),
            pdf_total: total,
            rejected: observed[rows * columns],
            fault,
            significance: self.significance,
        }
    }

    /// The pdf's integral over every cell, and a bound on the error of their sum.
    fn masses(&self, rows: usize, columns: usize, pdf: impl Fn([f32; 3]) -> f32) -> (Vec<f64>, f64) {
        let (nodes, mut error) = (gauss_legendre(NODES), 0.0);
        let density = |z: f64, phi: f64| {
            let r = (1.0 - z * z).max(0.0).sqrt();
            f64::from(pdf([(r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32]))
        };
        // A hundredth of the standard deviation of a cell of five counts.
        let tolerance = 0.02 / f64::from(self.samples);
        let cells = (0..rows * columns).map(|i| {
            let (row, column) = ((i / columns) as f64, (i % columns) as f64);
            let z = [1.0 - 2.0 * (row + 1.0) / rows as f64, 1.0 - 2.0 * row / rows as f64];
            let phi = [TAU * column / columns as f64, TAU * (column + 1.0) / columns as f64];
            let first = rectangle(&nodes, z, phi, &density);
            let (mass, off) = quartered(&nodes, z, phi, &density, first, tolerance, DEPTH);
            error += off;
            mass
        });
        (cells.collect(), error)
    }
}

fn sample_fault(wi: [f32; 3], weighted: [f32; 3], value: [f32; 3], delta: bool) -> Option<String> {
    if delta {
        return Some(format!("{wi:?} is drawn from a delta (narrower than alpha {ALPHA_MIN}?): no density to test"));
    }
    let off = |c: usize| {
        let difference = (weighted[c] - value[c]).abs();
        difference.is_nan() || difference > AGREEMENT * value[c].abs().max(1e-4)
    };
    (0..3).any(off).then(|| format!("at {wi:?} weight·pdf is {weighted:?}, value {value:?}"))
}

fn cell(w: [f32; 3], rows: usize, columns: usize) -> usize {
    let [x, y, z] = w.map(f64::from);
    let row = ((1.0 - z) / 2.0 * rows as f64) as usize;
    let turn = y.atan2(x) / TAU;
    let column = ((turn - turn.floor()) * columns as f64) as usize;
    row.min(rows - 1) * columns + column.min(columns - 1)
}

fn rectangle(nodes: &[[f64; 2]], z: [f64; 2], phi: [f64; 2], f: &impl Fn(f64, f64) -> f64) -> f64 {
    let (hz, hp) = (0.5 * (z[1] - z[0]), 0.5 * (phi[1] - phi[0]));
    let along = |&[x, w]: &[f64; 2]| {
        let across = nodes.iter().map(|&[y, v]| v * f(z[0] + hz * (1.0 + x), phi[0] + hp * (1.0 + y)));
        w * across.sum::<f64>()
    };
    hz * hp * nodes.iter().map(along).sum::<f64>()
}

/// Quarters a rectangle until that changes nothing that counts: its integral and how far off it may be.
fn quartered(
    nodes: &[[f64; 2]],
    z: [f64; 2],
    phi: [f64; 2],
    f: &impl Fn(f64, f64) -> f64,
    whole: f64,
    tolerance: f64,
    depth: u32,
) -> (f64, f64) {
    let (mz, mp) = (0.5 * (z[0] + z[1]), 0.5 * (phi[0] + phi[1]));
    let parts = [[z[0], mz], [mz, z[1]]].into_iter().flat_map(|z| [[phi[0], mp], [mp, phi[1]]].map(|phi| (z, phi)));
    let parts: Vec<_> = parts.map(|(z, phi)| (z, phi, rectangle(nodes, z, phi, f))).collect();
    let sum: f64 = parts.iter().map(|part| part.2).sum();
    let change = (sum - whole).abs();
    if change <= tolerance || depth == 0 || change.is_nan() {
        return (sum, change);
    }
    parts.into_iter().fold((0.0, 0.0), |(mass, error), (z, phi, part)| {
        let (m, e) = quartered(nodes, z, phi, f, part, 0.25 * tolerance, depth - 1);
        (mass + m, error + e)
    })
}
