//! What speaks for a model and against it: findings with their numbers. `sentences` has them in words.

use super::curve::Curved;
use super::{FirstOrderHold, OtherOrder};
use crate::estimators::Form;
use crate::selection::{Candidate, criteria, process};
use crate::uncertainty::Uncertain;
use crate::validation::identifiability::Doubt;
use crate::validation::nonlinearity::Finding;
use crate::validation::residuals::Correlation;

/// A finding on a model. Fits and shares of samples are in %.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// Samples of the validation data, the simulated fit on them, the fit of predictions.
    Validated(usize, Option<f64>, Option<f64>),
    /// What reading the data has found that bears on the model, in words.
    Data(String),
    /// The output stands still until the input steps: the record is taken to begin at rest.
    AtRest,
    /// The record may not determine the model.
    Doubt(Doubt),
    /// Segments used, of so many, with the share of the samples.
    SegmentsLeftOut(usize, usize, f64),
    /// Samples on which order and delay were searched, of so many.
    SearchedInPart(usize, usize),
    /// Models cross-validated, the one chosen, and the one of the largest fit if that is larger.
    Selected(usize, Box<Candidate>, Option<Box<Candidate>>),
    /// The same of several inputs, in words.
    SelectedOfSeveral(String),
    /// The order and delay chosen by criteria, and the next order.
    Order(criteria::Candidate, Option<criteria::Candidate>),
    /// The process model chosen, and the next form with the difference of its criterion.
    Process(process::Candidate, Option<(Form, f64)>),
    /// The order is the largest searched.
    LargestOrder(usize),
    /// The delay is the longest searched.
    LongestDelay(usize),
    /// The response in two stages and by a direct fit, where they differ most.
    TwoStages {
        /// The frequency, rad/s.
        frequency: f64,
        /// The reference's name.
        reference: String,
        /// The magnitude in two stages and its standard deviation.
        staged: (f64, f64),
        /// The same by the direct fit.
        direct: (f64, f64),
        /// Standard deviations between them, where that is significant.
        apart: Option<f64>,
    },
    /// The model is unstable; the fit of predictions.
    PredictedFit(f64),
    /// The simulated fit on held-out data.
    HeldOutFit(f64, FitRemark),
    /// The output stays within the noise there; the cross-validated fit, %, where the model is judged by that.
    HeldOutIsNoise(Option<f64>),
    /// The error there is no larger than elsewhere, though the output moves less; the cross-validated fit, %, by which the model is judged.
    ErrorAsElsewhere(Option<f64>),
    /// Not validated: the first part alone does not determine the model.
    FirstPartUndetermined,
    /// The first part alone does not excite the band: the simulated fit on all of the record, %.
    WholeRecord(Option<f64>),
    /// The band in which the coherence holds.
    Band {
        /// The lowest and the highest frequency, rad/s.
        band: (f64, f64),
        /// The least coherence.
        coherence: f64,
        /// J of the transfer function there.
        cost: f64,
    },
    /// Another model than a linear, steady one explains the error.
    NotLinear {
        /// What the error points to.
        finding: Finding,
        /// The interval between samples, s.
        sample_time: f64,
        /// The segment's number from 1, where there are several.
        segment: Option<usize>,
    },
    /// The simulated fit on held-out data with the state from the samples before it, %.
    Carried(f64),
    /// The halves of the record do not agree.
    Unsteady,
    /// The input's share of the output's variation, 0 to 1, and whether that is too little for a gain.
    InputShare(f64, bool),
    /// The F statistic of one of several inputs, the one needed, and whether the model has it.
    InputEffect(f64, f64, bool),
    /// Another input that explains nearly all of one, and the share of it that is its own.
    Inseparable(String, f64),
    /// The F statistic of a process model against the noise, and the one from which it is beyond doubt.
    ProcessF(f64, f64),
    /// The steady-state gain, which is hardly known.
    GainUndetermined(Uncertain),
    /// Samples by which the output seems to come before the input.
    Early(i64),
    /// The delay that fits better, and the model's.
    OtherDelay(i64, usize),
    /// The output answers within a sample.
    DirectFeedthrough,
    /// A static curve in front of the dynamics or behind them.
    Curve(Curved),
    /// By how much, %, the fit with the curve stays below what the noise leaves.
    CurveMisses(f64),
    /// The input moves on straight lines between its samples.
    FirstOrderHold(FirstOrderHold),
    /// The residuals are rounding.
    NoNoise,
    /// The result of the residual tests, against the reference where that is so.
    Residuals(ResidualFinding, bool),
    /// The residuals correlate with later inputs.
    Feedback(Correlation),
    /// A pole with a negative real part in z, known imprecisely.
    NegativePole(Uncertain),
    /// A pole beyond the unit circle.
    UnstablePole(Uncertain),
    /// A pole that a zero may cancel.
    CancelledPole(Uncertain),
    /// A model with or without such a pole.
    OtherOrder(OtherOrder),
    /// Samples, few for so many parameters.
    FewSamples(usize, usize),
}

