//! The options of a fit, and their valid combinations.

use std::path::PathBuf;
use std::str::FromStr;

use planesman_identification::InitialState;
use planesman_identification::analysis::{CurveChoice, Options};
use planesman_identification::estimators::recursive::{Forgetting, Options as Recursion};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_identification::estimators::{Form, Knowledge, Method, Property};
use planesman_identification::selection::Kind;
use planesman_identification::several;
use planesman_signals::{
    Band, Clock, Method as Resampling, Outliers, SegmentChoice, TimeUnit, Trend, Unwrap,
};
use planesman_units::Dimension;

use crate::data::DataOptions;
use crate::declaration::{OptionGroup, Range, Value, choices, options};
use crate::error::FitError;
use crate::rules::{
    self, ABOVE_ZERO, BAND, COHERENCE, FORGETTING, MAX_GAP, NOT_NEGATIVE, RATE, RuleError, WINDOW,
};
use crate::steps_in_words::StepsInWords;

/// The maximum order of a model with poles.
const MAX_ORDER: usize = 20;

options! {
    /// The options of [`fit`](crate::fit).
    ///
    /// Each field is the option of the same name of `planesman sysid fit`; docs/sysid.md explains them.
    #[derive(Clone, Debug)]
    pub struct FitOptions in "Model" {
        /// The signals of some data, on one grid.
        signals: SignalOptions;
        /// Validation data, not used for the fit: a file or folder with the same signals, or a window of the data as in `window`, which is
        /// then left out of the fit [default: a model of the first 70 % is validated on the rest]
        validation: Option<Validation> = None, section: "Data", value: "DATA|FROM..TO";
        /// The estimator
        method: MethodChoice = MethodChoice::default(), of_grid: true;
        /// The model's structure.
        structure: StructureOptions;
        /// Known values of the vehicle.
        vehicle: VehicleOptions;
        /// Settings of the recursive methods.
        recursion: RecursionOptions;
        /// Also compute 95 % intervals of poles and gain by a bootstrap: fit this many records simulated with the model and its residuals
        bootstrap: Option<usize> = None, value: "RECORDS", range: Range::Count(100..=100_000), of_one: true;
        /// Static curve before the dynamics (Hammerstein) or after them (Wiener)
        curve: CurveChoice = CurveChoice::default(), of_one: true;
    }
}

options! {
    /// Signals of some data, on one grid.
    #[derive(Clone, Debug)]
    pub struct SignalOptions in "Signals" {
        /// The data.
        data: DataOptions;
        /// The input: `TOPIC:FIELD`, a column, or an unrecorded input in words: `12V from 0.1s`.
        input: String;
        /// The output.
        output: String;
        /// Further inputs, each recorded. The model then has several inputs ([`fit_several`](crate::fit_several)).
        other_inputs: Vec<String>;
        /// Further outputs.
        other_outputs: Vec<String>;
        /// Reference (setpoint) of the control loop, for closed-loop data: the model is then fitted in two stages
        reference: Option<String> = None, value: "SIGNAL", short: Some('r'), of_one: true;
        /// The grid.
        grid: GridOptions;
        /// Preparation of the record.
        preparation: PreparationOptions;
    }
}

/// Each front end takes the names of signals as arguments.
impl OptionGroup for String {}
impl OptionGroup for Vec<String> {}

options! {
    /// Resampling of the data to a grid.
    #[derive(Clone, Debug)]
    pub struct GridOptions in "Grid" {
        /// Sampling rate of the grid (Hz) [default: the rate of the slowest output]
        rate: Option<f64> = None, value: "HZ", range: Range::Number(RATE), of_grid: true;
        /// Use only data between these times, in seconds from the first output's first sample; each window is a separate run of the same model
        window: Vec<(f64, f64)> = Vec::new(), value: "FROM..TO", range: Range::Span(WINDOW);
        /// Resampling of inputs
        input_method: Resampling = Resampling::Mean;
        /// Resampling of outputs
        output_method: Resampling = Resampling::Linear;
        /// Longest interval between two samples that is not a gap (s) [default: five sample intervals; no limit for a held input]
        max_gap: Option<f64> = None, value: "SECONDS", range: Range::Number(MAX_GAP);
        /// Angles and counters that wrap: unwrap if the jumps clearly come from wrapping (default), with this period, or not at all
        unwrap: Unwrap = Unwrap::Automatic, value: "360|2pi|65536|no";
    }
}

