//! Many simulations of a scenario in this process, with different parameters and seeds.
//!
//! - [`space`]: the varied parameters and the resulting cases;
//! - [`case`]: the simulation of one case, and its numbers;
//! - `column`: data types of the result columns;
//! - [`outcomes`]: results of the cases by combination;
//! - [`results`]: the file with one row per case, which can be interrupted at any time.

pub mod case;
mod column;
pub mod outcomes;
#[cfg(feature = "parquet")]
mod parquet;
pub mod results;
pub mod space;

use std::num::NonZero;
use std::path::{Path, PathBuf};

use crate::error::{During, Result, refuse, refused};
use planesman_identifier::IdentifierParameters;
use planesman_parallel::{Progress, on_all_cores};
use planesman_text::{in_one_line, option};
use serde::{Deserialize, Serialize};

use crate::parts::Parts;
use crate::scenario::{Scenario, plain};
use crate::sink::write_text;
use case::Metrics;
use results::Results;
pub use results::file_of;
use space::Space;

pub use column::Kind;

/// Number of combinations checked at a time, so that memory does not grow with the sweep.
const CHECKED: u64 = 100_000;

/// Number of refused combinations that a message names.
const LISTED: usize = 3;

/// Definition of a folder's results, stored in the folder: a folder contains one sweep.
#[derive(PartialEq, Serialize, Deserialize)]
struct Definition {
    planesman: String,
    vary: Vec<String>,
    samples: Option<u32>,
    seeds: u32,
    /// Number of parts of the cases, if they are divided; a second division would repeat cases.
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<u64>,
    scenario: String,
}

fn check_these(
    scenario: &Scenario,
    space: &Space,
    combinations: &[u64],
    progress: &dyn Progress,
) -> Result<()> {
    let refusals = on_all_cores(combinations, |combination| {
        let outcome = space.scenario(scenario, *combination)?.check();
        progress.step();
        outcome
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
        format!("{}: {}", values.join(" "), in_one_line(reason).trim_end())
    });
    refuse!(
        "{} of {} combinations are refused; {}",
        refused.len(),
        combinations.len(),
        reasons.collect::<Vec<_>>().join("; ")
    )
}

/// Creates the folder and writes its definition.
fn define(folder: &Path, definition: &Definition) -> Result<()> {
    let text = serde_yaml_ng::to_string(definition).map_err(|it| refused!("{it}"))?;
    let path = folder.join("sweep.yaml");
    std::fs::create_dir_all(folder).during(|| format!("'{}'", folder.display()))?;
    match planesman_text::read(&path) {
        Ok(there) if there == text => Ok(()),
        Ok(there) => {
            let there: Option<Definition> = planesman_text::yaml::from_str(&there).ok();
            let parts = there.as_ref().and_then(|it| it.parts);
            let is_same = there.is_some_and(|it| {
                let parts = definition.parts;
                Definition { parts, ..it } == *definition
            });
            match (is_same, parts) {
                (false, _) => refuse!(
                    "'{}' contains the results of another sweep. Name a new folder with {}",
                    folder.display(),
                    option("out")
                ),
                (true, None) => refuse!(
                    "'{}' contains this sweep without parts, so parts would repeat its cases. Continue without parts, or name a new folder",
                    folder.display()
                ),
                (true, Some(parts)) => refuse!(
                    "'{}' contains this sweep in {parts} parts, so another number of parts would repeat its cases. Continue with {parts} parts, or name a new folder",
                    folder.display()
                ),
            }
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            // Whole or not there, also where several parts begin at once.
            write_text(&path, text)
        }
        Err(error) => Err(error).during(|| format!("'{}'", path.display())),
    }
}

/// Largest possible number of poles of a case's model.
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

/// A part of the combinations, number `part` of `of`, from 1 on; all seeds of a combination are in one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which.
    pub part: u64,
    /// Number of parts.
    pub of: u64,
}

impl Part {
    /// The whole.
    pub const ALL: Self = Self { part: 1, of: 1 };
}

/// Simulated cases of a part.
#[derive(Clone, Debug)]
pub struct CaseResult {
    /// File with one row per case.
    pub file: PathBuf,
    /// Its cases.
    pub all: u64,
    /// Number of cases that the file already had.
    pub there: u64,
}

/// A scenario and its cases.
#[derive(Debug)]
pub struct Sweep {
    scenario: Scenario,
    parts: Parts,
    space: Space,
    poles: usize,
    /// The varied parameters as given on the command line, for the sweep's definition.
    vary: Vec<String>,
    samples: Option<u32>,
}

/// A simulated case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number.
    pub number: u64,
    /// Values of the varied parameters, as text.
    pub values: Vec<String>,
    /// Its seed.
    pub seed: u32,
    /// The case's numbers; `None` for a missing number.
    pub numbers: Vec<Option<f64>>,
    /// Reason why the flight failed; empty otherwise.
    pub error: String,
}

