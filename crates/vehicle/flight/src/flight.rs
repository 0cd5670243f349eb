//! Reads a flight from its bag: the data of the summary and the page.
//!
//! The bag is streamed; the memory used does not grow with the length of the flight. The same irregularities are tolerated as in the loop.
//! A repeated tick counts once. A message that does not decode, or whose stamp is out of order, is skipped. A restart of the vehicle begins
//! a new flight. [`Flight::notes`] lists all irregularities.

mod collected;

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::Result;
use planesman_bag::TopicKind;
use planesman_bag::reader::{BagReader, Messages, Order};

use planesman_control::gains::{FIRST_PAIR, is_of_pitch};
use planesman_hydraulics::Energy;
use planesman_linear::{StepMeter, StepMetrics};
use planesman_msgs::planesman_msgs::msg::{DhaState, ModelEstimate, VehicleState};
use planesman_msgs::{Message, cdr};

use crate::in_order::{InOrder, Next, ReorderStatistics};
use collected::{
    ACTUATORS, Commands, Controls, Line, Models, Motions, Rams, Stamped, States, Thrusters, points,
    seconds,
};

pub(crate) use collected::HeldDepth;
pub use collected::Points;

/// Largest number of topics with lost messages that a note names.
const LOST_SHOWN: usize = 10;

/// A flight; if the bag has several, the last one.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// Number of messages per topic.
    pub counts: BTreeMap<String, u64>,
    /// Reason why the bag is incomplete; `None` if it is complete.
    pub truncated: Option<String>,
    /// Irregularities of the bag, one sentence each.
    pub notes: Vec<String>,
    /// Number of ticks; a repeated tick counts once.
    pub ticks: u64,
    /// Number of ticks without the actuator's answer.
    pub held_ticks: u64,
    /// Last change of the depth setpoint; `None` without a state.
    pub step: Option<Step>,
    /// Actuators by the names of their groups.
    pub actuators: BTreeMap<String, Actuator>,
    /// Last valid model of pitch rate over plane angle. With several pairs, the model of sysid's first pair, or else of the pair published first.
    pub model: Option<ModelEstimate>,
    /// Reason why the last model was not valid.
    pub no_model: String,
    /// Data for the diagrams.
    pub time_histories: TimeHistories,
}

/// Last change of the depth setpoint, and the response.
#[derive(Clone, Debug)]
pub struct Step {
    /// Last depth setpoint, m; without depth control the depth that was reached.
    pub setpoint: f64,
    /// Response; `None` without a step.
    pub response: Option<StepMetrics>,
    /// Evaluated part of the flight, s since the first state: from the step to the first test signal after the step, or to the end if the response
    /// has not settled by then.
    pub judged: [f64; 2],
    /// Whether a test signal moved the planes in that part.
    pub is_disturbed: bool,
}

/// Data of one actuator.
#[derive(Clone, Debug, Default)]
pub struct Actuator {
    /// Pulses issued.
    pub pulses: u64,
    /// Energies at the last state; 0 in a recording of a version without energies.
    pub energy: Energy,
    /// Position of the ram at the last state, m from neutral.
    pub ram: f64,
    /// Differential pressure across the ram, Pa.
    pub pressure: Points,
}

/// Time histories of a flight, at the resolution of a page.
#[derive(Clone, Debug, Default)]
pub struct TimeHistories {
    /// True depth, m.
    pub depth: Points,
    /// Depth setpoint, m.
    pub depth_setpoint: Points,
    /// True pitch, rad.
    pub pitch: Points,
    /// Pitch command, rad.
    pub pitch_command: Points,
    /// Position along and to starboard of the initial heading, m.
    pub place: [Points; 2],
    /// True roll, rad.
    pub roll: Points,
    /// True yaw, rad.
    pub yaw: Points,
    /// Speed through the water, m/s.
    pub speed: Points,
    /// Heading setpoint, rad, while a heading is held.
    pub heading_setpoint: Points,
    /// Rudder command, rad.
    pub rudder: Points,
    /// Thrust command, as a share of full thrust.
    pub thrust: Points,
    /// Commands of the thrusters, by name.
    pub thrusters: Vec<(String, Points)>,
    /// Plane angle of the actuator, rad: for the whole flight and for its first seconds.
    pub planes: [Points; 2],
    /// Plane command, rad: for the whole flight and for its first seconds.
    pub plane_command: [Points; 2],
    /// Real and imaginary part of the identified dominant pole, 1/s.
    pub pole: [Points; 2],
}

