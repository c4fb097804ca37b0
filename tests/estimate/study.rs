//! Studies: variances as predicted, slopes as known, biases found where they are and nowhere else, one set of bits.

use super::{cell, study};
use crate::stats::{Rng, oracle, z_bound};
use octolux::estimate::method::{Claim, Method, Prepared, Single};
use octolux::estimate::problems::{Problem, cube, discrete, hemisphere, interval, pi};
use octolux::estimate::study::{Budget, Quantity, Study, run};
use octolux::kernel::Width;
use std::f64::consts::PI;

const W: Width = Width::Eight;

/// All problems with all their default methods.
fn everything(width: Width, samples: &[usize], repeats: usize) -> Vec<Study> {
    let die: Vec<[f64; 2]> = (1..=6).map(|i| [f64::from(i), 1.0 / 6.0]).collect();
    let problems: Vec<Box<dyn Problem>> = vec![
        Box::new(pi(width)),
        Box::new(discrete("die", &die, width).unwrap()),
        Box::new(interval("exp", [0.0, 1.0], Some("2*(1+x)/3"), width).unwrap()),
        Box::new(interval("step", [0.0, 1.0], None, width).unwrap()),
        Box::new(cube("sine", 3, width).unwrap()),
        Box::new(cube("diagonal", 6, width).unwrap()),
        Box::new(cube("corner", 20, width).unwrap()),
        Box::new(hemisphere("cos3", 1.0, 0, width).unwrap()),
        Box::new(hemisphere("sky", 1.0, 3, width).unwrap()),
        Box::new(hemisphere("edge", 1.0, 3, width).unwrap()),
    ];
    let run = |p: &dyn Problem| {
        let (names, defaults) = p.method_names();
        let names: Vec<&str> = names[..defaults].iter().map(String::as_str).collect();
        study(p, &names, samples, repeats, 11)
    };
    problems.iter().map(|p| run(&**p)).collect()
}

/// 2,000 estimates of each kind: a bias of 4.5 of their standard deviations over √2000 = 45 is seen.
#[test]
fn unbiased_methods_show_no_bias_and_have_the_predicted_variance() {
    let studies = everything(W, &[1, 16, 64], 2000);
    let cells = || {
        studies
            .iter()
            .flat_map(|s| s.rows.iter().map(move |r| (s, r)))
            .flat_map(|(s, r)| r.cells.iter().map(move |c| (s, r, c)))
    };
    let bound = z_bound(cells().filter(|(_, r, c)| r.claim == Claim::Unbiased && c.z.is_some()).count());
    let ratios = cells().filter(|(.., c)| c.variance_ratio.is_some()).count();
    assert!(ratios > 30);
    for (s, r, c) in cells().filter(|(_, r, _)| r.claim == Claim::Unbiased) {
        let what = format!("{}, {}, n = {}", s.quantity.name, r.method, c.samples);
        assert!(c.z.is_none_or(|z| z.abs() < bound), "{what}: z = {:?}", c.z);
        if let Some(ratio) = c.variance_ratio {
            let off = (ratio.value - 1.0) / ratio.standard_error;
            assert!(off.abs() < z_bound(ratios) + 0.5, "{what}: {} ± {}", ratio.value, ratio.standard_error);
        }
        // What independent samples say of their own mean is right on average: 64 samples of anything here.
        if let (Some(own), 64) = (c.own_standard_error, c.samples)
            && c.variance > 0.0
        {
            assert!((own * own / c.variance - 1.0).abs() < 0.25, "{what}: {own}² for {}", c.variance);
        }
    }
}

/// Slopes with their power: each is fitted with a standard error that would see an exponent off by 0.1 with six of them.
#[test]
fn slopes_are_as_known() {
    let samples = [16, 64, 256, 1024];
    let exp = interval("exp", [0.0, 1.0], None, W).unwrap();
    let step = interval("step", [0.0, 1.0], None, W).unwrap();
    let linear = cube("linear", 2, W).unwrap();
    let cases = [
        (study(&exp, &["mc"], &samples, 1000, 5), -0.5),
        (study(&exp, &["stratified"], &samples, 1000, 5), -1.5),
        (study(&exp, &["owen"], &samples, 1000, 5), -1.5),
        (study(&step, &["stratified"], &samples, 1000, 5), -1.0),
        (study(&linear, &["stratified"], &samples, 1000, 5), -1.0),
        (study(&pi(W), &["stratified"], &samples, 1000, 5), -0.75),
    ];
    for (s, expected) in cases {
        let slope = s.rows[0].slope.unwrap().exponent;
        let what = format!("{} {}", s.quantity.name, s.rows[0].method);
        assert!(slope.standard_error < 0.1 / 6.0, "{what}: no power, {}", slope.standard_error);
        let off = (slope.value - expected).abs();
        // The step's error at n strata depends on where the jump falls in one.
        let bend = if s.quantity.formula.contains("signum") { 0.05 } else { 0.02 };
        assert!(off < z_bound(6) * slope.standard_error + bend, "{what}: {} for {expected}", slope.value);
    }
    // Rules have no chance in them: −2 for the trapezoid, −2/d in d dimensions.
    for (problem, nodes, expected) in [
        (&exp as &dyn Problem, [65usize, 129, 257, 513], -2.0),
        (&cube("sine", 3, W).unwrap(), [9usize.pow(3), 17usize.pow(3), 33usize.pow(3), 65usize.pow(3)], -2.0 / 3.0),
    ] {
        let s = study(problem, &["trapezoid"], &nodes, 1, 0);
        let slope = s.rows[0].slope.unwrap().exponent.value;
        // h² against n^(−2/d): n counts nodes, one an axis more than intervals.
        assert!((slope / expected - 1.0).abs() < 0.1, "{slope} for {expected}");
    }
}

