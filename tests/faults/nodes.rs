//! What becomes of a flight when one of its processes is stopped, killed, frozen, comes back, or is there twice.

use std::path::Path;
use std::time::Duration;

use libtest_mimic::Trial;

use super::crew::Crew;
use super::evidence::{self, stamp};
use super::pace::{PACES, Pace};
use super::stage::{Process, Signal, Stage, kill, scenario};
use super::trial;

/// What happens to a process.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    Terminate,
    Kill,
    /// Stopped and continued, as by a debugger or `docker pause`, for so long.
    Freeze(Duration),
    /// Killed and started again.
    Restart,
    /// Started once more.
    Twin,
}

/// What is to become of the flight.
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
    ("freeze_10_ms", Fault::Freeze(Duration::from_millis(10))),
    ("freeze_3_s", Fault::Freeze(Duration::from_secs(3))),
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

/// Those that every run of the tests tries.
const ALWAYS: [&str; 0] = [];

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
    trials
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
        let flight = Dive::in_flight(&stage, self.pace, Length::Endless);
        let nodes = flight.launcher.nodes();
        self.strike(&flight);
        let outcome = flight.launcher.finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        assert!(!outcome.stdout.contains("Flew "), "{outcome:#?}");
        let told = format!("the node {} stopped by itself", self.who);
        assert!(outcome.complaints()[0].contains(&told), "{outcome:#?}");
        evidence::nobody_is_left(&nodes);
        let bag = Path::new(&flight.out).join("bag");
        // Who is killed cannot close what it writes.
        let is_closed = self.who != "recorder" || self.fault != Fault::Kill;
        assert_eq!(evidence::is_whole(&bag), is_closed);
        self.check(&bag, 1);
    }

    fn is_interrupted(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace, Length::Endless);
        let nodes = flight.launcher.nodes();
        self.strike(&flight);
        let out = flight.out.clone();
        let outcome = flight.launcher.finish();
        assert!(outcome.stdout.contains("Interrupted after"), "{outcome:#?}");
        evidence::ends_and_says_what_it_lost(&outcome, Path::new(&out));
        evidence::nobody_is_left(&nodes);
        self.check(&Path::new(&out).join("bag"), 1);
    }

    fn is_abandoned(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace, Length::Endless);
        let nodes = flight.launcher.nodes();
        self.strike(&flight);
        let out = flight.out.clone();
        assert!(!flight.launcher.finish().status.success());
        evidence::nobody_is_left(&nodes);
        let bag = Path::new(&out).join("bag");
        assert!(evidence::is_whole(&bag));
        self.check(&bag, 1);
    }

    fn goes_on(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace, Length::Finite);
        let nodes = flight.launcher.nodes();
        let twin = match self.fault {
            Fault::Twin => Some(self.twin(&stage, &flight)),
            _ => {
                self.strike(&flight);
                None
            }
        };
        let out = flight.out.clone();
        self.comes_to_its_end(flight.launcher, &out);
        evidence::nobody_is_left(&nodes);
        if let Some(twin) = twin {
            twin.signal(Signal::TERM);
            twin.finish().success();
        }
    }

    /// The launcher ends well, and its bag shows a loop that was closed to the end.
    fn comes_to_its_end(self, launcher: Process, out: &str) {
        let outcome = launcher.finish();
        evidence::ends_and_says_what_it_lost(&outcome, Path::new(out));
        assert!(outcome.stdout.contains("Flew "), "{outcome:#?}");
        let ticks = (self.pace.duration() / 0.05).round() as usize;
        self.check(&Path::new(out).join("bag"), ticks);
    }

    /// The flight reached at least so many ticks, and at its end everybody took part.
    fn check(self, bag: &Path, least: usize) {
        let flight = evidence::flight(bag);
        let ticks = match self.pace {
            Pace::Lockstep => evidence::each_tick_is_there(&flight),
            Pace::Real(_) => flight.states.len(),
        };
        assert!(ticks >= least, "{ticks} of {least} ticks");
        if least > 1 {
            evidence::the_loop_is_closed_at_the_end(&flight);
        }
    }

    fn resumes(self) {
        let stage = Stage::new();
        // No flight ends before all is seen.
        let mut crew = Crew::start(&stage, self.pace, 1_000_000, Default::default());
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
        let flight = Dive::in_flight(&stage, self.pace, Length::Endless);
        flight.launcher.kill();
        let (launcher, out) = Dive::start(&stage, self.pace, Length::Finite, "again");
        self.comes_to_its_end(launcher, &out);
    }

    fn second_is_refused(self) {
        let stage = Stage::new();
        let flight = Dive::in_flight(&stage, self.pace, Length::Finite);
        let second = if self.who == LAUNCHER {
            Dive::start(&stage, self.pace, Length::Finite, "second").0
        } else {
            self.twin(&stage, &flight)
        };
        let out = flight.out.clone();
        self.comes_to_its_end(flight.launcher, &out);
        // It needs no asking to end.
        let outcome = second.finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        assert!(outcome.stderr.contains("already"), "{outcome:#?}");
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
        stage.start_as(&arguments, &[(planesman::crew::LAUNCHED, "1")])
    }

    /// Does to the process what is to happen to it.
    fn strike(self, flight: &Dive) {
        let pid = match self.who {
            LAUNCHER => flight.launcher.pid(),
            node => flight.launcher.nodes()[node],
        };
        let signal = |signal| rustix::process::kill_process(pid, signal).unwrap();
        match self.fault {
            Fault::Terminate => signal(Signal::TERM),
            Fault::Kill => kill(pid),
            Fault::Freeze(time) => {
                signal(Signal::STOP);
                std::thread::sleep(time);
                signal(Signal::CONT);
            }
            Fault::Restart | Fault::Twin => unreachable!("not done to a process"),
        }
    }
}

enum Length {
    /// Until the test ends it.
    Endless,
    Finite,
}

/// A flight with a launcher.
struct Dive {
    launcher: Process,
    out: String,
}

impl Dive {
    fn start(stage: &Stage, pace: Pace, length: Length, name: &str) -> (Process, String) {
        let duration = match length {
            Length::Endless => 3600.0,
            Length::Finite => pace.duration(),
        };
        let parameters = "  recorder: {flush_interval: 0.1}\n  sysid: {start: 2.0}\n  \
             depth_controller: {depth_setpoint: 0.9144, identification: {signal: prbs, amplitude: 0.0349, period: 1.0}}\n";
        let file = stage.file(&format!("{name}.yaml"), scenario(duration, parameters));
        let out = stage.path(name);
        let mut arguments = vec!["dive".to_owned(), file, "--out".to_owned(), out.clone()];
        arguments.extend(pace.arguments());
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        (stage.start(&arguments), out)
    }

    /// One that has left its first ticks behind.
    fn in_flight(stage: &Stage, pace: Pace, length: Length) -> Self {
        let (launcher, out) = Self::start(stage, pace, length, "flight");
        let operator = stage.operator();
        let first = operator.state("the first state", |_| true);
        let early = stamp(&first) + pace.early() * evidence::TICK;
        operator.state("a flight", |state| stamp(state) >= early);
        Self { launcher, out }
    }
}
