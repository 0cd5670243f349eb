//! The `plant_sim` node as a separate program.

use std::process::ExitCode;

fn main() -> ExitCode {
    plant_sim::main(std::env::args_os().skip(1).collect())
}
