//! Numbers that say how far image A is from image B.

use serde::Serialize;

use crate::film::{Attribute, ExrImage, VarianceValidity};

use super::sidak::sidak_bound;

/// Below this many samples a z-score's variance is itself so uncertain that its tails are not the normal ones: under 64
/// samples of each, Student's t puts more than four times as much beyond the bound for a 256×256 image.
const NORMAL_SAMPLES: u64 = 64;
/// Errors of skewed samples leave each other's tails out where both images have as many: from so many times as many on they do not.
/// (256 and 1024 samples of a Cornell box against 8384: 16 of 20 and 0 of 8 comparisons went beyond.)
const UNEQUAL: u64 = 2;

/// How far image A is from B. Sums run over all pixels and channels in order, in f64; values that are not finite in A
/// or B are left out and counted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    pub a: String,
    pub b: String,
    pub width: u32,
    pub height: u32,
    /// Every value of R, G, B has the same bits in A and B.
    pub identical: bool,
    /// Values (of 3 · width · height) that are NaN or infinite in A or B.
    pub non_finite: u64,
    /// √(mean (a − b)²).
    pub rmse: f64,
    /// mean (a − b)²/(b² + 0.01).
    pub relmse: f64,
    pub mean_a: [f64; 3],
    pub mean_b: [f64; 3],
    /// mean_a / mean_b per channel; `None` where B's mean is 0.
    pub mean_ratio: [Option<f64>; 3],
    /// Largest |a − b|, and where.
    pub max_abs_difference: f64,
    pub max_at: Option<Place>,
    /// `None` unless both files hold variances that are valid for it; [`Self::notes`] then says why.
    pub z: Option<ZScores>,
    pub notes: Vec<String>,
}

/// A value's place in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Place {
    pub x: u32,
    pub y: u32,
    /// 0 red, 1 green, 2 blue.
    pub channel: u32,
}

/// z = (a − b)/√(var a + var b) over the values whose variances sum to more than 0. For independent renders of the
/// same image the mean is near 0, the standard deviation near 1 where pixels have samples enough for their mean to be
/// normal, and none is beyond the bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZScores {
    pub tested: u64,
    pub mean: f64,
    /// Unbiased; 0 for one value.
    pub standard_deviation: f64,
    pub max_abs: f64,
    pub max_at: Place,
    /// Šidák bound for `tested` values at family-wise 1 %.
    pub bound: f64,
    pub beyond_bound: u64,
    /// Values whose variances are both 0 and that differ nevertheless: no noise can explain them.
    pub unexplained: u64,
}

/// Compares the colours of two images. `None` if their sizes differ.
pub fn compare(a: &ExrImage, b: &ExrImage, (name_a, name_b): (&str, &str)) -> Option<Comparison> {
    if (a.width, a.height) != (b.width, b.height) {
        return None;
    }
    let (mut squares, mut relative) = (0.0, 0.0);
    let (mut sum_a, mut sum_b) = ([0.0; 3], [0.0; 3]);
    let (mut non_finite, mut identical) = (0u64, true);
    let (mut counted, mut max_abs, mut max_at) = ([0u64; 3], 0.0f64, None);
    for (c, (plane_a, plane_b)) in a.rgb().into_iter().zip(b.rgb()).enumerate() {
        for (i, (&va, &vb)) in plane_a.iter().zip(plane_b).enumerate() {
            identical &= va.to_bits() == vb.to_bits();
            if !(va.is_finite() && vb.is_finite()) {
                non_finite += 1;
                continue;
            }
            let (va, vb) = (f64::from(va), f64::from(vb));
            let difference = va - vb;
            squares += difference * difference;
            relative += difference * difference / (vb * vb + 0.01);
            sum_a[c] += va;
            sum_b[c] += vb;
            counted[c] += 1;
            if difference.abs() > max_abs {
                (max_abs, max_at) = (difference.abs(), Some(place(i, c, a.width)));
            }
        }
    }
    let values = counted.iter().sum::<u64>().max(1) as f64;
    let mean = |sum: [f64; 3]| std::array::from_fn(|c| sum[c] / counted[c].max(1) as f64);
    let (mean_a, mean_b): ([f64; 3], [f64; 3]) = (mean(sum_a), mean(sum_b));
    let (z, notes) = z_scores(a, b);
    Some(Comparison {
        a: name_a.to_owned(),
        b: name_b.to_owned(),
        width: a.width,
        height: a.height,
        identical,
        non_finite,
        rmse: (squares / values).sqrt(),
        relmse: relative / values,
        mean_a,
        mean_b,
        mean_ratio: std::array::from_fn(|c| (mean_b[c] != 0.0).then(|| mean_a[c] / mean_b[c])),
        max_abs_difference: max_abs,
        max_at,
        z,
        notes,
    })
}

