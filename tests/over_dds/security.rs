//! SROS2: the loop under DDS Security. What it says nobody hears who has no enclave of its keystore, nor does it
//! hear them; and who has one takes part, another DDS too.
//!
//! Built with the feature `security` alone (tests/README.md).

use crate::foreign;
use crate::page;
use crate::recorded;
use crate::stage;
use std::io::Read as _;
use std::net::Ipv4Addr;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use foreign::{CYCLONE, root};
use page::Page;
use planesman::run_folder::RunFolder;
use planesman_flight::flight::Flight;
use planesman_msgs::Message;
use planesman_msgs::diagnostic_msgs::msg::DiagnosticArray;
use planesman_msgs::planesman_msgs::msg::VehicleState;
use planesman_msgs::rcl_interfaces::msg::Log;
use rustdds::no_key::DataWriterCdr;
use rustdds::policy::{Durability, History};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, DomainParticipantSecurityConfigFiles,
    QosPolicyBuilder, TopicKind,
};
use serde_json::json;
use stage::{Process, Received, Stage, eventually, scenario};

/// A dive that is over soon.
const DIVE: &str = "  plant_sim: {speed: 0.36576}
  depth_controller: {depth_setpoint: 0.5}
";

/// The variables that put a process under security in one enclave.
struct Credentials {
    keystore: String,
    enclave: &'static str,
}

impl Credentials {
    /// Those of a keystore of its own in the stage's folder, for the stage's domain.
    fn make(stage: &Stage, keystore: &str, enclave: &'static str) -> Self {
        let made = Self {
            keystore: stage.path(keystore),
            enclave,
        };
        let status = Command::new(root().join("tests/keystore.sh"))
            .args([&made.keystore, enclave])
            .env("ROS_DOMAIN_ID", stage.domain().to_string())
            .stdin(Stdio::null())
            .status()
            .unwrap();
        assert!(status.success());
        made
    }

    /// Permits these topics alone to be published, as DDS names them.
    fn may_publish(&self, topics: &[&str]) {
        let folder = format!("{}/enclaves{}", self.keystore, self.enclave);
        let file = format!("{folder}/permissions.xml");
        let allowed = std::fs::read_to_string(&file).unwrap();
        let (before, rest) = allowed.split_once("<publish>").unwrap();
        let (_, after) = rest.split_once("</publish>").unwrap();
        let topics = topics.iter().map(|it| format!("<topic>{it}</topic>"));
        let topics: String = topics.collect();
        let less = format!("{before}<publish><topics>{topics}</topics></publish>{after}");
        std::fs::write(file, less).unwrap();
        let of_authority = |file| format!("{}/{file}", self.keystore);
        let signed = Command::new("openssl")
            .args(["smime", "-sign", "-text", "-in", "permissions.xml"])
            .args(["-out", "permissions.p7s"])
            .args(["-signer", &of_authority("public/permissions_ca.cert.pem")])
            .args(["-inkey", &of_authority("private/permissions_ca.key.pem")])
            .current_dir(&folder)
            .status();
        assert!(signed.unwrap().success());
    }

    /// A participant with this identity in the test's own process.
    fn participant(&self, stage: &Stage) -> DomainParticipant {
        let folder = format!("{}/enclaves{}", self.keystore, self.enclave);
        let files =
            DomainParticipantSecurityConfigFiles::with_ros_default_names(folder, String::new());
        DomainParticipantBuilder::new(stage.domain())
            .with_only_networks([Ipv4Addr::LOCALHOST])
            .builtin_security(files)
            .build()
            .unwrap()
    }

