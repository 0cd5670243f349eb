//! SROS2: the loop under DDS Security. What it says nobody hears who has no enclave of its keystore, nor does it
//! hear them; and who has one takes part, another DDS too.
//!
//! Built with the feature `security` alone (tests/README.md).

use crate::foreign;
use crate::page;
use crate::stage;
use std::io::Read as _;
use std::process::{Command, Stdio};

use foreign::{CYCLONE, root};
use page::Page;
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
        vehicle.stderr().contains("in the clear"),
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
    let folder = stage.path("keystore/enclaves/watch");
    let allowed = std::fs::read_to_string(format!("{folder}/permissions.xml")).unwrap();
    let (before, rest) = allowed.split_once("<publish>").unwrap();
    let (_, after) = rest.split_once("</publish>").unwrap();
    let own = [
        "ros_discovery_info",
        "rt/rosout",
        "rt/diagnostics",
        "rt/parameter_events",
        "rr/*Reply",
    ];
    let own = own.map(|it| format!("<topic>{it}</topic>")).concat();
    let looks = format!("{before}<publish><topics>{own}</topics></publish>{after}");
    std::fs::write(format!("{folder}/permissions.xml"), looks).unwrap();
    let signed = Command::new("openssl")
        .args([
            "smime",
            "-sign",
            "-text",
            "-in",
            "permissions.xml",
            "-out",
            "permissions.p7s",
        ])
        .args(["-signer", "../../public/permissions_ca.cert.pem"])
        .args(["-inkey", "../../private/permissions_ca.key.pem"])
        .current_dir(&folder)
        .status();
    assert!(signed.unwrap().success());
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
