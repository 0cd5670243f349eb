//! The recursive estimators.
//!
//! All share one recursion (Ljung and Soederstrom, *Theory and Practice of Recursive Identification*, 1983, ch. 3): a prediction
//! `phi . theta`, its error, and the prediction's slope `psi`
//! ```text
//! theta += P psi e,   P^-1 = lambda P^-1 + psi psi'
//! ```
//! in square-root form ([`RecursiveLeastSquares`]): the added row is `psi`, its output `psi . theta + e`.
//!
//! | kind | phi | psi |
//! |---|---|---|
//! | least squares | `-y, u, 1` | phi |
//! | extended least squares | `-y, u, 1, e` | phi |
//! | prediction error (RML2) | `-y, u, 1, e` | phi / C |
//! | output error | `-x, u, 1` | phi / A, but for the offset |
//!
//! `e` are residuals with the latest parameters, `x` is the model's own output. A step that would make the filter (C, or A) unstable is
//! halved until the filter is stable. For an input that moves within an interval, phi also contains its first moments
//! ([`Recursion::with_moments`]).

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};
use planesman_linear::{ComplexFunctions as _, polynomial};

use super::estimate::{Error, Estimate};
use super::estimator::Recursive;
use super::jumps::JumpDetector;
use crate::error::{IdentificationError, Result};
use crate::rls::{RecursiveLeastSquares, check_forgetting};
use crate::structure::{Layout, Problem, Structure};
use planesman_record::Input;

/// Which recursion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Recursive least squares.
    LeastSquares,
    /// Extended least squares: a noise model by pseudo-linear regression.
    ExtendedLeastSquares,
    /// Recursive prediction error method on the ARMAX model.
    PredictionError,
    /// Recursive output error.
    OutputError,
}

/// The kind of forgetting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Forgetting {
    /// The forgetting factor per sample, in every direction.
    Constant(f64),
    /// Constant forgetting; in addition, all earlier data is forgotten after a detected jump of the parameters. Only for (extended) least squares. The other
    /// two recursions treat it as constant.
    OnJump(f64),
    /// Constant forgetting, but only in the direction of the new row; the information in other directions is kept (Cao and Schwartz, *Automatica* 36, 2000).
    Directional(f64),
    /// A forgetting factor that depends on the prediction error: `lambda = 1 - e^2 / ((1 + phi'P phi) information)`, at least `least` (Fortescue,
    /// Kershenbaum and Ydstie, *Automatica* 17, 1981).
    Variable {
        /// The smallest lambda.
        least: f64,
        /// The noise's variance times the rows to remember, output unit squared.
        information: f64,
    },
}

/// Options of a recursion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The kind of forgetting.
    pub forgetting: Forgetting,
    /// p0, parameter unit squared per output unit squared.
    pub initial_covariance: f64,
    /// The limit of the trace of P; `None` for no limit.
    pub covariance_limit: Option<f64>,
    /// Errors up to this size cause no update, output unit; 0 to disable.
    pub dead_zone: f64,
}

impl Options {
    /// The forgetting factor of the rows themselves; [`Recursion`] implements the other kinds.
    ///
    /// # Errors
    /// [`IdentificationError`], if an option is invalid.
    fn row_forgetting(&self) -> Result<f64> {
        let refuse = |reason: &str| Err(IdentificationError::Option(reason.to_owned()));
        if self
            .covariance_limit
            .is_some_and(|limit| !(limit > 0.0 && limit.is_finite()))
        {
            return refuse("the covariance's limit must be above 0");
        }
        match self.forgetting {
            Forgetting::Constant(lambda) | Forgetting::OnJump(lambda) => {
                check_forgetting(lambda).map(|()| lambda)
            }
            Forgetting::Directional(lambda) => check_forgetting(lambda).map(|()| 1.0),
            Forgetting::Variable { least, information } if information > 0.0 => {
                check_forgetting(least).map(|()| 1.0)
            }
            Forgetting::Variable { .. } => {
                refuse("variable forgetting needs an information content above 0")
            }
        }
    }
}

