//! Estimators on their own.

mod bmc;
mod bmc_posterior;
