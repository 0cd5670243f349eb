//! The runtime over real DDS on loopback: the example node `doubler` in a process of its
//! own, and a node of this process that speaks to it.
#![allow(clippy::unwrap_used)]

use std::{
    io::Read as _,
    path::PathBuf,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

use planesman_msgs::{
    Message, Service,
    diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus},
    rcl_interfaces::{
        msg::{Parameter, ParameterEvent, ParameterType, ParameterValue},
        srv::{
            DescribeParameters, DescribeParametersRequest, GetParameters, GetParametersRequest,
            SetParameters, SetParametersAtomically, SetParametersAtomicallyRequest,
            SetParametersRequest,
        },
    },
    std_msgs::msg::{Float64, String as Text},
    std_srvs::srv::{SetBool, SetBoolRequest},
};
use planesman_node::{
    Connections, Direction, ExitReport, Next, NodeSpec, Publisher, Qos, RawSample, RosArguments,
    Runtime, testing::OwnDomain,
};
use rustdds::{DomainParticipantBuilder, QosPolicyBuilder, StatusEvented as _};
use serde::{Deserialize, Serialize};

/// Longest that anything here may take; reached only when something is broken.
const PATIENCE: Duration = Duration::from_secs(20);

enum Event {
    Output(f64),
    Beat,
    Raw(RawSample),
    Diagnostics(DiagnosticArray),
    ParameterEvent(ParameterEvent),
    Parameters,
}

/// The example node in its own process, killed if a test forgets it.
struct Doubler {
    process: Child,
    report: PathBuf,
}

impl Doubler {
    fn start(domain: &OwnDomain, arguments: &[&str]) -> Self {
        let report = std::env::temp_dir().join(format!("planesman-doubler-{}.json", domain.id()));
        let _ = std::fs::remove_file(&report);
        let process = command()
            .args(arguments)
            .envs(domain.variables())
            .env("PLANESMAN_EXIT_REPORT", &report)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        Self { process, report }
    }

    fn signal(&self, signal: &str) {
        let pid = self.process.id().to_string();
        let status = Command::new("kill").args([signal, &pid]).status().unwrap();
        assert!(status.success());
    }

    /// Ends it as `Ctrl-C` or a launcher would, and returns its report and its log.
    fn stop(mut self, signal: &str) -> (ExitReport, String) {
        self.signal(signal);
        assert!(self.process.wait().unwrap().success());
        let mut log = String::new();
        self.process
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut log)
            .unwrap();
        let report = serde_json::from_slice(&std::fs::read(&self.report).unwrap()).unwrap();
        (report, log)
    }
}

impl Drop for Doubler {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_file(&self.report);
    }
}

/// The example's executable, which `cargo test` builds beside the tests.
fn command() -> Command {
    let tests = std::env::current_exe().unwrap();
    let build = tests.ancestors().nth(2).unwrap();
    Command::new(build.join("examples/doubler"))
}

fn prober(domain: &OwnDomain) -> Runtime<Event> {
    let spec = NodeSpec {
        name: "prober",
        namespace: "/",
        validate: |(): &()| Ok(()),
        on_parameters: |_| Event::Parameters,
    };
    let (rt, ()) = Runtime::start_in(domain.domain(), spec, RosArguments::default()).unwrap();
    rt
}

/// Handles events until `done` says so.
fn until(rt: &Runtime<Event>, mut done: impl FnMut(Option<Event>) -> bool) {
    let start = Instant::now();
    loop {
        let event = match rt.next(Duration::from_millis(20)) {
            Next::Event(event) => Some(event),
            Next::Timeout => None,
            Next::Stop => panic!("asked to stop"),
        };
        if done(event) {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "nothing happens");
    }
}

/// A prober whose `/input` the doubler reads and which reads its `/output`.
fn joined(domain: &OwnDomain) -> (Runtime<Event>, Publisher<Float64>) {
    let rt = prober(domain);
    let input = rt.publisher("/input", Qos::reliable(1000)).unwrap();
    rt.subscribe("/output", Qos::reliable(1000), |Float64 { data }| {
        Event::Output(data)
    })
    .unwrap();
    rt.subscribe("/diagnostics", Qos::reliable(10), Event::Diagnostics)
        .unwrap();
    until(&rt, |event| {
        let matched = matches!(&event, Some(Event::Diagnostics(array)) if has_readers(array));
        input.readers() == 1 && matched
    });
    (rt, input)
}

