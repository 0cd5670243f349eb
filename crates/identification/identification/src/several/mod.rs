//! Several inputs to one output: a transfer function of each input, with its own order, delay and intervals.
//!
//! ```text
//! y = sum  q^-di (Bi/Ai) u_i  +  offset of each record  +  e/D
//! ```
//! Gauss-Newton steps minimise the simulated error of all channels together ([`Analysis`] has the results). An F test finds inputs without
//! an effect, which are left out. The effects of inputs that move together cannot be separated; the verdict says so.
//!
//! - `layout`: channels, and the place of every unknown; `scaled`: records relative to their levels.
//! - `equations`: the error, its normal equations, its slopes.
//! - `regressions`: likely delays and the noise, by difference equations.
//! - `selection`: orders, delays, and which inputs have an effect.
//! - `estimate`: the model in the signals' units, with its covariance; `delays`: intervals of the delays.
//! - `excitation`: the independent share of each input.
//! - `given`: a model from any source on a record.
//! - `verdict`: the verdict and its reasons; `finding`: each reason with its input; `text`: the results for the terminal.
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
pub use text::HEAD_OF_F;

#[cfg(test)]
mod tests;
