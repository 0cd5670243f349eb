//! `planesman tf`: the transfer functions of a vehicle in level flight.
//!
//! For any vehicle and speed, from [`planesman_vehicle::transfer`], in SI units. `planesman-reports` prints the transfer functions of the thesis'
//! vehicle as in Brunner 1988 (eq. 7 and Table 8), including the errors printed there.

use std::fmt::{self, Display, Write as _};

use anyhow::Result;
use clap::Args;
use planesman_linear::{Complex, Domain, TransferFunction};
use planesman_units::FOOT;
use planesman_vehicle::linearised::Output;
use planesman_vehicle::transfer::{self, Input, Models, RATES, SPEEDS};
use planesman_vehicle::vehicle_file;

use crate::arguments::{choice, speed, within};
use planesman_console::print_wrapped;

/// Arguments of `tf`.
#[derive(Args)]
pub struct TfArgs {
    /// A built-in vehicle (brunner, brunner_as_printed, remus_100), a vehicle file, or a model file
    pub vehicle: String,
    /// Base vehicle of an identified model: supplies everything except the pitch dynamics
    #[arg(long, default_value = vehicle_file::BRUNNER)]
    base: String,
    /// Input of the transfer function
    #[arg(long, value_parser = choice(&Input::ALL, Input::described), default_value = "dive_planes")]
    pub input: Input,
    /// Output of the transfer function
    #[arg(long, value_parser = choice(&Output::ALL, Output::described), default_value = "pitch_rate")]
    pub output: Output,
    /// Speed through the water (m/s, or with its unit: 1ft/s)
    #[arg(long, value_parser = speed(*SPEEDS.start(), *SPEEDS.end()), default_value_t = FOOT)]
    pub speed: f64,
    /// Sampling rate of the zero-order hold (Hz)
    #[arg(long, value_parser = within(*RATES.start(), *RATES.end()), default_value_t = 20.0)]
    pub rate: f64,
    /// As printed in the thesis (eq. 7, Table 8), only for its own vehicle: nondimensional, sampled every 0.05 L/U
    #[arg(long)]
    pub as_printed: bool,
}

/// Prints the requested transfer function.
///
/// # Errors
/// A refused vehicle, an input and output without a model, numerical overflow.
pub fn run(args: &TfArgs) -> Result<()> {
    print_wrapped(text(&models(args)?)?)?;
    Ok(())
}

fn models(args: &TfArgs) -> Result<Models> {
    let vehicle = vehicle_file::load_on(&args.vehicle, &args.base)?;
    let signals = (args.input, args.output);
    Ok(transfer::models(&vehicle, signals, args.speed, args.rate)?)
}

/// Transfer functions as text.
///
/// # Errors
/// Roots of a polynomial that cannot be found.
pub fn text(models: &Models) -> Result<String> {
    let mut text = String::new();
    writeln!(text, "{}", models.heading)?;
    writeln!(text, "\ncontinuous, s in {}", models.frequency)?;
    describe(&mut text, &models.continuous)?;
    // A hold leaves the steady-state gain as it is; rounding would show another beside a pole at 1.
    match models.continuous.steady_state_gain(Domain::Continuous) {
        Ok(gain) => writeln!(text, "  steady   {}", Number(gain))?,
        Err(_) => writeln!(text, "  steady   none (the response integrates)")?,
    }
    writeln!(text, "\nzero-order hold, {}", models.sampling)?;
    describe(&mut text, &models.sampled)?;
    if !models.remarks.is_empty() {
        writeln!(text)?;
    }
    for remark in &models.remarks {
        writeln!(text, "{remark}")?;
    }
    Ok(text)
}

