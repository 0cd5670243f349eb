//! The recorder records what it was asked for, as `ros2 bag record` does, and goes on whatever one message says.

use crate::stage;
use std::path::Path;
use std::time::{Duration, Instant};

use planesman_bag::{BagReader, Order};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::MotionEstimate;
use planesman_msgs::rosbag2_interfaces::srv::{IsPaused, Pause, Resume, Snapshot, SplitBagfile};
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_msgs::std_msgs::msg::Float64;
use planesman_msgs::{Message, Service, cdr};
use planesman_node::{
    Client, Connections, Direction, Domain, NodeSpec, Publisher, Qos, RosArguments, Runtime,
};
use stage::{PATIENCE, Process, Received, Signal, Stage};

fn matched_publisher<M: Message>(rt: &Runtime<()>, topic: &str) -> Publisher<M> {
    let publisher = rt.publisher(topic, Qos::reliable(100)).unwrap();
    let deadline = Instant::now() + PATIENCE;
    // The recorder, and its clock.
    let readers = if topic == "/clock" { 2 } else { 1 };
    while publisher.readers() < readers {
        rt.next(Duration::from_millis(10));
        assert!(Instant::now() < deadline, "nobody listens to {topic}");
    }
    publisher
}

/// A node beside the recorder.
fn peer(stage: &Stage) -> Runtime<()> {
    let spec = NodeSpec {
        name: "peer",
        namespace: "/auv",
        validate: |(): &()| Ok(()),
        on_parameters: |_| (),
    };
    let domain = Domain {
        id: stage.domain(),
        local: true,
    };
    let (rt, ()) = Runtime::start_in(domain, spec, RosArguments::default()).unwrap();
    rt
}

/// A recorder of topics that are no part of the loop, and a node beside it.
struct Recording {
    rt: Runtime<()>,
    recorder: Process,
    out: String,
    stage: Stage,
}

impl Recording {
    fn begin(parameters: &[&str]) -> Self {
        let stage = Stage::new();
        let out = stage.path("bag");
        let output = format!("output:={out}");
        Self {
            recorder: stage.node("recorder", &[&[&*output], parameters].concat()),
            rt: peer(&stage),
            out,
            stage,
        }
    }

    /// Calls a service of the recorder's.
    fn ask<S: Service>(&self, name: &str) -> S::Response
    where
        S::Request: Default,
    {
        let client: Client<S> = self.rt.client(&format!("recorder/{name}")).unwrap();
        let call = client.call(S::Request::default(), PATIENCE);
        self.rt.block_on(call).unwrap()
    }

    /// Publishes a number, and leaves time for it to arrive.
    fn say(&self, publisher: &Publisher<Float64>, data: f64) {
        publisher.publish(&Float64 { data });
        self.rt.next(Duration::from_millis(500));
    }

    /// Ends the recording: the number of files, and the numbers with their topics.
    fn end(self) -> (usize, Vec<(String, f64)>) {
        self.recorder.signal(Signal::TERM);
        self.recorder.finish().success();
        let bag = BagReader::open(Path::new(&self.out)).unwrap();
        assert!(bag.completeness().is_whole(), "{}", bag.completeness());
        assert_eq!(bag.dropped(), 0);
        let messages = bag.messages(Order::File).map(Result::unwrap);
        let numbers = messages.map(|message| {
            let number = cdr::from_bytes::<Float64>(&message.payload).unwrap();
            (message.topic.name.clone(), number.data)
        });
        let found = (bag.files().count(), numbers.collect());
        drop(self.stage);
        found
    }
}

#[test]
fn what_is_selected_is_recorded_and_pause_and_split_are_obeyed() {
    let recording = Recording::begin(&[
        "record.regex:=^/(sonar|auv)/",
        "record.exclude_topics:=[depth_setpoint]",
        "record.exclude_topic_types:=[std_msgs/msg/String]",
    ]);
    let rt = &recording.rt;
    let offer = |topic, qos| rt.publisher::<Float64>(topic, qos).unwrap();
    let left_out = [
        offer("/sonar/_raw", Qos::reliable(10)),
        offer("/lidar/range", Qos::reliable(10)),
        offer("depth_setpoint", Qos::reliable(10)),
    ];
    let fact = offer("fact", Qos::latched(1));
    fact.publish(&Float64 { data: 0.5 }); // Before anybody listens.
    let range = matched_publisher::<Float64>(rt, "/sonar/range");
    recording.say(&range, 1.0);
    recording.ask::<Pause>("pause");
    assert!(recording.ask::<IsPaused>("is_paused").paused);
    recording.say(&range, 2.0);
    recording.ask::<Resume>("resume");
    recording.ask::<SplitBagfile>("split_bagfile");
    recording.say(&range, 3.0);
    assert!(left_out.iter().all(|it| it.readers() == 0));

    let (files, mut numbers) = recording.end();
    assert_eq!(files, 2);
    numbers.sort_by(|a, b| a.1.total_cmp(&b.1));
    let of = |topic: &str, number: f64| (topic.to_owned(), number);
    let expected = [
        of("/auv/fact", 0.5),
        of("/sonar/range", 1.0),
        of("/sonar/range", 3.0),
    ];
    assert_eq!(numbers, expected);
}

