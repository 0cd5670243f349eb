//! `planesman dive`: a scenario run by separate processes over DDS.
//!
//! The launcher is a node itself: it reads all diagnostics until every node has discovered the
//! others, releases the vehicle, shows its progress, and stops the nodes in the order in which
//! no message is lost: publishers first, the recorder last.

use std::collections::{BTreeMap, VecDeque};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use planesman_console::progress::{ProgressBar, ProgressStyle};
use planesman_console::sparkline;
use planesman_control::gains::is_of_pitch;
use planesman_linear::pole_text;
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use planesman_msgs::loop_topics;
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, VehicleState};
use planesman_msgs::rcl_interfaces::srv::{GetParameters, GetParametersRequest};
use planesman_msgs::std_srvs::srv::{SetBool, SetBoolRequest, SetBoolResponse};
use planesman_node::claim::{Claim, Stage};
use planesman_node::{
    Client, Connections, Direction, Domain, Flow, Next, NodeSpec, Qos, Runtime, args, shutdown,
    value_of,
};
use planesman_parameters::{Value, Values};
use recorder::node::BAG;

use crate::processes::Processes;
use crate::run_folder::{Loss, RunFolder};
use planesman_console::print_wrapped;
use planesman_flight::model_summary::identified;
use planesman_flight::nodes::NODES;
use planesman_flight::scenario::{Scenario, difference};
use planesman_flight::sink::full_name;

/// Timeout of discovery without a new match, and of an answer.
const DISCOVERY_TIMEOUT: Duration = Duration::from_secs(30);
/// Time to detect another loop. A peer is found within 0.2 s, one that starts at the same moment as well.
const LISTEN_TIME: Duration = Duration::from_millis(500);
/// Time until killed nodes are forgotten: their lease of 5 s, with a margin.
const LEASE_TIME: Duration = Duration::from_secs(7);
/// Timeout for the last messages to arrive.
const DRAIN_TIMEOUT: Duration = Duration::from_secs(10);
/// Timeout for the vehicle to confirm its stop.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);
/// The same two timeouts after an interrupt.
const INTERRUPT_TIMEOUT: Duration = Duration::from_secs(5);

/// The end of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// When every member has answered.
    Lockstep,
    /// By the wall clock.
    Real {
        /// The real-time factor.
        factor: f64,
        /// Stamps from 0, `/clock` published.
        sim_time: bool,
    },
}

impl Pace {
    /// Whether the vehicle makes `/clock`.
    fn owns_time(self) -> bool {
        match self {
            Self::Lockstep => true,
            Self::Real { sim_time, .. } => sim_time,
        }
    }
}

/// How a dive is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The end of a tick.
    pub pace: Pace,
    /// Keep the loop running until Ctrl-C.
    pub keep_running: bool,
    /// Show the dive on a page in the browser.
    pub watch: bool,
    /// The namespace of all nodes.
    pub namespace: String,
}

/// Runs `scenario` into `run` and prints the summary. Returns the published messages that the bag lacks.
///
/// # Errors
/// When a node cannot start, does not find the others, or fails in flight.
pub fn run(scenario: &Scenario, run: &RunFolder, options: &Options) -> Result<Option<Loss>> {
    let extra = extra(run, options);
    launcher_decides(scenario, &extra)?;
    let parameters =
        scenario.parameter_file(&options.namespace, &extra, options.pace.owns_time())?;
    let namespace = format!("__ns:={}", options.namespace);
    let (rt, ()) = Runtime::start(
        NodeSpec {
            name: "planesman",
            namespace: "/auv",
            validate: |(): &()| Ok(()),
            on_parameters: |_| Event::Poll,
        },
        args::only(["--ros-args", "-r", &namespace, "--log-level", "warn"].map(str::to_owned))?,
    )?;
    // Nobody else ends the dive by telling of its nodes.
    let own = NODES.map(|node| full_name(&options.namespace, node));
    let vehicle = vec![full_name(&options.namespace, "plant_sim")];
    rt.subscribe_to_speakers(
        "/diagnostics",
        Qos::reliable(1000),
        move |array: &DiagnosticArray| {
            let is_told = |node: &&String| {
                let mut told = array.status.iter().map(|it| it.name.split_once(": "));
                told.any(|it| it.is_some_and(|(name, _)| name == node.as_str()))
            };
            own.iter().filter(is_told).cloned().collect()
        },
        Event::Diagnostics,
    )?;
    rt.subscribe_to_speakers(
        "state",
        Qos::reliable(1000),
        move |_: &VehicleState| vehicle.clone(),
        Event::State,
    )?;
    rt.subscribe("model", Qos::reliable(1000).of_one_publisher(), |model| {
        Event::Model(Box::new(model))
    })?;
    let go = rt.client::<SetBool>("plant_sim/pause")?;
    let parameters_of = |node: &'static str| {
        Ok(LaunchedNode {
            node,
            parameters: scenario.launched_values(node, &extra)?,
            get: rt.client(&format!("{node}/get_parameters"))?,
        })
    };
    let launched = NODES.into_iter().map(parameters_of);
    let launched = launched.collect::<Result<Vec<_>>>()?;
    print_wrapped(format_args!("{}\n", scenario.description()))?;
    let claim = claim_namespace(&rt, options)?;
    // All that can be refused has been: now there is something to keep.
    run.create(scenario, &parameters)?;
    if options.keep_running {
        planesman_console::out!(
            "{}",
            other_terminal(Domain::from_environment()?, &options.namespace)
        )?;
    }
    fly(rt, go, launched, claim, scenario, run, options)
        .inspect_err(|error| run.note_failure(error))
}

