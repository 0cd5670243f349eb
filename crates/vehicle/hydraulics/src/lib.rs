#![doc = include_str!("../README.md")]
//!
//! A digital hydraulic actuator (DHA): two latching valves move a ram by metered volumes of oil. After G. W. Scott, *Digital Hydraulic
//! Actuator Study, Phase III Final Report* (IBM 66-L03-005, November 1966).
//!
//! ```text
//! plane command -> [position loop] -> [pulse logic] -> [valves] -> [metering] -> [ram] -> planes
//!                       ^                                                         |
//!                       +---------------------------------------------------------+
//! ```
//! - [`Dha`]: the complete actuator on its clock of valve cycles; [`Hydraulics`]: valves, metering and ram; [`Condition`]: faults.
//! - [`ActuatorSet`]: an actuator's constants; [`actuator_file`]: reads them; [`sizing`]: computes them for a load.
//! - [`linearised`]: small signals; [`frequency_response`]: sinusoids; [`describing_function`]: limit cycles.
//! - [`Actuator`]: turns a plane command into the plane motion over a tick.

pub mod actuator_file;
mod actuator_model;
mod actuator_set;
mod closed_form;
mod condition;
mod core;
mod cycle_clock;
pub mod describing_function;
mod dha;
mod energy;
mod error;
mod events;
mod first_order;
pub mod frequency_response;
mod groups;
mod hydraulics;
mod limit_cycle;
pub mod linearised;
mod metering;
mod modes;
pub mod parameters;
mod position_loop;
mod pulse_logic;
mod pulse_train;
mod ram;
pub mod sizing;
mod valves;

pub use crate::core::{Actuator, Output};
pub use actuator_model::Model;
pub use actuator_set::{ActuatorFile, ActuatorSet};
pub use condition::{Condition, Encoder, Leakages, Sound, StuckValve};
pub use dha::{Demand, Dha};
pub use energy::Energy;
pub use error::Error;
pub use events::break_away_force;
pub use groups::Group;
pub use hydraulics::{Hydraulics, Reading};
pub use modes::{Constants, FrictionState};
pub use parameters::ActuatorParameters;
pub use pulse_logic::{Command, DriftOption, Options, PulseLogic, SignChange, Volume};
pub use pulse_train::PulseTrain;