/// Whether the doubler says that both its topics are connected.
fn has_readers(array: &DiagnosticArray) -> bool {
    Connections::from_diagnostics(array).is_some_and(|connections| {
        let peers = |direction, topic| connections.find(direction, topic).map(|c| c.peers);
        connections.node == "/doubler"
            && peers(Direction::Publisher, "/output") == Some(1)
            && peers(Direction::Subscription, "/input") == Some(1)
    })
}

/// The doubler's answer to `input`.
fn answer(rt: &Runtime<Event>, publisher: &Publisher<Float64>, input: f64) -> f64 {
    let mut output = None;
    assert!(publisher.publish(&Float64 { data: input }));
    until(rt, |event| {
        if let Some(Event::Output(number)) = event {
            output = Some(number);
        }
        output.is_some()
    });
    output.unwrap()
}

#[test]
fn every_number_comes_back_doubled_in_order_and_is_accounted_for() {
    let domain = OwnDomain::claim().unwrap();
    let doubler = Doubler::start(&domain, &[]);
    let (rt, input) = joined(&domain);
    for number in 0..500 {
        assert!(input.publish(&Float64 {
            data: f64::from(number)
        }));
    }
    let mut expected = 0..500;
    until(&rt, |event| {
        if let Some(Event::Output(number)) = event {
            assert_eq!(number, f64::from(expected.next().unwrap()) * 2.0);
        }
        expected.is_empty()
    });
    let (report, log) = doubler.stop("-TERM");
    assert_eq!(report.node, "/doubler");
    assert_eq!(report.received["/input"], 500);
    assert_eq!(report.published["/output"], 500);
    assert!(report.refused.is_empty() && report.dropped.is_empty());
    assert!(
        log.lines()
            .all(|line| line.starts_with("[INFO] [") && line.contains("[doubler]: ")),
        "{log}"
    );
}

#[test]
fn names_are_remapped_and_parameters_set_from_the_command_line() {
    let domain = OwnDomain::claim().unwrap();
    let arguments = "--ros-args -r __ns:=/b -r __node:=triple -r output:=/output \
                     -r /b/input:=/input -p gain:=3";
    let parts: Vec<&str> = arguments.split_whitespace().collect();
    let doubler = Doubler::start(&domain, &parts);
    let rt = prober(&domain);
    let input = rt.publisher("/input", Qos::reliable(10)).unwrap();
    rt.subscribe("/output", Qos::reliable(10), |Float64 { data }| {
        Event::Output(data)
    })
    .unwrap();
    rt.subscribe("/b/triple/beat", Qos::sensor(), |Float64 { .. }| {
        Event::Beat
    })
    .unwrap();
    until(&rt, |_| input.readers() == 1);
    // Our reader may still be unknown over there: ask until the first answer.
    let (mut output, mut beats) = (None, false);
    until(&rt, |event| {
        match event {
            Some(Event::Output(number)) => output = Some(number),
            Some(Event::Beat) => beats = true,
            _ => drop(input.publish(&Float64 { data: 7.0 })),
        }
        output.is_some() && beats
    });
    assert_eq!(output, Some(21.0));
    let (report, _) = doubler.stop("-INT");
    assert_eq!(report.node, "/b/triple");
    assert!(report.published["/b/triple/beat"] > 0);
}

fn number(name: &str, value: f64) -> Parameter {
    Parameter {
        name: name.to_owned(),
        value: ParameterValue {
            r#type: ParameterType::PARAMETER_DOUBLE,
            double_value: value,
            ..ParameterValue::default()
        },
    }
}