impl Reason {
    /// Whether it says how the model was chosen, rather than what it is worth.
    pub(crate) const fn is_of_the_choice(&self) -> bool {
        matches!(
            self,
            Self::Selected(..)
                | Self::SelectedOfSeveral(_)
                | Self::Order(..)
                | Self::Process(..)
                | Self::SearchedInPart(..)
        )
    }

    /// Whether it speaks against the model.
    #[must_use]
    pub const fn is_against(&self) -> bool {
        match self {
            Self::Doubt(_)
            | Self::LargestOrder(_)
            | Self::LongestDelay(_)
            | Self::HeldOutFit(_, FitRemark::WorseThanMean | FitRemark::Overfitted(_))
            | Self::HeldOutIsNoise(None)
            | Self::FirstPartUndetermined
            | Self::NotLinear { .. }
            | Self::CurveMisses(_)
            | Self::Unsteady
            | Self::InputShare(_, true)
            | Self::InputEffect(..)
            | Self::Inseparable(..)
            | Self::GainUndetermined(_)
            | Self::Early(_)
            | Self::OtherDelay(..)
            | Self::Residuals(ResidualFinding::InLoop(_) | ResidualFinding::Correlated(_), _)
            | Self::Feedback(_)
            | Self::NegativePole(_)
            | Self::UnstablePole(_)
            | Self::CancelledPole(_)
            | Self::FewSamples(..) => true,
            Self::Residuals(ResidualFinding::Coloured(_, is_allowed_for), _) => !*is_allowed_for,
            Self::ProcessF(f, least) => *f < *least,
            _ => false,
        }
    }

    /// What it says, as files and JSON have it.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Validated(..) => "validated",
            Self::Data(_) => "data",
            Self::AtRest => "at_rest",
            Self::Doubt(_) => "doubt",
            Self::SegmentsLeftOut(..) => "segments_left_out",
            Self::SearchedInPart(..) => "searched_in_part",
            Self::Selected(..) | Self::SelectedOfSeveral(_) => "selected",
            Self::Order(..) => "order",
            Self::Process(..) => "process",
            Self::LargestOrder(_) => "largest_order",
            Self::LongestDelay(_) => "longest_delay",
            Self::TwoStages { .. } => "two_stages",
            Self::PredictedFit(_) => "predicted_fit",
            Self::HeldOutFit(..) => "held_out_fit",
            Self::HeldOutIsNoise(_) => "held_out_is_noise",
            Self::ErrorAsElsewhere(_) => "error_as_elsewhere",
            Self::FirstPartUndetermined => "first_part_undetermined",
            Self::WholeRecord(_) => "whole_record",
            Self::Band { .. } => "band",
            Self::NotLinear { .. } => "not_linear",
            Self::Carried(_) => "carried",
            Self::Unsteady => "unsteady",
            Self::InputShare(..) => "input_share",
            Self::InputEffect(..) => "input_effect",
            Self::Inseparable(..) => "inseparable",
            Self::ProcessF(..) => "process_f",
            Self::GainUndetermined(_) => "gain_undetermined",
            Self::Early(_) => "early",
            Self::OtherDelay(..) => "other_delay",
            Self::DirectFeedthrough => "direct_feedthrough",
            Self::Curve(_) => "curve",
            Self::CurveMisses(_) => "curve_misses",
            Self::FirstOrderHold(_) => "lines",
            Self::NoNoise => "no_noise",
            Self::Residuals(..) => "residuals",
            Self::Feedback(_) => "feedback",
            Self::NegativePole(_) => "negative_pole",
            Self::UnstablePole(_) => "unstable_pole",
            Self::CancelledPole(_) => "cancelled_pole",
            Self::OtherOrder(_) => "other_order",
            Self::FewSamples(..) => "few_samples",
        }
    }
}

/// What there is to a fit on held-out data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FitRemark {
    /// Nothing.
    None,
    /// The mean of the output would be better.
    WorseThanMean,
    /// As good as the noise lets a model be, %.
    NoiseLimited(f64),
    /// Very good.
    VeryGood,
    /// Far below the fit on the whole record, %.
    Overfitted(f64),
}

/// The result of the residual tests.
#[derive(Clone, Debug, PartialEq)]
pub enum ResidualFinding {
    /// White and uncorrelated; whether the model explains the data.
    White(bool),
    /// Uncorrelated but not white; whether the standard deviations allow for it.
    Coloured(Correlation, bool),
    /// Correlated significantly, but little.
    LittleCorrelation(Correlation),
    /// Correlated, with an input that follows the output.
    InLoop(Correlation),
    /// Correlated.
    Correlated(Correlation),
}
