//! What a program prints: tables, progress, lines that a closed pipe or a full disk does not break.
//!
//! - [`out!`], [`err!`], [`print()`]: a line on standard output, on standard error, text on standard output.
//! - [`Outcome`], [`file_line`]: the order of every command's output: answer, numbers, files, what next.
//! - [`Table`], [`Format`]: rows under the names of their columns, aligned, as Markdown, CSV or JSON.
//! - [`print_wrapped`], [`wrapped`]: sentences within the terminal's width.
//! - [`progress`]: bars and spinners; work on all cores under a bar.
//! - [`sparkline()`]: a curve in one line.

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

/// Writes a line to standard error, as `eprintln!` does; where that cannot be written, as on a full
/// disk, nobody is left to tell, and the program goes on.
#[macro_export]
macro_rules! err {
    ($($argument:tt)*) => {
        $crate::write_error(format_args!("{}\n", format_args!($($argument)*)))
    };
}

/// Writes to standard error what [`err!`] formats.
pub fn write_error(text: std::fmt::Arguments<'_>) {
    use std::io::Write as _;
    let _ = std::io::stderr().write_fmt(text);
}

/// Prints the output of a command, with foreign names and texts made harmless ([`shown`]). A reader that has read
/// enough (`| head`) is no error, nor is a terminal that was closed.
///
/// # Errors
/// When standard output cannot be written, as on a full disk.
pub fn print(text: impl std::fmt::Display) -> std::io::Result<()> {
    use std::io::Write as _;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    match write!(out, "{}", shown(text)).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe || is_gone(&error) => Ok(()),
        result => result,
    }
}

/// Whether standard output is a terminal that was closed. Of a file the same error is the disk's.
fn is_gone(error: &std::io::Error) -> bool {
    use rustix::{fs, io::Errno};
    let kind = |it: fs::Stat| fs::FileType::from_raw_mode(it.st_mode);
    error.raw_os_error() == Some(Errno::IO.raw_os_error())
        && fs::fstat(std::io::stdout()).is_ok_and(|it| kind(it) == fs::FileType::CharacterDevice)
}
