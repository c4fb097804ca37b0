//! Gauss–Legendre quadrature.

/// Nodes and weights on [−1, 1] in rising order, by Newton's method on the Legendre polynomial P_n. `n` ≥ 1.
pub fn gauss_legendre(n: usize) -> Vec<[f64; 2]> {
    (0..n).rev().map(|i| node(n, i)).collect()
}

fn node(n: usize, i: usize) -> [f64; 2] {
    let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
    let mut slope = 1.0;
    // Newton doubles its digits from an estimate good to 1/n²: six steps are more than enough.
    for _ in 0..6 {
        let (mut p, mut before) = (1.0, 0.0);
        for j in 0..n {
            let j = j as f64;
            (p, before) = (((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0), p);
        }
        slope = n as f64 * (x * p - before) / (x * x - 1.0);
        x -= p / slope;
    }
    [x, 2.0 / ((1.0 - x * x) * slope * slope)]
}

/// A Gauss–Legendre rule to be used over and over.
#[derive(Clone, Debug)]
pub struct Gauss {
    nodes: Vec<[f64; 2]>,
}

impl Gauss {
    pub fn new(n: usize) -> Self {
        Self { nodes: gauss_legendre(n.max(1)) }
    }

    /// ∫ f over [a, b] with `panels` equal panels, summed in rising order.
    pub fn integrate(&self, [a, b]: [f64; 2], panels: usize, mut f: impl FnMut(f64) -> f64) -> f64 {
        let half = 0.5 * (b - a) / panels as f64;
        let mut sum = 0.0;
        for panel in 0..panels {
            let middle = a + half * (2 * panel + 1) as f64;
            for &[x, weight] in &self.nodes {
                sum += weight * f(middle + half * x);
            }
        }
        half * sum
    }
}
