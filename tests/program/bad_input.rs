//! Everything that can be wrong with what a user gives: each is refused with one line that names where
//! it came from, the value and the rule, and nothing is left that could be taken for a result.

use crate::stage;
use std::fs::File;
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

use planesman_node::STRICT_PARAMETERS;
use stage::{Signal, Stage, eventually, scenario};

/// The vehicle of the report, for a copy with a fault.
const VEHICLE: &str = include_str!("../../crates/vehicle/vehicle/vehicles/brunner.yaml");

/// One with six degrees of freedom and thrusters.
const SIX_DOF: &str =
    include_str!("../../crates/vehicle/vehicle/vehicles/six_dof/bluerov2_heavy.yaml");

/// The first bytes of a photograph.
const JPEG: &[u8] = b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01\x01\x01\x00H\x00H\x00\x00\xff\xdb\x00C";

/// `planesman ARGUMENTS` ends with status `code` and one line that holds all of `says`, and
/// leaves the stage as it was.
fn refused(stage: &Stage, code: i32, arguments: &[&str], says: &[&str]) {
    refused_as(stage, code, arguments, &[], says);
}

/// Like [`refused`], with more in the environment.
fn refused_as(
    stage: &Stage,
    code: i32,
    arguments: &[&str],
    variables: &[(&str, &str)],
    says: &[&str],
) {
    let before = stage.content();
    let outcome = stage.start_as(arguments, variables).finish();
    assert_eq!(
        outcome.status.code(),
        Some(code),
        "{arguments:?}: {outcome:#?}"
    );
    let complaints = outcome.complaints();
    assert_eq!(complaints.len(), 1, "{arguments:?}: {outcome:#?}");
    for part in says {
        assert!(
            complaints[0].contains(part),
            "{arguments:?}: no '{part}' in: {}",
            complaints[0]
        );
    }
    assert!(!outcome.stderr.contains("panicked"), "{outcome:#?}");
    assert_eq!(stage.content(), before, "{arguments:?}");
}

/// A scenario file is refused the same way by both that fly it.
fn refused_scenario(stage: &Stage, file: &str, says: &[&str]) {
    let says = [&["planesman: "], says].concat();
    refused(
        stage,
        1,
        &["dive", file, "--out", &stage.path("dive")],
        &says,
    );
    refused(
        stage,
        1,
        &["sim", file, "--out", &stage.path("sim.mcap")],
        &says,
    );
    refused(
        stage,
        1,
        &["sim", file, "--out", &stage.path("sim.csv")],
        &says,
    );
}

#[test]
fn a_scenario_with_a_bad_value_is_refused_before_anything_starts() {
    let stage = Stage::new();
    for (parameters, says) in [
        (
            "  depth_controller: {depth.q: 1.0}",
            vec!["depth_controller", "depth.q", "has no parameter"],
        ),
        (
            "  depth_controller: {depth: {p: .nan}}",
            vec!["depth_controller", "depth.p", "finite"],
        ),
        (
            "  plant_sim: {speed: -0.3}",
            vec!["plant_sim", "speed", "-0.3", "[0, 5]"],
        ),
        (
            "  plant_sim: {vehicle: nowhere.yaml}",
            vec!["nowhere.yaml", "No such file"],
        ),
        (
            "  dha_actuator: {actuator: nowhere.yaml}",
            vec!["nowhere.yaml", "No such file"],
        ),
        (
            "  dha_actuator: {actuator: /dev/zero}",
            vec!["/dev/zero", "not a regular file"],
        ),
        (
            "  depth_controller: {planes.limit: 0.0}",
            vec!["planes.limit"],
        ),
        (
            "  recorder: {topics: [stat]}",
            vec!["recorder", "'stat'", "plane_motion"],
        ),
        ("  rudder: {}", vec!["'rudder'", "depth_controller"]),
    ] {
        let file = stage.file("bad.yaml", scenario(1.0, parameters));
        refused_scenario(&stage, &file, &says);
    }
}

