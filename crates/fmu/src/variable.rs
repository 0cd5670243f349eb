//! The variables of an FMU: one table, from which `modelDescription.xml` is written and by which values are read and set.

use planesman_parameters::{Declaration, Value};

/// What a variable is to the importer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Causality {
    /// Set by the importer before each step, and held over the ticks that begin in it.
    Input,
    /// Computed; it depends at once on the inputs at these places among the inputs.
    Output(Vec<usize>),
    /// A constant of the simulation; one that is not read-only may change between steps.
    Parameter,
}

/// A variable: its name, type, unit, range and start value, and what it is to the importer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variable {
    pub(crate) declaration: Declaration,
    pub(crate) causality: Causality,
}

impl Variable {
    /// An input, 0 at first.
    pub(crate) fn input(name: String, unit: &'static str, description: &'static str) -> Self {
        Self {
            declaration: Declaration::of(name, &0.0, description).unit(unit),
            causality: Causality::Input,
        }
    }

    /// The same within a closed interval.
    pub(crate) fn within(self, low: f64, high: f64) -> Self {
        Self {
            declaration: self.declaration.range(low, high),
            ..self
        }
    }

    /// An output of the type of `like`, which depends on no input at once.
    pub(crate) fn output(
        name: String,
        like: &Value,
        unit: &'static str,
        description: &'static str,
    ) -> Self {
        let declaration = Declaration {
            default: like.clone(),
            ..Declaration::of(name, &0.0, description).unit(unit)
        };
        Self {
            declaration,
            causality: Causality::Output(Vec::new()),
        }
    }

    /// A parameter as a node declares it; `fixed`: once the simulation has begun, it stays.
    pub(crate) fn parameter(declaration: Declaration, fixed: bool) -> Self {
        Self {
            declaration: match fixed {
                true => declaration.read_only(),
                false => declaration,
            },
            causality: Causality::Parameter,
        }
    }
}
