//! The options of a fit, and which of them go together.

use std::path::PathBuf;
use std::str::FromStr;

use planesman_identification::InitialState;
use planesman_identification::analysis::{CurveChoice, Options};
use planesman_identification::estimators::recursive::{Forgetting, Options as Recursion};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_identification::estimators::{Form, Knowledge, Method};
use planesman_identification::selection::Kind;
use planesman_identification::several;
use planesman_signals::{
    Band, Clock, Method as Resampling, Outliers, SegmentChoice, TimeUnit, Trend, Unwrap,
};

use crate::data::DataOptions;
use crate::error::FitError;
use crate::rules::{
    ABOVE_ZERO, AT_ONE, BAND, BOOTSTRAP, COHERENCE, DELAY, FINITE, FORGETTING, MAX_GAP,
    NOT_NEGATIVE, NUMERATOR, ORDER, RATE, RuleError, SPEED, WINDOW, count, number, span, together,
};
use crate::steps_in_words::StepsInWords;

/// The largest order of a model with poles.
const MAX_ORDER: usize = 20;

/// The options of [`fit`](crate::fit).
///
/// Each is the option of that name of `planesman sysid fit`; docs/sysid.md says more.
#[derive(Clone, Debug, Default)]
pub struct FitOptions {
    /// The signals of some data, on one grid.
    pub signals: SignalOptions,
    /// Data to judge the model on, of which nothing is fitted; `None` for the last three tenths of the record.
    pub validation: Option<Validation>,
    /// The estimator.
    pub method: MethodChoice,
    /// The model's structure.
    pub structure: StructureOptions,
    /// Known values of the vehicle.
    pub vehicle: VehicleOptions,
    /// How the recursive methods learn.
    pub recursion: RecursionOptions,
    /// Simulated records of a bootstrap for 95 % intervals of poles and gain, 100 to 100,000; `None` for none.
    pub bootstrap: Option<usize>,
    /// The static curve in front of the dynamics or behind them.
    pub curve: CurveChoice,
}

/// Signals of some data, on one grid.
#[derive(Clone, Debug, Default)]
pub struct SignalOptions {
    /// The data.
    pub data: DataOptions,
    /// The input: `TOPIC:FIELD`, a column, or one that was not recorded in words: `12V from 0.1s`.
    pub input: String,
    /// The output.
    pub output: String,
    /// Further inputs, each recorded: the model is then one of several inputs ([`fit_several`](crate::fit_several)).
    pub other_inputs: Vec<String>,
    /// Further outputs.
    pub other_outputs: Vec<String>,
    /// The reference (setpoint) of the control loop, for closed-loop data: the model is then fitted in two stages.
    pub reference: Option<String>,
    /// The grid.
    pub grid: GridOptions,
    /// How the record is prepared.
    pub preparation: PreparationOptions,
}

/// How samples are put on a grid.
#[derive(Clone, Debug)]
pub struct GridOptions {
    /// Sampling rate, Hz; `None` for that of the slowest output.
    pub rate: Option<f64>,
    /// The times that are used, in seconds from the first output's first sample, infinite where open; several are runs of one
    /// model, none is all.
    pub window: Vec<(f64, f64)>,
    /// Resampling of inputs.
    pub input_method: Resampling,
    /// Resampling of outputs.
    pub output_method: Resampling,
    /// The longest interval between two samples that is not a gap, s; `None` for five sample intervals, and for none of a held
    /// input.
    pub max_gap: Option<f64>,
    /// What becomes of angles and counters that wrap.
    pub unwrap: Unwrap,
}

impl Default for GridOptions {
    fn default() -> Self {
        Self {
            rate: None,
            window: Vec::new(),
            input_method: Resampling::Mean,
            output_method: Resampling::Linear,
            max_gap: None,
            unwrap: Unwrap::Automatic,
        }
    }
}

/// How a record is prepared before a model is fitted.
#[derive(Clone, Copy, Debug, Default)]
pub struct PreparationOptions {
    /// What becomes of samples far from the median of those around them.
    pub outliers: Outliers,
    /// The band of frequencies that is used, of every signal, Hz; 0 or infinity for an open edge.
    pub prefilter: Option<Band>,
    /// Which data is used.
    pub segment: SegmentChoice,
    /// What is subtracted from each signal.
    pub detrend: Trend,
}