impl Default for Options {
    /// No forgetting, and a weak prior, `p0 = 1e8`, for complete records. Live identification has its own default, 1e18: the node's
    /// parameter `initial_covariance`.
    fn default() -> Self {
        Self {
            forgetting: Forgetting::Constant(1.0),
            initial_covariance: 1e8,
            covariance_limit: None,
            dead_zone: 0.0,
        }
    }
}

/// Initial forgetting of the kinds whose first slopes are wrong, and how fast it ends.
const FIRST_FORGETTING: f64 = 0.05;
const FORGETTING_FADES: f64 = 0.98;
/// Maximum number of halvings of an unstable step; after that the step is skipped.
const HALVINGS: usize = 8;

/// One recursion of the estimator.
#[derive(Clone, Debug)]
pub struct Recursion {
    kind: Kind,
    options: Options,
    layout: Layout,
    sample_time: f64,
    rls: RecursiveLeastSquares,
    /// The jump detector, if jumps cause forgetting.
    detector: Option<JumpDetector>,
    /// The number of rows on which the estimate is based, if the last sample has shown a jump.
    jump: Option<u64>,
    jumps: u64,
    /// Whether first moments are regressors.
    with_moments: bool,
    /// Whether the recursion only predicts, without learning.
    frozen: bool,
    /// Newest first: outputs (or the model's), residuals, slopes.
    outputs: VecDeque<f64>,
    residuals: VecDeque<f64>,
    slopes: VecDeque<DVector<f64>>,
    inputs: Driving,
    moments: Driving,
    /// Number of samples since the history began.
    since: usize,
    /// Whether the history began during a motion that had already been learnt from.
    resumed: bool,
    error: Option<f64>,
}

/// An input, and its product with the known factors; newest first.
#[derive(Clone, Debug, Default)]
struct Driving {
    raw: VecDeque<f64>,
    driving: VecDeque<f64>,
}

impl Driving {
    fn push(&mut self, input: f64, structure: &Structure) {
        let Structure {
            known_numerator,
            known_denominator,
            ..
        } = structure;
        let sum = |coefficients: &[f64], values: &VecDeque<f64>| -> f64 {
            let past = coefficients.iter().skip(1).zip(values);
            past.map(|(c, v)| c * v).sum()
        };
        let driving = known_numerator[0] * input + sum(known_numerator, &self.raw)
            - sum(known_denominator, &self.driving);
        let depth = structure.history() + known_denominator.len();
        remember(&mut self.raw, input, depth);
        remember(&mut self.driving, driving, depth);
    }

    fn clear(&mut self) {
        self.raw.clear();
        self.driving.clear();
    }
}

impl Recursion {
    /// A recursion before the first sample.
    ///
    /// # Errors
    /// [`IdentificationError`], if an option is invalid, or the structure has no parameters.
    pub fn new(
        kind: Kind,
        structure: Structure,
        sample_time: f64,
        options: Options,
    ) -> Result<Self> {
        let layout = Layout { structure, runs: 1 };
        let count = Self::count(kind, &layout, false);
        let lambda = options.row_forgetting()?;
        let rls = RecursiveLeastSquares::new(count, lambda, options.initial_covariance)?;
        Ok(Self {
            detector: detector(kind, options, &rls),
            jump: None,
            jumps: 0,
            kind,
            options,
            layout,
            sample_time,
            rls,
            with_moments: false,
            frozen: false,
            outputs: VecDeque::new(),
            residuals: VecDeque::new(),
            slopes: VecDeque::new(),
            inputs: Driving::default(),
            moments: Driving::default(),
            since: 0,
            resumed: false,
            error: None,
        })
    }

    /// A recursion before its first sample, with the input's first moments as additional regressors: as many coefficients as the numerator has, after
    /// the offset.
    ///
    /// # Errors
    /// Like [`Recursion::new`].
    pub fn with_moments(mut self) -> Result<Self> {
        self.with_moments = true;
        self.rls = RecursiveLeastSquares::new(
            Self::count(self.kind, &self.layout, true),
            self.options.row_forgetting()?,
            self.options.initial_covariance,
        )?;
        self.detector = detector(self.kind, self.options, &self.rls);
        Ok(self)
    }