fn place(index: usize, channel: usize, width: u32) -> Place {
    let index = index as u64;
    let width = u64::from(width.max(1));
    Place { x: (index % width) as u32, y: (index / width) as u32, channel: channel as u32 }
}

fn z_scores(a: &ExrImage, b: &ExrImage) -> (Option<ZScores>, Vec<String>) {
    let (variance_a, variance_b) = match (valid_variance(a), valid_variance(b)) {
        (Ok(va), Ok(vb)) => (va, vb),
        (Err(why), _) => return (None, vec![format!("no z-scores: A {why}")]),
        (_, Err(why)) => return (None, vec![format!("no z-scores: B {why}")]),
    };
    let mut notes = Vec::new();
    if let (Some(seed_a), Some(seed_b)) = (a.attribute("seed"), b.attribute("seed"))
        && seed_a.to_string() == seed_b.to_string()
    {
        notes.push(format!("both used seed {seed_a}: where they share samples, z-scores are too small"));
    }
    notes.extend(samples_note([a, b].map(|image| samples(image)?.parse().ok())));
    let mut scores = ScoreSums::default();
    for c in 0..3 {
        let values = a.rgb()[c].iter().zip(b.rgb()[c]);
        let variances = variance_a[c].iter().zip(variance_b[c]);
        for (i, ((&va, &vb), (&sa, &sb))) in values.zip(variances).enumerate() {
            scores.add(f64::from(va) - f64::from(vb), f64::from(sa) + f64::from(sb), place(i, c, a.width));
        }
    }
    let finished = scores.finish();
    if finished.is_none() {
        notes.push("no z-scores: no variance is above 0".to_owned());
    }
    (finished, notes)
}

/// The variance planes, or why they cannot be used for z-scores.
fn valid_variance(image: &ExrImage) -> Result<[&[f32]; 3], &'static str> {
    let planes = image.variance().ok_or("has no variance")?;
    match image.variance_validity() {
        Some(VarianceValidity::Independent) => Ok(planes),
        Some(VarianceValidity::Correlated) => Err("has a variance of correlated samples, which overstates it"),
        Some(VarianceValidity::Stopped) => Err("stopped on its own values, which biases mean and variance"),
        Some(VarianceValidity::Shared) => Err("has a variance that leaves out the error of shared point sets"),
        None => Err("does not say what its variance is valid for"),
    }
}

/// All z are kept: their count beyond a bound is only known when the number tested is.
#[derive(Default)]
struct ScoreSums {
    scores: Vec<f64>,
    largest: Option<(f64, Place)>,
    unexplained: u64,
}

impl ScoreSums {
    fn add(&mut self, difference: f64, variance: f64, place: Place) {
        if variance > 0.0 && variance.is_finite() && difference.is_finite() {
            let z = difference / variance.sqrt();
            self.scores.push(z);
            if self.largest.is_none_or(|(largest, _)| z.abs() > largest) {
                self.largest = Some((z.abs(), place));
            }
        } else if variance == 0.0 && difference.is_finite() && difference != 0.0 {
            self.unexplained += 1;
        }
    }

    fn finish(self) -> Option<ZScores> {
        let (max_abs, max_at) = self.largest?;
        let tested = self.scores.len() as u64;
        let mean = self.scores.iter().sum::<f64>() / tested as f64;
        let squares: f64 = self.scores.iter().map(|z| (z - mean) * (z - mean)).sum();
        let bound = sidak_bound(tested);
        Some(ZScores {
            tested,
            mean,
            standard_deviation: (squares / (tested - 1).max(1) as f64).sqrt(),
            max_abs,
            max_at,
            bound,
            beyond_bound: self.scores.iter().filter(|z| z.abs() > bound).count() as u64,
            unexplained: self.unexplained,
        })
    }
}

/// Why z-scores of images of so many samples may be larger than those of normal errors.
fn samples_note(samples: [Option<u64>; 2]) -> Option<String> {
    let known = || samples.into_iter().flatten();
    let (few, many) = (known().min()?, known().max()?);
    if few < NORMAL_SAMPLES {
        return Some(format!(
            "{few} samples are few for a mean to be normal: z-scores spread wider than the bound allows"
        ));
    }
    (many >= UNEQUAL * few).then(|| {
        format!(
            "{few} samples against {many}: where single samples carry much, the fewer have a small variance just where \
             they missed light, and z-scores beyond the bound are to be expected"
        )
    })
}

/// The number of samples a file says it was made of, for the summary line.
pub(super) fn samples(image: &ExrImage) -> Option<String> {
    image.attribute("samples").map(Attribute::to_string)
}
