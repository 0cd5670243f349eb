//! PI and PID gains for identified models, with margins over the plants within a model's uncertainty.
//!
//! ```text
//! ModelFile -> UncertainModel -> draws -> Plant      the controller's view at its ticks, dead time exact
//!           -> Dynamics -> Reduced                   gain, time constants and dead time, by the half rule
//! rules, search -> Controller -> Margins, Motion     of the model and of each draw
//! ```
//! - [`tune`], [`TuneOptions`], [`Tuning`]: the complete computation, including the choice of the method.
//! - [`rules`], [`search`]: gains for one model. [`reduction`]: the half rule.
//! - [`PlantResponse`], [`Margins`], [`Motion`]: the analysis of a loop. [`causes`]: properties that make the controller's phase margin uncertain.

mod causes;
mod closed_loop;
mod controller;
mod drawn;
mod dynamics;
mod error;
mod json;
mod model;
mod options;
mod plant;
pub mod reduction;
mod response;
mod robustness;
pub mod rules;
pub mod search;
#[cfg(test)]
mod tests;
mod tune;

pub use causes::{Cause, causes};
pub use closed_loop::{Limits, Margins, PlantResponse};
pub use controller::{Controller, FILTER_RATIO};
pub use drawn::drawn;
pub use dynamics::Dynamics;
pub use error::TuneError;
pub use model::{Property, PropertyKind, Sampling, UncertainModel};
pub use options::{Kind, Method, TuneOptions};
pub use plant::Plant;
pub use response::{Motion, Trial};
pub use robustness::{Band, Distribution, MISSED, Robustness, Steps};
pub use tune::{Tuning, tune};
