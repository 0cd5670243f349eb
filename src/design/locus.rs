//! `planesman design locus`: the poles of the dive loop as one gain, or the speed, changes.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum as _};
use maud::html;
use planesman_linear::Complex;
use planesman_plot::{Plot, Series, Style};

use super::subject::{GainArgs, Subject, Varied, gains_text, poles_text, speed_text};
use crate::arguments::{number, output_file, speed, within};
use crate::page::{document, figures};
use crate::sink::write_text;
use crate::table::{Table, wrapped};

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
    /// Also draw it on an HTML page, on which the cursor tells the value at each pole
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    html: Option<PathBuf>,
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
    for value in args.values() {
        let line = format!("{value:12.5}  {}", poles_text(&args.poles(value)?));
        planesman_node::say!("{}", wrapped(&line).trim_end())?;
    }
    if let Some(file) = &args.html {
        write_text(file, args.page()?)?;
        planesman_node::say!("{}", file.display())?;
    }
    Ok(())
}

impl LocusArgs {
    /// The values of the table.
    fn values(&self) -> impl Iterator<Item = f64> {
        let last = f64::from(self.rows - 1);
        (0..self.rows).map(move |i| self.value(f64::from(i) / last))
    }

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

    fn page(&self) -> Result<String> {
        let possible = self.vary.to_possible_value();
        let varied = possible.map_or_else(String::new, |it| it.get_name().to_owned());
        let (from, to) = (number(self.value(0.0)), number(self.value(1.0)));
        let title = format!(
            "Root locus of {} behind {}: {varied} from {from} to {to}",
            self.subject.vehicle, self.subject.actuator
        );
        let mut fixed = gains_text(&self.gains.gains());
        if self.vary != Varied::Speed {
            fixed += &format!(", U = {}", speed_text(self.speed));
        }
        let mut rows = Table::of([varied.as_str(), "poles [1/s]"]);
        for value in self.values() {
            rows.row([number(value), poles_text(&self.poles(value)?)]);
        }
        let body = html! {
            h1 { (title) }
            p.lead { "All others as in " (fixed) "." }
            div.columns { (figures(&[self.drawing(&varied)?])) (rows.html()) }
        };
        Ok(document(&title, "td { text-align: left; }", &body, ""))
    }

    fn drawing<'a>(&self, varied: &'a str) -> Result<Plot<'a>> {
        // Those of the dead time are far to the left and would make the rest small.
        let far = 4.0
            * self
                .poles(self.value(0.0))?
                .iter()
                .map(|s| s.norm())
                .fold(1.0, f64::min)
                .max(1.0);
        let at = |style, name: &'static str, shares: &mut dyn Iterator<Item = f64>| {
            let (mut points, mut values) = (Vec::new(), Vec::new());
            for share in shares {
                let value = self.value(share);
                let near = self.poles(value)?.into_iter().filter(|s| s.norm() < far);
                points.extend(near.map(|s| (s.re, s.im)));
                values.resize(points.len(), value);
            }
            anyhow::Ok(Series {
                at: Some((varied.into(), values)),
                ..Series::new(style, name, points)
            })
        };
        // Dense at the beginning: there the poles move most.
        let mut shares = (1..DOTS).map(|i| (f64::from(i) / f64::from(DOTS)).powi(2));
        Ok(
            Plot::new("Root locus", ["real part [1/s]", "imaginary part [rad/s]"])
                .from_zero()
                .one_scale()
                .with_all([
                    at(Style::Dots, "between", &mut shares)?,
                    at(Style::Crosses, "first value", &mut [0.0].into_iter())?,
                    at(Style::Circles, "last value", &mut [1.0].into_iter())?,
                ]),
        )
    }
}
