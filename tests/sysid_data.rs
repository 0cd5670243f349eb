//! `planesman sysid topics` and `planesman sysid fit` on good, mixed, broken and hostile data.
#![allow(clippy::unwrap_used)]

mod bags;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use bags::{FLOAT, IMU, Maker, float, imu};
use clap::Parser;
use planesman::sysid::fit::{self, FitArgs, Found};
use planesman::sysid::topics::{self, Survey, TopicsArgs};
use planesman_bag::BagReader;
use planesman_testing::hostile::mutated;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

fn try_fit(data: &Path, more: &str) -> Result<Found, String> {
    let data = data.to_str().unwrap();
    let args = ["fit", data].into_iter().chain(more.split_whitespace());
    let args = FitArgs::try_parse_from(args).map_err(|error| error.to_string())?;
    fit::fit(&args).map_err(|error| format!("{error:#}"))
}

fn fit(data: &Path, more: &str) -> Found {
    try_fit(data, more).unwrap()
}

fn survey(data: &Path) -> Result<Survey, String> {
    let args = ["topics", data.to_str().unwrap()];
    let args = TopicsArgs::try_parse_from(args).unwrap();
    topics::survey(&args).map_err(|error| format!("{error:#}"))
}

/// The first-order response y_k = 0.9 y_(k-1) + 0.2 u_(k-1) to a square wave, at 20 Hz.
fn response(count: usize) -> Vec<(f64, f64)> {
    let mut y = 0.0;
    (0..count)
        .map(|k| {
            let u = f64::from(u8::from((k / 15) % 2 == 0)) + 0.1 * (k as f64).sin();
            let pair = (u, y);
            y = 0.9 * y + 0.2 * u;
            pair
        })
        .collect()
}

const STEP: i64 = 50_000_000;
const SIGNALS: &str =
    "-i cmd:data -o imu:angular_velocity.y --method least_squares --order 1 --no-offset";

/// The response as floats on /cmd and Imu on /imu.
fn bag(path: &Path, count: usize) {
    let mut maker = Maker::new(path);
    let (cmd, imus) = (maker.topic("/cmd", FLOAT), maker.topic("/imu", IMU));
    for (k, (u, y)) in response(count).into_iter().enumerate() {
        let time = 7 + k as i64 * STEP;
        maker.write(cmd, &float(u), time);
        maker.write(imus, &imu(time, y), time);
    }
    maker.close();
}

fn is_the_response(found: &Found) {
    let model = found.analysis.model();
    assert!((model.a[0] + 0.9).abs() < 1e-12, "{model:?}");
    assert!((model.b[0] - 0.2).abs() < 1e-12, "{model:?}");
    assert!((model.dc_gain().unwrap() - 2.0).abs() < 1e-9);
    assert!(found.analysis.fit.unwrap() > 99.9999);
}

#[test]
fn a_table_and_a_bag_of_the_same_samples_give_the_same_record() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    bag(&path, 200);
    let from_bag = fit(&path, SIGNALS);
    is_the_response(&from_bag);
    for (name, delimiter) in [("a.csv", ","), ("b.csv", ";"), ("c.tsv", "\t")] {
        let mut text = format!("\u{feff}u{delimiter} time{delimiter}\"rate, y\"\n");
        for (k, (u, y)) in response(200).into_iter().enumerate() {
            text += &format!(
                "{u}{delimiter} {:.9}{delimiter}{y}\n",
                7e-9 + 0.05 * k as f64
            );
        }
        let table = folder.path().join(name);
        fs::write(&table, text).unwrap();
        let args = [
            "fit",
            table.to_str().unwrap(),
            "-i",
            "u",
            "-o",
            "rate, y",
            "--order=1",
            "--method=least_squares",
            "--no-offset",
        ];
        let found = fit::fit(&FitArgs::try_parse_from(args).unwrap()).unwrap();
        is_the_response(&found);
        assert_eq!(
            found.taken.resampled.record.stretches,
            from_bag.taken.resampled.record.stretches
        );
    }
}

