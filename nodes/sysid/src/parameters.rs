//! The identifier's parameters: the only place where its defaults and ranges stand.

use planesman_identification::Structure;
use planesman_identification::estimators::kalman::Settings;
use planesman_identification::estimators::recursive::{Forgetting, Kind, Options};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_parameters::{Declaration, Values};
use planesman_signals::Signal;

use crate::message_types;

/// Parameters that are not a pair's.
pub(crate) const OF_THE_NODE: [&str; 4] = ["pairs", "answer", "input", "output"];

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
            "pairs",
            &[] as &[&str],
            "Further pairs of signals, each NAME: INPUT -> OUTPUT, followed by what differs from the node's own parameters as PARAMETER=VALUE.",
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
            "reliability",
            "auto",
            "How the signals' topics are listened to. reliable: lost messages are asked for again, of publishers that offer it, and no others are heard; best_effort: everybody is heard, and what is lost is lost; auto: reliable for a member of lockstep (answer), else best_effort. A topic of several pairs is reliable if one of them asks for it.",
        )
        .choices(&["auto", "reliable", "best_effort"])
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
            "resample",
            false,
            "Whether both signals are put on a grid of sample_time first: outputs on the straight line between samples, inputs held until the next (a list by its mean). For signals that are not stamped whole sample_times apart; not for a member of lockstep.",
        )
        .read_only(),
        Declaration::new(
            "max_gap",
            0.5,
            "With resample, the longest interval between two outputs that is no gap.",
        )
        .unit("s")
        .range(1e-3, 1e3)
        .read_only(),
        Declaration::new(
            "estimator",
            Method::ALL[0].name(),
            "What the model is found by; kalman on the vehicle's own equations (kalman.*), the others on a difference equation. A change begins the estimate anew.",
        )
        .choices(&METHODS),
        Declaration::new(
            "order",
            3_i64,
            "The model's order; 3 is the vehicle's from planes to pitch rate. A change begins the \
             estimate anew.",
        )
        .range(1.0, 10.0),
        Declaration::new(
            "delay",
            1_i64,
            "Samples from an input to its first effect. A change begins the estimate anew.",
        )
        .unit("samples")
        .range(1.0, 100.0),
        Declaration::new(
            "zeros_at_one",
            0_i64,
            "Zeros known to be at z = 1, fewer than the order: 1 for planes to pitch rate with a restoring moment. A change begins the estimate anew.",
        )
        .range(0.0, 9.0),
        Declaration::new(
            "integrators",
            0_i64,
            "Poles known to be at z = 1, fewer than the order. What was learnt then ends with a gap. A change begins the estimate anew.",
        )
        .range(0.0, 9.0),
        Declaration::new(
            "first_moment",
            true,
            "Regress on the input's first moment over each sample too, for an input that moves \
             within it; kalman does not. A change begins the estimate anew.",
        ),
        Declaration::new(
            "bias",
            false,
            "Regress on a constant too, for an output with an offset; kalman always does. A change begins the estimate anew.",
        ),
        Declaration::new(
            "forgetting",
            1.0,
            "What a row counts for after each later one; 1 forgets nothing, 0.98 remembers about 50 rows. The least, when it is variable.",
        )
        .range(0.5, 1.0),
        Declaration::new(
            "forgetting_kind",
            "constant",
            "What is forgotten: everything, only what the new row speaks of, or as much as it surprises.",
        )
        .choices(&["constant", "directional", "variable"]),
        Declaration::new(
            "forgetting_information",
            1e-4,
            "Of variable forgetting: the noise's variance times the rows to remember.",
        )
        .unit("output unit squared")
        .range(1e-30, 1e30),
        Declaration::new(
            "initial_covariance",
            1e18,
            "Covariance of each parameter before the first row, per unit of residual variance. A \
             change begins the estimate anew.",
        )
        .range(1e-6, 1e30),
        Declaration::new(
            "covariance_limit",
            0.0,
            "What the covariance's trace is kept below, per unit of residual variance; 0 for no limit.",
        )
        .range(0.0, 1e30),
        Declaration::new(
            "dead_zone",
            0.0,
            "Prediction errors up to this size teach nothing; 0 for none.",
        )
        .unit("output unit")
        .range(0.0, 1e30),
        Declaration::new(
            "publish_rate",
            2.0,
            "How often an estimate is published by the samples' stamps, to whole samples, at most each.",
        )
        .unit("Hz")
        .range(1e-6, 1e3),
        Declaration::new(
            "min_samples",
            60_i64,
            "Rows before an estimate can be valid.",
        )
        .unit("rows")
        .range(1.0, 1e9),
    ]
    .into_iter()
    .chain(kalman())
    .collect()
}

