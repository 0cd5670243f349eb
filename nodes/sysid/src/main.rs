//! The `sysid` program: the node, or one of its commands on recorded data.

use std::process::ExitCode;

use clap::Parser;
use sysid::command::Command;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().collect();
    let first = args.get(1).map_or("", String::as_str);
    if Command::NAMES.contains(&first) {
        let command = Program::parse_from(args).command;
        return planesman_node::exit_code("sysid", || command.run());
    }
    sysid::node::main(args.into_iter().skip(1).collect())
}

/// Identifies models, live and from data.
#[derive(Parser)]
#[command(name = "sysid")]
struct Program {
    #[command(subcommand)]
    command: Command,
}
