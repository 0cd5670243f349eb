//! Errors as Python exceptions of one line, in Python's terms; long work that releases the interpreter and that Ctrl-C can stop.

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
    "What was refused, where it was found, and what is allowed."
);

/// Converts an error to an exception; an error that is already an exception, such as that of Ctrl-C, is returned unchanged.
pub(crate) fn raised(error: impl Into<anyhow::Error>) -> PyErr {
    match error.into().downcast::<PyErr>() {
        Ok(exception) => exception,
        Err(error) => PlanesmanError::new_err(in_one_line(error.as_ref())),
    }
}

/// Does work on a separate thread while the interpreter is released; this thread checks for Python's signals.
/// When a signal handler raises an exception, the work ends at its next stop point.
///
/// # Errors
/// The error of the work; `KeyboardInterrupt`, or the exception of another handler.
pub(crate) fn released<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> anyhow::Result<T> + Send,
) -> PyResult<T> {
    watched(py, &Watch::default(), work)
}

/// The progress of work, and its callback.
#[derive(Default)]
pub(crate) struct Watch {
    /// The callback, called repeatedly with the number of completed steps.
    pub(crate) told: Option<Py<PyAny>>,
    /// The number of completed steps.
    pub(crate) done: AtomicU64,
}

impl Watch {
    pub(crate) fn new(told: Option<Py<PyAny>>) -> Self {
        let done = AtomicU64::new(0);
        Self { told, done }
    }

    /// Checks for signals and calls the callback.
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

/// Like [`released`], with a callback for progress.
///
/// # Errors
/// Like [`released`], and the exception of the callback.
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
                (None, None) => Err(PlanesmanError::new_err("the work was cancelled")),
            }
        })
    })
}
