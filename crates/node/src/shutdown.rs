//! SIGINT, SIGTERM and SIGHUP as events.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
use smol::channel::{Receiver, Sender, bounded};

/// Whether nobody waits for a request any more.
static AT_ONCE: AtomicBool = AtomicBool::new(false);

/// The exit status of a process that a request has ended, as shells have it for SIGINT.
const INTERRUPTED: i32 = 130;

/// From now on a request ends the process: it has only work to do that nothing is lost with, and nobody reads
/// [`requested`] any more.
pub fn at_once() {
    AT_ONCE.store(true, Ordering::Relaxed);
}

/// Becomes ready when the process has been asked to stop.
///
/// # Errors
/// When the signal handler cannot be installed.
pub fn requested() -> anyhow::Result<Receiver<()>> {
    static CHANNEL: OnceLock<(Sender<()>, Receiver<()>)> = OnceLock::new();
    let mut fresh = false;
    let (sender, receiver) = CHANNEL.get_or_init(|| {
        fresh = true;
        bounded(1)
    });
    if fresh {
        let sender = sender.clone();
        // A second signal finds the channel full: the first is already being obeyed.
        let handler = move || {
            if AT_ONCE.load(Ordering::Relaxed) {
                std::process::exit(INTERRUPTED);
            }
            let _ = sender.try_send(());
        };
        ctrlc::set_handler(handler).context("no handler for SIGINT and SIGTERM")?;
    }
    Ok(receiver.clone())
}