    fn count(kind: Kind, layout: &Layout, with_moments: bool) -> usize {
        let Structure {
            poles, numerator, ..
        } = layout.structure;
        let moments = if with_moments { numerator } else { 0 };
        let noise = match kind {
            Kind::ExtendedLeastSquares | Kind::PredictionError => poles,
            Kind::LeastSquares | Kind::OutputError => 0,
        };
        layout.without_motion() + moments + noise
    }

    /// Uses other options from the next sample on; the initial values are kept.
    ///
    /// # Errors
    /// [`IdentificationError`], if an option is invalid; then nothing changes.
    pub fn set_options(&mut self, options: Options) -> Result<()> {
        self.rls.set_forgetting(options.row_forgetting()?)?;
        self.options = options;
        let new = detector(self.kind, options, &self.rls);
        self.detector = new.map(|new| self.detector.take().unwrap_or(new));
        Ok(())
    }

    /// Takes the next output, and the input over the interval that ended with it, which may have moved during the interval.
    pub fn push_input(&mut self, input: Input, output: f64) {
        self.error = None;
        self.jump = None;
        self.inputs.push(input.mean, &self.layout.structure);
        self.moments.push(input.moment, &self.layout.structure);
        self.since += 1;
        let n = self.layout.structure.poles;
        let theta = self.rls.parameters();
        // The simulated output begins at rest, unless motion was learnt from before; measured ones
        // need a whole history.
        let simulated = self.kind == Kind::OutputError;
        if (!simulated || self.resumed) && self.since < self.layout.structure.history() {
            let offset = if simulated { self.offset(&theta) } else { 0.0 };
            remember(&mut self.outputs, output - offset, n.max(1));
            return;
        }
        let phi = self.regressor();
        let psi = self.slope(&phi, &theta);
        let error = output - phi.dot(&theta);
        self.error = Some(error);
        let theta = self.learn(&phi, &psi, output, error, theta);
        let explained = phi.dot(&theta);
        let own = if simulated {
            explained - self.offset(&theta)
        } else {
            output
        };
        remember(&mut self.outputs, own, n.max(1));
        remember(&mut self.residuals, output - explained, n.max(1));
        remember(&mut self.slopes, psi, n.max(1));
    }

    /// The underlying least-squares problem, with the columns `a, b, offset, moments, noise`.
    #[must_use]
    pub fn rows(&self) -> &RecursiveLeastSquares {
        &self.rls
    }

    /// The number of rows on which the estimate is based, if the last sample has shown a jump of the parameters.
    #[must_use]
    pub fn jump(&self) -> Option<u64> {
        self.jump
    }

    /// Jumps detected.
    #[must_use]
    pub fn jumps(&self) -> u64 {
        self.jumps
    }

    /// The kind of recursion.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// How it learns.
    #[must_use]
    pub fn options(&self) -> Options {
        self.options
    }

    /// Whether first moments are regressors.
    #[must_use]
    pub fn has_moments(&self) -> bool {
        self.with_moments
    }

    /// The place of each unknown; moments and noise follow.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The current estimate; `None` until there are more samples than unknowns.
    #[must_use]
    pub fn estimate(&self) -> Option<Estimate> {
        let plain = self.layout.without_motion();
        let theta = self.rls.parameters();
        let noise_variance = self.rls.noise_variance()?;
        let covariance = self.rls.unit_covariance() * noise_variance;
        Some(Estimate {
            error: match self.kind {
                Kind::OutputError => Error::Output,
                _ => Error::Equation,
            },
            layout: self.layout.clone(),
            sample_time: self.sample_time,
            covariance: covariance.view((0, 0), (plain, plain)).into_owned(),
            noise_variance,
            noise_model: theta.iter().skip(self.noise()).copied().collect(),
            factor: None,
            noise_denominator: Vec::new(),
            input_level: 0.0,
            residuals: Vec::new(),
            theta: theta.rows(0, plain).into_owned(),
            output_curve: None,
            physical: None,
            process: None,
            frequency: None,
        })
    }

    /// Restores the initial covariance at the present estimate, so that new samples have full weight again.
    pub fn reset_covariance(&mut self) {
        self.rls.reset_covariance();
        self.detector = detector(self.kind, self.options, &self.rls);
    }

