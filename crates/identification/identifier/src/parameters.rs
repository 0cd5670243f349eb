//! The identifier's parameters, with their defaults and ranges, which are defined only here.

use planesman_decode::message_types;
use planesman_identification::Structure;
use planesman_identification::estimators::kalman::Settings;
use planesman_identification::estimators::recursive::{Forgetting, Kind, Options};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_parameters::{Choice, Parameters};
use planesman_signals::Signal;

use crate::error::Error;

/// Parameters that are not a pair's.
pub(crate) const OF_THE_NODE: [&str; 4] = ["pairs", "answer", "input", "output"];

/// Every parameter of `sysid`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct IdentifierParameters {
    /// Input signal, TOPIC:FIELD; a list is its time history over the next sample_time.
    #[parameter(default = "plane_motion:dive_planes", read_only)]
    pub input: String,
    /// Output signal, TOPIC:FIELD.
    #[parameter(default = "state:pitch_rate", read_only)]
    pub output: String,
    /// Validity flag, a field of the output's messages: if the flag is not 0, the preceding input is invalid and the history restarts. Empty: no flag.
    #[parameter(default = "state:planes_source", read_only)]
    pub break_on: String,
    /// Message type of the input's topic.
    #[parameter(default = "planesman_msgs/msg/PlaneMotion", read_only)]
    pub input_type: String,
    /// Message type of the output's topic.
    #[parameter(default = "planesman_msgs/msg/VehicleState", read_only)]
    pub output_type: String,
    /// Further signal pairs, each NAME: INPUT -> OUTPUT, followed by PARAMETER=VALUE for each parameter that
    /// differs from the node's own.
    #[parameter(default = Vec::new(), read_only)]
    pub pairs: Vec<String>,
    /// Delay from the first sample to the start of the estimation, to exclude a transient. A change restarts the
    /// estimate.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e6)]
    pub start: f64,
    /// Whether each tick is answered once its sample is processed, as a member of lockstep.
    #[parameter(default = false, read_only)]
    pub answer: bool,
    /// QoS reliability of the signals' subscriptions: reliable (lost messages are sent again; only reliable
    /// publishers match), best_effort (all publishers match), or auto (reliable for a member of lockstep, else
    /// best_effort). A topic of several pairs is reliable if at least one pair needs it.
    #[parameter(default = Reliability::Auto, read_only)]
    pub reliability: Reliability,
    /// Sampling time; 0.05 s in the report (Brunner 1988, ch. V).
    #[parameter(default = 0.05, unit = "s", range = 1e-3..=1e3, read_only)]
    pub sample_time: f64,
    /// Whether both signals are resampled to sample_time first: outputs by linear interpolation, inputs by hold
    /// (a list by its mean). For signals whose stamps are not whole sample_times apart; not for a member of
    /// lockstep.
    #[parameter(default = false, read_only)]
    pub resample: bool,
    /// Longest interval between two outputs that is not a gap, with resample.
    #[parameter(default = 0.5, unit = "s", range = 1e-3..=1e3, read_only)]
    pub max_gap: f64,
    /// Estimator: kalman for the vehicle's equations (kalman.*), the others for a difference equation. A change
    /// restarts the estimate.
    #[parameter(default = EstimatorKind::RecursiveLeastSquares)]
    pub estimator: EstimatorKind,
    /// Order of the model; 3 for the vehicle from planes to pitch rate. A change restarts the estimate.
    #[parameter(default = 3, range = 1..=10)]
    pub order: usize,
    /// Delay from the input to its first effect. A change restarts the estimate.
    #[parameter(default = 1, unit = "samples", range = 1..=100)]
    pub delay: usize,
    /// Number of zeros known to be at z = 1, below the order: 1 for planes to pitch rate with a restoring moment.
    /// A change restarts the estimate.
    #[parameter(default = 0, range = 0..=9)]
    pub zeros_at_one: usize,
    /// Number of poles known to be at z = 1, below the order; a gap then discards the estimate. A change restarts
    /// the estimate.
    #[parameter(default = 0, range = 0..=9)]
    pub integrators: usize,
    /// Whether the input's first moment over each sample is a regressor, for an input that moves within the sample; not used by kalman. A change
    /// restarts the estimate.
    #[parameter(default = true)]
    pub first_moment: bool,
    /// Whether a constant is a regressor, for an output with an offset; kalman always estimates a constant. A change restarts the estimate.
    #[parameter(default = false)]
    pub bias: bool,
    /// Forgetting factor per sample (1 = none; 0.98 = memory of about 50 samples); its minimum with
    /// forgetting_kind variable.
    #[parameter(default = 1.0, range = 0.5..=1.0)]
    pub forgetting: f64,
    /// Law of forgetting: on_jump (all past samples, and everything before a jump of the parameters once it is detected;
    /// recursive and extended least squares), constant (all past samples), directional (only in the direction of the new
    /// regressor) or variable (by the prediction error).
    #[parameter(default = ForgettingKind::OnJump)]
    pub forgetting_kind: ForgettingKind,
    /// Information kept with forgetting_kind variable: noise variance times the number of samples to remember.
    #[parameter(default = 1e-4, unit = "output unit squared", range = 1e-30..=1e30)]
    pub forgetting_information: f64,
    /// Initial covariance of each parameter, per unit of residual variance. A change restarts the estimate.
    #[parameter(default = 1e18, range = 1e-6..=1e30)]
    pub initial_covariance: f64,
    /// Limit of the covariance's trace, per unit of residual variance; 0: no limit.
    #[parameter(default = 0.0, range = 0.0..=1e30)]
    pub covariance_limit: f64,
    /// Dead zone of the prediction error; smaller errors do not update the estimate. 0: no dead zone.
    #[parameter(default = 0.0, unit = "output unit", range = 0.0..=1e30)]
    pub dead_zone: f64,
    /// Rate at which estimates are published, by the stamps of the samples, rounded to whole samples.
    #[parameter(default = 2.0, unit = "Hz", range = 1e-6..=1e3)]
    pub publish_rate: f64,
    /// Number of samples before an estimate can be valid.
    #[parameter(default = 60, unit = "rows", range = 1.0..=1e9)]
    pub min_samples: u64,
    /// `kalman.*`.
    pub kalman: Kalman,
}

