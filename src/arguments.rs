//! Parsing and printing of command-line values, shared by several commands.

use std::any::TypeId;
use std::ffi::{OsStr, OsString};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{fs, io};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser};
use planesman_console::Format;
use planesman_text::{did_you_mean, in_one_line, shown};
use planesman_units::{Dimension, Quantity};
use rustix::fs::{Access, access};

/// Help text of a scenario argument.
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

/// A parser of quantities in `[least, most]`, both in SI. A bare number is in SI; other units are written with the number, such as `1ft/s`.
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

/// The option that allows a command to replace its existing files and folders.
const OVERWRITE: &str = "--overwrite";

/// Whether the command line has `--overwrite`. Parsers of values need it before all options are parsed.
#[must_use]
pub fn overwrites() -> bool {
    let mut options = std::env::args_os().skip(1).take_while(|it| it != "--");
    options.any(|it| it == OVERWRITE)
}

/// Removes an existing regular file if `--overwrite` is given. Anything else at the path is kept, and writing there fails.
///
/// # Errors
/// When it cannot be removed.
pub fn make_way(path: &Path) -> io::Result<()> {
    match overwrites() && path.is_file() {
        true => fs::remove_file(path),
        false => Ok(()),
    }
}

/// Removes an existing results folder if `--overwrite` is given and [`is_replaceable`] allows it. Any other folder stays; writing to such a folder
/// then fails.
///
/// # Errors
/// Those of [`is_replaceable`]; the folder cannot be removed.
pub fn make_way_for_folder(folder: &Path, own: &[&str]) -> io::Result<()> {
    match is_replaceable(folder, own)? {
        true => fs::remove_dir_all(folder),
        false => Ok(()),
    }
}

/// Whether `--overwrite` may replace this folder. The folder is recognised by the first file of `own`. The names in `own` are relative to the
/// folder; a `*` matches any characters but `/`.
///
/// # Errors
/// The folder is a link, the current folder or a parent of it, or cannot be read. It contains a file that is not in `own`, or that
/// the command line names.
pub fn is_replaceable(folder: &Path, own: &[&str]) -> io::Result<bool> {
    let is_known = own.first().is_some_and(|it| folder.join(it).is_file());
    if !overwrites() || !is_known {
        return Ok(false);
    }
    let refused = |reason: String| {
        let text = format!("'{}' cannot be replaced: {reason}", folder.display());
        Err(io::Error::other(text))
    };
    // Without a slash at its end, which would follow a link.
    let plain: PathBuf = folder.components().collect();
    if plain.symlink_metadata()?.is_symlink() {
        return refused("it is a link".to_owned());
    }
    let whole = folder.canonicalize()?;
    let is_around = std::env::current_dir()?.canonicalize()?.starts_with(&whole);
    if plain.file_name().is_none() || is_around {
        return refused(
            "the folder is the current folder or contains the current folder".to_owned(),
        );
    }
    if let Some(foreign) = first_foreign(folder, Path::new(""), own)? {
        return refused(format!(
            "the folder contains '{}', which this command did not write. Name a new folder",
            foreign.display()
        ));
    }
    let mut named = std::env::args_os().skip(1).flat_map(|it| paths_in(&it));
    let input = named.find(|it| {
        let path = it.canonicalize();
        path.is_ok_and(|it| it != whole && it.starts_with(&whole))
    });
    match input {
        Some(input) => refused(format!("the command reads '{}'", input.display())),
        None => Ok(true),
    }
}

/// The first file or folder in `folder`, below `within`, that no pattern of `own` matches.
fn first_foreign(folder: &Path, within: &Path, own: &[&str]) -> io::Result<Option<PathBuf>> {
    let entries = fs::read_dir(folder.join(within))?;
    let mut entries = entries.collect::<io::Result<Vec<_>>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = within.join(entry.file_name());
        let kind = entry.file_type()?;
        let is_own = own.iter().any(|it| match kind.is_dir() {
            true => Path::new(it).parent() == Some(path.as_path()),
            false => kind.is_file() && is_like(&path, it),
        });
        let foreign = match (is_own, kind.is_dir()) {
            (false, _) => Some(path),
            (true, true) => first_foreign(folder, &path, own)?,
            (true, false) => None,
        };
        if foreign.is_some() {
            return Ok(foreign);
        }
    }
    Ok(None)
}

