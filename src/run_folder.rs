//! The folder of one flight: scenario, parameters, bag, logs, page.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fmt, fs};

use anyhow::{Context, Result, bail};
use planesman_bag::reader::BagReader;
use planesman_console::{Format, Outcome};
use planesman_control::{ControllerParameters, Mode};
use planesman_msgs::loop_topics;
use planesman_recording::parameters::RecorderParameters;
use planesman_recording::selection::Selection;
use planesman_text::{in_one_line, shell_word};

use crate::arguments::{is_replaceable, make_way_for_folder};
use planesman_flight::flight::{Flight, recorded};
use planesman_flight::nodes::NODES;
use planesman_flight::scenario::Scenario;
use planesman_flight::sink::{full_name, write_text};
use planesman_flight::summary::Summary;
use planesman_show::pages::flights::{self, Count, FlightReport, published_and_lost};

/// File of the scenario; a flight's folder is recognised by it.
const SCENARIO: &str = "scenario.yaml";

/// The files in a flight's folder, the scenario first.
const OWN: [&str; 8] = [
    SCENARIO,
    "parameters.yaml",
    "report.html",
    "failed.txt",
    "log/*.log",
    "log/*.json",
    "bag/metadata.yaml",
    "bag/bag_*.mcap",
];

/// The folder of one flight.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// The folder of a future flight: `out`, or one under `runs/` with the scenario's name and the time. The folder is not created yet.
    ///
    /// # Errors
    /// The path exists already, or is not UTF-8, as the nodes' parameters need.
    pub fn free(out: Option<&Path>, name: &str) -> Result<Self> {
        let path = out.map_or_else(
            || {
                let stem = Path::new(name)
                    .file_stem()
                    .and_then(|s| s.to_str())
                    .unwrap_or("dive");
                PathBuf::from("runs")
                    .join(format!("{stem}-{}", planesman_recording::names::utc_now()))
            },
            Path::to_owned,
        );
        if path.exists() && !is_replaceable(&path, &OWN)? {
            bail!(
                "'{}' exists already. Name a new folder, or replace an earlier flight's folder with --overwrite",
                path.display()
            );
        }
        if path.to_str().is_none() {
            bail!(
                "the name '{}' is not UTF-8 text. Name another folder",
                path.display()
            );
        }
        Ok(Self { path })
    }

    /// Creates the folder, with the scenario and the parameters of the nodes.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn create(&self, scenario: &Scenario, parameters: &str) -> Result<()> {
        make_way_for_folder(&self.path, &OWN)
            .and_then(|()| fs::create_dir_all(self.path.join("log")))
            .and_then(|()| fs::write(self.scenario_file(), scenario.to_yaml()))
            .and_then(|()| fs::write(self.parameter_file(), parameters))
            .with_context(|| format!("cannot create the folder '{}'", self.path.display()))
    }

    /// Writes a file into the folder that states that the flight failed, and the reason.
    pub fn note_failure(&self, error: &anyhow::Error) {
        // The error is on its way to the terminal; a full disk must not hide it.
        let _ = fs::write(
            self.path.join("failed.txt"),
            in_one_line(error.as_ref()) + "\n",
        );
    }

    /// Opens the folder of an earlier flight.
    ///
    /// # Errors
    /// The folder contains no scenario.
    pub fn open(path: &Path) -> Result<Self> {
        let run = Self {
            path: path.to_owned(),
        };
        if !run.scenario_file().is_file() {
            bail!(
                "'{}' is not a flight's folder: it contains no scenario.yaml",
                path.display()
            );
        }
        Ok(run)
    }

    /// Path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of the bag's folder.
    #[must_use]
    pub fn bag(&self) -> PathBuf {
        self.path.join("bag")
    }

    /// Path of the HTML page.
    #[must_use]
    pub fn page(&self) -> PathBuf {
        self.path.join("report.html")
    }

    /// Path of the ROS 2 parameter file that the nodes were started with.
    #[must_use]
    pub fn parameter_file(&self) -> PathBuf {
        self.path.join("parameters.yaml")
    }

    /// Path of the file with a node's standard error.
    #[must_use]
    pub fn log(&self, node: &str) -> PathBuf {
        self.path.join("log").join(format!("{node}.log"))
    }

    /// Path of a node's exit report (JSON).
    #[must_use]
    pub fn exit_report(&self, node: &str) -> PathBuf {
        self.path.join("log").join(format!("{node}.json"))
    }

    /// Path of the scenario that was flown.
    #[must_use]
    pub fn scenario_file(&self) -> PathBuf {
        self.path.join(SCENARIO)
    }

    /// Reads the scenario of the flight.
    ///
    /// # Errors
    /// The scenario cannot be read.
    pub fn scenario(&self) -> Result<Scenario> {
        Ok(Scenario::parse(&fs::read_to_string(self.scenario_file())?)?)
    }

    /// The flight of `scenario`, read from its bag.
    ///
    /// # Errors
    /// When the bag cannot be read.
    pub fn flown(&self, scenario: Scenario) -> Result<FlightReport> {
        let flight = Flight::read(&self.bag())?;
        let summary = Summary::new(&flight, &scenario)?;
        let counts = self.counts(&flight.counts, &scenario)?;
        let mut reports = NODES.iter().map(|it| published(&self.exit_report(it)));
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        Ok(FlightReport {
            name: name.to_string_lossy().into_owned(),
            flight,
            scenario,
            summary,
            counts,
            is_counted: reports.all(|it| it.is_some()),
        })
    }

    /// Reads the bag of a flight of `scenario`, writes the page, and returns the text to print: the result, with `verbose` all numbers, the
    /// files, and the next commands. `name`: the scenario's name or file.
    ///
    /// # Errors
    /// When the bag cannot be read or the page cannot be written.
    pub fn report(&self, scenario: Scenario, name: &str, verbose: bool) -> Result<Outcome> {
        let flown = self.flown(scenario)?;
        let html = flights::page(std::slice::from_ref(&flown));
        write_text(&self.page(), html)?;
        let summary = &flown.summary;
        let mut answer = summary.conclusions();
        answer.extend(flights::kept(&flown));
        if let Some(reason) = &flown.flight.truncated {
            let reason = reason.trim_start_matches("incomplete: ");
            answer.insert(0, format!("The bag is incomplete: {reason}."));
        }
        let held = Some(summary.held_ticks).filter(|it| *it > 0);
        let held =
            held.map(|it| format!("{it} ticks were flown without an answer of the actuator"));
        let notes = summary.notes.iter().chain(&held);
        let notes = notes.map(|it| format!("Note: {it}\n"));
        let mut outcome = Outcome::new(answer.join(" ")).numbers(notes.collect::<String>());
        if verbose {
            let flown = std::slice::from_ref(&flown);
            outcome = outcome
                .numbers(flights::comparison(flown).text(Format::Table))
                .numbers(summary.model_lines())
                .numbers(count_table(&flown[0].counts));
        }
        outcome = outcome.file("Bag", &self.bag()).file("Page", &self.page());
        let dive = dive_command(name);
        outcome = outcome.next(format!("{dive} --watch"), "watch the flight on a page");
        if let (Some(_), Some(signal), false) =
            (&summary.identified, &summary.test_signal, summary.hovers)
        {
            let bag = shell_word(&self.bag().display().to_string());
            let fit = format!(
                "planesman sysid fit {bag} -i plane_motion:dive_planes -o state:pitch_rate --window {}..{}",
                signal.start, summary.duration
            );
            outcome = outcome.next(fit, "identify from its bag");
        }
        if summary.mode == Mode::Depth && summary.depth.is_some() {
            let controller: ControllerParameters =
                flown.scenario.parameters_of("depth_controller")?;
            let set = format!(
                "--set depth_controller.depth.p={:.2}",
                1.2 * controller.depth.p
            );
            outcome = outcome.next(format!("{dive} {set}"), "change a gain");
        }
        Ok(outcome)
    }

    /// The published messages of a flight of `scenario` that are missing in the bag; `None` if the bag is complete.
    ///
    /// # Errors
    /// When the bag cannot be read.
    pub fn loss(&self, scenario: &Scenario) -> Result<Option<Loss>> {
        let bag = BagReader::open(&self.bag())?;
        let counts = self.counts(&recorded(&bag), scenario)?;
        Ok(Loss::of(&counts))
    }

    /// Messages per topic: in the bag, and as counted by the publishers when they stopped. Messages that could not be sent count as
    /// published: they are lost as well.
    ///
    /// # Errors
    /// The scenario's parameters are refused.
    pub(crate) fn counts(
        &self,
        recorded: &BTreeMap<String, u64>,
        scenario: &Scenario,
    ) -> Result<BTreeMap<String, Count>> {
        let recorder: RecorderParameters = scenario.parameters_of("recorder")?;
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
        for node in NODES {
            let Some(published) = published(&self.exit_report(node)) else {
                continue;
            };
            for (topic, n) in published {
                if is_counted(&topic) && is_selected(&topic, &recorder) {
                    let count = counts.entry(topic).or_default();
                    count.published = Some(count.published.unwrap_or(0) + n);
                }
            }
        }
        Ok(counts)
    }
}