options! {
    /// Preparation of a record before a model is fitted.
    #[derive(Clone, Copy, Debug)]
    pub struct PreparationOptions in "Preparation" {
        /// Outliers: samples far from the median of their neighbours
        outliers: Outliers = Outliers::default();
        /// Frequency band to keep in every signal: LOW..HIGH, LOW.. to remove drift, or ..HIGH to remove noise (Hz) [default: all]
        prefilter: Option<Band> = None, value: "LOW..HIGH", range: Range::Span(BAND), of_grid: true;
        /// Part of the data to use
        segment: SegmentChoice = SegmentChoice::default(), of_grid: true;
        /// Mean or trend to subtract from each signal
        detrend: Trend = Trend::default(), of_grid: true;
    }
}

/// Data for validation.
#[derive(Clone, Debug)]
pub enum Validation {
    /// A separate file or folder.
    Data(PathBuf),
    /// Between two times of the same data, s.
    Window(f64, f64),
}

impl FromStr for Validation {
    type Err = RuleError;

    /// An existing file or folder, else a window.
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

/// The requested method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodChoice {
    /// One.
    One(Method),
    /// All methods, compared with each other.
    All,
}

impl Default for MethodChoice {
    fn default() -> Self {
        Self::One(Method::default())
    }
}

impl MethodChoice {
    /// Every method, and the choice of all.
    pub const ALL: [Self; Method::ALL.len() + 1] = {
        let mut all = [Self::All; Method::ALL.len() + 1];
        let mut i = 0;
        while i < Method::ALL.len() {
            all[i] = Self::One(Method::ALL[i]);
            i += 1;
        }
        all
    };

    /// The name with its line of help.
    #[must_use]
    pub fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::One(method) => method.described(),
            Self::All => (
                "all",
                "Compare all methods; the method that simulates held-out data best is printed and written",
            ),
        }
    }

    /// The names of the method in other software.
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

choices! {
    Clock, |_| &[];
    TimeUnit, |_| &[];
    Resampling, |_| &[];
    Outliers, |_| &[];
    SegmentChoice, |_| &[];
    Trend, |_| &[];
    Form, |_| &[];
    CurveChoice, |_| &[];
    MethodChoice, Self::also_known;
}

impl Value for Validation {
    const PYTHON: &'static str = "Path | Span";

    fn read(text: &str, _: &Range) -> Result<Self, RuleError> {
        text.parse()
    }

    fn written(&self) -> String {
        match self {
            Self::Data(path) => path.display().to_string(),
            Self::Window(from, to) => (*from, *to).written(),
        }
    }

    /// Only reading the data checks that a file or folder exists.
    fn check(&self, _: &Range) -> Result<(), RuleError> {
        match self {
            Self::Data(_) => Ok(()),
            Self::Window(from, to) => Value::check(&(*from, *to), &Range::Span(WINDOW)),
        }
    }
}

impl Value for Unwrap {
    const PYTHON: &'static str = "Literal[\"automatic\", \"2pi\", \"no\"] | float";

    fn read(text: &str, _: &Range) -> Result<Self, RuleError> {
        rules::unwrap(text)
    }

    fn written(&self) -> String {
        self.to_string()
    }
}

impl Value for [f64; 4] {
    const PYTHON: &'static str = "Sequence[float]";

    fn read(text: &str, _: &Range) -> Result<Self, RuleError> {
        rules::heave(text)
    }

    fn written(&self) -> String {
        self.map(|it| it.to_string()).join(",")
    }
}

impl Value for KnownVehicle {
    const PYTHON: &'static str = "str";
    const HYPHEN: bool = false;

    fn read(text: &str, _: &Range) -> Result<Self, RuleError> {
        Ok(Self {
            name: text.to_owned(),
            heave: None,
        })
    }

    fn written(&self) -> String {
        self.name.clone()
    }
}

