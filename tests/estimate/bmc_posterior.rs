//! Does the posterior mean what it says? Functions drawn from the prior itself.

use crate::stats::special::{quantile, student_two_sided};
use crate::stats::{Moments, Rng, assert_mean, assert_variance};
use octolux::estimate::bmc::{
    Covariance, Mean, Measure, Points, Rules, SetRecipe, System, gram, grid, point_sets, polar_points, rank, weights,
};
use std::f64::consts::TAU;

/// Lower factor of a positive definite matrix given by rows.
fn factor(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut l: Vec<Vec<f64>> = Vec::new();
    for i in 0..rows.len() {
        let mut row = vec![0.0; i + 1];
        for j in 0..=i {
            let before: f64 = (0..j).map(|k| row[k] * if j == i { row[k] } else { l[j][k] }).sum();
            row[j] = if i == j { (rows[i][i] - before).sqrt() } else { (rows[i][j] - before) / l[j][j] };
        }
        assert!(row[i] > 0.0);
        l.push(row);
    }
    l
}

fn draw(l: &[Vec<f64>], rng: &mut Rng) -> Vec<f64> {
    let e: Vec<f64> = l.iter().map(|_| rng.normal()).collect();
    l.iter().map(|row| row.iter().zip(&e).map(|(a, b)| a * b).sum()).collect()
}

fn directions(polar: &[[f64; 2]]) -> Vec<[f64; 3]> {
    let one = |&[c, t]: &[f64; 2]| {
        let s = (1.0 - c * c).sqrt();
        [s * (TAU * t).cos(), s * (TAU * t).sin(), c]
    };
    polar.iter().map(one).collect()
}

fn system(k: Covariance, polar: &[[f64; 2]]) -> System {
    let (rules, measure) = (Rules::new(), Measure::COSINE);
    let z = polar.iter().map(|p| measure.embedding(k, p[0].acos(), &rules)).collect();
    System { gram: gram(k, &directions(polar)), z, total: measure.total(), self_energy: measure.self_energy(k, &rules) }
}

/// Values at the points and the integral are jointly normal with covariance [[Q, z], [zᵀ, V₀]]: draws from it must find the
/// posterior mean unbiased and its variance right, to 20,000 draws' standard error of 1 %.
#[test]
fn the_posterior_of_the_prior_is_calibrated() {
    let n = 24;
    let polar = polar_points(Points::Fibonacci, Measure::COSINE, n, 4, 0);
    let covariances = [Covariance::SOBOLEV, Covariance::SquaredExponential { length: 0.4 }];
    for (seed, k) in covariances.into_iter().enumerate() {
        let system = system(k, &polar);
        let mut rows: Vec<Vec<f64>> = (0..n).map(|i| system.gram[i * n..(i + 1) * n].to_vec()).collect();
        rows.push(system.z.iter().copied().chain([system.self_energy]).collect());
        let l = factor(&rows);
        let (zero, constant) = (weights(&system, Mean::Zero, 0.0), weights(&system, Mean::Constant, 0.0));
        let (mut z_scores, mut t_scores) = (Moments::new(), Moments::new());
        let t95 = quantile(0.05, |t| student_two_sided((n - 1) as f64, t));
        let mut covered = Moments::new();
        let mut rng = Rng::new(seed as u64);
        for _ in 0..20_000 {
            let mut y = draw(&l, &mut rng);
            let integral = y.pop().unwrap();
            z_scores.push((integral - zero.estimate(&y)) / zero.unit_variance.unwrap().sqrt());
            // Any constant, and any scale: here 50 and 3.
            let moved: Vec<f64> = y.iter().map(|y| 50.0 + 3.0 * y).collect();
            let truth = 50.0 * system.total + 3.0 * integral;
            let t = (truth - constant.estimate(&moved)) / constant.variance(&moved).unwrap().sqrt();
            t_scores.push(t);
            covered.push(f64::from(u8::from(t.abs() <= t95)));
        }
        assert_mean("z", &z_scores, 0.0, 0.0, 8);
        assert_variance("z", &z_scores, 1.0, 0.0, 8);
        assert_mean("t", &t_scores, 0.0, 0.0, 8);
        assert_mean("coverage of 95 %", &covered, 0.95, 0.0, 8);
    }
}

/// Functions drawn with one length-scale: the evidence prefers it, or its neighbour on the grid, to all others.
#[test]
fn the_evidence_finds_the_length_scale() {
    let n = 64;
    let polar = polar_points(Points::Fibonacci, Measure::COSINE, n, 4, 0);
    let points = directions(&polar);
    for truth in [0.2, 0.5] {
        let q = gram(Covariance::SquaredExponential { length: truth }, &points);
        let rows: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| q[i * n + j] + if i == j { 1e-8 } else { 0.0 }).collect()).collect();
        let l = factor(&rows);
        let mut rng = Rng::new(9);
        let functions: Vec<Vec<f64>> = (0..8).map(|_| draw(&l, &mut rng)).collect();
        let ranked = rank(&grid(), &points, &functions);
        let Covariance::SquaredExponential { length } = ranked[0].covariance else { panic!("{:?}", ranked[0]) };
        assert!((length / truth).ln().abs() < 0.42, "{length} for {truth}");
    }
    assert!(rank(&grid(), &points, &[vec![2.0; n]]).iter().all(|e| e.ln_likelihood == 0.0), "a constant says nothing");
}

#[test]
fn sets_do_not_depend_on_threads() {
    let recipe = SetRecipe {
        points: Points::Owen,
        n: 20,
        sets: 5,
        measure: Measure::COSINE,
        covariance: Some(Covariance::SOBOLEV),
        mean: Mean::Constant,
        seed: 8,
    };
    let bits = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let sets = pool.install(|| point_sets(&recipe));
        let all = sets.iter().flat_map(|s| s.directions.iter().flatten().chain(&s.weights).map(|v| v.to_bits()));
        all.collect::<Vec<_>>()
    };
    assert_eq!(bits(1), bits(3));
}
