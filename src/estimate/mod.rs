//! Estimators on their own: the integral without the picture.
//!
//! | room | holds |
//! |---|---|
//! | [`problems`] | what is estimated, with the truth: numbers, distributions, integrals on intervals, cubes, the hemisphere |
//! | [`points`], [`method`] | where samples lie; a way to make one estimate of n of them |
//! | [`tensor`], [`biased`], [`bmc`] | quadrature; estimators that are wrong on average; Gaussian-process weights, used here and by the renderer |
//! | [`study`], [`table`], [`page`] | many estimates of each kind held against the truth, as text, CSV and HTML |
//! | [`demos`] | what is no single number: rules of variance, Gaussian processes, O'Hagan's objections |
//! | [`rules`], [`adaptive`], [`cholesky`], [`special`], [`expression`] | the numerics under them, all in f64 |

pub mod adaptive;
pub mod biased;
pub mod bmc;
pub mod cholesky;
pub mod demos;
pub mod expression;
pub mod method;
pub mod page;
pub mod points;
pub mod problems;
pub mod rules;
pub mod special;
pub mod study;
pub mod table;
pub mod tensor;
