//! `planesman sysid fit`: a model with uncertainty, tests and a verdict, from a bag or a CSV file.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Parser;
use planesman_console::{file_line, print_wrapped};
use planesman_equations::EquationsFile;
use planesman_fit::{
    FitError, FitOptions, MethodChoice, compared, fit, fit_continuous, fit_equations, fit_several,
};
use planesman_identification::analysis::Shown;
use planesman_identification::estimators::Method;
use planesman_model_file::ModelFile;
use planesman_signals::PreparedRecord;

use super::arguments::SignalArgs;
use crate::arguments::{output_file, page_file};
use planesman_flight::sink::write_text;
use planesman_show::pages::tables::{notes, tried};
use planesman_vehicle::heave::{HeaveError, heave_of};

/// The options that `-h` shows; `--help` shows all.
const SHORT: [&str; 18] = [
    "data",
    "input",
    "output",
    "reference",
    "rate",
    "window",
    "validation",
    "sample_time",
    "method",
    "order",
    "delay",
    "equations",
    "continuous",
    "speed",
    "json",
    "verbose",
    "model",
    "html",
];

fn shown_or_hidden(argument: clap::Arg) -> clap::Arg {
    let is_shown = SHORT.contains(&argument.get_id().as_str());
    let argument = match argument.get_id().as_str() {
        // Equations name their signals themselves.
        "input" | "output" => argument
            .required(false)
            .required_unless_present("equations"),
        _ => argument,
    };
    argument.hide_short_help(!is_shown)
}

/// Identify a model between two signals of a bag or CSV file, with uncertainty, tests and a verdict.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "sysid fit",
    mut_args = shown_or_hidden,
    override_usage = "planesman sysid fit [OPTIONS] -i <SIGNAL> -o <SIGNAL> <DATA>..."
)]
pub struct FitArgs {
    #[command(flatten)]
    signals: SignalArgs<FitOptions>,
    /// Fit your own state equations with unknown parameters, read from this file, at the recorded sample times. Assign signals with -i NAME=SIGNAL
    /// and -o NAME=SIGNAL; inputs and outputs without an option use the signal of their own name
    #[arg(long, value_name = "FILE", help_heading = "Model")]
    equations: Option<PathBuf>,
    /// Fit a transfer function in s with dead time at the recorded sample times, even uneven ones; --order and --numerator are those in s. It
    /// has no sampling interval: use --delay 0 for no dead time, or leave --delay out to estimate it
    #[arg(long, conflicts_with = "equations", help_heading = "Model")]
    continuous: bool,
    /// Write the frequency response of --method frf: *.csv
    #[arg(long, value_name = "FILE", value_parser = output_file, help_heading = "Output")]
    response: Option<PathBuf>,
    /// Print JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Also print the candidate models, coefficients, poles and zeros
    #[arg(long, help_heading = "Output")]
    verbose: bool,
    /// Write the model to a file: *.json or *.yaml
    #[arg(long, value_name = "FILE", value_parser = model_path, help_heading = "Output")]
    model: Option<PathBuf>,
    /// Write an HTML page: data, comparison, residual tests, poles and zeros, frequency response
    #[arg(long, value_name = "FILE", value_parser = page_file, help_heading = "Output")]
    html: Option<PathBuf>,
}

impl TryFrom<&FitArgs> for FitOptions {
    type Error = HeaveError;

    fn try_from(args: &FitArgs) -> Result<Self, HeaveError> {
        let mut options = args.signals.options();
        options.vehicle.look_up(heave_of)?;
        Ok(options)
    }
}

impl FitArgs {
    /// The lines about the data record and the validation record.
    fn record(&self, fitted: &PreparedRecord, validation: Option<&PreparedRecord>) -> String {
        let validation = validation.map_or(String::new(), |it| {
            format!("validation data\n{}", it.description())
        });
        format!("\n{}{validation}", fitted.description())
    }

    fn shown<'a>(&self, record: &'a str, once_written: Option<&'a str>) -> Shown<'a> {
        Shown {
            record,
            once_written,
            verbose: self.verbose,
        }
    }

    /// The next command once the model is written; `None` if no model is written.
    fn once_written(&self) -> Option<String> {
        let path = self.model.as_ref()?.display();
        Some(format!(
            "validate it on other data: planesman sysid compare {path} DATA"
        ))
    }
}

fn model_path(text: &str) -> Result<PathBuf, String> {
    let path = output_file(text)?;
    ModelFile::takes_name(&path).map_err(|refusal| refusal.to_string())?;
    Ok(path)
}

