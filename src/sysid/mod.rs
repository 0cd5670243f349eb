//! What the program adds to identification: pages.
//!
//! - [`page`]: a model with everything there is to know of it, as one HTML page.

use anyhow::{Context, Result};
use sysid::identify_command::{self, IdentifyArgs};

pub mod page;

/// Runs `planesman sysid identify`: as `sysid identify`, with its page.
///
/// # Errors
/// As [`identify_command::identify`]; a page that cannot be drawn or written.
pub fn identify(args: &IdentifyArgs) -> Result<()> {
    let (analysis, record) = identify_command::identify(args)?;
    if let Some(path) = &args.html {
        std::fs::write(path, page::page(&analysis, &record)?)
            .with_context(|| format!("{}", path.display()))?;
        println!("{}: the page", path.display());
    }
    Ok(())
}
