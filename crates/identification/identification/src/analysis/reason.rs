//! Reasons for and against a model: findings with their numbers. The module `sentences` expresses them in words.

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
    /// Number of validation samples, simulated fit on them, fit of predictions.
    Validated(usize, Option<f64>, Option<f64>),
    /// A finding from reading the data that affects the model, as a sentence.
    Data(String),
    /// The output is constant until the input steps: the record is assumed to begin at rest.
    AtRest,
    /// The record may not determine the model.
    Doubt(Doubt),
    /// Number of used segments, number of all segments, share of the samples.
    SegmentsLeftOut(usize, usize, f64),
    /// Number of samples used for the search of order and delay, and number of all samples.
    SearchedInPart(usize, usize),
    /// Number of cross-validated models, the chosen model, and the model with the largest fit if that is larger.
    Selected(usize, Box<Candidate>, Option<Box<Candidate>>),
    /// The model that cross-validation selected for several inputs, as a sentence.
    SelectedOfSeveral(String),
    /// The order and delay chosen by criteria, and the next best order.
    Order(criteria::Candidate, Option<criteria::Candidate>),
    /// The chosen process model, and the next best form with the difference of their criteria.
    Process(process::Candidate, Option<(Form, f64)>),
    /// The chosen order is the largest one searched.
    LargestOrder(usize),
    /// The chosen delay is the longest one searched.
    LongestDelay(usize),
    /// The response by the two-stage method and by a direct fit, at the frequency where they differ most.
    TwoStages {
        /// The frequency, rad/s.
        frequency: f64,
        /// The reference's name.
        reference: String,
        /// The magnitude by the two-stage method, and its standard deviation.
        staged: (f64, f64),
        /// The magnitude by the direct fit, and its standard deviation.
        direct: (f64, f64),
        /// The difference in standard deviations, if it is significant.
        apart: Option<f64>,
    },
    /// The model is unstable, so it is judged by its predictions; their fit, %.
    PredictedFit(f64),
    /// The simulated fit on held-out data.
    HeldOutFit(f64, FitRemark),
    /// The held-out output stays within the noise; the cross-validated fit, %, if the verdict uses it.
    HeldOutIsNoise(Option<f64>),
    /// The held-out error is no larger than elsewhere, though the output moves less; the cross-validated fit, %, which the verdict uses.
    ErrorAsElsewhere(Option<f64>),
    /// Not validated: the first part of the record alone does not determine the model.
    FirstPartUndetermined,
    /// The first part of the record alone does not excite the band; the simulated fit on the complete record, %.
    WholeRecord(Option<f64>),
    /// The band with sufficient coherence.
    Band {
        /// The lowest and the highest frequency, rad/s.
        band: (f64, f64),
        /// The least coherence.
        coherence: f64,
        /// Cost J of the transfer function in this band.
        cost: f64,
    },
    /// A nonlinear or time-varying model, or a disturbance, explains the error.
    NotLinear {
        /// The cause of the error.
        finding: Finding,
        /// The interval between samples, s.
        sample_time: f64,
        /// The segment's number, from 1, if there are several.
        segment: Option<usize>,
    },
    /// The simulated fit on held-out data, %, with the initial state from the samples before it.
    Carried(f64),
    /// A model of one half of the record does not fit the other half.
    Unsteady,
    /// The input's share of the output's variation, 0 to 1, and whether it is too small to determine the gain.
    InputShare(f64, bool),
    /// The F statistic of one of several inputs, the required F, and whether the model contains the input.
    InputEffect(f64, f64, bool),
    /// Another input that explains nearly all of this input's variation, and the remaining independent share.
    Inseparable(String, f64),
    /// The F statistic of a process model relative to the noise, and the required F.
    ProcessF(f64, f64),
    /// The steady-state gain, which is uncertain.
    GainUndetermined(Uncertain),
    /// Number of samples by which the output seems to precede the input.
    Early(i64),
    /// The delay that fits better, and the model's delay.
    OtherDelay(i64, usize),
    /// The output responds within one sample.
    DirectFeedthrough,
    /// A static curve before or after the dynamics.
    Curve(Curved),
    /// The amount, %, by which the fit with the curve is below the limit set by noise.
    CurveMisses(f64),
    /// The input moves on straight lines between its samples.
    FirstOrderHold(FirstOrderHold),
    /// The residuals are only rounding error.
    NoNoise,
    /// The result of the residual tests, and whether they use the reference instead of the input.
    Residuals(ResidualFinding, bool),
    /// The residuals correlate with later inputs.
    Feedback(Correlation),
    /// A pole in z with a negative real part and a wide interval.
    NegativePole(Uncertain),
    /// A pole outside the unit circle.
    UnstablePole(Uncertain),
    /// A pole that a zero may cancel.
    CancelledPole(Uncertain),
    /// A model with or without a pole that a zero may cancel.
    OtherOrder(OtherOrder),
    /// Number of samples, which is small for the number of parameters.
    FewSamples(usize, usize),
}

impl Reason {
    /// Whether the reason explains the choice of the model, in contrast to its quality.
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

    /// Whether the reason is evidence against the model.
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

    /// The reason's code in files and JSON.
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

/// Remark on a fit on held-out data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FitRemark {
    /// Nothing.
    None,
    /// The output's mean would fit better.
    WorseThanMean,
    /// The fit reaches the limit set by noise, %.
    NoiseLimited(f64),
    /// Very good.
    VeryGood,
    /// The fit is far below the fit on the whole record, %.
    Overfitted(f64),
}

/// The result of the residual tests.
#[derive(Clone, Debug, PartialEq)]
pub enum ResidualFinding {
    /// The residuals are white and uncorrelated with the input; whether the model explains the data.
    White(bool),
    /// The residuals are uncorrelated with the input but not white; whether the standard deviations are valid for this colour.
    Coloured(Correlation, bool),
    /// The residuals are correlated significantly, but little.
    LittleCorrelation(Correlation),
    /// The residuals are correlated, but the input follows the output.
    InLoop(Correlation),
    /// Correlated.
    Correlated(Correlation),
}
