//! Bayesian Monte Carlo on skies, against what it has to beat.

use super::study;
use crate::stats::ln_ratio;
use octolux::estimate::problems::hemisphere;
use octolux::kernel::Width;

const METHODS: [&str; 5] = ["mc-is", "owen", "fibonacci", "bmc-is", "bmc-is-equal"];

/// Squared error relative to the exact value, for each of the skies `first …`: 64 directions, 48 repeats.
fn relative_squares(kind: &str, skies: std::ops::Range<u64>) -> Vec<[f64; 5]> {
    let of_sky = |sky| {
        let problem = hemisphere(kind, 1.0, sky, Width::Sixteen).unwrap();
        let s = study(&problem, &METHODS, &[64], 48, sky);
        std::array::from_fn(|i| (s.rows[i].cells[0].rmse.value / s.quantity.exact).powi(2))
    };
    skies.map(of_sky).collect()
}

fn relative_rmse(kind: &str) -> [f64; 5] {
    let squares = relative_squares(kind, 0..30);
    std::array::from_fn(|i| (squares.iter().map(|s| s[i]).sum::<f64>() / 30.0).sqrt())
}

/// The targets: RMSE at most 1/24 of MC-IS and 1/2.3 of Owen–Sobol on smooth skies, asserted at one-sided 99 %. The skies are
/// none of those that the default smoothness was chosen on. Of methods that just met the targets 99 in 100 such tests
/// would fail; of one a fifth better (29), with the standard error of 5.6 % that they have, one in seven.
#[test]
fn smooth_skies_are_integrated_far_better() {
    let squares = relative_squares("sky", 1000..1120);
    for (name, method, target) in [("mc-is", 0, 24f64), ("owen", 1, 2.3)] {
        let [ln, error] = ln_ratio(squares.iter().map(|s| [s[method], s[3]]));
        println!("sky: {name} over bmc-is: {:.2} ± {:.1} %, wanted {target}", ln.exp(), 100.0 * error);
        assert!(ln - 2.33 * error > target.ln(), "{name}: {:.2} ± {:.1} %", ln.exp(), 100.0 * error);
        assert!(error < 0.1, "{error}");
    }
    let worst = squares.iter().map(|s| (s[3] / s[4]).sqrt()).fold(0.0, f64::max);
    println!("sky: bmc-is over equal weights, the worst sky: {worst:.3}");
    assert!(worst < 1.0, "{worst}");
}

/// RMSE over that of equal weights on the same points, as a logarithm with its standard error over 120 skies: by the
/// posterior's weights as they are, and drawn towards equal ones.
fn against_equal_weights(kind: &str, n: usize) -> [[f64; 2]; 2] {
    const METHODS: [&str; 3] = ["bmc-is-equal", "bmc-is-unshrunk", "bmc-is"];
    let of_sky = |sky| {
        let problem = hemisphere(kind, 1.0, sky, Width::Sixteen).unwrap();
        let s = study(&problem, &METHODS, &[n], 480, sky);
        [0, 1, 2].map(|i| (s.rows[i].cells[0].rmse.value / s.quantity.exact).powi(2))
    };
    let squares: Vec<[f64; 3]> = (2000..2120).map(of_sky).collect();
    [1, 2].map(|i| ln_ratio(squares.iter().map(|s| [s[i], s[0]])))
}

/// Never worse than equal weights on the same points: under smooth skies, behind an edge, and with a bright small sun, where
/// the posterior's own weights are. One-sided at 99 %; the test sees an excess of 2.33 + 2.33 standard errors in 99 of 100
/// cases, and must see that of the weights as they are.
#[test]
fn never_worse_than_equal_weights() {
    for (kind, own_are_worse) in [("sky", false), ("edge", false), ("sun", true)] {
        for n in [16, 64] {
            let [own, shrunk] = against_equal_weights(kind, n);
            let text = |[ln, error]: [f64; 2]| format!("{:.4} ± {:.2} %", ln.exp(), 100.0 * error);
            println!("{kind}, n = {n}: unshrunk {}, shrunk {}", text(own), text(shrunk));
            assert!(shrunk[0] < 2.33 * shrunk[1], "{kind}, {n}: {}", text(shrunk));
            assert!(shrunk[0] <= own[0] + 2.33 * shrunk[1], "{kind}, {n}: {} {}", text(own), text(shrunk));
            assert!(!own_are_worse || own[0] > 2.33 * own[1], "{kind}, {n}: {}", text(own));
        }
    }
}

#[test]
fn edges_lose_nothing_to_weights() {
    let [mc, owen, fibonacci, bmc, equal] = relative_rmse("edge");
    println!(
        "edge: mc-is {mc:.5}, owen {owen:.5}, fibonacci {fibonacci:.5}, bmc-is {bmc:.5}, equal weights {equal:.5}"
    );
    assert!(mc / bmc > 4.0, "{}", mc / bmc);
    assert!(bmc < fibonacci && bmc < owen && bmc < equal);
}

/// The course's P1: the whole integrand modelled (bmc), L alone (bmc-is); a furnace is exact for both.
#[test]
fn furnaces_are_exact() {
    let furnace = hemisphere("constant", 1.0, 0, Width::Eight).unwrap();
    let lambert = hemisphere("cosine", 1.0, 0, Width::Eight).unwrap();
    for (problem, method) in [(&furnace, "bmc"), (&lambert, "bmc-is")] {
        let s = study(problem, &[method], &[1, 16, 64], 20, 0);
        for c in &s.rows[0].cells {
            // Weights and directions are f32.
            assert!(c.rmse.value < 1e-6, "{method} {}: {:e}", c.samples, c.rmse.value);
        }
    }
    // A zero mean shrinks what it does not know.
    let s = study(&furnace, &["bmc-zero"], &[4], 20, 0);
    assert!(s.rows[0].cells[0].bias.value < -0.01, "{:?}", s.rows[0].cells[0].bias);
}

#[test]
fn a_long_length_scale_is_reported() {
    let problem = hemisphere("edge", 1.0, 0, Width::Eight).unwrap();
    let s = study(&problem, &["bmc-is-random-se2", "bmc-is-random-se0.3", "bmc-is"], &[64], 10, 0);
    assert!(s.rows[0].cells[0].note.as_ref().is_some_and(|n| n.contains("ill-conditioned")));
    assert!(s.rows[1].cells[0].note.as_ref().is_some_and(|n| n.contains("equal weights")));
    let note = |row: usize| s.rows[row].cells[0].note.as_deref().unwrap_or_default();
    assert!(!note(2).contains("ill-conditioned") && note(2).contains("pilot of 16384"), "{}", note(2));
}
