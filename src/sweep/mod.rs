//! `planesman sweep`: a scenario flown many times in this process, with other parameters and seeds each time.
//!
//! - `space`: what is varied, and the cases that follow;
//! - `case`: the flight of one case, and its numbers;
//! - `column`: what a column of the results holds;
//! - `results`: the file with a row a case, which can be interrupted at any time;
//! - `page`: heat map and Pareto plot of what is there.

mod case;
mod column;
mod page;
#[cfg(feature = "parquet")]
mod parquet;
mod results;
mod space;

use std::num::NonZero;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail};
use clap::Args;
use planesman_identifier::IdentifierParameters;
use planesman_text::in_one_line;
use serde::{Deserialize, Serialize};

use crate::scenario::{Scenario, plain};
use crate::sink::write_text;
use crate::summary::test_signal;
use case::Metrics;
use planesman_console::progress::{bar_with, on_all_cores};
use results::{Results, file_of};
use space::Space;

pub use column::Kind;

/// Combinations that are checked at a time: what is kept of them does not grow with the sweep.
const CHECKED: u64 = 100_000;

/// Refused combinations that are named.
const LISTED: usize = 3;

/// What to vary.
#[derive(Args)]
pub struct SweepArgs {
    /// A built-in scenario (dive, open_loop, way_depths, remus_100) or a scenario file
    scenario: String,
    /// Set a parameter of a node in all cases, as depth_controller.depth.p=1.2; may be repeated
    #[arg(long = "set", value_name = "NODE.PARAMETER=VALUE")]
    set: Vec<String>,
    /// Vary a parameter: over a list (1ft/s,2ft/s or ideal,dha), a range with its step (0.4:1.6:0.1), or a range to draw
    /// samples from (0.4..1.6); may be repeated, then every combination is flown
    #[arg(long, value_name = "NODE.PARAMETER=VALUES", required = true)]
    vary: Vec<String>,
    /// Fly each combination with so many seeds, from the scenario's seed on
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: u32,
    /// Draw so many samples, a Latin hypercube over all parameters that are varied as FROM..TO
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: Option<u32>,
    /// Folder for the results; the same command again goes on where it was interrupted [default: runs/sweep-SCENARIO]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Fly only part I of N of the combinations, as 1/4: for N machines, or tasks of a batch system, that share a folder
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// Flights at the same time [default: as many as there are cores]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,
}

/// `I/N`, of a part and how many there are.
fn shard(text: &str) -> Result<(u64, u64), String> {
    let parts = text.split_once('/').and_then(|(part, of)| {
        let (part, of) = (part.parse().ok()?, of.parse().ok()?);
        (1..=of).contains(&part).then_some((part, of))
    });
    parts.ok_or_else(|| "I/N is expected, I from 1 to N".to_owned())
}

/// What a folder's results are of, kept beside them: a folder holds one sweep.
#[derive(PartialEq, Serialize, Deserialize)]
struct Definition {
    planesman: String,
    vary: Vec<String>,
    samples: Option<u32>,
    seeds: u32,
    /// How many parts the cases are in, if they are; in no two ways, where cases would be twice.
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<u64>,
    scenario: String,
}