    fn variables(&self) -> [(&'static str, &str); 4] {
        [
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_STRATEGY", "Enforce"),
            ("ROS_SECURITY_KEYSTORE", &self.keystore),
            ("ROS_SECURITY_ENCLAVE_OVERRIDE", self.enclave),
        ]
    }
}

/// A vehicle that waits at this depth, m.
fn vehicle(stage: &Stage, depth: f64, variables: &[(&str, &str)]) -> Process {
    let depth = format!("initial_depth:={depth}");
    let arguments = ["node", "plant_sim", "--ros-args", "-p", &depth];
    let variables = [&[(planesman::nodes::LAUNCHED, "1")], variables].concat();
    stage.start_as(&arguments, &variables)
}

#[test]
fn a_dive_is_flown_among_strangers_who_neither_hear_it_nor_are_heard() {
    let stage = Stage::new();
    let ours = Credentials::make(&stage, "ours", "/");
    let theirs = Credentials::make(&stage, "theirs", "/");

    // Either vehicle would be refused for the other, and the dive for both, if they received each other's messages.
    let mut in_the_clear = vehicle(&stage, 5.0, &[]);
    let mut of_another_authority = vehicle(&stage, 7.0, &theirs.variables());
    let listener = stage.operator();
    let depth = |received| match received {
        Received::State(state) => Some(state.depth),
        _ => None,
    };
    let received = listener.until("a vehicle in the clear", depth);
    assert!((received - 5.0).abs() < 1.0, "{received} m");

    let file = stage.file("dive.yaml", scenario(20.0, DIVE));
    let out = stage.path("out");
    let arguments = ["dive", &file, "--out", &out];
    let mut dive = stage.start_as(&arguments, &ours.variables());
    while dive.is_running() {
        let received = listener.until("the vehicle in the clear", depth);
        assert!((received - 5.0).abs() < 1.0, "{received} m");
    }
    let printed = dive.finish().success().stdout;
    assert!(printed.contains("6 processes over DDS"), "{printed}");
    assert!(in_the_clear.is_running() && of_another_authority.is_running());
}

/// A writer of a participant, as rcl offers the log; why there is none otherwise.
fn writer<M: Message>(
    participant: &DomainParticipant,
    topic: &str,
) -> Result<DataWriterCdr<M>, String> {
    let qos = QosPolicyBuilder::new()
        .reliable(rustdds::Duration::from_millis(5))
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: 10 })
        .build();
    let (name, type_name) = (format!("rt{topic}"), M::DDS_TYPE_NAME.to_owned());
    let topic = participant
        .create_topic(name, type_name, &qos, TopicKind::NoKey)
        .unwrap();
    let publisher = participant.create_publisher(&qos).unwrap();
    let writer = publisher.create_datawriter_no_key_cdr(&topic, None);
    writer.map_err(|error| error.to_string())
}

