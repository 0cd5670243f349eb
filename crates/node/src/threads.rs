//! Whether the system gives a node its threads (`ulimit -u`): the libraries that start them would panic.

use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, scope};

use anyhow::Context as _;

/// A node's threads beside the first: the middleware's event loop and discovery, timers, signals; and one to spare.
const OF_A_NODE: usize = 5;

/// Starts the threads of a node, all at once, and ends them.
///
/// # Errors
/// When the system refuses one.
pub(crate) fn check() -> anyhow::Result<()> {
    let gate = Mutex::new(());
    scope(|scope| {
        let _closed = gate.lock();
        for _ in 0..OF_A_NODE {
            Builder::new().spawn_scoped(scope, || {
                drop(gate.lock().unwrap_or_else(PoisonError::into_inner));
            })?;
        }
        std::io::Result::Ok(())
    })
    .with_context(|| {
        format!("the system refuses the {OF_A_NODE} threads of a node (see ulimit -u)")
    })
}
