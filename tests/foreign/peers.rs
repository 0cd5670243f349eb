//! Where the foreign programs of the tests are, and what becomes of a test that lacks them. Test programs of several crates
//! include this file.

// Each uses its own part.
#![allow(dead_code)]

use std::{path::Path, process::Command};

/// The repository's root: what holds `tests/peers`.
pub(crate) fn root() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package
        .ancestors()
        .find(|folder| folder.join("tests/peers").is_dir())
        .unwrap_or(package)
}

/// Whether an absent foreign program fails its test (`PLANESMAN_PEERS=required`), not only skips it.
pub(crate) fn are_required() -> bool {
    std::env::var("PLANESMAN_PEERS").is_ok_and(|value| value == "required")
}

/// Says what is skipped and why.
///
/// # Panics
/// When the peers are required.
pub(crate) fn skip(reason: &str) {
    assert!(!are_required(), "required, but {reason}");
    println!("skipped: {reason}");
}

/// A program of `tests/peers` with the Python in `.venv`; `None`, having said so, where there is none.
pub(crate) fn program(name: &str) -> Option<Command> {
    let python = root().join(".venv/bin/python");
    if !python.exists() {
        skip(&format!("there is no {}", python.display()));
        return None;
    }
    let mut command = Command::new(python);
    command.arg(root().join("tests/peers").join(name));
    Some(command)
}
