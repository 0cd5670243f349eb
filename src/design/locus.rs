//! `planesman design locus`: the poles of the dive loop as one gain, or the speed, changes.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum as _};
use maud::html;
use planesman_control::design::dive_loop::DiveLoop;
use planesman_control::gains::LoopGains;
use planesman_linear::{Complex, discrete_to_continuous};
use planesman_plot::{Plot, Series, Style};

use super::analyse::{FAST, heading};
use super::subject::{Drive, GainArgs, Subject, Varied, law_text, poles_text, speed_text};
use crate::arguments::{output_file, speed, within};
use planesman_console::number;
use planesman_console::{Table, print_wrapped, wrapped};
use planesman_flight::sink::write_text;
use planesman_pages::{document, figures};

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
    let drive = args.subject.drive()?;
    print_wrapped(heading(&args.subject, &drive))?;
    for value in args.values() {
        let line = format!("{value:12.5}  {}", args.poles_text(&drive, value)?);
        planesman_console::out!("{}", wrapped(&line).trim_end())?;
    }
    if let Some(file) = &args.html {
        write_text(file, args.page(&drive)?)?;
        planesman_console::out!("{}", file.display())?;
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

    /// The gain that varies; `None` for the speed.
    fn gain(&self) -> Option<fn(&mut LoopGains) -> &mut f64> {
        match self.vary {
            Varied::DepthP => Some(|gains| &mut gains.depth_p),
            Varied::DepthD => Some(|gains| &mut gains.depth_d),
            Varied::PitchP => Some(|gains| &mut gains.pitch_p),
            Varied::PitchRate => Some(|gains| &mut gains.pitch_rate),
            Varied::Speed => None,
        }
    }

    fn dive_loop(&self, drive: &Drive, value: f64) -> Result<DiveLoop> {
        let mut gains = self.gains.gains();
        let speed = match self.gain() {
            Some(gain) => {
                *gain(&mut gains) = value;
                self.speed
            }
            None => value,
        };
        self.subject
            .dive_loop(drive, (gains, self.gains.memory()), speed)
    }

    /// The poles in `s`; of the sampled loop `ln(z) / T`.
    fn poles(&self, drive: &Drive, value: f64) -> Result<Vec<Complex<f64>>> {
        let dive_loop = self.dive_loop(drive, value)?;
        Ok(in_s(dive_loop.poles()?, drive))
    }

    /// Those that can be told apart from the actuator's motion within a tick.
    fn poles_text(&self, drive: &Drive, value: f64) -> Result<String> {
        let mut poles = self.poles(drive, value)?;
        if let Some(sampling) = &drive.sampling {
            poles.retain(|s| (s.re * sampling.tick).exp() >= FAST);
        }
        Ok(poles_text(&poles))
    }

    fn page(&self, drive: &Drive) -> Result<String> {
        let possible = self.vary.to_possible_value();
        let varied = possible.map_or_else(String::new, |it| it.get_name().to_owned());
        let (from, to) = (number(self.value(0.0)), number(self.value(1.0)));
        let title = format!(
            "Root locus of {}: {varied} from {from} to {to}",
            self.subject.title()
        );
        let mut fixed = law_text(&self.gains.gains(), &self.gains.memory());
        if self.vary != Varied::Speed {
            fixed += &format!(", U = {}", speed_text(self.speed));
        }
        let mut rows = Table::of([varied.as_str(), "poles [1/s]"]);
        for value in self.values() {
            rows.row([number(value), self.poles_text(drive, value)?]);
        }
        let body = html! {
            h1 { (title) }
            p.lead { "All others as in " (fixed) "." }
            div.columns { (figures(&[self.drawing(drive, &varied)?])) (rows.html()) }
        };
        Ok(document(&title, "td { text-align: left; }", &body, ""))
    }

    fn drawing<'a>(&self, drive: &Drive, varied: &'a str) -> Result<Plot<'a>> {
        // Those of the actuator are far to the left and would make the rest small, unless they become unstable.
        let first = self.poles(drive, self.value(0.0))?;
        let last = self.poles(drive, self.value(1.0))?;
        let slowest = first.iter().map(|s| s.norm()).fold(1.0, f64::min).max(1.0);
        let unstable = last.iter().filter(|s| s.re >= 0.0).map(|s| s.norm());
        let far = unstable
            .map(|norm| 1.2 * norm)
            .fold(4.0 * slowest, f64::max);
        let near = |poles: Vec<Complex<f64>>| -> Vec<(f64, f64)> {
            let near = poles.into_iter().filter(|s| s.norm() < far);
            near.map(|s| (s.re, s.im)).collect()
        };
        let at = |style, name: &'static str, shares: &mut dyn Iterator<Item = f64>| {
            let (mut points, mut values) = (Vec::new(), Vec::new());
            for share in shares {
                let value = self.value(share);
                points.extend(near(self.poles(drive, value)?));
                values.resize(points.len(), value);
            }
            anyhow::Ok(Series {
                at: Some((varied.into(), values)),
                ..Series::new(style, name, points)
            })
        };
        // Dense at the beginning: there the poles move most.
        let mut shares = (1..DOTS).map(|i| (f64::from(i) / f64::from(DOTS)).powi(2));
        let mut locus = vec![
            at(Style::Dots, "between", &mut shares)?,
            at(Style::Diamonds, "last value", &mut [1.0].into_iter())?,
        ];
        if self.vary == Varied::Speed || self.value(0.0) != 0.0 {
            locus.push(at(Style::Squares, "first value", &mut [0.0].into_iter())?);
        }
        let mut plot = Plot::new("Root locus", ["real part [1/s]", "imaginary part [rad/s]"])
            .from_zero()
            .one_scale();
        plot = match self.gain() {
            Some(gain) => {
                let dive_loop = self.dive_loop(drive, 0.0)?;
                let zeros = in_s(dive_loop.locus_zeros(gain)?, drive);
                plot.note(
                    "A cross is a pole with the gain at 0; a circle is a zero, where a pole ends as the gain grows without bound.",
                )
                .with(Style::Crosses, "open-loop poles", near(in_s(dive_loop.poles()?, drive)))
                .with(Style::Circles, "zeros", near(zeros))
            }
            None => plot,
        };
        let drawn = locus.iter().flat_map(|series| &series.points);
        let corner = drawn.fold((0.0_f64, 0.0_f64), |(left, top), (re, im)| {
            (left.max(-re), top.max(*im))
        });
        Ok(plot.with_all(locus).with_all(damping_grid(corner)))
    }
}

