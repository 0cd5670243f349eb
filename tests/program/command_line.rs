//! The command line as its user meets it: what is refused before the work is done, names and units as they are
//! written, and the remedy in the refusal.

use crate::stage;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use stage::{Signal, Stage, eventually};

/// `planesman ARGUMENTS` ends with status `code`, prints nothing, and says all of `says` in one line.
fn refused(stage: &Stage, code: i32, arguments: &[&str], says: &[&str]) {
    let outcome = stage.run(arguments);
    assert_eq!(outcome.status.code(), Some(code), "{outcome:#?}");
    assert!(outcome.stdout.is_empty(), "{outcome:#?}");
    let complaints = outcome.complaints();
    assert_eq!(complaints.len(), 1, "{arguments:?}: {outcome:#?}");
    for part in says {
        assert!(
            complaints[0].contains(part),
            "no '{part}' in: {}",
            complaints[0]
        );
    }
}

/// A flight of a few seconds in one process.
fn flight(stage: &Stage, name: &str) {
    let text = stage::scenario(5.0, "");
    let file = stage.file("short.yaml", text);
    stage.run(&["sim", &file, "--out", name]).success();
}

#[test]
fn a_file_that_could_not_be_written_is_refused_before_anything_is_computed() {
    let stage = Stage::new();
    flight(&stage, "flight.csv");
    stage.file("there.json", "{}");
    let fit = [
        "sysid",
        "fit",
        "flight.csv",
        "-i",
        "dive_planes",
        "-o",
        "pitch",
    ];
    for option in ["--html", "--model"] {
        let missing = [&fit[..], &[option, "no/such/x.json"]].concat();
        refused(
            &stage,
            2,
            &missing,
            &["no/such/x.json", "the folder 'no/such' does not exist"],
        );
        let there = [&fit[..], &[option, "there.json"]].concat();
        refused(&stage, 2, &there, &["there.json", "exists already"]);
    }
    let locus = [
        "design",
        "locus",
        "--vary",
        "speed",
        "--to",
        "1",
        "--html",
        "there.json",
    ];
    refused(&stage, 2, &locus, &["exists already"]);
    refused(
        &stage,
        1,
        &["sim", "dive", "--out", "flight.csv"],
        &["flight.csv"],
    );
}

#[test]
fn a_column_is_named_without_its_unit_and_a_signal_must_say_which_number_it_is() {
    let stage = Stage::new();
    flight(&stage, "flight.csv");
    flight(&stage, "flight.mcap");
    let fit = |data: &str, input: &str, output: &str| {
        stage.run(&[
            "sysid", "fit", data, "-i", input, "-o", output, "--order", "1",
        ])
    };
    for (data, input, output, says) in [
        (
            "flight.csv",
            "dive_plane",
            "pitch",
            "did you mean 'dive_planes'?",
        ),
        (
            "flight.csv",
            "pitch",
            "pitch [rad]",
            "is named both as input and as output",
        ),
        (
            "flight.mcap",
            "state:pitch",
            "/auv/state:pitch",
            "is named both as input and as output",
        ),
        (
            "flight.mcap",
            "planes:position",
            "state:pitch",
            "a list of 2 numbers, one for each 'name' (",
        ),
        (
            "flight.mcap",
            "planes:position[dive_plane]",
            "state:pitch",
            "did you mean 'dive_planes'?",
        ),
        (
            "flight.mcap",
            "stat:pitch",
            "state:pitch",
            "did you mean 'state'?",
        ),
        (
            "flight.mcap",
            "state:pich",
            "state:heave",
            "did you mean 'pitch'?",
        ),
    ] {
        let outcome = fit(data, input, output);
        assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
        assert!(outcome.stderr.contains(says), "{outcome:#?}");
    }
    for joint in ["planes:position[0]", "planes:position[dive_planes]"] {
        let outcome = fit("flight.mcap", joint, "state:pitch_rate");
        assert!(outcome.stdout.contains("pitch_rate"), "{outcome:#?}");
    }
    assert!(
        fit("flight.csv", "dive_planes", "pitch_rate")
            .stdout
            .contains("pitch_rate")
    );
}

