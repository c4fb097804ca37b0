//! Estimators on their own: the integral without the picture.
//!
//! | room | holds |
//! |---|---|
//! | [`bmc`] | Bayesian Monte Carlo: Gaussian-process weights for fixed points, used here and by the renderer |
//! | [`rules`] | Gauss–Legendre nodes and panels |
//! | [`cholesky`] | the f64 factorisation under the weights |

pub mod bmc;
pub mod cholesky;
pub mod rules;
