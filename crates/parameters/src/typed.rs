//! Parameters as the fields of a struct.

use crate::{Declaration, Refusal, Value, Values};

/// A struct whose fields are a node's parameters, or groups of them: derive it.
///
/// ```
/// use planesman_parameters::{Choice, Parameters, Values};
///
/// /// The control mode.
/// #[derive(Clone, Copy, Debug, PartialEq, Choice)]
/// enum Mode {
///     Off,
///     Depth,
/// }
///
/// /// The parameters of a controller.
/// #[derive(Clone, Debug, PartialEq, Parameters)]
/// struct Controller {
///     /// Control mode.
///     #[parameter(default = Mode::Depth)]
///     mode: Mode,
///     depth: DepthLoop,
/// }
///
/// /// The parameters `depth.*`.
/// #[derive(Clone, Debug, PartialEq, Parameters)]
/// struct DepthLoop {
///     /// Pitch command per depth error.
///     #[parameter(default = 0.82, unit = "rad/m", range = 0.0..=1e3)]
///     p: f64,
/// }
///
/// let values = Values::of::<Controller>();
/// assert_eq!(values.declarations()[1].name, "depth.p");
/// assert_eq!(Controller::from_values(&values), Ok(Controller::default()));
/// ```
///
/// The doc comment of a field is the parameter's description. Its attribute `#[parameter(...)]` gives the
/// `default`, the `unit`, the closed interval `range` of its numbers, and `read_only` for a parameter that is set
/// at start-up only. A field without the attribute is a group: its parameters are named `field.parameter`.
pub trait Parameters: Default {
    /// Appends the declarations of all fields, in their order, with the present values as defaults; `under` is
    /// the name of the group, `""` at the top.
    fn declare(&self, under: &str, declarations: &mut Vec<Declaration>);

    /// The fields out of `values`.
    ///
    /// # Errors
    /// A [`Refusal`] when a field is not declared there.
    fn read(under: &str, values: &Values) -> Result<Self, Refusal>;

    /// All declarations.
    #[must_use]
    fn declarations() -> Vec<Declaration> {
        let mut declarations = Vec::new();
        Self::default().declare("", &mut declarations);
        declarations
    }

    /// These parameters by name.
    #[must_use]
    fn values(&self) -> Values {
        let mut present = Vec::new();
        self.declare("", &mut present);
        Values::defaults(present)
    }

    /// These parameters with changes by name, as a node would take them at its start.
    ///
    /// # Errors
    /// The first [`Refusal`]: a name that is not declared, or a value against its declaration.
    fn with(&self, changes: &[(&str, Value)]) -> Result<Self, Refusal> {
        let changes = changes
            .iter()
            .map(|(name, value)| ((*name).to_owned(), value.clone()));
        Self::from_values(&self.values().with(changes)?)
    }

    /// The struct out of `values`.
    ///
    /// # Errors
    /// A [`Refusal`] when a field is not declared there.
    fn from_values(values: &Values) -> Result<Self, Refusal> {
        Self::read("", values)
    }
}

/// No parameters.
impl Parameters for () {
    fn declare(&self, _: &str, _: &mut Vec<Declaration>) {}

    fn read(_: &str, _: &Values) -> Result<Self, Refusal> {
        Ok(())
    }
}

/// A text parameter with a closed list of values: derive it for an enum without fields.
pub trait Choice: Copy {
    /// The values as users write them, in snake case.
    const NAMES: &'static [&'static str];

    /// The value as users write it.
    fn name(self) -> &'static str;

    /// The variant of that name.
    fn named(name: &str) -> Option<Self>;
}

/// A Rust type that a parameter may have.
pub trait ParameterType: Sized {
    /// The only texts accepted; empty when any is.
    const CHOICES: &'static [&'static str] = &[];

    /// The ROS value.
    fn to_value(&self) -> Value;

    /// The Rust value; `None` when the ROS value is of another type or does not fit.
    fn from_value(value: &Value) -> Option<Self>;
}

macro_rules! parameter_types {
    ($($rust:ty => $ros:ident),* $(,)?) => {$(
        impl ParameterType for $rust {
            fn to_value(&self) -> Value {
                Value::$ros(self.clone())
            }

            fn from_value(value: &Value) -> Option<Self> {
                match value {
                    Value::$ros(it) => Some(it.clone()),
                    _ => None,
                }
            }
        }
    )*};
}

parameter_types! {
    bool => Bool,
    i64 => Integer,
    f64 => Double,
    String => String,
    Vec<f64> => DoubleArray,
    Vec<String> => StringArray,
}

macro_rules! counts {
    ($($rust:ty),*) => {$(
        impl ParameterType for $rust {
            fn to_value(&self) -> Value {
                Value::Integer(i64::try_from(*self).unwrap_or(i64::MAX))
            }

            fn from_value(value: &Value) -> Option<Self> {
                match value {
                    Value::Integer(count) => Self::try_from(*count).ok(),
                    _ => None,
                }
            }
        }
    )*};
}

counts!(u32, u64, usize);

/// The name of a parameter in a group; `under` is the group's name, `""` for none.
#[must_use]
pub fn dotted(under: &str, name: &str) -> String {
    match under {
        "" => name.to_owned(),
        under => format!("{under}.{name}"),
    }
}
