//! The reports' program, `planesman-reports`, which some commands run in place of this one: it is a program of its own, so that a build of
//! this one is without the reports.

use std::ffi::{OsStr, OsString};
use std::fmt;
use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use clap::Args;

/// Its name.
const PROGRAM: &str = "planesman-reports";

/// The arguments of a command that the reports' program has.
#[derive(Args, Clone, Debug)]
#[command(disable_help_flag = true)]
pub struct PassedOn {
    /// Options of the reports' program, which lists them with --help once it is built:
    /// cargo build --release --package planesman-reports
    #[arg(
        value_name = "OPTION",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    pub arguments: Vec<OsString>,
}

/// The reports' program is not where it is looked for.
#[derive(Debug)]
pub struct NotBuilt;

impl fmt::Display for NotBuilt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "this command is of the reports' program, {PROGRAM}, which is neither beside this program nor on PATH; \
             build it: cargo build --release --package {PROGRAM}"
        )
    }
}

impl std::error::Error for NotBuilt {}

/// Becomes the reports' program, the one beside this program or else the one on `PATH`, with a command of it and the arguments of this
/// program, behind as many `words` as name the command here.
///
/// # Errors
/// [`NotBuilt`], or the program cannot be run. Otherwise this does not return.
pub fn run(command: &str, words: usize) -> Result<()> {
    let beside = std::env::current_exe()?.with_file_name(PROGRAM);
    let program = match beside.is_file() {
        true => beside.as_os_str(),
        false => OsStr::new(PROGRAM),
    };
    let arguments = std::env::args_os().skip(1 + words);
    let error = Command::new(program).arg(command).args(arguments).exec();
    match error.kind() {
        ErrorKind::NotFound => bail!(NotBuilt),
        _ => Err(error).with_context(|| format!("cannot run '{}'", Path::new(program).display())),
    }
}