#[test]
fn work_ends_when_its_reader_has_gone() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args("dha design dfcu --load-cycle dive --seeds 1000".split(' '))
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let begin = Instant::now();
    let status = stage::eventually("the end of the program", || child.try_wait().unwrap());
    assert!(status.success(), "{status}");
    // The work itself takes longer in a build for tests.
    assert!(begin.elapsed() < Duration::from_secs(10));
}

#[test]
fn a_speed_is_in_si_unless_its_unit_is_written() {
    let stage = Stage::new();
    let tf = |speed: &str| stage.run(&["tf", "brunner", "--speed", speed]).stdout;
    assert_eq!(tf("1ft/s"), tf("0.3048"));
    assert!(tf("1ft/s").contains("0.3048 m/s"), "{}", tf("1ft/s"));
    let analyse = |speeds: &str| stage.run(&["design", "analyse", "--speed", speeds]).stdout;
    let numbers = |speeds: &str| analyse(speeds).split_once("\nNext:").unwrap().0.to_owned();
    assert_eq!(numbers("1ft/s,3ft/s"), numbers("0.3048,0.9144"));
    refused(
        &stage,
        2,
        &["tf", "brunner", "--speed", "1ft"],
        &["m/s, ft/s"],
    );
}

#[test]
fn an_actuator_has_one_name_in_design_in_scenarios_and_in_the_actuator_s_own_commands() {
    let stage = Stage::new();
    for name in ["ideal", "first_order"] {
        let fly = |parameter: &str| {
            let out = format!("{parameter}-{name}.csv");
            let set = format!("dha_actuator.{parameter}={name}");
            let short = stage.file("short.yaml", stage::scenario(5.0, "  plant_sim: {}\n"));
            stage
                .run(&["sim", &short, "--set", &set, "--out", &out])
                .success();
            std::fs::read(stage.path(&out)).unwrap()
        };
        assert!(fly("actuator") == fly("model"), "{name}");
        let design = ["design", "analyse", "--actuator", name];
        let design = stage.run(&design);
        assert!(
            design.stdout.contains(&format!("with actuator {name}")),
            "{design:#?}"
        );
        refused(
            &stage,
            1,
            &["dha", "size", name],
            &[name, "without hydraulics", "auv"],
        );
    }
    refused(
        &stage,
        1,
        &["dha", "size", "table_31"],
        &["did you mean 'table_3_1'?"],
    );
}

#[test]
fn the_program_prints_its_completions_and_its_manual() {
    let stage = Stage::new();
    let completions = stage.run(&["completions", "bash"]);
    assert!(
        completions.stdout.contains("limit-cycles"),
        "{completions:#?}"
    );
    let manual = stage.run(&["man"]);
    assert!(manual.stdout.contains(".TH planesman"), "{manual:#?}");
    let fit = stage.run(&["man", "sysid", "fit"]);
    assert!(fit.stdout.contains("heave"), "{fit:#?}");
    refused(
        &stage,
        1,
        &["man", "sysid", "fitt"],
        &["did you mean 'fit'?"],
    );
}

#[test]
fn a_doctor_finds_nothing_wrong_where_the_tests_run_and_names_what_is() {
    let stage = Stage::new();
    let well = stage.run(&["doctor"]);
    for line in ["domain and range", "middleware", "multicast", "other loops"] {
        assert!(
            well.stdout.contains(&format!("ok       {line}")),
            "{well:#?}"
        );
    }
    assert!(well.stdout.contains("planesman_msgs"), "{well:#?}");
    assert!(well.stdout.contains("Ready: dives work here."), "{well:#?}");
    let variables = [("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")];
    let ill = stage.start_as(&["doctor"], &variables).finish();
    assert_eq!(ill.status.code(), Some(1), "{ill:#?}");
    assert!(ill.stdout.contains("TROUBLE  middleware"), "{ill:#?}");
    assert!(ill.complaints()[0].contains("Unset it"), "{ill:#?}");
}

