#![doc = include_str!("../README.md")]
//!
//! ```text
//! num   b1 z^(n-1) + ... + bn
//! --- = -------------------------      one number per power of z, the highest first
//! den   z^n + a1 z^(n-1) + ... + an
//! ```
//! [`ModelFile`] has one input and one output, [`SeveralModelFile`] several. `*.json` and `*.yaml` have the same contents. A file that was
//! read has passed [`ModelFile::check`]: every number is finite, `den` begins with 1, and sizes match.

mod covariance;
mod judgement;
mod several;

pub use judgement::Judgement;
pub use several::{
    ChannelModel, LeftOut, OutputModel, SeveralFormat, SeveralModelFile, StateSpace,
};

use std::path::Path;

use planesman_text::{option, setting, write_text, yaml};
use serde::{Deserialize, Serialize};
use serde_yaml_ng::Value as Yaml;

/// The largest accepted order, which includes the samples of a long delay. No record determines a model of a higher order.
pub const LARGEST_ORDER: usize = 1100;

/// An error in reading or writing a model file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("model file '{path}': {refusal}")]
pub struct Error {
    /// The file.
    pub path: String,
    /// The refused value, and the allowed values.
    pub refusal: Refusal,
}

impl Error {
    fn of(path: &Path, refusal: Refusal) -> Self {
        Self {
            path: path.display().to_string(),
            refusal,
        }
    }
}

/// The reason why a model, or its file, is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The file cannot be read or written; the reason.
    #[error("{0}")]
    File(String),
    /// The text is not a model; the parser's reason.
    #[error("{0}")]
    Text(String),
    /// The file's name does not end in `.json`, `.yaml` or `.yml`.
    #[error("the name of a model file must end in .json, .yaml or .yml")]
    Name,
    /// The text would be too long to be read again.
    #[error(
        "the file would have {length} bytes, but at most {} can be read. Use a lower {}, so that the delay has fewer samples",
        planesman_text::LARGEST,
        option("rate")
    )]
    Size {
        /// Bytes.
        length: usize,
    },
    /// A number is not finite; its fields and indices, each preceded by a space.
    #[error("the number at{0} is not finite")]
    NotFinite(String),
    /// The sample time, s, is not positive.
    #[error("sample_time: {0} s refused: it must be above 0")]
    SampleTime(f64),
    /// The speed is not positive.
    #[error("speed refused: it must be above 0")]
    Speed,
    /// The speed is needed but missing.
    #[error(
        "the file lacks the speed of the vehicle. Add 'speed', in m/s, or set it when you fit: {}",
        option("speed")
    )]
    NoSpeed,
    /// The denominator does not begin with 1.
    #[error("den must begin with 1")]
    Denominator,
    /// The numbers of coefficients do not match.
    #[error(
        "num has {num} coefficients and den has {den}: den must have as many as num or one more, and at most {}",
        LARGEST_ORDER + 1
    )]
    Orders {
        /// Of the numerator.
        num: usize,
        /// Of the denominator.
        den: usize,
    },
    /// The covariance has the wrong size; contains the right number of rows.
    #[error(
        "covariance must have {0} rows of {0} numbers: one row for each coefficient of den after the 1, and for each of num"
    )]
    Covariance(usize),
    /// A channel has an input that the file does not list.
    #[error("a channel has the input '{0}', which is missing in inputs")]
    Input(String),
    /// The matrices of the state space have inconsistent sizes.
    #[error(
        "state_space: with n states, the size must be n by n for a, n by inputs for b, outputs by n for c, outputs by inputs for d"
    )]
    StateSpace,
    /// The file has a static curve, but a linear model is needed.
    #[error(
        "the model has a static curve, but a linear model is needed. Identify a linear model near one level of the input: {}",
        setting("curve", "none")
    )]
    Curve,
    /// The static curve has the parameters of another kind of curve.
    #[error("static_curve: invalid kind or parameters")]
    CurveParameters,
    /// The file has several inputs or outputs, but one input and one output are needed.
    #[error("the model has several inputs or outputs; only sysid compare can use it")]
    Several,
    /// The covariance of a process model has the wrong size; contains the right number of rows.
    #[error(
        "process.covariance must have {0} rows of {0} numbers: one row for each of process.parameters"
    )]
    ProcessCovariance(usize),
    /// The continuous transfer function is improper.
    #[error("continuous.num must not be longer than continuous.den")]
    Continuous,
}