/// The parameters `kalman.*`: initial values and noise levels of the Kalman filter; by default the 1988 vehicle's equations at 1 ft/s
/// (Brunner 1988, Table 1 and programs T2-T5, over J and in SI), with wide deviations.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Kalman {
    /// Initial K/J: pitch acceleration, positive bow up, per plane angle, positive dive. A change restarts the
    /// estimate.
    #[parameter(default = -0.47, unit = "1/s^2", range = -1e6..=1e6)]
    pub plane: f64,
    /// Initial B/J. A change restarts the estimate.
    #[parameter(default = 1.19, unit = "1/s", range = -1e6..=1e6)]
    pub damping: f64,
    /// Initial M_theta/J. A change restarts the estimate.
    #[parameter(default = 0.27, unit = "1/s^2", range = -1e6..=1e6)]
    pub restoring: f64,
    /// `kalman.deviation.*`.
    pub deviation: Deviation,
    /// Standard deviation of the gyro noise.
    #[parameter(default = 0.002, unit = "rad/s", range = 1e-9..=1e6)]
    pub noise: f64,
    /// Standard deviation of the pitch rate's change by disturbances in one second.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e6)]
    pub disturbance: f64,
    /// `kalman.drift.*`.
    pub drift: Drift,
    /// `kalman.heave.*`.
    pub heave: KalmanHeave,
}

/// The parameters `kalman.deviation.*`: initial standard deviations.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Deviation {
    /// Standard deviation of the initial K/J. A change restarts the estimate.
    #[parameter(default = 0.5, unit = "1/s^2", range = 0.0..=1e6)]
    pub plane: f64,
    /// Standard deviation of the initial B/J. A change restarts the estimate.
    #[parameter(default = 1.0, unit = "1/s", range = 0.0..=1e6)]
    pub damping: f64,
    /// Standard deviation of the initial M_theta/J. A change restarts the estimate.
    #[parameter(default = 0.2, unit = "1/s^2", range = 0.0..=1e6)]
    pub restoring: f64,
    /// Standard deviation of the initial gyro bias. A change restarts the estimate.
    #[parameter(default = 0.01, unit = "rad/s", range = 0.0..=1e6)]
    pub bias: f64,
    /// Standard deviation of pitch rate, and of pitch in rad, at the start of the history.
    #[parameter(default = 0.05, unit = "rad/s", range = 0.0..=1e6)]
    pub motion: f64,
}

/// The parameters `kalman.drift.*`: standard deviations of random walks.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Drift {
    /// Standard deviation of the random walk of K/J after one second.
    #[parameter(default = 0.0, unit = "1/s^2", range = 0.0..=1e6)]
    pub plane: f64,
    /// Standard deviation of the random walk of B/J after one second.
    #[parameter(default = 0.0, unit = "1/s", range = 0.0..=1e6)]
    pub damping: f64,
    /// Standard deviation of the random walk of M_theta/J after one second.
    #[parameter(default = 0.0, unit = "1/s^2", range = 0.0..=1e6)]
    pub restoring: f64,
    /// Standard deviation of the random walk of the gyro bias after one second.
    #[parameter(default = 0.0, unit = "rad/s", range = 0.0..=1e6)]
    pub bias: f64,
}

