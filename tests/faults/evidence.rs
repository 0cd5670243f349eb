//! Evidence of a flight: whether its vehicle stayed within its envelope, its data are complete, its bag is readable, its
//! exit code is true, and nobody is left behind.

use std::collections::BTreeMap;
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

use planesman::run_folder::RunFolder;
use planesman_bag::BagReader;
use planesman_flight::nodes::NODES;
use planesman_msgs::Message;
use planesman_msgs::planesman_msgs::msg::{ControlState, DhaState, ModelEstimate, VehicleState};
use planesman_node::ExitReport;
use rustix::process::Pid;

use super::recorded;
use super::stage::{self, Outcome, eventually};

/// The sampling time, ns.
pub(crate) const TICK: i64 = 50_000_000;
/// Where a vehicle that is sent three feet down must stay, m, while its planes are moved.
const DEPTHS: RangeInclusive<f64> = -0.5..=3.0;
/// How far it can come in a tick whose planes are held where they were, m: at 1 ft/s, straight down.
const HELD: f64 = 0.3048 * 0.05;
/// Topics that are spoken before the recorder listens, and tell nothing of the vehicle's course.
const OF_HEALTH: [&str; 3] = ["/diagnostics", "/rosout", "/parameter_events"];
/// Exit status of `planesman dive` when its bag lacks published messages.
const DATA_LOST: i32 = 3;

pub(crate) fn stamp(state: &VehicleState) -> i64 {
    state.header.stamp.nanos()
}

/// A bag's data on a flight.
pub(crate) struct Flight {
    pub(crate) states: Vec<VehicleState>,
    controls: Vec<ControlState>,
    actuators: Vec<DhaState>,
    models: Vec<ModelEstimate>,
    is_whole: bool,
}

impl Flight {
    /// The messages in a bag as it is now; `None` while it cannot be read.
    pub(crate) fn read(bag: &Path) -> Option<Self> {
        Some(Self {
            states: messages(bag, "state")?,
            controls: messages(bag, "control_state")?,
            actuators: messages(bag, "dha_state")?,
            models: messages(bag, "model")?,
            is_whole: BagReader::open(bag).ok()?.completeness().is_whole(),
        })
    }
}

/// The messages of the one vehicle's topic `name`.
fn messages<M: Message>(bag: &Path, name: &str) -> Option<Vec<M>> {
    let topics = BagReader::open(bag).ok()?.topics().to_vec();
    let topic = topics
        .iter()
        .map(|counted| &counted.topic.name)
        .find(|topic| topic.rsplit('/').next() == Some(name));
    topic.map_or(Some(Vec::new()), |topic| recorded::messages(bag, topic))
}

/// The flight in a bag that reads to its end, whole or not; the vehicle was within its envelope all the time.
pub(crate) fn flight(bag: &Path) -> Flight {
    let flight = Flight::read(bag).unwrap();
    let mut drift = 0.0;
    for state in &flight.states {
        if state.planes_source == VehicleState::PLANES_HELD {
            drift += HELD;
        }
        let depths = DEPTHS.start() - drift..=DEPTHS.end() + drift;
        assert_eq!(state.first_non_finite(), None, "{state:?}");
        assert!(depths.contains(&state.depth), "{state:?}");
    }
    flight
}

/// Like [`flight`], of a bag that was closed.
pub(crate) fn whole_flight(bag: &Path) -> Flight {
    let flight = flight(bag);
    assert!(flight.is_whole);
    flight
}

/// The states of a lockstep flight, tick by tick from the first without a gap; what was said again is the same.
/// Returns the number of ticks.
pub(crate) fn each_tick_is_there(flight: &Flight) -> usize {
    let mut states = flight.states.clone();
    states.dedup();
    let stamps: Vec<i64> = states.iter().map(stamp).collect();
    let first = stamps.first().copied().unwrap_or(0);
    let expected: Vec<i64> = (0..).map(|k| first + k * TICK).take(stamps.len()).collect();
    if let Some(wrong) = (0..stamps.len()).find(|k| stamps[*k] != expected[*k]) {
        panic!(
            "tick {wrong} is missing or differs when said again: {:?}",
            &states[wrong.saturating_sub(1)..=wrong]
        );
    }
    assert_eq!(first, 0);
    stamps.len()
}

