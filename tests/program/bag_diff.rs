//! `planesman bag diff`: what was changed in a bag is found, and nothing else.

use std::fs;
use std::path::Path;

use planesman_bag::{BagReader, BagWriter, Compression, Order, WriterOptions};
use planesman_msgs::cdr;
use planesman_msgs::planesman_msgs::msg::PlaneCommand;

use crate::bags::{FLOAT, IMU, Maker, float, imu};
use crate::stage::{Outcome, Stage, scenario};

/// The command's exit status and output.
fn diff(stage: &Stage, arguments: &[&str]) -> Outcome {
    stage.run(&[&["bag", "diff"], arguments].concat())
}

fn is_equal(stage: &Stage, arguments: &[&str]) {
    let outcome = diff(stage, arguments);
    assert_eq!(outcome.status.code(), Some(0), "{outcome:#?}");
    assert!(outcome.stdout.starts_with("equal: "), "{outcome:#?}");
}

/// The recordings differ; the text of all lines as one, and all of `says` in it.
fn differs(stage: &Stage, arguments: &[&str], says: &[&str]) {
    let outcome = diff(stage, arguments);
    assert_eq!(outcome.status.code(), Some(4), "{outcome:#?}");
    let text = outcome.stdout.split_whitespace().collect::<Vec<_>>();
    let text = text.join(" ");
    for part in says {
        assert!(text.contains(part), "no '{part}' in: {text}");
    }
}

/// A dive of five seconds in one process, with another gain if one is given.
fn fly(stage: &Stage, out: &str, gain: &str) {
    let parameters = format!("  depth_controller: {{depth.p: {gain}, depth_setpoint: 0.5}}\n");
    let file = stage.file(&format!("{out}.yaml"), scenario(5.0, &parameters));
    stage.run(&["sim", &file, "--out", out]).success();
}

/// The bag again in `to`, its plane command of number `changed` with the last bit of the angle changed. Returns both angles.
fn rewritten(from: &str, to: &str, changed: Option<usize>, options: WriterOptions) -> [f64; 2] {
    let bag = BagReader::open(Path::new(from)).unwrap();
    let mut writer = match to.ends_with(".mcap") {
        true => BagWriter::create_file(Path::new(to), options).unwrap(),
        false => BagWriter::create(Path::new(to), options).unwrap(),
    };
    let (mut commands, mut angles) = (0, [0.0; 2]);
    for message in bag.messages(Order::File) {
        let mut message = message.unwrap();
        if message.topic.name == "/auv/plane_command" {
            if Some(commands) == changed {
                let mut command: PlaneCommand = cdr::from_bytes(&message.payload).unwrap();
                let other = f64::from_bits(command.dive_planes.to_bits() ^ 1);
                angles = [command.dive_planes, other];
                command.dive_planes = other;
                message.payload = cdr::to_bytes(&command);
            }
            commands += 1;
        }
        let id = writer.add_topic(&message.topic).unwrap();
        let (log_time, publish_time) = (message.log_time + 77, message.publish_time);
        writer
            .write_raw(id, &message.payload, log_time, publish_time)
            .unwrap();
    }
    writer.close().unwrap();
    angles
}

fn options(compression: Compression) -> WriterOptions {
    WriterOptions {
        compression,
        chunk_size: 10_000,
        flush_interval: None,
        ..WriterOptions::default()
    }
}

#[test]
fn the_last_bit_of_one_field_of_one_message_is_found_with_its_stamp_and_values() {
    let stage = Stage::new();
    let (a, b) = (stage.path("a.mcap"), stage.path("b.mcap"));
    fly(&stage, &a, "0.8");
    let [was, is] = rewritten(&a, &b, Some(41), options(Compression::None));
    let first = "first difference: /auv/plane_command field dive_planes at stamp 2.050000000 (message 42): ";
    let values = format!("{first}{was} in A, {is} in B");
    let before = "(1 ulp); the 41 messages before this one are equal";
    differs(
        &stage,
        &[&a, &b],
        &[&values, before, "/auv/plane_command 100 100 99 1 "],
    );
    differs(
        &stage,
        &[&b, &a],
        &[&format!("{first}{is} in A, {was} in B")],
    );
    is_equal(
        &stage,
        &[&a, &b, "--tolerance", "plane_command:dive_planes=1e-15"],
    );
    is_equal(&stage, &[&a, &b, "--ignore", "*command:dive_planes"]);
    is_equal(&stage, &[&a, &b, "--ignore", "/auv/plane_command"]);
    differs(
        &stage,
        &[
            &a,
            &b,
            "--tolerance",
            "plane_command:header=1",
            "--ignore",
            "state",
        ],
        &[&values],
    );

    let page = stage.path("page.html");
    differs(&stage, &[&a, &b, "--html", &page], &[&values]);
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("/auv/plane_command dive_planes: difference"));
}