/// Poles or zeros in `s`, those of a sampled loop as `ln(z) / T`, without those at `z = 0`.
fn in_s(roots: Vec<Complex<f64>>, drive: &Drive) -> Vec<Complex<f64>> {
    match &drive.sampling {
        Some(sampling) => roots
            .into_iter()
            .filter_map(|z| discrete_to_continuous(z, sampling.tick))
            .collect(),
        None => roots,
    }
}

/// Lines of equal damping ratio and arcs of equal natural frequency in the left half plane, as far as `left` and `top`.
fn damping_grid((left, top): (f64, f64)) -> Vec<Series<'static>> {
    const RATIOS: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
    let left = left.max(0.1);
    let top = top.max(0.4 * left);
    let largest = left.hypot(top);
    let decade = 10f64.powf((largest / 4.0).log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|it| it * decade);
    let step = steps.into_iter().rfind(|it| *it <= largest / 4.0);
    let step = step.unwrap_or(decade);
    let frequencies = (1..10).map(|i| f64::from(i) * step);
    let frequencies: Vec<f64> = frequencies.filter(|w| *w < largest).collect();
    let mut lines = Vec::new();
    for side in [1.0, -1.0] {
        for ratio in RATIOS {
            let (re, im) = (-ratio, side * (1.0 - ratio * ratio).sqrt());
            let end = (left / ratio).min(top / im.abs());
            lines.push(vec![(0.0, 0.0), (end * re, end * im)]);
        }
        for frequency in &frequencies {
            let angles = (0..=90).map(|degree| f64::from(degree).to_radians());
            let points =
                angles.map(|angle| (-frequency * angle.sin(), side * frequency * angle.cos()));
            lines.push(
                points
                    .filter(|(re, im)| *re >= -left && im.abs() <= top)
                    .collect(),
            );
        }
    }
    let list = |values: &[f64]| {
        let values = values.iter().map(|it| number(*it));
        values.collect::<Vec<_>>().join(", ")
    };
    let name = format!(
        "damping ratio {}; natural frequency {} rad/s",
        list(&RATIOS),
        list(&frequencies)
    );
    // One entry in the legend.
    let names = std::iter::once(name).chain(std::iter::repeat(String::new()));
    let lines = lines.into_iter().zip(names);
    lines
        .map(|(points, name)| Series::new(Style::Grid, name, points))
        .collect()
}
