#![doc = include_str!("../README.md")]
//!
//! - [`read()`]: a text file, read within bounds.
//! - [`decoded`], [`unmarked`]: bytes as UTF-8 text, UTF-16 refused by name.
//! - [`yaml`]: YAML, its depth and size bounded before it is parsed.
//! - [`shown()`]: text as it may be shown, on a terminal or a page, whatever it holds.
//! - [`in_one_line`]: an error with its causes.
//! - [`number()`], [`grouped`]: a number, a count for a reader.
//! - [`shell_word`]: a word as a shell takes it.
//! - [`option`], [`setting`]: options as the user of each front end writes them ([`use_wording`]).
//! - [`choices!`]: an enum; each value has a word and a line of help.
//! - [`did_you_mean`]: the name that was probably meant.
//! - [`Draft`], [`write_whole`], [`write_text`]: files that are whole or not there.
//!
//! Whoever reads text of others or shows it, or moves a finished file into its place, does so through this crate: there is one place to mend.

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
