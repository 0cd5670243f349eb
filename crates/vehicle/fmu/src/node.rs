//! The common part of an actuator and a vehicle in an FMU: the core of a node, its parameters, and the file that they name with its
//! numbers.

use std::path::Path;

use planesman_parameters::{Parameters as _, Value};

use crate::error::Error;
use crate::numbers::Numbers;
use crate::subject::{Parameters, Simulation, Subject};
use crate::variable::Variable;

/// The core of a node, run tick by tick. A clone has exactly the same future.
pub(crate) trait Core: Clone + Send + Sized + 'static {
    /// The node's.
    type Parameters: planesman_parameters::Parameters + Clone + Send + Sync;
    /// The simulated file, after reading.
    type File;
    /// The node's parameter with the file's path.
    const FILE: &'static str;
    /// The node's parameters with special values in FMUs.
    const HELD: &'static [(&'static str, f64)] = &[];
    /// Beginnings of the names of parameters that have an effect only at the start.
    const FIXED: &'static [&'static str] = &[];

    /// Reads a file from its text; `name` is its name in errors.
    ///
    /// # Errors
    /// If the text is invalid.
    fn read(name: &str, text: &str) -> Result<Self::File, Error>;

    /// Inputs and outputs.
    fn variables(file: &Self::File) -> Vec<Variable>;

    /// Whether the FMU has a parameter of the node.
    fn has(file: &Self::File, parameter: &str) -> bool;

    /// # Errors
    /// If parameters conflict.
    fn new(parameters: &Self::Parameters, file: Self::File) -> Result<Self, Error>;

    /// Like [`Simulation::set_parameters`].
    fn set_parameters(&mut self, parameters: &Self::Parameters) -> Result<(), Error>;

    /// Like [`Simulation::advance`].
    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error>;

    /// Like [`Simulation::outputs`].
    fn outputs(&self) -> Vec<Value>;
}

/// A node's core before the simulation starts.
pub(crate) struct Node<C: Core> {
    name: String,
    numbers: Numbers,
    parameters: C::Parameters,
    tick: f64,
    variables: Vec<Variable>,
}

impl<C: Core> Node<C> {
    /// # Errors
    /// If a file or a tick is invalid.
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

/// A node's parameters with the changes to parameters that it declares.
///
/// # Errors
/// If a value does not match its declaration.
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

/// A running core of a node.
#[derive(Clone)]
struct Running<C: Core> {
    /// The initial parameters; a change gives all that may change.
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