#[test]
fn how_a_bag_is_stored_is_no_difference_and_what_was_cut_off_is_missing() {
    let stage = Stage::new();
    let path = |name: &str| stage.path(name);
    let a = path("a.mcap");
    fly(&stage, &a, "0.8");
    for (name, compression) in [
        ("plain.mcap", Compression::None),
        ("packed.mcap", Compression::Zstd),
    ] {
        rewritten(&a, &path(name), None, options(compression));
        is_equal(&stage, &[&a, &path(name)]);
    }
    let split = WriterOptions {
        max_file_size: Some(40_000),
        ..options(Compression::None)
    };
    rewritten(&a, &path("split"), None, split);
    assert!(
        BagReader::open(Path::new(&path("split")))
            .unwrap()
            .files()
            .count()
            > 3
    );
    is_equal(&stage, &[&path("split"), &a]);

    let bytes = fs::read(path("plain.mcap")).unwrap();
    fs::write(path("cut.mcap"), &bytes[..bytes.len() / 2]).unwrap();
    differs(
        &stage,
        &[&a, &path("cut.mcap")],
        &["only A has it", "B: incomplete: "],
    );
    differs(
        &stage,
        &[&path("cut.mcap"), &a],
        &["only B has it", "A: incomplete: "],
    );
}

#[test]
fn a_table_of_a_flight_is_compared_with_its_bag_and_another_gain_shows() {
    let stage = Stage::new();
    let path = |name: &str| stage.path(name);
    for (stem, gain) in [("a", "0.8"), ("b", "0.8000000000001")] {
        fly(&stage, &path(&format!("{stem}.csv")), gain);
        fly(&stage, &path(&format!("{stem}.mcap")), gain);
    }
    is_equal(&stage, &[&path("a.csv"), &path("a.mcap")]);
    is_equal(&stage, &[&path("b.mcap"), &path("b.csv")]);
    let says = ["first difference: plane_command [rad] at stamp 0.000000000 (value 1): "];
    differs(&stage, &[&path("a.csv"), &path("b.mcap")], &says);
    differs(&stage, &[&path("a.csv"), &path("b.csv")], &says);
    differs(
        &stage,
        &[&path("a.mcap"), &path("b.mcap")],
        &["/auv/plane_command field dive_planes"],
    );
    let outcome = diff(
        &stage,
        &[
            &path("a.csv"),
            &path("b.csv"),
            "--format",
            "json",
            "--tolerance",
            "*=1e-9",
        ],
    );
    assert_eq!(outcome.status.code(), Some(0), "{outcome:#?}");
    let table: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(table[0]["equal"], 100);
}

/// Times in ns, ten milliseconds apart.
const STEP: i64 = 10_000_000;

/// A bag of messages with stamps, given by their numbers and values, and of others without.
fn stamped(path: &str, messages: &[(i64, f64)], others: &[f64]) {
    let mut bag = Maker::new(Path::new(path));
    let (with, without) = (bag.topic("/imu", IMU), bag.topic("/u", FLOAT));
    for (number, (k, value)) in messages.iter().enumerate() {
        bag.write(with, &imu(1 + k * STEP, *value), number as i64);
    }
    for (number, value) in others.iter().enumerate() {
        bag.write(without, &float(*value), number as i64);
    }
    bag.close();
}