#[test]
fn jittered_variance_is_the_closed_form() {
    let s = study(&interval("linear", [0.0, 1.0], None, W).unwrap(), &["stratified"], &[4, 64, 1024], 4000, 2);
    for n in [4usize, 64, 1024] {
        let c = cell(&s, "stratified", n);
        let expected = 1.0 / (12.0 * (n as f64).powi(3));
        assert!((c.predicted_variance.unwrap() / expected - 1.0).abs() < 1e-9, "{n}");
        // √(2/4000) = 2.2 % of spread.
        assert!((c.variance / expected - 1.0).abs() < 0.022 * z_bound(3), "{n}: {} for {expected}", c.variance);
    }
}

#[test]
fn biased_methods_are_caught() {
    // A firefly of probability p: the pilot of 16 sees none with probability (1 − p)^16, and then all is lost; else the
    // mean is kept. E = 1 − (1 − p)^16 · 48/64 (numerics.md has the same with 1008/1024: 0.16).
    let p = 0.01;
    let firefly = discrete("firefly", &[[0.0, 1.0 - p], [1.0 / p, p]], W).unwrap();
    let s = study(&firefly, &["mc", "pilot-reuse", "clamped"], &[64], 20_000, 1);
    assert!(!cell(&s, "mc", 64).biased);
    let pilot = cell(&s, "pilot-reuse", 64);
    let expected = -(1.0f64 - p).powi(16) * 0.75;
    assert!(
        pilot.biased && (pilot.bias.value - expected).abs() < z_bound(1) * pilot.bias.standard_error,
        "{:?}",
        pilot.bias
    );
    assert!(cell(&s, "clamped", 64).biased);
    // The ratio of sums is biased by O(1/n): seen at 2 samples, gone at 512.
    let s = study(&interval("exp", [0.0, 1.0], None, W).unwrap(), &["ratio"], &[2, 512], 20_000, 1);
    assert!(cell(&s, "ratio", 2).biased && !cell(&s, "ratio", 512).biased, "{:?}", s.rows[0].cells);
    // Clamping the sky costs what lies above the clamp.
    let sky = hemisphere("sun", 1.0, 0, W).unwrap();
    let s = study(&sky, &["clamped", "mc:mis"], &[64], 1000, 1);
    assert!(cell(&s, "clamped", 64).biased && !cell(&s, "mc:mis", 64).biased);
}

/// Everything but seconds, bit for bit, at any width and number of threads.
#[test]
fn studies_do_not_depend_on_width_or_threads() {
    let numbers = |width, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let studies = pool.install(|| everything(width, &[1, 5, 16, 37], 20));
        let cells = studies.iter().flat_map(|s| &s.rows).flat_map(|r| &r.cells);
        cells
            .flat_map(|c| [c.first, c.mean.value, c.variance, c.rmse.value, c.mae.value])
            .map(f64::to_bits)
            .collect::<Vec<_>>()
    };
    let one = numbers(Width::One, 1);
    assert!(one.len() > 500);
    assert!(one == numbers(Width::Eight, 2), "width 8");
    assert!(one == numbers(Width::Sixteen, 3), "width 16");
}

/// In high dimensions a grid is hopeless: the table that shows quadrature overtaken.
#[test]
fn monte_carlo_overtakes_quadrature_as_dimensions_grow() {
    let rmse = |d, method| {
        let problem = cube("sine", d, W).unwrap();
        let s = study(&problem, &[method], &[4096], 200, 1);
        s.rows[0].cells[0].rmse.value
    };
    assert!(rmse(2, "trapezoid") < rmse(2, "mc") && rmse(12, "trapezoid") > rmse(12, "mc"));
    assert!(rmse(6, "owen") < rmse(6, "mc"));
}

