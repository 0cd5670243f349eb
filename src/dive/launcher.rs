//! The launcher in flight: from the discovery of the nodes to the last message.

use std::collections::{BTreeMap, VecDeque};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use planesman_console::progress::{ProgressBar, ProgressStyle};
use planesman_console::sparkline;
use planesman_control::gains::is_of_pitch;
use planesman_flight::model_summary::identified;
use planesman_flight::nodes::NODES;
use planesman_flight::scenario::{Scenario, difference};
use planesman_flight::sink::full_name;
use planesman_linear::pole_text;
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use planesman_msgs::loop_topics;
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, VehicleState};
use planesman_msgs::rcl_interfaces::srv::{GetParameters, GetParametersRequest};
use planesman_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse};
use planesman_node::claim::{Claim, Stage};
use planesman_node::{Client, Connections, Direction, Flow, Next, Runtime, value_of};
use planesman_parameters::{Value, Values};
use recorder::node::BAG;

use super::options::{Options, yield_to_other_dive};
use crate::processes::Processes;

/// Timeout of discovery without a new match, and of an answer to a service call.
const DISCOVERY_TIMEOUT: Duration = Duration::from_secs(30);
/// Timeout for the last messages to arrive.
const DRAIN_TIMEOUT: Duration = Duration::from_secs(10);
/// Timeout for the vehicle to confirm its stop.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);
/// Timeouts for the last messages and for the confirmation of the stop, after an interrupt.
const INTERRUPT_TIMEOUT: Duration = Duration::from_secs(5);

/// A node to be launched.
pub(super) struct LaunchedNode {
    pub(super) node: &'static str,
    pub(super) parameters: Values,
    pub(super) get: Client<GetParameters>,
}

impl LaunchedNode {
    /// Compares the parameters of the running node with those of the flight.
    ///
    /// # Errors
    /// The node does not answer, or has a different value of a parameter.
    async fn check(self) -> Result<()> {
        let names = self.parameters.declarations().iter();
        let names: Vec<String> = names.map(|it| it.name.clone()).collect();
        let request = GetParametersRequest {
            names: names.clone(),
        };
        let answer = self.get.call(request, DISCOVERY_TIMEOUT).await;
        let answer = answer.with_context(|| format!("the parameters of {}", self.node))?;
        let values = answer.values.into_iter().map(value_of);
        let has: BTreeMap<String, Option<Value>> = names.into_iter().zip(values).collect();
        match difference(&self.parameters, |name| has.get(name).cloned().flatten()) {
            None => Ok(()),
            Some(difference) => bail!(
                "a parameter of the running node differs from that of the flight: {}.{difference}",
                self.node
            ),
        }
    }
}

pub(super) enum Event {
    Diagnostics(DiagnosticArray),
    State(VehicleState),
    Model(Box<ModelEstimate>),
    /// Result of the comparison of the nodes' parameters with the flight's.
    Compared(Result<()>),
    /// The vehicle's answer to its release.
    Going(Result<SetBoolResponse, planesman_node::Error>),
    /// The vehicle's answer to the stop request.
    Stopped(Result<SetBoolResponse, planesman_node::Error>),
    Poll,
}

enum Phase {
    /// The launcher waits until all nodes have discovered each other. `matches`: the largest number of matches so far; `since`: when it was reached.
    Discovering { matches: usize, since: Instant },
    /// All nodes have discovered each other; their parameters are compared with the flight's.
    Comparing,
    /// The vehicle is released and flies.
    Flying,
    /// The vehicle has been requested to stop.
    Stopping,
    /// The vehicle stopped at this time; the last messages are in transit.
    Draining(Instant),
}

