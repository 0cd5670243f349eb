//! All estimators, which implement the same trait.
//!
//! | estimator | minimises, or solves | consistent when the noise is |
//! |---|---|---|
//! | [`LeastSquares`] | the equation error `A y - B u`, by QR | white in the equation (rarely so) |
//! | [`Armax`] | the one-step error of `A y = B u + C e` | a moving average through the plant's poles |
//! | [`WarmStarted`] | output error or Box-Jenkins, started from approximately known poles | as output error |
//! | [`OutputError`] | the simulated error `y - (B/A) u` | anything independent of the input |
//! | [`N4sid`] | states by canonical variates, then the simulated error with these poles | anything independent of the input |
//! | [`Wiener`] | output error with a static curve behind the dynamics | as output error |
//! | [`Fir`] | the error of a weighted sum of past inputs | anything independent of the input |
//! | [`Recursively`] | least squares, ARMAX, output error, a sample at a time | as those |
//! | [`Process`] | the simulated error of a gain, one or two time constants and a dead time | anything independent of the input |
//! | [`FrequencyDomain`] | a transfer function with dead time: its error in dB and phase | anything independent of input or reference |
//! | [`VehicleSearch`] | the simulated error of the vehicle's own equations | anything independent of the input |
//! | [`VehicleFilter`] | state and coefficients of the same, by a Kalman filter | white, with a drifting bias |
//! | [`TwoStages`] | any of these on the part of the input that a reference causes | anything independent of the reference |
//!
//! Source: Ljung, *System Identification*, 2nd ed., 1999, ch. 7, 10, 11. The thesis used the first (Brunner, NPS thesis, 1988, ch. V).

mod armax;
mod coloured;
mod curved;
mod delayed_transfer;
mod equation;
mod estimate;
mod estimator;
mod fir;
mod frequency_domain;
mod frequency_fit;
mod jumps;
pub mod kalman;
mod least_squares;
mod levenberg_marquardt;
mod method;
mod n4sid;
mod normal_equations;
mod output_error;
mod physical;
mod process;
mod process_model;
pub mod recursive;
mod recursively;
mod refined;
mod rows;
mod simulator;
mod stability;
mod starts;
mod step_response;
mod sums;
mod two_stages;
pub mod vehicle;
mod vehicle_fit;

pub use crate::frequency::{COHERENCE, Row};
pub use armax::Armax;
pub(crate) use coloured::independent_share;
pub(crate) use coloured::{whitened, whitening};
pub use curved::Wiener;
pub(crate) use curved::{cost_in_front, in_front, moved_by, of_least_criterion};
pub use delayed_transfer::Orders;
pub use estimate::{Error, Estimate};
pub use estimator::{Estimator, Recursive, learn};
pub use fir::Fir;
pub use frequency_domain::{FrequencyDomain, TransferConstraints};
pub use frequency_fit::{Candidate, FrequencyFit};
pub use least_squares::LeastSquares;
pub(crate) use levenberg_marquardt::{Linearised, unit_factor};
pub use levenberg_marquardt::{Trial, descend};
pub use method::{Knowledge, Method, Property};
pub use n4sid::N4sid;
pub(crate) use normal_equations::{
    NormalEquations, Part, correlation, damped, information, shifted_sum, through_poles,
};
pub use normal_equations::{Search, Total, least};
pub use output_error::OutputError;
pub use physical::{NAMES, Physical, UNKNOWNS};
pub use process::{Begins, Process};
pub use process_model::{Form, ProcessModel};
pub use recursively::Recursively;
pub use refined::WarmStarted;
pub(crate) use rows::{impulse, regression};
pub use simulator::coloured_covariance;
pub(crate) use simulator::{coloured, lost};
pub(crate) use stability::{held_within, lies_within, radius_of_memory};
pub use step_response::StepResponse;
pub(crate) use sums::dot;
pub use two_stages::TwoStages;
pub use vehicle_fit::{Guess, VehicleFilter, VehicleSearch};

#[cfg(test)]
mod tests {
    mod refined_iv;
}
