//! The `dha_actuator` node as a separate program.

use std::process::ExitCode;

fn main() -> ExitCode {
    dha_actuator::main(std::env::args_os().skip(1).collect())
}
