//! Requests of a page, and their answers.

use planesman_parameters::Value as Parameter;
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::{Value, json};
use tokio::sync::oneshot;

use crate::{Error, units};

/// A request of a page. Names are absolute.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Command {
    /// Record these channels, `TOPIC:FIELD`.
    Keep { channels: Vec<String> },
    /// List the numeric fields of a topic.
    Fields { topic: String },
    /// Return a node's parameters with their descriptors.
    Parameters { node: String },
    /// Set a parameter; `kind` is its type in `rcl_interfaces/msg/ParameterType`. A number is in the page's unit, or has its own unit.
    Set {
        node: String,
        name: String,
        kind: u8,
        text: String,
        /// SI unit of the parameter, empty if it has none.
        unit: String,
    },
    /// Call a `std_srvs/srv/Trigger`.
    Trigger { service: String },
    /// Call a `std_srvs/srv/SetBool`.
    SetBool { service: String, data: bool },
    /// Run a paused vehicle for a number of ticks.
    Step { service: String, ticks: u32 },
    /// Request the estimate of the pair `name`.
    Fit { service: String, name: String },
    /// Pause, resume or split a recording.
    Recorder { service: String },
    /// Return the file that the recorder of this name writes.
    Bag { node: String },
    /// Publish a setpoint, in the page's unit or with its own.
    Publish { topic: String, text: String },
    /// Send a manoeuvre to the action of this name.
    Manoeuvre { action: String, goal: Goal },
    /// Cancel the page's manoeuvre.
    Cancel { action: String },
}

/// A goal of `planesman_msgs/action/Manoeuvre`; its quantities are texts in the page's units or with their own.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Goal {
    pub(crate) name: String,
    pub(crate) amplitude: String,
    pub(crate) period: String,
    pub(crate) duration: String,
    #[serde(default)]
    pub(crate) seed: i64,
}

/// A request on its way to the node, with the channel for its answer.
pub(crate) struct Request {
    pub(crate) command: Command,
    pub(crate) reply: oneshot::Sender<Value>,
}

/// Answer to a successful request.
pub(crate) fn done(message: impl Into<String>) -> Value {
    json!({"ok": true, "message": message.into()})
}

/// Answer to a refused request, with the reason.
pub(crate) fn refused(reason: impl ToString) -> Value {
    json!({"ok": false, "message": reason.to_string()})
}

/// Parses a parameter's value from the page's text; `unit` is its SI unit.
pub(crate) fn parameter_of(kind: u8, text: &str, unit: &str) -> Result<Parameter, Error> {
    fn list<T: DeserializeOwned>(text: &str, what: &'static str) -> Result<Vec<T>, Error> {
        serde_json::from_str(text).map_err(|_| Error::List(text.to_owned(), what))
    }
    let trimmed = text.trim();
    Ok(match kind {
        1 => Parameter::Bool(trimmed.parse().map_err(|_| Error::Bool(text.to_owned()))?),
        2 => Parameter::Integer(
            trimmed
                .parse()
                .map_err(|_| Error::Integer(text.to_owned()))?,
        ),
        3 => Parameter::Double(units::parse(text, unit)?),
        4 => Parameter::String(text.to_owned()),
        5 => Parameter::ByteArray(list(text, "bytes")?),
        6 => Parameter::BoolArray(list(text, "true or false")?),
        7 => Parameter::IntegerArray(list(text, "whole numbers")?),
        8 => {
            let numbers: Vec<f64> = list(text, "numbers")?;
            let numbers = numbers.iter().map(|it| units::parse(&it.to_string(), unit));
            Parameter::DoubleArray(numbers.collect::<Result<_, _>>()?)
        }
        9 => Parameter::StringArray(list(text, "texts")?),
        other => return Err(Error::ParameterType(other)),
    })
}

/// Text of a parameter's value, in the form that [`parameter_of`] reads.
pub(crate) fn text_of(value: &Parameter, unit: &str) -> String {
    match value {
        Parameter::String(text) => text.clone(),
        Parameter::Double(number) => units::on_page(*number, unit).to_string(),
        Parameter::DoubleArray(numbers) => {
            let shown = numbers.iter().map(|it| units::on_page(*it, unit));
            Parameter::DoubleArray(shown.collect()).to_string()
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameters_text_reads_back_as_the_value() {
        for (kind, value) in [
            (1, Parameter::Bool(true)),
            (2, Parameter::Integer(-9_007_199_254_740_993)),
            (3, Parameter::Double(1.0e-7)),
            (3, Parameter::Double(0.1 + 0.2)),
            (4, Parameter::String(" <b>\"x\"\n".to_owned())),
            (5, Parameter::ByteArray(vec![0, 255])),
            (6, Parameter::BoolArray(vec![true, false])),
            (7, Parameter::IntegerArray(vec![])),
            (8, Parameter::DoubleArray(vec![1.0, -2.5])),
            (9, Parameter::StringArray(vec!["a".to_owned()])),
        ] {
            let read = parameter_of(kind, &text_of(&value, ""), "");
            assert_eq!(read.expect("its own text"), value);
        }
        for (kind, text) in [
            (1, "yes"),
            (2, "1.5"),
            (3, "inf"),
            (3, ""),
            (8, "1, 2"),
            (77, ""),
        ] {
            assert!(parameter_of(kind, text, "").is_err(), "{kind} {text}");
        }
        let angles = Parameter::DoubleArray(vec![std::f64::consts::PI, 0.0]);
        assert_eq!(text_of(&angles, "rad"), "[180.0, 0.0]");
        assert_eq!(parameter_of(8, "[180, 0]", "rad").expect("a list"), angles);
    }

    #[test]
    fn a_request_with_what_it_must_not_have_is_no_request() {
        let read = |text: &str| serde_json::from_str::<Command>(text);
        assert!(read(r#"{"do":"set_bool","service":"/auv/plant_sim/pause","data":true}"#).is_ok());
        assert!(read(r#"{"do":"set_bool","service":"/a"}"#).is_err());
        assert!(read(r#"{"do":"run","command":"reboot"}"#).is_err());
    }
}
