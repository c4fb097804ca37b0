//! Reports: statistics of error curves against closed forms and simulation, plots, pages.

mod converge;
mod coverage;
mod fit;
mod page;
mod plot;