options! {
    /// The model's structure.
    #[derive(Clone, Copy, Debug)]
    pub struct StructureOptions in "Model" {
        /// Order of the model (of its denominator), without known poles; 0 for a static gain; for fir the number of coefficients [default:
        /// searched from 1 to 10; from 1 to 4 with a named method; up to 64 for fir]
        order: Option<usize> = None, range: Range::Count(0..=64), alias: Some("denominator-order");
        /// Form of a process model, for `method process` [default: chosen by the Bayesian criterion]
        process: Option<Form> = None, value: "FORM", of_one: true;
        /// For `method frf`: the lowest coherence of input and output in the band of the fit [default: 0.6]
        coherence: Option<f64> = None, value: "SHARE", range: Range::Number(COHERENCE), of_grid: true;
        /// Coefficients of the numerator, without known zeros [default: the same number as the order]
        numerator: Option<usize> = None, value: "COUNT", range: Range::Count(1..=40), needs: Some("order");
        /// Delay in samples from the input to its first effect; 0 if the output is measured after the input of the same sample [default:
        /// searched from 0 to 1000; with a named method 1 to 3, or 1 with `order`]
        delay: Option<usize> = None, range: Range::Count(0..=1000);
        /// Number of zeros known to be at z = 1
        zeros_at_one: usize = 0, range: Range::Count(0..=4), of_one: true;
        /// Number of poles known to be at z = 1
        integrators: usize = 0, range: Range::Count(0..=4), of_one: true;
        /// The output has no offset
        no_offset: bool = false;
        /// The data begins at rest [default: the initial state is estimated]
        at_rest: bool = false;
        /// Input and output are zero before each segment (the thesis' start): zeros are inserted before it
        prewindow: bool = false, needs: Some("order"), of_one: true;
        /// Each segment has its own numerator; only the poles are common
        own_numerators: bool = false, of_one: true;
    }
}

impl StructureOptions {
    /// Number of zeros to insert before each segment: as far back as a row of the difference equation reaches.
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
    /// A built-in vehicle or a vehicle file.
    pub name: String,
    /// Heave coefficients at `speed` from `planesman_vehicle::heave::heave_of`; `None` without a speed.
    pub heave: Option<[f64; 4]>,
}

options! {
    /// Known values of the vehicle.
    #[derive(Clone, Debug)]
    pub struct VehicleOptions in "Vehicle" {
        /// For vehicle and kalman, the coefficients of heave in q_dot = K/J u - B/J q - M_theta/J theta + NU w, w_dot = EPSILON u + ETA q -
        /// ZETA w, with w in the output's unit times m [default: no heave]
        heave: Option<[f64; 4]> = None, value: "NU,ZETA,ETA,EPSILON", of_one: true;
        /// Take the heave coefficients from a built-in vehicle or a vehicle file, at `speed`: for planes in rad, a rate in rad/s
        vehicle: Option<KnownVehicle> = None, value: "NAME|FILE", needs: Some("speed"), excludes: Some("heave"), of_one: true;
        /// Standard deviation of the heave coefficients, in % of each
        heave_doubt: f64 = 0.0, value: "PERCENT", range: Range::Number(NOT_NEGATIVE);
        /// The vehicle's speed (m/s, or with its unit: 1ft/s), for `vehicle` and the model file
        speed: Option<f64> = None, range: Range::Quantity(Dimension::Speed, 1e-3, 100.0), of_one: true;
        /// Moment of inertia J; if given, K, B and M_theta are printed
        inertia: Option<f64> = None, range: Range::Number(ABOVE_ZERO), of_one: true;
        /// For kalman: standard deviation of the noise, output unit [default: from second differences]
        noise: Option<f64> = None, range: Range::Number(ABOVE_ZERO), of_one: true;
        /// For kalman: standard deviation of the sensor's bias drift in one second, output unit
        bias_drift: f64 = 0.0, range: Range::Number(NOT_NEGATIVE);
        /// For kalman: standard deviation of the output's change by disturbances in one second, output unit
        disturbance: f64 = 0.0, range: Range::Number(NOT_NEGATIVE);
    }
}

