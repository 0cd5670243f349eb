//! A model of several inputs and outputs: a transfer function from each input to each output, and a common state space.

use crate::judgement::Judgement;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Continuous, Error, Place, Refusal, Syntax, not_finite, text, write_checked};

/// The name and version of the format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SeveralFormat {
    /// The first format with several inputs and outputs.
    #[serde(rename = "planesman model 2")]
    Two,
    /// With judgements.
    #[default]
    #[serde(rename = "planesman model 4")]
    Four,
}

/// The transfer function from an input to an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelModel {
    /// The input's name.
    pub input: String,
    /// Numerator in the form of a file with one input: powers of z, highest first; a delay of d samples gives d - 1 leading zeros.
    pub num: Vec<f64>,
    /// `1, a1 ... an`.
    pub den: Vec<f64>,
    /// The covariance of `a1 ... an` and of `num`, row by row.
    #[serde(with = "super::covariance")]
    pub covariance: Vec<Vec<f64>>,
    /// The delay, samples.
    pub delay: usize,
    /// The 95 % interval of the delay, samples; `None` if the delay was given.
    pub delay_interval: Option<[i64; 2]>,
    /// The continuous model; `None` if a pole has no continuous counterpart.
    pub continuous: Option<Continuous>,
    /// Poles in z.
    pub poles: Vec<Place>,
    /// Poles in s, 1/s.
    pub continuous_poles: Vec<Place>,
    /// Zeros in z.
    pub zeros: Vec<Place>,
    /// Steady-state gain and its standard deviation; `None` with a pole at z = 1.
    pub steady_state_gain: Option<[f64; 2]>,
    /// The F statistic of the input's parameters, and the required one.
    pub effect: [f64; 2],
}

/// An input without a visible effect on an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Its name.
    pub input: String,
    /// The F statistic of the input, and the required F.
    pub effect: [f64; 2],
}

/// The model of one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputModel {
    /// The output's name.
    pub output: String,
    /// The estimator's name.
    pub method: String,
    /// The inputs with an effect, in the order of the file.
    pub channels: Vec<ChannelModel>,
    /// The others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// The output's offset where every input is 0.
    pub offset: f64,
    /// The noise's variance, output unit squared.
    pub noise_variance: f64,
    /// `d1 ... dk` of the noise `e / (1 + d1 z^-1 + ... + dk z^-k)` on the output.
    pub noise_denominator: Vec<f64>,
    /// Simulated fit, %.
    pub fit: Option<f64>,
    /// Simulated fit on held-out data, %.
    pub held_out_fit: Option<f64>,
    /// The judgement on the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judgement: Option<Judgement>,
    /// Findings and verdict as text, for display.
    pub verdict: Vec<String>,
}

/// `x_(k+1) = A x_k + B u_k`, `y_k = C x_k + D u_k` plus the offsets; inputs and outputs in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateSpace {
    /// n rows of n.
    pub a: Vec<Vec<f64>>,
    /// n rows, each with one number per input.
    pub b: Vec<Vec<f64>>,
    /// One row of n numbers for each output.
    pub c: Vec<Vec<f64>>,
    /// One row for each output, with one number per input.
    pub d: Vec<Vec<f64>>,
}

/// A model of several inputs and outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeveralModelFile {
    /// The name of the format.
    pub format: SeveralFormat,
    /// The inputs' names.
    pub inputs: Vec<String>,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// The model of each output.
    pub outputs: Vec<OutputModel>,
    /// All outputs as one system.
    pub state_space: StateSpace,
    /// Sentences about each step of the data's preparation.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub preparation: Vec<String>,
}

impl SeveralModelFile {
    /// Whether the text of a `*.json`, `*.yaml` or `*.yml` file claims to be such a model.
    #[must_use]
    pub fn recognises(path: &Path, given: &str) -> bool {
        #[derive(Deserialize)]
        struct Head {
            #[serde(rename = "format")]
            _format: SeveralFormat,
        }
        let head = Syntax::of(path).and_then(|syntax| syntax.parse::<Head>(given));
        head.is_ok()
    }

    /// The model from a file's text.
    ///
    /// # Errors
    /// If the text is not such a model, or fails [`check`](Self::check).
    pub fn parse(path: &Path, given: &str) -> Result<Self, Error> {
        let model: Self = Syntax::of(path)
            .and_then(|syntax| syntax.parse(given))
            .map_err(|reason| Error::of(path, reason))?;
        model.check().map_err(|reason| Error::of(path, reason))?;
        Ok(model)
    }

    /// Writes the model to a `*.json`, `*.yaml` or `*.yml` file, completely or not at all.
    ///
    /// # Errors
    /// If the model fails [`check`](Self::check), or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let checked = self.check().and_then(|()| write_checked(self, path));
        checked.map_err(|reason| Error::of(path, reason))
    }

    /// The checks on every such file.
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
        for channel in self.outputs.iter().flat_map(|it| &it.channels) {
            super::check_coefficients(&channel.num, &channel.den, &channel.covariance)?;
            if !self.inputs.contains(&channel.input) {
                return Err(Refusal::Input(channel.input.clone()));
            }
        }
        let (n, m, p) = (
            self.state_space.a.len(),
            self.inputs.len(),
            self.outputs.len(),
        );
        let is = |matrix: &[Vec<f64>], rows: usize, columns: usize| {
            matrix.len() == rows && matrix.iter().all(|row| row.len() == columns)
        };
        let space = &self.state_space;
        let fits = is(&space.a, n, n) && is(&space.b, n, m) && is(&space.c, p, n);
        match fits && is(&space.d, p, m) {
            true => Ok(()),
            false => Err(Refusal::StateSpace),
        }
    }
}
