//! Learns a model from samples in order, by any recursive estimator, and judges whether it is valid.

use planesman_identification::estimators::Recursive;
use planesman_identification::estimators::kalman::Filter;
use planesman_identification::estimators::recursive::{Forgetting, Kind, Recursion};
use planesman_identification::{
    FitRange, IdentificationError, Input, Model, PHYSICAL, Readout, fit,
};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_parameters::Choice as _;
use planesman_signals::Sample;

use crate::parameters::Config;

/// The forgetting factor of the recent fit: a memory of about 200 samples.
const RECENT: f64 = 0.995;

/// An unknown of the vehicle's equations counts as learnt if its deviation is below this share of its initial value.
const LEARNT: f64 = 0.5;

/// The recursive estimator.
#[derive(Clone, Debug)]
enum Estimator {
    Recursion(Box<Recursion>),
    Vehicle(Box<Filter>),
}

impl Estimator {
    fn new(config: &Config) -> Result<Self, IdentificationError> {
        let dt = config.sample_time;
        Ok(match config.estimator.recursion() {
            Some(kind) => {
                let plain = Recursion::new(kind, config.structure.clone(), dt, config.options)?;
                let recursion = if config.moment {
                    plain.with_moments()?
                } else {
                    plain
                };
                Self::Recursion(Box::new(recursion))
            }
            None => Self::Vehicle(Box::new(Filter::new(config.vehicle, dt, config.settings)?)),
        })
    }

    /// The common interface of both kinds of estimators.
    fn recursive(&mut self) -> &mut dyn Recursive {
        match self {
            Self::Recursion(it) => &mut **it,
            Self::Vehicle(it) => &mut **it,
        }
    }
}

/// The current estimate, and the history for the next row.
#[derive(Clone, Debug)]
pub(crate) struct Learner {
    estimator: Estimator,
    frozen: bool,
    /// Whether a sample has arrived.
    begun: bool,
    /// Number of samples learnt from.
    samples: u64,
    /// Number of samples predicted, whether learnt from or not.
    predicted: u64,
    /// The range of the outputs learnt from.
    spread: FitRange,
    recent: Recent,
    /// The last input.
    last_input: Option<Input>,
    /// Whether the input has changed from one sample to the next, or within one.
    input_moved: bool,
    /// Whether the input has moved within a sample.
    moment_seen: bool,
}

/// The latest prediction errors, and the outputs' range for comparison.
#[derive(Clone, Copy, Debug, Default)]
struct Recent {
    squared_errors: f64,
    spread: FitRange,
}

impl Recent {
    fn update(&mut self, error: f64, output: f64) {
        self.squared_errors = RECENT * self.squared_errors + error * error;
        self.spread.update(output, RECENT);
    }
}

impl Learner {
    /// A learner before its first sample.
    ///
    /// # Errors
    /// If the estimator refuses its parameters.
    pub(crate) fn new(config: &Config) -> Result<Self, IdentificationError> {
        Ok(Self::before(Estimator::new(config)?, false))
    }

    /// The state before the first sample.
    fn before(estimator: Estimator, frozen: bool) -> Self {
        Self {
            estimator,
            frozen,
            begun: false,
            samples: 0,
            predicted: 0,
            spread: FitRange::default(),
            recent: Recent::default(),
            last_input: None,
            input_moved: false,
            moment_seen: false,
        }
    }

    /// Forgets every sample; a frozen learner stays frozen.
    pub(crate) fn reset(&mut self) {
        let mut estimator = self.estimator.clone();
        estimator.recursive().reset();
        *self = Self::before(estimator, self.frozen);
    }

    /// Applies parameters that can change while learning.
    ///
    /// # Errors
    /// If the estimator refuses them; then nothing changes.
    pub(crate) fn retune(&mut self, config: &Config) -> Result<(), IdentificationError> {
        match &mut self.estimator {
            Estimator::Recursion(it) => it.set_options(config.options),
            Estimator::Vehicle(it) => it.set_settings(config.settings),
        }
    }

