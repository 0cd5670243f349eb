//! `planesman tf`: the transfer functions of a vehicle about level flight.
//!
//! For any vehicle and speed, from [`planesman_vehicle::linearised`], in SI units; or for the thesis' vehicle
//! as Brunner 1988 prints them (eq. 7 and Table 8), from [`brunner_1988::predicted`], with its errors.

use std::fmt::{self, Display, Write as _};

use anyhow::{Context as _, Result, anyhow, bail};
use brunner_1988::predicted::{D2_ANOMALY, DepthRate, PRINTED, SAMPLING_TIME, table_8};
use clap::{Args, ValueEnum};
use planesman_linear::{Complex, Domain, TransferFunction};
use planesman_units::FOOT;
use planesman_vehicle::LevelFlight;
use planesman_vehicle::linearised::{self, Output};
use planesman_vehicle::vehicle_file;

use crate::arguments::{speed, within};
use planesman_console::number;
use planesman_console::print_wrapped;

/// The vehicle, the pair of signals and the sampling.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct TfArgs {
    /// A built-in vehicle (brunner, brunner_as_printed, remus_100), a vehicle file, or a model file
    vehicle: String,
    /// Base vehicle of an identified model: gives all but the pitch dynamics
    #[arg(long, default_value = vehicle_file::BRUNNER)]
    base: String,
    /// Input of the transfer function
    #[arg(long, value_enum, default_value_t = InputName::DivePlanes)]
    input: InputName,
    /// Output of the transfer function
    #[arg(long, value_enum, default_value_t = OutputName::PitchRate)]
    output: OutputName,
    /// Speed through the water (m/s, or with its unit: 1ft/s)
    #[arg(long, value_parser = speed(0.001, 100.0), default_value_t = FOOT)]
    speed: f64,
    /// Sampling rate of the zero-order hold (Hz)
    #[arg(long, value_parser = within(0.01, 10_000.0), default_value_t = 20.0)]
    rate: f64,
    /// As the thesis prints them (eq. 7, Table 8), for its own vehicle: nondimensional, sampled every
    /// 0.05 L/U
    #[arg(long)]
    as_printed: bool,
}

/// Inputs, as the command line names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum InputName {
    /// The dive planes' angle (rad), positive to dive
    DivePlanes,
    /// The pitch rate (rad/s), for output depth only; without the direct effect of the planes
    PitchRate,
}

/// Outputs, as the command line names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum OutputName {
    /// q (rad/s), positive bow up
    PitchRate,
    /// theta (rad), positive bow up
    Pitch,
    /// z (m), positive down
    Depth,
    /// w (m/s), positive towards the keel
    Heave,
}

impl From<OutputName> for Output {
    fn from(name: OutputName) -> Self {
        match name {
            OutputName::PitchRate => Self::PitchRate,
            OutputName::Pitch => Self::Pitch,
            OutputName::Depth => Self::Depth,
            OutputName::Heave => Self::Heave,
        }
    }
}

/// A model before and after the zero-order hold, with its heading and remarks.
#[derive(Clone, Debug)]
pub struct Models {
    /// Vehicle, signals, unit and speed.
    pub heading: String,
    /// The model in s.
    pub continuous: TransferFunction,
    /// The unit of `s`.
    pub frequency: &'static str,
    /// The model in z.
    pub sampled: TransferFunction,
    /// The rate of the zero-order hold.
    pub sampling: String,
    /// The operating point, and what else is to be known.
    pub remarks: Vec<String>,
}

/// Prints the transfer function that was asked for.
///
/// # Errors
/// A vehicle that is refused, a pair of input and output that has no model, numbers that overflow.
pub fn run(args: &TfArgs) -> Result<()> {
    print_wrapped(text(&models(args)?)?)?;
    Ok(())
}

/// The transfer function that was asked for.
///
/// # Errors
/// As [`run`].
pub fn models(args: &TfArgs) -> Result<Models> {
    match args.as_printed {
        true => as_printed(args),
        false => corrected(args),
    }
}

