//! Text that comes from outside: files that people write, and names that anybody may choose.
//!
//! - [`read()`]: a text file, read within bounds.
//! - [`decoded`], [`unmarked`]: bytes as UTF-8 text, UTF-16 refused by name.
//! - [`yaml`]: YAML, its depth and size bounded before it is parsed.
//! - [`shown()`]: text as it may be shown, on a terminal or a page, whatever it holds.
//! - [`did_you_mean`]: the name that was probably meant.
//!
//! Whoever reads text of others or shows it does so through this crate: there is one place to mend.

mod read;
mod shown;
mod suggestion;
pub mod yaml;

pub use read::{LARGEST, decoded, read, unmarked};
pub use shown::{Shown, shown};
pub use suggestion::did_you_mean;
