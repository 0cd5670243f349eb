//! Logs of vehicles: ArduPilot's DataFlash, telemetry of MAVLink, MOOS, PX4's behind damage; and what is known and not read.

use std::fmt::Write as _;
use std::fs;

use planesman_testing::near;
use planesman_testing::telemetry::Version;
use planesman_testing::{dataflash, telemetry, ulog};

use crate::answer::{fit, planesman};
use crate::plant::{SAMPLES, STEP, log};

/// Input and output.
fn response() -> Vec<(f64, f64)> {
    let (u, y) = log(21, SAMPLES);
    u.into_iter().zip(y).collect()
}

/// Bytes with some in the middle set to zero.
fn damaged(mut bytes: Vec<u8>) -> Vec<u8> {
    let middle = bytes.len() / 2;
    bytes[middle..middle + 400].fill(0);
    bytes
}

#[test]
fn a_dataflash_log_is_read_by_its_own_formats() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = dataflash::log(&response());
    fs::write(folder.path().join("flight.bin"), &bytes).unwrap();
    let run = |arguments: &[&str]| fit(folder.path(), arguments);
    run(&["flight.bin", "-i", "RATE:RDes", "-o", "RATE:R"]).is_the_plant(SAMPLES as u64);
    // The I of a controller is its integral, that of a gyro its number.
    run(&["flight.bin", "-i", "PIDR:Tar", "-o", "RATE:R"]).is_the_plant(SAMPLES as u64);
    // The letter c is hundredths; the second gyro is another signal.
    let first = run(&["flight.bin", "-i", "RATE:RDes", "-o", "IMU[0]:GyrX"]);
    near(first.number("model/steady_state_gain/0"), 0.75 * 57.3, 0.3);
    let second = run(&["flight.bin", "-i", "RATE:RDes", "-o", "IMU[1]:GyrX"]);
    near(
        second.number("model/steady_state_gain/0"),
        -0.75 * 57.3,
        0.3,
    );
    run(&["flight.bin", "-i", "RATE:RDes", "-o", "IMU:GyrX"])
        .refused(&["several", "IMU[0], IMU[1]"]);
    run(&["flight.bin", "-i", "RATE:RDes", "-o", "RATE:P"]).refused(&["no field 'P'", "RDes, R"]);
    run(&["flight.bin", "-i", "RATE:RDes", "-o", "ATT:Roll"]).refused(&["no such topic", "RATE"]);
    let topics = planesman(folder.path(), &["sysid", "topics", "flight.bin"]);
    for words in ["RATE  DataFlash  2000 at 20.000 Hz", "IMU[1]", "GyrX"] {
        assert!(topics.text.contains(words), "{words}: {}", topics.text);
    }
    // 400 bytes of 132 000: some 7 of 2000 samples.
    fs::write(folder.path().join("damaged.bin"), damaged(bytes.clone())).unwrap();
    let answer = run(&["damaged.bin", "-i", "RATE:RDes", "-o", "RATE:R"]);
    answer
        .says("the log is damaged at these places")
        .says("verdict: good");
    near(answer.number("record/samples"), 1991.0, 6.0);
    near(answer.number("model/steady_state_gain/0"), 0.75, 0.005);
    fs::write(folder.path().join("cut.bin"), &bytes[..bytes.len() / 2 + 7]).unwrap();
    run(&["cut.bin", "-i", "RATE:RDes", "-o", "RATE:R"])
        .says("verdict: good")
        .says("or cut off");
    fs::write(folder.path().join("image.bin"), [7; 5000]).unwrap();
    run(&["image.bin", "-i", "RATE:RDes", "-o", "RATE:R"])
        .refused(&["not a DataFlash log of ArduPilot"]);
}

#[test]
fn telemetry_of_mavlink_is_read_in_both_versions() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| fit(folder.path(), arguments);
    for (name, version) in [("one.tlog", Version::One), ("two.tlog", Version::Two)] {
        fs::write(
            folder.path().join(name),
            telemetry::log(&response(), version, 1),
        )
        .unwrap();
        let answer = run(&[
            name,
            "-i",
            "SERVO_OUTPUT_RAW:servo3_raw",
            "-o",
            "ATTITUDE:rollspeed",
        ]);
        answer
            .says("verdict: good")
            .says("60000")
            .says("mavlogdump.py");
        assert_eq!(answer.number("record/samples"), SAMPLES as f64);
        near(answer.number("model/steady_state_gain/0"), 0.0075, 5e-5);
        near(answer.number("model/continuous_poles/0/re"), -0.6, 0.01);
    }
    // Named values are signals of their own.
    let named = [
        "-i",
        "NAMED_VALUE_FLOAT[pitch]:value",
        "-o",
        "NAMED_VALUE_FLOAT[roll]:value",
    ];
    run(&[&["two.tlog"][..], &named].concat()).is_the_plant(SAMPLES as u64);
    // Two vehicles send the same messages.
    fs::write(
        folder.path().join("fleet.tlog"),
        telemetry::log(&response(), Version::Two, 2),
    )
    .unwrap();
    let input = ["fleet.tlog", "-i", "SERVO_OUTPUT_RAW[1.1]:servo3_raw", "-o"];
    run(&[&input[..], &["ATTITUDE:rollspeed"]].concat())
        .refused(&["several", "ATTITUDE[1.1], ATTITUDE[2.1]"]);
    for (output, gain) in [
        ("ATTITUDE[1.1]:rollspeed", 0.0075),
        ("ATTITUDE[2.1]:rollspeed", -0.0075),
    ] {
        let answer = run(&[&input[..], &[output]].concat());
        near(answer.number("model/steady_state_gain/0"), gain, 5e-5);
    }
    let bytes = damaged(telemetry::log(&response(), Version::Two, 1));
    fs::write(folder.path().join("damaged.tlog"), bytes).unwrap();
    let answer = run(&[
        "damaged.tlog",
        "-i",
        "SERVO_OUTPUT_RAW:servo3_raw",
        "-o",
        "ATTITUDE:rollspeed",
    ]);
    answer
        .says("the log is damaged at these places")
        .says("verdict: good");
    near(answer.number("record/samples"), 1997.0, 3.0);
    fs::write(folder.path().join("none.tlog"), [7; 5000]).unwrap();
    run(&["none.tlog", "-i", "A:x", "-o", "B:y"])
        .refused(&["no message", "5000 bytes belong to no frame"]);
}

