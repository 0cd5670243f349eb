//! A wrong clock for a process: Debian's `faketime`. The monotonic clock stays right.

// Each test program uses its own part.
#![allow(dead_code, clippy::unwrap_used)]

use super::foreign;
use super::stage::Stage;

/// Debian's library, where it is installed.
pub(crate) fn library() -> Option<String> {
    let folders = std::fs::read_dir("/usr/lib").unwrap();
    let places = folders.map(|it| it.unwrap().path().join("faketime/libfaketime.so.1"));
    let found = places.into_iter().find(|it| it.exists());
    if found.is_none() {
        foreign::skip("Debian's faketime is not installed");
    }
    Some(found?.to_str().unwrap().to_owned())
}

/// The environment of a process whose clock shows what `time` says, as faketime writes it. Writing the stage's file `clock`
/// again sets it.
pub(crate) fn variables(stage: &Stage, library: &str, time: &str) -> [(&'static str, String); 4] {
    [
        ("LD_PRELOAD", library.to_owned()),
        (
            "FAKETIME_TIMESTAMP_FILE",
            stage.file("clock", format!("{time}\n")),
        ),
        ("FAKETIME_NO_CACHE", "1".to_owned()),
        ("FAKETIME_DONT_FAKE_MONOTONIC", "1".to_owned()),
    ]
}
