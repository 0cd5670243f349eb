//! The variables of an FMU: one table, used to write `modelDescription.xml` and to read and set values.

use planesman_parameters::{Declaration, Value};

/// The role of a variable for the importer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Causality {
    /// Set by the importer before each step, and held over the ticks that begin in the step.
    Input,
    /// Computed; with direct feedthrough from the inputs with these indices.
    Output(Vec<usize>),
    /// A constant of the simulation; one that is not read-only may change between steps.
    Parameter,
}

/// A variable: its name, type, unit, range, start value and causality.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variable {
    pub(crate) declaration: Declaration,
    pub(crate) causality: Causality,
}

impl Variable {
    /// An input with the initial value 0.
    pub(crate) fn input(name: String, unit: &'static str, description: &'static str) -> Self {
        Self {
            declaration: Declaration::of(name, &0.0, description).unit(unit),
            causality: Causality::Input,
        }
    }

    /// The variable, limited to a closed interval.
    pub(crate) fn within(self, low: f64, high: f64) -> Self {
        Self {
            declaration: self.declaration.range(low, high),
            ..self
        }
    }

    /// An output from a field of a message.
    pub(crate) fn field<M: Default>(field: &Field<M>) -> Self {
        let like = (field.of)(&M::default());
        Self::output(field.name.to_owned(), &like, field.unit, field.description)
    }

    /// An output with the type of `like`, without direct feedthrough.
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

    /// A parameter from a node's declaration; if `fixed`, it cannot change during the simulation.
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

/// A message field that is an output.
pub(crate) struct Field<M> {
    pub(crate) name: &'static str,
    /// Unit, as in the message's definition; `""` for counts and flags.
    pub(crate) unit: &'static str,
    pub(crate) description: &'static str,
    pub(crate) of: fn(&M) -> Value,
}

/// Fields of a message: name, unit, description.
macro_rules! fields {
    ($message:ty: $($name:ident, $unit:literal, $description:literal;)*) => {
        &[$($crate::variable::Field::<$message> {
            name: stringify!($name),
            unit: $unit,
            description: $description,
            of: |it| $crate::variable::Read::value(&it.$name),
        }),*]
    };
}
pub(crate) use fields;

/// A field's value as a value of an FMU.
pub(crate) trait Read {
    fn value(&self) -> Value;
}

macro_rules! read {
    ($($kind:ty: |$it:ident| $value:expr;)*) => {$(
        impl Read for $kind {
            fn value(&self) -> Value {
                let $it = *self;
                $value
            }
        }
    )*};
}

read! {
    f64: |it| Value::Double(it);
    bool: |it| Value::Bool(it);
    i8: |it| Value::Integer(it.into());
    u8: |it| Value::Integer(it.into());
    u64: |it| Value::Integer(i64::try_from(it).unwrap_or(i64::MAX));
}
