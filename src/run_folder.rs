//! The folder of one flight: scenario, parameters, bag, logs, page.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::flight::Flight;
use crate::page::{self, Count};
use crate::scenario::Scenario;
use crate::summary::Summary;

/// The folder of one flight.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// The folder of a flight to come: `out`, or one under `runs/` with the scenario's name
    /// and the time. It is not made yet.
    ///
    /// # Errors
    /// When the path is taken.
    pub fn free(out: Option<&Path>, name: &str) -> Result<Self> {
        let path = out.map_or_else(
            || {
                let stem = Path::new(name)
                    .file_stem()
                    .and_then(|s| s.to_str())
                    .unwrap_or("dive");
                PathBuf::from("runs").join(format!("{stem}-{}", recorder::names::utc_now()))
            },
            Path::to_owned,
        );
        if path.exists() {
            bail!(
                "'{}' exists already; a flight never overwrites another, name a new folder",
                path.display()
            );
        }
        Ok(Self { path })
    }

    /// Makes the folder, with what is flown and the parameters the nodes are started with.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn create(&self, scenario: &Scenario, parameters: &str) -> Result<()> {
        fs::create_dir_all(self.path.join("log"))
            .and_then(|()| fs::write(self.scenario_file(), scenario.source()))
            .and_then(|()| fs::write(self.parameter_file(), parameters))
            .with_context(|| format!("cannot make the folder '{}'", self.path.display()))
    }

    /// Says in the folder that the flight failed, and why.
    pub fn note_failure(&self, error: &anyhow::Error) {
        // The error is on its way to the terminal; a full disk must not hide it.
        let _ = fs::write(self.path.join("failed.txt"), format!("{error:#}\n"));
    }

    /// A folder that a flight left.
    ///
    /// # Errors
    /// When it holds no scenario.
    pub fn open(path: &Path) -> Result<Self> {
        let run = Self {
            path: path.to_owned(),
        };
        if !run.scenario_file().is_file() {
            bail!(
                "'{}' is not a flight's folder: it holds no scenario.yaml",
                path.display()
            );
        }
        Ok(run)
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The bag's folder.
    #[must_use]
    pub fn bag(&self) -> PathBuf {
        self.path.join("bag")
    }

    /// The page.
    #[must_use]
    pub fn page(&self) -> PathBuf {
        self.path.join("report.html")
    }

    /// The ROS 2 parameter file the nodes were started with.
    #[must_use]
    pub fn parameter_file(&self) -> PathBuf {
        self.path.join("parameters.yaml")
    }

    /// What a node wrote to its standard error.
    #[must_use]
    pub fn log(&self, node: &str) -> PathBuf {
        self.path.join("log").join(format!("{node}.log"))
    }

    /// What a node told when it stopped (JSON).
    #[must_use]
    pub fn exit_report(&self, node: &str) -> PathBuf {
        self.path.join("log").join(format!("{node}.json"))
    }

    fn scenario_file(&self) -> PathBuf {
        self.path.join("scenario.yaml")
    }

    /// Reads the bag, writes the page, and returns the flight's summary with the counts.
    ///
    /// # Errors
    /// When the bag cannot be read or the page cannot be written.
    pub fn report(&self) -> Result<String> {
        let text = fs::read_to_string(self.scenario_file())?;
        let scenario = Scenario::parse(&text)?;
        let flight = Flight::read(&self.bag())?;
        let summary = Summary::of(&flight, &scenario)?;
        let counts = self.counts(&flight.counts);
        let html = page::page(&flight, &scenario, &text, &summary, &counts);
        let draft = self.path.join(".report.html.part");
        fs::write(&draft, html)
            .and_then(|()| fs::rename(&draft, self.page()))
            .with_context(|| format!("cannot write '{}'", self.page().display()))?;
        let mut out = format!("{summary}\n\n");
        out += &count_table(&counts);
        if let Some(reason) = &flight.truncated {
            out += &format!("\nThe bag is not whole: {reason}\n");
        }
        out += &format!(
            "\nBag:   {}\nPage:  {}",
            self.bag().display(),
            self.page().display()
        );
        Ok(out)
    }

    /// Messages per topic: in the bag, and as the publishers counted them when they stopped.
    pub(crate) fn counts(&self, recorded: &BTreeMap<String, u64>) -> BTreeMap<String, Count> {
        let mut counts: BTreeMap<String, Count> = recorded
            .iter()
            .map(|(topic, n)| {
                (
                    topic.clone(),
                    Count {
                        recorded: *n,
                        published: None,
                    },
                )
            })
            .collect();
        for node in crate::scenario::NODES {
            let Some(published) = published(&self.exit_report(node)) else {
                continue;
            };
            for (topic, n) in published {
                if is_counted(&topic) {
                    let count = counts.entry(topic).or_default();
                    count.published = Some(count.published.unwrap_or(0) + n);
                }
            }
        }
        counts
    }
}

/// Whether loss on a topic means anything: the others are spoken before the recorder listens.
fn is_counted(topic: &str) -> bool {
    !["/diagnostics", "/rosout", "/parameter_events"].contains(&topic)
}

/// The counts in a node's exit report, `None` when there is no such report.
fn published(path: &Path) -> Option<BTreeMap<String, u64>> {
    let text = fs::read_to_string(path).ok()?;
    let report: planesman_node::ExitReport = serde_json::from_str(&text).ok()?;
    Some(report.published)
}

fn count_table(counts: &BTreeMap<String, Count>) -> String {
    let width = counts.keys().map(String::len).max().unwrap_or(0).max(5);
    let mut out = format!("{:width$}  published  in the bag  lost\n", "Topic");
    let mut lost = 0;
    for (topic, count) in counts {
        let (published, missing) = match count.published {
            Some(n) => (n.to_string(), n.saturating_sub(count.recorded).to_string()),
            None => ("-".to_owned(), "-".to_owned()),
        };
        lost += count
            .published
            .map_or(0, |n| n.saturating_sub(count.recorded));
        out += &format!(
            "{topic:width$}  {published:>9}  {:>10}  {missing:>4}\n",
            count.recorded
        );
    }
    out + &format!("{:width$}  {:>9}  {:>10}  {lost:>4}\n", "all", "", "")
}
