//! A digital hydraulic actuator (DHA): a ram moved in metered volumes of oil by two latching
//! valves, as IBM studied it for Polaris (G. W. Scott, *Digital Hydraulic Actuator Study, Phase
//! III Final Report*, IBM 66-L03-005, November 1966), here on an AUV's dive planes.
//!
//! ```text
//! plane command -> [position loop] -> [pulse logic] -> [valves] -> [metering] -> [ram] -> planes
//!                       ^                                                         |
//!                       +---------------------------------------------------------+
//! ```
//!
//! Models, from the oil outwards:
//! - [`actuator_set`], [`actuator_file`], [`units`]: an actuator's constants, and where they are read.
//! - [`condition`]: wear and faults.
//! - [`modes`]: the ram's laws and its motion within one, in closed form.
//! - [`events`]: where one law gives way to another: stick, slip, clamp, limits, stops.
//! - [`ram`]: the ram with its load, through modes and events.
//! - [`valves`]: the truth table of actuating and direction valve.
//! - [`metering`]: calibrated volumes on their way, drift, leakage: the flow into the ram.
//! - [`hydraulics`]: valves, metering and ram, cycle by cycle.
//! - [`pulse_logic`]: the quantizer that sends sign and volume pulses.
//! - [`position_loop`]: the predicting error detector before it.
//! - [`cycle_clock`]: valve cycles, counted without drift.
//! - [`dha`]: logic and hydraulics on that clock.
//! - [`limit_cycle`]: the limit cycle it is in.
//! - [`first_order`]: an analog servo to compare with.
//! - [`actuator_model`]: the DHA, a first-order or an ideal actuator, behind one interface.
//! - [`pulse_train`]: the hydraulics alone under given pulses.
//!
//! Design and analysis:
//! - [`sizing`]: quantum, rates, frequencies, power of an actuator; an actuator for a load.
//! - [`linearised`]: the actuator for small signals, and the flight control around it (Section V).
//! - [`frequency_response`]: the full model under sinusoids.
//! - [`describing_function`]: limit cycles predicted.
//!
//! Node:
//! - [`groups`]: which planes have an actuator of their own.
//! - [`parameters`]: every tunable, its default and range.
//! - [`core`]: a plane command in, a tick of plane motion out.

pub mod actuator_file;
pub mod actuator_model;
pub mod actuator_set;
pub mod condition;
pub mod core;
pub mod cycle_clock;
pub mod describing_function;
pub mod dha;
pub mod events;
pub mod first_order;
pub mod frequency_response;
pub mod groups;
pub mod hydraulics;
pub mod limit_cycle;
pub mod linearised;
pub mod metering;
pub mod modes;
pub mod node;
pub mod parameters;
pub mod position_loop;
pub mod pulse_logic;
pub mod pulse_train;
pub mod ram;
pub mod sizing;
pub mod units;
pub mod valves;