/// Data to judge a model on.
#[derive(Clone, Debug)]
pub enum Validation {
    /// A file or folder of its own.
    Data(PathBuf),
    /// Between two times, s, of the data given.
    Window(f64, f64),
}

impl FromStr for Validation {
    type Err = RuleError;

    /// A file or folder that is there, else a window.
    fn from_str(text: &str) -> Result<Self, RuleError> {
        let path = PathBuf::from(text);
        if path.exists() {
            return Ok(Self::Data(path));
        }
        match WINDOW.parse(text) {
            Ok((from, to)) => Ok(Self::Window(from, to)),
            Err(rule) if text.contains("..") && !text.contains('/') => Err(rule),
            Err(_) => Err(RuleError::NoValidation(text.to_owned())),
        }
    }
}

/// The method that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodChoice {
    /// One.
    One(Method),
    /// Each of them, beside the others.
    All,
}

impl Default for MethodChoice {
    fn default() -> Self {
        Self::One(Method::default())
    }
}

impl MethodChoice {
    /// Every method, and all of them.
    pub const ALL: [Self; Method::ALL.len() + 1] = {
        let mut all = [Self::All; Method::ALL.len() + 1];
        let mut i = 0;
        while i < Method::ALL.len() {
            all[i] = Self::One(Method::ALL[i]);
            i += 1;
        }
        all
    };

    /// Its name and its help line.
    #[must_use]
    pub fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::One(method) => method.described(),
            Self::All => (
                "all",
                "Every method beside the others; the one that simulates held-out data best is printed and written",
            ),
        }
    }

    /// The names by which it is known elsewhere.
    #[must_use]
    pub fn also_known(self) -> &'static [&'static str] {
        let Self::One(method) = self else {
            return &[];
        };
        match method {
            Method::OutputError => &["oe"],
            Method::BoxJenkins => &["bj"],
            Method::LeastSquares => &["arx"],
            Method::N4sid => &["subspace"],
            Method::Frf => &["spa", "frequency"],
            Method::RecursiveLeastSquares => &["rls", "rarx"],
            Method::ExtendedLeastSquares => &["els"],
            Method::RecursivePredictionError => &["rpem", "rml"],
            Method::RecursiveOutputError => &["roe"],
            _ => &[],
        }
    }
}

/// Every option of a fit by its name, with its words where it takes one of several.
#[must_use]
pub fn options() -> Vec<(&'static str, Vec<&'static str>)> {
    const OTHERS: [&str; 33] = [
        "input",
        "output",
        "reference",
        "time",
        "sample_time",
        "most_unpacked",
        "prefilter",
        "rate",
        "window",
        "max_gap",
        "unwrap",
        "validation",
        "order",
        "coherence",
        "numerator",
        "delay",
        "zeros_at_one",
        "integrators",
        "no_offset",
        "at_rest",
        "prewindow",
        "own_numerators",
        "heave",
        "vehicle",
        "heave_doubt",
        "speed",
        "inertia",
        "noise",
        "bias_drift",
        "disturbance",
        "bootstrap",
        "forgetting",
        "initial_covariance",
    ];
    fn words<T: Copy>(
        all: &[T],
        described: fn(T) -> (&'static str, &'static str),
    ) -> Vec<&'static str> {
        all.iter().map(|it| described(*it).0).collect()
    }
    let mut options: Vec<_> = OTHERS.map(|name| (name, Vec::new())).into();
    options.extend([
        ("stamp", words(&Clock::ALL, Clock::described)),
        ("time_unit", words(&TimeUnit::ALL, TimeUnit::described)),
        ("outliers", words(&Outliers::ALL, Outliers::described)),
        (
            "segment",
            words(&SegmentChoice::ALL, SegmentChoice::described),
        ),
        ("detrend", words(&Trend::ALL, Trend::described)),
        (
            "input_method",
            words(&Resampling::ALL, Resampling::described),
        ),
        (
            "output_method",
            words(&Resampling::ALL, Resampling::described),
        ),
        ("method", words(&MethodChoice::ALL, MethodChoice::described)),
        ("process", words(&Form::ALL, Form::described)),
        ("curve", words(&CurveChoice::ALL, CurveChoice::described)),
    ]);
    options
}

