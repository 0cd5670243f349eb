//! The `recorder` node as a separate program.

use std::process::ExitCode;

fn main() -> ExitCode {
    recorder::node::main(std::env::args_os().skip(1).collect())
}
