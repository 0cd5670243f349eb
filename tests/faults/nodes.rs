//! Flights in which one process is stopped, killed, frozen, restarted or duplicated.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use libtest_mimic::Trial;
use planesman_node::{Direction, Next};
use rustix::process::Pid;

use super::crew::Crew;
use super::evidence::{self, Flight, Part, stamp};
use super::pace::{PACES, Pace};
use super::stage::{Operator, Process, Received, Signal, Stage, eventually, kill, scenario};
use super::trial;

/// The fault of a process.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    Terminate,
    Kill,
    /// Stopped and continued, as by a debugger or `docker pause`, for so long.
    Stop(Duration),
    /// Killed and started again.
    Restart,
    /// Started once more.
    Twin,
}

/// The expected outcome of the flight.
#[derive(Clone, Copy, Debug)]
enum Fate {
    /// The launcher stops all nodes and says who left.
    GivenUp,
    /// The launcher stops it in good order.
    Interrupted,
    /// Without a launcher the nodes end; the bag is closed.
    Abandoned,
    /// It comes to its end.
    GoesOn,
    /// The loop goes on with the one that came back.
    Resumes,
    /// Another flight in the same place comes to its end.
    FliesAgain,
    /// Who comes second is refused; the first flight comes to its end.
    SecondRefused,
}

const FAULTS: [(&str, Fault); 6] = [
    ("terminate", Fault::Terminate),
    ("kill", Fault::Kill),
    ("stopped_10_ms", Fault::Stop(Duration::from_millis(10))),
    ("stopped_3_s", Fault::Stop(Duration::from_secs(3))),
    ("restart", Fault::Restart),
    ("twin", Fault::Twin),
];

const LAUNCHER: &str = "launcher";

/// Who, and the fate for each of [`FAULTS`].
#[rustfmt::skip]
const FATES: [(&str, [Fate; 6]); 6] = {
    use Fate::{Abandoned, FliesAgain, GivenUp, GoesOn, Interrupted, Resumes, SecondRefused};
    [
        ("plant_sim",        [GivenUp,     GivenUp,   GoesOn, GoesOn, Resumes,    SecondRefused]),
        ("depth_controller", [GivenUp,     GivenUp,   GoesOn, GoesOn, Resumes,    GoesOn]),
        ("dha_actuator",     [GivenUp,     GivenUp,   GoesOn, GoesOn, Resumes,    GoesOn]),
        ("sysid",            [GivenUp,     GivenUp,   GoesOn, GoesOn, Resumes,    GoesOn]),
        ("recorder",         [GivenUp,     GivenUp,   GoesOn, GoesOn, Resumes,    GoesOn]),
        (LAUNCHER,           [Interrupted, Abandoned, GoesOn, GoesOn, FliesAgain, SecondRefused]),
    ]
};

/// Those that every run of the tests tries: each process, each fault, each pace.
pub(crate) const ALWAYS: [&str; 20] = [
    "nodes/plant_sim/terminate/factor_10",
    "nodes/plant_sim/stopped_10_ms/factor_1",
    "nodes/plant_sim/restart/lockstep",
    "nodes/plant_sim/twin/lockstep",
    "nodes/depth_controller/kill/lockstep",
    "nodes/depth_controller/stopped_3_s/lockstep",
    "nodes/depth_controller/restart/factor_10",
    "nodes/dha_actuator/stopped_10_ms/factor_10",
    "nodes/dha_actuator/restart/factor_1",
    "nodes/dha_actuator/twin/lockstep",
    "nodes/sysid/stopped_3_s/lockstep",
    "nodes/sysid/restart/lockstep",
    "nodes/recorder/kill/factor_1",
    "nodes/recorder/stopped_3_s/factor_10",
    "nodes/recorder/restart/lockstep",
    "nodes/launcher/terminate/lockstep",
    "nodes/launcher/kill/factor_10",
    "nodes/launcher/stopped_3_s/factor_1",
    "nodes/launcher/restart/lockstep",
    "nodes/launcher/at_once/lockstep",
];

/// One of the table's cells.
#[derive(Clone, Copy)]
struct Cell {
    who: &'static str,
    fault: Fault,
    pace: Pace,
}

pub(crate) fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (who, fates) in FATES {
        for ((name, fault), fate) in FAULTS.into_iter().zip(fates) {
            for pace in PACES {
                let cell = Cell { who, fault, pace };
                let name = format!("nodes/{who}/{name}/{}", pace.name());
                let always = ALWAYS.contains(&name.as_str());
                trials.push(trial(name, always, move || cell.run(fate)));
            }
        }
    }
    for pace in PACES {
        let name = format!("nodes/{LAUNCHER}/at_once/{}", pace.name());
        let always = ALWAYS.contains(&name.as_str());
        trials.push(trial(name, always, move || two_at_once(pace)));
    }
    trials
}

