//! `planesman sim`: a scenario simulated in one process, as fast as possible.

use std::path::Path;

use anyhow::{Result, bail};
use planesman_console::progress::ProgressBar;

use crate::compose::Loop;
use crate::scenario::Scenario;
use crate::sink::{CsvSink, McapSink};

/// Flies `scenario` into `out`, an `.mcap` or a `.csv` file; returns the ticks flown.
///
/// # Errors
/// When the file's kind is unknown, the path is taken, or a part of the loop refuses.
pub fn run(scenario: &Scenario, out: &Path, namespace: &str) -> Result<u64> {
    enum Out {
        Mcap(Box<McapSink>),
        Csv(CsvSink),
    }
    let flight = Loop::new(scenario)?;
    let mut sink = match out.extension().and_then(|e| e.to_str()) {
        Some("mcap") => Out::Mcap(Box::new(McapSink::create(out, namespace)?)),
        Some("csv") => Out::Csv(CsvSink::create(out)?),
        _ => bail!("'{}': the output is named *.mcap or *.csv", out.display()),
    };
    let bar = ProgressBar::new(scenario.ticks());
    let mut ticks = 0;
    for tick in flight {
        let tick = tick?;
        match &mut sink {
            Out::Mcap(sink) => tick.put_into(sink.as_mut())?,
            Out::Csv(sink) => sink.put(&tick)?,
        }
        ticks += 1;
        if ticks % 64 == 0 {
            bar.set_position(ticks);
        }
    }
    bar.finish_and_clear();
    match sink {
        Out::Mcap(sink) => sink.finish()?,
        Out::Csv(sink) => sink.finish()?,
    }
    Ok(ticks)
}
