//! SIGINT, SIGTERM and SIGHUP as events.
//!
//! SIGHUP, which comes when a terminal is closed, asks to stop as SIGTERM does. A shell and the system both send it, so it is
//! no second wish, for haste; and where it was to be ignored, as under `nohup`, it is.

use crate::error::{Error, Result};
use std::fs;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
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
/// When the signals cannot be waited for.
pub fn requested() -> Result<Receiver<()>> {
    static CHANNEL: OnceLock<(Sender<()>, Receiver<()>)> = OnceLock::new();
    let mut fresh = false;
    let (sender, receiver) = CHANNEL.get_or_init(|| {
        fresh = true;
        bounded(1)
    });
    if fresh {
        listen(sender.clone()).map_err(Error::system("cannot wait for SIGINT and SIGTERM"))?;
    }
    Ok(receiver.clone())
}

fn listen(sender: Sender<()>) -> std::io::Result<()> {
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    if !is_ignored(SIGHUP) {
        signals.add_signal(SIGHUP)?;
    }
    let wait = move || {
        let mut hung_up = false;
        for signal in signals.forever() {
            if signal == SIGHUP && std::mem::replace(&mut hung_up, true) {
                continue;
            }
            if AT_ONCE.load(Ordering::Relaxed) {
                // Nobody waits for an answer at a terminal that is gone; what is being done comes to its end.
                if signal == SIGHUP {
                    continue;
                }
                std::process::exit(INTERRUPTED);
            }
            // A second signal finds the channel full: the first is already being obeyed.
            let _ = sender.try_send(());
        }
    };
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(wait)
        .map(drop)
}

/// Whether the process was started with the signal ignored; where `/proc` does not say, not.
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|it| it.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|it| u64::from_str_radix(it.trim(), 16).ok());
    ignored.is_some_and(|it| it & (1 << (signal - 1)) != 0)
}
