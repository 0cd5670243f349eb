//! SIGINT, SIGTERM and SIGHUP as events.

use std::sync::OnceLock;

use anyhow::Context as _;
use smol::channel::{Receiver, Sender, bounded};

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
            let _ = sender.try_send(());
        };
        ctrlc::set_handler(handler).context("no handler for SIGINT and SIGTERM")?;
    }
    Ok(receiver.clone())
}