#[test]
fn a_dive_is_flown_among_forged_claims_and_floods_with_keys_and_without() {
    /// Of the dive, s and ticks.
    const SECONDS: f64 = 60.0;
    const TICKS: u64 = 1200;
    /// Memory of each node, KiB.
    const CEILING: u64 = 256 << 10;

    let Some(peer) = CYCLONE.found() else { return };
    let stage = Stage::with(peer.middleware);
    let ours = Credentials::make(&stage, "keystore", "/");
    let logs_only = Credentials::make(&stage, "keystore", "/logs_only");
    logs_only.may_publish(&["ros_discovery_info", "rt/rosout"]);

    // Who has no keys, in a DDS of its own, claims to be the vehicle and floods its topic. Others without keys hear it.
    let claim = json!({"status": [{"name": "x: claim to /auv/state", "values": [
        {"key": "stage", "value": "used"}, {"key": "since", "value": "0"},
        {"key": "id", "value": "0"}, {"key": "who", "value": "nobody"}]}]});
    let state = json!({"header": {"frame_id": "x".repeat(100_000)}});
    let outside = stage.operator();
    let send = |topic: &str, type_name: &str, message: String, rate: &str| {
        let message = [topic, type_name, "--json", &message];
        let always = ["--rate", rate, "--duration", "600", "--timeout", "90"];
        let arguments = [&message[..], &always].concat();
        peer.start("peer_pub.py", stage.domain(), &arguments)
    };
    let _intruders = [
        send(
            "/diagnostics",
            DiagnosticArray::TYPE_NAME,
            claim.to_string(),
            "20",
        ),
        send(
            "/auv/state",
            VehicleState::TYPE_NAME,
            state.to_string(),
            "50",
        ),
    ];
    outside.until("the claim", |received| {
        received.status("x: claim to /auv/state").map(|_| ())
    });
    outside.until("the flood", |received| match received {
        Received::State(state) => (state.header.frame_id.len() == 100_000).then_some(()),
        _ => None,
    });

    // Who may write log lines alone can neither claim anything nor be a vehicle.
    let inside = logs_only.participant(&stage);
    for refused in [
        writer::<DiagnosticArray>(&inside, "/diagnostics").err(),
        writer::<VehicleState>(&inside, "/auv/state").err(),
    ] {
        let refused = refused.unwrap();
        assert!(refused.contains("Not allowed"), "{refused}");
    }

    let file = stage.file("dive.yaml", scenario(SECONDS, DIVE));
    let out = stage.path("out");
    let mut dive = stage.start_as(&["dive", &file, "--out", &out], &ours.variables());
    // Two in one datagram each, and one in fragments, of which a debug build does not send a whole one in time.
    let lines = [60_000, 61_000, 1_000_000].map(|length| Log {
        msg: "x".repeat(length),
        ..Log::default()
    });
    let writers = [(); 3].map(|()| writer(&inside, "/rosout").unwrap());
    let mut most = 0;
    while dive.is_running() {
        for (writer, line) in writers.iter().zip(&lines) {
            let _ = writer.write(line.clone(), None); // Where it has no room, it is fast enough.
        }
        thread::sleep(Duration::from_millis(20));
        for pid in dive.nodes().into_values() {
            most = most.max(peak_memory(pid.as_raw_nonzero().get()));
        }
    }
    dive.finish().success();
    assert!(most < CEILING, "{most} KiB");
    let run = RunFolder::open(Path::new(&out)).unwrap();
    assert_eq!(
        Flight::read(&run.bag()).unwrap().counts["/auv/state"],
        TICKS
    );
    let said: Vec<DiagnosticArray> = recorded::messages(&run.bag(), "/diagnostics").unwrap();
    let mut said = said.iter().flat_map(|it| &it.status);
    assert!(!said.any(|it| it.name.starts_with("x: claim")));
    let said: Vec<Log> = recorded::messages(&run.bag(), "/rosout").unwrap();
    let lengths: Vec<usize> = said.iter().map(|it| it.msg.len()).collect();
    // Each of a participant's writers has keys of its own.
    for line in &lines[..2] {
        assert!(lengths.contains(&line.msg.len()), "{lengths:?}");
    }
}

/// The most memory that a process had, KiB; 0 once it has ended.
fn peak_memory(pid: i32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|it| it.trim_end_matches("kB").trim().parse().ok());
    kib.unwrap_or(0)
}

#[test]
fn a_node_without_its_enclave_is_refused_under_enforce_and_speaks_in_the_clear_otherwise() {
    let stage = Stage::new();
    let ours = Credentials::make(&stage, "ours", "/auv");
    let elsewhere = Credentials {
        enclave: "/elsewhere",
        keystore: ours.keystore.clone(),
    };
    let refused = vehicle(&stage, 0.0, &elsewhere.variables()).finish();
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");
    assert!(
        refused
            .stderr
            .contains("enclaves/elsewhere/identity_ca.cert.pem is not a file"),
        "{refused:?}"
    );

    let mut permissive = elsewhere.variables();
    permissive[1] = ("ROS_SECURITY_STRATEGY", "");
    let vehicle = vehicle(&stage, 3.0, &permissive);
    let state = stage.operator().state("the vehicle", |_| true);
    assert!((state.depth - 3.0).abs() < 1.0, "{state:?}");
    assert!(
        vehicle.stderr().contains("unencrypted"),
        "{}",
        vehicle.stderr()
    );
}

#[test]
fn a_certificate_that_no_authority_of_the_keystore_has_signed_is_refused() {
    let stage = Stage::new();
    let ours = Credentials::make(&stage, "ours", "/auv");
    Credentials::make(&stage, "theirs", "/auv");
    for file in ["cert.pem", "key.pem"] {
        let of = |keystore: &str| stage.path(&format!("{keystore}/enclaves/auv/{file}"));
        std::fs::copy(of("theirs"), of("ours")).unwrap();
    }
    let refused = vehicle(&stage, 0.0, &ours.variables()).finish();
    assert_eq!(refused.status.code(), Some(1), "{refused:?}");
    assert!(refused.stderr.contains("identity"), "{refused:?}");
}