/// The command that flies a scenario, given its name or file.
#[must_use]
pub fn dive_command(scenario: &str) -> String {
    match scenario {
        "dive" => "planesman dive".to_owned(),
        name => format!("planesman dive {}", shell_word(name)),
    }
}

/// The published messages that are missing in the bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// By topic: number of missing messages, number of published messages.
    topics: BTreeMap<String, (u64, u64)>,
    /// Messages published on all topics.
    published: u64,
}

impl Loss {
    pub(crate) fn of(counts: &BTreeMap<String, Count>) -> Option<Self> {
        let lost = counts.iter().filter_map(|(topic, count)| {
            let missing = count.lost().filter(|it| *it > 0)?;
            Some((topic.clone(), (missing, count.published?)))
        });
        let topics: BTreeMap<String, (u64, u64)> = lost.collect();
        (!topics.is_empty()).then(|| Self {
            topics,
            published: published_and_lost(counts).0,
        })
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let missing: u64 = self.topics.values().map(|(missing, _)| missing).sum();
        write!(
            f,
            "the bag lacks {missing} of {} published messages: ",
            self.published
        )?;
        for (i, (topic, (missing, of))) in self.topics.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{topic} {missing} of {of}")?;
        }
        Ok(())
    }
}

/// Whether the recorder was to record a topic; without a selection it records all.
fn is_selected(topic: &str, recorder: &RecorderParameters) -> bool {
    let (namespace, last) = topic.rsplit_once('/').unwrap_or(("", topic));
    let is_it = |name: &str| name.trim_start_matches('/') == last;
    let types = loop_topics::ALL.iter().filter(|topic| is_it(topic.name));
    let type_name = types.map(|it| it.info.type_name).next().unwrap_or_default();
    let selection = Selection::new(&recorder.record, |name| full_name(namespace, name));
    (recorder.topics.is_empty() || recorder.topics.iter().any(|name| is_it(name)))
        && selection.is_ok_and(|it| it.takes(topic, type_name))
}

