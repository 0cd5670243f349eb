//! Signals as they lie in a bag, CSV file or PX4 log: every sample with its stamp, on no grid.

use anyhow::Result;
use clap::Parser;
use planesman_identification::stop_point;
use planesman_signals::{Reading, Request, Role, Take};

use super::arguments::DataArgs;

/// The signals of some data.
#[derive(Clone, Debug, Parser)]
#[command(name = "samples")]
pub struct SamplesArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Signal: TOPIC:FIELD, or a CSV column
    #[arg(long, short, value_name = "SIGNAL", required = true)]
    signal: Vec<String>,
}

impl SamplesArgs {
    /// The signals, as they were named.
    #[must_use]
    pub fn signals(&self) -> &[String] {
        &self.signal
    }
}

/// Hands every sample of the signals to `take`. Of a field that is a list the first element is taken, unless one is named.
///
/// # Errors
/// One line: a signal that is not there, or data of which nothing can be read.
pub fn read(args: &SamplesArgs, take: &mut Take<'_>) -> Result<Reading> {
    let request = |name: &String| Request {
        name: name.clone(),
        role: Role::Output,
    };
    let requests: Vec<Request> = args.signal.iter().map(request).collect();
    Ok(args.data.open()?.read(&requests, take, &|_| stop_point())?)
}