/// One value in a thousand carries everything: the coverage of its own intervals is the oracle's, and it is told.
#[test]
fn intervals_from_rare_hits_cover_as_they_must_and_are_flagged() {
    let quantity =
        Quantity { name: "rare".into(), formula: String::new(), exact: 1.0, exact_error: 0.0, source: String::new() };
    const P: f64 = 1e-3;
    let method = Method::new("hits", Claim::Unbiased, |n| {
        Some(Prepared::new(n, move |key, _| {
            let mut rng = Rng::new(key);
            let hits = (0..n).filter(|_| rng.f64() < P).count() as f64;
            let n = n as f64;
            let value = hits / n / P;
            let variance = (hits / P / P - n * value * value) / (n - 1.0);
            Single { value, standard_error: Some((variance / n).sqrt()) }
        }))
    });
    let cases = [("3", 3_000, true), ("10", 10_000, false), ("30", 30_000, false), ("0.1", 100, true)];
    let budget = Budget { samples: cases.map(|c| c.1).to_vec(), repeats: 4000, seed: 3 };
    let study = run(quantity, &[method], &budget, &|| false);
    for ((id, n, flagged), cell) in cases.into_iter().zip(&study.rows[0].cells) {
        let Some(case) = oracle(&format!("H.ci_coverage_lam{id}")) else { return };
        let held = cell.own_coverage.expect("standard errors");
        // Le Cam: within P of Poisson's law in probability; 4,000 estimates.
        let bound = z_bound(4) * (case.value * (1.0 - case.value) / 4000.0).sqrt() + P;
        assert!((held - case.value).abs() <= bound, "{n}: {held} not {}", case.value);
        assert_eq!(cell.own_interval_trusted, !flagged, "{n}: {held}");
        assert_eq!(cell.doubts().iter().any(|d| d.contains("95 % intervals")), flagged, "{:?}", cell.doubts());
    }
}

/// Drawn by the cosine itself, the cosine's integral has no variance: what its estimates are off by is their rounding, no miss.
#[test]
fn rounding_is_no_miss_where_nothing_varies() {
    let problem = hemisphere("cosine", 1.0, 0, W).unwrap();
    for cell in &study(&problem, &["mc-is"], &[16, 256], 200, 3).rows[0].cells {
        assert!(cell.rmse.value < 2e-7 * PI, "{cell:?}");
        assert_eq!((cell.own_coverage, cell.own_interval_trusted), (Some(1.0), true), "{cell:?}");
        assert!(cell.doubts().is_empty(), "{:?}", cell.doubts());
    }
}

/// Two or three estimates have Student's tails, not the normal law's: of 1,000 studies no more are told of a bias than the 1 % that
/// chance allows.
#[test]
fn few_repeats_accuse_no_more_than_chance_allows() {
    let problem = interval("exp", [0.0, 1.0], None, W).unwrap();
    for repeats in [2, 3, 5] {
        let accuses = |seed: &u64| {
            let rows = study(&problem, &["mc", "stratified"], &[16, 64], repeats, *seed).rows;
            rows.iter().flat_map(|row| &row.cells).any(|cell| cell.biased)
        };
        let accusations = (0..1000).filter(accuses).count();
        assert!(accusations as f64 <= 10.0 + z_bound(3) * 10f64.sqrt(), "{repeats} repeats: {accusations}");
    }
}

/// A mean that is off by what its samples are rounded to, ½π in single precision and such, is not called biased, however well it is
/// known.
#[test]
fn rounding_is_no_bias() {
    let sine = cube("sine", 1, W).unwrap();
    let cosine = hemisphere("cosine", 1.0, 0, W).unwrap();
    let cases: [(&dyn Problem, &str); 2] = [(&sine, "stratified"), (&cosine, "owen:uniform")];
    for (problem, method) in cases {
        let study = study(problem, &[method], &[1 << 16], 200, 0);
        let cell = &study.rows[0].cells[0];
        let off = cell.bias.value.abs() / study.quantity.exact;
        assert!(off > 4.0 * cell.bias.standard_error / study.quantity.exact && off < 6e-8, "{cell:?}");
        assert!(!cell.biased, "{method}: {cell:?}");
    }
}

/// Of a constant a lobe of cos²θ leaves what no number of samples is sure to meet: whatever the points, it is told.
#[test]
fn infinite_variance_is_a_doubt() {
    let constant = hemisphere("constant", 1.0, 0, W).unwrap();
    for (method, doubtful) in [("mc:phong2", true), ("owen:phong2", true), ("owen:uniform", false)] {
        let study = study(&constant, &[method], &[64], 100, 1);
        let doubts = study.rows[0].cells[0].doubts();
        assert_eq!(doubts.iter().any(|doubt| doubt.contains("infinite")), doubtful, "{method}: {doubts:?}");
    }
}