/// The model's structure.
#[derive(Clone, Copy, Debug, Default)]
pub struct StructureOptions {
    /// The order, known poles not counted, 0 for a static gain; for a finite impulse response the number of its coefficients. `None` to search it.
    pub order: Option<usize>,
    /// The form of a process model; `None` for a criterion to choose.
    pub process: Option<Form>,
    /// For the frequency domain, the least coherence that a transfer function is fitted by, 0 to 1; `None` for 0.6.
    pub coherence: Option<f64>,
    /// Coefficients of the numerator, known zeros not counted; `None` for as many as the order.
    pub numerator: Option<usize>,
    /// Samples from the input to its first effect; `None` to search it.
    pub delay: Option<usize>,
    /// Zeros known to be at z = 1.
    pub zeros_at_one: usize,
    /// Poles known to be at z = 1.
    pub integrators: usize,
    /// The output has no offset.
    pub no_offset: bool,
    /// The data begins at rest; else the initial state is estimated.
    pub at_rest: bool,
    /// Input and output are zero before each segment (the thesis' start): zeros are put in front of it.
    pub prewindow: bool,
    /// Each segment has its own numerator; only the poles are common.
    pub own_numerators: bool,
}

impl StructureOptions {
    /// Zeros that go in front of each segment, as many as a row of the difference equation looks back.
    pub(crate) fn zeros_in_front(&self) -> usize {
        match self.order.filter(|_| self.prewindow) {
            None => 0,
            Some(order) => {
                let numerator = self.numerator.unwrap_or(order).max(1);
                let inputs = self.delay.unwrap_or(1) + numerator + self.zeros_at_one;
                inputs.saturating_sub(1).max(order + self.integrators)
            }
        }
    }

    fn is_given(&self) -> bool {
        self.order.is_some()
            || self.numerator.is_some()
            || self.delay.is_some()
            || self.zeros_at_one + self.integrators > 0
            || self.own_numerators
    }
}

/// A vehicle whose equations are known.
#[derive(Clone, Debug, Default)]
pub struct KnownVehicle {
    /// Its coefficients of heave at `speed`, as `planesman_vehicle::heave::heave_of` has them; `None` where no speed was given.
    pub heave: Option<[f64; 4]>,
}

/// Known values of the vehicle.
#[derive(Clone, Debug, Default)]
pub struct VehicleOptions {
    /// For the methods vehicle and kalman: nu, zeta, eta and epsilon of `q_dot = K/J u - B/J q - M_theta/J theta + nu w`,
    /// `w_dot = epsilon u + eta q - zeta w`, with w in the output's unit times m.
    pub heave: Option<[f64; 4]>,
    /// The same of a known vehicle at `speed`: for planes in rad, a rate in rad/s.
    pub vehicle: Option<KnownVehicle>,
    /// Standard deviation of the heave coefficients, % of each.
    pub heave_doubt: f64,
    /// The vehicle's speed, m/s, for `vehicle` and the model file.
    pub speed: Option<f64>,
    /// Moment of inertia J: turns K/J into K.
    pub inertia: Option<f64>,
    /// For kalman: standard deviation of the noise, output unit; `None` for that of second differences.
    pub noise: Option<f64>,
    /// For kalman: standard deviation of the sensor's bias drift in one second, output unit.
    pub bias_drift: f64,
    /// For kalman: standard deviation of the output's change by disturbances in one second, output unit.
    pub disturbance: f64,
}

/// How the recursive methods learn.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecursionOptions {
    /// Forgetting factor per sample; `None` for 1, none.
    pub forgetting: Option<f64>,
    /// Initial covariance of each parameter; `None` for 1e8.
    pub initial_covariance: Option<f64>,
}

