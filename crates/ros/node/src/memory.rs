//! Memory limit of the process.
//!
//! In DDS any peer on the network can make a node store data. Known ways to do this without limit are fixed in RustDDS; this limit is for unknown
//! ways. A node that reaches it aborts on a failed allocation, which its peers notice; otherwise the whole machine would swap. A node of this suite
//! uses about 15 MB, plus its [`ReceiveLimits`].

use crate::error::{Error, Result};
use crate::receive_limits::ReceiveLimits;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Environment variable for another limit, in MiB; 0 means no limit.
pub const VARIABLE: &str = "PLANESMAN_MEMORY_LIMIT_MB";

/// Default limit, MiB, without the node's receive limits.
const DEFAULT_MIB: u64 = 1024;

/// Limits the process's private writable memory (`RLIMIT_DATA`; reserved address space does not count). A lower existing limit stays.
///
/// # Errors
/// The variable is not a number, or the system refuses.
pub fn limit(receive_limits: &ReceiveLimits) -> Result<()> {
    let budgets = (receive_limits.budget as u64).saturating_mul(4) >> 20;
    let mib = match std::env::var(VARIABLE) {
        Ok(text) => text.parse::<u64>().map_err(|reason| {
            let expected = format!("a number of MiB is expected: {reason}");
            Error::environment(format!("{VARIABLE}='{text}'"), expected)
        })?,
        Err(_) => DEFAULT_MIB.saturating_add(budgets),
    };
    if mib == 0 {
        return Ok(());
    }
    let wanted = mib.saturating_mul(1 << 20);
    let now = getrlimit(Resource::Data);
    let bound = |limit: Option<u64>| Some(limit.map_or(wanted, |l| l.min(wanted)));
    setrlimit(
        Resource::Data,
        Rlimit {
            current: bound(now.current),
            maximum: now.maximum,
        },
    )
    .map_err(Error::system("cannot set the memory limit"))
}