/// `ros2 doctor` warns of each topic that has subscribers alone.
#[test]
fn topics_that_are_published_on_request_alone_are_subscribed_to_then() {
    let stage = Stage::new();
    let output = format!("output:={}", stage.path("bag"));
    let _recorder = stage.node("recorder", &[&output]);
    let operator = stage.operator();
    let on_request = ["/auv/estimate", "/auv/dha_state_stern", "/clock"];
    let subscribed = |wanted: &[&str]| {
        operator.until("the recorder's subscriptions", |received| {
            let Received::Diagnostics(array) = received else {
                return None;
            };
            let connections = Connections::from_diagnostics(&array)?;
            let has = |topic: &str| connections.find(Direction::Subscription, topic).is_some();
            let all = ["/auv/state"].iter().chain(wanted).all(|topic| has(topic));
            all.then(|| on_request.map(has))
        })
    };
    assert_eq!(subscribed(&[]), [false; 3]);
    let qos = Qos::reliable(100);
    let _estimate = operator.rt.publisher::<MotionEstimate>("estimate", qos);
    assert_eq!(subscribed(&["/auv/estimate"]), [true, false, false]);
}

#[test]
fn a_snapshot_has_the_latest_messages_and_nothing_is_recorded_without_one() {
    // A number takes twelve bytes with its encapsulation.
    let recording = Recording::begin(&[
        "record.topics:=[/sonar/range]",
        "storage.snapshot_mode:=true",
        "storage.max_cache_size:=24",
    ]);
    let range = matched_publisher::<Float64>(&recording.rt, "/sonar/range");
    for number in [1.0, 2.0, 3.0] {
        recording.say(&range, number);
    }
    assert!(recording.ask::<Snapshot>("snapshot").success);
    recording.say(&range, 4.0);
    let (_, numbers) = recording.end();
    let numbers: Vec<f64> = numbers.into_iter().map(|(_, number)| number).collect();
    assert_eq!(numbers, [2.0, 3.0]);
}

#[test]
fn a_clock_before_its_epoch_ends_no_recording() {
    let stage = Stage::new();
    let out = stage.path("bag");
    let output = format!("output:={out}");
    let recorder = stage.node("recorder", &[&output, "use_sim_time:=true"]);
    let rt = peer(&stage);
    let clock = matched_publisher::<Clock>(&rt, "/clock");
    let setpoint = matched_publisher::<Float64>(&rt, "depth_setpoint");
    let operator = stage.operator();
    for (phase, seconds) in [-5, 5].into_iter().enumerate() {
        let mut before = None;
        // Until the recorder has reported some at that time.
        operator.until("a report of the recorder's", |received| {
            clock.publish(&Clock {
                clock: Time::from_nanos(seconds * 1_000_000_000),
            });
            setpoint.publish(&Float64 { data: phase as f64 });
            let status = received.status("/auv/recorder: bag")?;
            let value = |key: &str| status.values.iter().find(|v| v.key == key);
            let number = |key: &str| value(key).unwrap().value.parse::<u64>().unwrap();
            let first = *before.get_or_insert(number("messages"));
            (number("unfit") > 0 && number("messages") > first + 10).then_some(())
        });
    }
    recorder.signal(Signal::TERM);
    recorder.finish().success();
    let bag = BagReader::open(Path::new(&out)).unwrap();
    assert!(bag.completeness().is_whole(), "{}", bag.completeness());
    let mut phases: Vec<u8> = bag
        .messages(Order::File)
        .map(|message| message.unwrap())
        .filter(|message| message.topic.name == "/auv/depth_setpoint")
        .map(|message| cdr::from_bytes::<Float64>(&message.payload).unwrap().data as u8)
        .collect();
    phases.dedup();
    assert_eq!(phases, [0, 1]);
}