#[test]
fn a_log_of_moos_has_variables_of_numbers_and_of_pairs() {
    let folder = tempfile::tempdir().unwrap();
    let mut text =
        "%% LOG FILE:       ./sim.alog\n%% LOGSTART           1700000000.0\n%%%%%%%%\n".to_owned();
    for (k, (u, y)) in response().into_iter().enumerate() {
        let t = k as f64 * STEP;
        writeln!(
            text,
            "{t:.3}           DESIRED_RUDDER       pHelmIvP      {u:.5}"
        )
        .unwrap();
        writeln!(text, "{t:.3}  IVPHELM_STATE pHelmIvP:1:{k} DRIVE").unwrap();
        writeln!(
            text,
            "{t:.3}           NODE_REPORT  pNodeReporter  NAME=alpha,X={u},YAW_RATE={y:.6},MODE=ON"
        )
        .unwrap();
        writeln!(
            text,
            "{t:.3}           NAV_YAW_RATE         uSimMarine    {y:.6}"
        )
        .unwrap();
    }
    fs::write(folder.path().join("run.alog"), text).unwrap();
    let run = |arguments: &[&str]| fit(folder.path(), arguments);
    let all = SAMPLES as u64;
    run(&["run.alog", "-i", "DESIRED_RUDDER", "-o", "NAV_YAW_RATE"]).is_the_plant(all);
    run(&[
        "run.alog",
        "-i",
        "DESIRED_RUDDER:value",
        "-o",
        "NODE_REPORT:YAW_RATE",
    ])
    .is_the_plant(all);
    run(&["run.alog", "-i", "DESIRED_RUDDER", "-o", "NAV_YAW"])
        .refused(&["no such topic", "did you mean 'NAV_YAW_RATE'"]);
    run(&[
        "run.alog",
        "-i",
        "DESIRED_RUDDER",
        "-o",
        "NAV_YAW_RATE",
        "--stamp",
        "log",
    ])
    .refused(&["its own stamps"]);
}

#[test]
fn a_px4_log_is_read_on_behind_damage() {
    let folder = tempfile::tempdir().unwrap();
    // The outputs of this log are 1 and y; the input is on the second element of its list.
    fs::write(folder.path().join("whole.ulg"), ulog::log(&response())).unwrap();
    fs::write(
        folder.path().join("damaged.ulg"),
        damaged(ulog::log(&response())),
    )
    .unwrap();
    let signals = ["-i", "command:control[1]", "-o", "rates:body.y"];
    fit(folder.path(), &[&["whole.ulg"][..], &signals].concat()).is_the_plant(SAMPLES as u64);
    let answer = fit(folder.path(), &[&["damaged.ulg"][..], &signals].concat());
    // Some 5 of 2000 samples, each of 73 bytes.
    answer.says("the log is damaged").says("verdict: good");
    near(answer.number("record/samples"), 1995.0, 4.0);
    near(answer.number("model/steady_state_gain/0"), 0.75, 0.005);
}

#[test]
fn what_is_known_and_not_read_is_refused_with_the_command_that_converts_it() {
    let folder = tempfile::tempdir().unwrap();
    for (name, words) in [
        ("dive.bag", "rosbags-convert --src dive.bag --dst dive"),
        (
            "dive.bag.active",
            "rosbag reindex dive.bag.active && mv dive.bag.active dive.bag && rosbags-convert --src dive.bag",
        ),
        ("dive.mat", "scipy.io"),
        ("dive.xlsx", "read_excel"),
        ("dive.parquet", "read_parquet"),
    ] {
        let bytes = if name.contains("bag") {
            "#ROSBAG V2.0\n"
        } else {
            "something"
        };
        fs::write(folder.path().join(name), bytes).unwrap();
        fit(folder.path(), &[name, "-i", "a:x", "-o", "b:y"]).refused(&[name, words]);
    }
}
