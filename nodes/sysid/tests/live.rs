//! The node identifies between topics whose type only the ament index knows.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_node::{Next, NodeSpec, Qos, RosArguments, Runtime, testing::OwnDomain};
use serde::{Deserialize, Serialize};

/// Longest that anything here may take; reached only when something is broken.
const PATIENCE: Duration = Duration::from_secs(60);

const DEFINITION: &str = "builtin_interfaces/Time stamp\nfloat64 value\n";

/// A message of a package that is not this project's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Reading {
    stamp: Time,
    value: f64,
}

impl Message for Reading {
    const TYPE_NAME: &'static str = "demo_msgs/msg/Reading";
    const DDS_TYPE_NAME: &'static str = "demo_msgs::msg::dds_::Reading_";
    const DEFINITION: &'static str = DEFINITION;
    // As `rosbags` computes it.
    const TYPE_HASH: &'static str =
        "RIHS01_649527e2092773fa368049c2cf6a55a4732e758cf08e25647abc8f2b5fef6176";

    fn first_non_finite(&self) -> Option<String> {
        (!self.value.is_finite()).then(|| "value".to_owned())
    }
}

enum Event {
    Parameters,
    Model(Box<ModelEstimate>),
}

/// Killed at the test's end, whatever becomes of it.
struct Sysid(Child);

impl Drop for Sysid {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_model_is_found_between_topics_of_a_type_read_from_the_ament_index() {
    let folder = tempfile::tempdir().unwrap();
    for (package, name, text) in [
        ("demo_msgs", "Reading", DEFINITION),
        ("builtin_interfaces", "Time", "int32 sec\nuint32 nanosec\n"),
    ] {
        let place = folder.path().join("share").join(package).join("msg");
        fs::create_dir_all(&place).unwrap();
        fs::write(place.join(format!("{name}.msg")), text).unwrap();
    }
    let domain = OwnDomain::claim().unwrap();
    let arguments = "--ros-args -p input:=command:value -p output:=answer:value \
                     -p input_type:=demo_msgs/msg/Reading -p output_type:=demo_msgs/msg/Reading \
                     -p break_on:='' -p order:=1 -p first_moment:=false";
    let _sysid = Sysid(
        Command::new(env!("CARGO_BIN_EXE_sysid"))
            .args(arguments.split_whitespace())
            .envs(domain.variables())
            .env("AMENT_PREFIX_PATH", folder.path())
            .stderr(Stdio::null())
            .spawn()
            .unwrap(),
    );
    let spec = NodeSpec {
        name: "prober",
        namespace: "/auv",
        declarations: Vec::new(),
        validate: |_| Ok(()),
        on_parameters: |_| Event::Parameters,
    };
    let rt = Runtime::start_in(domain.domain(), spec, RosArguments::default()).unwrap();
    let command = rt
        .publisher::<Reading>("command", Qos::reliable(100))
        .unwrap();
    let answer = rt
        .publisher::<Reading>("answer", Qos::reliable(100))
        .unwrap();
    rt.subscribe("model", Qos::reliable(100), |model| {
        Event::Model(Box::new(model))
    })
    .unwrap();

    let begin = Instant::now();
    let (mut k, mut y) = (0_i64, 0.0);
    let model = loop {
        assert!(begin.elapsed() < PATIENCE, "no model came");
        if let Next::Event(Event::Model(model)) = rt.next(Duration::from_millis(5))
            && model.valid
        {
            break model;
        }
        if command.readers() == 1 && answer.readers() == 1 {
            let stamp = Time::from_nanos(k * 50_000_000);
            let u = f64::from(u8::from((k / 15) % 2 == 0));
            let reading = |value| Reading {
                stamp: stamp.clone(),
                value,
            };
            answer.publish(&reading(y));
            command.publish(&reading(u));
            y = 0.9 * y + 0.2 * u;
            k += 1;
        }
    };
    assert!((model.a[0] + 0.9).abs() < 1e-6, "{model:?}");
    assert!((model.b[0] - 0.2).abs() < 1e-6, "{model:?}");
}
