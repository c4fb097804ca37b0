//! When to stop, and how many samples a pass takes.
//!
//! Passes after calibration are equal, so stopping on the clock between completed passes is biased by
//! O(1/passes) at most (Glynn & Heidelberger 1990). Calibration is the ramp 1, 1, 2, 4 … up to the pass size; a resumed
//! render climbs it anew from where it stands.

use crate::film::BLOCK;

/// Limits of a render; the first to be reached stops it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Samples a pixel.
    pub samples: Option<u64>,
    /// Seconds since the process started, image written.
    pub seconds: Option<f64>,
    /// Estimated relative error E = √(mean over pixels and channels of var/(mean² + 0.01)).
    pub error: Option<f64>,
}

/// Which limit stopped a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StoppedBy {
    /// The sample count was reached.
    Samples,
    /// The user.
    Interrupt,
    /// The clock.
    Time,
    /// The estimated error was reached.
    Error,
}

impl StoppedBy {
    /// Of samples of which some were stopped by this and some by `other`: what can be claimed least of.
    pub fn with(self, other: StoppedBy) -> StoppedBy {
        self.max(other)
    }

    /// Of a render that `self` has stopped after one that `before` had: a fixed count forgets how often it was halted.
    pub fn after(self, before: StoppedBy) -> StoppedBy {
        if self == StoppedBy::Samples { self } else { self.with(before) }
    }

    /// What this says about the estimate's bias.
    pub fn claim(self) -> &'static str {
        match self {
            StoppedBy::Samples => "fixed sample count, which adds no bias",
            StoppedBy::Time => "stopped by the clock between equal passes, bias O(1/passes)",
            StoppedBy::Error => "sequentially stopped, bias O(1/n)",
            StoppedBy::Interrupt => "interrupted, bias O(1/passes)",
        }
    }
}

/// Samples at which the error target is tested first; then at its doublings.
pub const FIRST_ERROR_TEST: u64 = 64;
/// No budget lets a pixel have more: sample indices are 32 bits wide.
pub const MAX_SAMPLES: u64 = u32::MAX as u64 + 1;
/// A pass takes at most this share of the time budget …
const PASS_SHARE: f64 = 0.05;
/// … and where there is none, this many seconds.
const PASS_SECONDS: f64 = 1.0;
/// At least this share of the time budget is to be used, even where one sample takes longer than what is left over.
const USED_SHARE: f64 = 0.95;
/// With a time budget passes are kept shorter still where one sample a pixel is: what is left unused at the end is
/// less than a pass.
const PREFERRED_SHARE: f64 = 0.02;

/// Sizes the passes and says when the time is up.
#[derive(Debug)]
pub struct Pacer {
    budget: Budget,
    /// Samples in the pass under calibration or, once `settled`, in every pass.
    size: u64,
    settled: bool,
    /// Seconds of the slowest of the last passes, per sample.
    seconds_per_sample: f64,
}

impl Pacer {
    /// Nothing rendered yet.
    pub fn new(budget: Budget) -> Self {
        Pacer { budget, size: 1, settled: false, seconds_per_sample: 0.0 }
    }

    /// Nothing rendered yet, but known that a sample of every pixel takes so long: full passes from the first on.
    pub fn paced(budget: Budget, seconds_per_sample: f64) -> Self {
        let mut pacer = Pacer { budget, size: 1, settled: true, seconds_per_sample };
        while 2 * pacer.size <= BLOCK && 2.0 * pacer.size as f64 * seconds_per_sample <= pacer.preferred_seconds() {
            pacer.size *= 2;
        }
        pacer
    }

    /// Seconds that a pass should take at most.
    fn preferred_seconds(&self) -> f64 {
        self.budget.seconds.map_or(PASS_SECONDS, |limit| PREFERRED_SHARE.min(PASS_SHARE) * limit)
    }

    /// Samples of the next pass after `done`, or what stops the render. `now` is in seconds since the process
    /// started, `output` the seconds that writing the image will take.
    ///
    /// A pass starts only if it is predicted to end within the limit. The image is written within it, too, unless one
    /// sample a pixel takes more than 5 % of the time: then it may be late by that excess, so that 95 % are used. Where
    /// nothing is rendered yet a sample a pixel is, however late: nothing at all would be of no use to anybody.
    pub fn next(&self, done: u64, now: f64, output: f64) -> Result<u64, StoppedBy> {
        let left = self.budget.samples.unwrap_or(MAX_SAMPLES).min(MAX_SAMPLES).saturating_sub(done);
        if left == 0 {
            return Err(StoppedBy::Samples);
        }
        let size = self.size.min(left);
        match self.budget.seconds {
            Some(limit) if now + size as f64 * self.seconds_per_sample + self.reserve(limit, output) > limit => {
                // During calibration a smaller pass may still fit; afterwards all are equal.
                let one_fits = now + self.seconds_per_sample + self.reserve(limit, output) <= limit;
                let smaller = !self.settled && one_fits && size > 1;
                if smaller || done == 0 { Ok(1) } else { Err(StoppedBy::Time) }
            }
            _ => Ok(size),
        }
    }

    /// Learns from a pass of `samples` that took `seconds`, with `done` samples taken in all.
    pub fn learn(&mut self, samples: u64, seconds: f64, done: u64) {
        let measured = seconds / samples as f64;
        if self.settled {
            self.seconds_per_sample = measured.max(0.5 * (self.seconds_per_sample + measured));
            return;
        }
        self.seconds_per_sample = measured;
        // A pass starts at a multiple of its size: so none crosses a block, and every power of two is an end.
        let doubled = 2 * self.size;
        if !done.is_multiple_of(doubled) {
            return;
        }
        if doubled <= BLOCK && doubled as f64 * measured <= self.preferred_seconds() {
            self.size = doubled;
            self.settled = doubled == BLOCK;
        } else {
            self.settled = true;
        }
    }

    /// Seconds to keep for the image.
    fn reserve(&self, limit: f64, output: f64) -> f64 {
        let late = self.seconds_per_sample - (1.0 - USED_SHARE) * limit;
        output - late.clamp(0.0, output)
    }

    /// Is the error target to be tested after `done` samples?
    pub fn tests_error(&self, done: u64) -> bool {
        self.budget.error.is_some() && done >= FIRST_ERROR_TEST && done.is_power_of_two()
    }
}