pub(super) struct Launcher {
    scenario: Scenario,
    options: Options,
    pub(super) processes: Processes,
    go: Client<SetBool>,
    launched: Vec<LaunchedNode>,
    claim: Claim,
    phase: Phase,
    /// The endpoints of each node.
    connections: BTreeMap<String, Connections>,
    pub(super) bar: ProgressBar,
    /// History of depth (m) and plane angle (deg) so far.
    depth: History,
    planes: History,
    /// Stamps of the first and the last state, ns.
    first: Option<i64>,
    last: Option<i64>,
    pub(super) ticks: u64,
    /// Whether the vehicle has reported the end of the flight.
    done: bool,
    pole: String,
    /// Time at which the vehicle was released.
    began: Instant,
    /// Wall time from the release to the last state.
    pub(super) flown: Duration,
    /// The vehicle's last diagnostic status: level and message.
    vehicle: (u8, String),
    /// Whether the dive was interrupted.
    pub(super) interrupted: bool,
    /// Whether another dive was discovered in flight.
    rival_seen: bool,
}

impl Launcher {
    pub(super) fn new(
        scenario: &Scenario,
        options: &Options,
        processes: Processes,
        go: Client<SetBool>,
        (launched, claim): (Vec<LaunchedNode>, Claim),
    ) -> Self {
        Self {
            scenario: scenario.clone(),
            options: options.clone(),
            processes,
            go,
            launched,
            claim,
            phase: Phase::Discovering {
                matches: 0,
                since: Instant::now(),
            },
            connections: BTreeMap::new(),
            bar: bar(scenario.ticks(), options.keep_running),
            depth: History::of(scenario, options.keep_running),
            planes: History::of(scenario, options.keep_running),
            first: None,
            last: None,
            ticks: 0,
            done: false,
            pole: String::new(),
            began: Instant::now(),
            flown: Duration::ZERO,
            vehicle: (DiagnosticStatus::OK, String::new()),
            interrupted: false,
            rival_seen: false,
        }
    }

    /// Handles events until the dive ends. A first interrupt ends the dive in order, a second one at once.
    pub(super) fn command(&mut self, rt: &Runtime<Event>) -> Result<()> {
        loop {
            match rt.next(Duration::MAX) {
                Next::Event(event) => {
                    if self.on(rt, event)? == Flow::Stop {
                        return Ok(());
                    }
                }
                Next::Stop => {
                    self.interrupted = true;
                    // A request to stop would reach the other dive's vehicle too.
                    if self.rival_seen || !matches!(self.phase, Phase::Flying) {
                        return Ok(());
                    }
                    self.stop_the_vehicle(rt);
                }
                Next::Timeout => {}
            }
        }
    }

    fn on(&mut self, rt: &Runtime<Event>, event: Event) -> Result<Flow> {
        match event {
            Event::Diagnostics(array) => {
                if let Some(trouble) = self.trouble_of_the_bag(&array) {
                    bail!("the recorder stopped: {trouble}");
                }
                let vehicle = full_name(&self.options.namespace, "plant_sim") + ": vehicle";
                let is_done = |status: &DiagnosticStatus| {
                    status.name == vehicle && status.message == plant_sim::DONE
                };
                self.done |= array.status.iter().any(is_done);
                if let Some(status) = array.status.iter().find(|it| it.name == vehicle) {
                    self.on_vehicle(status);
                }
                if let Some(connections) = Connections::from_diagnostics(&array) {
                    self.connections
                        .insert(connections.node.clone(), connections);
                }
            }
            Event::State(state) => {
                if self.options.pace.owns_time() {
                    rt.set_time(&state.header.stamp);
                }
                self.on_state(&state);
            }
            Event::Model(model) if model.valid && is_of_pitch(&model) => {
                if let Some(pole) = identified(&model).dominant() {
                    self.pole = format!("pole {}", pole_text(pole, 4));
                }
            }
            Event::Model(_) => {}
            Event::Compared(outcome) => {
                outcome?;
                self.release(rt);
            }
            // A vehicle that moves was released, though its answer was lost.
            Event::Going(outcome) if self.ticks == 0 => drop(outcome?),
            Event::Going(_) => {}
            Event::Stopped(Ok(_)) => self.drain(),
            Event::Stopped(Err(reason)) => {
                self.print_line(&format!(
                    "WARNING: plant_sim does not pause ({reason}); sending SIGTERM to all nodes, to the recorder last"
                ));
                return Ok(Flow::Stop);
            }
            Event::Poll => return self.poll(rt),
        }
        Ok(Flow::Continue)
    }