/// Starts the nodes and flies them to the end.
fn fly(
    rt: Runtime<Event>,
    go: Client<SetBool>,
    launched: Vec<LaunchedNode>,
    claim: Claim,
    scenario: &Scenario,
    run: &RunFolder,
    options: &Options,
) -> Result<Option<Loss>> {
    let mut processes = Processes::start(run, &options.namespace, &NODES)?;
    if options.watch {
        processes.show()?;
    }
    drop(rt.every(Duration::from_millis(20), || Event::Poll));
    let mut launcher = Launcher {
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
    };
    let flown = launcher.command(&rt);
    launcher.bar.finish_and_clear();
    let flown = flown.and(rt.shutdown().map_err(Into::into));
    let stopped = launcher.processes.stop();
    // The bag is closed. A report can be made again, with `planesman report`.
    shutdown::at_once();
    if let Err(error) = flown.and(stopped).and_then(|()| launcher.check_flown()) {
        // What was flown is worth a report; that it cannot be made must not hide the error.
        if launcher.ticks > 0
            && let Ok(report) = run.report(scenario.clone())
        {
            print_wrapped(format_args!("{report}\n"))?;
        }
        return Err(error);
    }
    if launcher.interrupted {
        planesman_console::out!(
            "Interrupted after {} ticks; the bag is closed.",
            launcher.ticks
        )?;
    } else {
        planesman_console::out!(
            "Flew {:.1} s of vehicle time in {:.1} s, {} processes over DDS.\n",
            launcher.ticks as f64 * scenario.tick,
            launcher.flown.as_secs_f64(),
            NODES.len() + 1,
        )?;
    }
    print_wrapped(format_args!("{}\n", run.report(scenario.clone())?))?;
    run.loss(scenario)
}

/// What to paste into another terminal to look into the loop.
fn other_terminal(domain: Domain, namespace: &str) -> String {
    let range = if domain.local { "LOCALHOST" } else { "SUBNET" };
    let namespace = namespace.trim_end_matches('/');
    format!(
        "In another terminal (Ctrl-C here ends the loop):\n\
         \x20 export ROS_DOMAIN_ID={} ROS_AUTOMATIC_DISCOVERY_RANGE={range}\n\
         \x20 ros2 topic list\n\
         \x20 ros2 topic echo {namespace}/state\n\
         \x20 planesman watch\n",
        domain.id
    )
}

/// Waits until no other loop runs in the namespace, whose vehicle the nodes would answer. Returns the claim to it.
fn claim_namespace(rt: &Runtime<Event>, options: &Options) -> Result<Claim> {
    // Who launches calls the vehicle's service.
    let evidence = format!("rq{}/plant_sim/pauseRequest", options.namespace);
    let claim = rt.claim(&format!("launch {}", options.namespace), &evidence)?;
    find_no_other_loop(rt, || yield_to_other_dive(&claim, options))?;
    claim.advance_to(Stage::Held);
    Ok(claim)
}