/// The parameters `kalman.heave.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct KalmanHeave {
    /// Pitch acceleration per heave; 0: heave is ignored. A change restarts the estimate.
    #[parameter(default = 0.7363, unit = "1/(m s)", range = -1e6..=1e6)]
    pub to_pitch: f64,
    /// Damping of heave. A change restarts the estimate.
    #[parameter(default = 0.5306, unit = "1/s", range = -1e6..=1e6)]
    pub damping: f64,
    /// Heave acceleration per pitch rate. A change restarts the estimate.
    #[parameter(default = 0.0571, unit = "m/s", range = -1e6..=1e6)]
    pub from_rate: f64,
    /// Heave acceleration per plane angle. A change restarts the estimate.
    #[parameter(default = 0.0119, unit = "m/s^2", range = -1e6..=1e6)]
    pub from_plane: f64,
}

/// The reliability requested from the signals' publishers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum Reliability {
    /// Reliable for a member of lockstep, else best effort.
    Auto,
    /// Lost messages are sent again.
    Reliable,
    /// Lost messages are not sent again.
    BestEffort,
}

/// The law of forgetting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum ForgettingKind {
    /// All past rows equally, and everything before a jump once it is detected.
    OnJump,
    /// All past rows equally.
    Constant,
    /// Only in the direction of the new row.
    Directional,
    /// Forgets as much as the prediction error requires.
    Variable,
}

/// The estimators of the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum EstimatorKind {
    /// Recursive least squares.
    RecursiveLeastSquares,
    /// Extended least squares.
    ExtendedLeastSquares,
    /// Recursive prediction error method.
    RecursivePredictionError,
    /// Recursive output error.
    RecursiveOutputError,
    /// The vehicle's equations, by an extended Kalman filter.
    Kalman,
}

impl EstimatorKind {
    /// The recursion on a difference equation; `None` for the Kalman filter.
    #[must_use]
    pub fn recursion(self) -> Option<Kind> {
        match self {
            Self::RecursiveLeastSquares => Some(Kind::LeastSquares),
            Self::ExtendedLeastSquares => Some(Kind::ExtendedLeastSquares),
            Self::RecursivePredictionError => Some(Kind::PredictionError),
            Self::RecursiveOutputError => Some(Kind::OutputError),
            Self::Kalman => None,
        }
    }
}

/// The parameters in the form that the identifier uses.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The input.
    pub input: Signal,
    /// The output.
    pub output: Signal,
    /// The flag that marks the input before an output as invalid, if it is not 0.
    pub break_on: Option<Signal>,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// With resampling, the longest interval between two outputs that is not a gap, ns.
    pub resample: Option<i64>,
    /// Delay from the first sample to the start of the estimation, ns.
    pub start: i64,
    /// The estimator.
    pub estimator: EstimatorKind,
    /// The structure of the difference equation.
    pub structure: Structure,
    /// Whether first moments are regressors.
    pub moment: bool,
    /// Options of the recursion.
    pub options: Options,
    /// Prior knowledge of the vehicle.
    pub vehicle: Vehicle,
    /// Initial state and noise of the Kalman filter.
    pub settings: Settings,
    /// Samples from one published estimate to the next.
    pub publish_every: u64,
    /// Samples before an estimate can be valid.
    pub min_samples: u64,
}

impl Config {
    /// The configuration that the parameters describe.
    ///
    /// # Errors
    /// [`Error::Parameter`], if a signal is not `TOPIC:FIELD`, input and output are the same, or more of the structure is known than
    /// exists.
    pub fn new(parameters: &IdentifierParameters) -> Result<Self, Error> {
        let p = parameters;
        let refused = |name, reason: String| Error::Parameter { name, reason };
        let signal = |name, text: &str| {
            text.parse::<Signal>()
                .map_err(|reason| refused(name, reason.to_string()))
        };
        let (input, output) = (signal("input", &p.input)?, signal("output", &p.output)?);
        for (name, message_type) in [
            ("input_type", &p.input_type),
            ("output_type", &p.output_type),
        ] {
            message_types::find(message_type)
                .map_err(|reason| refused(name, reason.to_string()))?;
        }
        if input == output {
            return Err(refused(
                "output",
                format!("{output} refused: this signal is also the input"),
            ));
        }
        let break_on = match p.break_on.as_str() {
            "" => None,
            text => Some(signal("break_on", text)?),
        };
        if p.resample && p.answer {
            return Err(refused(
                "resample",
                "true refused: a member of lockstep (answer) must use every tick, so it cannot resample"
                    .to_owned(),
            ));
        }
        let samples = (1.0 / (p.publish_rate * p.sample_time)).round();
        Ok(Self {
            input,
            output,
            break_on,
            sample_time: p.sample_time,
            resample: p.resample.then(|| (p.max_gap * 1e9).round() as i64),
            start: (p.start * 1e9).round() as i64,
            estimator: p.estimator,
            structure: structure(p)?,
            moment: p.first_moment,
            options: options(p),
            vehicle: vehicle(&p.kalman.heave),
            settings: settings(&p.kalman),
            publish_every: samples.max(1.0) as u64,
            min_samples: p.min_samples,
        })
    }