#[test]
fn a_vehicle_file_with_a_negative_mass_names_the_file_the_field_and_the_rule() {
    let stage = Stage::new();
    let weightless = VEHICLE.replace("mass: 0.6", "mass: -0.6");
    assert_ne!(weightless, VEHICLE);
    let vehicle = stage.file("vehicle.yaml", weightless);
    let parameters = format!("  plant_sim: {{vehicle: {vehicle}}}");
    let file = stage.file("bad.yaml", scenario(1.0, &parameters));
    let says = ["vehicle.yaml", "mass", "above zero"];
    refused_scenario(&stage, &file, &says);
    let vehicle = format!("vehicle:={vehicle}");
    let arguments = ["node", "plant_sim", "--ros-args", "-p", &vehicle];
    refused(&stage, 1, &arguments, &says);
}

/// The default of `hover.vehicle`, which nobody wrote, is the vehicle that flies.
#[test]
fn a_broken_vehicle_is_refused_by_the_parameter_that_names_it() {
    let stage = Stage::new();
    let broken = SIX_DOF.replace("\nmass:", "\nmas:");
    assert_ne!(broken, SIX_DOF);
    let vehicle = stage.file("broken.yaml", broken);
    let set = format!("plant_sim.vehicle={vehicle}");
    let out = stage.path("out.csv");
    let says = ["plant_sim.vehicle: ", "broken.yaml", "mas"];
    let arguments = ["sim", "bluerov2", "--set", &set, "--out", &out];
    refused(&stage, 1, &arguments, &says);
    let hovers = format!("depth_controller.hover.vehicle={vehicle}");
    let arguments = ["sim", "bluerov2", "--set", &hovers, "--out", &out];
    refused(&stage, 1, &arguments, &["'hover.vehicle'", "broken.yaml"]);
}

#[test]
fn what_is_no_scenario_is_refused_by_name() {
    let stage = Stage::new();
    refused_scenario(&stage, "dvie", &["'dvie'", "dive, lauv, open_loop"]);
    refused_scenario(&stage, "/dev/zero", &["'/dev/zero'", "not a regular file"]);
    let folder = stage.path("folder");
    std::fs::create_dir(&folder).unwrap();
    refused_scenario(&stage, &folder, &["folder'", "not a regular file"]);
    for (name, content, says) in [
        ("photo.jpg", JPEG.to_vec(), "not UTF-8 text"),
        ("empty.yaml", Vec::new(), "missing field"),
        ("huge.yaml", vec![b'#'; 3 << 20], "1048576"),
        (
            "long.yaml",
            scenario(1e9, "  {}").into_bytes(),
            "duration: 1000000000",
        ),
        (
            "never.yaml",
            b"{description: d, duration: .nan}".to_vec(),
            "duration: NaN",
        ),
        (
            "other.yaml",
            b"{description: d, duration: 1, gain: 2}".to_vec(),
            "gain",
        ),
    ] {
        let file = stage.file(name, content);
        refused_scenario(&stage, &file, &[name, says]);
    }
    for (_, text) in planesman_testing::hostile::yaml() {
        let file = stage.file("hostile.yaml", text);
        refused_scenario(&stage, &file, &["hostile.yaml"]);
        let arguments = ["node", "plant_sim", "--ros-args", "--params-file", &file];
        refused(&stage, 1, &arguments, &["plant_sim: ", "hostile.yaml"]);
        let vehicle = format!("vehicle:={file}");
        let arguments = ["node", "plant_sim", "--ros-args", "-p", &vehicle];
        refused(&stage, 1, &arguments, &["plant_sim: ", "hostile.yaml"]);
    }
}

#[test]
fn a_taken_path_is_never_written_to() {
    let stage = Stage::new();
    let short = stage.file("short.yaml", scenario(1.0, "  {}"));
    let mine = stage.file("mine.mcap", "mine");
    let folder = stage.path("mine");
    std::fs::create_dir(&folder).unwrap();
    for out in [&mine, &folder] {
        let says = ["planesman: ", out, "exists"];
        refused(&stage, 1, &["dive", &short, "--out", out], &says);
        let output = format!("output:={out}");
        let arguments = ["node", "recorder", "--ros-args", "-p", &output];
        refused(&stage, 1, &arguments, &["recorder: ", out, "exists"]);
    }
    let says = ["planesman: ", &mine, "exists"];
    refused(&stage, 1, &["sim", &short, "--out", &mine], &says);
    assert_eq!(std::fs::read(&mine).unwrap(), b"mine");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
}

