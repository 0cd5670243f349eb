//! Poles and vehicles for the page, computed by functions of the calling program.

use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_node::BoxedError;
use planesman_parameters::Value;
use serde::Serialize;
use serde_json::json;

use crate::board::Board;
use crate::charts::{POLE, POLE_HIGH, POLE_LOW};
use crate::nodes::bounded;

/// A pole in the s plane with the standard deviation of each part, 1/s; 0 for a true pole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pole {
    /// Its real part.
    pub re: f64,
    /// Its imaginary part.
    pub im: f64,
    /// The standard deviation of the real part.
    pub re_sd: f64,
    /// The standard deviation of the imaginary part.
    pub im_sd: f64,
    /// Whether the pole is an artefact of sampling: too fast to be determined from the samples.
    pub artefact: bool,
}

/// A vehicle as known from its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Vehicle {
    /// Name or file of the model.
    pub name: String,
    /// Depth of the bottom, m; 0 without a bottom.
    pub bottom: f64,
    /// Poles of the true response from plane angle to pitch rate.
    pub poles: Vec<Pole>,
}

/// A parameter's name and value.
pub type Named = (String, Value);

/// Functions of the program that shows the page.
#[derive(Clone, Copy, Debug)]
pub struct ModelFunctions {
    /// The poles of an estimate, the dominant one first.
    pub poles: fn(&ModelEstimate) -> Vec<Pole>,
    /// The vehicle of a `plant_sim` with these parameters.
    pub vehicle: fn(&[Named]) -> Result<Vehicle, BoxedError>,
}

impl ModelFunctions {
    /// An estimate in the form that the page reads.
    pub(crate) fn model(&self, model: &ModelEstimate) -> serde_json::Value {
        json!({
            "name": bounded(&model.name),
            "input": bounded(&model.input),
            "output": bounded(&model.output),
            "estimator": bounded(&model.estimator),
            "order": model.order,
            "samples": model.samples,
            "fit": model.fit,
            "valid": model.valid,
            "reason": bounded(&model.reason),
            "frozen": model.frozen,
            "poles": (self.poles)(model),
        })
    }

    /// Writes an estimate to the board: the section of its topic, and the samples of its dominant pole.
    pub(crate) fn tell(&self, board: &mut Board, topic: &str, time: f64, model: &ModelEstimate) {
        /// Maximum number of signal pairs shown.
        const PAIRS: usize = 16;
        let section = format!("model:{topic}");
        let mut pairs = match board.section(&section) {
            Some(serde_json::Value::Object(pairs)) => pairs.clone(),
            _ => serde_json::Map::new(),
        };
        let told = self.model(model);
        let name = bounded(&model.name);
        if pairs.len() < PAIRS || pairs.contains_key(name) {
            pairs.insert(name.to_owned(), told);
            board.put(&section, pairs.into());
        }
        if let Some(pole) = (self.poles)(model).first().filter(|_| model.valid) {
            let width = 2.0 * pole.re_sd;
            for (channel, value) in [
                (POLE, pole.re),
                (POLE_LOW, pole.re - width),
                (POLE_HIGH, pole.re + width),
            ] {
                board.push(&format!("{topic}:{channel}"), time, value);
            }
        }
    }
}
