//! The thesis's transfer functions as printed there (Brunner 1988, eq. 7 and Table 8), with the printed errors.

use anyhow::{Result, bail};
use planesman::tf_command::{TfArgs, text};
use planesman_console::print_wrapped;
use planesman_reports::brunner_1988::predicted::{
    D2_ANOMALY, DepthRate, PRINTED, SAMPLING_TIME, table_8,
};
use planesman_units::FOOT;
use planesman_vehicle::linearised::Output;
use planesman_vehicle::transfer::{Input, Models};
use planesman_vehicle::vehicle_file;

/// Prints the requested transfer function.
///
/// # Errors
/// A vehicle other than the thesis's, or an input and output that the thesis does not print.
pub(crate) fn run(args: &TfArgs) -> Result<()> {
    Ok(print_wrapped(text(&as_printed(args)?)?)?)
}

fn as_printed(args: &TfArgs) -> Result<Models> {
    if args.vehicle != vehicle_file::BRUNNER {
        bail!(
            "--as-printed: the thesis prints transfer functions only for its own vehicle, '{}', not for '{}'",
            vehicle_file::BRUNNER,
            args.vehicle
        );
    }
    let feet_per_second = args.speed / FOOT;
    let (name, continuous, sampled, gain) = match (args.input, args.output) {
        (Input::DivePlanes, Output::PitchRate) => (
            "pitch_rate over dive_planes, eq. (7a)",
            PRINTED.pitch_rate()?,
            table_8::pitch_rate_third_order()?,
            format!(
                "multiply by 0.54 U = {:.6} to get gyro volts per plane volt",
                table_8::pitch_rate_gain() * feet_per_second
            ),
        ),
        (Input::PitchRate, Output::Depth) => (
            "depth over pitch_rate, eq. (7b)",
            PRINTED.depth(DepthRate::AsPrinted { feet_per_second }, D2_ANOMALY)?,
            table_8::depth_as_printed(feet_per_second)?,
            format!(
                "multiply by 23.44 / U = {:.6} to get depth volts per gyro volt; the model uses z' = w + U theta, and its D2 is 1.5 times the value of its formula",
                table_8::depth_gain() / feet_per_second
            ),
        ),
        _ => bail!(
            "--as-printed: the thesis prints only pitch_rate over dive_planes and depth over pitch_rate"
        ),
    };
    let mut remarks = vec![gain];
    if (args.rate * SAMPLING_TIME - 1.0).abs() > 1e-9 {
        remarks.push(format!(
            "the thesis samples only at 20 Hz, but this command at {} Hz",
            args.rate
        ));
    }
    Ok(Models {
        heading: format!("brunner as printed: {name}, U = {feet_per_second:.4} ft/s"),
        continuous,
        frequency: "U/L",
        sampled: sampled.without_rounding(),
        sampling: format!("T = {SAMPLING_TIME} L/U, which the thesis treats as seconds"),
        remarks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        tf: TfArgs,
    }

    fn printed(arguments: &str) -> Result<String> {
        let arguments = ["tf", "brunner"].into_iter().chain(arguments.split(' '));
        text(&as_printed(&Cli::try_parse_from(arguments)?.tf)?)
    }

    #[test]
    fn the_printed_third_order_model_is_printed_again() {
        let shown = printed("--speed 1.2ft/s").expect("text");
        for digits in [
            "-0.1191", "0.2313", "-0.1122", "-2.807", "2.62567", "-0.81808",
        ] {
            assert!(shown.contains(digits), "{digits} is not in\n{shown}");
        }
    }

    #[test]
    fn what_the_thesis_does_not_print_is_refused() {
        let refusal = printed("--output heave").expect_err("refused").to_string();
        assert!(
            refusal.contains("the thesis prints only pitch_rate"),
            "{refusal}"
        );
    }
}