impl Flight {
    /// Reads the flight in a bag. Topics are identified by the last part of their name; with several vehicles, the topics in the namespace with the
    /// most states are used.
    ///
    /// # Errors
    /// If the path is not a bag.
    pub fn read(path: &Path) -> Result<Self> {
        let bag = BagReader::open(path)?;
        let mut account = Account::new(&bag);
        let damage = account.read_all(&bag);
        let mut flight = account.flight();
        flight.step = account.step(&bag, &mut flight.notes);
        flight.counts = recorded(&bag);
        if bag.dropped() > 0 {
            let loss = |(topic, lost): (&str, u64)| format!("{lost} of {topic}");
            let lost: Vec<_> = bag.dropped_by_topic().take(LOST_SHOWN).map(loss).collect();
            let note = format!("messages lost while recording: {}", lost.join(", "));
            flight.notes.push(note);
        }
        let whole = bag.completeness().is_whole();
        flight.truncated = damage.or_else(|| (!whole).then(|| bag.completeness().to_string()));
        Ok(flight)
    }
}

/// Number of messages in a bag, by topic.
pub fn recorded(bag: &BagReader) -> BTreeMap<String, u64> {
    let mut counts = BTreeMap::new();
    for count in bag.topics() {
        *counts.entry(count.topic.name.clone()).or_insert(0) += count.messages;
    }
    counts
}

/// Meter for the response to a setpoint from a depth, up to the time `end`; `None` if the vehicle was already there.
pub(crate) fn step_meter(
    depth: f64,
    setpoint: f64,
    end: f64,
) -> Result<Option<StepMeter>, planesman_linear::Error> {
    let is_step = (setpoint - depth).abs() > 1e-6;
    is_step
        .then(|| StepMeter::new(depth, setpoint, end))
        .transpose()
}

/// Data of all topics of a flight.
struct Account {
    /// Namespace of the topics.
    namespace: String,
    /// Stamp of the first message, ns; the origin of the times.
    origin: Option<i64>,
    states: Line<States>,
    controls: Line<Controls>,
    commands: Line<Commands>,
    thrusters: Line<Thrusters>,
    motions: Line<Motions>,
    rams: BTreeMap<String, Line<Rams>>,
    /// Models of the first pair; and models of the first other pair, with its name.
    models: Line<Models>,
    other_models: Option<(String, Line<Models>)>,
    /// Number of skipped messages by topic, with the problem of the first skipped message.
    refused: BTreeMap<String, (u64, String)>,
}

impl Account {
    fn new(bag: &BagReader) -> Self {
        let of_states = bag
            .topics()
            .iter()
            .filter(|count| count.topic.kind.type_name == VehicleState::TYPE_NAME)
            .filter_map(|count| Some((count.topic.name.strip_suffix("state")?, count.messages)))
            .filter(|(namespace, _)| namespace.is_empty() || namespace.ends_with('/'));
        Self {
            namespace: of_states
                .max_by_key(|(_, messages)| *messages)
                .map_or("/", |(namespace, _)| namespace)
                .to_owned(),
            origin: None,
            states: Line::default(),
            controls: Line::default(),
            commands: Line::default(),
            thrusters: Line::default(),
            motions: Line::default(),
            rams: BTreeMap::new(),
            models: Line::default(),
            other_models: None,
            refused: BTreeMap::new(),
        }
    }

    /// Reads the whole bag; returns the reason if it ends early.
    fn read_all(&mut self, bag: &BagReader) -> Option<String> {
        let namespace = self.namespace.clone();
        let mut messages = bag.messages_of(|topic| concerns(&namespace, &topic.name), Order::File);
        let damage = each(&mut messages, |message| {
            let topic = &message.topic;
            let name = topic.name.strip_prefix(&namespace).unwrap_or_default();
            let outcome = self.take_one(name, &topic.kind, &message.payload);
            if let Err(reason) = outcome {
                let (count, _) = self
                    .refused
                    .entry(topic.name.clone())
                    .or_insert((0, reason.to_string()));
                *count += 1;
            }
        });
        let origin = self.origin.unwrap_or(0);
        self.states.finish(origin);
        self.controls.finish(origin);
        self.commands.finish(origin);
        self.thrusters.finish(origin);
        self.motions.finish(origin);
        self.rams.values_mut().for_each(|ram| ram.finish(origin));
        self.models.finish(origin);
        if let Some((_, models)) = &mut self.other_models {
            models.finish(origin);
        }
        damage
    }