impl RecursionOptions {
    fn options(&self, asked: MethodChoice) -> Result<Recursion, FitError> {
        let given = self.forgetting.or(self.initial_covariance);
        match asked {
            MethodChoice::One(method) if given.is_some() && !method.is_recursive() => {
                return Err(FitError::NotRecursive(method));
            }
            _ => {}
        }
        let defaults = Recursion::default();
        Ok(Recursion {
            forgetting: self
                .forgetting
                .map_or(defaults.forgetting, Forgetting::Constant),
            initial_covariance: self
                .initial_covariance
                .unwrap_or(defaults.initial_covariance),
            ..defaults
        })
    }
}

impl SignalOptions {
    /// Whether there are several inputs or outputs.
    #[must_use]
    pub fn are_several(&self) -> bool {
        !self.other_inputs.is_empty() || !self.other_outputs.is_empty()
    }

    /// Every input.
    pub(crate) fn inputs(&self) -> Vec<String> {
        let all = std::iter::once(&self.input).chain(&self.other_inputs);
        all.cloned().collect()
    }

    /// Every output.
    pub(crate) fn outputs(&self) -> Vec<String> {
        let all = std::iter::once(&self.output).chain(&self.other_outputs);
        all.cloned().collect()
    }

    /// Checks grid and preparation.
    pub(crate) fn check(&self) -> Result<(), FitError> {
        for names in [self.inputs(), self.outputs()] {
            let twice = |(at, name): (usize, &String)| names[..at].contains(name);
            if let Some((_, name)) = names.iter().enumerate().find(|it| twice(*it)) {
                return Err(FitError::Twice(name.clone()));
            }
        }
        let grid = &self.grid;
        number("rate", grid.rate, &RATE)?;
        number("max_gap", grid.max_gap, &MAX_GAP)?;
        for window in &grid.window {
            span("window", *window, &WINDOW)?;
        }
        let band = self.preparation.prefilter;
        band.map_or(Ok(()), |band| span("prefilter", band, &BAND))
    }
}

impl FitOptions {
    /// Checks each value.
    pub(crate) fn check(&self) -> Result<(), FitError> {
        self.signals.check()?;
        let (structure, vehicle) = (&self.structure, &self.vehicle);
        if let Some(Validation::Window(from, to)) = self.validation {
            span("validation", (from, to), &WINDOW)?;
        }
        for (option, value, range) in [
            ("order", structure.order, ORDER),
            ("numerator", structure.numerator, NUMERATOR),
            ("delay", structure.delay, DELAY),
            ("zeros_at_one", Some(structure.zeros_at_one), AT_ONE),
            ("integrators", Some(structure.integrators), AT_ONE),
            ("bootstrap", self.bootstrap, BOOTSTRAP),
        ] {
            count(option, value, &range)?;
        }
        let covariance = self.recursion.initial_covariance;
        for (option, value, rule) in [
            ("heave_doubt", Some(vehicle.heave_doubt), NOT_NEGATIVE),
            ("speed", vehicle.speed, SPEED),
            ("inertia", vehicle.inertia, ABOVE_ZERO),
            ("noise", vehicle.noise, ABOVE_ZERO),
            ("bias_drift", Some(vehicle.bias_drift), NOT_NEGATIVE),
            ("disturbance", Some(vehicle.disturbance), NOT_NEGATIVE),
            ("coherence", structure.coherence, COHERENCE),
            ("forgetting", self.recursion.forgetting, FORGETTING),
            ("initial_covariance", covariance, ABOVE_ZERO),
        ] {
            number(option, value, &rule)?;
        }
        for coefficient in vehicle.heave.into_iter().flatten() {
            number("heave", Some(coefficient), &FINITE)?;
        }
        together(|option| match option {
            "order" => structure.order.is_some(),
            "numerator" => structure.numerator.is_some(),
            "prewindow" => structure.prewindow,
            "vehicle" => vehicle.vehicle.is_some(),
            "heave" => vehicle.heave.is_some(),
            "speed" => vehicle.speed.is_some(),
            _ => false,
        })
    }

    /// Whether the output is at rest before the record: as it is said, or where an input in words begins with it.
    pub(crate) fn is_at_rest(&self) -> bool {
        let in_words = StepsInWords::read(&self.signals.input);
        let begins = matches!(in_words, Some(Ok(steps)) if steps.is_from_rest());
        self.structure.at_rest || begins
    }