/// Listens for publishers of the topics that the node reads, beside everybody's diagnostics, and runs `check` meanwhile.
///
/// # Errors
/// Another loop runs, `check` fails, or the process is asked to stop.
pub(crate) fn find_no_other_loop<E: 'static>(
    rt: &Runtime<E>,
    check: impl Fn() -> Result<()>,
) -> Result<()> {
    let began = Instant::now();
    loop {
        if matches!(rt.next(Duration::from_millis(50)), Next::Stop) {
            bail!("interrupted");
        }
        check()?;
        let connections = rt.connections();
        let taken = connections.list.iter().find(|end| {
            end.direction == Direction::Subscription && end.topic != "/diagnostics" && end.peers > 0
        });
        match taken {
            None if began.elapsed() > LISTEN_TIME => return Ok(()),
            Some(end) if began.elapsed() > LEASE_TIME => bail!(
                "{} has a publisher already: is another loop running? Stop it, or choose \
                 another ROS_DOMAIN_ID or --namespace",
                end.topic
            ),
            _ => {}
        }
    }
}

/// Ends this dive if another one holds the claim; of several at once exactly one continues.
fn yield_to_other_dive(claim: &Claim, options: &Options) -> Result<()> {
    if let Some(holder) = claim.holder() {
        bail!(
            "another dive, {holder}, runs in namespace {}; wait for its end, or choose another ROS_DOMAIN_ID or \
             --namespace",
            options.namespace
        );
    }
    Ok(())
}

/// The parameters that the launcher sets.
fn extra(run: &RunFolder, options: &Options) -> Vec<(&'static str, &'static str, Value)> {
    let lockstep = options.pace == Pace::Lockstep;
    let mut extra: Vec<(&str, &str, Value)> = vec![
        (
            "recorder",
            "output",
            run.bag().to_string_lossy().as_ref().into(),
        ),
        ("recorder", "answer", lockstep.into()),
        ("sysid", "answer", lockstep.into()),
        ("dha_actuator", "lockstep", lockstep.into()),
        ("depth_controller", "lockstep", lockstep.into()),
        ("recorder", "reliable_sensors", true.into()),
        ("plant_sim", "reliable_sensors", true.into()),
        ("plant_sim", "start_paused", true.into()),
    ];
    match options.pace {
        Pace::Lockstep => {
            extra.push(("plant_sim", "time", "lockstep".into()));
            let members: &[&str] = &["sysid", "recorder"];
            extra.push(("plant_sim", "lockstep.members", members.into()));
        }
        Pace::Real { factor, sim_time } => {
            extra.push(("plant_sim", "time", "real".into()));
            extra.push(("plant_sim", "factor", factor.into()));
            extra.push(("plant_sim", "sim_time", sim_time.into()));
        }
    }
    if options.keep_running {
        extra.push(("plant_sim", "duration", 0.0.into()));
    }
    extra
}

/// Refuses a scenario that gives a parameter of the launcher's another value: it would be lost.
fn launcher_decides(scenario: &Scenario, extra: &[(&str, &str, Value)]) -> Result<()> {
    let of_pace = ["time", "factor", "sim_time"].map(|name| ("plant_sim", name));
    for (node, name) in extra.iter().map(|it| (it.0, it.1)).chain(of_pace) {
        let decided = extra.iter().find(|it| (it.0, it.1) == (node, name));
        let given = scenario.given(node, name);
        if given.is_some_and(|given| decided.is_none_or(|it| it.2 != *given)) {
            bail!(
                "{node}.{name} follows from the options of `planesman dive` (--sim-time, --factor, --lockstep, --out): leave it \
                 out of the scenario"
            );
        }
    }
    Ok(())
}

/// A node as it is to be launched.
struct LaunchedNode {
    node: &'static str,
    parameters: Values,
    get: Client<GetParameters>,
}

impl LaunchedNode {
    /// Asks the running node for its parameters.
    ///
    /// # Errors
    /// No answer, or a parameter with another value than the flight is to have.
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
                "the running node does not have the parameters of the flight: {}.{difference}",
                self.node
            ),
        }
    }
}

enum Event {
    Diagnostics(DiagnosticArray),
    State(VehicleState),
    Model(Box<ModelEstimate>),
    /// Whether every node has the parameters of the flight.
    Compared(Result<()>),
    /// The vehicle's answer to its release.
    Going(Result<SetBoolResponse, planesman_node::Error>),
    /// Its answer to the stop.
    Stopped(Result<SetBoolResponse, planesman_node::Error>),
    Poll,
}

enum Phase {
    /// Waiting until all have discovered each other: the largest number of matches, and its time.
    Discovering { matches: usize, since: Instant },
    /// All have; their parameters are compared with the flight's.
    Comparing,
    /// The vehicle was released.
    Flying,
    /// It was asked to stop.
    Stopping,
    /// It has stopped, at this time; the last messages are in transit.
    Draining(Instant),
}