#[test]
fn the_page_does_what_its_enclave_may_and_nothing_more() {
    let stage = Stage::new();
    let ours = Credentials::make(&stage, "keystore", "/");
    let page = Credentials::make(&stage, "keystore", "/watch");
    let _vehicle = vehicle(&stage, 0.0, &ours.variables());
    let pause = r#"{"do":"set_bool","service":"/auv/plant_sim/pause","data":true}"#;
    let show = || {
        let arguments = ["watch", "--no-open"];
        let launched = [(planesman::nodes::LAUNCHED, "1")];
        let program = stage.start_as(&arguments, &[&launched[..], &page.variables()].concat());
        let shown = Page::of(&program);
        // It draws.
        let mut stream = shown.stream(&["/auv/state:depth"]);
        let (mut text, mut part) = (String::new(), [0; 4096]);
        eventually("samples", || {
            let count = stream.read(&mut part).unwrap();
            text += &String::from_utf8_lossy(&part[..count]);
            text.contains("\"series\":[[0").then_some(())
        });
        (program, shown)
    };

    // One that only looks (docs/security.md).
    page.may_publish(&[
        "ros_discovery_info",
        "rt/rosout",
        "rt/diagnostics",
        "rt/parameter_events",
        "rr/*Reply",
    ]);
    let (program, shown) = show();
    eventually("a refusal, once the vehicle's services are known", || {
        let answer = shown.post(pause);
        assert!(!answer.contains("\"ok\":true"), "{answer}");
        answer.contains("not allowed by security").then_some(())
    });
    let setpoint = r#"{"do":"publish","topic":"/auv/depth_setpoint","text":"2"}"#;
    let answer = shown.post(setpoint);
    assert!(answer.contains("not allowed by security"), "{answer}");
    drop(program);

    // As the script makes it: every topic may be used.
    Credentials::make(&stage, "keystore", "/watch");
    let (_program, shown) = show();
    eventually("the vehicle is paused", || {
        let answer = shown.post(pause);
        answer.contains("\"ok\":true").then_some(())
    });
}

#[test]
fn another_dds_with_an_enclave_hears_commands_and_calls_the_nodes_and_without_one_nothing() {
    let Some(peer) = CYCLONE.found() else { return };
    // Who begins the handshake follows from the enclaves' names: one peer that does, one that does not.
    for enclave in ["/a", "/peer"] {
        let stage = Stage::with(peer.middleware);
        let ours = Credentials::make(&stage, "keystore", "/auv");
        let theirs = Credentials::make(&stage, "keystore", enclave);
        let controller = ["node", "depth_controller"];
        let _nodes = [
            vehicle(&stage, 0.0, &ours.variables()),
            stage.start_as(&controller, &ours.variables()),
        ];
        let variables = theirs.variables();
        let with = |program: &str, arguments: &[&str]| {
            peer.run_as(program, stage.domain(), arguments, &variables)
        };

        let speed = with("peer_params.py", &["/auv/plant_sim", "get", "speed"]).answer();
        assert_eq!(speed["value"], 0.3048, "{speed}");

        let setpoint = [
            "/auv/depth_setpoint",
            "std_msgs/msg/Float64",
            "--json",
            "{\"data\": 0.75}",
        ];
        with(
            "peer_pub.py",
            &[&setpoint[..], &["--rate", "5", "--duration", "2"]].concat(),
        )
        .well();
        let said = [
            "/auv/control_state",
            "planesman_msgs/msg/ControlState",
            "--count",
            "1",
        ];
        let said = with("peer_echo.py", &[&said[..], &["--timeout", "30"]].concat()).answer();
        assert_eq!(said["depth_target"], 0.75, "{said}");

        let topics = peer.run("peer_topics.py", stage.domain(), &["--timeout", "3"]);
        assert_eq!(topics.well(), [serde_json::Value::Null; 0]);
    }
}