    /// The options of the analysis by a method.
    pub(crate) fn analysis(&self, method: Method) -> Result<Options, FitError> {
        let (structure, vehicle) = (&self.structure, &self.vehicle);
        let is_alone = self.method != MethodChoice::All;
        let of_vehicle = vehicle.vehicle.as_ref().and_then(|it| it.heave);
        let coefficients = vehicle.heave.or(of_vehicle);
        if method.is_of_the_vehicle() {
            if structure.is_given() {
                return Err(FitError::StructureOfVehicle(method));
            }
        } else if coefficients.is_some() && is_alone {
            return Err(FitError::NoVehicle);
        }
        if method == Method::Process && structure.is_given() {
            return Err(FitError::StructureOfProcess);
        }
        if method != Method::Process && structure.process.is_some() && is_alone {
            return Err(FitError::NotProcess(method));
        }
        if method != Method::Frf && structure.coherence.is_some() && is_alone {
            return Err(FitError::NotFrequency(method));
        }
        if method == Method::Frf && structure.own_numerators && is_alone {
            return Err(FitError::OneResponse);
        }
        let is_asked = ![CurveChoice::Automatic, CurveChoice::None].contains(&self.curve);
        let takes_curve = matches!(
            method,
            Method::Automatic
                | Method::OutputError
                | Method::BoxJenkins
                | Method::LeastSquares
                | Method::Armax
                | Method::N4sid
        );
        if is_asked && (!takes_curve || self.signals.reference.is_some()) {
            return Err(FitError::NoCurve);
        }
        let is_fir = method == Method::Fir;
        if is_fir && structure.numerator.is_some() && is_alone {
            return Err(FitError::NumeratorOfFir);
        }
        let has_none = matches!(method, Method::Fir | Method::N4sid | Method::Frf);
        if structure.order == Some(0) && has_none && is_alone {
            return Err(FitError::NoStatic(method));
        }
        if structure.order.is_some_and(|order| order > MAX_ORDER) && !is_fir {
            return Err(FitError::Order(MAX_ORDER));
        }
        let heave = coefficients.map(|[to_pitch, damping, from_rate, from_input]| Heave {
            to_pitch,
            damping,
            from_rate,
            from_input,
            doubt: vehicle.heave_doubt / 100.0,
        });
        Ok(Options {
            method,
            knowledge: Knowledge {
                vehicle: Vehicle { heave },
                noise: vehicle.noise,
                bias_drift: vehicle.bias_drift,
                disturbance: vehicle.disturbance,
                process: structure.process,
                coherence: structure.coherence,
                // Beside other methods the criterion chooses: an order is none of coefficients.
                length: structure.order.filter(|_| is_fir && is_alone),
                recursion: self.recursion.options(self.method)?,
            },
            order: structure.order.filter(|_| !is_fir),
            numerator: structure.numerator.filter(|_| !is_fir),
            delay: structure.delay,
            zeros_at_one: structure.zeros_at_one,
            integrators: structure.integrators,
            offset: !structure.no_offset,
            start: if self.is_at_rest() || structure.prewindow {
                InitialState::Rest
            } else {
                InitialState::Estimated
            },
            own_numerators: structure.own_numerators,
            inertia: vehicle.inertia,
            speed: vehicle.speed,
            bootstrap: self.bootstrap,
            curve: self.curve,
        })
    }

