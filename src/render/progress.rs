//! Progress for a person: a bar at a terminal, plain lines elsewhere, nothing when asked to be quiet.

use super::budget::Budget;
use crate::kernel::Counters;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// The bar shows thousandths.
const STEPS: u64 = 1000;
/// Plain lines come this far apart at least; the error, which costs a pass over the film, is computed as seldom.
const LINE_EVERY: Duration = Duration::from_secs(1);

/// Where a render tells how far it is.
pub struct Progress {
    bar: Option<ProgressBar>,
    plain: bool,
    budget: Budget,
    last: Option<Instant>,
    error: Option<f64>,
}

impl Progress {
    /// Tells nothing.
    pub fn quiet() -> Self {
        Progress { bar: None, plain: false, budget: Budget::default(), last: None, error: None }
    }

    /// On standard error.
    pub fn new(budget: Budget) -> Self {
        if !std::io::stderr().is_terminal() {
            return Progress { plain: true, budget, ..Progress::quiet() };
        }
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
        // The template is a constant; if it were wrong the default style would serve.
        if let Ok(style) = ProgressStyle::with_template("{bar:32} {msg}") {
            bar.set_style(style);
        }
        Progress { bar: Some(bar), budget, ..Progress::quiet() }
    }

    /// After a pass: `done` samples a pixel, `seconds` of rendering. `relative_error` is only called when shown.
    pub fn update(&mut self, done: u64, counters: &Counters, seconds: f64, relative_error: impl Fn() -> Option<f64>) {
        if self.bar.is_none() && !self.plain {
            return;
        }
        let due = self.last.is_none_or(|last| last.elapsed() >= LINE_EVERY);
        if due {
            self.error = relative_error();
            self.last = Some(Instant::now());
        }
        let fraction = self.fraction(done);
        let message = self.message(done, counters, seconds, fraction);
        if let Some(bar) = &self.bar {
            bar.set_position((fraction * STEPS as f64) as u64);
            bar.set_message(message);
        } else if due {
            crate::process::tell(format_args!("{message}\n"));
        }
    }

    /// The share of the nearest limit that is used up. Never rounded up: 100 % means done.
    fn fraction(&self, done: u64) -> f64 {
        let samples = self.budget.samples.map_or(0.0, |n| done as f64 / n.max(1) as f64);
        let time = self.budget.seconds.map_or(0.0, |_| {
            crate::process::seconds_since_process_start() / self.budget.seconds.unwrap_or(f64::INFINITY)
        });
        let error = self.budget.error.zip(self.error).map_or(0.0, |(target, e)| (target / e).powi(2));
        samples.max(time).max(error).clamp(0.0, 1.0)
    }

    fn message(&self, done: u64, counters: &Counters, seconds: f64, fraction: f64) -> String {
        let rate = counters.camera_rays as f64 / seconds.max(1e-9) / 1e6;
        let eta = seconds * (1.0 - fraction) / fraction.max(1e-9);
        let error = self.error.map_or("-".to_string(), |e| format!("{e:.4}"));
        let percent = (fraction * 100.0).floor();
        format!("{percent:3.0} %  {done} spp  {rate:.2} Msamples/s  relative error {error}  ETA {eta:.1} s")
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