    fn take_one(&mut self, name: &str, kind: &TopicKind, payload: &[u8]) -> Result<(), Unreadable> {
        let Self { origin, .. } = self;
        let type_name = &kind.type_name;
        match name {
            "state" => {
                let state = decode(type_name, payload)?;
                self.states.push(begun(origin, &state), state);
            }
            "control_state" => {
                let control = decode(type_name, payload)?;
                self.controls.push(begun(origin, &control), control);
            }
            "plane_command" => {
                let command = decode(type_name, payload)?;
                self.commands.push(begun(origin, &command), command);
            }
            "thruster_command" => {
                let command = decode(type_name, payload)?;
                self.thrusters.push(begun(origin, &command), command);
            }
            "plane_motion" => {
                let motion = decode(type_name, payload)?;
                self.motions.push(begun(origin, &motion), motion);
            }
            "model" => {
                let model: ModelEstimate = decode(type_name, payload)?;
                let origin = begun(origin, &model);
                if !is_of_pitch(&model) {
                    return Ok(());
                }
                if model.name == FIRST_PAIR {
                    self.models.push(origin, model);
                    return Ok(());
                }
                let (name, line) = self
                    .other_models
                    .get_or_insert_with(|| (model.name.clone(), Line::default()));
                if *name == model.name {
                    line.push(origin, model);
                }
            }
            _ => {
                let state = ram_state(kind, payload)?;
                if !self.rams.contains_key(&state.group) && self.rams.len() == ACTUATORS {
                    return Err(Unreadable::TooManyActuators);
                }
                let ram = self.rams.entry(state.group.clone()).or_default();
                ram.push(begun(origin, &state), state);
            }
        }
        Ok(())
    }

    /// Last change of the depth setpoint. The response depends on the start and end of the evaluation, so the states are read a second time.
    fn step(&self, bag: &BagReader, notes: &mut Vec<String>) -> Option<Step> {
        let states = &self.states.data;
        let (start, end) = states.span?;
        let held = self.controls.data.depth_held;
        let held = held.unwrap_or(HeldDepth::from(states.last_depth, start));
        let (setpoint, since) = (held.depth, held.since);
        let response = |to| self.response(bag, [start, since, to], setpoint);
        let (response, to, is_disturbed) = held.judged(end, response);
        let response = response.unwrap_or_else(|error| {
            notes.push(format!("no depth response: {error}"));
            None
        });
        Some(Step {
            setpoint,
            response,
            judged: [since, to].map(|it| seconds(start, it)),
            is_disturbed,
        })
    }

    /// Response to a step at `since`, evaluated up to `end`.
    fn response(
        &self,
        bag: &BagReader,
        [start, since, end]: [i64; 3],
        setpoint: f64,
    ) -> Result<Option<StepMetrics>, planesman_linear::Error> {
        let mut order = InOrder::default();
        let mut response = Response {
            start,
            since,
            end,
            setpoint,
            measured: Measured::NotBegun,
        };
        let name = format!("{}state", self.namespace);
        let mut messages = bag.messages_of(|topic| topic.name == name, Order::File);
        // What ends it early has ended the first reading too.
        let _ = each(&mut messages, |message| {
            let state = decode::<VehicleState>(&message.topic.kind.type_name, &message.payload);
            if let Ok(state) = state {
                response.take(order.take(state.stamp(), state.depth));
            }
        });
        response.take(order.finish());
        response.metrics()
    }

