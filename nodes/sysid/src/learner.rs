//! Learns a model from samples in order, and says what it is worth.

use planesman_msgs::planesman_msgs::msg::ModelEstimate;

use crate::align::Sample;
use crate::fit::{Spread, fit};
use crate::model::Model;
use crate::parameters::Config;
use crate::regression::{History, Input, Shape};
use crate::rls::RecursiveLeastSquares;

/// What has been learnt, and the history the next row is made of.
#[derive(Clone, Debug)]
pub struct Learner {
    shape: Shape,
    forgetting: f64,
    history: History,
    rls: RecursiveLeastSquares,
    /// Of the outputs regressed on.
    spread: Spread,
    /// The last input regressed on.
    last_input: Option<Input>,
    /// The input has changed from one sample to the next, or within one.
    input_moved: bool,
    /// The input has moved within a sample.
    moment_seen: bool,
}

impl Learner {
    /// A learner before its first sample.
    ///
    /// # Errors
    /// As [`RecursiveLeastSquares::new`].
    pub fn new(config: &Config) -> Result<Self, String> {
        Ok(Self {
            shape: config.shape,
            forgetting: config.forgetting,
            history: History::new(config.shape),
            rls: RecursiveLeastSquares::new(
                config.shape.parameters(),
                config.forgetting,
                config.initial_covariance,
            )?,
            spread: Spread::default(),
            last_input: None,
            input_moved: false,
            moment_seen: false,
        })
    }

    /// Forgets every sample.
    pub fn reset(&mut self) {
        self.history = History::new(self.shape);
        self.rls.reset();
        self.spread = Spread::default();
        self.last_input = None;
        self.input_moved = false;
        self.moment_seen = false;
    }

    /// Forgets at another rate from the next row on.
    ///
    /// # Errors
    /// As [`RecursiveLeastSquares::set_forgetting`].
    pub fn set_forgetting(&mut self, forgetting: f64) -> Result<(), String> {
        self.rls.set_forgetting(forgetting)?;
        self.forgetting = forgetting;
        Ok(())
    }

    /// Begins the history anew with `output`; nothing is learnt.
    pub fn begin(&mut self, output: f64) {
        self.history.begin(output);
    }

    /// Takes the next sample; without an input the history begins anew.
    pub fn take(&mut self, sample: Sample) {
        let Some(input) = sample.input else {
            self.begin(sample.output);
            return;
        };
        self.moment_seen |= input.moment != 0.0;
        self.input_moved |= self.moment_seen || self.last_input.is_some_and(|last| last != input);
        self.last_input = Some(input);
        if let Some(row) = self.history.push(input, sample.output) {
            self.rls.update(row, sample.output);
            self.spread.update(sample.output, self.forgetting);
        }
    }

    /// Rows regressed on.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.rls.rows()
    }

    /// The model as it stands.
    #[must_use]
    pub fn model(&self, config: &Config) -> Model {
        let mut model = Model::from_parameters(
            self.shape,
            self.rls.parameters().as_slice(),
            config.sample_time,
        );
        if !self.moment_seen {
            model.c.clear();
        }
        model
    }

    /// The estimate as it stands, without stamp and names.
    ///
    /// The covariance is the residual's variance times `(Phi'Phi)^-1`: what least squares
    /// claims when the residual is white. It says nothing of the bias that noise on the
    /// measured outputs brings into an equation-error fit.
    #[must_use]
    pub fn estimate(&self, config: &Config) -> ModelEstimate {
        let model = self.model(config);
        let variance = self.rls.noise_variance();
        let poles = model.poles();
        let reason = match &poles {
            Ok(_) => self.doubt(config),
            Err(reason) => Some(format!("no poles: {reason}")),
        };
        let poles = poles.unwrap_or_default();
        let s_poles: Vec<_> = poles.iter().map(|z| model.continuous(*z)).collect();
        let dc_gain = model.dc_gain();
        ModelEstimate {
            sample_time: config.sample_time,
            order: self.shape.order as u32,
            samples: self.rows(),
            covariance: variance.map_or_else(Vec::new, |variance| self.covariance(variance)),
            noise_variance: variance.unwrap_or(0.0),
            poles_re: poles.iter().map(|z| z.re).collect(),
            poles_im: poles.iter().map(|z| z.im).collect(),
            s_poles_re: s_poles.iter().map(|s| s.re).collect(),
            s_poles_im: s_poles.iter().map(|s| s.im).collect(),
            dc_gain: dc_gain.unwrap_or(0.0),
            has_dc_gain: dc_gain.is_some(),
            fit: fit(self.rls.cost(), self.spread.sum_of_squares()).unwrap_or(0.0),
            valid: reason.is_none(),
            reason: reason.unwrap_or_default(),
            a: model.a,
            b: model.b,
            c: model.c,
            bias: model.bias,
            ..ModelEstimate::default()
        }
    }

    /// Why the numbers mean nothing yet, if so.
    fn doubt(&self, config: &Config) -> Option<String> {
        let columns = self.columns();
        let needed = config.min_samples.max(columns.len() as u64 + 1);
        if self.rows() < needed {
            return Some(format!("{} rows, {needed} are needed", self.rows()));
        }
        if !self.input_moved {
            return Some("the input has not moved".to_owned());
        }
        match self.rls.unlearnt(&columns) {
            0 => None,
            unlearnt => Some(format!(
                "too little excitation: {unlearnt} of {} parameters cannot be told apart",
                columns.len()
            )),
        }
    }

    /// The parameters' covariance, row by row, for a residual of that variance.
    fn covariance(&self, variance: f64) -> Vec<f64> {
        let unit = self.rls.unit_covariance();
        let columns = self.columns();
        columns
            .iter()
            .flat_map(|i| columns.iter().map(|j| variance * unit[(*i, *j)]))
            .collect()
    }

    /// The columns in use: all, or all but the moments' as long as none has been seen.
    fn columns(&self) -> Vec<usize> {
        let n = self.shape.order;
        let unused = if self.shape.moment && !self.moment_seen {
            2 * n..3 * n
        } else {
            0..0
        };
        (0..self.shape.parameters())
            .filter(|column| !unused.contains(column))
            .collect()
    }
}