    /// Stops learning (samples are still predicted), or resumes it.
    pub(crate) fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
        self.estimator.recursive().set_frozen(frozen);
        // The fit is that of the one model from here on.
        self.recent = Recent::default();
    }

    /// Whether learning is stopped.
    #[must_use]
    pub(crate) fn frozen(&self) -> bool {
        self.frozen
    }

    /// Restarts the history with `output`; nothing is learnt. The integral's value is then lost: with known integrators, everything learnt
    /// is discarded too.
    pub(crate) fn begin(&mut self, output: f64) {
        if let Estimator::Recursion(it) = &self.estimator
            && it.layout().structure.known_denominator.len() > 1
            && !self.frozen
        {
            self.reset();
        }
        self.begun = true;
        self.estimator.recursive().begin(output);
    }

    /// Takes the next sample; without an input, or as the first one, it starts the history. Returns whether the sample was predicted.
    pub(crate) fn take(&mut self, sample: Sample) -> bool {
        let Some(input) = sample.input.filter(|_| self.begun) else {
            self.begin(sample.output);
            return false;
        };
        self.moment_seen |= input.moment != 0.0;
        self.input_moved |= self.moment_seen || self.last_input.is_some_and(|last| last != input);
        self.last_input = Some(input);
        let samples = match &mut self.estimator {
            Estimator::Recursion(it) => {
                it.push_input(input, sample.output);
                it.rows().rows()
            }
            Estimator::Vehicle(it) => {
                it.push(input.mean, sample.output);
                self.samples + u64::from(!self.frozen)
            }
        };
        let Some(error) = self.estimator.recursive().error() else {
            return false;
        };
        if samples > self.samples {
            self.spread.update(sample.output, self.row_forgetting());
        }
        self.samples = samples;
        self.predicted += 1;
        if self.jump().is_some() {
            // The fit is that of the model since.
            self.recent = Recent::default();
        }
        self.recent.update(error, sample.output);
        true
    }

    /// The number of samples on which the estimate is based, if the last sample has shown a jump of the parameters.
    #[must_use]
    pub(crate) fn jump(&self) -> Option<u64> {
        match &self.estimator {
            Estimator::Recursion(it) => it.jump(),
            Estimator::Vehicle(_) => None,
        }
    }

    /// Number of samples predicted, whether learnt from or not.
    #[must_use]
    pub(crate) fn predicted(&self) -> u64 {
        self.predicted
    }

    /// The current model.
    #[must_use]
    pub(crate) fn model(&self, config: &Config) -> Model {
        self.readout(config).model
    }

    fn readout(&self, config: &Config) -> Readout {
        match &self.estimator {
            Estimator::Recursion(it) => {
                Readout::of_recursion(it, config.moment && self.moment_seen, config.sample_time)
            }
            Estimator::Vehicle(it) => Readout::of_vehicle(it, config.sample_time),
        }
    }

    /// The current estimate, without stamp and names.
    ///
    /// The covariance is the estimator's own: for least squares the residual's variance times `(Phi'Phi)^-1`, which is correct for a white
    /// residual. The covariance does not include the bias that noise on the measured outputs causes in an equation-error fit.
    #[must_use]
    pub(crate) fn estimate(&self, config: &Config) -> ModelEstimate {
        let Readout { model, covariance } = self.readout(config);
        let none = ModelEstimate {
            estimator: config.estimator.name().to_owned(),
            sample_time: config.sample_time,
            samples: self.samples,
            frozen: self.frozen,
            ..ModelEstimate::default()
        };
        let poles = match model.poles() {
            Ok(poles) => poles,
            Err(reason) => {
                let reason = format!("no poles: {reason}");
                return ModelEstimate { reason, ..none };
            }
        };
        let s_poles: Vec<_> = poles.iter().map(|z| model.continuous(*z)).collect();
        let steady_state_gain = model.steady_state_gain();
        let reason = self.doubt(config);
        let (physical, deviations) = self.physical();
        ModelEstimate {
            order: model.a.len() as u32,
            covariance: covariance.map_or_else(Vec::new, |it| it.transpose().as_slice().to_vec()),
            noise_variance: self.noise_variance(config),
            physical_names: physical
                .iter()
                .zip(PHYSICAL)
                .map(|(_, n)| n.to_owned())
                .collect(),
            physical_values: physical,
            physical_deviations: deviations,
            poles_re: poles.iter().map(|z| z.re).collect(),
            poles_im: poles.iter().map(|z| z.im).collect(),
            s_poles_re: s_poles.iter().map(|s| s.re).collect(),
            s_poles_im: s_poles.iter().map(|s| s.im).collect(),
            steady_state_gain: steady_state_gain.unwrap_or(0.0),
            has_steady_state_gain: steady_state_gain.is_some(),
            fit: self.fit(),
            valid: reason.is_none(),
            reason: reason.unwrap_or_default(),
            a: model.a,
            b: model.b,
            c: model.c,
            bias: model.bias,
            ..none
        }
    }

    /// The vehicle's own coefficients and their standard deviations.
    fn physical(&self) -> (Vec<f64>, Vec<f64>) {
        match &self.estimator {
            Estimator::Recursion(_) => (Vec::new(), Vec::new()),
            Estimator::Vehicle(it) => {
                let (values, covariance) = it.learnt();
                let deviations = covariance.diagonal().map(|v| v.max(0.0).sqrt());
                (values.as_slice().to_vec(), deviations.as_slice().to_vec())
            }
        }
    }

    fn noise_variance(&self, config: &Config) -> f64 {
        match &self.estimator {
            Estimator::Recursion(it) => it.rows().noise_variance().unwrap_or(0.0),
            Estimator::Vehicle(_) => config.settings.noise.powi(2),
        }
    }

    /// The forgetting factor per sample, if it is constant, nothing has jumped, and the current parameters explain every sample.
    fn constant_forgetting(&self) -> Option<f64> {
        match &self.estimator {
            Estimator::Recursion(it) if it.kind() == Kind::LeastSquares => {
                match it.options().forgetting {
                    Forgetting::Constant(lambda) => Some(lambda),
                    Forgetting::OnJump(lambda) if it.jumps() == 0 => Some(lambda),
                    Forgetting::OnJump(_)
                    | Forgetting::Directional(_)
                    | Forgetting::Variable { .. } => None,
                }
            }
            Estimator::Recursion(_) | Estimator::Vehicle(_) => None,
        }
    }

    fn row_forgetting(&self) -> f64 {
        self.constant_forgetting().unwrap_or(1.0)
    }

    /// The one-step fit, %.
    fn fit(&self) -> f64 {
        let found = match &self.estimator {
            Estimator::Recursion(it) if !self.frozen && self.constant_forgetting().is_some() => {
                fit(it.rows().cost(), self.spread.sum_of_squares())
            }
            _ => fit(
                self.recent.squared_errors,
                self.recent.spread.sum_of_squares(),
            ),
        };
        found.unwrap_or(0.0)
    }

    /// The reason why the estimate is not valid yet; `None` for a valid estimate.
    fn doubt(&self, config: &Config) -> Option<String> {
        let unlearnt = match &self.estimator {
            Estimator::Recursion(it) => {
                let columns = self.columns(it);
                let needed = config.min_samples.max(columns.len() as u64 + 1);
                if self.samples < needed {
                    return Some(format!("{} rows, {needed} are needed", self.samples));
                }
                (it.rows().unlearnt(&columns), columns.len())
            }
            Estimator::Vehicle(_) => {
                if self.samples < config.min_samples {
                    let needed = config.min_samples;
                    return Some(format!("{} rows, {needed} are needed", self.samples));
                }
                let began = config.settings.deviations;
                let open = began.iter().filter(|d| **d > 0.0).count();
                let learnt = (self.physical().1.iter().zip(began))
                    .filter(|(now, began)| *began > 0.0 && **now <= LEARNT * began)
                    .count();
                // One that is well known beforehand need not become better known.
                (if learnt == 0 { open } else { 0 }, open)
            }
        };
        if !self.input_moved {
            return Some("the input has not moved".to_owned());
        }
        match unlearnt {
            (0, _) => None,
            (unlearnt, all) => Some(format!(
                "too little excitation: {unlearnt} of {all} parameters are not determined"
            )),
        }
    }

    /// The columns in use: all except the noise model's, and except the moments' until an input moves within a sample.
    fn columns(&self, recursion: &Recursion) -> Vec<usize> {
        let layout = recursion.layout();
        let plain = layout.without_motion();
        let moments = if self.moment_seen && recursion.has_moments() {
            layout.structure.numerator
        } else {
            0
        };
        (0..plain + moments).collect()
    }
}
