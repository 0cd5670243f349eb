//! The `recorder` node as a program of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    recorder::node::main(std::env::args().skip(1).collect())
}
