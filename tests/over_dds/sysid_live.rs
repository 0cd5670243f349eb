//! The node over DDS, between topics whose type only the ament index knows: what it learns, what its services
//! do, and what it makes of time going back, of numbers that are none and of publishers of another type.
use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_msgs::planesman_msgs::srv::{Fit, FitRequest, FitResponse};
use planesman_msgs::std_msgs::msg::Float64;
use planesman_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use planesman_msgs::{Message, Service};
use planesman_node::{
    Client, Next, NodeSpec, Publisher, Qos, RosArguments, Runtime, testing::OwnDomain,
};
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

    /// Numbers that are not finite are left to the node here.
    fn first_non_finite(&self) -> Option<String> {
        None
    }
}

enum Event {
    Parameters,
    Model(Box<ModelEstimate>),
    Diagnostics(DiagnosticArray),
}

/// Killed at the test's end, whatever becomes of it.
struct Sysid(Child);

impl Drop for Sysid {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The node, and a plant of first order that it hears: `y = 0.9 y + 0.2 u`.
struct Rig {
    rt: Runtime<Event>,
    command: Publisher<Reading>,
    answer: Publisher<Reading>,
    k: i64,
    y: f64,
    _sysid: Sysid,
    /// What the node finds the types in.
    _folder: tempfile::TempDir,
    domain: OwnDomain,
}

impl Rig {
    fn new(more: &[&str]) -> Self {
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
        let sysid = Sysid(
            Command::new(env!("CARGO_BIN_EXE_planesman"))
                .args(["node", "sysid"])
                .args(arguments.split_whitespace())
                .args(more)
                .envs(domain.variables())
                .env("AMENT_PREFIX_PATH", folder.path())
                .stderr(Stdio::null())
                .spawn()
                .unwrap(),
        );
        let spec = NodeSpec {
            name: "prober",
            namespace: "/auv",
            validate: |(): &()| Ok(()),
            on_parameters: |_| Event::Parameters,
        };
        let (rt, ()) = Runtime::start_in(domain.domain(), spec, RosArguments::default()).unwrap();
        let command = rt.publisher("command", Qos::reliable(100)).unwrap();
        let answer = rt.publisher("answer", Qos::reliable(100)).unwrap();
        rt.subscribe("model", Qos::reliable(100), |model| {
            Event::Model(Box::new(model))
        })
        .unwrap();
        rt.subscribe("/diagnostics", Qos::reliable(100), Event::Diagnostics)
            .unwrap();
        Self {
            rt,
            command,
            answer,
            k: 0,
            y: 0.0,
            _sysid: sysid,
            _folder: folder,
            domain,
        }
    }

    /// One sample of the plant, once the node listens.
    fn step(&mut self) {
        if self.command.readers() == 0 || self.answer.readers() == 0 {
            return;
        }
        let stamp = Time::from_nanos(self.k * 50_000_000);
        let u = f64::from(u8::from((self.k / 15) % 2 == 0));
        let reading = |value| Reading {
            stamp: stamp.clone(),
            value,
        };
        self.answer.publish(&reading(self.y));
        self.command.publish(&reading(u));
        self.y = 0.9 * self.y + 0.2 * u;
        self.k += 1;
    }

    /// Goes on until `pick` has what it wants.
    fn until<T>(&mut self, what: &str, mut pick: impl FnMut(&Event) -> Option<T>) -> T {
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "waited in vain: {what}");
            if let Next::Event(event) = self.rt.next(Duration::from_millis(5))
                && let Some(picked) = pick(&event)
            {
                return picked;
            }
            self.step();
        }
    }

    fn model(&mut self, what: &str, wanted: impl Fn(&ModelEstimate) -> bool) -> ModelEstimate {
        self.until(what, |event| match event {
            Event::Model(model) if wanted(model) => Some((**model).clone()),
            _ => None,
        })
    }

    /// The node's status `model` once it is as wanted.
    fn status(&mut self, what: &str, wanted: impl Fn(&DiagnosticStatus) -> bool) {
        self.until(what, |event| match event {
            Event::Diagnostics(array) => array
                .status
                .iter()
                .any(|status| status.name == "/auv/sysid: model" && wanted(status))
                .then_some(()),
            _ => None,
        });
    }

    fn call<S: Service>(&self, name: &str, request: S::Request) -> S::Response {
        let client: Client<S> = self.rt.client(name).unwrap();
        self.rt.block_on(client.call(request, PATIENCE)).unwrap()
    }

    fn fit(&self, name: &str) -> FitResponse {
        let name = name.to_owned();
        self.call::<Fit>("/auv/sysid/fit", FitRequest { name })
    }

    fn freeze(&self, data: bool) -> String {
        let answer = self.call::<SetBool>("/auv/sysid/freeze", SetBoolRequest { data });
        assert!(answer.success);
        answer.message
    }
}

/// A value of a status.
fn value<'a>(status: &'a DiagnosticStatus, key: &str) -> &'a str {
    let pair = status.values.iter().find(|pair| pair.key == key);
    pair.map_or("", |pair| &pair.value)
}

fn is_the_plant(model: &ModelEstimate) {
    assert!((model.a[0] + 0.9).abs() < 1e-6, "{model:?}");
    assert!((model.b[0] - 0.2).abs() < 1e-6, "{model:?}");
}