    fn flight(&self) -> Flight {
        let states = &self.states.data;
        let controls = &self.controls.data;
        let start = states.span.map_or(0, |(start, _)| start);
        let shift = seconds(self.origin.unwrap_or(start), start);
        let other = self.other_models.as_ref().map(|(_, line)| line);
        let spoken = |line: &&Line<Models>| line.order.has_begun();
        let models = Some(&self.models).filter(spoken).or(other);
        let no_model = match models {
            None => "no model was published".to_owned(),
            Some(models) => models.data.reason.clone(),
        };
        let pole =
            |part: usize| models.map_or_else(Vec::new, |line| points(&line.data.pole[part], shift));
        let actuator = |(group, line): (&String, &Line<Rams>)| {
            let actuator = Actuator {
                pulses: line.data.pulses,
                energy: line.data.energy,
                ram: line.data.ram,
                pressure: points(&line.data.pressure, shift),
            };
            (group.clone(), actuator)
        };
        Flight {
            notes: self.notes(),
            ticks: states.ticks,
            held_ticks: states.planes_held,
            actuators: self.rams.iter().map(actuator).collect(),
            model: models.and_then(|line| line.data.valid.clone()),
            no_model,
            time_histories: TimeHistories {
                depth: points(&states.depth, shift),
                depth_setpoint: points(&controls.depth_setpoint, shift),
                pitch: points(&states.pitch, shift),
                pitch_command: points(&controls.pitch_command, shift),
                place: [0, 1].map(|i| points(&states.place[i], shift)),
                roll: points(&states.roll, shift),
                yaw: points(&states.yaw, shift),
                speed: points(&states.speed, shift),
                heading_setpoint: points(&controls.heading_setpoint, shift),
                rudder: points(&self.commands.data.rudder, shift),
                thrust: points(&self.commands.data.thrust, shift),
                thrusters: (self.thrusters.data.0.iter())
                    .map(|(name, it)| (name.clone(), points(it, shift)))
                    .collect(),
                planes: self.motions.data.0.points(shift),
                plane_command: self.commands.data.planes.points(shift),
                pole: [pole(0), pole(1)],
            },
            ..Flight::default()
        }
    }

    /// Irregularities of the bag.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let refused = self.refused.iter();
        notes.extend(refused.map(|(topic, (count, reason))| {
            format!("{topic}: {count} messages skipped. The reason for the first is: {reason}")
        }));
        let lines = [
            ("state", self.states.order.statistics),
            ("control_state", self.controls.order.statistics),
            ("plane_command", self.commands.order.statistics),
            ("thruster_command", self.thrusters.order.statistics),
            ("plane_motion", self.motions.order.statistics),
            ("model", self.models.order.statistics),
        ];
        let rams = self.rams.iter();
        let rams =
            rams.map(|(group, line)| (format!("dha_state of {group}"), line.order.statistics));
        let lines = lines.map(|(name, met)| (name.to_owned(), met));
        for (name, met) in lines.into_iter().chain(rams) {
            let ReorderStatistics {
                repeated,
                out_of_line,
                restarts,
            } = met;
            for (count, what) in [
                (repeated, "with a repeated stamp, counted once"),
                (out_of_line, "skipped, with stamps out of order"),
            ] {
                if count > 0 {
                    notes.push(format!("{}{name}: {count} {what}", self.namespace));
                }
            }
            if restarts > 0 {
                notes.push(format!(
                    "{}{name}: time went back {restarts} times; only the flight after the last \
                     restart is shown",
                    self.namespace
                ));
            }
        }
        notes
    }
}

/// Response to a step, from the states, which are read again.
struct Response {
    /// First state, end of the evaluated part, and step, ns.
    start: i64,
    end: i64,
    since: i64,
    /// m
    setpoint: f64,
    measured: Measured,
}

/// State of the measurement of a response.
enum Measured {
    NotBegun,
    /// The vehicle was already at its setpoint.
    NoStep,
    By(Box<StepMeter>),
    Failed(planesman_linear::Error),
}

impl Response {
    fn take(&mut self, next: Option<Next<f64>>) {
        let (stamp, depth) = match next {
            None => return,
            Some(Next::On(stamp, depth)) => (stamp, depth),
            Some(Next::Restarted(stamp, depth)) => {
                self.measured = Measured::NotBegun;
                (stamp, depth)
            }
        };
        if stamp < self.since || stamp > self.end {
            return;
        }
        if matches!(self.measured, Measured::NotBegun) {
            self.measured = self.begun(depth).unwrap_or_else(Measured::Failed);
        }
        if let Measured::By(meter) = &mut self.measured
            && let Err(error) = meter.take(seconds(self.start, stamp), depth)
        {
            self.measured = Measured::Failed(error);
        }
    }

    fn begun(&self, depth: f64) -> Result<Measured, planesman_linear::Error> {
        let end = seconds(self.start, self.end);
        let meter = step_meter(depth, self.setpoint, end)?;
        Ok(meter.map_or(Measured::NoStep, |it| Measured::By(Box::new(it))))
    }

