//! Values on the command line, read and written: what several commands share.

use std::any::TypeId;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser};
use planesman_console::Format;
use planesman_text::{did_you_mean, in_one_line, shown};
use planesman_units::{Dimension, Quantity};
use rustix::fs::{Access, access};

/// The help of an argument that is a scenario.
pub fn scenario_help() -> String {
    let names = planesman_flight::scenario::builtin_names().join(", ");
    format!("A built-in scenario ({names}) or a scenario file")
}

/// A parser of numbers in `[least, most]`.
pub fn within(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("a number from {least} to {most} is expected")),
    }
}

/// A parser of quantities in `[least, most]`, both in SI. A bare number is in SI; any other unit is written with
/// it, as `1ft/s`.
pub fn quantity(
    dimension: Dimension,
    least: f64,
    most: f64,
) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let Ok(quantity) = text.parse::<Quantity>();
        let value = quantity.argument_within(dimension, least, most);
        value.map_err(|refusal| refusal.to_string())
    }
}

/// A parser of speeds in `[least, most]`, m/s.
pub fn speed(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    quantity(Dimension::Speed, least, most)
}

/// A parser of lengths in `[least, most]`, m.
pub fn length(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    quantity(Dimension::Length, least, most)
}

/// The option that lets a command replace files and folders of results.
const OVERWRITE: &str = "--overwrite";

/// Whether the command line has `--overwrite`. Parsers of values need it before all options are parsed.
#[must_use]
pub fn overwrites() -> bool {
    let mut options = std::env::args_os().skip(1).take_while(|it| it != "--");
    options.any(|it| it == OVERWRITE)
}

/// Removes a result that `--overwrite` lets a command replace: a file, or a folder that contains the file `mark`, by
/// which it is known as one of this command's. Anything else stays, and is refused by whoever writes there.
///
/// # Errors
/// When it cannot be removed.
pub fn make_way(path: &Path, mark: Option<&str>) -> std::io::Result<()> {
    match mark {
        _ if !overwrites() => Ok(()),
        None if path.is_file() => std::fs::remove_file(path),
        Some(mark) if path.join(mark).is_file() => std::fs::remove_dir_all(path),
        _ => Ok(()),
    }
}

/// A file that a command is to write. It is checked before the work is done: the folder exists and can be written,
/// and no file or folder of that name is there, but for a file with `--overwrite`. A device such as `/dev/stdout` may be there.
///
/// # Errors
/// A sentence: what keeps the file from being written.
pub fn output_file(text: &str) -> Result<PathBuf, String> {
    let path = Path::new(text);
    if path.file_name().is_none() {
        return Err("the name of a file is expected".to_owned());
    }
    match path.metadata() {
        Ok(there) if there.is_dir() => return Err("it is a folder".to_owned()),
        Ok(there) if there.is_file() && !overwrites() => {
            return Err(format!(
                "it exists already; name a new file, or add {OVERWRITE}"
            ));
        }
        Ok(there) if there.is_file() => {}
        Ok(_) => return Ok(path.to_owned()),
        Err(_) => {}
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(format!("there is no folder '{}'", folder.display()));
    }
    access(folder, Access::WRITE_OK | Access::EXEC_OK)
        .map_err(|error| format!("the folder '{}': {error}", folder.display()))?;
    Ok(path.to_owned())
}

/// The arguments of the program, as it was called, by [`completed`].
///
/// # Errors
/// As clap's `try_parse`.
pub fn parsed<C: Parser>() -> Result<C, clap::Error> {
    let mut matches = completed(C::command()).try_get_matches()?;
    C::from_arg_matches_mut(&mut matches)
}

/// A command with what all commands share. An option for a number takes one below 0 as its value, so that the option's own
/// range refuses it. A command that writes files has `--overwrite`, which [`overwrites`] reads.
#[must_use]
pub fn completed(command: clap::Command) -> clap::Command {
    let numbers = [
        TypeId::of::<f64>(),
        TypeId::of::<(f64, f64)>(),
        TypeId::of::<u8>(),
        TypeId::of::<u16>(),
        TypeId::of::<u32>(),
    ];
    let taking = command.mut_args(move |argument| {
        let of = argument.get_value_parser().type_id();
        match numbers.iter().any(|it| of == *it) {
            true => argument.allow_hyphen_values(true),
            false => argument,
        }
    });
    let writes = taking
        .get_arguments()
        .filter_map(clap::Arg::get_long)
        .any(|it| ["html", "out", "history"].contains(&it));
    let overwrite = clap::Arg::new("overwrite")
        .long(&OVERWRITE[2..])
        .action(clap::ArgAction::SetTrue)
        .help_heading("Output")
        .help("Replace files and folders of results that exist");
    match writes {
        true => taking.arg(overwrite),
        false => taking,
    }
    .mut_subcommands(completed)
}

/// A command-line error as one line, without the usage, and clap's suggestion.
fn error_and_tip(error: &clap::Error) -> (String, Option<String>) {
    let text = error.to_string();
    let mut lines = text.lines().map(str::trim);
    let wrong: Vec<&str> = lines.by_ref().take_while(|line| !line.is_empty()).collect();
    let mut wrong = wrong.join(" ").trim_start_matches("error: ").to_owned();
    // What the standard library says of a number is no help at a prompt.
    for reason in [
        "invalid digit found in string",
        "cannot parse integer from empty string",
    ] {
        wrong = wrong.replace(reason, "a whole number is expected");
    }
    // Ranges are written as in Rust.
    if let Some((value, range)) = wrong.split_once(" is not in ")
        && let Some((least, most)) = range.split_once("..=")
        && let Some((option, _)) = value.rsplit_once(": ")
    {
        wrong = format!("{option}: a whole number from {least} to {most} is expected");
    }
    wrong = wrong.replace("invalid float literal", "a number is expected");
    wrong = wrong.replace(
        "number too large to fit in target type",
        "the number is too large",
    );
    let tip = lines.find_map(|line| line.strip_prefix("tip: "));
    (wrong, tip.map(str::to_owned))
}