fn corrected(args: &TfArgs) -> Result<Models> {
    let vehicle = vehicle_file::load_on(&args.vehicle, &args.base)?;
    let dt = 1.0 / args.rate;
    let derivatives = vehicle.derivatives(args.speed);
    let context = || format!("vehicle '{}' at {} m/s", vehicle.name, args.speed);
    let of = |output| -> Result<TransferFunction> {
        let g = linearised::response(&derivatives, output)
            .and_then(|s| s.transfer_function(0, 0))
            .with_context(context)?;
        Ok(tidy(g))
    };
    let output = Output::from(args.output);
    let (continuous, sampled, unit) = match (args.input, output) {
        (InputName::DivePlanes, _) => {
            let sampled = linearised::response(&derivatives, output)
                .and_then(|s| s.zero_order_hold(dt))
                .and_then(|s| s.transfer_function(0, 0))
                .with_context(context)?;
            (of(output)?, tidy(sampled), output.unit())
        }
        (InputName::PitchRate, Output::Depth) => {
            // z / q = (z / delta) / (q / delta): both have the same denominator but for an s.
            let mut den = of(Output::PitchRate)?.num;
            den.push(0.0);
            let g = TransferFunction::new(of(Output::Depth)?.num, trimmed(den))
                .map_err(|_| anyhow!("the planes have no effect on the pitch of this vehicle"))?;
            let g = monic(g);
            let sampled = trimmed_num(&g).zero_order_hold(dt).with_context(context)?;
            (g, tidy(sampled), "m s/rad")
        }
        (InputName::PitchRate, _) => bail!("pitch_rate is an input for the output depth only"),
    };
    Ok(Models {
        heading: format!(
            "{}: {} over {} [{unit}] at {} m/s",
            vehicle.name,
            output.name(),
            input_name(args.input),
            number(args.speed)
        ),
        continuous,
        frequency: "rad/s",
        sampled,
        sampling: format!("{} Hz, T = {} s", args.rate, dt),
        remarks: vec![operating_point(derivatives.level_flight())],
    })
}

/// The operating point of the linearised model.
fn operating_point(level: Option<LevelFlight>) -> String {
    match level {
        Some(level) if level == LevelFlight::default() => {
            "about level flight on an even keel with neutral planes".to_owned()
        }
        Some(level) => format!(
            "about level flight: pitch {:.2} degrees, planes {:.2} degrees",
            level.pitch.to_degrees(),
            level.planes.to_degrees()
        ),
        None => "about zero pitch: at this speed the vehicle has no trim".to_owned(),
    }
}

fn as_printed(args: &TfArgs) -> Result<Models> {
    if args.vehicle != vehicle_file::BRUNNER {
        bail!(
            "--as-printed: the thesis prints them for its own vehicle, '{}', not for '{}'",
            vehicle_file::BRUNNER,
            args.vehicle
        );
    }
    let feet_per_second = args.speed / FOOT;
    let (name, continuous, sampled, gain) = match (args.input, args.output) {
        (InputName::DivePlanes, OutputName::PitchRate) => (
            "pitch_rate over dive_planes, eq. (7a)",
            PRINTED.pitch_rate()?,
            table_8::pitch_rate_third_order()?,
            format!(
                "times 0.54 U = {:.6} it is gyro volts per plane volt",
                table_8::pitch_rate_gain() * feet_per_second
            ),
        ),
        (InputName::PitchRate, OutputName::Depth) => (
            "depth over pitch_rate, eq. (7b)",
            PRINTED.depth(DepthRate::AsPrinted { feet_per_second }, D2_ANOMALY)?,
            table_8::depth_as_printed(feet_per_second)?,
            format!(
                "times 23.44 / U = {:.6} it is depth volts per gyro volt; z' = w + U theta, and D2 is \
                 1.5 times its formula",
                table_8::depth_gain() / feet_per_second
            ),
        ),
        _ => bail!(
            "--as-printed: the thesis prints pitch_rate over dive_planes, and depth over pitch_rate"
        ),
    };
    let mut remarks = vec![gain];
    if (args.rate * SAMPLING_TIME - 1.0).abs() > 1e-9 {
        remarks.push(format!(
            "the thesis samples at 20 Hz alone, not at {}",
            args.rate
        ));
    }
    Ok(Models {
        heading: format!("brunner as printed: {name}, U = {feet_per_second:.4} ft/s"),
        continuous,
        frequency: "U/L",
        sampled: tidy(sampled),
        sampling: format!("T = {SAMPLING_TIME} L/U, which it takes for seconds"),
        remarks,
    })
}

fn input_name(input: InputName) -> &'static str {
    match input {
        InputName::DivePlanes => "dive_planes",
        InputName::PitchRate => "pitch_rate",
    }
}

