//! The thread that waits for timers and sockets.

use crate::error::{Error, Result};
use std::os::unix::net::UnixStream;
use std::panic;

/// Starts the thread. The timer library would start the thread at the first timer, and would panic if the system provides no thread; here this is an
/// error.
///
/// # Errors
/// The system provides no thread.
pub(crate) fn start() -> Result<()> {
    let told = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let started = panic::catch_unwind(smol::Async::<UnixStream>::pair);
    panic::set_hook(told);
    match started {
        Ok(Ok(_)) => Ok(()),
        Ok(Err(reason)) => Err(Error::Failed(reason.to_string())),
        Err(_) => Err(Error::Timers),
    }
}
