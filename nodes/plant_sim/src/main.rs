//! The `plant_sim` node as a program of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    plant_sim::main(std::env::args_os().skip(1).collect())
}
