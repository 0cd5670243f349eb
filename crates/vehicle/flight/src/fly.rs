//! Simulates a scenario in one process, as fast as possible, and writes the messages to a file.

use std::path::Path;

use crate::error::{Result, refuse};
use planesman_parallel::Progress;

use crate::compose::Loop;
use crate::parts::Parts;
use crate::scenario::Scenario;
use crate::sink::{CsvSink, McapSink};

/// Simulates `scenario` and writes `out`, an `.mcap` or a `.csv` file; returns the number of ticks.
///
/// # Errors
/// If the file's kind is unknown, the path exists, or a part of the loop refuses.
pub fn fly(
    scenario: &Scenario,
    parts: &Parts,
    out: &Path,
    namespace: &str,
    progress: &dyn Progress,
) -> Result<u64> {
    fly_into(scenario, parts, out, namespace, progress, false)
}

/// Like [`fly`], but replaces an existing file after the flight is complete.
///
/// # Errors
/// Same as [`fly`], except that the path may exist.
pub fn fly_over(
    scenario: &Scenario,
    parts: &Parts,
    out: &Path,
    namespace: &str,
    progress: &dyn Progress,
) -> Result<u64> {
    fly_into(scenario, parts, out, namespace, progress, true)
}

fn fly_into(
    scenario: &Scenario,
    parts: &Parts,
    out: &Path,
    namespace: &str,
    progress: &dyn Progress,
    replaces: bool,
) -> Result<u64> {
    enum Out {
        Mcap(Box<McapSink>),
        Csv(CsvSink),
    }
    let mut flight = Loop::of_parts(parts, scenario)?;
    let mut sink = match out.extension().and_then(|e| e.to_str()) {
        Some("mcap") => Out::Mcap(Box::new(McapSink::create(out, namespace, replaces)?)),
        Some("csv") => Out::Csv(CsvSink::create(out, replaces)?),
        _ => refuse!(
            "the output file '{}' has an unknown ending. Name it *.mcap or *.csv",
            out.display()
        ),
    };
    progress.begin("ticks", scenario.ticks(), 0);
    let flown = flight.try_fold(0, |ticks, tick| -> Result<u64> {
        let tick = tick?;
        match &mut sink {
            Out::Mcap(sink) => tick.put_into(sink.as_mut())?,
            Out::Csv(sink) => sink.put(&tick)?,
        }
        progress.step();
        Ok(ticks + 1)
    });
    progress.end();
    let ticks = flown?;
    match sink {
        Out::Mcap(sink) => sink.finish()?,
        Out::Csv(sink) => sink.finish()?,
    }
    Ok(ticks)
}