/// Of two flights begun at the same moment in the same place one comes to its end, and the other is refused.
fn two_at_once(pace: Pace) {
    let stage = Stage::new();
    let dives = ["one", "other"].map(|name| Dive::start(&stage, pace, pace.duration(), name));
    let mut flown = 0;
    for (launcher, out) in dives {
        let outcome = launcher.finish();
        if outcome.status.code() == Some(1) {
            assert!(outcome.stderr.contains("another dive"), "{outcome:#?}");
        } else {
            evidence::ends_and_says_what_it_lost(&outcome, Path::new(&out));
            let flight = evidence::whole_flight(&bag(&out));
            if pace == Pace::Lockstep {
                evidence::each_tick_is_there(&flight);
            }
            assert_eq!(Part::of(&flight, 0), Part::ALL);
            flown += 1;
        }
    }
    assert_eq!(flown, 1);
}

impl Cell {
    fn run(self, fate: Fate) {
        match fate {
            Fate::GivenUp => self.is_given_up(),
            Fate::Interrupted => self.is_interrupted(),
            Fate::Abandoned => self.is_abandoned(),
            Fate::GoesOn => self.goes_on(),
            Fate::Resumes => self.resumes(),
            Fate::FliesAgain => self.flies_again(),
            Fate::SecondRefused => self.second_is_refused(),
        }
    }

    fn is_given_up(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace);
        self.strike(&flight);
        let outcome = flight.launcher.finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        assert!(!outcome.stdout.contains("Flew "), "{outcome:#?}");
        let expected = format!("the node {} stopped by itself", self.who);
        assert!(outcome.complaints()[0].contains(&expected), "{outcome:#?}");
        evidence::nobody_is_left(&flight.nodes);
        // Who is killed cannot close what it writes.
        let is_closed = self.who != "recorder" || self.fault != Fault::Kill;
        assert_eq!(evidence::is_whole(&bag(&flight.out)), is_closed);
        self.check(&bag(&flight.out));
    }

    fn is_interrupted(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace);
        self.strike(&flight);
        let out = flight.ends_interrupted();
        self.check(&bag(&out));
    }

    fn is_abandoned(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace);
        self.strike(&flight);
        assert!(!flight.launcher.finish().status.success());
        evidence::nobody_is_left(&flight.nodes);
        assert!(evidence::is_whole(&bag(&flight.out)));
        self.check(&bag(&flight.out));
    }

    fn goes_on(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace);
        let twin = match self.fault {
            Fault::Twin => {
                let before = flight.participants();
                let twin = self.twin(&stage, &flight);
                eventually("the twin", || {
                    (flight.participants() > before).then_some(())
                });
                Some(twin)
            }
            _ => {
                self.strike(&flight);
                None
            }
        };
        self.flies_on(flight);
        if let Some(twin) = twin {
            twin.signal(Signal::TERM);
            twin.finish().success();
        }
    }

    /// Everybody takes part again, and the bag shows it.
    fn flies_on(self, flight: Dive) {
        let since = flight.everybody_takes_part();
        flight.launcher.signal(Signal::TERM);
        let out = flight.ends_interrupted();
        let flown = self.check(&bag(&out));
        assert_eq!(Part::of(&flown, since), Part::ALL);
    }

    /// The flight is readable, within the envelope, and in lockstep complete.
    fn check(self, bag: &Path) -> Flight {
        let flight = evidence::flight(bag);
        assert!(!flight.states.is_empty());
        if self.pace == Pace::Lockstep {
            evidence::each_tick_is_there(&flight);
        }
        flight
    }

    fn resumes(self) {
        let stage = Stage::new();
        let mut crew = Crew::start(&stage, self.pace, BTreeMap::new());
        let early = self.pace.early() as u64;
        crew.wait_for("state", early);
        crew.kill(self.who);
        crew.join(self.who);
        let topic = match self.who {
            "depth_controller" => "plane_command",
            "dha_actuator" => "plane_motion",
            "sysid" if self.pace == Pace::Lockstep => "tick_answer",
            "sysid" => "model",
            _ => "state",
        };
        // What was on its way when it died counts for nothing.
        let before = crew.recorded(topic);
        let after = if topic == "model" { 10 } else { 2 * early };
        crew.wait_for(topic, before + after);
        let bags = crew.stop();
        if self.pace == Pace::Lockstep && self.who != "plant_sim" {
            let mut flown = evidence::flight(&bags[0]);
            for bag in &bags[1..] {
                flown.states.extend(evidence::flight(bag).states);
            }
            evidence::each_tick_is_there(&flown);
        }
    }

    fn flies_again(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace);
        flight.launcher.kill();
        let (launcher, out) = Dive::start(&stage, self.pace, self.pace.duration(), "again");
        let outcome = launcher.finish();
        evidence::ends_and_says_what_it_lost(&outcome, Path::new(&out));
        assert_eq!(Part::of(&self.check(&bag(&out)), 0), Part::ALL);
    }

    fn second_is_refused(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace);
        let second = if self.who == LAUNCHER {
            Dive::start(&stage, self.pace, ENDLESS, "second").0
        } else {
            self.twin(&stage, &flight)
        };
        // It needs no asking to end.
        let outcome = second.finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        let holder = format!("process {}", self.pid(&flight).as_raw_nonzero());
        assert!(outcome.stderr.contains(&holder), "{holder}: {outcome:#?}");
        self.flies_on(flight);
    }

    /// The node once more, started as the launcher starts it, but let go.
    fn twin(self, stage: &Stage, flight: &Dive) -> Process {
        let parameters = format!("{}/parameters.yaml", flight.out);
        let mut arguments = vec![
            "node",
            self.who,
            "--ros-args",
            "-r",
            "__ns:=/auv",
            "--params-file",
            &parameters,
        ];
        let own = match self.who {
            "plant_sim" => "start_paused:=false".to_owned(),
            "recorder" => format!("output:={}", stage.path("twin")),
            _ => "use_sim_time:=".to_owned() + &self.pace.owns_time().to_string(),
        };
        arguments.extend(["-p", &own]);
        stage.start_as(&arguments, &[(planesman::nodes::LAUNCHED, "1")])
    }

    /// The process that it happens to.
    fn pid(self, flight: &Dive) -> Pid {
        match self.who {
            LAUNCHER => flight.launcher.pid(),
            node => flight.nodes[node],
        }
    }

    /// Does to the process what is to happen to it.
    fn strike(self, flight: &Dive) {
        let pid = self.pid(flight);
        let signal = |signal| rustix::process::kill_process(pid, signal).unwrap();
        match self.fault {
            Fault::Terminate => signal(Signal::TERM),
            Fault::Kill => kill(pid),
            Fault::Stop(time) => {
                signal(Signal::STOP);
                std::thread::sleep(time);
                signal(Signal::CONT);
            }
            Fault::Restart | Fault::Twin => unreachable!("not done to a process"),
        }
    }
}