/// Messages that were published and are not in the bag, by topic.
fn lost(out: &Path) -> BTreeMap<String, u64> {
    let run = RunFolder::open(out).unwrap();
    let bag = BagReader::open(&run.bag()).unwrap();
    let recorded: BTreeMap<&str, u64> = bag
        .topics()
        .iter()
        .map(|counted| (counted.topic.name.as_str(), counted.messages))
        .collect();
    let mut lost = BTreeMap::new();
    for node in NODES {
        let text = fs::read(run.exit_report(node)).unwrap();
        let report: ExitReport = serde_json::from_slice(&text).unwrap();
        for (topic, messages) in report.published.into_iter().chain(report.dropped) {
            *lost.entry(topic).or_insert(0) += messages;
        }
    }
    lost.retain(|topic, messages| {
        *messages = messages.saturating_sub(recorded.get(topic.as_str()).copied().unwrap_or(0));
        *messages > 0 && !OF_HEALTH.contains(&topic.as_str())
    });
    lost
}

/// The flight came to its end. It says so if all that was published is in the bag; otherwise what is lost, in its
/// exit code and in its last line. Returns that, by topic.
pub(crate) fn ends_and_says_what_it_lost(outcome: &Outcome, out: &Path) -> BTreeMap<String, u64> {
    let lost = lost(out);
    match outcome.status.code() {
        Some(0) => assert!(lost.is_empty(), "lost without a report: {lost:?}"),
        Some(DATA_LOST) => {
            let complaints = outcome.complaints();
            let last = complaints.last().copied().unwrap_or_default();
            let number = format!("lacks {} of", lost.values().sum::<u64>());
            assert!(last.contains(&number), "lost {lost:?}, reported: {last}");
        }
        _ => panic!("{outcome:#?}"),
    }
    lost
}

/// The bag was closed.
pub(crate) fn is_whole(bag: &Path) -> bool {
    BagReader::open(bag).unwrap().completeness().is_whole()
}

/// Nobody of a flight runs on.
pub(crate) fn nobody_is_left(nodes: &BTreeMap<String, Pid>) {
    for (name, pid) in nodes {
        eventually(&format!("the end of {name}"), || {
            (!stage::runs(*pid)).then_some(())
        });
    }
}

/// Evidence that all nodes take part in the loop: the planes are answered for, the vehicle is steered, the actuator receives
/// it, and a model is learnt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Part {
    pub(crate) answered: bool,
    pub(crate) steered: bool,
    pub(crate) commanded: bool,
    pub(crate) learnt: bool,
}

impl Part {
    pub(crate) const ALL: Self = Self {
        answered: true,
        steered: true,
        commanded: true,
        learnt: true,
    };

    /// The evidence after the stamp `since`, ns.
    pub(crate) fn of(flight: &Flight, since: i64) -> Self {
        let mut part = Self::default();
        flight
            .states
            .iter()
            .for_each(|state| part.see_state(state, since));
        flight
            .controls
            .iter()
            .for_each(|control| part.see_control(control, since));
        flight
            .actuators
            .iter()
            .for_each(|state| part.see_actuator(state, since));
        flight
            .models
            .iter()
            .for_each(|model| part.see_model(model, since));
        part
    }

    pub(crate) fn see_state(&mut self, state: &VehicleState, since: i64) {
        self.answered |= stamp(state) > since && state.planes_source != VehicleState::PLANES_HELD;
    }

    pub(crate) fn see_control(&mut self, control: &ControlState, since: i64) {
        self.steered |= control.header.stamp.nanos() > since;
    }

    pub(crate) fn see_actuator(&mut self, state: &DhaState, since: i64) {
        self.commanded |= state.header.stamp.nanos() > since && !state.command_stale;
    }

    pub(crate) fn see_model(&mut self, model: &ModelEstimate, since: i64) {
        self.learnt |= model.header.stamp.nanos() > since;
    }
}
