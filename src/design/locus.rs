//! `planesman design locus`: the poles of the dive loop as one gain, or the speed, changes.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use planesman_linear::Complex;

use super::subject::{GainArgs, Subject, Varied, poles_text};
use crate::arguments::{output_file, speed, within};
use crate::table::wrapped;
use planesman_plot::{Plot, Style};

/// Points of the drawing.
const DOTS: u32 = 600;

/// The quantity that varies, and its range.
#[derive(Args)]
#[command(allow_negative_numbers = true, next_help_heading = "Locus")]
pub struct LocusArgs {
    #[command(flatten)]
    subject: Subject,
    #[command(flatten)]
    gains: GainArgs,
    /// Speed through the water (m/s, or with its unit: 1ft/s), unless it varies
    #[arg(long, default_value_t = 0.3048, value_parser = speed(1e-3, 100.0))]
    speed: f64,
    /// Quantity that varies
    #[arg(long, value_enum)]
    vary: Varied,
    /// First value; a speed in m/s or with its unit: 1ft/s
    #[arg(long, default_value = "0", value_parser = bound)]
    from: Bound,
    /// Last value; a speed in m/s or with its unit: 3ft/s
    #[arg(long, value_parser = bound)]
    to: Bound,
    /// Number of rows of the table
    #[arg(long, default_value_t = 11, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    rows: u32,
    /// Write a drawing to this file
    #[arg(long, value_name = "FILE.svg", value_parser = output_file)]
    svg: Option<PathBuf>,
}

/// An end of the range: a number, or a speed with its unit.
#[derive(Clone, Copy)]
struct Bound {
    /// In SI.
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

/// Prints the table, and draws where that is asked for.
///
/// # Errors
/// A speed for a gain, a vehicle or actuator that is refused, numbers that overflow, a file that cannot be written.
pub fn run(args: &LocusArgs) -> Result<()> {
    let gives_speed = args.from.has_unit || args.to.has_unit;
    if gives_speed && args.vary != Varied::Speed {
        bail!(
            "--from and --to: a speed is given, but --vary names a gain; gains are numbers in SI"
        );
    }
    for i in 0..args.rows {
        let value = args.value(f64::from(i) / f64::from(args.rows - 1));
        let line = format!("{value:12.5}  {}", poles_text(&args.poles(value)?));
        planesman_node::say!("{}", wrapped(&line).trim_end())?;
    }
    if let Some(file) = &args.svg {
        fs::write(file, args.drawing()?).with_context(|| format!("{}", file.display()))?;
        planesman_node::say!("{}", file.display())?;
    }
    Ok(())
}

impl LocusArgs {
    /// The value at a share of the range.
    fn value(&self, share: f64) -> f64 {
        let (from, to) = (self.from.value, self.to.value);
        let value = from + share * (to - from);
        // A vehicle at rest has no plane moments to speak of.
        if self.vary == Varied::Speed {
            value.max(1e-3)
        } else {
            value
        }
    }

    fn poles(&self, value: f64) -> Result<Vec<Complex<f64>>> {
        let (mut gains, mut speed) = (self.gains.gains(), self.speed);
        *match self.vary {
            Varied::DepthP => &mut gains.depth_p,
            Varied::DepthD => &mut gains.depth_d,
            Varied::PitchP => &mut gains.pitch_p,
            Varied::PitchRate => &mut gains.pitch_rate,
            Varied::Speed => &mut speed,
        } = value;
        Ok(self
            .subject
            .dive_loop(gains, speed)?
            .closed_loop()?
            .poles()?)
    }

    fn drawing(&self) -> Result<String> {
        let mut between = Vec::new();
        for i in 1..DOTS {
            // Dense at the beginning: there the poles move most.
            between.extend(self.poles(self.value((f64::from(i) / f64::from(DOTS)).powi(2)))?);
        }
        // Those of the dead time are far to the left and would make the rest small.
        let far = 4.0
            * self
                .poles(self.value(0.0))?
                .iter()
                .map(|s| s.norm())
                .fold(1.0, f64::min)
                .max(1.0);
        let near = |poles: Vec<Complex<f64>>| -> Vec<(f64, f64)> {
            let near = poles.iter().filter(|s| s.norm() < far);
            near.map(|s| (s.re, s.im)).collect()
        };
        Plot::new("root locus", ["real part [1/s]", "imaginary part [rad/s]"])
            .from_zero()
            .with(Style::Dots, "between", near(between))
            .with(
                Style::Crosses,
                "first value",
                near(self.poles(self.value(0.0))?),
            )
            .with(
                Style::Circles,
                "last value",
                near(self.poles(self.value(1.0))?),
            )
            .svg()
    }
}
