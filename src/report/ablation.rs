//! What a plan's decisions are worth: each left-out stage put back in, measured beside the planned kernel window by window.

use super::bench::Run;
use crate::kernel::{Width, World};
use crate::render;
use std::fmt;
use std::sync::Arc;

/// How to measure.
#[derive(Clone, Debug)]
pub struct AblationBench {
    /// Of the scene.
    pub name: String,
    /// Lanes of all kernels.
    pub lanes: Width,
    /// Worker threads, pinned.
    pub threads: usize,
    /// Windows of each kernel, at least 1.
    pub windows: u16,
    /// Seconds a window of the planned kernel lasts at least.
    pub seconds: f64,
}

/// What was measured.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AblationReport {
    /// Of the scene.
    pub scene: String,
    /// Lanes of all kernels.
    pub lanes: usize,
    /// Worker threads.
    pub threads: usize,
    /// Windows of each kernel.
    pub windows: usize,
    /// Of the planned kernel, the median, in millions.
    pub mpaths_per_s: f64,
    /// One a decision that was reversed.
    pub rows: Vec<AblationRow>,
}

/// One decision reversed: processor seconds a path over those of the planned kernel in the window before.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AblationRow {
    /// What was put back in.
    pub what: String,
    /// Median of the ratios, above 1 where leaving it out pays.
    pub ratio: f64,
    /// The least ratio.
    pub min: f64,
    /// The largest ratio.
    pub max: f64,
    /// Is the image the planned kernel's, bit for bit?
    pub same_bits: bool,
}

/// Measures `others` against `planned`, interleaved.
///
/// # Errors
/// The operating system gives no threads.
pub fn bench_ablations(
    planned: &World,
    others: &[(String, World)],
    bench: &AblationBench,
) -> Result<AblationReport, rayon::ThreadPoolBuildError> {
    let pool = Arc::new(render::pinned_thread_pool(bench.threads)?);
    let run = |world| Run::new(world, bench.lanes, bench.threads, pool.clone());
    let mut reference = run(planned);
    reference.calibrate(bench.seconds);
    let expected = reference.window();
    let mut rows = Vec::new();
    let mut runs: Vec<_> = others.iter().map(|(_, world)| (run(world), Vec::new())).collect();
    for ((what, _), (run, _)) in others.iter().zip(&mut runs) {
        run.set_samples(reference.samples());
        // This also warms up.
        let same_bits = run.window() == expected;
        rows.push(AblationRow { what: what.clone(), ratio: 1.0, min: 1.0, max: 1.0, same_bits });
    }
    for _ in 0..bench.windows {
        for (run, ratios) in &mut runs {
            let rate = |run: &mut Run| {
                run.window();
                run.cpu_rate
            };
            ratios.push(rate(&mut reference) / rate(run));
        }
    }
    for (row, (_, mut ratios)) in rows.iter_mut().zip(runs) {
        ratios.sort_by(f64::total_cmp);
        if let [first, .., last] | [first @ last] = ratios[..] {
            (row.ratio, row.min, row.max) = (ratios[ratios.len() / 2], first, last);
        }
    }
    let mut rates = reference.rates;
    rates.sort_by(f64::total_cmp);
    Ok(AblationReport {
        scene: bench.name.clone(),
        lanes: bench.lanes.lanes(),
        threads: bench.threads,
        windows: usize::from(bench.windows),
        mpaths_per_s: rates[rates.len() / 2],
        rows,
    })
}

impl fmt::Display for AblationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let AblationReport { scene, lanes, threads, windows, mpaths_per_s, rows } = self;
        writeln!(
            f,
            "{scene}: planned {mpaths_per_s:.3} Mpaths/s, {lanes} lanes, {threads} threads, {windows} windows"
        )?;
        writeln!(f, "{:28} CPU time with / without (min–max)  bits", "put back in")?;
        for AblationRow { what, ratio, min, max, same_bits } in rows {
            let bits = if *same_bits { "same" } else { "DIFFER" };
            writeln!(f, "{what:28} {ratio:.3} ({min:.3}–{max:.3})                 {bits}")?;
        }
        Ok(())
    }
}
