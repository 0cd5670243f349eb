//! Design of the depth and pitch loops, for any vehicle, speed, gains and actuator.
//!
//! - [`Subject`]: a vehicle behind an actuator, as a sampled loop.
//! - [`Analysis`]: poles, margins and step response at each speed.
//! - [`Locus`]: the poles as one gain, or the speed, varies.
//! - [`DiveTask`], [`DiveGains`]: gains for an identified vehicle, over its model's uncertainty.
//! - [`DepthSteps`]: depth steps flown with every actuator, feedback and gain source.
//! - [`size_text`], [`frequency_text`]: an actuator by itself; [`DepthLoop`]: the limit cycle that it leaves in the depth loop.
//! - [`circuits`]: designs of a circuit of on/off valves over a load cycle.
//!
//! The loops' tools judge the sampled loop: the command at the ticks, held, and the actuator's own motion behind it.
//! The tools are [`planesman_control::design`]; here they meet vehicles and actuators.

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
