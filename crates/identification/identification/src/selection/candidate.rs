//! A candidate model, and the comparison of two candidates.

use super::MIN_EFFECTIVE_SAMPLES;
use super::folds::HALVES;
use crate::estimators::{Armax, Estimator, LeastSquares, WarmStarted, lies_within};
use crate::structure::Structure;

/// The maximum decrease of the fit, %, accepted for removing a pole that a zero may cancel: with hardly any noise, the smallest nonlinearity would
/// require such a pole.
const UNSEEN: f64 = 0.1;

planesman_wording::choices! {
    /// The kind of a candidate.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Kind {
        /// Output error: the model with the smallest simulation error.
        OutputError = "output_error",
        /// Output error with an autoregressive noise model.
        BoxJenkins = "box_jenkins",
        /// The model with the smallest equation error.
        Arx = "arx",
        /// The smallest equation error with a noise model.
        Armax = "armax",
    }
}

/// A candidate with its cross-validation errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its kind.
    pub kind: Kind,
    /// Its structure.
    pub structure: Structure,
    /// `a1 ... an`, fitted to all samples.
    pub poles: Vec<f64>,
    /// `1, d1, ..., dk` of a Box-Jenkins model, `[1]` otherwise.
    pub whitening: Vec<f64>,
    /// The mean squared error of each block left out, over the output's variance: halves, then fifths.
    pub errors: Vec<f64>,
    /// The errors with the state fitted just before each block, so that free motion through the record cannot absorb drift.
    pub(super) afresh: Vec<f64>,
    /// The errors on the halves for an unstable plant, with the state fitted in every window.
    pub(super) in_windows: Vec<f64>,
    /// Whether a pole was limited by the memory of the record, or whether the record is too short to tell an integrator from the zero that cancels it.
    pub(super) at_limit: bool,
    /// The effective number of samples of the errors.
    pub(super) samples: f64,
}

impl Candidate {
    /// Number of parameters of the transfer function.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.structure.poles + self.structure.numerator
    }

    /// The number of poles, including those at z = 1.
    #[must_use]
    pub fn order(&self) -> usize {
        self.structure.poles + self.integrators()
    }

    /// The number of poles at z = 1.
    #[must_use]
    pub fn integrators(&self) -> usize {
        self.structure.known_denominator.len() - 1
    }

    /// The estimator that fits the candidate to data, started from the candidate's poles.
    #[must_use]
    pub fn estimator(&self) -> Box<dyn Estimator> {
        match self.kind {
            Kind::Arx => Box::new(LeastSquares),
            Kind::Armax => Box::new(Armax),
            of => Box::new(WarmStarted {
                poles: self.poles.clone(),
                noise: of == Kind::BoxJenkins,
            }),
        }
    }

    /// The mean over the blocks of the logarithm of the error, plus `ln N / N` for each parameter, analogous to the Bayesian criterion for white
    /// noise.
    pub(crate) fn score(&self) -> f64 {
        self.penalised(&self.errors)
    }

    /// The score for all samples, like the Bayesian criterion.
    pub(crate) fn criterion(&self) -> f64 {
        self.samples * self.score()
    }

    fn penalised(&self, errors: &[f64]) -> f64 {
        mean_logarithm(errors) + self.parameters() as f64 * libm::log(self.samples) / self.samples
    }

    pub(super) fn mean(&self) -> f64 {
        mean_logarithm(&self.errors)
    }

    /// Whether the mean logarithm of its errors exceeds the other's by at most this many standard errors of their difference, or `slack`.
    pub(super) fn is_within(&self, standard_errors: f64, slack: f64, best: &Self) -> bool {
        errors_not_significantly_worse(&self.errors, standard_errors, slack, &best.errors)
    }

    /// Whether the candidate cannot be distinguished from the best, neither by that criterion within a bound nor block by block; needs enough
    /// samples.
    pub(crate) fn is_alike(&self, best: &Self, bound: f64) -> bool {
        self.samples > 2.0 * MIN_EFFECTIVE_SAMPLES
            && self.criterion() - best.criterion() <= bound
            && self.is_within(1.0, 0.0, best)
    }

    /// Whether all poles, except known poles, are stable.
    pub(crate) fn is_stable(&self) -> bool {
        lies_within(&self.poles, 1.0)
    }

    /// The best candidate of lower order with newly fitted states, if one of three conditions is satisfied: it is better with such states; simulated
    /// through the records, it is at most a standard error worse than `best`; or the difference is too small to matter.
    pub(crate) fn simpler<'a>(&self, among: &'a [Self], best: &Self) -> Option<&'a Self> {
        let afresh = |it: &Self| it.penalised(&it.afresh);
        let is_as_good = |it: &Self| {
            afresh(it) <= afresh(self)
                || it.is_within(1.0, 0.0, best)
                || best.fit() - it.fit() <= UNSEEN
        };
        (self.lower(among).filter(|it| is_as_good(it)))
            .min_by(|p, q| afresh(p).total_cmp(&afresh(q)))
    }

    /// The lower-order candidates that are simulated on from earlier samples, in the order given.
    pub(crate) fn lower<'a>(&self, among: &'a [Self]) -> impl Iterator<Item = &'a Self> {
        let order = self.order();
        let is_lower = move |it: &&Self| it.order() < order && it.kind != Kind::Arx;
        among.iter().filter(is_lower)
    }

    /// Whether the candidate's error is below a share of the other's in each half, with a state fitted there.
    pub(super) fn leaves_less(&self, share: f64, other: &Self) -> bool {
        let pairs = self.in_windows.iter().zip(&other.in_windows);
        pairs.into_iter().all(|(it, other)| *it < share * other)
    }

    /// The ratio of the errors with half the record left out to the errors with a fifth left out.
    #[must_use]
    pub fn half_data_error_ratio(&self) -> f64 {
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let (halves, fifths) = self.errors.split_at(HALVES);
        mean(halves) / mean(fifths).max(f64::MIN_POSITIVE)
    }

    /// The fit that corresponds to the errors, %.
    #[must_use]
    pub fn fit(&self) -> f64 {
        100.0 * (1.0 - libm::exp(self.mean() / 2.0))
    }
}

fn logarithm(error: f64) -> f64 {
    libm::log(error + 1e-12)
}

pub(crate) fn mean_logarithm(errors: &[f64]) -> f64 {
    errors.iter().copied().map(logarithm).sum::<f64>() / errors.len() as f64
}

/// Whether the mean logarithm of errors exceeds that of others, block by block, by at most this many standard errors of their difference,
/// or `slack`.
pub(crate) fn errors_not_significantly_worse(
    errors: &[f64],
    standard_errors: f64,
    slack: f64,
    others: &[f64],
) -> bool {
    let pairs = errors.iter().zip(others);
    let worse: Vec<f64> = pairs
        .map(|(it, other)| logarithm(*it) - logarithm(*other))
        .collect();
    let count = worse.len() as f64;
    let mean = worse.iter().sum::<f64>() / count;
    let spread: f64 = worse.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / (count - 1.0);
    mean <= slack.max(standard_errors * (spread / count).sqrt()) + 1e-12
}
