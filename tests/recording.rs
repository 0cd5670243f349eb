//! The recorder goes on recording whatever one message says.
#![allow(clippy::unwrap_used)]

mod stage;

use std::path::Path;
use std::time::{Duration, Instant};

use planesman_bag::{BagReader, Order};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::rosgraph_msgs::msg::Clock;
use planesman_msgs::std_msgs::msg::Float64;
use planesman_msgs::{Message, cdr};
use planesman_node::{Domain, NodeSpec, Publisher, Qos, RosArguments, Runtime};
use stage::{PATIENCE, Signal, Stage};

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

#[test]
fn a_clock_before_its_epoch_ends_no_recording() {
    let stage = Stage::new();
    let out = stage.path("bag");
    let output = format!("output:={out}");
    let recorder = stage.node("recorder", &[&output, "use_sim_time:=true"]);
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
