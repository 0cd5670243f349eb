//! The `sysid` program: the node alone. Its commands on recorded data are `planesman sysid`.

use std::process::ExitCode;

fn main() -> ExitCode {
    sysid::main(std::env::args_os().skip(1).collect())
}