/// What the Kalman filter begins with and takes for noise: by default the 1988 vehicle's equations at 1 ft/s
/// (Brunner 1988, Table 1 and programs T2-T5, over J and in SI), loosely known.
fn kalman() -> Vec<Declaration> {
    let initial = |name, default: f64, unit, description| {
        Declaration::new(name, default, description)
            .unit(unit)
            .range(-1e6, 1e6)
    };
    let size = |name, default: f64, unit, description| {
        Declaration::new(name, default, description)
            .unit(unit)
            .range(0.0, 1e6)
    };
    vec![
        initial(
            "kalman.plane",
            -0.47,
            "1/s^2",
            "K/J at the beginning: pitch acceleration (bow up) per plane angle (dive). A change begins the estimate anew.",
        ),
        initial(
            "kalman.damping",
            1.19,
            "1/s",
            "B/J at the beginning. A change begins the estimate anew.",
        ),
        initial(
            "kalman.restoring",
            0.27,
            "1/s^2",
            "M_theta/J at the beginning. A change begins the estimate anew.",
        ),
        size(
            "kalman.deviation.plane",
            0.5,
            "1/s^2",
            "How far off K/J may be at the beginning, as a standard deviation. A change begins the estimate anew.",
        ),
        size(
            "kalman.deviation.damping",
            1.0,
            "1/s",
            "How far off B/J may be. A change begins the estimate anew.",
        ),
        size(
            "kalman.deviation.restoring",
            0.2,
            "1/s^2",
            "How far off M_theta/J may be. A change begins the estimate anew.",
        ),
        size(
            "kalman.deviation.bias",
            0.01,
            "rad/s",
            "How large the gyro's bias may be. A change begins the estimate anew.",
        ),
        size(
            "kalman.deviation.motion",
            0.05,
            "rad/s",
            "How large pitch rate, and pitch in rad, may be when the history begins.",
        ),
        Declaration::new(
            "kalman.noise",
            0.002,
            "The gyro noise's standard deviation.",
        )
        .unit("rad/s")
        .range(1e-9, 1e6),
        size(
            "kalman.disturbance",
            0.0,
            "rad/s",
            "How far disturbances move the pitch rate in one second.",
        ),
        size(
            "kalman.drift.plane",
            0.0,
            "1/s^2",
            "How far K/J drifts in one second.",
        ),
        size(
            "kalman.drift.damping",
            0.0,
            "1/s",
            "How far B/J drifts in one second.",
        ),
        size(
            "kalman.drift.restoring",
            0.0,
            "1/s^2",
            "How far M_theta/J drifts in one second.",
        ),
        size(
            "kalman.drift.bias",
            0.0,
            "rad/s",
            "How far the gyro's bias drifts in one second.",
        ),
        initial(
            "kalman.heave.to_pitch",
            0.7363,
            "1/(m s)",
            "Pitch acceleration per heave; 0 to leave heave out. A change begins the estimate anew.",
        ),
        initial(
            "kalman.heave.damping",
            0.5306,
            "1/s",
            "Heave's own damping. A change begins the estimate anew.",
        ),
        initial(
            "kalman.heave.from_rate",
            0.0571,
            "m/s",
            "Heave acceleration per pitch rate. A change begins the estimate anew.",
        ),
        initial(
            "kalman.heave.from_plane",
            0.0119,
            "m/s^2",
            "Heave acceleration per plane angle. A change begins the estimate anew.",
        ),
    ]
}

/// How a model is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// A difference equation, by a recursion.
    Recursion(Kind),
    /// The vehicle's equations, by an extended Kalman filter.
    Kalman,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Recursion(Kind::LeastSquares),
        Self::Recursion(Kind::ExtendedLeastSquares),
        Self::Recursion(Kind::PredictionError),
        Self::Recursion(Kind::OutputError),
        Self::Kalman,
    ];

    /// The name it is asked for by.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Recursion(Kind::LeastSquares) => "least_squares",
            Self::Recursion(Kind::ExtendedLeastSquares) => "extended_least_squares",
            Self::Recursion(Kind::PredictionError) => "prediction_error",
            Self::Recursion(Kind::OutputError) => "output_error",
            Self::Kalman => "kalman",
        }
    }
}

const METHODS: [&str; 5] = {
    let mut names = [""; 5];
    let mut i = 0;
    while i < names.len() {
        names[i] = Method::ALL[i].name();
        i += 1;
    }
    names
};

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
    /// The longest interval between two outputs that is no gap, ns, where signals are put on a grid first.
    pub resample: Option<i64>,
    /// How long after the first sample learning begins, ns.
    pub start: i64,
    /// How the model is found.
    pub method: Method,
    /// What is unknown of the difference equation.
    pub structure: Structure,
    /// First moments are regressed on.
    pub moment: bool,
    /// How a recursion learns.
    pub options: Options,
    /// What is known of the vehicle.
    pub vehicle: Vehicle,
    /// What the Kalman filter begins with and takes for noise.
    pub settings: Settings,
    /// Samples from one published estimate to the next.
    pub publish_every: u64,
    /// Samples before an estimate can be valid.
    pub min_samples: u64,
}

