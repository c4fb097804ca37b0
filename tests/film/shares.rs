//! Single samples' shares, held to the coverage that intervals from rare hits truly have.

use super::{filled, rendered};
use crate::stats::{Rng, oracles_in, z_bound};
use octolux::film::{FilmChannels, SampleShares};

/// Samples a pixel, as in the Poisson limit nearly: with probabilities up to .1 coverage would change.
const SAMPLES: usize = 1 << 14;
const SIDE: u32 = 32;

/// What became of the intervals of a film whose samples are 1/p with probability p, else 0.
struct Fates {
    covered: f64,
    /// Missed, though met by light and free of doubt.
    missed_unseen: f64,
    shares: SampleShares,
}

/// Hits are placed by their gaps: −ln u/p.
fn rare_hits(expected: f64, rng: &mut Rng) -> Fates {
    let p = expected / SAMPLES as f64;
    let pixels = (SIDE * SIDE) as usize;
    let mut hit = vec![false; pixels * 3 * SAMPLES];
    let mut at = 0.0;
    loop {
        // The number of misses before a hit.
        at += ((1.0 - rng.f64()).ln() / (-p).ln_1p()).floor();
        let Some(slot) = hit.get_mut(at as usize) else { break };
        *slot = true;
        at += 1.0;
    }
    let value = (1.0 / p) as f32;
    let film = filled((SIDE, SIDE), SAMPLES, |x, y, s| {
        let slot = ((y * SIDE + x) as usize * SAMPLES + s) * 3;
        std::array::from_fn(|c| if hit[slot + c] { value } else { 0.0 })
    });
    let shares = film.sample_shares(film.relative_error().expect("an error"));
    let (mut covered, mut unseen) = (0u32, 0u32);
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        let (mean, variance) = (film.mean(x, y), film.variance_of_mean(x, y).expect("samples"));
        let largest = film.largest(x, y);
        for c in 0..3 {
            let holds = (mean[c] - 1.0).abs() <= 1.959_963_985 * variance[c].sqrt();
            // As it is defined: one of fewer than ten equal hits has more than a tenth.
            let hits = (mean[c] * expected).round();
            assert_eq!(f64::from(largest[c]) > 0.1 * (mean[c] * SAMPLES as f64), hits > 0.0 && hits < 10.0);
            covered += u32::from(holds);
            unseen += u32::from(!holds && hits >= 10.0);
        }
    }
    let values = f64::from(3 * SIDE * SIDE);
    Fates { covered: f64::from(covered) / values, missed_unseen: f64::from(unseen) / values, shares }
}

/// Coverage is the oracle's (3,072 intervals: off by .04 would be seen), and what is not marked fails no more often than it
/// does at 30 hits. Without marks 99 % of the intervals fail at .01 hits, silently: they are 0 ± 0.
#[test]
fn intervals_from_rare_hits_fail_as_they_must_and_are_marked() {
    let mut rng = Rng::new(51);
    let values = f64::from(3 * SIDE * SIDE);
    for case in oracles_in("CI coverage (firefly)") {
        let expected: f64 = case.id.trim_start_matches("H.ci_coverage_lam").parse().expect("a number of hits");
        if expected > 100.0 {
            // Beyond the Poisson limit at this number of samples.
            continue;
        }
        let fates = rare_hits(expected, &mut rng);
        let deviation = (case.value * (1.0 - case.value) / values).sqrt();
        // The binomial's distance from Poisson's law, p at most (Barbour & Hall 1984).
        let bound = z_bound(6) * deviation + expected / SAMPLES as f64;
        assert!((fates.covered - case.value).abs() <= bound, "{}: {} not {}", case.id, fates.covered, case.value);
        assert!(fates.missed_unseen <= 1.0 - 0.930_737 + bound, "{}: {} unseen", case.id, fates.missed_unseen);
        let shares = fates.shares;
        let marked = (shares.doubtful + shares.dark) as f64 / values;
        println!("{expected}: {:.4} covered, {marked:.4} marked, {:.4} unseen", fates.covered, fates.missed_unseen);
        let zero = case.record["p_zero"].as_f64().expect("a probability");
        let dark_bound = z_bound(6) * (zero * (1.0 - zero) / values).sqrt() + expected / SAMPLES as f64;
        assert!((shares.dark as f64 / values - zero).abs() <= dark_bound, "{}: {} dark", case.id, shares.dark);
    }
}