struct Launcher {
    scenario: Scenario,
    options: Options,
    processes: Processes,
    go: Client<SetBool>,
    launched: Vec<LaunchedNode>,
    claim: Claim,
    phase: Phase,
    /// The endpoints of each node.
    connections: BTreeMap<String, Connections>,
    bar: ProgressBar,
    /// The depth (m) and the plane angle (deg) so far.
    depth: History,
    planes: History,
    /// The first and the last state's stamp, ns.
    first: Option<i64>,
    last: Option<i64>,
    ticks: u64,
    /// Whether the vehicle says that it is done.
    done: bool,
    pole: String,
    /// When the vehicle was released.
    began: Instant,
    /// From there to its last state.
    flown: Duration,
    /// How the vehicle last said it is: level and message.
    vehicle: (u8, String),
    /// Whether the dive was interrupted.
    interrupted: bool,
    /// Whether another dive was discovered in flight.
    rival_seen: bool,
}

impl Launcher {
    /// Handles events until the dive ends. A first interrupt ends it in order, a second one at once.
    fn command(&mut self, rt: &Runtime<Event>) -> Result<()> {
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
                    bail!("the recorder has stopped: {trouble}");
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
                    "WARNING: plant_sim does not pause ({reason}); all nodes are sent SIGTERM, the recorder last"
                ));
                return Ok(Flow::Stop);
            }
            Event::Poll => return self.poll(rt),
        }
        Ok(Flow::Continue)
    }

    /// Remembers how the vehicle is, and prints it once it has waited for `answer_timeout`.
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
    /// When fewer ticks were flown than the scenario asks for.
    fn check_flown(&self) -> Result<()> {
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

    /// The reason why recording stopped. The recorder's log may be on the full disk.
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

    /// Whether the dive is over, by what has come of the vehicle's states or by its own word.
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
                    "WARNING: another dive, {rival}, flies in namespace {} too: each vehicle stays with its own nodes, but services and setpoints reach both; stop one",
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
                "the nodes do not discover each other, no new match for {} s: {missing}",
                DISCOVERY_TIMEOUT.as_secs()
            );
        }
        self.bar.set_message(missing);
        Ok(())
    }

    fn release(&mut self, rt: &Runtime<Event>) {
        self.claim.advance_to(Stage::Used);
        self.print_line("all nodes have discovered each other; diving");
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

    /// The vehicle stands: what is in transit is waited for.
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

    /// The endpoints of every node, or the node whose report is missing.
    fn reports(&self) -> Result<Vec<&Connections>, String> {
        let of = |node: &&str| {
            self.connections
                .get(&full_name(&self.options.namespace, node))
                .ok_or_else(|| format!("waiting for {node}"))
        };
        NODES.iter().map(of).collect()
    }

    /// A topic with messages sent but not yet received, `None` without one. Only topics of the loop, which are
    /// all reliable here.
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
                        "{} has {} of {sent} messages of {}",
                        node.node, end.messages, end.topic
                    ));
                }
            }
        }
        None
    }

    /// The number of matches of the nodes and the launcher.
    fn matches(&self, own: &Connections) -> usize {
        let all = self.connections.values().chain([own]);
        all.flat_map(|node| &node.list)
            .map(|end| 1 + end.peers)
            .sum()
    }

    /// A match that is still missing, `None` when all endpoints are matched.
    ///
    /// Every node must have reported; every endpoint must be matched with as many others as all
    /// nodes together, this one included, have on its topic.
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

/// A quantity as it has been, small enough for a line of the terminal.
#[derive(Default)]
struct History {
    /// Ticks in a column.
    ticks: u64,
    /// The column of the last value, and the columns' values; of more than [`History::COLUMNS`] the last ones.
    column: u64,
    values: VecDeque<f64>,
}

impl History {
    const COLUMNS: u64 = 44;

    /// Over the whole scenario; of a flight without end the last seconds, one a column.
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

    /// Takes the value at a tick.
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

    /// Its name, its course and its range; with a sign of -1 larger values are drawn lower.
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

/// The state on one line, and above it, if the flight ends by itself, how much of it is left.
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

    #[test]
    fn the_lines_for_another_terminal_name_domain_range_and_topic() {
        let domain = Domain { id: 7, local: true };
        let lines = other_terminal(domain, "/second");
        for part in [
            "export ROS_DOMAIN_ID=7 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST",
            "ros2 topic echo /second/state",
            "planesman watch",
        ] {
            assert!(lines.contains(part), "{lines}");
        }
    }
}