    /// Stores the vehicle's status, and prints it once the vehicle has waited for `answer_timeout`.
    fn on_vehicle(&mut self, status: &DiagnosticStatus) {
        let now = (status.level, status.message.clone());
        let before = std::mem::replace(&mut self.vehicle, now);
        if status.level == DiagnosticStatus::ERROR && before.0 != status.level {
            let tick = self.ticks.saturating_sub(1);
            self.print_line(&format!(
                "WARNING: plant_sim at tick {tick}: {}",
                status.message
            ));
        }
    }

    /// # Errors
    /// Fewer ticks were flown than the scenario contains.
    pub(super) fn check_flown(&self) -> Result<()> {
        if self.options.keep_running || self.is_flown() {
            return Ok(());
        }
        let (flown, asked) = (self.ticks, self.scenario.ticks());
        let vehicle = match &self.vehicle {
            (DiagnosticStatus::OK, _) => String::new(),
            (_, trouble) => format!("; plant_sim: {trouble}"),
        };
        bail!("interrupted after {flown} of {asked} ticks{vehicle}; the bag is closed")
    }

    /// The reason why recording stopped, from the diagnostics: the recorder's log may be on the full disk.
    fn trouble_of_the_bag<'a>(&self, array: &'a DiagnosticArray) -> Option<&'a str> {
        let bag = format!("{}: {BAG}", full_name(&self.options.namespace, "recorder"));
        let failed = |status: &&DiagnosticStatus| {
            status.name == bag && status.level == DiagnosticStatus::ERROR
        };
        let status = array.status.iter().find(failed)?;
        Some(&status.message)
    }

    fn on_state(&mut self, state: &VehicleState) {
        let stamp = state.header.stamp.nanos();
        let first = *self.first.get_or_insert(stamp);
        let t = (stamp - first) as f64 * 1e-9;
        if self.options.pace.owns_time() {
            self.ticks = (t / self.scenario.tick).round() as u64 + 1;
        } else if self.last.replace(stamp) != Some(stamp) {
            // By the machine's clock ticks may be missed: those flown count.
            self.ticks += 1;
        }
        self.flown = self.began.elapsed();
        self.bar.set_position(self.ticks);
        if self.bar.is_hidden() {
            return;
        }
        let (pitch, planes) = (state.pitch.to_degrees(), state.dive_planes.to_degrees());
        self.depth.take(self.ticks, state.depth);
        self.planes.take(self.ticks, planes);
        self.bar.set_message(format!(
            "{t:5.1} s  depth {:6.3} m  pitch {pitch:+5.1}°  planes {planes:+5.1}°  {}\n{}\n{}",
            state.depth,
            self.pole,
            self.depth.line("depth", -1.0, "m"),
            self.planes.line("planes", 1.0, "deg"),
        ));
    }

    /// Whether the dive is over, by the received states or by the vehicle's own report.
    fn is_flown(&self) -> bool {
        self.ticks >= self.scenario.ticks() || self.done
    }

    fn poll(&mut self, rt: &Runtime<Event>) -> Result<Flow> {
        // A vehicle that has given way to another dive's ends too: name the dive first.
        yield_to_other_dive(&self.claim, &self.options)?;
        if matches!(self.phase, Phase::Flying) && !self.rival_seen {
            // Two networks have become one.
            if let Some(rival) = self.claim.rival() {
                self.rival_seen = true;
                self.print_line(&format!(
                    "WARNING: another dive, {rival}, also flies in namespace {}. Services and setpoints reach both vehicles: stop one of the dives",
                    self.options.namespace
                ));
            }
        }
        self.processes.check()?;
        match self.phase {
            Phase::Discovering { matches, since } => self.discover(rt, matches, since)?,
            Phase::Flying if !self.options.keep_running && self.is_flown() => match self.rival_seen
            {
                false => self.stop_the_vehicle(rt),
                // It ends with its last tick; the request would stop the other dive's vehicle too.
                true => self.drain(),
            },
            Phase::Draining(since) => match self.in_transit() {
                None => return Ok(Flow::Stop),
                Some(missing) if since.elapsed() > self.timeout(DRAIN_TIMEOUT) => {
                    self.print_line(&format!("timeout: {missing}"));
                    return Ok(Flow::Stop);
                }
                Some(_) => {}
            },
            _ => {}
        }
        Ok(Flow::Continue)
    }

    /// Compares the parameters once all have discovered each other; gives up after [`DISCOVERY_TIMEOUT`] without a new match.
    fn discover(&mut self, rt: &Runtime<Event>, matches: usize, since: Instant) -> Result<()> {
        let own = rt.connections();
        let Some(missing) = self.missing(&own) else {
            let checks = std::mem::take(&mut self.launched).into_iter();
            let checks: Vec<_> = checks.map(LaunchedNode::check).collect();
            rt.when_done(async move {
                let mut outcome = Ok(());
                for check in checks {
                    outcome = outcome.and(check.await);
                }
                Event::Compared(outcome)
            });
            self.phase = Phase::Comparing;
            return Ok(());
        };
        let now = self.matches(&own);
        if now > matches {
            self.phase = Phase::Discovering {
                matches: now,
                since: Instant::now(),
            };
        } else if since.elapsed() > DISCOVERY_TIMEOUT {
            bail!(
                "the nodes have not discovered each other (no new connection for {} s): {missing}",
                DISCOVERY_TIMEOUT.as_secs()
            );
        }
        self.bar.set_message(missing);
        Ok(())
    }

    fn release(&mut self, rt: &Runtime<Event>) {
        self.claim.advance_to(Stage::Used);
        if self.options.verbose {
            self.print_line("all nodes have discovered each other; diving");
        }
        self.began = Instant::now();
        let go = self.go.clone();
        rt.when_done(async move {
            Event::Going(
                go.call(SetBoolRequest { data: false }, DISCOVERY_TIMEOUT)
                    .await,
            )
        });
        self.phase = Phase::Flying;
    }

    fn stop_the_vehicle(&mut self, rt: &Runtime<Event>) {
        self.phase = Phase::Stopping;
        let (go, timeout) = (self.go.clone(), self.timeout(STOP_TIMEOUT));
        rt.when_done(async move {
            Event::Stopped(go.call(SetBoolRequest { data: true }, timeout).await)
        });
    }

    /// After the vehicle's stop: waits for the messages in transit.
    fn drain(&mut self) {
        // Only diagnostics from now on count.
        self.connections.clear();
        self.phase = Phase::Draining(Instant::now());
    }

    fn timeout(&self, usual: Duration) -> Duration {
        if self.interrupted {
            INTERRUPT_TIMEOUT
        } else {
            usual
        }
    }

    fn print_line(&self, text: &str) {
        if std::io::stderr().is_terminal() {
            self.bar.println(text);
        } else {
            // The summary at the end is checked; this line need not be.
            let _ = planesman_console::out!("{text}");
        }
    }

    /// The connections reported by every node, or a sentence that names the node whose report is missing.
    fn reports(&self) -> Result<Vec<&Connections>, String> {
        let of = |node: &&str| {
            self.connections
                .get(&full_name(&self.options.namespace, node))
                .ok_or_else(|| format!("waiting for {node}"))
        };
        NODES.iter().map(of).collect()
    }

    /// A sentence about a topic with messages sent but not yet received, or `None`. Looks only at topics of the loop, which are all reliable here.
    fn in_transit(&self) -> Option<String> {
        let all = match self.reports() {
            Ok(all) => all,
            Err(missing) => return Some(missing),
        };
        let recorded: Vec<String> = loop_topics::ALL
            .iter()
            .map(|topic| full_name(&self.options.namespace, topic.name))
            .collect();
        for node in &all {
            for end in &node.list {
                if end.direction == Direction::Publisher || !recorded.contains(&end.topic) {
                    continue;
                }
                let sent: u64 = all
                    .iter()
                    .filter(|other| other.node != node.node)
                    .filter_map(|other| other.find(Direction::Publisher, &end.topic))
                    .map(|other| other.messages)
                    .sum();
                if end.messages < sent {
                    return Some(format!(
                        "{} has received {} of {sent} messages of {}",
                        node.node, end.messages, end.topic
                    ));
                }
            }
        }
        None
    }

    /// Total number of matches of the nodes and the launcher.
    fn matches(&self, own: &Connections) -> usize {
        let all = self.connections.values().chain([own]);
        all.flat_map(|node| &node.list)
            .map(|end| 1 + end.peers)
            .sum()
    }

    /// A sentence about a missing match, or `None` when all endpoints are matched.
    ///
    /// Every node must have reported. Every endpoint must be matched with all endpoints on its topic, the launcher's included.
    fn missing(&self, own: &Connections) -> Option<String> {
        if let Some(rival) = self.claim.rival() {
            return Some(format!("waiting for another dive, {rival}, to end"));
        }
        let mut all = match self.reports() {
            Ok(all) => all,
            Err(missing) => return Some(missing),
        };
        all.push(own);
        let others_with = |own: &str, direction: Direction, topic: &str| {
            all.iter()
                .filter(|other| other.node != own && other.find(direction, topic).is_some())
                .count()
        };
        for node in &all {
            for end in &node.list {
                let (others, what) = match end.direction {
                    Direction::Publisher => (Direction::Subscription, "readers"),
                    Direction::Subscription => (Direction::Publisher, "writers"),
                };
                let expected = others_with(&node.node, others, &end.topic);
                if end.peers < expected {
                    return Some(format!(
                        "{}: {} of {expected} {what} of {}",
                        node.node, end.peers, end.topic
                    ));
                }
            }
        }
        None
    }
}