impl Config {
    /// The identifier that a set of [`declarations`]' values describes.
    ///
    /// # Errors
    /// A sentence naming the parameter, when a signal is not written `TOPIC:FIELD`, input
    /// and output are the same, or more of the structure is known than there is.
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
        let count = |name: &str| values.integer(name).max(0) as usize;
        let break_on = match values.string("break_on") {
            "" => None,
            _ => Some(signal("break_on")?),
        };
        if values.bool("resample") && values.bool("answer") {
            return Err(
                "parameter 'resample': true refused: a member of lockstep (answer) learns each tick as it is"
                    .to_owned(),
            );
        }
        let sample_time = values.double("sample_time");
        let samples = (1.0 / (values.double("publish_rate") * sample_time)).round();
        Ok(Self {
            input,
            output,
            break_on,
            sample_time,
            resample: values
                .bool("resample")
                .then(|| (values.double("max_gap") * 1e9).round() as i64),
            start: (values.double("start") * 1e9).round() as i64,
            method: Method::ALL
                .into_iter()
                .find(|method| method.name() == values.string("estimator"))
                .ok_or("parameter 'estimator': there is none of that name")?,
            structure: structure(values)?,
            moment: values.bool("first_moment"),
            options: options(values),
            vehicle: vehicle(values),
            settings: settings(values),
            publish_every: samples.max(1.0) as u64,
            min_samples: count("min_samples") as u64,
        })
    }

    /// Whether messages on `topic` bear one of the signals.
    #[must_use]
    pub fn is_on(&self, topic: &str) -> bool {
        self.input.is_on(topic) || self.output.is_on(topic)
    }

    /// These with what of `new` can change while it is learnt.
    #[must_use]
    pub fn retuned(&self, new: &Self) -> Self {
        Self {
            options: Options {
                initial_covariance: self.options.initial_covariance,
                ..new.options
            },
            settings: Settings {
                parameters: self.settings.parameters,
                deviations: self.settings.deviations,
                bias_deviation: self.settings.bias_deviation,
                ..new.settings
            },
            publish_every: new.publish_every,
            min_samples: new.min_samples,
            ..self.clone()
        }
    }
}

fn structure(values: &Values) -> Result<Structure, String> {
    let count = |name: &str| values.integer(name).max(0) as usize;
    let order = count("order");
    let mut structure = Structure::of_order(order);
    for (name, known) in [
        ("zeros_at_one", Structure::with_zero_at_one as fn(_) -> _),
        ("integrators", Structure::with_integrator),
    ] {
        if count(name) >= order {
            return Err(format!(
                "parameter '{name}': {} refused: the order is {order}, and some of it must be left to be found",
                count(name)
            ));
        }
        for _ in 0..count(name) {
            structure = known(structure);
        }
    }
    structure.delay = count("delay");
    structure.offset = values.bool("bias");
    Ok(structure)
}

fn options(values: &Values) -> Options {
    let lambda = values.double("forgetting");
    let limit = values.double("covariance_limit");
    Options {
        forgetting: match values.string("forgetting_kind") {
            "directional" => Forgetting::Directional(lambda),
            "variable" => Forgetting::Variable {
                least: lambda,
                information: values.double("forgetting_information"),
            },
            _ => Forgetting::Constant(lambda),
        },
        initial_covariance: values.double("initial_covariance"),
        covariance_limit: (limit > 0.0).then_some(limit),
        dead_zone: values.double("dead_zone"),
    }
}

fn vehicle(values: &Values) -> Vehicle {
    let heave = |name: &str| values.double(&format!("kalman.heave.{name}"));
    let heave = Heave {
        to_pitch: heave("to_pitch"),
        damping: heave("damping"),
        from_rate: heave("from_rate"),
        from_input: heave("from_plane"),
        doubt: 0.0,
    };
    Vehicle {
        heave: (heave.to_pitch != 0.0).then_some(heave),
    }
}

fn settings(values: &Values) -> Settings {
    let of = |name: &str| values.double(&format!("kalman.{name}"));
    let all = |group: &str| ["plane", "damping", "restoring"].map(|it| of(&format!("{group}{it}")));
    Settings {
        parameters: all(""),
        deviations: all("deviation."),
        bias_deviation: of("deviation.bias"),
        noise: of("noise"),
        bias_drift: of("drift.bias"),
        drift: all("drift."),
        disturbance: of("disturbance"),
        motion: of("deviation.motion"),
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
        assert_eq!(config.structure.poles, 3);
        assert_eq!(config.publish_every, 10);
    }

    #[test]
    fn signals_that_are_none_or_the_same_are_refused_by_name() {
        for (name, value, word) in [
            ("input", Value::from("dive_planes"), "TOPIC:FIELD"),
            ("output", "plane_motion:dive_planes".into(), "input as well"),
            ("zeros_at_one", 3.into(), "left to be found"),
        ] {
            let values = Values::defaults(declarations())
                .with([(name.to_owned(), value)])
                .unwrap();
            let refusal = Config::from_values(&values).unwrap_err();
            assert!(
                refusal.contains(name) && refusal.contains(word),
                "{refusal}"
            );
        }
    }
}
