//! Errors of two methods on the same problems.

/// ln of the ratio of root mean squares over problems, from pairs of squared errors, and its standard error by leaving out
/// one problem at a time (the jackknife: Efron & Stein 1981).
pub fn ln_ratio(pairs: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let pairs: Vec<[f64; 2]> = pairs.collect();
    let n = pairs.len() as f64;
    let [a, b] = [0, 1].map(|i| pairs.iter().map(|pair| pair[i]).sum::<f64>());
    let without: Vec<f64> = pairs.iter().map(|pair| 0.5 * ((a - pair[0]) / (b - pair[1])).ln()).collect();
    let mean = without.iter().sum::<f64>() / n;
    let spread: f64 = without.iter().map(|v| (v - mean).powi(2)).sum();
    [0.5 * (a / b).ln(), ((n - 1.0) / n * spread).sqrt()]
}
