//! The subject of an FMU: an actuator, a vehicle or an identified model, each sampled at its tick.

use planesman_parameters::Value;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::variable::Variable;

/// The kinds of subjects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// An actuator file.
    Actuator,
    /// A vehicle file, of the vertical plane or of six degrees of freedom.
    Vehicle,
    /// An identified model's file.
    Model,
}

/// Parameters by name.
pub(crate) type Parameters = [(String, Value)];

/// The subject of an FMU, before its simulation.
pub(crate) trait Subject: Send + Sync {
    /// The tick \[s\]: at its multiples inputs are read and outputs change.
    fn tick(&self) -> f64;

    /// Every variable except time: inputs, outputs and parameters, in this order.
    fn variables(&self) -> &[Variable];

    /// The simulation in its initial state.
    ///
    /// # Errors
    /// If parameters conflict.
    fn begin(&self, parameters: &Parameters) -> Result<Box<dyn Simulation>, Error>;
}

/// A running simulation. A clone has exactly the same future.
pub(crate) trait Simulation: Send {
    /// Applies changed parameters, from the next tick on.
    ///
    /// # Errors
    /// If parameters conflict; then the old ones stay.
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error>;

    /// Advances by one tick, with constant inputs.
    ///
    /// # Errors
    /// If a motion is refused or diverges.
    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error>;

    /// The outputs at the current tick, with these inputs for direct feedthrough.
    fn outputs(&self, inputs: &[f64]) -> Vec<Value>;

    /// A copy of the simulation.
    fn copy(&self) -> Box<dyn Simulation>;
}