/// Longer than any test, s.
const ENDLESS: f64 = 86_400.0;

fn bag(out: &str) -> PathBuf {
    Path::new(out).join("bag")
}

/// A flight with a launcher, and somebody who watches it.
struct Dive {
    launcher: Process,
    out: String,
    nodes: BTreeMap<String, Pid>,
    operator: Operator,
}

impl Dive {
    fn start(stage: &Stage, pace: Pace, duration: f64, name: &str) -> (Process, String) {
        // A busy machine is late with its answers; then they are flown late, and learnt from.
        let parameters = "  recorder: {flush_interval: 0.1}\n  sysid: {start: 0.0, break_on: ''}\n  \
             plant_sim: {delay_budget: 20}\n  \
             depth_controller: {identification: {signal: prbs, amplitude: 0.0349, period: 1.0}}\n";
        let file = stage.file(&format!("{name}.yaml"), scenario(duration, parameters));
        let out = stage.path(name);
        let arguments = ["dive", &file, "--verbose", "--out", &out];
        let mut arguments = arguments.map(str::to_owned).to_vec();
        arguments.extend(pace.arguments());
        if duration == ENDLESS {
            arguments.push("--keep-running".to_owned());
        }
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        (stage.start(&arguments), out)
    }

    /// One that has left its first ticks behind, and does not end by itself.
    fn in_flight(stage: &Stage, pace: Pace) -> Self {
        let (launcher, out) = Self::start(stage, pace, ENDLESS, "flight");
        let operator = stage.operator();
        let first = operator.state("the first state", |_| true);
        let early = stamp(&first) + pace.early() * evidence::TICK;
        operator.state("a flight", |state| stamp(state) >= early);
        let nodes = launcher.nodes();
        Self {
            launcher,
            out,
            nodes,
            operator,
        }
    }

    /// How many nodes the watcher knows.
    fn participants(&self) -> usize {
        self.operator.rt.next(Duration::ZERO);
        let connections = self.operator.rt.connections();
        let endpoint = connections.find(Direction::Subscription, "/diagnostics");
        endpoint.map_or(0, |end| end.peers)
    }

    /// Waits until everybody has taken part after the newest state that is on its way now, and returns its stamp.
    fn everybody_takes_part(&self) -> i64 {
        let mut since = stamp(&self.operator.state("a state", |_| true));
        while let Next::Event(received) = self.operator.rt.next(Duration::ZERO) {
            if let Received::State(state) = received {
                since = since.max(stamp(&state));
            }
        }
        let mut part = Part::default();
        self.operator.until("everybody's part", |received| {
            match received {
                Received::State(state) => part.see_state(&state, since),
                Received::Control(control) => part.see_control(&control, since),
                Received::Actuator(state) => part.see_actuator(&state, since),
                Received::Model(model) => part.see_model(&model, since),
                _ => {}
            }
            (part == Part::ALL).then_some(since)
        })
    }

    /// It ends as one who was asked to, and leaves nobody behind. Returns its folder.
    fn ends_interrupted(self) -> String {
        let outcome = self.launcher.finish();
        assert!(outcome.stdout.contains("Interrupted after"), "{outcome:#?}");
        // A launcher that hears its nodes has their reports.
        let deaf = outcome.stdout.contains("timeout: waiting for");
        assert!(!deaf, "{outcome:#?}");
        evidence::ends_and_says_what_it_lost(&outcome, Path::new(&self.out));
        evidence::nobody_is_left(&self.nodes);
        self.out
    }
}