    fn metrics(self) -> Result<Option<StepMetrics>, planesman_linear::Error> {
        match self.measured {
            Measured::NotBegun | Measured::NoStep => Ok(None),
            Measured::By(meter) => meter.metrics().map(Some),
            Measured::Failed(error) => Err(error),
        }
    }
}

/// Passes every message to `take`; returns the error that ended the reading early.
fn each(
    messages: &mut Messages<'_>,
    mut take: impl FnMut(&planesman_bag::Message),
) -> Option<String> {
    for message in messages {
        match message {
            Ok(message) => take(&message),
            Err(error) => return Some(error.to_string()),
        }
    }
    None
}

/// Origin of the times; the first message sets it.
fn begun(origin: &mut Option<i64>, message: &impl Stamped) -> i64 {
    *origin.get_or_insert(message.stamp())
}

/// Whether a topic of this name has data of a flight in the namespace.
fn concerns(namespace: &str, topic: &str) -> bool {
    let names = [
        "state",
        "control_state",
        "plane_command",
        "thruster_command",
        "plane_motion",
        "model",
    ];
    topic
        .strip_prefix(namespace)
        .is_some_and(|name| names.contains(&name) || is_of_a_ram(name))
}

fn is_of_a_ram(name: &str) -> bool {
    name.strip_prefix("dha_state")
        .is_some_and(|group| !group.contains('/'))
}

/// Reason why a message of a bag is skipped.
#[derive(Debug, thiserror::Error)]
enum Unreadable {
    #[error("its type is {0}, not {1}")]
    OfAnotherType(String, &'static str),
    #[error(transparent)]
    Cdr(#[from] cdr::Error),
    #[error("{0} is not finite")]
    NotFinite(String),
    #[error("more than {most} actuators", most = ACTUATORS)]
    TooManyActuators,
}

/// State of an actuator. A message of a version without energies is shorter: its energies are 0.
fn ram_state(kind: &TopicKind, payload: &[u8]) -> Result<DhaState, Unreadable> {
    let state = decode(&kind.type_name, payload);
    if kind.type_hash == DhaState::TYPE_HASH {
        return state;
    }
    state.or_else(|error| {
        let fields = payload.len().saturating_sub(cdr::HEADER);
        let energies = size_of::<Energy>();
        let mut longer = payload.to_vec();
        longer.resize(cdr::HEADER + fields.next_multiple_of(8) + energies, 0);
        decode(&kind.type_name, &longer).map_err(|_| error)
    })
}

/// Decodes a message of type `type_name` from a payload, by the same rules as a node.
fn decode<M: Message>(type_name: &str, payload: &[u8]) -> Result<M, Unreadable> {
    if type_name != M::TYPE_NAME {
        let type_name = type_name.to_owned();
        return Err(Unreadable::OfAnotherType(type_name, M::TYPE_NAME));
    }
    let message: M = cdr::from_bytes(payload)?;
    match message.first_non_finite() {
        None => Ok(message),
        Some(field) => Err(Unreadable::NotFinite(field)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rams_state_from_before_it_had_energies_is_read_whatever_its_last_text() {
        let with_faults = |length: usize| DhaState {
            group: "dive_planes".to_owned(),
            pulses: 7,
            faults: "f".repeat(length),
            ..DhaState::default()
        };
        let size = |length| cdr::to_bytes(&with_faults(length)).len();
        let old = TopicKind {
            type_name: DhaState::TYPE_NAME.to_owned(),
            type_hash: "RIHS01_of_an_earlier_version".to_owned(),
            ..TopicKind::default()
        };
        let new = TopicKind {
            type_hash: DhaState::TYPE_HASH.to_owned(),
            ..old.clone()
        };
        for length in 0..9 {
            // Letters that fit before the energies move are padding of the old message's last text.
            let padding = (1..9).find(|more| size(length + more) > size(length));
            let end = size(length) - size_of::<Energy>() - (padding.unwrap_or(1) - 1);
            let state = with_faults(length);
            let whole = cdr::to_bytes(&state);
            assert_eq!(ram_state(&old, &whole[..end]).ok(), Some(state), "{length}");
            assert!(ram_state(&new, &whole[..end]).is_err(), "{length}");
        }
    }
}
