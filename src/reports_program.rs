//! Runs `planesman-reports` for the commands of the historical reports. `planesman-reports` is a separate program, so that this program can be built
//! without the reports.

use std::ffi::{OsStr, OsString};
use std::fmt;
use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use clap::Args;

/// File name of the program.
const PROGRAM: &str = "planesman-reports";

/// The arguments of a command of `planesman-reports`.
#[derive(Args, Clone, Debug)]
#[command(disable_help_flag = true)]
pub struct PassedOn {
    /// Options of planesman-reports; its --help lists them once it is built: cargo build --release --package planesman-reports
    #[arg(
        value_name = "OPTION",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    pub arguments: Vec<OsString>,
}

/// Error: `planesman-reports` is neither next to this program nor on `PATH`.
#[derive(Debug)]
pub struct NotBuilt;

impl fmt::Display for NotBuilt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "this command needs the program {PROGRAM}, which is neither next to this program nor on PATH; \
             build it: cargo build --release --package {PROGRAM}"
        )
    }
}

impl std::error::Error for NotBuilt {}

/// Replaces this process by `planesman-reports`, from next to this program or else from `PATH`. The other program gets a command and this program's
/// arguments without the first `words`, which name the command here.
///
/// # Errors
/// [`NotBuilt`], or the program cannot be started. On success this function does not return.
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
