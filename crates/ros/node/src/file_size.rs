//! A file size limit is a write error, not the end of the process.
//!
//! Beyond `RLIMIT_FSIZE` (`ulimit -f`) the system sends SIGXFSZ, which kills. With a handler in
//! place the write fails with "File too large" instead, and can be recognised by name.

use std::sync::{Arc, Once};

/// Makes writes beyond the file size limit fail, for as long as the process runs.
pub fn limit_is_an_error() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Without the handler such a write kills, as it does in other programs. Nobody looks at the flag.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    });
}