#[test]
fn an_output_that_cannot_be_is_refused_before_the_flight() {
    let stage = Stage::new();
    let short = stage.file("short.yaml", scenario(1.0, "  {}"));
    for (out, says) in [
        ("flight.txt", "*.mcap or *.csv"),
        ("nowhere/flight.mcap", "nowhere"),
        ("nowhere/flight.csv", "nowhere"),
        ("short.yaml/flight.csv", "short.yaml"),
    ] {
        let out = stage.path(out);
        refused(
            &stage,
            1,
            &["sim", &short, "--out", &out],
            &["planesman: ", says],
        );
    }
    let out = stage.path("short.yaml/flight");
    refused(
        &stage,
        1,
        &["dive", &short, "--out", &out],
        &["planesman: ", "short.yaml"],
    );

    // The nodes get it as a parameter. `start` takes text alone.
    let out = std::ffi::OsStr::from_bytes(b"flight\xff");
    let refusal = Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args(["dive", &short, "--out"])
        .arg(Path::new(&stage.path("")).join(out))
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .unwrap();
    assert_eq!(refusal.status.code(), Some(1), "{refusal:?}");
    let said = String::from_utf8_lossy(&refusal.stderr);
    assert!(said.contains("is not UTF-8 text"), "{said}");
    assert_eq!(stage.content(), ["short.yaml"]);
}

#[test]
fn what_is_no_bag_is_called_so() {
    let stage = Stage::new();
    let photo = stage.file("photo.jpg", JPEG);
    let named = stage.file("photo.mcap", JPEG);
    let empty = stage.path("empty");
    std::fs::create_dir(&empty).unwrap();
    let none = stage.path("none");
    for path in [&photo, &named, &empty, &none] {
        refused(&stage, 1, &["bag", "info", path], &["planesman: ", path]);
        refused(&stage, 1, &["replay", path], &["planesman: ", path]);
        refused(&stage, 1, &["report", path], &["planesman: ", path]);
    }
}

#[test]
fn a_wrong_argument_is_named_with_what_would_be_right() {
    let stage = Stage::new();
    let out = stage.path("out");
    for (factor, says) in [
        ("fast", "a number"),
        ("-1", "from 0.01 to 100"),
        ("0", "from 0.01 to 100"),
        ("1e9", "from 0.01 to 100"),
        ("nan", "from 0.01 to 100"),
    ] {
        let factor = format!("--factor={factor}");
        let arguments = ["dive", &factor, "--out", &out];
        refused(&stage, 2, &arguments, &["planesman: ", "--factor", says]);
    }
    for (arguments, says) in [
        (vec!["dive", "--lockstep", "--factor", "2"], "--lockstep"),
        (vec!["dive", "--fast"], "--fast"),
        (vec!["sim", "dive", "--out"], "--out"),
        (
            vec!["surface"],
            "'surface' is neither a command nor a scenario",
        ),
        (
            vec!["tun", "model.yaml"],
            "'tun' is neither a command nor a scenario; did you mean 'tune'?",
        ),
        (
            vec!["sysid", "fit", "a.csv", "--order", "two"],
            "a whole number is expected",
        ),
        (
            vec!["tf", "brunner", "--speed", "-1"],
            "a number from 0.001 to 100",
        ),
        (
            vec!["tf", "brunner", "--speed", "nan"],
            "see planesman tf --help",
        ),
        (
            vec!["tf", "brunner", "--rate", "0"],
            "a number from 0.01 to 10000",
        ),
        (vec!["design", "locus"], "see planesman design locus --help"),
        (
            vec!["help", "tun"],
            "unknown command 'tun'; did you mean 'tune'? (see planesman --help)",
        ),
        (
            vec!["sysid", "help", "fti"],
            "unknown command 'fti'; did you mean 'fit'? (see planesman sysid --help)",
        ),
        (
            vec!["help", "sysid", "fti"],
            "unknown command 'fti'; did you mean 'fit'? (see planesman sysid --help)",
        ),
        (
            vec!["bag", "dif"],
            "unknown command 'dif'; did you mean 'diff'?",
        ),
    ] {
        refused(&stage, 2, &arguments, &["planesman: ", says]);
    }
    let doubled = ["known: recorder, ", "plant_sim; did you mean 'plant_sim'?"];
    let set = ["sim", "dive", "--out", &out, "--set", "plantsim.speed=1"];
    refused(&stage, 1, &set, &doubled);
    refused(&stage, 1, &["params", "plantsim"], &doubled);
    let scenario = ["unknown scenario 'dvie'", "; did you mean 'dive'?"];
    refused(&stage, 1, &["sim", "dvie", "--out", &out], &scenario);
    for (arguments, says) in [
        (vec!["dive", "--namespace", "2nd", "--out", &out], "2nd"),
        (vec!["params", "rudder"], "'rudder'"),
        (vec!["node", "rudder"], "'rudder'"),
    ] {
        refused(&stage, 1, &arguments, &["planesman: ", says]);
    }
}