/// Flies the cases that the folder lacks, and writes the page.
///
/// # Errors
/// What is refused of the command line, before the first case; a folder that holds another sweep or cannot be written.
pub fn run(args: &SweepArgs) -> Result<()> {
    let sweep = Sweep::new(
        Scenario::load_with(&args.scenario, &args.set)?,
        &args.vary,
        args.samples,
        args.seeds,
    )?;
    sweep.check()?;
    let folder = args.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&args.scenario).file_stem().unwrap_or_default();
        Path::new("runs").join(format!("sweep-{}", stem.display()))
    });
    let parts = args.shard.map(|(_, parts)| parts);
    sweep.define(&folder, parts)?;

    let part = args.shard.map_or(Part::ALL, |(part, of)| Part { part, of });
    let file = folder.join(match args.shard {
        None => "cases.csv".to_owned(),
        Some((part, parts)) => file_of(part, parts),
    });
    let all = sweep.cases(part);
    let results = Results::open(&file, &sweep.header()?)?;
    let there = results.there;
    if there > 0 {
        planesman_console::out!("{there} of {all} cases are in {} already", file.display())?;
    }
    let jobs = args
        .jobs
        .unwrap_or_else(|| std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN));
    let bar = bar_with("cases", all, there);
    let row = |number: u64| sweep.case(part, number)?.row();
    let filled = results.fill(all, jobs, row, || bar.inc(1));
    bar.finish_and_clear();
    filled.with_context(|| format!("'{}'; the same command again goes on", file.display()))?;

    #[cfg(feature = "parquet")]
    parquet::write(&file, &sweep.kinds())?;
    if let Some(signal) = test_signal(&sweep.scenario)? {
        planesman_console::out!(
            "flown with a test signal, {signal}, which disturbs every response; without it: --set \
             depth_controller.identification.signal=none"
        )?;
    }
    let page = page::of(&folder, parts, &sweep.scenario, &sweep.space)?;
    planesman_console::out!("{}: {} cases", file.display(), all)?;
    if page.failed > 0 {
        planesman_console::out!(
            "{} cases broke off; the column 'error' says why",
            page.failed
        )?;
    }
    planesman_console::out!("{}", page.path.display())?;
    Ok(())
}

/// Every combination as the nodes would check it at their start.
fn check(scenario: &Scenario, space: &Space) -> Result<()> {
    let all = space.combinations();
    for first in (0..all).step_by(CHECKED as usize) {
        let combinations: Vec<u64> = (first..all.min(first + CHECKED)).collect();
        check_these(scenario, space, &combinations)?;
    }
    Ok(())
}

fn check_these(scenario: &Scenario, space: &Space, combinations: &[u64]) -> Result<()> {
    let refusals = on_all_cores("combinations checked", combinations, |combination| {
        space.scenario(scenario, *combination)?.check()
    });
    let refused = combinations.iter().zip(refusals);
    let refused: Vec<_> = refused
        .filter_map(|(it, outcome)| Some((it, outcome.err()?)))
        .collect();
    if refused.is_empty() {
        return Ok(());
    }
    let reasons = refused.iter().take(LISTED).map(|(combination, reason)| {
        let values = space.values(**combination);
        let values: Vec<String> = values
            .map(|(axis, value)| format!("{}={value}", axis.parameter))
            .collect();
        format!(
            "{}: {}",
            values.join(" "),
            in_one_line(reason.as_ref()).trim_end()
        )
    });
    bail!(
        "{} of {} combinations are refused; {}",
        refused.len(),
        combinations.len(),
        reasons.collect::<Vec<_>>().join("; ")
    )
}

/// Makes the folder, with what its results are of.
fn define(folder: &Path, definition: &Definition) -> Result<()> {
    let text = serde_yaml_ng::to_string(definition)?;
    let path = folder.join("sweep.yaml");
    std::fs::create_dir_all(folder).with_context(|| format!("'{}'", folder.display()))?;
    match std::fs::read_to_string(&path) {
        Ok(there) if there == text => Ok(()),
        Ok(there) => {
            let there: Option<Definition> = serde_yaml_ng::from_str(&there).ok();
            let parts = there.as_ref().and_then(|it| it.parts);
            let is_same = there.is_some_and(|it| {
                let parts = definition.parts;
                Definition { parts, ..it } == *definition
            });
            match (is_same, parts) {
                (false, _) => bail!(
                    "'{}' holds another sweep; name a new folder with --out",
                    folder.display()
                ),
                (true, None) => bail!(
                    "'{}' holds this sweep whole, and cases would be there twice; go on without parts, or name a new folder",
                    folder.display()
                ),
                (true, Some(parts)) => bail!(
                    "'{}' holds this sweep in {parts} parts, and cases would be there twice; go on with {parts} parts, or name a new folder",
                    folder.display()
                ),
            }
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            // Whole or not there, also where several parts begin at once.
            write_text(&path, text)
        }
        Err(error) => Err(error).with_context(|| format!("'{}'", path.display())),
    }
}

