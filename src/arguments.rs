//! Values on the command line, read and written: what several commands share.

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

/// Removes the file that `--overwrite` lets a command replace. What is no file stays, and is refused by whoever writes there.
///
/// # Errors
/// When it cannot be removed.
pub fn make_way(path: &Path) -> io::Result<()> {
    match overwrites() && path.is_file() {
        true => fs::remove_file(path),
        false => Ok(()),
    }
}

/// Removes the folder that `--overwrite` lets a command replace, as [`is_replaceable`] says. Any other stays, and is refused
/// by whoever writes there.
///
/// # Errors
/// As [`is_replaceable`]; when it cannot be removed.
pub fn make_way_for_folder(folder: &Path, own: &[&str]) -> io::Result<()> {
    match is_replaceable(folder, own)? {
        true => fs::remove_dir_all(folder),
        false => Ok(()),
    }
}

/// Whether `--overwrite` lets a command replace a folder: the first of its `own` files is in it, by which the folder is known. The
/// names of its own files are relative to it, with a `*` for any characters but `/`.
///
/// # Errors
/// When such a folder is a link or the current folder or around it, holds a file that is not the command's own or that
/// the command line names, or cannot be read.
pub fn is_replaceable(folder: &Path, own: &[&str]) -> io::Result<bool> {
    let is_known = own.first().is_some_and(|it| folder.join(it).is_file());
    if !overwrites() || !is_known {
        return Ok(false);
    }
    let refused = |reason: String| {
        let text = format!("'{}' is not replaced: {reason}", folder.display());
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
        return refused("it is the current folder or around it".to_owned());
    }
    if let Some(foreign) = first_foreign(folder, Path::new(""), own)? {
        return refused(format!(
            "'{}' in it is not this command's; name a new folder",
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

/// The first file or folder in `folder`, below `within`, whose name is none of its `own`.
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

/// Whether a path is the pattern, in which one `*` stands for any characters but `/`.
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

/// The paths that a word of the command line may name: itself, and what is behind `=`, commas or an option's letter.
fn paths_in(word: &OsStr) -> Vec<PathBuf> {
    let text = word.to_string_lossy();
    let behind_letter = text.strip_prefix('-').and_then(|it| it.get(1..));
    let parts = text.split(['=', ',']).chain(behind_letter);
    let parts = parts.filter(|it| !it.is_empty()).map(PathBuf::from);
    std::iter::once(PathBuf::from(word)).chain(parts).collect()
}

/// Why `--overwrite` does not let a command replace this file, which the command line names `given` times as an output: it
/// names it once more, or the file is part of a recording.
fn reason_to_keep(path: &Path, given: usize) -> Option<String> {
    let identity = |it: &Path| it.metadata().ok().map(|it| (it.dev(), it.ino()));
    let own = identity(path)?;
    let names = |word: &OsString| {
        let mut paths = paths_in(word).into_iter();
        paths.any(|it| identity(&it) == Some(own))
    };
    if std::env::args_os().skip(1).filter(names).count() > given {
        return Some("the command line names it twice; name another file".to_owned());
    }
    let is_of_bag = path.file_name().is_some_and(|it| it == "metadata.yaml")
        || ending(path).is_some_and(|it| ["mcap", "db3"].contains(&it));
    (is_of_bag && path.with_file_name("metadata.yaml").is_file())
        .then(|| "it is part of a recording; name another file".to_owned())
}

/// Whether `--overwrite` lets a command replace this file, if it is there; `is_named` when the command line names it.
///
/// # Errors
/// When the command reads it, or it is part of a recording.
pub fn overwritten(path: &Path, is_named: bool) -> io::Result<bool> {
    match overwrites().then(|| reason_to_keep(path, usize::from(is_named))) {
        Some(Some(reason)) => Err(io::Error::other(format!("'{}': {reason}", path.display()))),
        may => Ok(may.is_some()),
    }
}

fn ending(path: &Path) -> Option<&str> {
    path.extension()?.to_str()
}

/// A page that a command is to write: as [`output_file`], and a file that is replaced is one.
///
/// # Errors
/// A sentence: what keeps the page from being written.
pub fn page_file(text: &str) -> Result<PathBuf, String> {
    let path = output_file(text)?;
    let is_page = ending(&path).is_some_and(|it| ["html", "htm"].contains(&it));
    match path.is_file() && !is_page {
        true => Err(format!(
            "it exists already, and {OVERWRITE} replaces a page *.html alone"
        )),
        false => Ok(path),
    }
}

/// The file that a command writes where none is named: as [`output_file`].
///
/// # Errors
/// A sentence: what keeps the file from being written.
pub fn default_file(text: &str) -> Result<PathBuf, String> {
    output(text, 0)
}

/// A file that a command is to write. It is checked before the work is done: the folder exists and can be written,
/// and no file or folder of that name is there, but for a file with `--overwrite`. A device such as `/dev/stdout` may be there.
///
/// # Errors
/// A sentence: what keeps the file from being written.
pub fn output_file(text: &str) -> Result<PathBuf, String> {
    output(text, 1)
}

/// The same of a file that the command line names `given` times as an output.
fn output(text: &str, given: usize) -> Result<PathBuf, String> {
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
