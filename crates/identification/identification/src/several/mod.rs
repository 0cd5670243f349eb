//! Several inputs to one output: a transfer function of each input, with an order, a delay and intervals of its own.
//!
//! ```text
//! y = sum  q^-di (Bi/Ai) u_i  +  offset of each record  +  e/D
//! ```
//! The least simulated error of all channels together, by Gauss-Newton steps ([`Analysis`] says what was found of it). An
//! input that does nothing is left out, by an F test. Inputs that move together cannot be told apart: that is said.
//!
//! - `layout`: channels, and the place of every unknown; `scaled`: records about their levels.
//! - `equations`: the error, its normal equations, its slopes.
//! - `regressions`: likely delays and the noise, by difference equations.
//! - `selection`: orders, delays, and which inputs do anything.
//! - `estimate`: the model in the signals' units, with its covariance; `delays`: intervals of the delays.
//! - `excitation`: what of each input is its own.
//! - `given`: a model of any origin on a record.
//! - `verdict`: what the model is good for, and why; `finding`: each reason, of which input; `text`: the results for the terminal.
//!
//! Source: Ljung, *System Identification*, 2nd ed., 1999, sec. 4.2 and 7.3.

mod analysis;
mod delays;
mod equations;
mod estimate;
mod excitation;
mod finding;
mod given;
mod layout;
mod options;
mod regressions;
mod scaled;
mod selection;
mod text;
mod verdict;

pub use analysis::{
    Analysis, ChannelModel, InputFindings, analyse, analyse_validated, searched_part,
};
pub use excitation::IndependentShare;
pub use finding::Finding;
pub use given::{Judged, KnownStructure};
pub use layout::Channel;
pub use options::Options;
pub use selection::{Candidate, Effect};

#[cfg(test)]
mod tests;
