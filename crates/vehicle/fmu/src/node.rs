//! What an actuator and a vehicle have in common in an FMU: the core of a node, its parameters, and the numbers of the file that they name.

use std::path::Path;

use planesman_parameters::{Parameters as _, Value};

use crate::error::Error;
use crate::numbers::Numbers;
use crate::subject::{Parameters, Simulation, Subject};
use crate::variable::Variable;

/// The core of a node, tick by tick. A clone has the same future.
pub(crate) trait Core: Clone + Send + Sized + 'static {
    /// The node's.
    type Parameters: planesman_parameters::Parameters + Clone + Send + Sync;
    /// The file that is simulated, read.
    type File;
    /// The node's parameter that names the file.
    const FILE: &'static str;
    /// The node's parameters that have a value of their own in FMUs.
    const HELD: &'static [(&'static str, f64)] = &[];
    /// Beginnings of the names of parameters that count at the start alone.
    const FIXED: &'static [&'static str] = &[];

    /// The file of this text; `name` is what errors call it.
    ///
    /// # Errors
    /// A text that is not taken.
    fn read(name: &str, text: &str) -> Result<Self::File, Error>;

    /// Inputs and outputs.
    fn variables(file: &Self::File) -> Vec<Variable>;

    /// Whether a parameter of the node is the FMU's.
    fn has(file: &Self::File, parameter: &str) -> bool;

    /// # Errors
    /// Parameters that do not go together.
    fn new(parameters: &Self::Parameters, file: Self::File) -> Result<Self, Error>;

    /// As [`Simulation::set_parameters`].
    fn set_parameters(&mut self, parameters: &Self::Parameters) -> Result<(), Error>;

    /// As [`Simulation::advance`].
    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error>;

    /// As [`Simulation::outputs`].
    fn outputs(&self) -> Vec<Value>;
}

/// A node's core before it runs.
pub(crate) struct Node<C: Core> {
    name: String,
    numbers: Numbers,
    parameters: C::Parameters,
    tick: f64,
    variables: Vec<Variable>,
}

impl<C: Core> Node<C> {
    /// # Errors
    /// A file or a tick that is not taken.
    pub(crate) fn load(file: &Path, text: &str, tick: Option<f64>) -> Result<Self, Error> {
        let name = file.display().to_string();
        let read = C::read(&name, text)?;
        let mut own = vec![(C::FILE, Value::String(name.clone()))];
        let held = C::HELD.iter().copied().chain(tick.map(|it| ("tick", it)));
        own.extend(held.map(|(name, value)| (name, value.into())));
        let parameters = C::Parameters::default().with(&own)?;
        let declared = C::Parameters::declarations().into_iter();
        let declared = declared.filter(|it| C::has(&read, &it.name)).map(|it| {
            let fixed = C::FIXED.iter().any(|fixed| it.name.starts_with(fixed));
            Variable::parameter(it, fixed)
        });
        let numbers = Numbers::of(text, |text| C::read(&name, text).is_ok());
        Ok(Self {
            tick: parameters.values().read("tick")?,
            variables: (C::variables(&read).into_iter())
                .chain(declared)
                .chain(numbers.variables())
                .collect(),
            name,
            numbers,
            parameters,
        })
    }
}

/// A node's parameters with those of the changes that it declares.
///
/// # Errors
/// A value against its declaration.
fn changed<P: planesman_parameters::Parameters>(
    parameters: &P,
    changes: &Parameters,
) -> Result<P, Error> {
    let values = parameters.values();
    let declared = changes.iter().filter(|it| values.get(&it.0).is_some());
    Ok(P::from_values(&values.with(declared.cloned())?)?)
}

impl<C: Core> Subject for Node<C> {
    fn tick(&self) -> f64 {
        self.tick
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn begin(&self, parameters: &Parameters) -> Result<Box<dyn Simulation>, Error> {
        let file = C::read(&self.name, &self.numbers.text(parameters))?;
        let parameters = changed(&self.parameters, parameters)?;
        Ok(Box::new(Running {
            core: C::new(&parameters, file)?,
            parameters,
        }))
    }
}

/// A node's core that runs.
#[derive(Clone)]
struct Running<C: Core> {
    /// Those at the begin; a change gives all that may change.
    parameters: C::Parameters,
    core: C,
}

impl<C: Core> Simulation for Running<C> {
    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let parameters = changed(&self.parameters, parameters)?;
        self.core.set_parameters(&parameters)
    }

    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error> {
        self.core.advance(inputs)
    }

    fn outputs(&self, _: &[f64]) -> Vec<Value> {
        self.core.outputs()
    }

    fn copy(&self) -> Box<dyn Simulation> {
        Box::new(self.clone())
    }
}
