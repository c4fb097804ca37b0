//! Hits: against independent arithmetic, between modes, widths and trees, and at the edges of the format.

mod adversarial;
mod bench_rays;
mod equivalence;
mod huge_pages;
mod reference;
mod rows;
mod spawn;
mod support;
