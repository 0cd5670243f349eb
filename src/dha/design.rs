//! `planesman dha design`: designs of a circuit of on/off valves, compared over a load cycle.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use planesman_circuit::coding::Coding;
use planesman_circuit::{Circuit, Law, LoadCycle, MOST_VALVES, Point};
use planesman_console::progress::{end_with_reader, on_all_cores};
use planesman_console::{Format, Outcome, called};
use planesman_flight::sink::write_text;
use planesman_flight::{Loop, Scenario};
use planesman_hydraulics::{ActuatorFile, actuator_file};
use planesman_parameters::Choice;
use planesman_show::design::circuits::{self, designs, evaluate, ledger_table};
use planesman_signals::{CsvSource, Request, Role, Source as _, TableTime};
use planesman_text::did_you_mean;
use planesman_units::{Dimension, Quantity};

use crate::arguments::page_file;

/// Maximum number of designs.
const MOST: usize = 10_000;

/// Arguments of `dha design`.
#[derive(Clone, Debug, clap::Args)]
pub struct DesignArgs {
    /// A circuit of on/off valves: a built-in one (dfcu) or a file
    pub file: String,
    /// Load cycle: a table with time, position (m, or a unit as in 'position (mm)') and optionally force (N) against positive motion; or a
    /// scenario, whose plane command is the reference
    #[arg(long, value_name = "CSV|SCENARIO")]
    pub load_cycle: String,
    /// Valve codings to compare: pcm, pnm, fibonacci
    #[arg(long, value_name = "NAMES", default_value = "pcm,pnm,fibonacci")]
    pub codings: List<Named<Coding>>,
    /// Numbers of valves per edge: a list or FROM..TO
    #[arg(long, value_name = "NUMBERS", default_value = "3..6")]
    pub valves: List<Count>,
    /// Control laws to compare: nearest, model, pwm
    #[arg(long, value_name = "NAMES", default_value = "nearest,model,pwm")]
    pub controllers: List<Named<Law>>,
    /// Number of random draws of the valves' scatter for each design
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub seeds: u32,
    /// Print all designs, not only the Pareto-optimal ones (no other design is better in every criterion)
    #[arg(long)]
    pub all: bool,
    /// Also print the circuit, the pressures, and where the energy of the best compromise goes
    #[arg(long)]
    pub verbose: bool,
    /// Format of the table [default: table on a terminal, md elsewhere]
    #[arg(long, value_parser = crate::arguments::format())]
    pub format: Option<Format>,
    /// Also write an HTML page with plots
    #[arg(long, value_name = "FILE", value_parser = page_file)]
    pub html: Option<PathBuf>,
}

/// A comma-separated list on the command line.
#[derive(Clone, Debug)]
pub struct List<T>(Vec<T>);

impl<T: Items> FromStr for List<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let items: Result<Vec<Vec<T>>, String> =
            text.split(',').map(|item| T::items(item.trim())).collect();
        Ok(Self(items?.into_iter().flatten().collect()))
    }
}

/// The content between two commas of a list.
pub trait Items: Sized {
    /// Parses one item, or a range of several.
    ///
    /// # Errors
    /// A sentence that says what is expected.
    fn items(text: &str) -> Result<Vec<Self>, String>;
}

/// A value chosen by its name.
#[derive(Clone, Copy, Debug)]
pub struct Named<T>(T);

impl<T: Choice> Items for Named<T> {
    fn items(text: &str) -> Result<Vec<Self>, String> {
        match T::named(text) {
            Some(choice) => Ok(vec![Self(choice)]),
            None => Err(format!(
                "unknown name '{text}'; known: {}{}",
                T::NAMES.join(", "),
                did_you_mean(text, T::NAMES.iter().copied())
            )),
        }
    }
}

/// A number of valves per edge.
#[derive(Clone, Copy, Debug)]
pub struct Count(usize);

impl Items for Count {
    fn items(text: &str) -> Result<Vec<Self>, String> {
        let count = |text: &str| {
            text.parse()
                .ok()
                .filter(|count| (1..=MOST_VALVES).contains(count))
        };
        let range = match text.split_once("..") {
            Some((from, to)) => count(from).zip(count(to)),
            None => count(text).map(|count| (count, count)),
        };
        match range {
            Some((from, to)) if from <= to => Ok((from..=to).map(Count).collect()),
            _ => Err(format!(
                "'{text}': a number from 1 to {MOST_VALVES} is expected, or FROM..TO"
            )),
        }
    }
}