/// Whether loss on a topic matters: other topics are published before the recorder listens.
fn is_counted(topic: &str) -> bool {
    !planesman_show::diff::WALL_TIME.contains(&topic)
}

/// The number of messages that a node published per topic, from its exit report; `None` without a report.
fn published(path: &Path) -> Option<BTreeMap<String, u64>> {
    let text = fs::read_to_string(path).ok()?;
    let report: planesman_node::ExitReport = serde_json::from_str(&text).ok()?;
    let mut sent = report.published;
    for (topic, dropped) in report.dropped {
        *sent.entry(topic).or_default() += dropped;
    }
    Some(sent)
}

fn count_table(counts: &BTreeMap<String, Count>) -> String {
    let width = counts.keys().map(String::len).max().unwrap_or(0).max(5);
    let mut out = format!("{:width$}  published  in the bag  lost\n", "Topic");
    for (topic, count) in counts {
        let text = |n: Option<u64>| n.map_or_else(|| "-".to_owned(), |it| it.to_string());
        let (published, missing) = (text(count.published), text(count.lost()));
        out += &format!(
            "{topic:width$}  {published:>9}  {:>10}  {missing:>4}\n",
            count.recorded
        );
    }
    let (_, lost) = published_and_lost(counts);
    out + &format!("{:width$}  {:>9}  {:>10}  {lost:>4}\n", "all", "", "")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(published: Option<u64>, recorded: u64) -> Count {
        Count {
            published,
            recorded,
        }
    }

    #[test]
    fn what_was_published_and_is_not_in_the_bag_is_lost() {
        let mut counts = BTreeMap::from([
            ("/auv/state".to_owned(), count(Some(1800), 1800)),
            ("/auv/depth_setpoint".to_owned(), count(None, 1)),
        ]);
        assert_eq!(Loss::of(&counts), None);
        counts.insert("/auv/imu".to_owned(), count(Some(1800), 1775));
        counts.insert("/auv/daq".to_owned(), count(Some(1800), 0));
        // Somebody else publishes there too: more is in the bag than our nodes sent.
        counts.insert("/tf".to_owned(), count(Some(1800), 2000));
        let loss = Loss::of(&counts).expect("lost").to_string();
        assert_eq!(
            loss,
            "the bag lacks 1825 of 7200 published messages: /auv/daq 1800 of 1800, /auv/imu 25 of 1800"
        );
    }

    #[test]
    fn a_topic_that_was_not_to_be_recorded_is_not_lost() {
        let all = RecorderParameters::default();
        let some = RecorderParameters {
            topics: ["state", "/tf"].map(str::to_owned).into(),
            ..all.clone()
        };
        assert!(is_selected("/auv/state", &some));
        assert!(is_selected("/tf", &some));
        assert!(!is_selected("/auv/imu", &some));
        assert!(is_selected("/auv/imu", &all));
        let mut but_two = all;
        but_two.record.exclude_topics = vec!["imu".to_owned()];
        but_two.record.exclude_topic_types = vec!["tf2_msgs/msg/TFMessage".to_owned()];
        assert!(is_selected("/auv/state", &but_two));
        assert!(!is_selected("/auv/imu", &but_two));
        assert!(!is_selected("/tf", &but_two));
    }

    /// A flight in one process into a flight's folder, with the reports of nodes that sent so much.
    #[test]
    fn a_flight_folder_tells_what_its_bag_lacks() {
        let folder = tempfile::tempdir().expect("a folder");
        let run = RunFolder {
            path: folder.path().join("flight"),
        };
        let text = "description: A test\nduration: 1.0\n";
        let scenario = Scenario::parse(text).expect("a scenario");
        run.create(&scenario, "").expect("made");
        planesman_flight::fly(
            &scenario,
            &planesman_flight::Parts::default(),
            &run.path.join("flown.mcap"),
            "/auv",
            &(),
        )
        .expect("flown");
        fs::create_dir(run.bag()).expect("made");
        fs::rename(run.path.join("flown.mcap"), run.bag().join("bag_0.mcap")).expect("moved");
        let tell = |published: u64, dropped: u64| {
            let topic = "/auv/state".to_owned();
            let report = planesman_node::ExitReport {
                node: "/auv/plant_sim".to_owned(),
                published: BTreeMap::from([(topic.clone(), published)]),
                dropped: BTreeMap::from([(topic, dropped)]),
                ..planesman_node::ExitReport::default()
            };
            let text = serde_json::to_vec(&report).expect("plain");
            fs::write(run.exit_report("plant_sim"), text).expect("written");
        };
        tell(20, 0);
        assert_eq!(run.loss(&scenario).expect("readable"), None);
        for (published, dropped) in [(23, 0), (20, 3)] {
            tell(published, dropped);
            let loss = run
                .loss(&scenario)
                .expect("readable")
                .expect("lost")
                .to_string();
            assert!(loss.ends_with("/auv/state 3 of 23"), "{loss}");
        }
    }
}