#[test]
fn a_tables_blanks_are_absent_and_its_faults_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("a.csv");
    fs::write(
        &table,
        "t,u,y\n0,1,2\n0.1,,3\n0.2,x,4\nnoon,1,5\n0.3,nan,6\n0.4,2,7\n0.5\n",
    )
    .unwrap();
    let survey = survey(&table).unwrap();
    let counts: Vec<_> = survey.topics[0]
        .fields
        .iter()
        .map(|it| (it.path.as_str(), it.count, it.not_finite))
        .collect();
    assert_eq!(counts, [("u", 2, 1), ("y", 5, 0)]);
    assert!(
        survey.notes[0].contains("1 of 7 rows have no time in 't'"),
        "{:?}",
        survey.notes
    );
    for (text, more, reason) in [
        ("", "-i u -o y", "no two columns"),
        ("t,u\n", "-i u -o y", "no column 'y'; it has t, u"),
        ("t,u,y\n", "-i u -o y", "there is no sample"),
        ("t,u,y\n0,1,1\n", "-i u -o y --time s", "no column 's'"),
        ("t,u,y\nx,1,1\n", "-i u -o y", "1 of 1 rows have no time"),
        (
            "t,u,y\n0,1,1\n",
            "-i u -o y --stamp log",
            "--stamp is for bags",
        ),
        ("t,u,y\n0,1,1\n1,1,1\n2,1,1\n", "-i u -o y", "determine"),
    ] {
        fs::write(&table, text).unwrap();
        let refusal = try_fit(&table, more).unwrap_err();
        assert!(refusal.contains(reason), "{refusal}");
    }
    fs::write(&table, "x,y\n".to_owned() + &"9".repeat(3 << 20)).unwrap();
    let refusal = try_fit(&table, "-i x -o y").unwrap_err();
    assert!(refusal.contains("not a CSV file"), "{refusal}");
}

#[test]
fn a_table_is_read_from_behind_its_byte_order_mark_and_utf_16_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("a.csv");
    fs::write(&table, "\u{feff}\"time\",u,y\n0,1,2\n0.1,2,3\n").unwrap();
    let survey_of = survey(&table).unwrap();
    assert_eq!(survey_of.topics[0].stamps, "of the column 'time'");
    assert_eq!(survey_of.topics[0].timing.samples, 2);
    for bytes in [&b"\xff\xfet\0,\0"[..], b"\xfe\xff\0t\0,"] {
        fs::write(&table, bytes).unwrap();
        let refusal = survey(&table).unwrap_err();
        assert!(refusal.contains("UTF-16"), "{refusal}");
    }
}

#[test]
fn the_stamps_are_the_messages_own_where_all_have_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut maker = Maker::new(&path);
    let (first, second) = (maker.topic("/a", IMU), maker.topic("/b", IMU));
    for (k, (u, y)) in response(200).into_iter().enumerate() {
        let time = k as i64 * STEP;
        // The recorder is late and irregular.
        let late = time + 3_000_000 + (k as i64 * 7_919_993) % 9_000_000;
        maker.write(first, &imu(time, u), late);
        maker.write(second, &imu(time, y), late + 1);
    }
    maker.close();
    let signals = "-i a:angular_velocity.y -o b:angular_velocity.y --order 1";
    is_the_response(&fit(&path, signals));
    is_the_response(&fit(&path, &format!("{signals} --stamp header")));
    let by_log = fit(&path, &format!("{signals} --stamp log"));
    assert!((by_log.analysis.model().a[0] + 0.9).abs() > 1e-6);
    assert!(by_log.taken.resampled.outputs[0].timing.jitter > 1e-3);

    bag(&folder.path().join("b.mcap"), 50);
    let refusal = try_fit(
        &folder.path().join("b.mcap"),
        &format!("{SIGNALS} --stamp header"),
    );
    let refusal = refusal.unwrap_err();
    assert!(
        refusal.contains("std_msgs/msg/Float64 carry no stamp"),
        "{refusal}"
    );
}

