//! Makes a write beyond the file size limit fail with an error, instead of ending the process.
//!
//! Beyond `RLIMIT_FSIZE` (`ulimit -f`) the system sends SIGXFSZ, which ends the process. With a handler for the signal, the write fails with
//! "File too large" instead.

use std::sync::{Arc, Once};

/// Makes writes beyond the file size limit fail, until the process ends.
pub fn limit_is_an_error() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Without the handler such a write kills, as it does in other programs. Nobody looks at the flag.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    });
}
