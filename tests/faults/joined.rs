//! Two machines that fly apart, the later one by a clock of 1972, whose link comes up in flight: each vehicle is flown to the
//! end of its dive by its own controller, and both dives tell.

use std::fs;
use std::path::{Path, PathBuf};

use libtest_mimic::Trial;
use planesman_bag::BagReader;

use super::evidence::{self, TICK, stamp};
use super::faked;
use super::link::Link;
use super::network::{self, ETHERNET, Network, Place};
use super::pace::Pace;
use super::stage::{LONG_WORK, Process, Stage, eventually, scenario};
use super::trial_where;

/// Ticks that a vehicle has flown before anything is done to it.
const BEFORE: u64 = 40;
/// How far from its target depth a vehicle is at the end, m.
const OFF: f64 = 0.15;

pub(crate) fn trials() -> Vec<Trial> {
    let trial = |pace: Pace, seconds, always| {
        trial_where(
            network::is_possible,
            format!("joined/{}", pace.name()),
            always,
            move || both_fly_on(pace, seconds),
        )
    };
    vec![
        trial(Pace::Lockstep, 400.0, true),
        // As at ten times real time, in as long.
        trial(Pace::Real(1), 30.0, false),
        trial(Pace::Real(10), 300.0, true),
    ]
}

/// A dive of one of the machines.
struct Machine {
    dive: Process,
    out: PathBuf,
    depth: f64,
}

impl Machine {
    /// Flying, to a depth of its own.
    fn start(
        stage: &Stage,
        place: &Place,
        pace: Pace,
        flight: (f64, f64),
        clock: &[(&str, &str)],
    ) -> Self {
        let (seconds, depth) = flight;
        let parameters = format!("  depth_controller: {{depth_setpoint: {depth}}}\n");
        let name = format!("dive_to_{depth}_m");
        let file = stage.file(&format!("{name}.yaml"), scenario(seconds, &parameters));
        let mut arguments = vec!["dive".to_owned(), file, "--out".to_owned(), name.clone()];
        arguments.extend(pace.arguments());
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        // In a namespace of its own a subnet has nobody else in it.
        let range = [("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")];
        let mut dive = stage.start_at(place, &arguments, &[&range[..], clock].concat());
        let out = PathBuf::from(stage.path(&name));
        eventually("a flight", || {
            assert!(dive.is_running(), "{}", dive.stderr());
            // Of a topic on which nobody has published yet the first publisher would be followed, whichever that is.
            (recorded(&out, "/auv/state") >= BEFORE && recorded(&out, "/auv/model") > 0)
                .then_some(())
        });
        Self { dive, out, depth }
    }

    /// It ends by itself, its vehicle where its own controller was to bring it, and has told of the other dive. In lockstep nothing is
    /// lost; by the clock a recorder whose receive buffer overflows on a busy computer loses messages, and the dive says how many.
    fn ends_by_itself(self, pace: Pace, seconds: f64) {
        let outcome = self.dive.finish_within(LONG_WORK);
        let lost = match pace {
            Pace::Lockstep => {
                assert_eq!(outcome.status.code(), Some(0), "{outcome:#?}");
                0
            }
            Pace::Real(_) => {
                let lost = evidence::ends_and_says_what_it_lost(&outcome, &self.out);
                lost.get("/auv/state").copied().unwrap_or(0)
            }
        };
        let told = "also flies in namespace /auv";
        assert!(outcome.stdout.contains(told), "{outcome:#?}");
        let log = fs::read_to_string(self.out.join("log/plant_sim.log")).unwrap();
        assert!(
            log.contains("another node publishes on this topic too"),
            "{log}"
        );

        let flight = evidence::whole_flight(&self.out.join("bag"));
        let ticks = match pace {
            Pace::Lockstep => evidence::each_tick_is_there(&flight),
            Pace::Real(_) => flight.states.len() + lost as usize,
        };
        assert!(
            lost as usize <= flight.states.len(),
            "{lost} states are lost: was the other dive recorded?"
        );
        assert_eq!(ticks as f64, (seconds * 1e9 / TICK as f64).round());
        let gap = |pair: &[_]| match pair {
            [one, other] => stamp(other) - stamp(one),
            _ => 0,
        };
        let longest = flight.states.windows(2).map(gap).max();
        let shortest = flight.states.windows(2).map(gap).min();
        println!(
            "{}: gaps of {shortest:?} to {longest:?} ns",
            self.out.display()
        );
        assert!(
            shortest >= Some(0),
            "a state of another clock: {shortest:?}"
        );
        let last = flight.states.last().unwrap();
        assert!((last.depth - self.depth).abs() < OFF, "{last:?}");
    }
}

/// Messages of a topic in a bag so far.
fn recorded(out: &Path, topic: &str) -> u64 {
    let Ok(bag) = BagReader::open(&out.join("bag")) else {
        return 0; // It is not begun yet.
    };
    let of_topic = bag.topics().iter().find(|it| it.topic.name == topic);
    of_topic.map_or(0, |it| it.messages)
}

fn both_fly_on(pace: Pace, seconds: f64) {
    let Some(library) = faked::library() else {
        return;
    };
    let stage = Stage::new();
    let mut network = Network::new(ETHERNET, 1);
    network.set(Link::CUT);
    let of_1972 = faked::variables(&stage, &library, "-20000d");
    let of_1972: Vec<(&str, &str)> = of_1972
        .iter()
        .map(|(name, value)| (*name, value.as_str()))
        .collect();
    // It flies alone first. In lockstep it flies for longer, so that it does not end before the other, which the faked clock slows down: a
    // lockstep dive may stand when the other one ends (docs/reliability.md).
    let first = match pace {
        Pace::Lockstep => 3.0 * seconds,
        Pace::Real(_) => seconds,
    };
    let near = Machine::start(&stage, &network.near(), pace, (first, 0.5), &[]);
    let far = Machine::start(&stage, &network.far(), pace, (seconds, 1.5), &of_1972);
    network.set(Link::GOOD);
    far.ends_by_itself(pace, seconds);
    near.ends_by_itself(pace, first);
}