#[test]
fn a_parameter_changes_live_and_a_bad_value_is_refused_with_its_reason() {
    let domain = OwnDomain::claim().unwrap();
    let doubler = Doubler::start(&domain, &[]);
    let (rt, input) = joined(&domain);
    rt.subscribe(
        "/parameter_events",
        Qos::reliable(100),
        Event::ParameterEvent,
    )
    .unwrap();
    let set = rt
        .client::<SetParameters>("/doubler/set_parameters")
        .unwrap();
    let set = |name: &str, value: f64| {
        let parameters = vec![number(name, value)];
        let call = set.call(SetParametersRequest { parameters }, PATIENCE);
        rt.block_on(call).unwrap().results.remove(0)
    };
    for (name, value, reason) in [
        ("gain", 10.5, "[0, 10]"),
        ("gain", 0.0, "must not both be 0"),
        ("gian", 1.0, "not declared"),
    ] {
        let result = set(name, value);
        assert!(
            !result.successful && result.reason.contains(reason),
            "{result:?}"
        );
    }
    assert_eq!(answer(&rt, &input, 21.0), 42.0);
    assert!(set("gain", 3.0).successful);
    let mut event_seen = None;
    until(&rt, |event| {
        if let Some(Event::ParameterEvent(event)) = event {
            event_seen = Some(event);
        }
        event_seen.is_some()
    });
    let event_seen = event_seen.unwrap();
    assert_eq!(event_seen.node, "/doubler");
    assert_eq!(event_seen.changed_parameters, [number("gain", 3.0)]);
    assert_eq!(answer(&rt, &input, 7.0), 21.0);

    let atomically = rt
        .client::<SetParametersAtomically>("/doubler/set_parameters_atomically")
        .unwrap();
    let parameters = vec![number("offset", 1.0), number("gain", 11.0)];
    let call = atomically.call(SetParametersAtomicallyRequest { parameters }, PATIENCE);
    assert!(!rt.block_on(call).unwrap().result.successful);
    let get = rt
        .client::<GetParameters>("/doubler/get_parameters")
        .unwrap();
    let names = vec![
        "offset".to_owned(),
        "gain".to_owned(),
        "use_sim_time".to_owned(),
    ];
    let call = get.call(GetParametersRequest { names }, PATIENCE);
    let values = rt.block_on(call).unwrap().values;
    assert_eq!(values[0].double_value, 0.0);
    assert_eq!(values[1].double_value, 3.0);
    assert_eq!(values[2].r#type, ParameterType::PARAMETER_BOOL);
    let describe = rt
        .client::<DescribeParameters>("/doubler/describe_parameters")
        .unwrap();
    let names = vec!["offset".to_owned()];
    let call = describe.call(DescribeParametersRequest { names }, PATIENCE);
    let descriptors = rt.block_on(call).unwrap().descriptors;
    assert_eq!(descriptors[0].description, "output at input 0 [m]");
    drop(doubler);
}

#[test]
fn a_service_of_the_node_answers_and_its_status_shows_in_the_diagnostics() {
    let domain = OwnDomain::claim().unwrap();
    let _doubler = Doubler::start(&domain, &[]);
    let (rt, _input) = joined(&domain);
    let mute = rt.client::<SetBool>("/doubler/mute").unwrap();
    let call = mute.call(SetBoolRequest { data: true }, PATIENCE);
    assert!(rt.block_on(call).unwrap().success);
    until(&rt, |event| {
        let Some(Event::Diagnostics(array)) = event else {
            return false;
        };
        array.status.iter().any(|status| {
            status.name == "/doubler: output"
                && status.level == DiagnosticStatus::WARN
                && status.message == "muted"
        })
    });
}

/// A `Float64` that lets every number through.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Unchecked {
    data: f64,
}

impl Message for Unchecked {
    const TYPE_NAME: &'static str = Float64::TYPE_NAME;
    const DDS_TYPE_NAME: &'static str = Float64::DDS_TYPE_NAME;
    const DEFINITION: &'static str = Float64::DEFINITION;
    const TYPE_HASH: &'static str = Float64::TYPE_HASH;

    fn first_non_finite(&self) -> Option<String> {
        None
    }
}

