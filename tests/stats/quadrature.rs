//! Gauss–Legendre quadrature, plain and adaptive over rectangles.

/// Nodes and weights of the `n`-point Gauss–Legendre rule on [−1, 1], by Newton's method on P_n.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let root = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..100 {
            let (mut p, mut p1) = (1.0, 0.0);
            for j in 0..n {
                let j = j as f64;
                (p, p1) = (((2.0 * j + 1.0) * x * p - j * p1) / (j + 1.0), p);
            }
            slope = n as f64 * (x * p - p1) / (x * x - 1.0);
            let step = p / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(root).collect()
}

/// ∫ f over [a, b] with `panels` equal panels of the given rule.
pub fn integrate(rule: &[(f64, f64)], a: f64, b: f64, panels: usize, f: impl Fn(f64) -> f64) -> f64 {
    let half = 0.5 * (b - a) / panels as f64;
    let panel = |i: usize| {
        let mid = a + half * (2 * i + 1) as f64;
        rule.iter().map(|&(x, w)| w * f(mid + half * x)).sum::<f64>()
    };
    half * (0..panels).map(panel).sum::<f64>()
}

/// A rectangle of the domain of a function of two variables.
#[derive(Clone, Copy, Debug)]
pub struct Rect {
    pub x: [f64; 2],
    pub y: [f64; 2],
}

impl Rect {
    fn quarters(&self) -> [Rect; 4] {
        let mid = |r: [f64; 2]| 0.5 * (r[0] + r[1]);
        let (mx, my) = (mid(self.x), mid(self.y));
        let (l, r, b, t) = ([self.x[0], mx], [mx, self.x[1]], [self.y[0], my], [my, self.y[1]]);
        [Rect { x: l, y: b }, Rect { x: r, y: b }, Rect { x: l, y: t }, Rect { x: r, y: t }]
    }
}

/// Adaptive integration over rectangles: a 4 × 4 Gauss rule against the sum of its quarters.
pub struct Adaptive<F> {
    pub f: F,
    rule: Vec<(f64, f64)>,
    /// Wanted absolute error of one call.
    pub tolerance: f64,
}

/// Deep enough for a jump along a curve; what is left beyond it is in the reported error.
const MAX_DEPTH: u32 = 12;

/// The part of a quarter's side beyond the outermost of its four nodes (½(1 − .8611)), halved for the half rectangle.
const OUTSIDE_NODES: f64 = 0.035;

impl<F: Fn(f64, f64) -> f64> Adaptive<F> {
    pub fn new(tolerance: f64, f: F) -> Self {
        Adaptive { f, rule: gauss_legendre(4), tolerance }
    }

    /// (integral, estimated error) after at least `min_depth` subdivisions.
    pub fn integrate(&self, r: Rect, min_depth: u32) -> (f64, f64) {
        self.refine(r, self.rule_over(r), 0, min_depth)
    }

    fn rule_over(&self, r: Rect) -> f64 {
        let half = |s: [f64; 2]| 0.5 * (s[1] - s[0]);
        let (hx, hy) = (half(r.x), half(r.y));
        let (mx, my) = (r.x[0] + hx, r.y[0] + hy);
        let row = |y: f64| self.rule.iter().map(|&(x, w)| w * (self.f)(mx + hx * x, y)).sum::<f64>();
        hx * hy * self.rule.iter().map(|&(y, w)| w * row(my + hy * y)).sum::<f64>()
    }

    /// What a jump to zero between the outermost nodes and the rectangle's border may hide from both rules: the corners
    /// tell whether there is one. (A hundredth inside, because a border may lie in the jump itself, as the horizon's do.)
    fn overlooked(&self, r: Rect, integral: f64) -> f64 {
        let at = |s: [f64; 2], t: f64| s[0] + (s[1] - s[0]) * t;
        let corners =
            [(0.01, 0.01), (0.99, 0.01), (0.01, 0.99), (0.99, 0.99)].map(|(x, y)| (self.f)(at(r.x, x), at(r.y, y)));
        let zeros = corners.iter().filter(|&&c| c == 0.0).count();
        if zeros == 0 || zeros == 4 && integral == 0.0 {
            return 0.0;
        }
        let area = (r.x[1] - r.x[0]) * (r.y[1] - r.y[0]);
        let height = corners.iter().fold((integral / area).abs(), |m, c| m.max(c.abs()));
        OUTSIDE_NODES * area * height
    }

    fn refine(&self, r: Rect, coarse: f64, depth: u32, min_depth: u32) -> (f64, f64) {
        let quarters = r.quarters();
        let parts = quarters.map(|q| self.rule_over(q));
        let fine: f64 = parts.iter().sum();
        let error = (fine - coarse).abs().max(self.overlooked(r, fine));
        // Along a jump 2^depth pieces err at each depth, so a piece's share halves with each.
        let enough = error <= self.tolerance * f64::powi(0.5, depth as i32);
        if depth >= min_depth && (enough || depth >= MAX_DEPTH) || !fine.is_finite() {
            return (fine, error);
        }
        let (mut sum, mut err) = (0.0, 0.0);
        for (q, part) in quarters.into_iter().zip(parts) {
            let (s, e) = self.refine(q, part, depth + 1, min_depth);
            sum += s;
            err += e;
        }
        (sum, err)
    }
}
