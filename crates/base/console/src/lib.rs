//! Terminal output of the programs: tables, progress, and printing that survives a closed pipe or a full disk.
//!
//! - [`out!`], [`err!`], [`print()`]: print a line on standard output, a line on standard error, text on standard output.
//! - [`Outcome`], [`file_line`]: the structure of every command's output: answer, numbers, files, next commands.
//! - [`Table`], [`Format`]: rows with named columns, printed aligned, as Markdown, CSV or JSON.
//! - [`print_wrapped`], [`wrapped`]: sentences wrapped to the terminal's width.
//! - [`progress`]: bars and spinners; parallel work with a bar.
//! - [`sparkline()`]: a curve in one line of text.

mod outcome;
pub mod progress;
mod sparkline;
mod table;

pub use outcome::{Outcome, called, file_line};
use planesman_text::shown;
pub use sparkline::sparkline;
pub use table::{Format, Table, is_terminal, print_wrapped, terminal, wrapped};

/// Prints a line of a command's output, as [`print()`] does.
#[macro_export]
macro_rules! out {
    ($($argument:tt)*) => {
        $crate::print(format_args!("{}\n", format_args!($($argument)*)))
    };
}

/// Writes a line to standard error, as `eprintln!` does. If that fails, for example on a full disk, the program continues.
#[macro_export]
macro_rules! err {
    ($($argument:tt)*) => {
        $crate::write_error(format_args!("{}\n", format_args!($($argument)*)))
    };
}

/// Writes the text formatted by [`err!`] to standard error.
pub fn write_error(text: std::fmt::Arguments<'_>) {
    use std::io::Write as _;
    let _ = std::io::stderr().write_fmt(text);
}

/// Prints the output of a command; foreign names and texts are escaped ([`shown`]). A reader that stops early (`| head`) or a closed terminal is
/// not an error.
///
/// # Errors
/// Standard output cannot be written, for example on a full disk.
pub fn print(text: impl std::fmt::Display) -> std::io::Result<()> {
    use std::io::Write as _;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    match write!(out, "{}", shown(text)).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe || is_gone(&error) => Ok(()),
        result => result,
    }
}

/// Whether standard output is a terminal that was closed. For a file the same error comes from the disk.
fn is_gone(error: &std::io::Error) -> bool {
    use rustix::{fs, io::Errno};
    let kind = |it: fs::Stat| fs::FileType::from_raw_mode(it.st_mode);
    error.raw_os_error() == Some(Errno::IO.raw_os_error())
        && fs::fstat(std::io::stdout()).is_ok_and(|it| kind(it) == fs::FileType::CharacterDevice)
}
