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
/// `default`, the `unit`, the direction in which its numbers are `positive` (as `"down"`), their closed interval
/// `range`, and `read_only` for a parameter that is set at start-up only. A field without the attribute is a
/// group: its parameters are named `field.parameter`.
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

impl Values {
    /// The defaults of a struct of parameters.
    #[must_use]
    pub fn of<P: Parameters>() -> Self {
        Self::defaults(P::declarations())
    }
}

/// The name of a parameter in a group; `under` is the group's name, `""` for none.
#[must_use]
pub fn dotted(under: &str, name: &str) -> String {
    match under {
        "" => name.to_owned(),
        under => format!("{under}.{name}"),
    }
}
