//! The `sysid` program: the node, or `sysid replay BAG`.

use std::process::ExitCode;

use clap::Parser;
use sysid::replay::{self, ReplayArgs};

fn main() -> ExitCode {
    let mut args: Vec<String> = std::env::args().collect();
    if args.get(1).is_some_and(|first| first == "replay") {
        args.remove(1);
        let args = ReplayArgs::parse_from(args);
        return planesman_node::exit_code("sysid", || replay::run(&args));
    }
    args.remove(0);
    sysid::node::main(args)
}