#[test]
fn numbers_that_are_not_finite_pass_neither_out_nor_in() {
    let domain = OwnDomain::claim().unwrap();
    let doubler = Doubler::start(&domain, &[]);
    let (rt, input) = joined(&domain);
    assert!(!input.publish(&Float64 { data: f64::NAN }));
    assert_eq!(input.published(), 0);
    drop(rt.shutdown());

    let rt = prober(&domain);
    let input = rt
        .publisher::<Unchecked>("/input", Qos::reliable(10))
        .unwrap();
    rt.subscribe("/diagnostics", Qos::reliable(10), Event::Diagnostics)
        .unwrap();
    until(&rt, |event| {
        input.readers() == 1 && matches!(&event, Some(Event::Diagnostics(_)))
    });
    assert!(input.publish(&Unchecked {
        data: f64::INFINITY
    }));
    assert!(input.publish(&Unchecked { data: 1.0 }));
    until(&rt, |event| {
        let Some(Event::Diagnostics(array)) = event else {
            return false;
        };
        Connections::from_diagnostics(&array).is_some_and(|connections| {
            let input = connections.find(Direction::Subscription, "/input");
            input.is_some_and(|c| c.refused == 1 && c.messages == 1)
        })
    });
    let (report, log) = doubler.stop("-TERM");
    assert_eq!(report.refused["/input"], 1);
    assert!(
        log.contains("/input: message refused: data is not finite"),
        "{log}"
    );
}

#[test]
fn messages_of_another_type_on_the_topic_are_refused() {
    let domain = OwnDomain::claim().unwrap();
    let doubler = Doubler::start(&domain, &[]);
    let (rt, good) = joined(&domain);
    let other = prober(&domain);
    let bad = other
        .publisher::<Text>("/input", Qos::reliable(10))
        .unwrap();
    let mut refused = 0;
    until(&rt, |event| {
        // The middleware matches by topic alone, and tells nobody when it has.
        other.block_on(async {
            bad.publish(&Text {
                data: "long enough".to_owned(),
            })
        });
        if let Some(Event::Diagnostics(array)) = event
            && let Some(connections) = Connections::from_diagnostics(&array)
            && let Some(input) = connections.find(Direction::Subscription, "/input")
        {
            assert_eq!((input.messages, input.peers), (0, 1));
            refused = input.refused;
        }
        refused > 0
    });
    assert_eq!(answer(&rt, &good, 1.0), 2.0);
    let (_, log) = doubler.stop("-TERM");
    assert!(
        log.contains("std_msgs::msg::dds_::String_, not std_msgs::msg::dds_::Float64_"),
        "{log}"
    );
}

#[test]
fn a_raw_subscription_gets_the_payload_byte_for_byte() {
    let domain = OwnDomain::claim().unwrap();
    let _doubler = Doubler::start(&domain, &[]);
    let (rt, input) = joined(&domain);
    let (topic, qos) = ("/output", Qos::record_reliable());
    rt.subscribe_raw(topic, Float64::TYPE_NAME, None, qos, Event::Raw)
        .unwrap();
    let mut sample = None;
    until(&rt, |event| {
        match event {
            Some(Event::Raw(raw)) => sample = Some(raw),
            _ => drop(input.publish(&Float64 { data: 0.5 })),
        }
        sample.is_some()
    });
    let sample = sample.unwrap();
    assert_eq!(sample.topic, "/output");
    assert_eq!(
        sample.bytes,
        planesman_msgs::cdr::to_bytes(&Float64 { data: 1.0 })
    );
    assert!(sample.published.unwrap().nanos() <= sample.received.nanos());
}

#[test]
fn a_peer_that_leaves_or_is_killed_is_missed() {
    let domain = OwnDomain::claim().unwrap();
    let doubler = Doubler::start(&domain, &[]);
    let (rt, input) = joined(&domain);
    doubler.stop("-TERM");
    until(&rt, |_| input.readers() == 0);

    let doubler = Doubler::start(&domain, &[]);
    until(&rt, |_| input.readers() == 1);
    doubler.signal("-KILL");
    until(&rt, |_| input.readers() == 0);
}