/// Evaluates the designs, prints them and writes the page.
///
/// # Errors
/// A refused circuit or load cycle.
pub fn run(args: &DesignArgs) -> Result<()> {
    let circuit = match actuator_file::read(&args.file)? {
        ActuatorFile::Circuit(circuit) => circuit,
        ActuatorFile::Metering(set) => bail!(
            "'{}' is an actuator with metered volumes ({}), not a circuit of on/off valves; use: planesman dha size {}",
            args.file,
            set.name,
            args.file
        ),
    };
    let cycle = load_cycle(&args.load_cycle, &circuit)?;
    cycle
        .fits(&circuit)
        .with_context(|| args.load_cycle.clone())?;
    let laws = once(args.controllers.0.iter().map(|it| it.0));
    let codings = once(args.codings.0.iter().map(|it| it.0));
    let counts = once(args.valves.0.iter().map(|it| it.0));
    let designs = designs(&circuit, &codings, &counts, &laws);
    if designs.len() > MOST {
        bail!(
            "{} designs exceed the limit of {MOST}. Choose fewer codings, valves or controllers",
            designs.len()
        );
    }
    if args.html.is_none() {
        end_with_reader();
    }
    let begun = Instant::now();
    let figures = on_all_cores("designs", &designs, |design| {
        evaluate(design, &cycle, args.seeds.into())
    });
    let seconds = begun.elapsed().as_secs_f64();
    planesman_console::err!("{} designs in {seconds:.1} s", designs.len());
    let outcome = circuits::Outcome::new(designs.into_iter().zip(figures).collect(), &cycle);
    let format = args.format.unwrap_or(Format::Table);
    if let Some(file) = &args.html {
        write_text(file, outcome.page(&args.load_cycle, &cycle))?;
    }
    let table = outcome.table(args.all).text(format);
    if !matches!(format, Format::Table | Format::Md) {
        planesman_console::print(table)?;
        return Ok(());
    }
    let mut printed = Outcome::new(outcome.winner());
    printed = printed.numbers(table);
    if args.verbose {
        let (design, it) = &outcome.designs[outcome.middle()];
        let ledger = ledger_table(&design.circuit, &it.mean.ledger).text(format);
        printed = printed
            .numbers(format!("\n{}", outcome.head(&args.load_cycle, &cycle)))
            .numbers(format!(
                "\nWhere the energy of '{}' goes:\n\n{ledger}",
                design.name()
            ));
    }
    Ok(match &args.html {
        Some(file) => printed.file("Page", file),
        None => printed.next(
            format!("{} --html designs.html", called()),
            "all designs as plots, the best one over time",
        ),
    }
    .print()?)
}

/// Removes duplicates; each item stays at its first place.
fn once<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut all = Vec::new();
    for item in items {
        if !all.contains(&item) {
            all.push(item);
        }
    }
    all
}

/// The load cycle in a table, or the plane command of a scenario simulated with ideal planes.
fn load_cycle(name: &str, circuit: &Circuit) -> Result<LoadCycle> {
    let path = Path::new(name);
    if match path.extension() {
        Some(extension) => extension != "yaml" && extension != "yml",
        None => path.is_file(),
    } {
        return of_table(path);
    }
    let scenario = Scenario::load_with(name, &["dha_actuator.actuator=ideal".to_owned()])?;
    scenario.check()?;
    let mut points = Vec::new();
    for tick in Loop::new(&scenario)? {
        let tick = tick?;
        points.push(Point {
            time: tick.stamp.nanos() as f64 * 1e-9,
            position: tick.command.dive_planes * circuit.load.moment_arm,
            force: 0.0,
        });
    }
    LoadCycle::new(points).with_context(|| name.to_owned())
}

fn of_table(path: &Path) -> Result<LoadCycle> {
    let table = CsvSource::open(path, &TableTime::default())?;
    let heads = table.signals();
    let position = column(path, &heads, "position", Dimension::Length)?;
    let force = column(path, &heads, "force", Dimension::Force)?;
    let used = [&position, &force].map(|it| it.as_ref().map(|it| it.0.as_str()));
    if let Some(unused) = heads.iter().find(|head| !used.contains(&Some(**head))) {
        bail!(
            "{}: unknown column '{unused}'; known: time, position, force, each with or without a unit as in 'force [kN]'",
            path.display()
        );
    }
    let Some((position, in_metres)) = position else {
        bail!("{}: the column 'position' is missing", path.display());
    };
    let in_newtons = force.as_ref().map_or(1.0, |it| it.1);
    let requests: Vec<Request> = [
        Some((position, Role::Output)),
        force.map(|it| (it.0, Role::Input)),
    ]
    .into_iter()
    .flatten()
    .map(|(name, role)| Request { name, role })
    .collect();
    let mut points: Vec<Point> = Vec::new();
    let mut take = |signal: usize, stamp: i64, value: Option<f64>| {
        // An empty cell is refused with its row.
        let value = value.unwrap_or(f64::NAN);
        match (signal, points.last_mut()) {
            (0, _) => points.push(Point {
                time: stamp as f64 * 1e-9,
                position: value * in_metres,
                force: 0.0,
            }),
            (_, Some(point)) => point.force = value * in_newtons,
            (_, None) => {}
        }
        true
    };
    let reading = table.read(&requests, &mut take, &|_| ())?;
    for note in reading.notes.iter().chain(&reading.clock) {
        planesman_console::err!("{note}");
    }
    LoadCycle::new(points).with_context(|| path.display().to_string())
}

/// The header of the column `name`, with or without a unit after it (`force [kN]`, `force_kN`), and the factor from its unit to SI.
fn column(
    path: &Path,
    heads: &[&str],
    name: &str,
    dimension: Dimension,
) -> Result<Option<(String, f64)>> {
    let behind = |head: &'_ str| {
        let (start, rest) = head.split_at_checked(name.len())?;
        let unit = rest.trim_matches(|sign: char| "[]()_".contains(sign) || sign.is_whitespace());
        let apart = rest
            .chars()
            .next()
            .is_none_or(|next| !next.is_alphanumeric());
        (start.eq_ignore_ascii_case(name) && apart).then(|| unit.to_owned())
    };
    let mut found = heads.iter().filter_map(|head| Some((*head, behind(head)?)));
    let Some((head, unit)) = found.next() else {
        return Ok(None);
    };
    if let Some((other, _)) = found.next() {
        bail!(
            "{}: columns '{head}' and '{other}' both contain the {name}",
            path.display()
        );
    }
    let factor = match unit.as_str() {
        "" => 1.0,
        unit => {
            let one: Quantity = format!("1 {unit}").parse().unwrap_or_default();
            one.si(dimension)
                .with_context(|| format!("{}: column '{head}'", path.display()))?
        }
    };
    Ok(Some((head.to_owned(), factor)))
}
