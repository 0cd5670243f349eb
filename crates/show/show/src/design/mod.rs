//! Design of the depth and pitch loops, for any vehicle, speed, gains and actuator.
//!
//! - [`Subject`]: a vehicle with its actuator, as a sampled loop.
//! - [`Analysis`]: poles, margins and step response at each speed.
//! - [`Locus`]: the poles as one gain, or the speed, varies.
//! - [`DiveTask`], [`DiveGains`]: gains for an identified vehicle, over its model's uncertainty.
//! - [`DepthSteps`]: simulated depth steps with every actuator, feedback and gain source.
//! - [`size_text`], [`frequency_text`]: sizes and frequency response of an actuator; [`DepthLoop`]: the limit cycle it causes in the depth loop.
//! - [`circuits`]: designs of a circuit of on/off valves over a load cycle.
//!
//! The tools judge the sampled loop: the command is held between ticks, and the actuator has its own dynamics.
//! The methods are in [`planesman_control::design`]; this module applies them to vehicles and actuators.

mod actuator;
mod analysis;
pub mod circuits;
mod error;
mod harmonic_balance;
mod locus;
mod steps;
mod subject;
mod uncertain;

pub use actuator::{frequency_text, gain_and_phase, size_table, size_text};
pub use analysis::{Analysis, described, heading, stability};
pub use error::{Error, Result};
pub use harmonic_balance::{DepthLoop, Describing, MOST_RESIDUAL, Prediction};
pub use locus::{Locus, Varied};
pub use steps::{Choice, DepthSteps, Outcome};
pub use subject::{
    ACTUATOR, Body, Drive, Law, RATE, Sampling, Subject, TABLE_3, default_gains, gains_text,
    law_text, speed_text,
};
pub use uncertain::{DiveGains, DiveTask};
