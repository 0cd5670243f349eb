//! `planesman six-dof fit`: fits a vehicle with six degrees of freedom to a recording; prints text or JSON.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use planesman_console::{Outcome, out};
use planesman_fit::{DataOptions, FitOptions, rules};
use planesman_identification::analysis::Standing;
use planesman_linear::digits::{significant, value_and_interval, with_interval};
use planesman_six_dof_fit::{Estimated, SIGNALS, SixDofOptions, SixDofResult, fit_six_dof};

use crate::arguments::{output_file, within};
use crate::sysid::arguments::{DataArgs, span};

/// Options of `fit`.
#[derive(Clone, Debug, clap::Args)]
pub struct FitArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Vehicle to start from, built-in or a file; --prior is relative to its numbers
    #[arg(long, value_name = "VEHICLE")]
    like: String,
    /// Signal of an input or of the motion (north, east, depth, roll, pitch, yaw, u, v, w, p, q, r), if its name or an odometry message does not
    /// give it; may be repeated
    #[arg(long = "signal", value_name = "NAME=SIGNAL")]
    signals: Vec<String>,
    /// Inputs of the vehicle that the recording lacks: assumed to be 0
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    zero: Vec<String>,
    /// Numbers or groups to keep: Y_uv, linear_damping_26, added_mass, linear_damping, quadratic_damping, coefficients, fins, thrust
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    fixed: Vec<String>,
    /// Numbers or groups to fit, all others are kept [default: all but buoyancy and centre_of_gravity (group body)]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    free: Vec<String>,
    /// Prior standard deviation of each number, % of its value; choose it large if the vehicle hardly resembles this one
    #[arg(long, value_name = "PERCENT", default_value_t = 50.0, value_parser = within(0.1, 1e4))]
    prior: f64,
    /// A number counts as determined if half of its 95 % interval is at most this percentage of its value
    #[arg(long, value_name = "PERCENT", default_value_t = 50.0, value_parser = within(0.1, 1e4))]
    bound: f64,
    /// Signals with a constant error (bias) to estimate, or none
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "u,v,w,p,q,r"
    )]
    bias: Vec<String>,
    /// Longest simulation from one initial state (s)
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0, value_parser = within(1.0, 1e5))]
    horizon: f64,
    /// Use only data between these times, in seconds from the first sample of the motion; may be repeated
    #[arg(long, value_name = "FROM..TO", value_parser = span(rules::WINDOW))]
    window: Vec<(f64, f64)>,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
    /// Also print the signals, correlated numbers, biases and noise
    #[arg(long)]
    verbose: bool,
    /// The vehicle file to write; must not exist
    #[arg(long, short, value_parser = output_file)]
    out: Option<PathBuf>,
}

/// Fits the vehicle, prints the result, and writes the vehicle file.
///
/// # Errors
/// A refused vehicle, name or recording, or a file that cannot be written.
pub fn run(args: &FitArgs) -> Result<()> {
    let mut data = FitOptions::default();
    data.signals.data = DataOptions::from(&args.data);
    data.signals.grid.window.clone_from(&args.window);
    let none = args.bias == ["none"];
    let options = SixDofOptions {
        data,
        signals: args.signals.clone(),
        like: args.like.clone(),
        zero: args.zero.clone(),
        fixed: args.fixed.clone(),
        free: args.free.clone(),
        prior: args.prior / 100.0,
        bound: args.bound / 100.0,
        bias: if none { Vec::new() } else { args.bias.clone() },
        horizon: args.horizon,
    };
    let found = fit_six_dof(&options, &*args.data.progress())?;
    let name = |path: &PathBuf| path.file_name().map(|it| it.to_string_lossy().into_owned());
    let recording = args.data.data.iter().filter_map(name);
    let recording = recording.collect::<Vec<_>>().join(", ");
    if let Some(path) = &args.out {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let name = name.replace(|c: char| !c.is_alphanumeric() && c != '-', "_");
        let text = found.text(&name, &recording);
        planesman_text::write_text(path, text).with_context(|| format!("{}", path.display()))?;
    }
    let verdict = found.verdict();
    if args.json {
        let mut all = serde_json::to_value(&found)?;
        all["verdict"] = serde_json::to_value(&verdict)?;
        all["verdict"]["standing"] = verdict.standing().name().into();
        out!("{}", serde_json::to_string_pretty(&all)?)?;
    } else {
        print(args, &found, &recording)?;
    }
    match verdict.standing() {
        Standing::NotUsable => bail!("the fitted vehicle is {verdict}"),
        _ => Ok(()),
    }
}

fn unit(name: &str) -> &'static str {
    SIGNALS.iter().find(|it| it.0 == name).map_or("", |it| it.1)
}