/// Why the command line is wrong: with the command or option that was probably meant, where clap knows none.
fn refusal(error: &clap::Error, command: &clap::Command) -> String {
    let (wrong, tip) = error_and_tip(error);
    if let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidSubcommand) {
        let known = command.get_subcommands().map(clap::Command::get_name);
        return format!(
            "there is no command '{unknown}'{}",
            did_you_mean(unknown, known)
        );
    }
    let is_like_one = error.get(ContextKind::SuggestedArg).is_some();
    let unknown = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(unknown))) if !is_like_one => {
            unknown
        }
        _ => return tip.map_or(wrong.clone(), |tip| format!("{wrong}; {tip}")),
    };
    let options = command.get_arguments().filter_map(|it| it.get_long());
    let options: Vec<String> = options.map(|it| format!("--{it}")).collect();
    let meant = did_you_mean(unknown, options.iter().map(String::as_str));
    // clap's own tip is how to pass it as a value, which nobody meant.
    format!("{wrong}{meant}")
}

/// The command that the arguments begin with, or that `help` is asked for, and how it is called.
#[must_use]
pub fn command_of<C: CommandFactory>(
    arguments: impl Iterator<Item = OsString>,
) -> (String, clap::Command) {
    let mut program = completed(C::command());
    program.build();
    let (mut command, mut name) = (&program, program.get_name().to_owned());
    for argument in arguments.filter(|it| it != "help") {
        let Some(found) = command.find_subcommand(&argument) else {
            break;
        };
        name = format!("{name} {}", found.get_name());
        command = found;
    }
    (name, command.clone())
}

/// Whether a command line asks for help or the version, or is so short that help answers it.
#[must_use]
pub fn is_help(error: &clap::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    )
}

/// Prints the help that a command line asks for, or says in a line why it is wrong.
#[must_use]
pub fn refused<C: CommandFactory>(error: &clap::Error) -> ExitCode {
    if is_help(error) {
        error.exit();
    }
    let (name, command) = command_of::<C>(std::env::args_os().skip(1));
    planesman_console::err!(
        "{}: {} (see {name} --help)",
        C::command().get_name(),
        shown(refusal(error, &command))
    );
    ExitCode::from(2)
}

/// The exit status of a program's command, whose error is said in a line.
#[must_use]
pub fn ended(program: &str, outcome: anyhow::Result<()>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            planesman_console::err!("{program}: {}", shown(in_one_line(error.as_ref())));
            ExitCode::FAILURE
        }
    }
}

/// A parser for one of several values, each with its name and its help line.
pub fn choice<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    described: fn(T) -> (&'static str, &'static str),
) -> impl TypedValueParser<Value = T> {
    choice_also_known(all, described, |_| &[])
}

/// The same, some of them with other names too.
pub fn choice_also_known<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    described: fn(T) -> (&'static str, &'static str),
    also: fn(T) -> &'static [&'static str],
) -> impl TypedValueParser<Value = T> {
    let values = all.iter().map(|it| possible(described(*it), also(*it)));
    PossibleValuesParser::new(values).try_map(move |name| {
        let is_it =
            |value: &T| described(*value).0 == name || also(*value).contains(&name.as_str());
        let mut values = all.iter().copied();
        values.find(is_it).ok_or("not one of the values")
    })
}

/// A value with its name, its help line and its other names.
pub fn possible(
    (name, about): (&'static str, &'static str),
    also: &'static [&'static str],
) -> PossibleValue {
    let about = match also {
        [] => about.to_owned(),
        names => format!("{about} [also: {}]", names.join(", ")),
    };
    PossibleValue::new(name).help(about).aliases(also)
}

/// A parser for the format of a table.
pub fn format() -> impl TypedValueParser<Value = Format> {
    choice(&Format::ALL, Format::described)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_units::FOOT;

    #[test]
    fn a_quantity_is_in_si_unless_its_unit_is_written() {
        let read = speed(0.01, 10.0);
        for text in ["0.3048", "1ft/s", "1 ft/s", "0.3048m/s"] {
            assert_eq!(read(text), Ok(FOOT), "{text}");
        }
        for text in ["", "fast", "1 ft", "0", "11", "100ft/s", "nan"] {
            let refusal = read(text).expect_err(text);
            assert!(refusal.contains("from 0.01 to 10 m/s"), "{text}: {refusal}");
            assert!(refusal.contains("ft/s"), "{text}: {refusal}");
        }
        assert_eq!(length(0.0, 10.0)("3ft"), Ok(3.0 * FOOT));
    }

    #[test]
    fn an_output_is_refused_where_it_could_not_be_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name).display().to_string();
        std::fs::write(path("there.html"), "").expect("written");
        for (name, reason) in [
            (path("there.html"), "exists already"),
            (path("no/such/page.html"), "there is no folder"),
            (path("."), "it is a folder"),
            (path(".."), "the name of a file"),
        ] {
            let refusal = output_file(&name).expect_err(&name);
            assert!(refusal.contains(reason), "{name}: {refusal}");
        }
        for name in [
            path("new.html"),
            "/dev/null".to_owned(),
            "new.html".to_owned(),
        ] {
            assert_eq!(output_file(&name), Ok(PathBuf::from(&name)));
        }
    }
}
