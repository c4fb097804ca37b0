//! Estimators on their own.

mod bmc;
mod bmc_posterior;
mod demos;
mod gather;
mod hemisphere;
mod illumination;
mod shrinkage;
mod study;
mod truths;

use octolux::estimate::problems::Problem;
use octolux::estimate::study::{Budget, Study, run};

/// A study of the named methods.
pub fn study(problem: &dyn Problem, methods: &[&str], samples: &[usize], repeats: usize, seed: u64) -> Study {
    let methods: Vec<_> = methods.iter().map(|name| problem.method(name).unwrap()).collect();
    let budget = Budget { samples: samples.to_vec(), repeats, seed };
    run(problem.quantity(), &methods, &budget, &|| false)
}

/// The cell of a method at a number of samples.
pub fn cell<'a>(study: &'a Study, method: &str, samples: usize) -> &'a octolux::estimate::study::Cell {
    let row = study.rows.iter().find(|r| r.method == method).unwrap();
    row.cells.iter().find(|c| c.samples == samples).unwrap_or_else(|| panic!("{method}: no cell of {samples}"))
}