#[test]
fn what_is_not_there_is_refused_with_what_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    bag(&path, 50);
    let mut maker = Maker::new(&folder.path().join("two.mcap"));
    for name in ["/x/imu", "/y/imu"] {
        maker.topic(name, IMU);
    }
    maker.close();
    let two = folder.path().join("two.mcap");
    for (path, more, reason) in [
        (&path, "-i cmd -o imu:angular_velocity.y", "TOPIC:FIELD"),
        (
            &path,
            "-i cmd:data -o gyro:x",
            "no such topic; it has /cmd, /imu",
        ),
        (
            &path,
            "-i cmd:data -o imu:angular_velocity",
            "it has x, y, z",
        ),
        (
            &path,
            "-i cmd:data -o imu:header.frame_id",
            "a string, not a number",
        ),
        (
            &path,
            "-i cmd:datum -o imu:orientation.x",
            "no field 'datum'; it has data",
        ),
        (
            &two,
            "-i x/imu:orientation.x -o imu:orientation.x",
            "/x/imu, /y/imu",
        ),
        (
            &two,
            "-i x/imu:orientation.x -o y/imu:orientation.x",
            "there is no sample",
        ),
        (
            &path,
            "-i cmd:data -o imu:orientation.x --window 5..1",
            "FROM..TO",
        ),
        (
            &path,
            "-i cmd:data -o imu:orientation.x --rate 0",
            "between 1e-6 and 1e6",
        ),
        (
            &path,
            "-i cmd:data -o imu:angular_velocity.y --window 100..",
            "no instant",
        ),
        (
            &path,
            "-i cmd:data -o imu:angular_velocity.y --time t",
            "--time is for .csv",
        ),
        (
            &path,
            "-i cmd:data -o imu:linear_acceleration.z",
            "determine",
        ),
    ] {
        let refusal = try_fit(path, more).unwrap_err();
        assert!(refusal.contains(reason), "{refusal}");
    }
}

#[test]
fn messages_that_are_not_of_their_type_are_reported_and_the_rest_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut maker = Maker::new(&path);
    let (cmd, imus) = (maker.topic("/cmd", FLOAT), maker.topic("/imu", IMU));
    let wrong = maker.topic("/wrong", IMU);
    let other = maker.topic("/other", ("a/msg/A", "protobuf", "message A {}"));
    for (k, (u, y)) in response(100).into_iter().enumerate() {
        let time = k as i64 * STEP;
        maker.write(cmd, &float(u), time);
        maker.write(imus, &imu(time, y), time);
        maker.write(wrong, &float(u), time);
        maker.write(other, &float(u), time);
        if k % 10 == 0 {
            maker.write(imus, &[0, 7, 0, 0, 1, 2, 3], time + 1);
        }
    }
    maker.close();
    let found = fit(&path, SIGNALS);
    is_the_response(&found);
    let note = &found.taken.reading.notes[0];
    assert!(
        note.contains("/imu: 10 of 110 messages") && note.contains("XCDR2"),
        "{note}"
    );
    let refusal = try_fit(&path, "-i cmd:data -o wrong:angular_velocity.y").unwrap_err();
    assert!(refusal.contains("/wrong: 100 of 100 messages cannot be read as sensor_msgs/msg/Imu"));
    let refusal = try_fit(&path, "-i cmd:data -o other:x").unwrap_err();
    assert!(
        refusal.contains("'protobuf'; ros2msg and ros2idl are read"),
        "{refusal}"
    );

    let survey = survey(&path).unwrap();
    let note = |name: &str| {
        let topic = survey.topics.iter().find(|it| it.name == name).unwrap();
        topic.note.clone().unwrap_or_default()
    };
    assert!(note("/wrong").contains("100 of 100 messages cannot be read"));
    assert!(note("/other").contains("protobuf"));
    assert_eq!(note("/cmd"), "");
}

#[test]
fn a_cut_bag_gives_what_is_before_the_cut_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    bag(&path, 3000);
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let found = fit(&path, SIGNALS);
    is_the_response(&found);
    assert!(found.taken.resampled.record.samples() < 3000);
    assert!(
        found.taken.reading.notes[0].contains("not whole"),
        "{:?}",
        found.taken.reading.notes
    );
    assert!(survey(&path).unwrap().notes[0].contains("not whole"));
    fs::write(&path, &bytes[..20]).unwrap();
    assert!(try_fit(&path, SIGNALS).unwrap_err().contains("cut off"));
    fs::write(&path, b"").unwrap();
    assert!(try_fit(&path, SIGNALS).unwrap_err().contains("is empty"));
}