#[test]
fn messages_are_paired_by_their_stamps_and_bits_are_compared() {
    let stage = Stage::new();
    let path = |name: &str| stage.path(name);
    let all: Vec<(i64, f64)> = (0..10).map(|k| (k, k as f64)).collect();
    let others = [1.0, f64::NAN, 0.0];
    let (a, b) = (path("a.mcap"), path("b.mcap"));
    stamped(&a, &all, &others);
    let against = |messages: &[(i64, f64)], others: &[f64], says: &[&str]| {
        stamped(&b, messages, others);
        match says[0].starts_with("equal") {
            true => {
                let outcome = diff(&stage, &[&a, &b]);
                assert_eq!(outcome.status.code(), Some(0), "{outcome:#?}");
                says.iter()
                    .for_each(|it| assert!(outcome.stdout.contains(it), "{outcome:#?}"));
            }
            false => differs(&stage, &[&a, &b], says),
        }
        fs::remove_file(&b).unwrap();
    };
    against(&all, &others, &["equal: 13 messages on 2 topics"]);
    // One is missing: the others are equal.
    let missing: Vec<_> = all.iter().copied().filter(|it| it.0 != 4).collect();
    against(
        &missing,
        &others,
        &[
            "/imu at stamp 0.040000001 (message 5): only A has it",
            "/imu 10 9 9 1",
        ],
    );
    // One more, between others.
    let more: Vec<_> = [&all[..3], &[(2, 7.0)], &all[3..]].concat();
    against(
        &more,
        &others,
        &[
            "/imu at stamp 0.020000001",
            "only B has it",
            "/imu 10 11 10 1",
        ],
    );
    // The same again, as after a tick that was sent twice.
    let twice: Vec<_> = [&all[..5], &all[3..]].concat();
    against(
        &twice,
        &others,
        &["equal: ", "2 messages occur twice in a recording"],
    );
    // Two publishers of a topic, one received late.
    let late: Vec<_> = [&all[..4], &all[5..8], &all[4..5], &all[8..]].concat();
    against(
        &late,
        &others,
        &["equal: 13 messages", "1 messages have a different order"],
    );
    // A clock that starts again.
    let again: Vec<_> = all.iter().map(|it| (it.0 + 500, it.1)).collect();
    let twice: Vec<_> = [&again[..], &all[..]].concat();
    stamped(&path("restarted.mcap"), &twice, &others);
    let short: Vec<_> = [&again[..6], &all[..]].concat();
    stamped(&path("short.mcap"), &short, &others);
    differs(
        &stage,
        &[&path("restarted.mcap"), &path("short.mcap")],
        &["/imu 20 16 16 4"],
    );
    // Bits: a NaN is itself, -0.0 is not 0.0.
    against(
        &all,
        &[1.0, f64::NAN, -0.0],
        &["/u field data, message 3: 0.0 in A, -0.0 in B", "(1 ulp)"],
    );
    against(&all, &[1.0, 2.0, 0.0], &["nan in A, 2.0 in B"]);
    // By their numbers a missing one shifts all that follow.
    stamped(&b, &missing, &others);
    differs(
        &stage,
        &[&a, &b, "--by-index", "--ignore", "imu:header"],
        &["/imu 10 9 4 5 1"],
    );
}

#[test]
fn topics_of_wall_time_are_counted_and_names_that_are_none_are_refused() {
    let stage = Stage::new();
    let path = |name: &str| stage.path(name);
    for (name, value) in [("a.mcap", 1.0), ("b.mcap", 2.0)] {
        let mut bag = Maker::new(Path::new(&path(name)));
        let [log, u] = ["/rosout", "/u"].map(|it| bag.topic(it, FLOAT));
        bag.write(log, &float(value), 0);
        bag.write(u, &float(0.0), 0);
        bag.close();
    }
    let (a, b) = (path("a.mcap"), path("b.mcap"));
    is_equal(&stage, &[&a, &b]);
    differs(&stage, &[&a, &b, "--all"], &["/rosout field data"]);
    for (arguments, code, reason) in [
        (
            &["--ignore", "w"][..],
            1,
            "neither recording has such a topic",
        ),
        (&["--ignore", "u:dta"], 1, "no such field"),
        (&["--tolerance", "u:data"], 2, "TOPIC:FIELD=VALUE"),
        (&["--ignore", "u"], 1, "nothing to compare"),
    ] {
        let outcome = diff(&stage, &[&[&*a, &*b], arguments].concat());
        assert_eq!(outcome.status.code(), Some(code), "{outcome:#?}");
        assert!(outcome.stderr.contains(reason), "{outcome:#?}");
    }
    let outcome = diff(&stage, &[&a, "no/such"]);
    assert_eq!(outcome.status.code(), Some(1), "{outcome:#?}");
}
