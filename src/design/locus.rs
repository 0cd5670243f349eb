//! `planesman design locus`: the closed-loop poles as one gain, or the speed, varies.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use planesman_console::{print_wrapped, wrapped};
use planesman_flight::sink::write_text;
use planesman_show::design::{Locus, Varied, heading};

use super::arguments::{GainArgs, SubjectArgs};
use crate::arguments::{choice, page_file, speed, within};

/// Arguments of `design locus`.
#[derive(Args)]
#[command(next_help_heading = "Locus")]
pub struct LocusArgs {
    #[command(flatten)]
    subject: SubjectArgs,
    #[command(flatten)]
    gains: GainArgs,
    /// Speed through the water (m/s, or with its unit: 1ft/s), unless --vary names the speed
    #[arg(long, default_value_t = 0.3048, value_parser = speed(1e-3, 100.0))]
    speed: f64,
    /// Quantity to vary
    #[arg(long, value_parser = choice(&Varied::ALL, Varied::described))]
    vary: Varied,
    /// First value; a speed in m/s or with its unit: 1ft/s
    #[arg(long, default_value = "0", value_parser = bound, allow_hyphen_values = true)]
    from: Bound,
    /// Last value; a speed in m/s or with its unit: 3ft/s
    #[arg(long, value_parser = bound, allow_hyphen_values = true)]
    to: Bound,
    /// Number of rows of the table
    #[arg(long, default_value_t = 11, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    rows: u32,
    /// Also write an HTML page with the locus; the cursor shows the value at each pole
    #[arg(long, value_name = "FILE", value_parser = page_file)]
    html: Option<PathBuf>,
}

/// One end of the range: either a number, or a speed with its unit.
#[derive(Clone, Copy)]
struct Bound {
    /// Value in SI.
    value: f64,
    has_unit: bool,
}

fn bound(text: &str) -> std::result::Result<Bound, String> {
    let has_unit = text.parse::<f64>().is_err();
    let value = match has_unit {
        true => speed(0.0, 1e3)(text).map_err(|_| {
            "a number from 0 to 1000 is expected, or a speed with its unit: m/s, ft/s".to_owned()
        })?,
        false => within(0.0, 1e3)(text)?,
    };
    Ok(Bound { value, has_unit })
}

/// Prints the table, and writes the page of `--html`.
///
/// # Errors
/// A speed given for a gain, a refused vehicle or actuator, numerical overflow, a file that cannot be written.
pub fn run(args: &LocusArgs) -> Result<()> {
    let gives_speed = args.from.has_unit || args.to.has_unit;
    if gives_speed && args.vary != Varied::Speed {
        bail!("--from and --to are speeds, but --vary names a gain: gains are numbers in SI");
    }
    let locus = Locus {
        subject: args.subject.subject(),
        law: args.gains.law(),
        speed: args.speed,
        vary: args.vary,
        from: args.from.value,
        to: args.to.value,
        rows: args.rows,
    };
    let drive = locus.subject.drive()?;
    print_wrapped(heading(&locus.subject, &drive))?;
    let head = Varied::described(args.vary).1;
    planesman_console::out!("{head:>12}  poles of the closed loop [1/s]")?;
    for value in locus.values() {
        let line = format!("{value:12.5}  {}", locus.poles_text(&drive, value)?);
        planesman_console::out!("{}", wrapped(&line).trim_end())?;
    }
    if let Some(file) = &args.html {
        write_text(file, locus.page(&drive)?)?;
        planesman_console::out!("\n{}", planesman_console::file_line("Page", file))?;
    }
    Ok(())
}
