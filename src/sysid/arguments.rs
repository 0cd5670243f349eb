//! Arguments shared by several commands: data, signals, and the options that a library declares.

use std::path::PathBuf;

use clap::builder::{ArgPredicate, PossibleValuesParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches};
use planesman_console::progress::Bars;
use planesman_fit::declaration::{Declaration, OptionGroup, Takes};
use planesman_fit::rules::{Rule, RuleError, Span};
use planesman_fit::{DataOptions, SignalOptions, Sources};
use planesman_parallel::Progress;
use planesman_signals::{LogKind, TABLES};

use crate::arguments::possible;

/// Options declared by a library, as clap arguments.
#[derive(Clone, Debug)]
pub(crate) struct Declared<T>(pub(crate) T);

impl<T: OptionGroup> Args for Declared<T> {
    fn augment_args(command: Command) -> Command {
        let default = T::default();
        let options = default.values().into_iter();
        command.args(options.map(|(option, value)| argument(option, value.written())))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T: OptionGroup> FromArgMatches for Declared<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut options = Self(T::default());
        options.update_from_arg_matches(matches)?;
        Ok(options)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        for option in T::declarations() {
            let texts: Vec<&str> = match option.kind().takes {
                Takes::Nothing if matches.get_flag(option.name) => vec!["True"],
                Takes::Nothing => Vec::new(),
                _ => {
                    let texts = matches.get_many::<String>(option.name);
                    texts.into_iter().flatten().map(String::as_str).collect()
                }
            };
            for text in texts {
                let put = self.0.put(option, text);
                put.map_err(|it| Error::raw(ErrorKind::ValueValidation, it))?;
            }
        }
        Ok(())
    }
}

/// An option with its value, as written in help texts.
fn in_words(name: &str, value: Option<&str>) -> String {
    let value = value.map_or_else(String::new, |it| format!(" {it}"));
    format!("--{}{value}", name.replace('_', "-"))
}

/// The argument of an option.
fn argument(option: &'static Declaration, default: Vec<String>) -> Arg {
    let kind = option.kind();
    let argument = Arg::new(option.name)
        .long(option.name.replace('_', "-"))
        .short(option.short)
        .visible_aliases(option.alias)
        .help(option.doc(in_words))
        .help_heading(option.section)
        .requires_ifs(option.needs.map(|it| (ArgPredicate::IsPresent, it)))
        .conflicts_with_all(option.excludes);
    if kind.takes == Takes::Nothing {
        return argument.action(ArgAction::SetTrue);
    }
    let value = match option.value {
        "" => option.name.to_uppercase(),
        value => value.to_owned(),
    };
    let argument = argument
        .value_name(value)
        .default_values(default)
        .allow_hyphen_values(kind.hyphen)
        .action(match kind.takes {
            Takes::Several => ArgAction::Append,
            _ => ArgAction::Set,
        });
    match &kind.words[..] {
        [] => argument.value_parser(move |text: &str| {
            (kind.accept)(text, &option.range).map(|()| text.to_owned())
        }),
        words => {
            let words = words
                .iter()
                .map(|it| possible((it.name, it.about), it.also));
            argument.value_parser(PossibleValuesParser::new(words))
        }
    }
}

/// The accepted kinds of data, with their file extensions.
pub(crate) fn data_in_words() -> String {
    let written = |endings: &[&str]| format!(".{}", endings.join(", ."));
    let log = |it: &LogKind| format!("{} ({})", it.writer, written(it.endings));
    let logs: Vec<String> = LogKind::all().iter().map(log).collect();
    format!(
        "a bag folder, a metadata.yaml, one or several .mcap or .db3 files of a split bag, one or several tables ({}), or a log of {}",
        written(&TABLES),
        logs.join(", ")
    )
}

/// Data, and its options.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Data")]
pub(crate) struct DataArgs<T: OptionGroup = DataOptions> {
    #[arg(
        required = true,
        value_name = "DATA",
        help_heading = None::<&str>,
        help = format!("Recorded data: {}", data_in_words())
    )]
    pub(crate) data: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) options: Declared<T>,
    /// Do not show progress
    #[arg(long)]
    quiet: bool,
}

impl<T: OptionGroup> DataArgs<T> {
    /// Receiver of progress reports: standard error, or nothing with `--quiet`.
    pub(crate) fn progress(&self) -> Box<dyn Progress> {
        match self.quiet {
            true => Box::new(()),
            false => Box::new(Bars::default()),
        }
    }
}

impl DataArgs {
    /// The library's options for these paths.
    pub(crate) fn options(&self, paths: Vec<PathBuf>) -> DataOptions {
        self.options.0.for_files(paths)
    }
}

impl From<&DataArgs> for DataOptions {
    fn from(args: &DataArgs) -> Self {
        args.options(args.data.clone())
    }
}

/// Signals of the data, and their options.
#[derive(Clone, Debug, Args)]
pub(crate) struct SignalArgs<T: OptionGroup = SignalOptions> {
    #[command(flatten)]
    pub(crate) data: DataArgs<T>,
    /// Input signal: TOPIC:FIELD, or a CSV column. An unrecorded input in words: '12V from 0.1s', '0 to 12V at 0.1s', '5 from 1s, 0 from 4s'.
    /// Repeat for further inputs: one model contains all of them
    #[arg(
        long,
        short,
        required = true,
        value_name = "SIGNAL",
        allow_hyphen_values = true,
        help_heading = "Signals",
        display_order = 0
    )]
    pub(crate) input: Vec<String>,
    /// Output signal; repeat for further outputs
    #[arg(
        long,
        short,
        required = true,
        value_name = "SIGNAL",
        help_heading = "Signals",
        display_order = 0
    )]
    pub(crate) output: Vec<String>,
}

impl<T: OptionGroup + Clone + AsMut<SignalOptions>> SignalArgs<T> {
    /// The library's options, with data and signals.
    pub(crate) fn options(&self) -> T {
        let mut options = self.data.options.0.clone();
        let signals = options.as_mut();
        signals.data.sources = Sources::Files(self.data.data.clone());
        let named = |names: &[String]| {
            let first = names.first().cloned().unwrap_or_default();
            (first, names.iter().skip(1).cloned().collect())
        };
        (signals.input, signals.other_inputs) = named(&self.input);
        (signals.output, signals.other_outputs) = named(&self.output);
        options
    }
}

/// A parser of numbers that a rule allows.
pub(crate) fn by(rule: Rule) -> impl Fn(&str) -> Result<f64, RuleError> + Clone {
    move |text| rule.parse(text)
}

/// A parser of FROM..TO pairs that a rule allows.
pub(crate) fn span(rule: Span) -> impl Fn(&str) -> Result<(f64, f64), RuleError> + Clone {
    move |text| rule.parse(text)
}
