//! The `depth_controller` node as a program of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    depth_controller::main(std::env::args_os().skip(1).collect())
}