#[test]
fn a_table_is_printed_in_the_format_that_is_asked_for() {
    let stage = Stage::new();
    let params = |format: &str| {
        stage
            .run(&["params", "recorder", "--format", format])
            .stdout
    };
    assert!(
        params("table")
            .lines()
            .all(|line| line.chars().count() <= 80)
    );
    assert!(
        params("md").starts_with("| node | parameter | default | rules | description |\n|---|")
    );
    assert!(params("csv").starts_with("node,parameter,default,rules,description\n"));
    let json: serde_json::Value = serde_json::from_str(&params("json")).unwrap();
    assert_eq!(json[0]["node"], "recorder");
    let coefficients = ["coefficients", "brunner", "--format", "csv"];
    assert!(stage.run(&coefficients).stdout.contains("M'delta"));
    let sizes = ["dha", "size", "table_4_1", "--format", "csv"];
    assert!(
        stage
            .run(&sizes)
            .stdout
            .starts_with("quantity,SI,unit,report,report's unit\n")
    );
    flight(&stage, "flight.mcap");
    let topics = ["sysid", "topics", "flight.mcap", "--format", "csv"];
    assert!(stage.run(&topics).stdout.contains("\n/auv/state:pitch,"));
}

#[test]
fn a_nodes_log_has_the_form_the_colours_and_the_file_that_rcls_variables_ask_for() {
    let stage = Stage::new();
    let folder = stage.path("log");
    let variables = [
        (
            "RCUTILS_CONSOLE_OUTPUT_FORMAT",
            "{severity}|{name}|{message}",
        ),
        ("RCUTILS_COLORIZED_OUTPUT", "1"),
        ("ROS_LOG_DIR", &folder),
    ];
    // As `ros2 run` passes on what is not ROS's.
    let arguments = [
        "node",
        "plant_sim",
        "extra",
        "--ros-args",
        "--log-level",
        "plant_sim:=debug",
    ];
    let node = stage.start_as(&arguments, &variables);
    let up = "\x1b[0mINFO|auv.plant_sim|up in domain";
    eventually("a node that is up", || {
        node.stderr().contains(up).then_some(())
    });
    node.signal(Signal::INT);
    let outcome = node.finish().success();
    let passed_over =
        "\x1b[33mWARN|auv.plant_sim|ignored: extra: ROS arguments must follow --ros-args\x1b[0m\n";
    assert!(outcome.stderr.starts_with(passed_over), "{outcome:#?}");
    assert!(!outcome.stderr.contains("rustdds"), "{outcome:#?}");

    let files: Vec<_> = std::fs::read_dir(&folder).unwrap().collect();
    let [Ok(file)] = &files[..] else {
        panic!("{files:?}")
    };
    let name = file.file_name().into_string().unwrap();
    assert!(
        name.starts_with("plant_sim_") && name.ends_with(".log"),
        "{name}"
    );
    let written = std::fs::read_to_string(file.path()).unwrap();
    assert!(
        written.contains("\nINFO|auv.plant_sim|up in domain"),
        "{written}"
    );
    assert!(!written.contains('\x1b'));
}

#[test]
fn results_are_replaced_when_asked_and_nothing_else_is() {
    let stage = Stage::new();
    let page = stage.file("loop.html", "before");
    let analyse = ["design", "analyse", "--html", &page];
    refused(&stage, 2, &analyse, &["add --overwrite"]);
    stage
        .run(&[&analyse[..], &["--overwrite"]].concat())
        .success();
    assert!(std::fs::read_to_string(&page).unwrap().contains("</html>"));
    let file = stage.file("short.yaml", stage::scenario(1.0, ""));
    let sim = ["sim", &file, "--out", "flight.csv"];
    stage.run(&sim).success();
    refused(&stage, 1, &sim, &["exists already"]);
    stage.run(&[&sim[..], &["--overwrite"]].concat()).success();
    // A folder that no flight left stays.
    std::fs::create_dir(stage.path("mine")).unwrap();
    let dive = ["dive", &file, "--out", "mine", "--overwrite"];
    refused(&stage, 1, &dive, &["exists already"]);
    assert!(stage.content().contains(&"mine".to_owned()));
    // Nor does one of a flight with a file of somebody else in it.
    std::fs::write(stage.path("mine/scenario.yaml"), "").unwrap();
    std::fs::write(stage.path("mine/thesis.txt"), "mine").unwrap();
    refused(&stage, 1, &dive, &["the folder contains 'thesis.txt'"]);
    assert!(std::fs::exists(stage.path("mine/thesis.txt")).unwrap());
    let here = ["dive", &file, "--out", ".", "--overwrite"];
    std::fs::write(stage.path("scenario.yaml"), "").unwrap();
    refused(&stage, 1, &here, &["the current folder"]);
    // A file that the command could not write, or is no page, is as it was.
    let kept = stage.file("kept.txt", "before");
    let sim = ["sim", &file, "--out", &kept, "--overwrite"];
    refused(&stage, 1, &sim, &["*.mcap or *.csv"]);
    let analyse = ["design", "analyse", "--html", &kept, "--overwrite"];
    refused(&stage, 2, &analyse, &["replaces only pages, *.html"]);
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), "before");
    // Nor is what the command reads.
    let flight = ["flight.csv", "flight.csv", "--html", "flight.csv"];
    let diff = [&["bag", "diff"], &flight[..], &["--overwrite"]].concat();
    refused(&stage, 2, &diff, &["names this file twice"]);
    assert!(std::fs::exists(stage.path("flight.csv")).unwrap());
}

