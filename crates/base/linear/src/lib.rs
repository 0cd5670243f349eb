#![doc = include_str!("../README.md")]
//!
//! - [`polynomial`]: real polynomials: value, roots, product of roots.
//! - [`routh`]: stability from coefficients.
//! - [`state_space`]: `x' = A x + B u, y = C x + D u`, zero-order hold, poles, transfer functions.
//! - [`transfer_function`]: ratios of polynomials in `s` or `z`; difference equations.
//! - [`frequency`]: open loops, including those with dead time: crossovers, gain and phase margins, sensitivity.
//! - [`Sampled`]: a continuous system with a sampled input, exact at the ticks.
//! - [`pitch`]: equations of pitch and heave, shared by vehicles and identification.
//! - [`poles`]: mapping between the `z` plane and the `s` plane; eigenvalues.
//! - [`runge_kutta_step`]: fourth-order Runge-Kutta method for any equations.
//! - [`dormand_prince_step`]: eighth-order method with an error estimate; [`DormandPrinceDense`]: with an interpolating polynomial.
//! - [`first_below_zero`], [`below_zero_near`], [`lowest_point`]: location of events: where a margin falls below zero, and where it has a minimum.
//! - [`lowest`]: a global search.
//! - [`digits`]: numbers printed with their significant digits.
//! - [`step_metrics`]: rise time, overshoot, settling time and steady error of a sampled response.
//!
//! This crate does not depend on vehicle files, messages or clocks. Coefficient lists begin with the highest power, as in the reports. Failures
//! are an [`Error`], never a panic or a NaN.

mod complex;
pub mod digits;
mod dormand_prince;
pub mod error;
mod exponential;
pub mod frequency;
mod global;
mod margin;
pub mod pitch;
pub mod poles;
pub mod polynomial;
pub mod routh;
mod runge_kutta;
pub mod sampled;
pub mod state_space;
pub mod step_metrics;
mod time_history;
pub mod transfer_function;

pub use complex::{ComplexFunctions, polar};
pub use dormand_prince::{
    DORMAND_PRINCE_DENSE_NODES, DORMAND_PRINCE_NODES, DormandPrinceDense, dormand_prince_step,
};
pub use error::Error;
pub use exponential::exponential;
pub use frequency::{DelayedLoop, unwrapped_phases};
pub use global::lowest;
pub use margin::{below_zero_near, first_below_zero, lowest_point};
pub use nalgebra::{Complex, DMatrix};
pub use poles::{
    by_decay, discrete_to_continuous, is_sampling_artefact, mode_text, pair_text, pole_text,
};
pub use routh::RouthColumn;
pub use runge_kutta::runge_kutta_step;
pub use sampled::Sampled;
pub use state_space::StateSpace;
pub use step_metrics::{StepMeter, StepMetrics};
pub use time_history::{COLUMNS, TimeHistory};
pub use transfer_function::TransferFunction;

/// The rows of a matrix.
#[must_use]
pub fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

/// Whether a system is in `s` (differential equations) or in `z` (difference equations).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Continuous time: constant signals correspond to `s = 0`.
    Continuous,
    /// Discrete time: constant signals correspond to `z = 1`.
    Discrete,
}

impl Domain {
    /// Point of the complex plane at which a transfer function has its steady-state gain.
    #[must_use]
    pub fn steady_point(self) -> f64 {
        match self {
            Self::Continuous => 0.0,
            Self::Discrete => 1.0,
        }
    }
}
