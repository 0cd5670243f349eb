#![doc = include_str!("../README.md")]
//!
//! - [`polynomial`]: real polynomials: value, roots, product of roots.
//! - [`routh`]: stability from coefficients alone.
//! - [`state_space`]: `x' = A x + B u, y = C x + D u`, zero-order hold, poles, transfer functions.
//! - [`transfer_function`]: ratios of polynomials in `s` or `z`; difference equations.
//! - [`frequency`]: open loops, with dead time too: crossovers, gain and phase margins, sensitivity.
//! - [`Sampled`]: a continuous system behind a sampled command, exact at the ticks.
//! - [`pitch`]: the equations of pitch and heave that a vehicle and its identification share.
//! - [`poles`]: from the `z` plane to the `s` plane and back; eigenvalues.
//! - [`runge_kutta_step`]: the fourth-order Runge-Kutta integrator, for any equations.
//! - [`dormand_prince_step`]: the eighth-order one, with an estimate of its error; [`DormandPrinceDense`]: the polynomial through its step.
//! - [`first_below_zero`], [`below_zero_near`], [`lowest_point`]: where a margin falls below zero, and where it turns.
//! - [`lowest`]: a global search.
//! - [`digits`]: numbers written to the digits that they have.
//! - [`step_metrics`]: rise time, overshoot, settling time and steady error of a sampled response.
//!
//! Nothing here knows of vehicle files, messages or clocks. Coefficient lists have the highest power
//! first, as the reports print them. What cannot be answered is an [`Error`], never a panic and
//! never a NaN.

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

/// A matrix row by row.
#[must_use]
pub fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

/// Whether a system's variable is `s` (differential equations) or `z` (difference equations).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Continuous time: a constant input is seen at `s = 0`.
    Continuous,
    /// Discrete time: a constant input is seen at `z = 1`.
    Discrete,
}

impl Domain {
    /// The point of the complex plane at which a transfer function gives its steady-state gain.
    #[must_use]
    pub fn steady_point(self) -> f64 {
        match self {
            Self::Continuous => 0.0,
            Self::Discrete => 1.0,
        }
    }
}