impl VehicleOptions {
    /// Looks up the coefficients of the known vehicle by its name and the speed, m/s.
    ///
    /// # Errors
    /// Errors of `heave_of`.
    pub fn look_up<E>(
        &mut self,
        heave_of: impl FnOnce(&str, f64) -> Result<[f64; 4], E>,
    ) -> Result<(), E> {
        if let (Some(vehicle), Some(speed)) = (&mut self.vehicle, self.speed) {
            vehicle.heave = Some(heave_of(&vehicle.name, speed)?);
        }
        Ok(())
    }
}

options! {
    /// Settings of the recursive methods.
    #[derive(Clone, Copy, Debug)]
    pub struct RecursionOptions in "Recursive methods" {
        /// For recursive methods: forgetting factor per sample (1: no forgetting; 0.98: a memory of about 50 samples) [default: 1]
        forgetting: Option<f64> = None, value: "LAMBDA", range: Range::Number(FORGETTING), of_one: true;
        /// For recursive methods: initial covariance of each parameter [default: 1e8]
        initial_covariance: Option<f64> = None, value: "P0", range: Range::Number(ABOVE_ZERO), of_one: true;
    }
}

impl RecursionOptions {
    fn options(&self, asked: MethodChoice) -> Result<Recursion, FitError> {
        let given = self.forgetting.or(self.initial_covariance);
        match asked {
            MethodChoice::One(method) if given.is_some() && !method.has(Property::IsRecursive) => {
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

impl AsMut<SignalOptions> for SignalOptions {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

impl AsMut<SignalOptions> for FitOptions {
    fn as_mut(&mut self) -> &mut SignalOptions {
        &mut self.signals
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

    /// Checks that no signal is given twice.
    fn check_names(&self) -> Result<(), FitError> {
        for names in [self.inputs(), self.outputs()] {
            let twice = |(at, name): (usize, &String)| names[..at].contains(name);
            if let Some((_, name)) = names.iter().enumerate().find(|it| twice(*it)) {
                return Err(FitError::Twice(name.clone()));
            }
        }
        Ok(())
    }

    /// Checks each value.
    pub(crate) fn check(&self) -> Result<(), FitError> {
        self.check_names()?;
        self.check_values()
    }
}

impl FitOptions {
    /// Checks each value.
    pub(crate) fn check(&self) -> Result<(), FitError> {
        self.signals.check_names()?;
        self.check_values()
    }

    /// Whether the output is at rest before the record: because of the option, or because an input in words begins at rest.
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
        if is_asked && (!method.has(Property::TakesCurve) || self.signals.reference.is_some()) {
            return Err(FitError::NoCurve);
        }
        let has_no_poles = method.has(Property::HasNoPoles);
        if has_no_poles && structure.numerator.is_some() && is_alone {
            return Err(FitError::NumeratorOfFir);
        }
        if structure.order == Some(0) && !method.has(Property::FitsGain) && is_alone {
            return Err(FitError::NoStatic(method));
        }
        if structure.order.is_some_and(|order| order > MAX_ORDER) && !has_no_poles {
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
                length: structure.order.filter(|_| has_no_poles && is_alone),
                recursion: self.recursion.options(self.method)?,
            },
            order: structure.order.filter(|_| !has_no_poles),
            numerator: structure.numerator.filter(|_| !has_no_poles),
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

    /// The first given option that applies only to a sampled model with one input and one output.
    pub(crate) fn given_of_one(&self) -> Option<&'static str> {
        let given = self.given();
        given.iter().find(|it| it.of_one).map(|it| it.name)
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

    /// The methods to try; the methods for the vehicle's equations only if the vehicle is known.
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
                "method vehicle or kalman",
            ),
            (
                &|it| it.vehicle.heave = Some([f64::NAN; 4]),
                "'NaN' is not finite",
            ),
            (
                &|it| it.structure.order = Some(65),
                "'65' for 'order': 65 is not in 0..=64",
            ),
            (
                &|it| it.structure.order = Some(21),
                "order may be at most 20",
            ),
            (
                &|it| it.recursion.forgetting = Some(0.9),
                "only to recursive methods",
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