/// The name and version of the format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Format {
    /// The first format, without a judgement.
    #[serde(rename = "planesman model 1")]
    One,
    /// With a judgement. The format between them belongs to files with several inputs ([`SeveralFormat`]).
    #[default]
    #[serde(rename = "planesman model 3")]
    Three,
}

/// A root with its standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// The real part's standard deviation.
    pub re_deviation: f64,
    /// The imaginary part's standard deviation.
    pub im_deviation: f64,
}

/// The continuous model with the same response under zero-order hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Continuous {
    /// Powers of s, highest first.
    pub num: Vec<f64>,
    /// Powers of s, highest first.
    pub den: Vec<f64>,
    /// The delay, s.
    pub delay: f64,
}

/// The vehicle's own equations for level flight at [`ModelFile::speed`]:
///
/// ```text
/// q_dot     = kappa u - beta q - mu theta + nu w        kappa = K/J, beta = B/J, mu = M_theta/J
/// theta_dot = q
/// w_dot     = epsilon u + eta q - zeta w
/// ```
/// `theta` and `q` are positive bow up; `kappa` is then negative for planes that are positive to dive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Physical {
    /// `K/J`: pitch acceleration per input, 1/s^2 for planes in rad.
    pub kappa: f64,
    /// `B/J`, 1/s.
    pub beta: f64,
    /// `M_theta/J`, 1/s^2.
    pub mu: f64,
    /// The covariance of `kappa`, `beta` and `mu`, row by row.
    pub covariance: [[f64; 3]; 3],
    /// The known heave equation; `None` if heave was left out of the pitch equation.
    pub heave: Option<Heave>,
}

impl Physical {
    /// The standard deviations of `kappa`, `beta` and `mu`.
    #[must_use]
    pub fn deviations(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| self.covariance[i][i].max(0.0).sqrt())
    }
}

/// A known heave equation, in SI units where the planes are in rad and the pitch rate in rad/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Heave {
    /// `nu`: pitch acceleration per heave velocity, 1/(m s).
    pub to_pitch: f64,
    /// `zeta`, 1/s.
    pub damping: f64,
    /// `eta`: heave acceleration per pitch rate, m/s.
    pub from_rate: f64,
    /// `epsilon`: heave acceleration per input, m/s^2 per rad.
    pub from_input: f64,
}

/// A process model with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// Its form: 1, 2, 2u, i or 1i.
    pub form: String,
    /// The transfer function as text.
    pub equation: String,
    /// Gain, time constants, dead time.
    pub parameters: Vec<Parameter>,
    /// The covariance, row by row; empty if only the deviations are known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
}

/// A static curve in series with the dynamics: `y = G f(u)` or `y = f(G u)`, with a largest slope of 1, or `f(u) = u |u| + linear u`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StaticCurve {
    /// The side of the dynamics.
    pub side: Side,
    /// Dead zone, saturation, square law, piecewise linear, backlash.
    pub kind: String,
    /// Levels and slopes in order; of straight lines the omitted slope is 1.
    pub parameters: Vec<Parameter>,
}

/// A side of the dynamics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Before the dynamics.
    Input,
    /// Behind them.
    Output,
}

/// A parameter with its standard deviation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Name of the parameter in the equation.
    pub name: String,
    /// The unit; for a gain the signals' units.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// A model for other programs: `control.tf(num, den, sample_time)` in Python, `tf(num, den, sample_time)` in MATLAB.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// The name of the format.
    pub format: Format,
    /// The input's name, `TOPIC:FIELD` or a column.
    pub input: String,
    /// The output's name.
    pub output: String,
    /// The estimator's name.
    pub method: String,
    /// The vehicle's speed in the record, m/s; `None` if not given.
    pub speed: Option<f64>,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// `b1 ... bn`, with direct feedthrough `b0 ... bn`: powers of z, highest first. A delay of d samples gives d - 1 leading zeros.
    pub num: Vec<f64>,
    /// `1, a1 ... an`: powers of z, highest first.
    pub den: Vec<f64>,
    /// The covariance of `a1 ... an` and of `num`, row by row; zero for known values.
    #[serde(with = "covariance")]
    pub covariance: Vec<Vec<f64>>,
    /// The continuous model; `None` if a pole has no continuous counterpart.
    pub continuous: Option<Continuous>,
    /// The vehicle's own equations, if the method estimates them.
    pub physical: Option<Physical>,
    /// The process model that was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub process: Option<Process>,
    /// The static curve before or after the dynamics; all other fields describe the linear dynamics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub static_curve: Option<StaticCurve>,
    /// The output's offset.
    pub offset: f64,
    /// The input at which the output of an integrating model is constant; for other models the offset includes it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub input_level: f64,
    /// The noise's variance, output unit squared.
    pub noise_variance: f64,
    /// `c1 ... cn`; empty without a noise model.
    pub noise_model: Vec<f64>,
    /// `d1 ... dk` of the noise `e / (1 + d1 z^-1 + ... + dk z^-k)` on the output; empty without a noise model.
    #[serde(default)]
    pub noise_denominator: Vec<f64>,
    /// Poles in z.
    pub poles: Vec<Place>,
    /// Poles in s, 1/s.
    pub continuous_poles: Vec<Place>,
    /// Zeros in z.
    pub zeros: Vec<Place>,
    /// Steady-state gain and its standard deviation; `None` with a pole at z = 1.
    pub steady_state_gain: Option<[f64; 2]>,
    /// Simulated fit, %.
    pub fit: Option<f64>,
    /// Simulated fit on held-out data, %.
    pub held_out_fit: Option<f64>,
    /// Sentences about each step of the data's preparation.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub preparation: Vec<String>,
    /// The judgement on the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judgement: Option<Judgement>,
    /// Findings and verdict as text, for display.
    pub verdict: Vec<String>,
}

