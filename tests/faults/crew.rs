//! The loop's nodes, each started by itself, so that each can die, come back, or be far away by itself. What they do is
//! seen in the recorder's bag.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use planesman::nodes::LAUNCHED;
use planesman_bag::BagReader;
use planesman_flight::nodes::NODES;

use super::evidence::{self, Flight, Part};
use super::network::Place;
use super::pace::Pace;
use super::stage::{Process, Signal, Stage, eventually};

/// For links, and machines, that take longer than a tick.
const DELAY_BUDGET: &str = "delay_budget:=20";
/// Time between two looks into the bag.
const LOOK: Duration = Duration::from_millis(100);

/// Nodes without a launcher.
pub(crate) struct Crew<'s> {
    stage: &'s Stage,
    pace: Pace,
    /// Where a node runs, if not with the test.
    places: BTreeMap<&'static str, Place>,
    nodes: BTreeMap<&'static str, Process>,
    /// The bag of each recorder so far.
    bags: Vec<PathBuf>,
}

impl<'s> Crew<'s> {
    /// All five, in flight.
    pub(crate) fn start(
        stage: &'s Stage,
        pace: Pace,
        places: BTreeMap<&'static str, Place>,
    ) -> Self {
        let mut crew = Self {
            stage,
            pace,
            places,
            nodes: BTreeMap::new(),
            bags: Vec::new(),
        };
        for node in NODES {
            crew.join(node);
        }
        crew
    }

    /// Starts `node`, for the first time or again.
    pub(crate) fn join(&mut self, node: &'static str) {
        let mut parameters = self.parameters(node);
        if node == "recorder" {
            let bag = self.stage.path(&format!("bag-{}", self.bags.len()));
            parameters.push(format!("output:={bag}"));
            self.bags.push(bag.into());
        }
        let mut arguments = vec!["node", node, "--ros-args"];
        for parameter in &parameters {
            arguments.extend(["-p", parameter]);
        }
        let mut variables = vec![(LAUNCHED, "1")];
        let nowhere = Place::new();
        let place = self.places.get(node).unwrap_or(&nowhere);
        if !place.is_empty() {
            // In a namespace of its own a subnet has nobody else in it.
            variables.push(("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"));
        }
        let process = self.stage.start_at(place, &arguments, &variables);
        self.nodes.insert(node, process);
    }

    fn parameters(&self, node: &str) -> Vec<String> {
        let lockstep = self.pace == Pace::Lockstep;
        let mut parameters = match (node, self.pace) {
            ("plant_sim", Pace::Lockstep) => vec![
                "time:=lockstep".to_owned(),
                "lockstep.members:=[sysid,recorder]".to_owned(),
            ],
            ("plant_sim", Pace::Real(factor)) => vec![
                "time:=real".to_owned(),
                format!("factor:={factor}.0"),
                DELAY_BUDGET.to_owned(),
            ],
            ("depth_controller", _) => vec![
                format!("lockstep:={lockstep}"),
                "depth_setpoint:=0.9144".to_owned(),
                "identification.signal:=prbs".to_owned(),
            ],
            ("dha_actuator", _) => vec![format!("lockstep:={lockstep}")],
            // It learns from what was late, too.
            ("sysid", Pace::Real(_)) => vec!["start:=0.0".to_owned(), "break_on:=''".to_owned()],
            ("sysid", Pace::Lockstep) => {
                vec![format!("answer:={lockstep}"), "start:=0.0".to_owned()]
            }
            _ => vec![
                format!("answer:={lockstep}"),
                "flush_interval:=0.0".to_owned(),
            ],
        };
        if node != "plant_sim" {
            parameters.push(format!("use_sim_time:={}", self.pace.owns_time()));
        }
        parameters
    }

    /// Ends `node` as `kill -9` does.
    pub(crate) fn kill(&mut self, node: &str) {
        self.nodes.remove(node).unwrap().kill();
    }

    /// The bag that is written now.
    pub(crate) fn bag(&self) -> &Path {
        &self.bags[self.bags.len() - 1]
    }

    /// Messages of `/auv/topic` in the bag so far.
    pub(crate) fn recorded(&self, topic: &str) -> u64 {
        let Ok(bag) = BagReader::open(self.bag()) else {
            return 0; // It is not begun yet.
        };
        let name = format!("/auv/{topic}");
        let of_it = bag.topics().iter().find(|count| count.topic.name == name);
        of_it.map_or(0, |count| count.messages)
    }

    /// Waits until the bag holds so many messages of a topic.
    pub(crate) fn wait_for(&self, topic: &str, number: u64) {
        eventually(&format!("{number} messages of {topic}"), || {
            // A look reads the whole bag.
            std::thread::sleep(LOOK);
            (self.recorded(topic) >= number).then_some(())
        });
    }

    /// Waits until the bag shows that all take part after the stamp `since`, ns.
    pub(crate) fn wait_for_part(&self, since: i64) {
        eventually("everybody's part", || {
            std::thread::sleep(LOOK);
            let flight = Flight::read(self.bag())?;
            (Part::of(&flight, since) == Part::ALL).then_some(())
        });
    }

    /// Stops everybody, the recorder last; each ends well, and the last bag is whole.
    pub(crate) fn stop(mut self) -> Vec<PathBuf> {
        for node in NODES.iter().rev() {
            let process = self.nodes.remove(node).unwrap();
            process.signal(Signal::TERM);
            process.finish().success();
        }
        evidence::whole_flight(self.bag());
        self.bags
    }
}
