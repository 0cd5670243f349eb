//! `--ros-args` and all that may follow it, a line each.
#![no_main]

use libfuzzer_sys::fuzz_target;
use planesman_node::args;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let arguments = std::iter::once("--ros-args").chain(text.lines());
    let _ = args::split(arguments.map(str::to_owned));
    let _ = args::only(text.lines().map(str::to_owned));
});
