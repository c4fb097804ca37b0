//! Reports: statistics of error curves against closed forms and simulation, plots, pages.

mod converge;
pub mod coverage;
mod fit;
mod page;
mod plot;
