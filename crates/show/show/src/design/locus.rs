//! Root locus of the dive loop over one gain, or the speed.

use crate::pages::{document, figures};
use crate::plot::{Plot, Series, Style};
use maud::html;
use planesman_console::Table;
use planesman_control::design::dive_loop::DiveLoop;
use planesman_control::gains::LoopGains;
use planesman_linear::{Complex, ComplexFunctions as _, discrete_to_continuous};
use planesman_text::number;

use crate::design::analysis::FAST;
use crate::design::error::{Error, Result};
use crate::design::subject::{Drive, Law, Subject, law_text, poles_text, speed_text};

/// Number of points of the plot.
const DOTS: u32 = 600;

planesman_text::choices! {
    /// The quantity that varies: a gain, or the speed.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Varied {
        DepthP = "depth_p": "Kpz (rad/m)",
        DepthD = "depth_d": "Kdz (rad s/m)",
        PitchP = "pitch_p": "Kpy",
        PitchRate = "pitch_rate": "Kr (s)",
        Speed = "speed": "U (m/s)",
    }
}

/// The quantity that varies, and its range.
#[derive(Clone, Debug)]
pub struct Locus {
    /// Vehicle and actuator.
    pub subject: Subject,
    /// The control law; the gain that varies is ignored.
    pub law: Law,
    /// Speed through the water, m/s, unless it varies.
    pub speed: f64,
    /// The quantity that varies.
    pub vary: Varied,
    /// First value, in SI.
    pub from: f64,
    /// Last value, in SI.
    pub to: f64,
    /// Number of rows of the table, 2 or more.
    pub rows: u32,
}

impl Locus {
    /// The values of the table.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        let last = f64::from(self.rows - 1);
        (0..self.rows).map(move |i| self.value(f64::from(i) / last))
    }

    /// The value at a fraction of the range.
    fn value(&self, share: f64) -> f64 {
        let (from, to) = (self.from, self.to);
        let value = from + share * (to - from);
        // A vehicle at rest has no plane moments to speak of.
        if self.vary == Varied::Speed {
            value.max(1e-3)
        } else {
            value
        }
    }

    /// Access to the gain that varies; `None` for the speed.
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
        let (mut gains, memory) = self.law;
        let speed = match self.gain() {
            Some(gain) => {
                *gain(&mut gains) = value;
                self.speed
            }
            None => value,
        };
        self.subject.dive_loop(drive, (gains, memory), speed)
    }

    /// The poles in `s`; for the sampled loop `ln(z) / T`.
    fn poles(&self, drive: &Drive, value: f64) -> Result<Vec<Complex<f64>>> {
        let dive_loop = self.dive_loop(drive, value)?;
        Ok(in_s(dive_loop.poles()?, drive))
    }

    /// The poles at a value of the parameter, without the poles of the actuator's motion within a tick.
    ///
    /// # Errors
    /// A refused vehicle, numerical overflow.
    pub fn poles_text(&self, drive: &Drive, value: f64) -> Result<String> {
        let mut poles = self.poles(drive, value)?;
        if let Some(sampling) = &drive.sampling {
            poles.retain(|s| libm::exp(s.re * sampling.tick) >= FAST);
        }
        Ok(poles_text(&poles))
    }

    /// The HTML page: the table, and the locus as a plot, in which the cursor shows the parameter's value at each pole.
    ///
    /// # Errors
    /// Same as [`Locus::poles_text`].
    pub fn page(&self, drive: &Drive) -> Result<String> {
        let (varied, _) = self.vary.described();
        let (from, to) = (number(self.value(0.0)), number(self.value(1.0)));
        let title = format!(
            "Root locus of {}: {varied} from {from} to {to}",
            self.subject.title()
        );
        let mut fixed = law_text(&self.law.0, &self.law.1);
        if self.vary != Varied::Speed {
            fixed += &format!(", U = {}", speed_text(self.speed));
        }
        let mut rows = Table::of([varied, "poles [1/s]"]);
        for value in self.values() {
            rows.row([number(value), self.poles_text(drive, value)?]);
        }
        let body = html! {
            h1 { (title) }
            p.lead { "All other gains: " (fixed) "." }
            div.columns { (figures(&[self.drawing(drive, varied)?])) (rows.html()) }
        };
        Ok(document(&title, "td { text-align: left; }", &body, ""))
    }

    fn drawing(&self, drive: &Drive, varied: &'static str) -> Result<Plot<'static>> {
        // Those of the actuator are far to the left and would make the rest small, unless they become unstable.
        let first = self.poles(drive, self.value(0.0))?;
        let last = self.poles(drive, self.value(1.0))?;
        let slowest = first
            .iter()
            .map(|s| s.modulus())
            .fold(1.0, f64::min)
            .max(1.0);
        let unstable = last.iter().filter(|s| s.re >= 0.0).map(|s| s.modulus());
        let far = unstable
            .map(|norm| 1.2 * norm)
            .fold(4.0 * slowest, f64::max);
        let near = |poles: Vec<Complex<f64>>| -> Vec<(f64, f64)> {
            let near = poles.into_iter().filter(|s| s.modulus() < far);
            near.map(|s| (s.re, s.im)).collect()
        };
        let at = |style, name: &'static str, shares: &mut dyn Iterator<Item = f64>| {
            let (mut points, mut values) = (Vec::new(), Vec::new());
            for share in shares {
                let value = self.value(share);
                points.extend(near(self.poles(drive, value)?));
                values.resize(points.len(), value);
            }
            Ok::<_, Error>(Series {
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
                    "A cross is a pole with the gain at 0. A circle is a zero: a pole approaches it as the gain grows without bound.",
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

/// Poles or zeros in `s`; for a sampled loop `ln(z) / T`, without poles and zeros at `z = 0`.
fn in_s(roots: Vec<Complex<f64>>, drive: &Drive) -> Vec<Complex<f64>> {
    match &drive.sampling {
        Some(sampling) => roots
            .into_iter()
            .filter_map(|z| discrete_to_continuous(z, sampling.tick))
            .collect(),
        None => roots,
    }
}

/// Lines of equal damping ratio and arcs of equal natural frequency in the left half plane, up to `left` and `top`.
fn damping_grid((left, top): (f64, f64)) -> Vec<Series<'static>> {
    const RATIOS: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
    let left = left.max(0.1);
    let top = top.max(0.4 * left);
    let largest = libm::hypot(left, top);
    let decade = libm::pow(10f64, libm::log10(largest / 4.0).floor());
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
            let points = angles.map(|angle| {
                (
                    -frequency * libm::sin(angle),
                    side * frequency * libm::cos(angle),
                )
            });
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
