//! What an FMU simulates: an actuator, a vehicle or an identified model, each sampled at its tick.

use planesman_parameters::Value;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::variable::Variable;

/// The kinds of what is exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// An actuator file.
    Actuator,
    /// A vehicle file, of the plane or of six degrees of freedom.
    Vehicle,
    /// An identified model's file.
    Model,
}

/// Parameters by name.
pub(crate) type Parameters = [(String, Value)];

/// What an FMU simulates, before it does.
pub(crate) trait Subject: Send + Sync {
    /// The tick \[s\]: inputs are taken, and outputs change, at its multiples.
    fn tick(&self) -> f64;

    /// Every variable but time: inputs, outputs and parameters, in this order.
    fn variables(&self) -> &[Variable];

    /// The simulation at its beginning.
    ///
    /// # Errors
    /// Parameters that do not go together.
    fn begin(&self, parameters: &Parameters) -> Result<Box<dyn Simulation>, Error>;
}

/// A simulation under way. A clone has the same future.
pub(crate) trait Simulation: Send {
    /// Takes changed parameters, from the next tick on.
    ///
    /// # Errors
    /// Parameters that do not go together; those before then hold.
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error>;

    /// Moves on by one tick, the inputs held over it.
    ///
    /// # Errors
    /// A motion that is refused or diverges.
    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error>;

    /// The outputs at the present tick, with these inputs where an output depends on them at once.
    fn outputs(&self, inputs: &[f64]) -> Vec<Value>;

    /// The same simulation once more.
    fn copy(&self) -> Box<dyn Simulation>;
}
