//! A message that is lost in lockstep is asked for again, and comes again, whichever it was. Here a peer plays
//! the nodes around one that is real, and what is "lost" it does not say, or does not answer.

use crate::stage;
use std::time::{Duration, Instant};

use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{PlaneCommand, PlaneMotion, TickAnswer, VehicleState};
use planesman_msgs::sensor_msgs::msg::Imu;
use planesman_node::{Direction, Domain, Next, NodeSpec, Publisher, Qos, RosArguments, Runtime};
use stage::{PATIENCE, Stage};

/// The sampling time, ns.
const TICK: i64 = 50_000_000;
/// By the vehicle's clock a loop that stands is not silent.
const SIM_TIME: &str = "use_sim_time:=true";

/// The messages received by the peer, by the tick of their stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Received {
    State(i64),
    Imu(i64),
    Motion(i64),
    Answer(i64),
    Other,
}

fn stamp(k: i64) -> Time {
    Time::from_nanos(k * TICK)
}

fn tick(stamp: &Time) -> i64 {
    stamp.nanos() / TICK
}

struct Peer {
    rt: Runtime<Received>,
}

impl Peer {
    fn join(stage: &Stage) -> Self {
        let spec = NodeSpec {
            name: "peer",
            namespace: "/auv",
            validate: |(): &()| Ok(()),
            on_parameters: |_| Received::Other,
        };
        let domain = Domain {
            id: stage.domain(),
            local: true,
        };
        let (rt, ()) = Runtime::start_in(domain, spec, RosArguments::default()).unwrap();
        Self { rt }
    }

    /// A publisher that the real node listens to.
    fn matched_publisher<M: planesman_msgs::Message>(&self, topic: &str) -> Publisher<M> {
        let publisher = self.rt.publisher(topic, Qos::reliable(100)).unwrap();
        self.wait_for("a listener", || publisher.readers() > 0);
        publisher
    }

    /// Waits until the real node's publisher of `topic` is known.
    fn wait_until_said(&self, topic: &str) {
        self.wait_for("a publisher", || {
            let connections = self.rt.connections();
            let found = connections.find(Direction::Subscription, topic);
            found.is_some_and(|end| end.peers > 0)
        });
    }

    fn wait_for(&self, what: &str, mut come: impl FnMut() -> bool) {
        let deadline = Instant::now() + PATIENCE;
        while !come() {
            self.rt.next(Duration::from_millis(10));
            assert!(Instant::now() < deadline, "waited in vain: {what}");
        }
    }

    /// The next messages that `pick` accepts, as many as are expected.
    fn receives(&self, expected: &[Received], pick: impl Fn(&Received) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        let mut received = Vec::new();
        while received.len() < expected.len() {
            match self.rt.next(Duration::from_millis(10)) {
                Next::Event(event) if pick(&event) => received.push(event),
                _ => assert!(
                    Instant::now() < deadline,
                    "{expected:?}: received {received:?}"
                ),
            }
        }
        assert_eq!(received, expected);
    }

    /// Says something now and then until `expected` is received: the first words of a publisher may be spoken
    /// before it knows who listens.
    fn until_received(&self, expected: Received, say: impl Fn()) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            say();
            let look = Instant::now();
            while look.elapsed() < Duration::from_millis(200) {
                if self.rt.next(Duration::from_millis(10)) == Next::Event(expected) {
                    return;
                }
            }
            assert!(Instant::now() < deadline, "waited in vain: {expected:?}");
        }
    }

    fn listen(&self) {
        let (rt, qos) = (&self.rt, Qos::reliable(1000));
        let of = |header: &planesman_msgs::std_msgs::msg::Header| tick(&header.stamp);
        rt.subscribe("state", qos, move |m: VehicleState| {
            Received::State(of(&m.header))
        })
        .unwrap();
        rt.subscribe("imu", qos, move |m: Imu| Received::Imu(of(&m.header)))
            .unwrap();
        rt.subscribe("plane_motion", qos, move |m: PlaneMotion| {
            Received::Motion(of(&m.header))
        })
        .unwrap();
        rt.subscribe("tick_answer", qos, move |m: TickAnswer| {
            Received::Answer(of(&m.header))
        })
        .unwrap();
    }
}

fn state(k: i64) -> VehicleState {
    let mut state = VehicleState::default();
    state.header.stamp = stamp(k);
    state
}

fn motion(k: i64) -> PlaneMotion {
    let mut motion = PlaneMotion {
        dive_planes: vec![0.0, 0.0],
        ..PlaneMotion::default()
    };
    motion.header.stamp = stamp(k);
    motion
}

#[test]
fn an_identifier_that_lacks_a_motion_answers_when_it_comes_again_and_at_last_without_it() {
    let stage = Stage::new();
    let _sysid = stage.node("sysid", &["answer:=true", SIM_TIME]);
    let peer = Peer::join(&stage);
    peer.listen();
    let states = peer.matched_publisher("state");
    let motions = peer.matched_publisher("plane_motion");
    peer.wait_until_said("/auv/tick_answer");

    peer.until_received(Received::Answer(0), || {
        states.publish(&state(0));
    });
    peer.until_received(Received::Answer(1), || {
        motions.publish(&motion(0));
        states.publish(&state(1));
    });

    // The motion over tick 1 is lost; the vehicle says its state again, the actuator the motion.
    states.publish(&state(2));
    states.publish(&state(2));
    motions.publish(&motion(1));
    peer.until_received(Received::Answer(2), || ());

    // That over tick 2 is lost for good.
    for _ in 0..3 {
        states.publish(&state(3));
    }
    peer.until_received(Received::Answer(3), || ());
}

#[test]
fn an_actuator_whose_command_comes_again_says_the_motion_before_it_too() {
    let stage = Stage::new();
    let _actuator = stage.node("dha_actuator", &["lockstep:=true", SIM_TIME]);
    let peer = Peer::join(&stage);
    peer.listen();
    let commands = peer.matched_publisher("plane_command");
    peer.wait_until_said("/auv/plane_motion");
    let command = |k: i64| {
        let mut command = PlaneCommand::default();
        command.header.stamp = stamp(k);
        commands.publish(&command);
    };
    peer.until_received(Received::Motion(0), || command(0));
    command(1);
    peer.until_received(Received::Motion(1), || ());
    command(1);
    let motions = [0, 1].map(Received::Motion);
    peer.receives(&motions, |received| matches!(received, Received::Motion(_)));
}

#[test]
fn a_vehicle_that_waits_for_an_answer_says_its_instruments_words_again_too() {
    let stage = Stage::new();
    let peer = Peer::join(&stage);
    peer.listen();
    let _plant = stage.node(
        "plant_sim",
        &["time:=lockstep", "lockstep.members:=['nobody']"],
    );
    // Reliable, for members that wait for them; nobody answers tick 0.
    let imu = [Received::Imu(0), Received::Imu(0)];
    peer.receives(&imu, |received| matches!(received, Received::Imu(_)));
    let states = [Received::State(0), Received::State(0)];
    peer.receives(&states, |received| matches!(received, Received::State(_)));
}