/// Prints the model, and writes the model file and the page.
///
/// # Errors
/// Like [`planesman_fit::fit`]; a model, file or page that cannot be written.
pub fn run(args: &FitArgs) -> Result<()> {
    let options = FitOptions::try_from(args)?;
    let measures_response = options.method == MethodChoice::One(Method::Frf);
    if args.response.is_some() && (args.equations.is_some() || !measures_response) {
        return Err(FitError::NoResponse.into());
    }
    if let Some(path) = &args.equations {
        return run_equations(args, &options, path);
    }
    if args.continuous {
        return run_continuous(args, &options);
    }
    if options.signals.are_several() {
        return run_several(args, &options);
    }
    let found = fit(&options, &*args.signals.data.progress())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        if !found.tried.is_empty() {
            planesman_console::print(tried(&found.tried) + "\n")?;
            print_wrapped(notes(&found.tried) + "\n")?;
        }
        let record = args.record(&found.prepared, found.validation.as_ref());
        let next = args.once_written();
        print_wrapped(found.analysis.text_as(args.shown(&record, next.as_deref())))?;
    }
    if let Some(path) = &args.model {
        found.model_file()?.write(path)?;
        planesman_console::err!("{}", file_line("Model", path));
    }
    if let Some(path) = &args.response {
        write_text(path, found.response()?)?;
        planesman_console::err!("{}", file_line("Response", path));
    }
    if let Some(path) = &args.html {
        let page = match &found.tried[..] {
            [] => {
                let (analysis, prepared) = (&found.analysis, &found.prepared);
                let columns = [&analysis.input, &analysis.output];
                let columns = columns.map(|it| prepared.reading.column(it));
                planesman_show::pages::fit::page(analysis, &prepared.resampled.record, columns)?
            }
            tried => {
                let prepared = found.validation.as_ref().unwrap_or(&found.prepared);
                planesman_show::pages::compare::page(&compared(tried, prepared)?, prepared)
            }
        };
        write_text(path, page)?;
        planesman_console::err!("{}", file_line("Page", path));
    }
    Ok(())
}

/// Like `run`, for user-written state equations.
fn run_equations(args: &FitArgs, options: &FitOptions, path: &Path) -> Result<()> {
    let file = EquationsFile::read(path)?;
    let found = fit_equations(options, file, &*args.signals.data.progress());
    let found = found.with_context(|| path.display().to_string())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        print_wrapped(planesman_show::pages::equations::text(&found))?;
    }
    if let Some(path) = &args.model {
        found.file().write(path)?;
        planesman_console::err!("{}", file_line("Equations", path));
    }
    if let Some(path) = &args.html {
        write_text(path, planesman_show::pages::equations::page(&found))?;
        planesman_console::err!("{}", file_line("Page", path));
    }
    Ok(())
}

/// Like `run`, for a continuous-time transfer function.
fn run_continuous(args: &FitArgs, options: &FitOptions) -> Result<()> {
    if args.response.is_some() {
        return Err(FitError::NoResponse.into());
    }
    if args.model.is_some() {
        return Err(FitError::NoSampledModel.into());
    }
    let found = fit_continuous(options, &*args.signals.data.progress())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        print_wrapped(planesman_show::pages::continuous::text(&found))?;
    }
    if let Some(path) = &args.html {
        write_text(path, planesman_show::pages::continuous::page(&found))?;
        planesman_console::err!("{}", file_line("Page", path));
    }
    Ok(())
}

/// Like `run`, for several inputs or outputs.
fn run_several(args: &FitArgs, options: &FitOptions) -> Result<()> {
    let found = fit_several(options, &*args.signals.data.progress())?;
    if args.json {
        let text = serde_json::to_string_pretty(&found.as_json()?)? + "\n";
        planesman_console::print(text)?;
    } else {
        let record = args.record(&found.prepared, found.validation.as_ref());
        let next = args.once_written();
        print_wrapped(found.text_as(args.shown(&record, next.as_deref())))?;
    }
    if let Some(path) = &args.model {
        found.model_file()?.write(path)?;
        planesman_console::err!("{}", file_line("Model", path));
    }
    if let Some(path) = &args.html {
        write_text(path, planesman_show::pages::several::page(&found))?;
        planesman_console::err!("{}", file_line("Page", path));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use clap::CommandFactory as _;
    use planesman_fit::FitOptions;
    use planesman_fit::declaration::OptionGroup as _;

    use super::FitArgs;

    #[test]
    fn the_command_line_has_the_options_of_the_library() {
        let command = FitArgs::command();
        let own = [
            "input",
            "output",
            "continuous",
            "equations",
            "json",
            "model",
            "response",
            "html",
            "quiet",
            "verbose",
            "help",
        ];
        let here: BTreeMap<String, Vec<String>> = (command.get_arguments())
            .filter_map(|it| {
                let values = it.get_possible_values();
                let values = values.iter().map(|value| value.get_name().to_owned());
                let takes_one = it.get_action().takes_values();
                let values = values.filter(|_| takes_one).collect();
                Some((it.get_long()?.replace('-', "_"), values))
            })
            .filter(|(name, _)| !own.contains(&name.as_str()))
            .collect();
        let there = FitOptions::declarations().into_iter();
        let there = there.map(|option| {
            let words = option.kind().words.into_iter().map(|it| it.name.to_owned());
            (option.name.to_owned(), words.collect())
        });
        assert_eq!(here, there.collect());
    }
}