fn percent(share: f64) -> String {
    significant(100.0 * share, 2) + " %"
}

/// Prints the table of numbers; returns the width of the name column.
fn print_numbers(args: &FitArgs, found: &SixDofResult) -> Result<usize> {
    let wide = found.numbers.iter().map(|it| it.name.len());
    let wide = wide.fold(6, usize::max);
    let columns = "      fitted       95 % +-      of it        --like";
    out!("  {:wide$}  {columns}", "number")?;
    for it in &found.numbers {
        let (value, interval) = value_and_interval(it.value, it.interval);
        let is_determined = it.relative() <= args.bound / 100.0;
        let mark = if is_determined {
            ""
        } else {
            "  not determined"
        };
        out!(
            "  {:wide$}  {value:>12}  {interval:>12}  {:>9}  {:>12}{mark}",
            it.name,
            percent(it.relative()),
            significant(it.like, 6)
        )?;
    }
    Ok(wide)
}

fn print(args: &FitArgs, found: &SixDofResult, recording: &str) -> Result<()> {
    out!("verdict: {}\n", found.verdict())?;
    for contradiction in &found.contradictions {
        out!("- {contradiction}")?;
    }
    out!(
        "{} fitted to {recording}: {:.1} s in {} windows, {} samples\n",
        found.like,
        found.seconds,
        found.windows,
        found.samples
    )?;
    let wide = print_numbers(args, found)?;
    let list = |title: &str, of: &[Estimated], unit: fn(&str) -> &'static str| {
        let each = of.iter().map(|it| {
            let value = with_interval(it.value, it.interval);
            format!("{} {value} {}", it.name, unit(&it.name))
        });
        let each: Vec<String> = each.collect();
        match each.is_empty() {
            true => Ok(()),
            false => out!("{title} {}", each.join(", ")),
        }
    };
    out!("")?;
    list("current ", &found.current, |_| "m/s")?;
    if args.verbose {
        list("bias    ", &found.biases, unit)?;
        let noise = found.noise.iter();
        let noise =
            noise.map(|(name, it)| format!("{name} {} {}", significant(*it, 3), unit(name)));
        out!("noise    {}", noise.collect::<Vec<_>>().join(", "))?;
        for (one, other, correlation) in &found.correlated {
            out!("{one} and {other} are hard to separate: their correlation is {correlation:.3}")?;
        }
        for line in &found.data.description {
            out!("{line}")?;
        }
    } else if !found.correlated.is_empty() {
        let count = found.correlated.len();
        out!(
            "{count} pairs of numbers are hard to separate: correlation above 0.95 (--verbose lists them)"
        )?;
    }
    match &found.held_out {
        None => out!(
            "\nheld-out data: not evaluated, because too little data is left for the fit, or the motion diverges in the held-out data"
        )?,
        Some(held) => {
            out!(
                "\nheld-out data: the last 30 % ({:.1} s), simulated with a fit of the first 70 %; initial states, current and biases are fitted in both parts:",
                held.seconds
            )?;
            out!("  rms          fitted       --like")?;
            for (name, fitted, like) in &held.signals {
                let (fitted, like) = (significant(*fitted, 3), significant(*like, 3));
                out!("  {name:6}  {fitted:>11}  {like:>11}  {}", unit(name))?;
            }
        }
    }
    if found.undetermined.is_empty() {
        out!("\neach number is determined to within {} %", args.bound)?;
    } else {
        out!(
            "\nnot determined to within {} % (prior: {} %), each with the manoeuvre that would help most:",
            args.bound,
            significant(planesman_identification::SIGMAS_95 * args.prior, 2)
        )?;
        for it in &found.undetermined {
            let then = match &it.manoeuvre {
                Some(words) => format!("{} by {words}", percent(it.after)),
                None => {
                    "no manoeuvre of the library shortens the interval by 20 % or more".to_owned()
                }
            };
            out!("  {:wide$}  {} -> {then}", it.name, percent(it.before))?;
        }
    }
    if let Some(next) = &found.next {
        let [before, after] = &next.largest;
        let [up, down] = next.depths;
        out!(
            "\nbest next run, chosen from {} manoeuvres of 60 s: {}",
            next.compared,
            next.manoeuvre
        )?;
        out!(
            "  largest interval that a manoeuvre shortens: {} {} -> {} {}; depth {up:.1} to {down:.1} m relative to the start",
            before.0,
            percent(before.1),
            after.0,
            percent(after.1)
        )?;
    }
    if let Some(path) = &args.out {
        let written = Outcome::new("").file("Vehicle", path);
        let fly = format!("planesman six-dof fly {}", path.display());
        match found.verdict().standing() {
            Standing::NotUsable => written,
            _ => written.next(fly, "fly it"),
        }
        .print()?;
    }
    Ok(())
}