/// The most poles that a case's model can have.
fn poles(scenario: &Scenario, space: &Space) -> Result<usize> {
    let own = scenario
        .parameters_of::<IdentifierParameters>("sysid")?
        .order;
    let orders = space
        .axes
        .iter()
        .filter(|axis| axis.parameter.node == "sysid" && axis.parameter.name == "order");
    let most = orders
        .filter_map(space::Axis::numbers)
        .flatten()
        .fold(own as f64, f64::max);
    Ok(most as usize)
}

/// A part of the combinations, `part` of `of`, from 1 on; all seeds of a combination are in one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which.
    pub part: u64,
    /// How many there are.
    pub of: u64,
}

impl Part {
    /// The whole.
    pub const ALL: Self = Self { part: 1, of: 1 };
}

/// A scenario and its cases.
#[derive(Debug)]
pub struct Sweep {
    scenario: Scenario,
    space: Space,
    poles: usize,
    /// As given, for the definition.
    vary: Vec<String>,
    samples: Option<u32>,
}

/// A case that was flown.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number.
    pub number: u64,
    /// The values of what is varied, as text.
    pub values: Vec<String>,
    /// Its seed.
    pub seed: u32,
    /// The numbers that are kept of it; `None` where there is none.
    pub numbers: Vec<Option<f64>>,
    /// Why the flight broke off; empty otherwise.
    pub error: String,
}

impl Sweep {
    /// The cases of these `--vary`, `--samples` and `--seeds`; their combinations are still to be [checked](Sweep::check).
    ///
    /// # Errors
    /// A parameter or a value that is refused.
    pub fn new(
        scenario: Scenario,
        vary: &[String],
        samples: Option<u32>,
        seeds: u32,
    ) -> Result<Self> {
        let space = Space::new(vary, samples.unwrap_or(0), seeds, scenario.seed)?;
        let parameters = || space.axes.iter().map(|axis| &axis.parameter);
        if let Some(parameter) = parameters().find(|it| scenario.is_changed(it)) {
            bail!("{parameter} is set and varied: one of the two");
        }
        Ok(Self {
            poles: poles(&scenario, &space)?,
            scenario,
            space,
            vary: vary.to_vec(),
            samples,
        })
    }

    /// Checks every combination as the nodes would at their start.
    ///
    /// # Errors
    /// Combinations that are refused.
    pub fn check(&self) -> Result<()> {
        check(&self.scenario, &self.space)
    }

    /// Combinations of values; each is flown with every seed.
    #[must_use]
    pub fn combinations(&self) -> u64 {
        self.space.combinations()
    }

    /// Cases of a part.
    #[must_use]
    pub fn cases(&self, Part { part, of }: Part) -> u64 {
        (self.combinations() + of - part) / of * u64::from(self.space.seeds)
    }

    /// Makes the folder, with what its results are of; in so many parts, where that is fixed.
    ///
    /// # Errors
    /// A folder that holds another sweep or cannot be written.
    pub fn define(&self, folder: &Path, parts: Option<u64>) -> Result<()> {
        let definition = Definition {
            planesman: env!("CARGO_PKG_VERSION").to_owned(),
            vary: self.vary.clone(),
            samples: self.samples,
            seeds: self.space.seeds,
            parts,
            scenario: self.scenario.to_yaml(),
        };
        define(folder, &definition)
    }

    /// The names of the columns, with their units, and what they hold.
    #[must_use]
    pub fn columns(&self) -> Vec<(String, Kind)> {
        let number = |name: String| (name, Kind::Number);
        let mut columns = vec![("case".to_owned(), Kind::Whole)];
        columns.extend(self.space.axes.iter().map(|axis| match axis.numbers() {
            Some(_) => (axis.name(), Kind::Number),
            None => (axis.name(), Kind::Text),
        }));
        columns.push(("seed".to_owned(), Kind::Whole));
        columns.extend(case::COLUMNS.iter().map(|it| number((*it).to_owned())));
        for pole in 1..=self.poles {
            columns.extend(["re", "im"].map(|part| number(format!("pole_{pole}_{part} [1/s]"))));
        }
        columns.push(("error".to_owned(), Kind::Text));
        columns
    }

