//! Options of the analysis, and the structures that they ask for.

use super::curve::CurveChoice;
use crate::estimators::{FrequencyDomain, Knowledge, Method, Property, TransferConstraints};
use crate::structure::{InitialState, Structure};

/// Options of the analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How to estimate.
    pub method: Method,
    /// Knowledge that the method begins with.
    pub knowledge: Knowledge,
    /// The order, known poles not counted; `None` to search.
    pub order: Option<usize>,
    /// Coefficients of the numerator, known zeros not counted; `None` for as many as the order.
    pub numerator: Option<usize>,
    /// Samples from input to first effect; `None` to search it beside the order, and for 1 with an order
    /// that is given.
    pub delay: Option<usize>,
    /// Zeros known to be at z = 1.
    pub zeros_at_one: usize,
    /// Poles known to be at z = 1.
    pub integrators: usize,
    /// Seek an offset of the output.
    pub offset: bool,
    /// How each segment begins.
    pub start: InitialState,
    /// The segments have only their poles in common.
    pub own_numerators: bool,
    /// The moment of inertia, where it is known: what turns `K/J` into `K`.
    pub inertia: Option<f64>,
    /// The vehicle's speed, m/s, for the model file.
    pub speed: Option<f64>,
    /// Simulated records of a bootstrap; `None` for none.
    pub bootstrap: Option<usize>,
    /// The static curve that is tried.
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
    /// The structure of a model with so many poles beside the known ones.
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
