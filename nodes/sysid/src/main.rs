//! The `sysid` node as a program of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    sysid::node::main(std::env::args().skip(1).collect())
}
