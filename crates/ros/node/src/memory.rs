//! A limit on the memory of the process.
//!
//! DDS lets any peer on the network make a node store what it sends. The known ways to
//! make it store without end are patched in RustDDS; the ceiling is for the unknown ones. A node
//! that reaches it aborts on the failed allocation, and its peers see it lost, instead of
//! the whole machine swapping. A node of this suite uses some 15 MB, and its [`ReceiveLimits`]
//! in addition.

use crate::error::{Error, Result};
use crate::receive_limits::ReceiveLimits;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// The environment variable that sets another ceiling, in MiB; 0 means none.
pub const VARIABLE: &str = "PLANESMAN_MEMORY_LIMIT_MB";

/// The ceiling without the variable, MiB, beside what the node's budgets allow.
const DEFAULT_MIB: u64 = 1024;

/// Limits the process's private writable memory (`RLIMIT_DATA`; address space that is
/// only reserved does not count). A lower limit that is already in force stays.
///
/// # Errors
/// When the variable holds no number, or the system refuses.
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
    .map_err(Error::system("the memory limit cannot be set"))
}