/// A sweep writes a row a case, resumes behind the last whole row, and its parts are the whole.
#[test]
fn a_sweep_goes_on_where_it_was_interrupted_and_its_parts_are_the_whole() {
    let stage = Stage::new();
    let file = stage.file("short.yaml", stage::scenario(20.0, ""));
    let sweep = |folder: &str, more: &[&str]| {
        let varied = ["--vary", "depth_controller.depth.p=0.8,1.2", "--seeds", "3"];
        let arguments = [&["sweep", &file], &varied[..], &["--out", folder], more].concat();
        stage.run(&arguments).success()
    };
    let read = |name: &str| std::fs::read_to_string(stage.path(name)).unwrap();
    sweep("whole", &[]);
    let whole = read("whole/cases.csv");
    assert_eq!(whole.lines().count(), 1 + 6, "{whole}");

    // As kill -9 leaves it: the third row is cut.
    let cut: usize = whole.split_inclusive('\n').take(3).map(str::len).sum();
    std::fs::write(stage.path("whole/cases.csv"), &whole[..cut + 9]).unwrap();
    sweep("whole", &["--jobs", "1"]);
    assert_eq!(read("whole/cases.csv"), whole);

    for part in ["1/2", "2/2"] {
        sweep("parts", &["--shard", part]);
    }
    let rows = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    let mut parts = rows(&read("parts/cases-1-of-2.csv"));
    parts.extend(rows(&read("parts/cases-2-of-2.csv")));
    parts.sort_by_key(|row| row.split(',').next().unwrap().parse::<usize>().unwrap());
    assert_eq!(parts, rows(&whole));
}

/// Whoever has no thread left (`ulimit -u`): commands work without, or end with a sentence, and nodes end with one.
#[test]
fn where_the_system_gives_no_thread_nothing_panics() {
    let stage = Stage::new();
    // Root has no such limit; another user needs a folder that it may write to.
    let everybody = std::os::unix::fs::PermissionsExt::from_mode(0o777);
    std::fs::set_permissions(stage.path(""), everybody).unwrap();
    let place = "prlimit --nproc=1 setpriv --reuid=64321 --regid=64321 --clear-groups";
    let words = if rustix::process::geteuid().is_root() {
        6
    } else {
        2
    };
    let place: Vec<String> = place.split(' ').take(words).map(str::to_owned).collect();
    let works = [
        "sim dive --out dive.csv",
        "params",
        "tf brunner",
        "sysid topics dive.csv",
        "sweep dive --vary plant_sim.speed=1ft/s,2ft/s --out sweep",
    ];
    let refused = [
        "sim dive --out dive.mcap",
        "dive",
        "watch",
        "node plant_sim",
        "node recorder",
        "node sysid",
    ];
    for (code, commands) in [(0, &works[..]), (1, &refused)] {
        for command in commands {
            let arguments: Vec<&str> = command.split(' ').collect();
            let outcome = stage.start_at(&place, &arguments, &[]).finish();
            assert_eq!(outcome.status.code(), Some(code), "{command}: {outcome:#?}");
            let says = outcome.complaints();
            assert!(
                code == 0 || says.len() == 1 && says[0].contains("thread"),
                "{command}: {outcome:#?}"
            );
        }
    }
}