#[test]
fn a_number_below_zero_is_refused_by_the_range_of_its_option() {
    let stage = Stage::new();
    let whole = "a whole number from ";
    for (command, option, value, says) in [
        (
            "dive",
            "--factor",
            "-1",
            "': a number from 0.01 to 100 is expected",
        ),
        ("sweep dive", "--seeds", "-1", whole),
        ("sweep dive", "--samples", "-3", whole),
        ("sweep dive", "--shard", "-1/4", "I from 1 to N"),
        ("watch", "--port", "-1", "from 0 to 65535"),
        ("sysid topics a.csv", "--most-unpacked", "-1", whole),
        ("sysid topics a.csv", "--most-unpacked", "0", whole),
        (
            "sysid topics a.csv",
            "--sample-time",
            "-1s",
            "from 0.000001",
        ),
        (
            "sysid fit a.csv",
            "--delay",
            "-1",
            "from 0 to 1000 is expected",
        ),
        (
            "sysid fit a.csv",
            "--order",
            "-1",
            "from 0 to 64 is expected",
        ),
        (
            "sysid fit a.csv",
            "--order",
            "400",
            "from 0 to 64 is expected",
        ),
        ("sysid fit a.csv", "--numerator", "-2", whole),
        ("sysid fit a.csv", "--bootstrap", "-2", whole),
        (
            "sysid fit a.csv",
            "--coherence",
            "-0.5",
            "from 0.05 to 0.999",
        ),
        ("sysid fit a.csv", "--inertia", "-0.5", "a number above 0"),
        ("sysid fit a.csv", "--noise", "-1e-3", "a number above 0"),
        ("sysid fit a.csv", "--bias-drift", "-1", "0 or more"),
        (
            "sysid fit a.csv",
            "--speed",
            "-1ft/s",
            "from 0.001 to 100 m/s",
        ),
        ("sysid fit a.csv", "--prefilter", "-1..2", "--prefilter"),
        ("sysid fit a.csv", "--unwrap", "-1", "a period above 0"),
        ("sysid compare m.yaml a.csv", "--ahead", "-1", whole),
        ("tune m.yaml", "--ms", "-1", "from 1.05 to 100"),
        ("tune m.yaml", "--seed", "-1", "from 0 to 4294967295"),
        ("bag diff a b", "--most-unpacked", "-3", whole),
        ("dha design dfcu --load-cycle a", "--seeds", "-1", whole),
        ("six-dof fly lauv", "--wave", "-1,2", "three numbers"),
        (
            "design locus --vary speed",
            "--to",
            "-1m/s",
            "from 0 to 1000",
        ),
        (
            "six-dof fit a --like lauv",
            "--horizon",
            "-1",
            "from 1 to 100000",
        ),
    ] {
        let arguments: Vec<&str> = command.split(' ').chain([option, value]).collect();
        let named = format!("invalid value '{value}' for '{option} <");
        refused(&stage, 2, &arguments, &["planesman: ", &named, says]);
    }
    let current = ["six-dof", "fly", "lauv", "--duration", "1"];
    let current = [&current[..], &["--current", "-0.1,0,0"]].concat();
    stage.run(&current).success();
}