/// History of a quantity, as a sparkline for one line of the terminal.
#[derive(Default)]
struct History {
    /// Ticks per column.
    ticks: u64,
    /// Index of the last column, and the columns' values; at most the last [`History::COLUMNS`] of them.
    column: u64,
    values: VecDeque<f64>,
}

impl History {
    const COLUMNS: u64 = 44;

    /// A history of the whole scenario; for a flight without end, of the last seconds with one column per second.
    fn of(scenario: &Scenario, endless: bool) -> Self {
        let ticks = match endless {
            true => (1.0 / scenario.tick).round() as u64,
            false => scenario.ticks().div_ceil(Self::COLUMNS),
        };
        Self {
            ticks: ticks.max(1),
            ..Self::default()
        }
    }

    /// Adds the value at a tick.
    fn take(&mut self, tick: u64, value: f64) {
        let column = tick / self.ticks;
        if column == self.column {
            self.values.pop_back();
        }
        self.column = column;
        self.values.push_back(value);
        if self.values.len() as u64 > Self::COLUMNS {
            self.values.pop_front();
        }
    }

    /// Name, sparkline and range; with `sign` -1 larger values are drawn lower.
    fn line(&self, name: &str, sign: f64, unit: &str) -> String {
        let course: Vec<f64> = self.values.iter().map(|value| sign * value).collect();
        let (low, high) = self
            .values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
        format!(
            "{name:<6} {} {low:.2} to {high:.2} {unit}",
            sparkline(&course)
        )
    }
}

/// Progress line with the state; above it, if the flight has an end, a bar with the remaining time.
fn bar(ticks: u64, keep_running: bool) -> ProgressBar {
    let bar = ProgressBar::new(ticks);
    let template = match keep_running {
        true => "{msg}",
        false => "{bar:30} {percent:>3} %, {eta} left\n{msg}",
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_history_of_any_length_is_a_line_of_the_terminal_and_depth_goes_down() {
        let scenario = Scenario::parse("description: long\nduration: 500.0\n").expect("a scenario");
        let mut history = History::of(&scenario, false);
        for tick in 1..=scenario.ticks() {
            history.take(tick, tick as f64 * 1e-4);
        }
        let line = history.line("depth", -1.0, "m");
        assert!(line.chars().count() <= 80, "{line}");
        assert!(line.starts_with("depth  █") && line.contains('▁'), "{line}");
        assert!(line.ends_with("to 1.00 m"), "{line}");
    }
}