impl Sweep {
    /// Creates the cases of these `--vary`, `--samples` and `--seeds`; [check](Sweep::check) their combinations next.
    ///
    /// # Errors
    /// If a parameter or value is refused.
    pub fn new(
        scenario: Scenario,
        vary: &[String],
        samples: Option<u32>,
        seeds: u32,
    ) -> Result<Self> {
        let space = Space::new(vary, samples.unwrap_or(0), seeds, scenario.seed)?;
        let parameters = || space.axes.iter().map(|axis| &axis.parameter);
        if let Some(parameter) = parameters().find(|it| scenario.is_changed(it)) {
            refuse!("{parameter} is both set and varied. Either set it or vary it");
        }
        Ok(Self {
            poles: poles(&scenario, &space)?,
            scenario,
            parts: Parts::default(),
            space,
            vary: vary.to_vec(),
            samples,
        })
    }

    /// Like [`Sweep::new`], simulated with these parts.
    #[must_use]
    pub fn with_parts(self, parts: Parts) -> Self {
        Self { parts, ..self }
    }

    /// Checks every combination as the nodes would at their start.
    ///
    /// # Errors
    /// If combinations are refused.
    pub fn check(&self, progress: &dyn Progress) -> Result<()> {
        let all = self.combinations();
        progress.begin("combinations checked", all, 0);
        let mut outcome = Ok(());
        for first in (0..all).step_by(CHECKED as usize) {
            let combinations: Vec<u64> = (first..all.min(first + CHECKED)).collect();
            outcome = check_these(&self.scenario, &self.space, &combinations, progress);
            if outcome.is_err() {
                break;
            }
        }
        progress.end();
        outcome
    }

    /// Number of combinations of values; each is simulated with every seed.
    #[must_use]
    pub fn combinations(&self) -> u64 {
        self.space.combinations()
    }

    /// Number of cases of a part.
    #[must_use]
    pub fn cases(&self, Part { part, of }: Part) -> u64 {
        (self.combinations() + of - part) / of * u64::from(self.space.seeds)
    }

    /// Creates the folder and writes its definition, with the number of parts if it is fixed.
    ///
    /// # Errors
    /// If the folder has the results of another sweep or cannot be written.
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

    /// Simulates the cases that the part's file in `folder` lacks, `jobs` at a time; [define](Sweep::define) the folder first. An
    /// interrupted sweep continues.
    ///
    /// # Errors
    /// If a file belongs to another sweep, another process writes it, or it cannot be written.
    pub fn fly(
        &self,
        folder: &Path,
        part: Option<Part>,
        jobs: NonZero<usize>,
        progress: &dyn Progress,
    ) -> Result<CaseResult> {
        let file = folder.join(match part {
            None => "cases.csv".to_owned(),
            Some(Part { part, of }) => file_of(part, of),
        });
        let part = part.unwrap_or(Part::ALL);
        let all = self.cases(part);
        let results = Results::open(&file, &self.header()?)?;
        let there = results.there;
        progress.begin("cases", all, there);
        let row = |number: u64| self.case(part, number)?.row();
        let filled = results.fill(all, jobs, row, || progress.step());
        progress.end();
        filled.during(|| {
            format!(
                "'{}'; to continue, run the same command again",
                file.display()
            )
        })?;
        #[cfg(feature = "parquet")]
        parquet::write(&file, &self.kinds())?;
        Ok(CaseResult { file, all, there })
    }

    /// The scenario without the varied parameters.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The varied parameters.
    #[must_use]
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// Names of the columns with their units, and their data types.
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
        String::from_utf8(row_of(&names)?).map_err(|it| refused!("{it}"))
    }

    /// Data types of the columns.
    #[cfg(feature = "parquet")]
    fn kinds(&self) -> Vec<Kind> {
        self.columns().into_iter().map(|(_, kind)| kind).collect()
    }

    /// Simulates a case of a part, by its index there. A failed flight has a reason instead of numbers.
    ///
    /// # Errors
    /// If a parameter's declaration refuses a value.
    pub fn case(&self, Part { part, of }: Part, place: u64) -> Result<Case> {
        // The seeds of a combination follow each other, in whichever part it is.
        let seeds = u64::from(self.space.seeds);
        let combination = place / seeds * of + part - 1;
        let seed = (place % seeds) as u32;
        let mut scenario = self.space.scenario(&self.scenario, combination)?;
        scenario.seed = self.scenario.seed.wrapping_add(seed);
        let (numbers, error) = match Metrics::fly(&self.parts, &scenario) {
            Ok(metrics) => (metrics.numbers(self.poles), String::new()),
            Err(error) => {
                let count = case::COLUMNS.len() + 2 * self.poles;
                (vec![None; count], in_one_line(&error))
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
    /// The case as a line of the file.
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
    writer.into_inner().map_err(|error| refused!("{error}"))
}
