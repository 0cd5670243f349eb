//! The loop with one node behind a bad link.

use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use libtest_mimic::Trial;
use planesman_flight::nodes::NODES;
use planesman_msgs::planesman_msgs::msg::VehicleState;

use super::crew::Crew;
use super::evidence;
use super::link::Link;
use super::network::{self, ETHERNET, Network};
use super::pace::Pace;
use super::stage::Stage;
use super::trial_where;

/// The fault of the link during the flight.
#[derive(Clone, Copy)]
enum Trouble {
    /// It stays so to the end.
    Lasting(Link),
    /// It is so for a while (s), then good again.
    Passing(Link, f64),
    /// Packets longer than this many bytes have always gone in parts.
    Narrow(u16),
}

/// A node at the far end, and how time goes on: the loop stands still without it, or it flies on.
const FAR: [(&str, Pace); 3] = [
    ("sysid", Pace::Lockstep),
    ("depth_controller", Pace::Real(1)),
    ("dha_actuator", Pace::Real(1)),
];

const TO_FAR: Link = Link {
    cut_to_far: true,
    ..Link::GOOD
};
const TO_NEAR: Link = Link {
    cut_to_near: true,
    ..Link::GOOD
};

const TROUBLES: [(&str, Trouble); 13] = {
    use Trouble::{Lasting, Narrow, Passing};
    [
        (
            "loss_1",
            Lasting(Link {
                loss: 0.01,
                ..Link::GOOD
            }),
        ),
        (
            "loss_5",
            Lasting(Link {
                loss: 0.05,
                ..Link::GOOD
            }),
        ),
        (
            "loss_20",
            Lasting(Link {
                loss: 0.2,
                ..Link::GOOD
            }),
        ),
        (
            "delay_50_20_ms",
            Lasting(Link {
                delay: 0.05,
                jitter: 0.02,
                ..Link::GOOD
            }),
        ),
        (
            "reorder_25",
            Lasting(Link {
                reorder: 0.25,
                ..Link::GOOD
            }),
        ),
        (
            "duplicate_25",
            Lasting(Link {
                duplicate: 0.25,
                ..Link::GOOD
            }),
        ),
        ("mtu_576", Narrow(576)),
        ("cut_3_s", Passing(Link::CUT, 3.0)),
        ("cut_5_s", Passing(Link::CUT, 5.0)),
        ("cut_12_s", Passing(Link::CUT, 12.0)),
        ("cut_30_s", Passing(Link::CUT, 30.0)),
        ("cut_to_far_12_s", Passing(TO_FAR, 12.0)),
        ("cut_to_near_12_s", Passing(TO_NEAR, 12.0)),
    ]
};

/// Those that every run of the tests tries.
pub(crate) const ALWAYS: [&str; 5] = [
    "links/sysid/loss_5/lockstep",
    "links/sysid/cut_12_s/lockstep",
    "links/depth_controller/cut_to_near_12_s/factor_1",
    "links/dha_actuator/cut_5_s/factor_1",
    "links/dha_actuator/mtu_576/factor_1",
];

/// Ticks before the link turns bad, and after it is good again (or while it stays bad).
const BEFORE: u64 = 40;
const AFTER: u64 = 100;

pub(crate) fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (far, pace) in FAR {
        for (name, trouble) in TROUBLES {
            let name = format!("links/{far}/{name}/{}", pace.name());
            let always = ALWAYS.contains(&name.as_str());
            let place = name.clone();
            trials.push(trial_where(network::is_possible, name, always, move || {
                flies(&place, far, pace, trouble)
            }));
        }
    }
    trials
}

fn flies(name: &str, far: &'static str, pace: Pace, trouble: Trouble) {
    let mtu = match trouble {
        Trouble::Narrow(mtu) => mtu,
        _ => ETHERNET,
    };
    let stage = Stage::new();
    let mut network = Network::new(mtu, 1);
    let places = NODES.map(|node| match node == far {
        true => (node, network.far()),
        false => (node, network.near()),
    });
    let crew = Crew::start(&stage, pace, places.into_iter().collect());
    crew.wait_for("plane_command", BEFORE);

    let (now, counts) = match trouble {
        Trouble::Lasting(link) => (link, None),
        Trouble::Passing(link, seconds) => {
            network.set(link);
            sleep(Duration::from_secs_f64(seconds));
            (Link::GOOD, Some(network.counts()))
        }
        Trouble::Narrow(_) => (Link::GOOD, None),
    };
    network.set(now);
    let (began, since) = (Instant::now(), SystemTime::now());
    // In lockstep nothing moves without the far node; in real time this is its own.
    let own = match far {
        "dha_actuator" => "plane_motion",
        _ => "plane_command",
    };
    let before = crew.recorded(own);
    crew.wait_for(own, before + 1);
    let first = began.elapsed().as_secs_f64();
    crew.wait_for(own, before + AFTER);
    let last = began.elapsed().as_secs_f64();
    let [to_far, to_near] = counts.unwrap_or_else(|| network.counts());
    println!(
        "{name}: next tick after {first:.1} s, {AFTER} after {last:.1} s; lost to the far end {to_far}, to the near one {to_near}"
    );

    match pace {
        Pace::Lockstep => {
            network.set(Link::GOOD);
            let bags = crew.stop();
            evidence::each_tick_is_there(&evidence::whole_flight(&bags[0]));
        }
        Pace::Real(_) => {
            let since = since.duration_since(UNIX_EPOCH).unwrap().as_nanos();
            crew.wait_for_part(i64::try_from(since).unwrap());
            network.set(Link::GOOD);
            let bags = crew.stop();
            let flight = evidence::whole_flight(&bags[0]);
            let of = |source| {
                let states = flight.states.iter();
                states.filter(|state| state.planes_source == source).count()
            };
            println!(
                "{name}: planes held in {}, late in {} of {} ticks",
                of(VehicleState::PLANES_HELD),
                of(VehicleState::PLANES_LATE),
                flight.states.len()
            );
        }
    }
}