    fn header(&self) -> Result<String> {
        let names: Vec<String> = self.columns().into_iter().map(|(name, _)| name).collect();
        Ok(String::from_utf8(row_of(&names)?)?)
    }

    /// What the columns hold.
    #[cfg(feature = "parquet")]
    fn kinds(&self) -> Vec<Kind> {
        self.columns().into_iter().map(|(_, kind)| kind).collect()
    }

    /// Flies a case of a part, by its place there. A flight that breaks off has a reason in place of numbers.
    ///
    /// # Errors
    /// A value that its parameter's declaration refuses.
    pub fn case(&self, Part { part, of }: Part, place: u64) -> Result<Case> {
        // The seeds of a combination follow each other, in whichever part it is.
        let seeds = u64::from(self.space.seeds);
        let combination = place / seeds * of + part - 1;
        let seed = (place % seeds) as u32;
        let mut scenario = self.space.scenario(&self.scenario, combination)?;
        scenario.seed = self.scenario.seed.wrapping_add(seed);
        let (numbers, error) = match Metrics::of(&scenario) {
            Ok(metrics) => (metrics.numbers(self.poles), String::new()),
            Err(error) => {
                let count = case::COLUMNS.len() + 2 * self.poles;
                (vec![None; count], in_one_line(error.as_ref()))
            }
        };
        let values = self.space.values(combination);
        Ok(Case {
            number: combination * seeds + u64::from(seed),
            values: values.map(|(_, value)| plain(value)).collect(),
            seed: scenario.seed,
            numbers,
            error,
        })
    }
}

impl Case {
    /// As a line of the file.
    fn row(&self) -> Result<Vec<u8>> {
        let mut cells = vec![self.number.to_string()];
        cells.extend_from_slice(&self.values);
        cells.push(self.seed.to_string());
        let number = |it: &Option<f64>| it.map_or_else(String::new, |it| it.to_string());
        cells.extend(self.numbers.iter().map(number));
        cells.push(self.error.clone());
        row_of(&cells)
    }
}

