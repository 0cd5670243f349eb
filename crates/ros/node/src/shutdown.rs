//! SIGINT, SIGTERM and SIGHUP as events.
//!
//! SIGHUP, sent when a terminal is closed, has the same effect as SIGTERM. SIGHUP may be sent twice, by shell and system, and so does not count as a
//! second, urgent request. SIGHUP is ignored if it was ignored at the start, for example with `nohup`.

use crate::error::{Error, Result};
use std::fs;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use smol::channel::{Receiver, Sender, bounded};

/// Whether a stop request ends the process immediately.
static AT_ONCE: AtomicBool = AtomicBool::new(false);

/// Exit status of a process ended by a stop request, as shells use for SIGINT.
const INTERRUPTED: i32 = 130;

/// From now on a stop request ends the process immediately: its remaining work can be interrupted without loss, and nobody reads [`requested`]
/// any more.
pub fn at_once() {
    AT_ONCE.store(true, Ordering::Relaxed);
}

/// A receiver that becomes ready when the process is requested to stop.
///
/// # Errors
/// The signals cannot be handled.
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

/// Whether the process was started with the signal ignored; `false` if `/proc` is not readable.
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|it| it.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|it| u64::from_str_radix(it.trim(), 16).ok());
    ignored.is_some_and(|it| it & (1 << (signal - 1)) != 0)
}