/// A node that is dropped without being shut down, as by an error in its set-up, is taken down in order: the next one of the
/// process would otherwise find a writer without its participant.
#[test]
fn a_node_that_is_dropped_leaves_no_error_to_the_next_one() {
    const INNER: &str = "PLANESMAN_TEST_DROPS_NODES";
    if std::env::var_os(INNER).is_some() {
        let domain = OwnDomain::claim().unwrap();
        for _ in 0..2 {
            drop(prober(&domain));
        }
        return;
    }
    // The log is the process's, and other tests write to it.
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["a_node_that_is_dropped", "--nocapture"])
        .env(INNER, "1")
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{log}");
    assert_eq!(log.matches("up in domain").count(), 2, "{log}");
    assert!(!log.contains("[ERROR]"), "{log}");
}

#[test]
fn a_bad_argument_is_one_line_and_a_failure() {
    for (arguments, reason) in [
        (vec!["--ros-args", "-p", "gain:=fast"], "'gain'"),
        (vec!["--ros-args", "-p", "gain:=11.0"], "[0, 10]"),
        (vec!["--ros-args", "-p", "gain:=.nan"], "finite"),
        (vec!["--ros-args", "-r", "input"], "from:=to"),
        (vec!["--ros-args", "-r", "__ns:=/2nd"], "/2nd"),
        (
            vec!["--ros-args", "--params-file", "/nowhere.yaml"],
            "/nowhere.yaml",
        ),
        (vec!["--ros-args", "input.bag"], "input.bag"),
    ] {
        let output = command()
            .args(&arguments)
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.contains(reason), "{said}");
    }
}

#[test]
fn requests_of_somebody_who_never_listens_hold_up_nobody() {
    let domain = OwnDomain::claim().unwrap();
    let _doubler = Doubler::start(&domain, &[]);
    let (rt, input) = joined(&domain);
    let get = rt
        .client::<GetParameters>("/doubler/get_parameters")
        .unwrap();
    let names = vec!["gain".to_owned()];
    let gain = || {
        let names = names.clone();
        let call = get.call(GetParametersRequest { names }, PATIENCE);
        rt.block_on(call).unwrap().values[0].double_value
    };
    assert_eq!(gain(), 2.0);

    // A writer of requests without a reader of answers.
    let qos = QosPolicyBuilder::new()
        .reliable(rustdds::Duration::from_secs(10))
        .history(rustdds::policy::History::KeepLast { depth: 10 })
        .build();
    let loopback = [std::net::Ipv4Addr::LOCALHOST];
    let stranger = DomainParticipantBuilder::new(domain.id())
        .with_only_networks(loopback)
        .build()
        .unwrap();
    let (name, type_name) = (
        "rq/doubler/get_parametersRequest".to_owned(),
        GetParameters::REQUEST_DDS_TYPE_NAME.to_owned(),
    );
    let topic = stranger
        .create_topic(name, type_name, &qos, rustdds::TopicKind::NoKey)
        .unwrap();
    let publisher = stranger.create_publisher(&qos).unwrap();
    let writer = publisher
        .create_datawriter_no_key_cdr::<GetParametersRequest>(&topic, None)
        .unwrap();
    until(&rt, |_| writer.try_recv_status().is_some());
    let flood = move |requests: u32| {
        for _ in 0..requests {
            writer.write(GetParametersRequest::default(), None).unwrap();
        }
    };
    flood(500);
    assert_eq!(answer(&rt, &input, 21.0), 42.0);
    assert_eq!(gain(), 2.0);
    // Nor do theirs push others out that wait.
    let flooding = std::thread::spawn(move || flood(400));
    for _ in 0..50 {
        assert_eq!(gain(), 2.0);
    }
    flooding.join().unwrap();
    // Nor somebody who is new here.
    let describe = rt
        .client::<DescribeParameters>("/doubler/describe_parameters")
        .unwrap();
    let call = describe.call(DescribeParametersRequest { names }, PATIENCE);
    assert_eq!(rt.block_on(call).unwrap().descriptors.len(), 1);
    assert_eq!(answer(&rt, &input, 7.0), 14.0);
}
