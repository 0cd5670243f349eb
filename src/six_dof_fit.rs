//! `planesman six-dof fit`: fits a vehicle with six degrees of freedom to a recording; prints text or JSON.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use planesman_console::{Outcome, out};
use planesman_fit::{DataOptions, FitOptions, Validation, rules};
use planesman_identification::analysis::Standing;
use planesman_linear::digits::{significant, value_and_interval, with_interval};
use planesman_six_dof_fit::{
    Axes, Cost, Delay, Errors, Estimated, SIGNALS, SixDofOptions, SixDofResult, fit_six_dof,
};

use crate::arguments::{choice, output_file, within};
use crate::sysid::arguments::{DataArgs, span};

/// Options of `fit`.
#[derive(Clone, Debug, clap::Args)]
pub struct FitArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Vehicle to start from, built-in or a file; --prior is relative to its numbers
    #[arg(long, value_name = "VEHICLE")]
    like: String,
    /// Signal of an input or of the motion (north, east, depth, roll, pitch, yaw, or qw, qx, qy, qz, and u, v, w, p, q, r), if its name or an
    /// odometry message does not give it, with a factor and an offset: X=pwm_1*0.1-150; may be repeated
    #[arg(long = "signal", value_name = "NAME=SIGNAL")]
    signals: Vec<String>,
    /// For the record of a real vehicle: same as --prior 300 --bias none --cost velocities --horizon 4 --delay automatic where these are not given,
    /// and as --free all --fixed thrust without --free
    #[arg(long)]
    real: bool,
    /// Inputs of the vehicle that the recording lacks: assumed to be 0
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    zero: Vec<String>,
    /// Numbers or groups to keep: Y_uv, linear_damping_26, added_mass, linear_damping, quadratic_damping, coefficients, fins, thrust, thrust_centre
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    fixed: Vec<String>,
    /// Numbers or groups to fit, all others are kept; all: every number [default: those that are not 0, without the group body: buoyancy,
    /// centre_of_gravity]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    free: Vec<String>,
    /// Prior standard deviation of each number, % of its value; choose it large if the vehicle hardly resembles this one
    ///
    /// [default: 50]
    #[arg(long, value_name = "PERCENT", value_parser = within(0.1, 1e4))]
    prior: Option<f64>,
    /// A number counts as determined if half of its 95 % interval is at most this percentage of its value
    #[arg(long, value_name = "PERCENT", default_value_t = 50.0, value_parser = within(0.1, 1e4))]
    bound: f64,
    /// Signals with a constant error (bias) to estimate, or none [default: u,v,w,p,q,r]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    bias: Vec<String>,
    /// The delays of the inputs to estimate [default: none]
    #[arg(long, value_name = "WHICH", value_parser = choice(&Delay::ALL, Delay::described))]
    delay: Option<Delay>,
    /// The signals whose errors are minimised [default: all]
    #[arg(long, value_name = "SIGNALS", value_parser = choice(&Cost::ALL, Cost::described))]
    cost: Option<Cost>,
    /// Axes of the motion in a table, not of the inputs: down (x forward, y starboard, z down; north, east, depth) or up (x forward, y port, z up; as in REP 103)
    #[arg(long, value_name = "AXES", default_value = "down", value_parser = ["down", "up"])]
    axes: String,
    /// Angles and angular rates of a table are in degrees
    #[arg(long)]
    degrees: bool,
    /// A signal that is 0 where samples are not to be used
    #[arg(long, value_name = "SIGNAL")]
    mask: Option<String>,
    /// Judge the vehicle on this recording instead of the last three tenths of the data
    #[arg(long, value_name = "FILE")]
    validate: Option<PathBuf>,
    /// Longest simulation from one initial state (s) [default: 30]
    #[arg(long, value_name = "SECONDS", value_parser = within(1.0, 1e5))]
    horizon: Option<f64>,
    /// Judge predictions from measured states over this time (s); half and twice as long ones are printed too
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = within(0.1, 1e5))]
    predict: f64,
    /// Use only data between these times, in seconds from the first sample of the motion; may be repeated
    #[arg(long, value_name = "FROM..TO", value_parser = span(rules::WINDOW))]
    window: Vec<(f64, f64)>,
    /// Write a page with measured and predicted motion, errors beside simpler models, and the numbers
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    html: Option<PathBuf>,
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

/// Jumps that are listed.
const SHOWN: usize = 6;

impl FitArgs {
    fn options(&self, data: FitOptions) -> SixDofOptions {
        let usual = match self.real {
            true => SixDofOptions::of_a_real_vehicle(),
            false => SixDofOptions::default(),
        };
        let given = |names: &Vec<String>, usual: Vec<String>| match &names[..] {
            [] => usual,
            [none] if none == "none" => Vec::new(),
            names => names.to_vec(),
        };
        SixDofOptions {
            data,
            signals: self.signals.clone(),
            like: self.like.clone(),
            zero: self.zero.clone(),
            fixed: match self.free.is_empty() {
                true => [&usual.fixed[..], &self.fixed].concat(),
                false => self.fixed.clone(),
            },
            free: given(&self.free, usual.free),
            prior: self.prior.map_or(usual.prior, |it| it / 100.0),
            bound: self.bound / 100.0,
            bias: given(&self.bias, usual.bias),
            horizon: self.horizon.unwrap_or(usual.horizon),
            predict: self.predict,
            cost: self.cost.unwrap_or(usual.cost),
            delay: self.delay.unwrap_or(usual.delay),
            axes: Axes {
                left_up: self.axes == "up",
                degrees: self.degrees,
            },
            mask: self.mask.clone(),
        }
    }
}