    /// The first option that is given of those that only a sampled model of one input and output has.
    pub(crate) fn given_of_one(&self) -> Option<&'static str> {
        let (structure, vehicle) = (&self.structure, &self.vehicle);
        let recursion = &self.recursion;
        let of_one = [
            ("reference", self.signals.reference.is_some()),
            ("process", structure.process.is_some()),
            ("zeros_at_one", structure.zeros_at_one > 0),
            ("integrators", structure.integrators > 0),
            ("prewindow", structure.prewindow),
            ("own_numerators", structure.own_numerators),
            ("heave", vehicle.heave.is_some()),
            ("vehicle", vehicle.vehicle.is_some()),
            ("speed", vehicle.speed.is_some()),
            ("inertia", vehicle.inertia.is_some()),
            ("noise", vehicle.noise.is_some()),
            ("bootstrap", self.bootstrap.is_some()),
            ("curve", self.curve != CurveChoice::default()),
            ("forgetting", recursion.forgetting.is_some()),
            ("initial_covariance", recursion.initial_covariance.is_some()),
        ];
        of_one
            .into_iter()
            .find_map(|(option, given)| given.then_some(option))
    }

    /// The options of the analysis of several inputs or outputs.
    pub(crate) fn of_several(&self) -> Result<several::Options, FitError> {
        let structure = &self.structure;
        let kind = match self.method {
            MethodChoice::One(Method::Automatic) => None,
            MethodChoice::One(Method::OutputError) => Some(Kind::OutputError),
            MethodChoice::One(Method::BoxJenkins) => Some(Kind::BoxJenkins),
            _ => return Err(FitError::MethodOfSeveral(self.method.described().0)),
        };
        let numerator = structure.numerator.map(|_| "numerator");
        if let Some(option) = self.given_of_one().or(numerator) {
            return Err(FitError::OfOne(option));
        }
        if structure.order.is_some_and(|order| order > MAX_ORDER) {
            return Err(FitError::Order(MAX_ORDER));
        }
        Ok(several::Options {
            order: structure.order,
            delay: structure.delay,
            kind,
            offset: !structure.no_offset,
            start: match self.is_at_rest() {
                true => InitialState::Rest,
                false => InitialState::Estimated,
            },
        })
    }

    /// The methods of the vehicle's equations are tried only with what is known of it.
    pub(crate) fn tried(&self) -> Vec<Method> {
        let of_vehicle = self.vehicle.heave.is_some() || self.vehicle.vehicle.is_some();
        let methods = Method::ALL.into_iter();
        methods
            .filter(|method| of_vehicle || !method.is_of_the_vehicle())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_do_not_go_together_are_refused_before_data_is_read() {
        let refusal = |change: &dyn Fn(&mut FitOptions)| {
            let mut options = FitOptions {
                method: MethodChoice::One(Method::LeastSquares),
                ..FitOptions::default()
            };
            options.signals.data = DataOptions::files(["/no/such/bag"]);
            change(&mut options);
            crate::fit(&options, &()).expect_err("refused").to_string()
        };
        let unread = refusal(&|_| ());
        assert!(unread.contains("/no/such/bag"), "{unread}");
        type Case<'a> = (&'a dyn Fn(&mut FitOptions), &'a str);
        let cases: [Case<'_>; 12] = [
            (
                &|it| it.structure.numerator = Some(2),
                "numerator needs order",
            ),
            (&|it| it.structure.prewindow = true, "prewindow needs order"),
            (
                &|it| it.vehicle.vehicle = Some(KnownVehicle::default()),
                "vehicle needs speed",
            ),
            (
                &|it| {
                    it.vehicle.vehicle = Some(KnownVehicle::default());
                    it.vehicle.speed = Some(0.3);
                    it.vehicle.heave = Some([1.0; 4]);
                },
                "vehicle excludes heave",
            ),
            (
                &|it| it.vehicle.heave = Some([1.0; 4]),
                "method vehicle and kalman",
            ),
            (
                &|it| it.vehicle.heave = Some([f64::NAN; 4]),
                "'NaN' is not finite",
            ),
            (
                &|it| it.structure.order = Some(65),
                "'65' for 'order': 65 is not in 0..=64",
            ),
            (&|it| it.structure.order = Some(21), "order: 20 at most"),
            (
                &|it| it.recursion.forgetting = Some(0.9),
                "for the recursive methods",
            ),
            (
                &|it| it.signals.grid.window = vec![(6.0, 5.0)],
                "'6..5' is reversed; write 5..6",
            ),
            (
                &|it| it.signals.preparation.prefilter = Some((0.0, f64::INFINITY)),
                "is not a band",
            ),
            (
                &|it| {
                    it.signals.grid.window = vec![(0.0, 20.0)];
                    it.validation = Some(Validation::Window(10.0, 30.0));
                },
                "window 0..20 overlaps validation 10..30",
            ),
        ];
        for (change, said) in cases {
            let refusal = refusal(change);
            assert!(refusal.contains(said), "{said}: {refusal}");
        }
    }
}