#[test]
fn a_node_refuses_wrong_ros_arguments() {
    let stage = Stage::new();
    let photo = stage.file("photo.yaml", JPEG);
    for (arguments, says) in [
        (vec!["-p", "depth.p:=.nan"], vec!["depth.p", "finite"]),
        (vec!["-p", "depth.p:=deep"], vec!["depth.p", "deep"]),
        (vec!["-p", "depth.p"], vec!["depth.p", "name:=value"]),
        (vec!["--params-file", &photo], vec!["photo.yaml"]),
        (vec!["--params-file", "nowhere.yaml"], vec!["nowhere.yaml"]),
        (
            vec!["--params-file", "/dev/zero"],
            vec!["/dev/zero", "not a regular file"],
        ),
        (vec!["-r", "__ns:=/2nd"], vec!["/2nd"]),
        (vec!["--frobnicate"], vec!["--frobnicate"]),
    ] {
        let arguments = [&["node", "depth_controller", "--ros-args"], &arguments[..]].concat();
        let says = [&["depth_controller: "], &says[..]].concat();
        refused(&stage, 1, &arguments, &says);
    }
}

#[test]
fn a_name_that_a_node_does_not_declare_is_an_error_where_the_start_is_strict_and_else_a_warning() {
    let stage = Stage::new();
    let robot =
        "/**:\n  ros__parameters: {use_sim_time: false, robot_radius: 0.2, depth: {pp: 1.0}}\n";
    let robot = stage.file("robot.yaml", robot);
    let arguments = [
        "node",
        "depth_controller",
        "--ros-args",
        "--params-file",
        &robot,
    ];
    let strict = [(STRICT_PARAMETERS, "1")];
    refused_as(
        &stage,
        1,
        &arguments,
        &strict,
        &["robot_radius", "not declared"],
    );
    let typo = [
        "node",
        "plant_sim",
        "--ros-args",
        "-p",
        "initial_depht:=1.0",
    ];
    let meant = "did you mean 'initial_depth'?";
    refused_as(&stage, 1, &typo, &strict, &["plant_sim: ", meant]);

    let node = stage.start(&arguments);
    eventually("a node that is up", || {
        node.stderr().contains("up in domain").then_some(())
    });
    node.signal(Signal::INT);
    let outcome = node.finish().success();
    let complaints = outcome.complaints();
    assert_eq!(complaints.len(), 2, "{complaints:?}");
    assert!(complaints[0].contains("parameter 'robot_radius' is not declared"));
    assert!(
        complaints[1].contains("did you mean 'depth.p'?"),
        "{complaints:?}"
    );
}

#[test]
fn an_environment_that_is_not_ros_is_refused_before_anything_starts() {
    let stage = Stage::new();
    let out = stage.path("out");
    for (name, value) in [
        ("ROS_DOMAIN_ID", "harbour"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "PLANET"),
        ("RMW_IMPLEMENTATION", "rmw_carrier_pigeon"),
    ] {
        let outcome = stage
            .start_as(&["dive", "--out", &out], &[(name, value)])
            .finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        let complaints = outcome.complaints();
        assert_eq!(complaints.len(), 1, "{outcome:#?}");
        assert!(complaints[0].contains(name) && complaints[0].contains(value));
        assert_eq!(stage.content(), [""; 0]);
    }
}

#[test]
fn a_command_bears_that_nobody_reads_it_and_says_that_it_cannot_write() {
    let params = |stdout: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_planesman"));
        command.arg("params").stdout(stdout).stderr(Stdio::piped());
        command.spawn().unwrap()
    };
    let mut unread = params(Stdio::piped());
    drop(unread.stdout.take());
    let outcome = unread.wait_with_output().unwrap();
    assert!(outcome.status.success() && outcome.stderr.is_empty());

    let full = File::options().write(true).open("/dev/full").unwrap();
    let outcome = params(full.into()).wait_with_output().unwrap();
    assert_eq!(outcome.status.code(), Some(1));
    let said = String::from_utf8_lossy(&outcome.stderr);
    assert!(
        said.contains("No space left") && said.lines().count() == 1,
        "{said}"
    );
}

#[test]
fn a_node_that_is_to_enforce_security_does_not_speak_in_the_clear() {
    let stage = Stage::new();
    let enforce = [
        ("ROS_SECURITY_ENABLE", "true"),
        ("ROS_SECURITY_STRATEGY", "Enforce"),
    ];
    for arguments in [&["node", "plant_sim"][..], &["dive"]] {
        let outcome = stage.start_as(arguments, &enforce).finish();
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        let complaints = outcome.complaints();
        assert_eq!(complaints.len(), 1, "{outcome:#?}");
        assert!(complaints[0].contains("ROS_SECURITY_STRATEGY=Enforce"));
        assert_eq!(stage.content(), [""; 0]);
    }
}
