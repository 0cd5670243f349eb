//! `planesman sysid compare`: judges model files of any origin on the same data.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Parser;
use planesman_bag::metadata;
use planesman_console::{Format, print_wrapped};
use planesman_fit::{
    CompareOptions, GridOptions, PreparationOptions, compare, compare_several, rules,
};
use planesman_model_file::{ModelFile, SeveralModelFile};

use super::arguments::{DataArgs, Declared, data_in_words};
use crate::arguments::page_file;
use planesman_flight::sink::write_text;
use planesman_show::pages::tables::{numbers, of_several, tables};

/// Compare model files on the same data: simulation, predictions, residual tests, poles, frequency response.
///
/// Each model is simulated with its own offset, from a state fitted to the beginning of each segment. Without --rate, the data is resampled
/// to the sampling interval of the first model.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "sysid compare",
    override_usage = "planesman sysid compare [OPTIONS] <MODEL>... <DATA>...",
    mut_arg("data", |arg| arg.value_name("MODEL|DATA").help(
        format!("Model files (*.json, *.yaml), then the data: {}", data_in_words())
    ))
)]
pub struct CompareArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Input signal: TOPIC:FIELD, or a CSV column [default: the signal of the models]
    #[arg(long, short, value_name = "SIGNAL", help_heading = "Signals")]
    input: Option<String>,
    /// Output signal [default: the signal of the models]
    #[arg(long, short, value_name = "SIGNAL", help_heading = "Signals")]
    output: Option<String>,
    #[command(flatten)]
    grid: Declared<GridOptions>,
    #[command(flatten)]
    preparation: Declared<PreparationOptions>,
    /// Prediction horizons to compare, samples ahead
    #[arg(long, value_name = "SAMPLES", value_delimiter = ',', default_value = "1,10",
        value_parser = clap::value_parser!(u16).range(rules::AHEAD), help_heading = "Judgement")]
    ahead: Vec<u16>,
    /// Print one table in this format, a row per number [default: one table per question]
    #[arg(long, value_parser = crate::arguments::format(), help_heading = "Output")]
    format: Option<Format>,
    /// Write an HTML page: simulated outputs, frequency and step responses, poles, residual tests
    #[arg(long, value_name = "FILE", value_parser = page_file, help_heading = "Output")]
    html: Option<PathBuf>,
}

impl TryFrom<&CompareArgs> for CompareOptions {
    type Error = anyhow::Error;

    /// Reads the model files.
    fn try_from(args: &CompareArgs) -> Result<Self> {
        let (paths, data): (Vec<PathBuf>, Vec<PathBuf>) =
            args.data.data.iter().cloned().partition(|it| is_model(it));
        let read = |path: PathBuf| Ok((path.clone(), ModelFile::read(&path)?));
        let models: Vec<_> = paths.into_iter().map(read).collect::<Result<_>>()?;
        if data.is_empty() && !models.is_empty() {
            bail!(
                "the data is missing. Name a bag, a .csv file or a PX4 log after the model files"
            );
        }
        Ok(Self {
            models,
            data: args.data.options(data),
            input: args.input.clone(),
            output: args.output.clone(),
            grid: args.grid.0.clone(),
            preparation: args.preparation.0,
            ahead: args.ahead.iter().map(|it| usize::from(*it)).collect(),
        })
    }
}

/// Whether the path is a model file: *.json or *.yaml, except a bag's metadata.yaml.
fn is_model(path: &Path) -> bool {
    let is_metadata = path.file_name().is_some_and(|it| it == metadata::FILE_NAME);
    ModelFile::takes_name(path).is_ok() && !is_metadata
}

/// Prints the tables and writes the page.
///
/// # Errors
/// A refused model file; the errors of [`planesman_fit::compare`]; a page that cannot be written.
pub fn run(args: &CompareArgs) -> Result<()> {
    let models = several(args)?;
    if !models.is_empty() {
        return run_several(args, &models);
    }
    let options = CompareOptions::try_from(args)?;
    let found = compare(&options, &*args.data.progress())?;
    match args.format {
        Some(format) => planesman_console::print(numbers(&found.models).text(format))?,
        None => {
            for table in tables(&found.models) {
                planesman_console::print(table.text(Format::Table) + "\n")?;
            }
            print_wrapped(found.prepared.description())?;
        }
    }
    if let Some(path) = &args.html {
        let page = planesman_show::pages::compare::page(&found.models, &found.prepared);
        write_text(path, page)?;
        planesman_console::err!("{}", planesman_console::file_line("Page", path));
    }
    Ok(())
}

/// The model files with several inputs or outputs; empty if all models have one input and one output.
fn several(args: &CompareArgs) -> Result<Vec<(PathBuf, SeveralModelFile)>> {
    let paths = args.data.data.iter().filter(|it| is_model(it));
    let mut models = Vec::new();
    let mut single = None;
    for path in paths {
        let text = planesman_text::read(path).unwrap_or_default();
        match SeveralModelFile::recognises(path, &text) {
            true => models.push((path.clone(), SeveralModelFile::parse(path, &text)?)),
            false => single = Some(path),
        }
    }
    if let (Some(single), Some((path, _))) = (single, models.first()) {
        bail!(
            "{} has several inputs or outputs, but {} has one input and one output. Compare them separately",
            path.display(),
            single.display()
        );
    }
    Ok(models)
}

/// Compares models with several inputs or outputs.
fn run_several(args: &CompareArgs, models: &[(PathBuf, SeveralModelFile)]) -> Result<()> {
    for (option, is_given) in [
        ("input", args.input.is_some()),
        ("output", args.output.is_some()),
        ("html", args.html.is_some()),
    ] {
        if is_given {
            bail!("--{option} is only for models with one input and one output: leave it out");
        }
    }
    let data = args.data.data.iter().filter(|it| !is_model(it));
    let data: Vec<PathBuf> = data.cloned().collect();
    if data.is_empty() {
        bail!("the data is missing. Name a bag, a .csv file or a PX4 log after the model files");
    }
    let options = CompareOptions {
        models: Vec::new(),
        data: args.data.options(data),
        grid: args.grid.0.clone(),
        preparation: args.preparation.0,
        ..CompareOptions::default()
    };
    let found = compare_several(models, &options, &*args.data.progress())?;
    let format = args.format.unwrap_or(Format::Table);
    planesman_console::print(of_several(&found).text(format))?;
    if args.format.is_none() {
        print_wrapped(format!("\n{}", found.prepared.description()))?;
    }
    Ok(())
}
