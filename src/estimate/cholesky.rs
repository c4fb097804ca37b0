//! Cholesky factorisation in f64: f32 fails on smooth kernels from some 256 points on.

/// L with L·Lᵀ = Q, stored by rows.
#[derive(Clone, Debug)]
pub struct Cholesky {
    n: usize,
    lower: Vec<f64>,
}

impl Cholesky {
    /// Factors the symmetric `n` × `n` matrix `q` + `jitter`·I. `None` where a pivot is not positive: the matrix is not
    /// positive definite in f64. Only the lower triangle of `q` is read.
    pub fn new(q: &[f64], n: usize, jitter: f64) -> Option<Self> {
        let mut lower = vec![0.0; n * n];
        for i in 0..n {
            let (done, rest) = lower.split_at_mut(i * n);
            let row = &mut rest[..n];
            for j in 0..i {
                let above = &done[j * n..j * n + j + 1];
                row[j] = (q[i * n + j] - dot(&row[..j], &above[..j])) / above[j];
            }
            let pivot = q[i * n + i] + jitter - dot(&row[..i], &row[..i]);
            // False for a NaN too.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            row[i] = pivot.sqrt();
        }
        Some(Self { n, lower })
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.lower[i * self.n..i * self.n + i + 1]
    }

    /// L⁻¹ b.
    pub fn forward(&self, b: &[f64]) -> Vec<f64> {
        let mut x = b.to_vec();
        for i in 0..self.n {
            let row = self.row(i);
            x[i] = (x[i] - dot(&row[..i], &x[..i])) / row[i];
        }
        x
    }

    /// Q⁻¹ b.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = self.forward(b);
        for i in (0..self.n).rev() {
            let row = self.row(i);
            x[i] /= row[i];
            let known = x[i];
            for (below, l) in x[..i].iter_mut().zip(row) {
                *below -= known * l;
            }
        }
        x
    }

    /// L x: of standard normal x, numbers with covariance Q.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.n).map(|i| dot(self.row(i), &x[..=i])).collect()
    }

    /// bᵀ Q⁻¹ b.
    pub fn quadratic(&self, b: &[f64]) -> f64 {
        let half = self.forward(b);
        dot(&half, &half)
    }

    /// bᵀ Q b = |Lᵀb|².
    pub fn energy(&self, b: &[f64]) -> f64 {
        let mut along = vec![0.0; self.n];
        for (i, b) in b.iter().enumerate() {
            along.iter_mut().zip(self.row(i)).for_each(|(sum, l)| *sum += l * b);
        }
        dot(&along, &along)
    }

    /// The smallest of the squares on the diagonal: how near Q is to singular.
    pub fn smallest_pivot(&self) -> f64 {
        (0..self.n).map(|i| self.row(i)[i].powi(2)).fold(f64::INFINITY, f64::min)
    }

    /// ln |Q|.
    pub fn ln_determinant(&self) -> f64 {
        (0..self.n).map(|i| 2.0 * self.row(i)[i].ln()).sum()
    }
}

/// Eight partial sums in a fixed order, so that the compiler may keep them in a register.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_eights, b_eights) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_eights.remainder().iter().zip(b_eights.remainder()).map(|(x, y)| x * y).sum();
    let mut sums = [0.0; 8];
    for (x, y) in a_eights.zip(b_eights) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}