/// Fits the vehicle, prints the result, and writes the vehicle file.
///
/// # Errors
/// A refused vehicle, name or recording, or a file that cannot be written.
pub fn run(args: &FitArgs) -> Result<()> {
    let mut data = FitOptions::default();
    data.signals.data = DataOptions::from(&args.data);
    data.signals.grid.window.clone_from(&args.window);
    data.validation = args.validate.clone().map(Validation::Data);
    let options = args.options(data);
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
    if let Some(path) = &args.html {
        let page = planesman_show::pages::six_dof::page(&found, &recording);
        planesman_text::write_text(path, page).with_context(|| format!("{}", path.display()))?;
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
    if share > 10.0 {
        return "> 1000 %".to_owned();
    }
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

/// What the recording says of itself.
fn print_record(found: &SixDofResult) -> Result<()> {
    for contradiction in &found.contradictions {
        out!("- {contradiction}")?;
    }
    for input in &found.reversed_inputs {
        out!("- {input}")?;
    }
    let is_said = |name: &str| found.contradictions.iter().any(|it| it.signal == name);
    let agreements = found.agreements.iter();
    for it in agreements.filter(|it| !it.is_close() && !is_said(it.signal)) {
        out!("- {it}")?;
    }
    for it in found.resets.iter().take(SHOWN) {
        out!(
            "- {} jumps by {} {} at {:.1} s of run {}: left out",
            it.signal,
            significant(it.jump, 2),
            unit(it.signal),
            it.time,
            it.run + 1
        )?;
    }
    if let more @ 1.. = found.resets.len().saturating_sub(SHOWN) {
        out!("- {more} more jumps: left out")?;
    }
    for it in &found.saturated {
        out!("- {it}")?;
    }
    Ok(())
}

/// Errors on held-out data: of signals with fitted initial states, and of predictions from measured states.
fn print_held_out(args: &FitArgs, found: &SixDofResult) -> Result<()> {
    let Some(held) = &found.held_out else {
        return Ok(out!(
            "\nheld-out data: not judged, because too little data is left to fit or the motion diverges there"
        )?);
    };
    let data = match &args.validate {
        Some(path) => format!("{} ({:.1} s)", path.display(), held.seconds),
        None => format!(
            "the last 30 % ({:.1} s), by a fit of the first 70 %",
            held.seconds
        ),
    };
    out!("\nheld-out data: {data}")?;
    if !found.predictions.is_empty() {
        out!(
            "errors of predictions from measured states, a start each second (rms; deg and deg/s):"
        )?;
        out!(
            "  horizon  model                       velocity        rate    position    attitude"
        )?;
    }
    for of in &found.predictions {
        for (predictor, errors) in &of.errors {
            let name = predictor.name();
            let Some(Errors {
                velocity,
                rate,
                position,
                attitude,
            }) = errors
            else {
                out!("  {:>5} s  {name:26}  diverges", of.horizon)?;
                continue;
            };
            let [velocity, rate, position, attitude] = [
                *velocity,
                rate.to_degrees(),
                *position,
                attitude.to_degrees(),
            ]
            .map(|it| significant(it, 3));
            out!(
                "  {:>5} s  {name:24}  {velocity:>6} m/s  {rate:>10}  {position:>8} m  {attitude:>10}",
                of.horizon
            )?;
        }
    }
    out!("errors of simulations with fitted initial states:")?;
    out!("  rms          fitted       --like")?;
    for (name, fitted, like) in &held.signals {
        let (fitted, like) = (significant(*fitted, 3), significant(*like, 3));
        out!("  {name:6}  {fitted:>11}  {like:>11}  {}", unit(name))?;
    }
    Ok(())
}

fn print(args: &FitArgs, found: &SixDofResult, recording: &str) -> Result<()> {
    out!("verdict: {}\n", found.verdict())?;
    print_record(found)?;
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
    if args.real {
        out!(
            "\nMasses, moments and damping are in proportion to the forces of the inputs: if the given forces are k times too large, so are all these numbers.\nA bollard pull test or a weighing determines k."
        )?;
    }
    out!("")?;
    list("current ", &found.current, |_| "m/s")?;
    list("delay   ", &found.delays, |_| "s")?;
    for it in (found.delays.iter()).filter(|it| it.value + it.interval < 0.0) {
        out!(
            "- the delay of {} is negative, so the motion comes before this input. Check clock and signs",
            it.name
        )?;
    }
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
    print_held_out(args, found)?;
    if found.undetermined.is_empty() {
        out!("\neach number is determined to within {} %", args.bound)?;
    } else {
        out!(
            "\nnot determined to within {} % (prior: {} %), each with the manoeuvre that would help most:",
            args.bound,
            significant(100.0 * planesman_identification::SIGMAS_95 * found.prior, 2)
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
    let mut written = Outcome::new("");
    if let Some(path) = &args.html {
        written = written.file("Page", path);
    }
    if let Some(path) = &args.out {
        written = written.file("Vehicle", path);
        let fly = format!("planesman six-dof fly {}", path.display());
        if found.verdict().standing() != Standing::NotUsable {
            written = written.next(fly, "fly it");
        }
    }
    if args.html.is_some() || args.out.is_some() {
        written.print()?;
    }
    Ok(())
}
