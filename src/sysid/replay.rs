//! `planesman replay`: runs the identifier on a bag's messages, or on a table's or log's samples ([`planesman_identifier::replay`]).

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::PathBuf;

use anyhow::{Context, Result, anyhow, bail};
use clap::Parser;
use planesman_console::print_wrapped;
use planesman_console::progress::spinner;
use planesman_fit::declaration::{Declaration, OptionGroup as _};
use planesman_fit::rules::{RATE, WINDOW};
use planesman_fit::{DataOptions, GridOptions, PreparationOptions, SignalOptions};
use planesman_identifier::IdentifierParameters;
use planesman_identifier::replay::{OnEstimate, Replay, replay, replay_record, text};
use planesman_parameters::{Parameters as _, Value, Values, file};
use planesman_signals::{Outliers, is_record};

use super::arguments::{DataArgs, by, span};
use super::history::History;
use crate::arguments::output_file;

/// Maximum number of jumps that are printed.
const PRINTED: usize = 10;

/// Run the live identifier on a bag, table or log, and compare with a bag's published estimates.
#[derive(Clone, Debug, Parser)]
#[command(name = "replay")]
pub struct ReplayArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Input signal: a column of a table, TOPIC:FIELD of a log or bag [default: the parameter input]
    #[arg(long, short, value_name = "SIGNAL", allow_hyphen_values = true)]
    input: Option<String>,
    /// Output signal [default: the parameter output]
    #[arg(long, short, value_name = "SIGNAL")]
    output: Option<String>,
    /// Sampling rate of a table or log (Hz) [default: 1/sample_time if that parameter is given, else the output's rate]
    #[arg(long, value_name = "HZ", value_parser = by(RATE))]
    rate: Option<f64>,
    /// Use only data of a table or log between these times, in seconds from the output's first sample
    #[arg(long, value_name = "FROM..TO", value_parser = span(WINDOW))]
    window: Vec<(f64, f64)>,
    /// A ROS 2 parameter file; only the entries for the node sysid are used
    #[arg(long, value_name = "FILE")]
    params_file: Option<PathBuf>,
    /// A parameter, NAME:=VALUE; overrides the parameter file
    #[arg(short = 'p', long = "param", value_name = "NAME:=VALUE")]
    parameters: Vec<String>,
    /// Name of the node in the parameter file
    #[arg(long, default_value = "/auv/sysid")]
    node: String,
    /// Write the estimate after each sample to *.csv, with standard deviations, fit and events
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    history: Option<PathBuf>,
}

impl ReplayArgs {
    /// Replays the data.
    ///
    /// # Errors
    /// Same as [`run`].
    pub fn replay(&self) -> Result<Replay> {
        let mut changes = self.changes()?;
        let data = DataOptions::from(&self.data);
        let bag = match &self.data.data[..] {
            [path] if !is_record(path) => Some(path),
            paths if paths.iter().all(|it| is_record(it)) => None,
            _ => bail!("replay needs exactly one bag, one log, or one or several tables"),
        };
        if bag.is_some() {
            self.refuse_options_of_tables(&data)?;
            for (name, signal) in [("input", &self.input), ("output", &self.output)] {
                let signal = signal.as_deref().map(Value::from);
                changes.extend(signal.map(|it| (name.to_owned(), it)));
            }
        }
        let is_sampled = changes.iter().any(|(name, _)| name == "sample_time");
        let values = Values::of::<IdentifierParameters>().with(changes)?;
        let parameters = IdentifierParameters::from_values(&values)?;
        if let Some(path) = bag {
            return self.with_history(&parameters, &|parameters, on_estimate| {
                Ok(replay(path, parameters, on_estimate)?)
            });
        }
        let rate = is_sampled.then(|| 1.0 / parameters.sample_time);
        let signals = self.signals(data, self.rate.or(rate))?;
        if !parameters.pairs.is_empty() {
            bail!(
                "the parameter 'pairs' works only for bags. Name the input and output of a table or log with -i and -o"
            );
        }
        let record = signals.read(&*self.data.progress())?;
        print_wrapped(record.description())?;
        let record = record.resampled.record;
        let parameters = IdentifierParameters {
            sample_time: record.sample_time,
            first_moment: false,
            ..parameters
        };
        self.with_history(&parameters, &|parameters, on_estimate| {
            Ok(replay_record(&record, parameters, on_estimate)?)
        })
    }

