//! A line of the table: a case, its worst error, the bound it must keep.

use super::ulp::Worst;
use std::fmt::Display;

/// What one case of the catalogue gave on this build and CPU.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    pub group: &'static str,
    pub case: String,
    /// Values, rays or paths tried.
    pub count: u64,
    pub worst: f64,
    pub bound: f64,
    /// Of `worst` and `bound`.
    pub unit: &'static str,
    /// The arguments of the worst error; empty where there is none.
    pub at: String,
    /// What the textbook form gives on the same inputs, measured in the same run; empty where there is none.
    pub naive: String,
    pub pass: bool,
}

impl Row {
    /// Passes where `worst` ≤ `bound` and something was tried.
    pub fn new(
        group: &'static str,
        case: impl Display,
        count: u64,
        worst: f64,
        bound: f64,
        unit: &'static str,
    ) -> Self {
        let pass = worst <= bound && count > 0;
        Self { group, case: case.to_string(), count, worst, bound, unit, at: String::new(), naive: String::new(), pass }
    }

    /// How often something happened that must never.
    pub fn never(group: &'static str, case: impl Display, count: u64, times: u64, unit: &'static str) -> Self {
        Self::new(group, case, count, times as f64, 0.0, unit)
    }

    pub fn at(mut self, at: impl Display) -> Self {
        self.at = at.to_string();
        self
    }

    pub fn naive(mut self, naive: impl Display) -> Self {
        self.naive = naive.to_string();
        self
    }

    /// From the worst of many, which knows its arguments.
    pub fn of<A: Display>(
        group: &'static str,
        case: impl Display,
        count: u64,
        worst: &Worst<A>,
        bound: f64,
        unit: &'static str,
    ) -> Self {
        let at = worst.at.as_ref().map_or(String::new(), |a| a.to_string());
        Self::new(group, case, count, worst.error, bound, unit).at(at)
    }
}
