//! Errors as Python's exceptions: one line, in Python's words. And work with the interpreter released, which Ctrl-C ends.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use anyhow::Context as _;
use planesman_identification::{Stop, until_stopped};
use planesman_text::in_one_line;
use pyo3::exceptions::PyValueError;
use pyo3::{Py, PyAny, PyErr, PyResult, Python, create_exception};

/// Time between two looks for Ctrl-C.
const SIGNAL_POLL_INTERVAL: Duration = Duration::from_millis(50);

create_exception!(
    planesman,
    PlanesmanError,
    PyValueError,
    "What was refused, where it came from, and what would be accepted."
);

/// An error as an exception; one that is an exception already, as Ctrl-C's, is passed on.
pub(crate) fn raised(error: impl Into<anyhow::Error>) -> PyErr {
    match error.into().downcast::<PyErr>() {
        Ok(exception) => exception,
        Err(error) => PlanesmanError::new_err(in_one_line(error.as_ref())),
    }
}

/// Work with the interpreter released, on a thread of its own: Python's signals come to this one, which looks for them meanwhile.
/// The work ends at its next stop point once a handler has raised.
///
/// # Errors
/// Those of the work; `KeyboardInterrupt`, or what another handler raised.
pub(crate) fn released<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> anyhow::Result<T> + Send,
) -> PyResult<T> {
    watched(py, &Watch::default(), work)
}

/// Who is told how far work has come.
#[derive(Default)]
pub(crate) struct Watch {
    /// Called with the steps done, now and then.
    pub(crate) told: Option<Py<PyAny>>,
    /// Steps done.
    pub(crate) done: AtomicU64,
}

impl Watch {
    pub(crate) fn new(told: Option<Py<PyAny>>) -> Self {
        let done = AtomicU64::new(0);
        Self { told, done }
    }

    /// Looks for signals, and tells.
    fn look(&self) -> PyResult<()> {
        Python::attach(|py| {
            py.check_signals()?;
            match &self.told {
                Some(told) => told
                    .call1(py, (self.done.load(Ordering::Relaxed),))
                    .map(drop),
                None => Ok(()),
            }
        })
    }
}

/// As [`released`], of work whose progress somebody is told of.
///
/// # Errors
/// As [`released`], and what the one who is told raises.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    watch: &Watch,
    work: impl FnOnce() -> anyhow::Result<T> + Send,
) -> PyResult<T> {
    let stop = Stop::default();
    py.detach(|| {
        std::thread::scope(|scope| {
            let (ended, end) = channel::<()>();
            let worker = std::thread::Builder::new().spawn_scoped(scope, || {
                // Dropped with the work, however that ends.
                let _ended = ended;
                until_stopped(&stop, work)
            });
            let worker = worker.context("cannot start a thread").map_err(raised)?;
            let interrupted = loop {
                match end.recv_timeout(SIGNAL_POLL_INTERVAL) {
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(exception) = watch.look() {
                            stop.ask();
                            break Some(exception);
                        }
                    }
                    Ok(()) | Err(RecvTimeoutError::Disconnected) => break None,
                }
            };
            let outcome = match worker.join() {
                Ok(outcome) => outcome,
                Err(panic) => std::panic::resume_unwind(panic),
            };
            match (interrupted, outcome) {
                (Some(exception), _) => Err(exception),
                (None, Some(outcome)) => outcome.map_err(raised),
                (None, None) => Err(PlanesmanError::new_err("the work was stopped")),
            }
        })
    })
}
