//! The `dha_actuator` node as a program of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    dha_actuator::main(std::env::args().skip(1).collect())
}
