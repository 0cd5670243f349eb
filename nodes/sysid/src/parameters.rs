//! The identifier's parameters: the only place where its defaults and ranges stand.

use planesman_parameters::{Declaration, Values};

use crate::message_types;
use crate::regression::Shape;
use crate::signal::Signal;

/// Everything the node declares, in the order it is listed.
#[must_use]
pub fn declarations() -> Vec<Declaration> {
    vec![
        Declaration::new(
            "input",
            "plane_motion:dive_planes",
            "The signal that drives, TOPIC:FIELD; a list is its course over the coming sample_time.",
        )
        .read_only(),
        Declaration::new(
            "output",
            "state:pitch_rate",
            "The signal that responds, TOPIC:FIELD.",
        )
        .read_only(),
        Declaration::new(
            "break_on",
            "state:planes_source",
            "A signal of the output's messages: where it is not 0, the input over the interval before is not to be trusted and the history begins anew. Empty for none.",
        )
        .read_only(),
        Declaration::new(
            "input_type",
            "planesman_msgs/msg/PlaneMotion",
            "The message type on the input's topic.",
        )
        .read_only(),
        Declaration::new(
            "output_type",
            "planesman_msgs/msg/VehicleState",
            "The message type on the output's topic.",
        )
        .read_only(),
        Declaration::new(
            "start",
            0.0,
            "How long after the first sample learning begins, to leave a transient out. A change begins the estimate anew.",
        )
        .unit("s")
        .range(0.0, 1e6),
        Declaration::new(
            "answer",
            false,
            "Whether each tick is answered once it is learnt, as a member of lockstep.",
        )
        .read_only(),
        Declaration::new(
            "sample_time",
            0.05,
            "The interval between samples; 0.05 s is the report's (Brunner 1988, ch. V).",
        )
        .unit("s")
        .range(1e-3, 1e3)
        .read_only(),
        Declaration::new(
            "order",
            3_i64,
            "The model's order; 3 is the vehicle's from planes to pitch rate. A change begins the \
             estimate anew.",
        )
        .range(1.0, 10.0),
        Declaration::new(
            "first_moment",
            true,
            "Regress on the input's first moment over each sample too, for an input that moves \
             within it. A change begins the estimate anew.",
        ),
        Declaration::new(
            "bias",
            false,
            "Regress on a constant too, for an output with an offset. A change begins the estimate anew.",
        ),
        Declaration::new(
            "forgetting",
            1.0,
            "What a row counts for after each later one; 1 forgets nothing, 0.98 remembers about 50 rows.",
        )
        .range(0.5, 1.0),
        Declaration::new(
            "initial_covariance",
            1e18,
            "Covariance of each parameter before the first row, per unit of residual variance. A \
             change begins the estimate anew.",
        )
        .range(1e-6, 1e30),
        Declaration::new(
            "publish_every",
            10_i64,
            "Rows from one published estimate to the next.",
        )
        .unit("rows")
        .range(1.0, 1e6),
        Declaration::new(
            "min_samples",
            60_i64,
            "Rows before an estimate can be valid.",
        )
        .unit("rows")
        .range(1.0, 1e9),
    ]
}

/// The parameters as the identifier takes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// What drives.
    pub input: Signal,
    /// What responds.
    pub output: Signal,
    /// What says, where it is not 0, that the input before an output is not to be trusted.
    pub break_on: Option<Signal>,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// How long after the first sample learning begins, ns.
    pub start: i64,
    /// The model's order and which columns its regression has.
    pub shape: Shape,
    /// lambda.
    pub forgetting: f64,
    /// p0, parameter unit squared per output unit squared.
    pub initial_covariance: f64,
    /// Rows from one published estimate to the next.
    pub publish_every: u64,
    /// Rows before an estimate can be valid.
    pub min_samples: u64,
}

impl Config {
    /// The identifier that a set of [`declarations`]' values describes.
    ///
    /// # Errors
    /// A sentence naming the parameter, when a signal is not written `TOPIC:FIELD`, or input
    /// and output are the same.
    pub fn from_values(values: &Values) -> Result<Self, String> {
        let signal = |name: &str| {
            values
                .string(name)
                .parse::<Signal>()
                .map_err(|reason| format!("parameter '{name}': {reason}"))
        };
        let (input, output) = (signal("input")?, signal("output")?);
        for name in ["input_type", "output_type"] {
            message_types::find(values.string(name))
                .map_err(|reason| format!("parameter '{name}': {reason}"))?;
        }
        if input == output {
            return Err(format!(
                "parameter 'output': {output} refused: it is the input as well"
            ));
        }
        // The declared ranges keep these positive.
        let count = |name: &str| values.integer(name).max(1) as u64;
        let break_on = match values.string("break_on") {
            "" => None,
            _ => Some(signal("break_on")?),
        };
        Ok(Self {
            input,
            output,
            break_on,
            sample_time: values.double("sample_time"),
            start: (values.double("start") * 1e9).round() as i64,
            shape: Shape {
                order: count("order") as usize,
                moment: values.bool("first_moment"),
                bias: values.bool("bias"),
            },
            forgetting: values.double("forgetting"),
            initial_covariance: values.double("initial_covariance"),
            publish_every: count("publish_every"),
            min_samples: count("min_samples"),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use planesman_parameters::Value;

    #[test]
    fn every_default_obeys_its_own_declaration_and_all_go_together() {
        for declaration in declarations() {
            declaration.accept(declaration.default.clone()).unwrap();
        }
        let config = Config::from_values(&Values::defaults(declarations())).unwrap();
        assert_eq!(config.input.to_string(), "plane_motion:dive_planes");
        assert_eq!(config.shape.parameters(), 9);
    }

    #[test]
    fn signals_that_are_none_or_the_same_are_refused_by_name() {
        for (name, value, word) in [
            ("input", "dive_planes", "TOPIC:FIELD"),
            ("output", "plane_motion:dive_planes", "input as well"),
        ] {
            let values = Values::defaults(declarations())
                .with([(name.to_owned(), Value::from(value))])
                .unwrap();
            let refusal = Config::from_values(&values).unwrap_err();
            assert!(
                refusal.contains(name) && refusal.contains(word),
                "{refusal}"
            );
        }
    }
}