/// Cells as one line.
fn row_of(cells: &[String]) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // A row is a line: that is how an interrupted file is read again.
    writer.write_record(cells.iter().map(|it| it.replace(['\n', '\r'], " ")))?;
    writer.into_inner().map_err(|error| anyhow!("{error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENARIO: &str = "
description: short
duration: 4.0
parameters:
  depth_controller: {depth_setpoint: 0.1}
";

    fn args(folder: &Path, out: &str) -> SweepArgs {
        let scenario = folder.join("short.yaml");
        std::fs::write(&scenario, SCENARIO).expect("written");
        SweepArgs {
            scenario: scenario.display().to_string(),
            set: Vec::new(),
            vary: vec![
                "depth_controller.depth.p=0.5:1.5:0.5".to_owned(),
                "plant_sim.speed=1ft/s,2ft/s".to_owned(),
            ],
            seeds: 2,
            samples: None,
            out: Some(folder.join(out)),
            shard: None,
            jobs: NonZero::new(3),
        }
    }

    fn text(folder: &Path, name: &str) -> String {
        std::fs::read_to_string(folder.join(name)).expect("read")
    }

    #[test]
    fn a_sweep_has_a_row_a_case_whether_whole_interrupted_or_in_parts() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let whole = args(folder, "whole");
        run(&whole).expect("swept");
        let rows = text(folder, "whole/cases.csv");
        assert_eq!(rows.lines().count(), 1 + 3 * 2 * 2);
        assert!(rows.starts_with(
            "case,depth_controller.depth.p [rad/m],plant_sim.speed [m/s],seed,depth_setpoint [m],"
        ));
        assert!(
            rows.lines()
                .nth(6)
                .expect("a row")
                .starts_with("5,1,0.3048,2,0.1,")
        );
        assert!(text(folder, "whole/report.html").contains(r#"<figure class="plot">"#));

        let file = folder.join("whole/cases.csv");
        std::fs::write(&file, &rows[..rows.len() / 2]).expect("cut");
        run(&whole).expect("gone on");
        assert_eq!(text(folder, "whole/cases.csv"), rows);

        let mut parts = Vec::new();
        for part in 1..=4 {
            let part_of = SweepArgs {
                shard: Some((part, 4)),
                ..args(folder, "parts")
            };
            run(&part_of).expect("swept");
            let text = text(folder, &format!("parts/cases-{part}-of-4.csv"));
            parts.extend(text.lines().skip(1).map(str::to_owned));
        }
        parts.sort_by_key(|row| row.split(',').next().and_then(|it| it.parse::<u64>().ok()));
        assert_eq!(parts, rows.lines().skip(1).collect::<Vec<_>>());
        assert!(text(folder, "parts/report.html").contains("12 of 12 cases"));
    }

    #[test]
    fn a_folder_holds_each_case_once_however_a_sweep_is_divided() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let shard = |out: &str, shard| {
            run(&SweepArgs {
                shard,
                ..args(folder, out)
            })
        };
        shard("parts", Some((1, 2))).expect("swept");
        for (other, part) in [(Some((2, 3)), "in 2 parts"), (None, "in 2 parts")] {
            let refusal = format!("{:#}", shard("parts", other).expect_err("refused"));
            assert!(refusal.contains(part), "{refusal}");
        }
        shard("whole", None).expect("swept");
        let refusal = format!("{:#}", shard("whole", Some((1, 1))).expect_err("refused"));
        assert!(refusal.contains("whole"), "{refusal}");
        // What somebody has copied there.
        for (from, to) in [
            ("parts/cases-1-of-2.csv", "parts/cases-1-of-2 (copy).csv"),
            ("parts/cases-1-of-2.csv", "parts/cases-01-of-2.csv"),
            ("whole/cases.csv", "parts/cases.csv"),
            ("whole/cases.csv", "parts/cases-2-of-3.csv"),
            ("parts/cases-1-of-2.csv", "whole/cases-1-of-2.csv"),
        ] {
            std::fs::copy(folder.join(from), folder.join(to)).expect("copied");
        }
        shard("parts", Some((1, 2))).expect("done already");
        assert!(text(folder, "parts/report.html").contains(">6 of 12 cases"));
        shard("parts", Some((2, 2))).expect("swept");
        assert!(text(folder, "parts/report.html").contains(">12 of 12 cases"));
        shard("whole", None).expect("done already");
        assert!(text(folder, "whole/report.html").contains(">12 of 12 cases"));
    }

    #[test]
    fn what_is_refused_is_refused_before_the_first_case() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        // Each is a value of its range; the actuator has no small volume.
        let combination = SweepArgs {
            vary: vec!["dha_actuator.logic.mode=single_speed,two_speed".to_owned()],
            ..args(folder, "refused")
        };
        let refusal = format!("{:#}", run(&combination).expect_err("refused"));
        assert!(refusal.contains("1 of 2 combinations"), "{refusal}");
        assert!(
            refusal.contains(r#"dha_actuator.logic.mode="two_speed""#),
            "{refusal}"
        );
        assert!(!folder.join("refused").exists());

        run(&args(folder, "one")).expect("swept");
        let other = SweepArgs {
            seeds: 3,
            ..args(folder, "one")
        };
        let refusal = format!("{:#}", run(&other).expect_err("refused"));
        assert!(refusal.contains("another sweep"), "{refusal}");
    }

    #[test]
    fn a_flight_that_breaks_off_has_a_reason_in_place_of_numbers() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let wild = SweepArgs {
            vary: vec!["plant_sim.environment.seaway.moment=0,10000".to_owned()],
            seeds: 1,
            ..args(folder, "wild")
        };
        run(&wild).expect("swept");
        let rows = text(folder, "wild/cases.csv");
        assert_eq!(rows.lines().count(), 3);
        assert!(rows.lines().nth(1).expect("a row").ends_with(','));
        let broken_off = rows.lines().nth(2).expect("a row");
        assert!(broken_off.contains("plant_sim: "), "{broken_off}");
        assert!(text(folder, "wild/report.html").contains("1 broke off"));
    }
}
