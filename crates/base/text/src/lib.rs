#![doc = include_str!("../README.md")]
//!
//! - [`read()`]: reads a text file of limited size.
//! - [`decoded`], [`unmarked`]: UTF-8 text from bytes; UTF-16 is refused with a message.
//! - [`yaml`]: parses YAML of limited depth and size.
//! - [`shown()`]: escapes foreign text for a terminal or a page.
//! - [`in_one_line`]: an error with its causes in one line.
//! - [`number()`], [`grouped`]: a number, and a count, for readers.
//! - [`shell_word`]: a word quoted for a shell.
//! - [`option`], [`setting`]: names of options in the form of each front end ([`use_wording`]).
//! - [`choices!`]: an enum whose values have a word and a line of help.
//! - [`did_you_mean`]: the nearest known name.
//! - [`Draft`], [`write_whole`], [`write_text`]: files that are written completely or not at all.
//!
//! All reading and printing of foreign text, and all replacing of files, uses this crate, so that problems are fixed in one place.

mod draft;
mod number;
mod one_line;
mod read;
mod shell_word;
mod shown;
mod suggestion;
pub mod yaml;

pub use draft::{Draft, write_text, write_whole};
pub use number::{grouped, number};
pub use one_line::in_one_line;
pub use planesman_wording::{Setting, Wording, choices, option, setting, use_wording};
pub use read::{LARGEST, decoded, read, unmarked};
pub use shell_word::shell_word;
pub use shown::{Shown, shown};
pub use suggestion::did_you_mean;
