//! The node `sysid` as a separate program; the commands on recorded data are `planesman sysid`.

use std::process::ExitCode;

fn main() -> ExitCode {
    sysid::main(std::env::args_os().skip(1).collect())
}
