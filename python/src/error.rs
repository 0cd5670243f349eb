//! Errors as Python's exceptions: one line, as on the terminal.

use clap::Parser;
use planesman::arguments::one_line;
use planesman_node::in_one_line;
use pyo3::exceptions::PyValueError;
use pyo3::{PyErr, PyResult, Python, create_exception};

create_exception!(
    planesman,
    PlanesmanError,
    PyValueError,
    "What was refused, where it came from, and what would be accepted."
);

/// An error as an exception; one that is an exception already, as Ctrl-C's, is passed on.
pub(crate) fn raised(error: anyhow::Error) -> PyErr {
    match error.downcast::<PyErr>() {
        Ok(exception) => exception,
        Err(error) => PlanesmanError::new_err(in_one_line(&error)),
    }
}

/// The arguments of a command, without the program's name.
///
/// # Errors
/// As the command line refuses them.
pub(crate) fn parsed<P: Parser>(args: &[String]) -> PyResult<P> {
    let named = std::iter::once("planesman").chain(args.iter().map(String::as_str));
    P::try_parse_from(named).map_err(|error| PlanesmanError::new_err(one_line(&error)))
}

/// Work with the interpreter released.
///
/// # Errors
/// Those of the work.
pub(crate) fn released<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> anyhow::Result<T> + Send,
) -> PyResult<T> {
    py.detach(work).map_err(raised)
}

/// Whether the user wants no more: the exception of a signal that came meanwhile.
///
/// # Errors
/// `KeyboardInterrupt`, or what another handler raised.
pub(crate) fn interrupted() -> anyhow::Result<()> {
    Ok(Python::attach(|py| py.check_signals())?)
}
