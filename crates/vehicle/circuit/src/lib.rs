#![doc = include_str!("../README.md")]
//!
//! - [`Circuit`], [`mod@file`]: the constants of a circuit, and the file that contains them; [`Line`]: a hydraulic line from a level to its valves.
//! - [`Simulation`]: the motion with valves that open and close, and a ram that sticks, slides and reaches its stops; [`Ledger`]: its
//!   energy.
//! - [`Actuator`]: the circuit with its controller, [`Law`].
//! - [`LoadCycle`]: a reference and a force over time; [`run`]: the results of a circuit that follows one.

mod actuator;
mod choice;
mod circuit;
pub mod coding;
mod control;
pub mod file;
mod ledger;
mod line;
mod load_cycle;
mod simulation;

pub use actuator::{Actuator, Demand};
pub use circuit::{
    ATMOSPHERE, Chamber, Circuit, Control, Edge, ElasticStop, Law, Level, Line, Load, MOST_EDGES,
    MOST_LEVELS, MOST_VALVES, Oil, Steady, Valves, root,
};
pub use control::Reference;
pub use ledger::Ledger;
pub use load_cycle::{Figures, LoadCycle, LoadCycleError, MOST_FORCE, Point, run};
pub use simulation::{Force, Mode, Simulation};