    fn offset(&self, theta: &DVector<f64>) -> f64 {
        self.layout.offset(0).map_or(0.0, |at| theta[at])
    }

    /// The column of the first moment.
    fn moment(&self) -> usize {
        self.layout.without_motion()
    }

    /// The column of the noise model's first coefficient.
    fn noise(&self) -> usize {
        let moments = if self.with_moments {
            self.layout.structure.numerator
        } else {
            0
        };
        self.moment() + moments
    }

    /// `phi`.
    fn regressor(&self) -> DVector<f64> {
        let n = self.layout.structure.poles;
        let delay = self.layout.structure.delay;
        let at = |values: &VecDeque<f64>, i: usize| values.get(i).copied().unwrap_or(0.0);
        let mut phi = DVector::zeros(self.rls.size());
        for i in 0..n {
            phi[i] = -at(&self.outputs, i);
        }
        for (j, column) in self.layout.b(0).enumerate() {
            phi[column] = at(&self.inputs.driving, delay - 1 + j);
        }
        if let Some(column) = self.layout.offset(0) {
            phi[column] = 1.0;
        }
        for (j, column) in (self.moment()..self.noise()).enumerate() {
            phi[column] = at(&self.moments.driving, delay - 1 + j);
        }
        for (i, column) in (self.noise()..phi.len()).enumerate() {
            phi[column] = at(&self.residuals, i);
        }
        phi
    }

    /// `1, ...` of the polynomial that filters the slopes.
    fn filter(&self, theta: &DVector<f64>) -> Vec<f64> {
        let n = self.layout.structure.poles;
        let mut filter = vec![1.0];
        match self.kind {
            Kind::LeastSquares | Kind::ExtendedLeastSquares => {}
            Kind::PredictionError => filter.extend(theta.rows(self.noise(), n).iter()),
            Kind::OutputError => filter.extend(theta.rows(0, n).iter()),
        }
        filter
    }

    /// `psi`: phi through the filter.
    fn slope(&self, phi: &DVector<f64>, theta: &DVector<f64>) -> DVector<f64> {
        let mut psi = phi.clone();
        for (coefficient, before) in self.filter(theta).iter().skip(1).zip(&self.slopes) {
            psi -= before * *coefficient;
        }
        if let (Kind::OutputError, Some(column)) = (self.kind, self.layout.offset(0)) {
            psi[column] = 1.0;
        }
        psi
    }

    /// Adds a row, unless it must not change the estimate. Returns the new parameters; the old ones were `theta`.
    fn learn(
        &mut self,
        phi: &DVector<f64>,
        psi: &DVector<f64>,
        output: f64,
        error: f64,
        theta: DVector<f64>,
    ) -> DVector<f64> {
        let dead = self.options.dead_zone > 0.0 && error.abs() <= self.options.dead_zone;
        if self.frozen || dead {
            return theta;
        }
        if let (Some(detector), Forgetting::OnJump(lambda)) =
            (&mut self.detector, self.options.forgetting)
        {
            let row = psi.as_slice();
            self.jump = detector.update(&mut self.rls, &theta, row, output, error, lambda);
            self.jumps += u64::from(self.jump.is_some());
        } else {
            self.forget(psi, error);
            // psi . theta + e, which is the output itself where psi is phi.
            self.rls
                .update(psi.as_slice(), output + (psi - phi).dot(&theta));
        }
        let theta = self.keep_stable(theta);
        if let Some(limit) = self.options.covariance_limit {
            self.rls.limit_covariance(limit);
        }
        theta
    }

    fn forget(&mut self, phi: &DVector<f64>, error: f64) {
        let lambda = match self.options.forgetting {
            Forgetting::Directional(lambda) => {
                self.rls.forget_along(phi.as_slice(), lambda);
                return;
            }
            Forgetting::Variable { least, information } => {
                let surprise = error * error / (1.0 + self.rls.leverage(phi.as_slice()));
                (1.0 - surprise / information).max(least)
            }
            Forgetting::Constant(lambda) | Forgetting::OnJump(lambda) => match self.kind {
                Kind::LeastSquares | Kind::ExtendedLeastSquares => lambda,
                Kind::PredictionError | Kind::OutputError => {
                    let fading = libm::pow(FORGETTING_FADES, self.rls.rows() as f64);
                    lambda * (1.0 - FIRST_FORGETTING * fading)
                }
            },
        };
        // Every lambda here lies in (0, 1].
        let _ = self.rls.set_forgetting(lambda);
    }

