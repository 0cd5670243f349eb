//! A file of equations.
//!
//! ```yaml
//! inputs: [u]
//! outputs:
//!   y: {equation: x1, noise: 0.02}
//! states:
//!   x1: {derivative: x2, initial: unknown}
//!   x2: {derivative: (K*u - x2 - drag)/T, initial: 0}
//! definitions:
//!   drag: c*x2*abs(x2)
//! parameters:
//!   K: {start: 1, min: 0, unit: rad/s}
//!   T: {start: 1, min: 0.01}
//!   c: {start: 0}
//! ```

use std::path::Path;

use planesman_text::yaml;
use serde::{Deserialize, Serialize};

use crate::error::EquationsError;
use crate::named::Named;

/// The contents of a file of equations.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct EquationsFile {
    /// A description of the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Inputs, each with its signal of the data; by default the signal has the input's name.
    #[serde(default)]
    pub inputs: Named<Option<String>>,
    /// Outputs.
    pub outputs: Named<Output>,
    /// States.
    pub states: Named<State>,
    /// Names for expressions that others use.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub definitions: Named<String>,
    /// Parameters.
    #[serde(default)]
    pub parameters: Named<Parameter>,
}

/// An output.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Its equation.
    pub equation: String,
    /// Name of the output's signal in the data; by default the output's own name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal: Option<String>,
    /// Standard deviation of the measurement's noise, output unit, by which outputs are weighted. Without it the residuals of each output
    /// are used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// Unit of the output, for display only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// A state.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// The time derivative, per s.
    pub derivative: String,
    /// The state at the beginning of each segment of the data.
    #[serde(default)]
    pub initial: Initial,
    /// Unit of the signal, for display only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// The initial value of a state.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Initial {
    /// At a number.
    Known(f64),
    /// `unknown`, or an expression of parameters and of the inputs at the first sample.
    Text(String),
    /// Estimated, from a start.
    Sought(Sought),
}

impl Default for Initial {
    fn default() -> Self {
        Self::Text(UNKNOWN.to_owned())
    }
}

/// The keyword for an estimated initial state.
pub(crate) const UNKNOWN: &str = "unknown";

/// An estimated initial state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sought {
    /// The initial guess.
    pub start: f64,
    /// The minimum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// The most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// A parameter.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// The initial guess; optional with `min` and `max`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// The minimum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// The most. With `min` and `max`, several searches begin between them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// A known value; it is not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed: Option<f64>,
    /// Unit of the entry, for display only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The standard deviation of `start`, in a file written after a fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
}

impl EquationsFile {
    /// Reads a file.
    ///
    /// # Errors
    /// [`EquationsError`], with the line of the error.
    pub fn read(path: &Path) -> Result<Self, EquationsError> {
        let text = planesman_text::read(path).map_err(|error| EquationsError::file(path, error))?;
        text_of(&text).map_err(|error| {
            let reason = error.to_string();
            // Within braces a comma ends an expression.
            let hint = match reason.contains("unknown field") {
                true => ". Within braces, put an expression with commas in quotes",
                false => "",
            };
            EquationsError::file(path, format!("{reason}{hint}"))
        })
    }

    /// Writes a file: YAML, or JSON by its ending.
    ///
    /// # Errors
    /// [`EquationsError`]: a file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), EquationsError> {
        let text = match path.extension().is_some_and(|it| it == "json") {
            true => serde_json::to_string_pretty(self).map_err(|it| it.to_string()),
            false => serde_yaml_ng::to_string(self).map_err(|it| it.to_string()),
        };
        let written = text
            .and_then(|text| planesman_text::write_text(path, text).map_err(|it| it.to_string()));
        written.map_err(|error| EquationsError::file(path, error))
    }
}

/// The equations of a text.
///
/// # Errors
/// [`yaml::Error`], with the line of the error.
pub fn text_of(text: &str) -> Result<EquationsFile, yaml::Error> {
    yaml::from_str(text)
}
