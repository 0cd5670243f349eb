//! Parameters as fields of a struct.

use crate::{Declaration, Refusal, Value, Values};

/// A struct whose fields are a node's parameters, or groups of them; usually derived.
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
/// The doc comment of a field is the parameter's description. The attribute `#[parameter(...)]` gives the `default`, the `unit`, the direction of
/// `positive` numbers (such as `"down"`), their closed interval `range`, and `read_only` for a parameter that can be set only at the start. A
/// field without the attribute is a group: its parameters are named `field.parameter`.
pub trait Parameters: Default {
    /// Appends the declarations of all fields, in order, with the present values as defaults; `under`: name of the group, `""` at the top.
    fn declare(&self, under: &str, declarations: &mut Vec<Declaration>);

    /// Reads the fields from `values`.
    ///
    /// # Errors
    /// A [`Refusal`] if a field is not declared there.
    fn read(under: &str, values: &Values) -> Result<Self, Refusal>;

    /// All declarations.
    #[must_use]
    fn declarations() -> Vec<Declaration> {
        let mut declarations = Vec::new();
        Self::default().declare("", &mut declarations);
        declarations
    }

    /// These parameters as values with their names.
    #[must_use]
    fn values(&self) -> Values {
        let mut present = Vec::new();
        self.declare("", &mut present);
        Values::defaults(present)
    }

    /// These parameters after changes by name, as allowed at a node's start.
    ///
    /// # Errors
    /// The first [`Refusal`]: an undeclared name, or a value refused by its declaration.
    fn with(&self, changes: &[(&str, Value)]) -> Result<Self, Refusal> {
        let changes = changes
            .iter()
            .map(|(name, value)| ((*name).to_owned(), value.clone()));
        Self::from_values(&self.values().with(changes)?)
    }

    /// Reads the struct from `values`.
    ///
    /// # Errors
    /// A [`Refusal`] if a field is not declared there.
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
    /// The default values of a struct of parameters.
    #[must_use]
    pub fn of<P: Parameters>() -> Self {
        Self::defaults(P::declarations())
    }
}

/// Name of a parameter in a group; `under` is the name of the group, `""` without a group.
#[must_use]
pub fn dotted(under: &str, name: &str) -> String {
    match under {
        "" => name.to_owned(),
        under => format!("{under}.{name}"),
    }
}