/// Coefficients that are zero but for rounding, set to zero.
fn tidy(mut g: TransferFunction) -> TransferFunction {
    for polynomial in [&mut g.num, &mut g.den] {
        let largest = polynomial.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        for c in polynomial.iter_mut() {
            if c.abs() < 1e-14 * largest {
                *c = 0.0;
            }
        }
    }
    trimmed_num(&g)
}

fn trimmed(polynomial: Vec<f64>) -> Vec<f64> {
    polynomial.into_iter().skip_while(|c| *c == 0.0).collect()
}

fn trimmed_num(g: &TransferFunction) -> TransferFunction {
    let num = trimmed(g.num.clone());
    TransferFunction {
        num: if num.is_empty() { vec![0.0] } else { num },
        den: g.den.clone(),
    }
}

/// With 1 as the denominator's first coefficient.
fn monic(g: TransferFunction) -> TransferFunction {
    let lead = g.den[0];
    let divided = |c: Vec<f64>| c.into_iter().map(|c| c / lead).collect();
    TransferFunction {
        num: divided(g.num),
        den: divided(g.den),
    }
}

fn text(models: &Models) -> Result<String> {
    let mut text = String::new();
    writeln!(text, "{}", models.heading)?;
    writeln!(text, "\ncontinuous, s in {}", models.frequency)?;
    describe(&mut text, &models.continuous)?;
    // A hold leaves the steady gain as it is; rounding would show another beside a pole at 1.
    match models.continuous.dc_gain(Domain::Continuous) {
        Ok(gain) => writeln!(text, "  steady   {}", Number(gain))?,
        Err(_) => writeln!(text, "  steady   none, it integrates")?,
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

/// Coefficients from the highest power, then zeros, poles and the gain beside them.
fn describe(text: &mut String, g: &TransferFunction) -> Result<()> {
    let g = trimmed_num(&monic(g.clone()));
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

/// Ten significant digits, and no negative zero.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.0 + 0.0;
        let magnitude = value.abs();
        if value == 0.0 {
            write!(f, "0")
        } else if (1e-3..1e6).contains(&magnitude) {
            let digits = 9 - magnitude.log10().floor() as i32;
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

    fn args(input: InputName, output: OutputName, feet_per_second: f64) -> TfArgs {
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
    fn the_printed_third_order_model_is_printed_again() {
        let args = TfArgs {
            as_printed: true,
            ..args(InputName::DivePlanes, OutputName::PitchRate, 1.2)
        };
        let shown = text(&as_printed(&args).expect("a model")).expect("text");
        for digits in [
            "-0.1191", "0.2313", "-0.1122", "-2.807", "2.62567", "-0.81808",
        ] {
            assert!(shown.contains(digits), "{digits} is not in\n{shown}");
        }
    }

    #[test]
    fn a_held_plane_gives_no_steady_pitch_rate_and_depth_integrates() {
        let rate = corrected(&args(InputName::DivePlanes, OutputName::PitchRate, 1.8));
        let shown = text(&rate.expect("a model")).expect("text");
        assert!(shown.contains("zeros    0  -0.92"), "{shown}");
        assert!(shown.contains("steady   0\n"), "{shown}");
        let depth = corrected(&args(InputName::DivePlanes, OutputName::Depth, 1.8));
        let shown = text(&depth.expect("a model")).expect("text");
        assert!(shown.contains("steady   none"), "{shown}");
    }

    #[test]
    fn depth_over_pitch_rate_times_pitch_rate_is_depth() {
        let of = |input, output| {
            corrected(&args(input, output, 1.2))
                .expect("a model")
                .continuous
        };
        let rate = of(InputName::DivePlanes, OutputName::PitchRate);
        let depth = of(InputName::DivePlanes, OutputName::Depth);
        let ratio = of(InputName::PitchRate, OutputName::Depth);
        let point = Complex::new(0.1, 0.8);
        let off = rate.value_at(point) * ratio.value_at(point) - depth.value_at(point);
        assert!(off.norm() < 1e-12);
    }

    #[test]
    fn what_has_no_model_is_refused_in_a_line() {
        let refused = [
            corrected(&args(InputName::PitchRate, OutputName::Heave, 1.0)),
            as_printed(&args(InputName::DivePlanes, OutputName::Heave, 1.0)),
            corrected(&TfArgs {
                vehicle: "no/such/file".to_owned(),
                ..args(InputName::DivePlanes, OutputName::Depth, 1.0)
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
