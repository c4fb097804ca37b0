//! Product quadrature on the unit cube: trapezoid, Simpson, Gauss–Legendre.

use super::method::{Claim, Integrand, Method, Prepared, Shared, Single};
use super::points::per_axis;
use super::rules::gauss_legendre;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    Trapezoid,
    Simpson,
    Gauss,
}

impl Rule {
    pub const ALL: [Rule; 3] = [Rule::Trapezoid, Rule::Simpson, Rule::Gauss];

    pub fn name(self) -> &'static str {
        match self {
            Rule::Trapezoid => "trapezoid",
            Rule::Simpson => "simpson",
            Rule::Gauss => "gauss",
        }
    }

    /// Nodes and weights on [0, 1], at most `n`; `None` where the rule needs more.
    pub fn nodes(self, n: usize) -> Option<Vec<[f64; 2]>> {
        match self {
            Rule::Trapezoid => (n >= 2).then(|| equidistant(n - 1, |i, m| if i == 0 || i == m { 0.5 } else { 1.0 })),
            // An even number of intervals.
            Rule::Simpson => (n >= 3).then(|| {
                let third = |i: usize, m: usize| if i == 0 || i == m { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
                let nodes = equidistant((n - 1) & !1, third);
                nodes.into_iter().map(|[x, w]| [x, w / 3.0]).collect()
            }),
            Rule::Gauss => {
                let rule = gauss_legendre(n.max(1));
                Some(rule.into_iter().map(|[x, w]| [0.5 + 0.5 * x, 0.5 * w]).collect())
            }
        }
    }
}

fn equidistant(m: usize, weight: impl Fn(usize, usize) -> f64) -> Vec<[f64; 2]> {
    (0..=m).map(|i| [i as f64 / m as f64, weight(i, m) / m as f64]).collect()
}

/// The rule along every axis, with as many nodes an axis as n samples allow.
pub fn product(rule: Rule, integrand: Shared) -> Method {
    Method::new(rule.name(), Claim::Deterministic, move |n| {
        let dimensions = integrand.dimensions();
        let nodes = rule.nodes(per_axis(n, dimensions))?;
        let integrand = integrand.clone();
        let samples = nodes.len().checked_pow(dimensions as u32)?;
        Some(Prepared::new(samples, move |_, _| Single {
            value: sum(&nodes, &*integrand, dimensions),
            standard_error: None,
        }))
    })
}

fn sum(nodes: &[[f64; 2]], integrand: &dyn Integrand, dimensions: usize) -> f64 {
    let mut index = vec![0; dimensions];
    let mut x = vec![0.0; dimensions];
    let mut total = 0.0;
    loop {
        let mut weight = 1.0;
        for (x, &i) in x.iter_mut().zip(&index) {
            *x = nodes[i][0];
            weight *= nodes[i][1];
        }
        total += weight * integrand.at(&x);
        // The next index, the first digit fastest.
        let Some(digit) = index.iter().position(|&i| i + 1 < nodes.len()) else { return total };
        index[..digit].fill(0);
        index[digit] += 1;
    }
}
