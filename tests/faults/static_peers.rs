//! A network without multicast: who is named in `ROS_STATIC_PEERS` is found there, by unicast.

use libtest_mimic::Trial;
use planesman::nodes::LAUNCHED;
use planesman_flight::nodes::NODES;
use serde_json::Value;

use super::crew::Crew;
use super::evidence;
use super::foreign::{CYCLONE, Running};
use super::forwarder::{FAR, NEAR};
use super::network::{self, ETHERNET, Network, Place};
use super::pace::Pace;
use super::stage::{Process, Stage};
use super::trial_where;

/// Ticks that the loop flies.
const TICKS: u64 = 60;
/// Messages that the other DDS receives.
const MESSAGES: &str = "20";

pub(crate) fn trials() -> Vec<Trial> {
    let trial = |name: &str, run: fn()| {
        trial_where(
            network::is_possible,
            format!("static_peers/{name}"),
            true,
            run,
        )
    };
    vec![
        trial("one_side_names_the_other", || {
            flies(("SUBNET", FAR), ("SUBNET", ""));
        }),
        trial("in_the_localhost_range_both_name_the_other", || {
            flies(("LOCALHOST", FAR), ("LOCALHOST", NEAR));
        }),
        trial("cyclone_dds_names_us", || is_received(("SUBNET", ""), NEAR)),
        trial("we_name_cyclone_dds", || is_received(("SUBNET", FAR), "")),
        trial("in_the_localhost_range_cyclone_dds_and_we_do", || {
            is_received(("LOCALHOST", FAR), NEAR);
        }),
    ]
}

/// A discovery range with static peers.
type Discovery = (&'static str, &'static str);

/// The same place, with these variables.
fn discovering(mut place: Place, (range, peers): Discovery) -> Place {
    place.extend([
        "env".to_owned(),
        format!("ROS_AUTOMATIC_DISCOVERY_RANGE={range}"),
        format!("ROS_STATIC_PEERS={peers}"),
    ]);
    place
}

/// The loop flies in lockstep, `sysid` at the far end.
fn flies(near: Discovery, far: Discovery) {
    let stage = Stage::new();
    let network = Network::new(ETHERNET, 1);
    network.without_multicast();
    let places = NODES.map(|node| match node {
        "sysid" => (node, discovering(network.far(), far)),
        _ => (node, discovering(network.near(), near)),
    });
    let crew = Crew::start(&stage, Pace::Lockstep, places.into_iter().collect());
    crew.wait_for("plane_command", TICKS);
    let bags = crew.stop();
    evidence::each_tick_is_there(&evidence::whole_flight(&bags[0]));
}

/// Cyclone DDS at the far end receives the vehicle's states.
fn is_received(near: Discovery, cyclone_peers: &str) {
    let Some(cyclone) = CYCLONE.found() else {
        return;
    };
    let stage = Stage::new();
    let network = Network::new(ETHERNET, 1);
    network.without_multicast();
    let place = discovering(network.near(), near);
    let vehicle = ["node", "plant_sim"];
    let _vehicle: Process = stage.start_at(&place, &vehicle, &[(LAUNCHED, "1")]);
    let arguments = [
        "/auv/state",
        "planesman_msgs/msg/VehicleState",
        "--count",
        MESSAGES,
        "--timeout",
        "60",
    ];
    let mut peer = cyclone.command_at(&network.far(), "peer_echo.py", stage.domain(), &arguments);
    peer.env("PEER_INTERFACE", "far")
        .env("ROS_STATIC_PEERS", cyclone_peers);
    let states: Vec<Value> = Running::of(peer).collect();
    assert_eq!(states.len().to_string(), MESSAGES, "{states:?}");
}
