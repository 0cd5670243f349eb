//! Options of the analysis, and the structures that they define.

use super::curve::CurveChoice;
use crate::estimators::{FrequencyDomain, Knowledge, Method, Property, TransferConstraints};
use crate::structure::{InitialState, Structure};

/// Options of the analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How to estimate.
    pub method: Method,
    /// Prior knowledge used by the method.
    pub knowledge: Knowledge,
    /// The order, without known poles; `None` to search it.
    pub order: Option<usize>,
    /// Number of numerator coefficients, without known zeros; `None` for the same number as the order.
    pub numerator: Option<usize>,
    /// Samples from the input to its first effect; `None` to search it together with the order, or for 1 if an order is given.
    pub delay: Option<usize>,
    /// Zeros known to be at z = 1.
    pub zeros_at_one: usize,
    /// Poles known to be at z = 1.
    pub integrators: usize,
    /// Whether to estimate an offset of the output.
    pub offset: bool,
    /// Initial state of each segment.
    pub start: InitialState,
    /// Whether the segments share only their poles.
    pub own_numerators: bool,
    /// The moment of inertia, if known: the factor between `K/J` and `K`.
    pub inertia: Option<f64>,
    /// The vehicle's speed, m/s, for the model file.
    pub speed: Option<f64>,
    /// Number of simulated records of a bootstrap; `None` for no bootstrap.
    pub bootstrap: Option<usize>,
    /// The static curve to try.
    pub curve: CurveChoice,
}

impl Default for Options {
    /// Everything searched.
    fn default() -> Self {
        Self {
            method: Method::Automatic,
            knowledge: Knowledge::default(),
            order: None,
            numerator: None,
            delay: None,
            zeros_at_one: 0,
            integrators: 0,
            offset: true,
            start: InitialState::Estimated,
            own_numerators: false,
            inertia: None,
            speed: None,
            bootstrap: None,
            curve: CurveChoice::default(),
        }
    }
}

impl Options {
    /// The structure of a model with this many poles in addition to the known poles.
    pub(super) fn structure(&self, order: usize) -> Structure {
        let has_no_poles = self.method.has(Property::HasNoPoles);
        let order = if has_no_poles { 0 } else { order };
        let mut structure = Structure {
            offset: self.offset,
            start: self.start,
            // A static gain acts at once.
            delay: self.delay.unwrap_or(usize::from(order > 0 || has_no_poles)),
            own_numerators: self.own_numerators,
            ..Structure::of_order(order)
        };
        for _ in 0..self.zeros_at_one {
            structure = structure.with_zero_at_one();
        }
        for _ in 0..self.integrators {
            structure = structure.with_integrator();
        }
        structure.poles = order;
        structure.numerator = self.numerator.unwrap_or(structure.numerator).max(1);
        structure
    }

    /// The search in the frequency domain.
    pub(super) fn frequency_domain(
        &self,
        sample_time: f64,
        references: &[&[f64]],
    ) -> FrequencyDomain {
        FrequencyDomain {
            given: TransferConstraints {
                poles: self.order,
                zeros: self.numerator.map(|count| count.saturating_sub(1)),
                // The first effect of a held input is seen a sample later.
                delay: self
                    .delay
                    .map(|delay| delay.saturating_sub(1) as f64 * sample_time),
                integrators: self.integrators,
                differentiators: self.zeros_at_one,
            },
            coherence: self.knowledge.coherence,
            references: references.iter().map(|it| it.to_vec()).collect(),
            ..FrequencyDomain::default()
        }
    }
}