    /// The signals of a table or log on a uniform grid, with outliers kept: a live node does not remove them either.
    fn signals(&self, data: DataOptions, rate: Option<f64>) -> Result<SignalOptions> {
        let named = |signal: &Option<String>, option| {
            (signal.clone()).ok_or_else(|| {
                anyhow!("{option} is missing. Name the signals of a table or log with -i and -o; `planesman sysid topics` lists them")
            })
        };
        Ok(SignalOptions {
            data,
            input: named(&self.input, "-i")?,
            output: named(&self.output, "-o")?,
            grid: GridOptions {
                rate,
                window: self.window.clone(),
                ..GridOptions::default()
            },
            preparation: PreparationOptions {
                outliers: Outliers::Keep,
                ..PreparationOptions::default()
            },
            ..SignalOptions::default()
        })
    }

    fn refuse_options_of_tables(&self, data: &DataOptions) -> Result<()> {
        let of_tables = |it: &&Declaration| it.name != "most_unpacked";
        let is_given = self.rate.is_some() || !self.window.is_empty();
        if is_given || data.given().iter().any(of_tables) {
            bail!(
                "--stamp, --time, --time-unit, --sample-time, --rate and --window are only for tables and logs; for a bag use \
                 -p sample_time:=, -p start:= and -p resample:="
            );
        }
        Ok(())
    }

    /// Replays the data, and writes the history if requested.
    fn with_history(
        &self,
        parameters: &IdentifierParameters,
        replay: &dyn Fn(&IdentifierParameters, &mut OnEstimate<'_>) -> Result<Replay>,
    ) -> Result<Replay> {
        let Some(path) = &self.history else {
            return replay(parameters, &mut |_, _| {});
        };
        let cannot = || format!("cannot write '{}'", path.display());
        let parameters = IdentifierParameters {
            publish_rate: 1.0 / parameters.sample_time,
            ..parameters.clone()
        };
        let file = BufWriter::new(File::create(path).with_context(cannot)?);
        let mut history = History::new(file, &parameters)?;
        let found = replay(&parameters, &mut |estimate, pair| {
            history.take(estimate, pair);
        })?;
        history
            .finish()
            .and_then(|mut it| it.flush())
            .with_context(cannot)?;
        Ok(found)
    }

    /// The parameters set on the command line or in the file, by name.
    fn changes(&self) -> Result<Vec<(String, Value)>> {
        let mut changes = Vec::new();
        if let Some(path) = &self.params_file {
            let text =
                file::read(path).with_context(|| format!("parameter file '{}'", path.display()))?;
            let found = file::overrides_for(&text, &self.node)
                .with_context(|| format!("parameter file '{}'", path.display()))?;
            changes.extend(found.into_iter().filter(|(name, _)| name != "use_sim_time"));
        }
        for text in &self.parameters {
            let (name, value) = text
                .split_once(":=")
                .ok_or_else(|| anyhow!("-p {text}: NAME:=VALUE is expected"))?;
            changes.push((name.to_owned(), file::parse_value(name, value)?));
        }
        Ok(changes)
    }
}

/// Runs the command and prints the results.
///
/// # Errors
/// One line for the terminal: refused data, file or parameter, missing signals, or a history that cannot be written.
pub fn run(args: &ReplayArgs) -> Result<()> {
    let working = spinner("messages");
    let found = args.replay();
    working.finish_and_clear();
    let found = found?;
    if let Some(path) = &args.history {
        planesman_console::err!("{}", planesman_console::file_line("Table", path));
    }
    let tables: Vec<String> = found.estimates.iter().map(text).collect();
    print_wrapped(tables.join("\n"))?;
    for (name, jump) in found.jumps.iter().take(PRINTED) {
        print_wrapped(format!("{name}: {jump}\n"))?;
    }
    if found.jumps.len() > PRINTED {
        let more = found.jumps.len() - PRINTED;
        print_wrapped(format!(
            "{more} more changes of the plant (--history lists all changes)\n"
        ))?;
    }
    if let Some(live) = found.live {
        print_wrapped(format!(
            "live: {} published estimates compared, largest difference {:.1e}{}\n",
            live.compared,
            live.largest_difference,
            if live.missing == 0 {
                String::new()
            } else {
                format!(", {} without a counterpart", live.missing)
            }
        ))?;
    }
    if let Some((count, first)) = found.refused {
        print_wrapped(format!(
            "{count} messages refused. The reason for the first is: {first}\n"
        ))?;
    }
    if let Some(reason) = found.incomplete {
        print_wrapped(format!("the bag is {reason}\n"))?;
    }
    Ok(())
}