#[test]
fn a_slip_of_the_hand_is_answered_with_what_was_meant_and_what_is_taken() {
    let stage = Stage::new();
    let set = |change: &'static str| vec!["sim", "dive", "--set", change];
    for (code, arguments, says) in [
        (
            1,
            set("depth_controller.depth.P=1"),
            "did you mean 'depth.p'?",
        ),
        (
            1,
            set("plant_sim.speed=2furlongs"),
            "give a number in m/s, or a number with its unit: m/s, ft/s, kn, km/h",
        ),
        (
            1,
            set("depth_controller.depth_setpoint=-3"),
            "-3.0 refused: the value must lie in [0, 10000] m, positive down",
        ),
        (
            1,
            set("depth_controller.schedule.depths=[-1.0]"),
            "must lie in [0, 10000] m, positive down",
        ),
        (
            1,
            vec!["sim", "dives"],
            "a YAML file or one of bluerov2, dive, ",
        ),
        (2, vec!["sim", "dive", "--ot", "x"], "did you mean '--out'?"),
        (
            1,
            vec!["params", "depth_controler"],
            "did you mean 'depth_controller'?",
        ),
        (1, vec!["node", "plant_simm"], "did you mean 'plant_sim'?"),
        (1, vec!["tf", "brunnr"], "did you mean 'brunner'?"),
    ] {
        refused(&stage, code, &arguments, &[says]);
    }
    // Knots are a speed.
    let flown = [
        "sim",
        "dive",
        "--set",
        "plant_sim.speed=0.5kn",
        "--out",
        "knots.csv",
    ];
    stage.run(&flown).success();
}

#[test]
fn a_file_of_another_kind_is_refused_with_the_command_that_converts_it() {
    let stage = Stage::new();
    for (name, kind, command) in [
        ("log.mat", "a MATLAB file", "scipy.io.loadmat('"),
        ("log.XLSX", "a spreadsheet", "pandas.read_excel('"),
        ("log.parquet", "a Parquet file", "pandas.read_parquet('"),
        ("log.h5", "an HDF5 file", "h5py.File('"),
        ("log.npz", "an archive of numpy", "numpy.load('"),
        ("log.pkl", "a pickle of Python", "pandas.read_pickle('"),
        ("log.bag", "a bag of ROS 1", "rosbags-convert --src "),
    ] {
        let file = stage.file(name, "something");
        let says = [kind, "convert it: `", command, file.as_str()];
        refused(&stage, 1, &["sysid", "topics", &file], &says);
    }
}

#[test]
fn an_argument_that_is_not_utf_8_is_a_word_and_an_exit_status() {
    use std::ffi::{OsStr, OsString};
    use std::os::unix::ffi::OsStrExt as _;

    let stage = Stage::new();
    let bad = OsStr::from_bytes(b"caf\xe9");
    let run = |arguments: &[&OsStr]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_planesman"));
        command.current_dir(stage.path(".")).args(arguments);
        command.output().unwrap()
    };
    let [sim, dive, out, node, plant] =
        ["sim", "dive", "--out", "node", "plant_sim"].map(OsStr::new);
    let assignment: OsString = [OsStr::new("frame_prefix:="), bad].into_iter().collect();
    let [ros, p] = ["--ros-args", "-p"].map(OsStr::new);
    for (code, arguments) in [
        (2, vec![bad]),
        (2, vec![dive, bad]),
        (2, vec![sim, bad]),
        (1, vec![node, plant, ros, p, &assignment]),
    ] {
        let outcome = run(&arguments);
        let said = String::from_utf8(outcome.stderr).unwrap();
        assert_eq!(outcome.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(
            said.contains("UTF-8") && !said.contains("panicked"),
            "{said}"
        );
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    // What is only a path may be called anything.
    let file: OsString = [bad, OsStr::new(".csv")].into_iter().collect();
    let outcome = run(&[sim, dive, out, &file]);
    assert!(outcome.status.success(), "{outcome:?}");
    assert!(std::path::Path::new(&stage.path(".")).join(&file).is_file());
}