#[test]
fn a_model_is_found_between_topics_of_a_type_read_from_the_ament_index() {
    let mut rig = Rig::new(&[]);
    is_the_plant(&rig.model("a valid model", |model| model.valid));
}

#[test]
fn each_pair_is_fitted_frozen_and_reset_by_service() {
    // The plant backwards, from its output to its input, is none of first order: it only has to be distinguishable.
    let back = "pairs:=['back: answer:value -> command:value order=2']";
    let mut rig = Rig::new(&["-p", back]);
    let model = rig.model("a valid model", |model| {
        model.valid && model.name == "model"
    });
    is_the_plant(&model);
    rig.model("the other pair's", |model| {
        model.name == "back" && model.input == "answer:value" && model.order == 2
    });

    let first = rig.fit("");
    assert!(first.success, "{}", first.message);
    assert_eq!(first.model.name, "model");
    assert_eq!(rig.fit("back").model.output, "command:value");
    let none = rig.fit("roll");
    assert!(!none.success);
    assert!(
        none.message.contains("known: model, back"),
        "{}",
        none.message
    );

    assert!(rig.freeze(true).starts_with("estimate frozen"));
    assert!(rig.freeze(true).contains("already"));
    let kept = rig.fit("").model;
    assert!(kept.frozen && kept.valid);
    let stamp = kept.header.stamp.nanos();
    let later = rig.model("an estimate that is frozen", |model| {
        model.frozen && model.name == "model" && model.header.stamp.nanos() > 0 && model.fit > 99.0
    });
    assert!(stamp > 0);
    assert_eq!((later.samples, &later.a), (kept.samples, &kept.a));
    rig.status("a status that says so", |status| {
        status.message.starts_with("frozen") && value(status, "frozen") == "true"
    });
    assert_eq!(rig.fit("").model.samples, kept.samples);
    assert_eq!(rig.freeze(false), "estimation resumed");
    rig.model("more samples", |model| {
        model.name == "model" && !model.frozen && model.samples > kept.samples
    });

    assert!(
        rig.call::<Trigger>("/auv/sysid/reset", TriggerRequest::default())
            .success
    );
    for name in ["model", "back"] {
        assert!(rig.fit(name).model.samples < 30, "{name}");
    }
    is_the_plant(&rig.model("a model learnt anew", |model| {
        model.valid && model.name == "model" && model.samples < kept.samples
    }));
}

#[test]
fn a_record_that_loops_begins_everything_anew_and_is_counted() {
    let mut rig = Rig::new(&[]);
    rig.model("a valid model", |model| model.valid);
    (rig.k, rig.y) = (0, 0.0);
    let anew = rig.model("an estimate of the second round", |model| {
        model.restarts == 1
    });
    assert!(anew.samples < 60, "{anew:?}");
    is_the_plant(&rig.model("a valid model of the second round", |model| {
        model.valid && model.restarts == 1
    }));
    rig.status("a restart that is counted", |status| {
        value(status, "restarts") == "1" && status.message == "valid"
    });
}

#[test]
fn what_is_no_number_or_of_another_type_is_refused_and_said_and_silence_too() {
    let mut rig = Rig::new(&[]);
    rig.model("a valid model", |model| model.valid);
    rig.answer.publish(&Reading {
        stamp: Time::from_nanos(rig.k * 50_000_000),
        value: f64::NAN,
    });
    rig.status("a refused message", |status| {
        value(status, "refused") == "1"
    });

    let spec = NodeSpec {
        name: "stranger",
        namespace: "/auv",
        validate: |(): &()| Ok(()),
        on_parameters: |_| (),
    };
    let (stranger, ()) =
        Runtime::<()>::start_in(rig.domain.domain(), spec, RosArguments::default()).unwrap();
    let other: Publisher<Float64> = stranger.publisher("answer", Qos::reliable(10)).unwrap();
    let begin = Instant::now();
    loop {
        assert!(begin.elapsed() < PATIENCE, "nobody minds the other type");
        other.publish(&Float64 { data: 1.0 });
        let _ = stranger.next(Duration::from_millis(5));
        rig.step();
        if let Next::Event(Event::Diagnostics(array)) = rig.rt.next(Duration::from_millis(5))
            && array.status.iter().any(|status| {
                status.name == "/auv/sysid: connections" && status.message.contains("refused")
            })
        {
            break;
        }
    }
    is_the_plant(&rig.fit("").model);

    // The actuator, as it were, stops.
    for _ in 0..60 {
        rig.answer.publish(&Reading {
            stamp: Time::from_nanos(rig.k * 50_000_000),
            value: 0.0,
        });
        rig.k += 1;
    }
    let begin = Instant::now();
    loop {
        assert!(begin.elapsed() < PATIENCE, "nobody misses the input");
        if let Next::Event(Event::Diagnostics(array)) = rig.rt.next(Duration::from_millis(5))
            && array.status.iter().any(|status| {
                status.name == "/auv/sysid: model"
                    && status.level == DiagnosticStatus::WARN
                    && status.message.contains("no messages of command:value for")
            })
        {
            break;
        }
    }
}
