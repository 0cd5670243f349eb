//! The `depth_controller` node as a separate program.

use std::process::ExitCode;

fn main() -> ExitCode {
    depth_controller::main(std::env::args_os().skip(1).collect())
}