/// Coefficients from the highest power down, then zeros, poles and gain.
fn describe(text: &mut String, g: &TransferFunction) -> Result<()> {
    let g = g.monic();
    writeln!(text, "  num      {}", list(&g.num, |c| Number(*c)))?;
    writeln!(text, "  den      {}", list(&g.den, |c| Number(*c)))?;
    writeln!(text, "  zeros    {}", list(&g.zeros()?, |z| Root(*z)))?;
    writeln!(text, "  poles    {}", list(&g.poles()?, |p| Root(*p)))?;
    writeln!(text, "  gain     {}", Number(g.num[0]))?;
    Ok(())
}

fn list<T, D: Display>(items: &[T], show: impl Fn(&T) -> D) -> String {
    if items.is_empty() {
        return "none".to_owned();
    }
    let shown: Vec<String> = items.iter().map(|i| show(i).to_string()).collect();
    shown.join("  ")
}

/// A number printed with ten significant digits; negative zero prints as zero.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.0 + 0.0;
        let magnitude = value.abs();
        if value == 0.0 {
            write!(f, "0")
        } else if (1e-3..1e6).contains(&magnitude) {
            let digits = 9 - libm::log10(magnitude).floor() as i32;
            write!(f, "{value:.*}", digits.max(0) as usize)
        } else {
            write!(f, "{value:.9e}")
        }
    }
}

struct Root(Complex<f64>);

impl Display for Root {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Complex { re, im } = self.0;
        if im == 0.0 {
            write!(f, "{}", Number(re))
        } else {
            let sign = if im < 0.0 { '-' } else { '+' };
            write!(f, "{}{sign}{}j", Number(re), Number(im.abs()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::ComplexFunctions as _;

    fn args(input: Input, output: Output, feet_per_second: f64) -> TfArgs {
        TfArgs {
            vehicle: "brunner".to_owned(),
            base: "brunner".to_owned(),
            input,
            output,
            speed: feet_per_second * FOOT,
            rate: 20.0,
            as_printed: false,
        }
    }

    #[test]
    fn a_held_plane_gives_no_steady_pitch_rate_and_depth_integrates() {
        let rate = models(&args(Input::DivePlanes, Output::PitchRate, 1.8));
        let shown = text(&rate.expect("a model")).expect("text");
        assert!(shown.contains("zeros    0  -0.92"), "{shown}");
        assert!(shown.contains("steady   0\n"), "{shown}");
        let depth = models(&args(Input::DivePlanes, Output::Depth, 1.8));
        let shown = text(&depth.expect("a model")).expect("text");
        assert!(shown.contains("steady   none"), "{shown}");
    }

    #[test]
    fn depth_over_pitch_rate_times_pitch_rate_is_depth() {
        let of = |input, output| {
            models(&args(input, output, 1.2))
                .expect("a model")
                .continuous
        };
        let rate = of(Input::DivePlanes, Output::PitchRate);
        let depth = of(Input::DivePlanes, Output::Depth);
        let ratio = of(Input::PitchRate, Output::Depth);
        let point = Complex::new(0.1, 0.8);
        let off = rate.value_at(point) * ratio.value_at(point) - depth.value_at(point);
        assert!(off.modulus() < 1e-12);
    }

    #[test]
    fn what_has_no_model_is_refused_in_a_line() {
        let refused = [
            models(&args(Input::PitchRate, Output::Heave, 1.0)),
            models(&TfArgs {
                vehicle: "no/such/file".to_owned(),
                ..args(Input::DivePlanes, Output::Depth, 1.0)
            }),
        ];
        for refusal in refused {
            let line = format!("{:#}", refusal.expect_err("refused"));
            assert!(!line.contains('\n') && line.len() > 20, "{line}");
        }
    }

    #[test]
    fn numbers_have_ten_digits_whatever_their_size() {
        assert_eq!(Number(-0.0).to_string(), "0");
        assert_eq!(Number(-2.899_220_035_855).to_string(), "-2.899220036");
        assert_eq!(
            Number(0.000_445_870_768_658_9).to_string(),
            "4.458707687e-4"
        );
    }
}