/// Whether a path matches the pattern; one `*` matches any characters but `/`.
fn is_like(path: &Path, pattern: &str) -> bool {
    let Some(text) = path.to_str() else {
        return false;
    };
    match pattern.split_once('*') {
        None => text == pattern,
        Some((begin, end)) => text
            .strip_prefix(begin)
            .and_then(|it| it.strip_suffix(end))
            .is_some_and(|it| !it.contains('/')),
    }
}

/// The paths that a word of the command line may name: the whole word, and the parts after `=`, after commas and after an option's letter.
fn paths_in(word: &OsStr) -> Vec<PathBuf> {
    let text = word.to_string_lossy();
    let behind_letter = text.strip_prefix('-').and_then(|it| it.get(1..));
    let parts = text.split(['=', ',']).chain(behind_letter);
    let parts = parts.filter(|it| !it.is_empty()).map(PathBuf::from);
    std::iter::once(PathBuf::from(word)).chain(parts).collect()
}

/// The reason why `--overwrite` may not replace this file: the command line names the file more than `given` times, or the file is part of a recording.
/// `given` is the number of times it is named as an output.
fn reason_to_keep(path: &Path, given: usize) -> Option<String> {
    let identity = |it: &Path| it.metadata().ok().map(|it| (it.dev(), it.ino()));
    let own = identity(path)?;
    let names = |word: &OsString| {
        let mut paths = paths_in(word).into_iter();
        paths.any(|it| identity(&it) == Some(own))
    };
    if std::env::args_os().skip(1).filter(names).count() > given {
        return Some("the command line names this file twice. Name another file".to_owned());
    }
    let is_of_bag = path.file_name().is_some_and(|it| it == "metadata.yaml")
        || ending(path).is_some_and(|it| ["mcap", "db3"].contains(&it));
    (is_of_bag && path.with_file_name("metadata.yaml").is_file())
        .then(|| "the file is part of a recording. Name another file".to_owned())
}

/// Whether `--overwrite` may replace this file, if it exists. `is_named`: the command line names the file.
///
/// # Errors
/// The command reads the file, or the file is part of a recording.
pub fn overwritten(path: &Path, is_named: bool) -> io::Result<bool> {
    match overwrites().then(|| reason_to_keep(path, usize::from(is_named))) {
        Some(Some(reason)) => Err(io::Error::other(format!("'{}': {reason}", path.display()))),
        may => Ok(may.is_some()),
    }
}

fn ending(path: &Path) -> Option<&str> {
    path.extension()?.to_str()
}

/// Checks an HTML page to be written, as [`output_file`] does; an existing file is replaced only if it is a page.
///
/// # Errors
/// A sentence: why the page cannot be written.
pub fn page_file(text: &str) -> Result<PathBuf, String> {
    let path = output_file(text)?;
    let is_page = ending(&path).is_some_and(|it| ["html", "htm"].contains(&it));
    match path.is_file() && !is_page {
        true => Err(format!(
            "the folder exists already, and {OVERWRITE} replaces only pages, *.html"
        )),
        false => Ok(path),
    }
}

/// Checks the default output file of a command, as [`output_file`] does.
///
/// # Errors
/// A sentence: why the file cannot be written.
pub fn default_file(text: &str) -> Result<PathBuf, String> {
    output(text, 0)
}

/// Checks a file to be written, before the command starts its work: its folder exists and is writable, and no file or folder has its
/// name yet. With `--overwrite` a file may exist; a device such as `/dev/stdout` always may.
///
/// # Errors
/// A sentence: why the file cannot be written.
pub fn output_file(text: &str) -> Result<PathBuf, String> {
    output(text, 1)
}