    /// Whether messages on `topic` contain a signal of the pair.
    #[must_use]
    pub fn is_on(&self, topic: &str) -> bool {
        self.input.is_on(topic) || self.output.is_on(topic)
    }

    /// This configuration with the values of `new` that can change without a restart.
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

fn structure(p: &IdentifierParameters) -> Result<Structure, Error> {
    let order = p.order;
    let mut structure = Structure::of_order(order);
    for (name, count, known) in [
        (
            "zeros_at_one",
            p.zeros_at_one,
            Structure::with_zero_at_one as fn(_) -> _,
        ),
        ("integrators", p.integrators, Structure::with_integrator),
    ] {
        if count >= order {
            let reason = format!(
                "{count} refused: the order is {order}, and at least 1 of it must stay free"
            );
            return Err(Error::Parameter { name, reason });
        }
        for _ in 0..count {
            structure = known(structure);
        }
    }
    structure.delay = p.delay;
    structure.offset = p.bias;
    Ok(structure)
}

fn options(p: &IdentifierParameters) -> Options {
    let limit = p.covariance_limit;
    Options {
        forgetting: match p.forgetting_kind {
            ForgettingKind::OnJump => Forgetting::OnJump(p.forgetting),
            ForgettingKind::Constant => Forgetting::Constant(p.forgetting),
            ForgettingKind::Directional => Forgetting::Directional(p.forgetting),
            ForgettingKind::Variable => Forgetting::Variable {
                least: p.forgetting,
                information: p.forgetting_information,
            },
        },
        initial_covariance: p.initial_covariance,
        covariance_limit: (limit > 0.0).then_some(limit),
        dead_zone: p.dead_zone,
    }
}

fn vehicle(heave: &KalmanHeave) -> Vehicle {
    let heave = Heave {
        to_pitch: heave.to_pitch,
        damping: heave.damping,
        from_rate: heave.from_rate,
        from_input: heave.from_plane,
        doubt: 0.0,
    };
    Vehicle {
        heave: (heave.to_pitch != 0.0).then_some(heave),
    }
}

fn settings(kalman: &Kalman) -> Settings {
    let Kalman {
        deviation, drift, ..
    } = kalman;
    Settings {
        parameters: [kalman.plane, kalman.damping, kalman.restoring],
        deviations: [deviation.plane, deviation.damping, deviation.restoring],
        bias_deviation: deviation.bias,
        noise: kalman.noise,
        bias_drift: drift.bias,
        drift: [drift.plane, drift.damping, drift.restoring],
        disturbance: kalman.disturbance,
        motion: deviation.motion,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Value;

    #[test]
    fn every_default_obeys_its_own_declaration_and_all_go_together() {
        for declaration in IdentifierParameters::declarations() {
            declaration.accept(declaration.default.clone()).unwrap();
        }
        let config = Config::new(&IdentifierParameters::default()).unwrap();
        assert_eq!(config.input.to_string(), "plane_motion:dive_planes");
        assert_eq!(config.structure.poles, 3);
        assert_eq!(config.publish_every, 10);
    }

    #[test]
    fn signals_that_are_none_or_the_same_are_refused_by_name() {
        for (name, value, reason) in [
            ("input", Value::from("dive_planes"), "TOPIC:FIELD"),
            (
                "output",
                "plane_motion:dive_planes".into(),
                "also the input",
            ),
            ("zeros_at_one", 3.into(), "must stay free"),
        ] {
            let parameters = IdentifierParameters::default()
                .with(&[(name, value)])
                .unwrap();
            let refusal = Config::new(&parameters).unwrap_err().to_string();
            assert!(
                refusal.contains(name) && refusal.contains(reason),
                "{refusal}"
            );
        }
    }
}
