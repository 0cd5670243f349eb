//! The thread that waits for timers and sockets.

use std::os::unix::net::UnixStream;
use std::panic;

use anyhow::bail;

/// Starts the thread. Its library would start it at the first timer, and panics where the system gives none; whoever starts
/// another thread returns an error.
///
/// # Errors
/// When the system refuses it.
pub(crate) fn start() -> anyhow::Result<()> {
    let told = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let started = panic::catch_unwind(smol::Async::<UnixStream>::pair);
    panic::set_hook(told);
    match started {
        Ok(pair) => drop(pair?),
        Err(_) => {
            bail!("the system gives no thread, or no file, for timers (see ulimit -u and -n)")
        }
    }
    Ok(())
}