/// Checks a file as [`output_file`] does, if the command line names it `given` times as an output.
fn output(text: &str, given: usize) -> Result<PathBuf, String> {
    let path = Path::new(text);
    if path.file_name().is_none() {
        return Err("a file name is expected".to_owned());
    }
    match path.metadata() {
        Ok(there) if there.is_dir() => return Err("it is a folder".to_owned()),
        Ok(there) if there.is_file() && !overwrites() => {
            return Err(format!(
                "the file exists already. Name a new file, or add {OVERWRITE}"
            ));
        }
        Ok(there) if there.is_file() => {
            if let Some(reason) = reason_to_keep(path, given) {
                return Err(reason);
            }
        }
        Ok(_) => return Ok(path.to_owned()),
        Err(_) => {}
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(format!("the folder '{}' does not exist", folder.display()));
    }
    access(folder, Access::WRITE_OK | Access::EXEC_OK)
        .map_err(|error| format!("the folder '{}': {error}", folder.display()))?;
    Ok(path.to_owned())
}

/// The command line of this process, parsed with the shared options of [`completed`].
///
/// # Errors
/// As clap's `try_parse`.
pub fn parsed<C: Parser>() -> Result<C, clap::Error> {
    let mut matches = completed(C::command()).try_get_matches()?;
    C::from_arg_matches_mut(&mut matches)
}

/// Adds the settings that all commands share. An option for a number accepts negative values, so that the option's own range refuses them. A command
/// that writes files gets `--overwrite`, which [`overwrites`] reads.
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
        .help("Replace existing files and folders of results");
    match writes {
        true => taking.arg(overwrite),
        false => taking,
    }
    .mut_subcommands(completed)
}

/// A command-line error in one line, without the usage; separately, clap's suggestion.
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

/// The reason why the command line is refused; suggests the nearest command or option.
fn refusal(error: &clap::Error, command: &clap::Command) -> String {
    let (wrong, tip) = error_and_tip(error);
    if let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidSubcommand) {
        let known = command.get_subcommands().map(clap::Command::get_name);
        return format!(
            "unknown command '{unknown}'{}",
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

/// The command at the beginning of the command line, or the command after `help`; with the name to call it by.
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

/// Whether a command line requests help or the version, or is incomplete and therefore gets the help as answer.
#[must_use]
pub fn is_help(error: &clap::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    )
}

/// Prints the requested help, or one line with the reason why the command line is refused.
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

/// The exit status of a program's command; an error is printed in one line.
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

/// A parser that accepts one of several values, each with a name and a help line.
pub fn choice<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    described: fn(T) -> (&'static str, &'static str),
) -> impl TypedValueParser<Value = T> {
    choice_also_known(all, described, |_| &[])
}

/// Like [`choice`], with aliases for some of the values.
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
        values.find(is_it).ok_or("unknown value")
    })
}

/// A possible value with its name, help line and aliases.
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

/// A parser of table formats.
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
    fn a_file_that_is_not_the_commands_own_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let own = ["scenario.yaml", "log/*.log", "cases-*.csv"];
        fs::create_dir(folder.path().join("log")).expect("made");
        let foreign = || first_foreign(folder.path(), Path::new(""), &own).expect("readable");
        for name in ["scenario.yaml", "log/plant_sim.log", "cases-1-of-2.csv"] {
            fs::write(folder.path().join(name), "").expect("written");
        }
        assert_eq!(foreign(), None);
        for name in ["thesis.txt", "log/notes.txt", "my-cases-1.csv"] {
            let path = folder.path().join(name);
            fs::write(&path, "").expect("written");
            assert_eq!(foreign(), Some(PathBuf::from(name)));
            fs::remove_file(&path).expect("removed");
        }
        fs::create_dir(folder.path().join("photos")).expect("made");
        assert_eq!(foreign(), Some(PathBuf::from("photos")));
    }

    #[test]
    fn an_output_is_refused_where_it_could_not_be_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name).display().to_string();
        std::fs::write(path("there.html"), "").expect("written");
        for (name, reason) in [
            (path("there.html"), "exists already"),
            (path("no/such/page.html"), "does not exist"),
            (path("."), "it is a folder"),
            (path(".."), "a file name is expected"),
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