#[test]
fn a_bag_with_more_topics_than_anybody_reads_is_listed_in_part() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.mcap");
    let mut maker = Maker::new(&path);
    let mut last = maker.topic("/t0", FLOAT);
    for number in 1..3000 {
        last = maker.topic(&format!("/t{number}"), FLOAT);
    }
    for k in 0..100 {
        maker.write(last, &float(k as f64), k * STEP);
    }
    maker.close();
    let listing = survey(&path).unwrap();
    assert_eq!(listing.topics.len(), 1000);
    assert!(
        listing.notes[0].starts_with("2000 further topics"),
        "{:?}",
        listing.notes
    );
    let refusal = try_fit(&path, "-i t2999:data -o nowhere:data").unwrap_err();
    assert!(
        refusal.len() < 1000 && refusal.contains("and 2980 more"),
        "{refusal}"
    );
    // Split in several files, they are one bag's topics all the same.
    let copy = folder.path().join("again.mcap");
    fs::copy(&path, &copy).unwrap();
    assert_eq!(
        BagReader::open_all(&[path, copy]).unwrap().topics().len(),
        3000
    );
}

/// Both commands on whatever `path` holds; a panic fails the test.
fn looks_through(path: &Path) {
    let _ = survey(path);
    for more in [
        "-i cmd:data -o imu:angular_velocity.y",
        "-i cmd:data -o imu:orientation.pitch --rate 7 --stamp header",
        "-i imu:orientation_covariance -o imu:angular_velocity.y --max-gap 1000 --input-method hold",
        "-i cmd:data -o imu:angular_velocity.y --output-method centred --window 1..3",
    ] {
        let _ = try_fit(path, &format!("{more} --order 2 --method least_squares"));
    }
}

#[test]
fn a_file_with_changed_bytes_gives_an_answer_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    bag(&path, 60);
    let bytes = fs::read(&path).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(6);
    for _ in 0..1500 {
        fs::write(&path, mutated(&bytes, &mut random)).unwrap();
        looks_through(&path);
    }
}

#[test]
fn changed_messages_stamps_and_schemas_give_an_answer_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for number in 0..400 {
        let path = folder.path().join(format!("{number}.mcap"));
        let mut maker = Maker::new(&path);
        let schema = mutated(IMU.2.as_bytes(), &mut random);
        let schema = String::from_utf8_lossy(&schema).into_owned();
        let definition = if number % 2 == 0 { IMU.2 } else { &schema };
        let cmd = maker.topic("/cmd", FLOAT);
        let imus = maker.topic("/imu", (IMU.0, IMU.1, definition));
        for (k, (u, y)) in response(60).into_iter().enumerate() {
            let time = k as i64 * STEP;
            let stamp = match random.random_range(0..20) {
                0 => random.random_range(i64::MIN..=i64::MAX),
                1 => time - 5 * STEP,
                _ => time,
            };
            let payload = match random.random_range(0..3) {
                0 => mutated(&imu(stamp, y), &mut random),
                _ => imu(stamp, y),
            };
            maker.write(imus, &payload, stamp.max(0));
            maker.write(cmd, &float(u), time);
        }
        maker.close();
        looks_through(&path);
    }
}

#[test]
fn progress_is_shown_on_a_terminal_and_not_in_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    bag(&path, 10_000);
    let program = env!("CARGO_BIN_EXE_planesman");
    let path = path.to_str().unwrap();
    let on_a_terminal = |more: &str| {
        let command = format!("'{program}' sysid topics '{path}' {more}");
        let output = Command::new("script")
            .args(["-qec", &command, "/dev/null"])
            .stdin(Stdio::null())
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let shown = on_a_terminal("");
    assert!(shown.contains("B/s") && shown.contains("/imu"), "{shown}");
    let quiet = on_a_terminal("--quiet");
    assert!(!quiet.contains("B/s") && quiet.contains("/imu"), "{quiet}");
    let piped = Command::new(program)
        .args(["sysid", "topics", path])
        .output()
        .unwrap();
    assert!(piped.status.success() && piped.stderr.is_empty());
}