impl ModelFile {
    /// An exactly known transfer function, `num` and `den` as in the file, without other contents.
    #[must_use]
    pub fn exact(
        input: &str,
        output: &str,
        sample_time: f64,
        num: Vec<f64>,
        den: Vec<f64>,
    ) -> Self {
        let count = num.len() + den.len().saturating_sub(1);
        Self {
            format: Format::Three,
            input: input.to_owned(),
            output: output.to_owned(),
            method: "exact".to_owned(),
            speed: None,
            sample_time,
            num,
            den,
            covariance: vec![vec![0.0; count]; count],
            continuous: None,
            physical: None,
            process: None,
            static_curve: None,
            offset: 0.0,
            input_level: 0.0,
            noise_variance: 0.0,
            noise_model: Vec::new(),
            noise_denominator: Vec::new(),
            poles: Vec::new(),
            continuous_poles: Vec::new(),
            zeros: Vec::new(),
            steady_state_gain: None,
            fit: None,
            held_out_fit: None,
            preparation: Vec::new(),
            judgement: None,
            verdict: Vec::new(),
        }
    }

    /// The model in a `*.json`, `*.yaml` or `*.yml` file.
    ///
    /// # Errors
    /// If the file cannot be read, is larger than [`planesman_text::LARGEST`], is not a model file, or fails [`check`](Self::check).
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = planesman_text::read(path)
            .map_err(|reason| Error::of(path, Refusal::File(reason.to_string())))?;
        Self::parse(path, &text)
    }

    /// Reads the model from the file's text.
    ///
    /// # Errors
    /// Like [`read`](Self::read), except for reading.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        if SeveralModelFile::recognises(path, text) {
            return Err(Error::of(path, Refusal::Several));
        }
        let model: Self = Syntax::of(path)
            .and_then(|syntax| syntax.parse(text))
            .map_err(|reason| Error::of(path, reason))?;
        model.check().map_err(|reason| Error::of(path, reason))?;
        Ok(model)
    }

    /// Checks that a file with that name can be a model file.
    ///
    /// # Errors
    /// [`Refusal::Name`].
    pub fn takes_name(path: &Path) -> Result<(), Refusal> {
        Syntax::of(path).map(drop)
    }

    /// Whether a file claims to be a model file of any version, by the beginning of its `format`.
    #[must_use]
    pub fn recognises(path: &Path, text: &str) -> bool {
        #[derive(Deserialize)]
        struct Head {
            format: String,
        }
        let head = Syntax::of(path).and_then(|syntax| syntax.parse::<Head>(text));
        head.is_ok_and(|head| head.format.starts_with("planesman model"))
    }

    /// Writes the model to a `*.json`, `*.yaml` or `*.yml` file, completely or not at all.
    ///
    /// # Errors
    /// If the model fails [`check`](Self::check), or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        self.check()
            .and_then(|()| write_checked(self, path))
            .map_err(|reason| Error::of(path, reason))
    }

    /// The judgement on the model; for a file of the first format from its sentences. `None` if the file contains no judgement.
    #[must_use]
    pub fn judgement(&self) -> Option<Judgement> {
        (self.judgement.clone()).or_else(|| Judgement::of_sentences(&self.verdict))
    }

    /// `n`.
    #[must_use]
    pub fn order(&self) -> usize {
        self.den.len().saturating_sub(1)
    }

    /// Whether the model has direct feedthrough: `num` is as long as `den`.
    #[must_use]
    pub fn has_feedthrough(&self) -> bool {
        self.num.len() == self.den.len()
    }

    /// The speed at which a vehicle's linear model is valid, m/s.
    ///
    /// # Errors
    /// [`Refusal::NoSpeed`], if the file does not give it; [`Refusal::Curve`], if the model is not linear.
    pub fn required_speed(&self) -> Result<f64, Refusal> {
        if self.static_curve.is_some() {
            return Err(Refusal::Curve);
        }
        self.speed.ok_or(Refusal::NoSpeed)
    }

    /// The checks on every model file.
    ///
    /// # Errors
    /// The first rule that the model violates.
    pub fn check(&self) -> Result<(), Refusal> {
        let written = serde_yaml_ng::to_value(self).map_err(text)?;
        if let Some(place) = not_finite(&written) {
            return Err(Refusal::NotFinite(place));
        }
        if self.sample_time <= 0.0 {
            return Err(Refusal::SampleTime(self.sample_time));
        }
        if self.speed.is_some_and(|speed| speed <= 0.0) {
            return Err(Refusal::Speed);
        }
        check_coefficients(&self.num, &self.den, &self.covariance)?;
        if let Some(process) = &self.process {
            let count = process.parameters.len();
            let rows = &process.covariance;
            let square = rows.len() == count && rows.iter().all(|row| row.len() == count);
            if !rows.is_empty() && !square {
                return Err(Refusal::ProcessCovariance(count));
            }
        }
        let continuous = self.continuous.as_ref();
        if continuous.is_some_and(|it| it.num.is_empty() || it.num.len() > it.den.len()) {
            return Err(Refusal::Continuous);
        }
        Ok(())
    }
}