/// The squared relative error against its true value, and whether it was trusted: `value` draws samples of mean `mean` and
/// variance `variance`.
fn errors(mean: f64, variance: f64, mut value: impl FnMut() -> f64) -> (f64, usize) {
    const IMAGES: usize = 60;
    let (mut ratios, mut trusted) = (Vec::new(), 0);
    for _ in 0..IMAGES {
        let draws: Vec<f32> = (0..32 * 32 * 64 * 3).map(|_| value() as f32).collect();
        let film = filled((32, 32), 64, |x, y, s| {
            let at = ((y * 32 + x) as usize * 64 + s) * 3;
            [draws[at], draws[at + 1], draws[at + 2]]
        });
        let error = film.relative_error().expect("an error");
        trusted += usize::from(film.sample_shares(error).error_trusted());
        ratios.push(error * error / (variance / 64.0 / (mean * mean + 0.01)));
    }
    ratios.sort_by(f64::total_cmp);
    (ratios[IMAGES / 2], trusted)
}

#[test]
fn an_error_that_is_too_small_is_flagged() {
    let mut rng = Rng::new(52);
    let (ratio, trusted) = errors(1.0, 1.0, || -(1.0 - rng.f64()).ln());
    println!("exponential: {ratio}, trusted {trusted}");
    assert!((ratio - 1.0).abs() < 0.1 && trusted == 60, "exponential: {ratio}, trusted {trusted}");
    let (mean, square) = (3.125f64.exp(), 6.25f64.exp());
    let normal = crate::report::coverage::normal;
    let (ratio, trusted) = errors(mean, mean * mean * (square - 1.0), || (2.5 * normal(&mut rng)).exp());
    println!("log-normal: {ratio}, trusted {trusted}");
    assert!(ratio < 0.5 && trusted == 0, "log-normal: {ratio}, trusted {trusted}");
}

/// By hand: 15 samples of 1 and one of 31 in one channel of one pixel; all other values 0.
#[test]
fn shares_of_a_small_image() {
    let film =
        filled(
            (3, 2),
            16,
            |x, y, s| if (x, y) == (2, 1) { [0.0, if s == 5 { 31.0 } else { 1.0 }, 0.0] } else { [0.0; 3] },
        );
    let shares = film.sample_shares(film.relative_error().expect("an error"));
    assert_eq!((shares.at, shares.values, shares.doubtful, shares.dark), ((2, 1), 18, 1, 17));
    // Mean 2.875: squares 15·1.875² and 28.125².
    let exact = 28.125f64.powi(2) / (28.125f64.powi(2) + 15.0 * 1.875f64.powi(2));
    assert!((shares.largest_of_error - exact).abs() < 1e-12, "{}", shares.largest_of_error);
    assert!(!shares.error_trusted());
    let said = shares.to_string();
    assert!(said.contains("pixel 2,1, 93.75 % of its square") && said.contains("5.56 % of values"), "{said}");
}

/// Like the sums: whatever the tiles, the passes, the order of the parts.
#[test]
fn the_largest_sample_does_not_depend_on_how_the_film_was_filled() {
    let whole = rendered((21, 13), 32, FilmChannels::Colour, 200, 200);
    let tiled = rendered((21, 13), 4, FilmChannels::Colour, 200, 7);
    let shares = |film: &octolux::film::Film| film.sample_shares(film.relative_error().expect("an error"));
    assert_eq!(shares(&whole), shares(&tiled));
    let largest = (0..200).map(|s| super::radiance(20, 12, s)[1]).fold(0.0, f32::max);
    assert_eq!(tiled.largest(20, 12)[1], largest);
    let mut bytes = Vec::new();
    tiled.encode(&mut bytes).expect("memory");
    let back = octolux::film::Film::decode(tiled.shape(), &mut &*bytes, bytes.len() as u64).expect("what was written");
    assert_eq!(shares(&back), shares(&tiled));
}