    /// Halves the step from `before` until the filter is stable. Returns the resulting parameters.
    fn keep_stable(&mut self, before: DVector<f64>) -> DVector<f64> {
        let mut theta = self.rls.parameters();
        let sound = |theta: &DVector<f64>| {
            theta.iter().all(|v| v.is_finite()) && is_stable(&self.filter(theta))
        };
        if sound(&theta) {
            return theta;
        }
        for _ in 0..HALVINGS {
            theta = (&theta + &before) * 0.5;
            if sound(&theta) {
                self.rls.set_parameters(&theta);
                return theta;
            }
        }
        self.rls.set_parameters(&before);
        before
    }
}

/// The detector of a recursion that forgets after jumps. Only if the slopes equal the regressors are the rows' residuals the prediction
/// errors, as the test requires.
fn detector(kind: Kind, options: Options, rls: &RecursiveLeastSquares) -> Option<JumpDetector> {
    let is_tested = matches!(kind, Kind::LeastSquares | Kind::ExtendedLeastSquares);
    let is_asked = matches!(options.forgetting, Forgetting::OnJump(_));
    (is_tested && is_asked).then(|| JumpDetector::new(rls))
}

fn is_stable(polynomial: &[f64]) -> bool {
    polynomial.len() == 1
        || polynomial::roots(polynomial).is_ok_and(|roots| roots.iter().all(|z| z.modulus() <= 1.0))
}

/// Inserts a value in front and keeps at most `most`.
fn remember<T>(values: &mut VecDeque<T>, value: T, most: usize) {
    values.push_front(value);
    values.truncate(most);
}

impl Recursive for Recursion {
    fn begin(&mut self, output: f64) {
        self.outputs.clear();
        self.inputs.clear();
        self.moments.clear();
        self.residuals.clear();
        self.slopes.clear();
        self.since = 0;
        self.error = None;
        self.jump = None;
        self.resumed = self.rls.rows() > 0;
        let first = match (self.kind, self.resumed) {
            (Kind::OutputError, false) => 0.0,
            (Kind::OutputError, true) => output - self.offset(&self.rls.parameters()),
            _ => output,
        };
        self.outputs.push_front(first);
    }

    fn push(&mut self, input: f64, output: f64) {
        self.push_input(Input::held(input), output);
    }

    fn parameters(&self) -> DVector<f64> {
        self.rls.parameters()
    }

    fn names(&self) -> Vec<String> {
        let structure = &self.layout.structure;
        let of = |letter: &str, count: usize| {
            (1..=count)
                .map(|i| format!("{letter}{i}"))
                .collect::<Vec<_>>()
        };
        let mut names = of("a", structure.poles);
        names.extend(of("b", structure.numerator));
        names.extend(structure.offset.then(|| "constant".to_owned()));
        names.extend(of("m", self.noise() - self.moment()));
        names.extend(of("c", self.rls.size() - self.noise()));
        names
    }

    fn covariance(&self) -> Option<DMatrix<f64>> {
        Some(self.rls.unit_covariance() * self.rls.noise_variance()?)
    }

    fn error(&self) -> Option<f64> {
        self.error
    }

    fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    fn reset(&mut self) {
        self.rls.reset();
        self.detector = detector(self.kind, self.options, &self.rls);
        self.jumps = 0;
        self.begin(0.0);
    }
}

/// The recursion with which a batch estimator can be followed sample by sample.
pub(super) fn learner(kind: Kind, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
    if problem.structure.delay == 0 {
        let reason = "recursive methods need a delay of at least 1, since they use the input before the output";
        return Err(IdentificationError::Option(reason.to_owned()));
    }
    let structure = Structure {
        own_numerators: false,
        ..problem.structure.clone()
    };
    let recursion = Recursion::new(kind, structure, problem.sample_time, Options::default())?;
    Ok(Box::new(recursion))
}