/// Checks that the coefficients of a transfer function and their covariance match.
fn check_coefficients(num: &[f64], den: &[f64], covariance: &[Vec<f64>]) -> Result<(), Refusal> {
    if den.first() != Some(&1.0) {
        return Err(Refusal::Denominator);
    }
    let n = den.len() - 1;
    let paired = num.len() == n || num.len() == den.len();
    if n > LARGEST_ORDER || !paired || num.is_empty() {
        return Err(Refusal::Orders {
            num: num.len(),
            den: den.len(),
        });
    }
    let count = n + num.len();
    let square = covariance.iter().all(|row| row.len() == count);
    match covariance.len() == count && square {
        true => Ok(()),
        false => Err(Refusal::Covariance(count)),
    }
}

/// Writes a checked model, completely or not at all.
fn write_checked<T: Serialize>(model: &T, path: &Path) -> Result<(), Refusal> {
    let written = Syntax::of(path)?.text(model)?;
    if written.len() as u64 > planesman_text::LARGEST {
        return Err(Refusal::Size {
            length: written.len(),
        });
    }
    write_text(path, written).map_err(|reason| Refusal::File(reason.to_string()))
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The place of the first number that is not finite.
fn not_finite(value: &Yaml) -> Option<String> {
    match value {
        Yaml::Number(number) => {
            let finite = number.as_f64().is_some_and(f64::is_finite);
            (!finite).then(String::new)
        }
        Yaml::Sequence(list) => (1..)
            .zip(list)
            .find_map(|(i, value)| Some(format!(" {i}{}", not_finite(value)?))),
        Yaml::Mapping(map) => map.iter().find_map(|(key, value)| {
            let within = not_finite(value)?;
            Some(format!(" {}{within}", key.as_str().unwrap_or_default()))
        }),
        _ => None,
    }
}

/// The syntax of the file.
#[derive(Clone, Copy)]
enum Syntax {
    Json,
    Yaml,
}

impl Syntax {
    fn of(path: &Path) -> Result<Self, Refusal> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("json") => Ok(Self::Json),
            Some("yaml" | "yml") => Ok(Self::Yaml),
            _ => Err(Refusal::Name),
        }
    }

    fn parse<'de, T: Deserialize<'de>>(self, given: &'de str) -> Result<T, Refusal> {
        match self {
            Self::Json => serde_json::from_str(given).map_err(text),
            Self::Yaml => yaml::from_str(given).map_err(text),
        }
    }

    fn text<T: Serialize>(self, model: &T) -> Result<String, Refusal> {
        match self {
            Self::Json => serde_json::to_string_pretty(model).map_err(text),
            Self::Yaml => serde_yaml_ng::to_string(model).map_err(text),
        }
    }
}

fn text(reason: impl ToString) -> Refusal {
    Refusal::Text(reason.to_string())
}
