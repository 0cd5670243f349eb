//! `planesman sysid topics` and `planesman sysid fit` on good, mixed, broken and hostile data.

use crate::bags;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use bags::{FLOAT, IMU, Maker, float, imu};
use clap::Parser;
use planesman::sysid::fit::FitArgs;
use planesman_bag::BagReader;
use planesman_fit::{DataOptions, FitResult, Survey};
use planesman_testing::hostile::mutated;
use planesman_testing::ulog;
use planesman_text::in_one_line;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

fn try_fit(data: &Path, more: &str) -> Result<FitResult, String> {
    crate::by_command_line();
    let data = data.to_str().unwrap();
    let args = ["fit", data].into_iter().chain(more.split_whitespace());
    let args = FitArgs::try_parse_from(args).map_err(|error| error.to_string())?;
    planesman_fit::fit(
        &(&args).try_into().map_err(|error| in_one_line(&error))?,
        &(),
    )
    .map_err(|error| in_one_line(&error))
}

fn fit(data: &Path, more: &str) -> FitResult {
    try_fit(data, more).unwrap()
}

fn survey(data: &Path) -> Result<Survey, String> {
    crate::by_command_line();
    planesman_fit::survey(&DataOptions::files([data]), None, &())
        .map_err(|error| in_one_line(&error))
}

/// The first-order response y_k = 0.9 y_(k-1) + 0.2 u_(k-1) to a square wave, at 20 Hz.
fn response(count: usize) -> Vec<(f64, f64)> {
    let mut y = 0.0;
    (0..count)
        .map(|k| {
            let u = f64::from(u8::from((k / 15) % 2 == 0)) + 0.1 * libm::sin(k as f64);
            let pair = (u, y);
            y = 0.9 * y + 0.2 * u;
            pair
        })
        .collect()
}

const STEP: i64 = 50_000_000;
const SIGNALS: &str =
    "-i cmd:data -o imu:angular_velocity.y --method least_squares --order 1 --no-offset";

/// Of two topics with an Imu each, which signal is whose.
const IMUS: &str = "-i a:angular_velocity.y -o b:angular_velocity.y --order 1";

/// The response as Imu on /a and /b; `stamps` gives header and log time of both for a sample and its time.
fn two_imus(path: &Path, stamps: impl Fn(i64, i64) -> [(i64, i64); 2]) {
    let mut maker = Maker::new(path);
    let topics = [maker.topic("/a", IMU), maker.topic("/b", IMU)];
    for (k, (u, y)) in (0..).zip(response(200)) {
        for ((topic, value), (header, log)) in
            topics.into_iter().zip([u, y]).zip(stamps(k, k * STEP))
        {
            maker.write(topic, &imu(header, value), log);
        }
    }
    maker.close();
}

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

fn is_the_response(found: &FitResult) {
    let model = found.analysis.model();
    assert!((model.a[0] + 0.9).abs() < 1e-12, "{model:?}");
    assert!((model.b[0] - 0.2).abs() < 1e-12, "{model:?}");
    assert!((model.steady_state_gain().unwrap() - 2.0).abs() < 1e-9);
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
        let found = planesman_fit::fit(
            &(&FitArgs::try_parse_from(args).unwrap())
                .try_into()
                .unwrap(),
            &(),
        )
        .unwrap();
        is_the_response(&found);
        assert_eq!(
            found.prepared.resampled.record.segments,
            from_bag.prepared.resampled.record.segments
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
        ("", "-i u -o y", "does not have two columns"),
        ("t,u\n", "-i u -o y", "no column 'y'; there are t, u"),
        ("t,u,y\n", "-i u -o y", "the signal has no sample"),
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
fn a_table_is_read_however_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("a.csv");
    let rows = |line: &dyn Fn(usize, f64, f64) -> String| -> String {
        let all = response(200).into_iter().enumerate();
        all.map(|(k, (u, y))| line(k, u, y) + "\n").collect()
    };
    let comma = |value: f64| value.to_string().replace('.', ",");
    let plain = |k: usize, u: f64, y: f64| format!("{},{u},{y}", k as f64 * 0.05);
    let milliseconds = |k: usize, u: f64, y: f64| format!("{},{u},{y}", 50 * k);
    let date = |k: usize, u: f64, y: f64| {
        let (minutes, seconds) = (50 * k / 60_000, (50 * k % 60_000) as f64 * 1e-3);
        format!("2024-02-29T23:{:02}:{seconds:06.3}Z,{u},{y}", 58 + minutes)
    };
    for (text, signals, stamps) in [
        (
            rows(&plain),
            "-i c2 -o c3",
            "of the column 'c1', the first column, which increases",
        ),
        (
            "t;u;y\n".to_owned() + &rows(&|k, u, y| [k as f64 * 0.05, u, y].map(comma).join(";")),
            "-i u -o y",
            "of the column 't'",
        ),
        (
            "# a rig\ntime,speed_kn,rate (deg/s)\n".to_owned() + &rows(&date),
            "-i speed -o rate",
            "of the column 'time'",
        ),
        (
            "t_ms,u,y\n".to_owned() + &rows(&milliseconds),
            "-i u -o y",
            "of the column 't_ms', in ms",
        ),
        (
            "u\ttime (ms)\ty\n".to_owned() + &rows(&|k, u, y| format!("{u}\t{}\t{y}", 50 * k)),
            "-i u -o y",
            "of the column 'time (ms)', in ms",
        ),
        (
            "t,u,y\n".to_owned()
                + &rows(&|k, u, y| {
                    format!("{},{u},{y}", 1_700_000_000_000_000_000 + 50_000_000 * k)
                }),
            "-i u -o y",
            "of the column 't', in ns, by their size",
        ),
        (
            "% t u y\n".to_owned()
                + &rows(&|k, u, y| format!(" {:e}   {u:e}  {y:e}", k as f64 * 0.05)),
            "-i u -o y",
            "of the column 't'",
        ),
        (
            "u,y\n".to_owned() + &rows(&|_, u, y| format!("{u},{y}")),
            "-i u -o y --sample-time 50ms",
            "of the rows, which are 0.05 s apart",
        ),
    ] {
        fs::write(&table, text).unwrap();
        let found = fit(
            &table,
            &format!("{signals} --method least_squares --order 1 --no-offset"),
        );
        is_the_response(&found);
        let told = &found.prepared.reading.stamps;
        assert!(told.starts_with(stamps), "{told}");
    }
}

#[test]
fn a_table_without_a_time_is_refused_with_the_option_that_gives_it() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("a.csv");
    let rows: String = response(200)
        .iter()
        .map(|(u, y)| format!("{u},{y}\n"))
        .collect();
    fs::write(&table, "u,y\n".to_owned() + &rows).unwrap();
    let refusal = try_fit(&table, "-i u -o y").unwrap_err();
    assert!(refusal.contains("--sample-time 0.1s"), "{refusal}");
    // Its columns are listed all the same.
    assert_eq!(survey(&table).unwrap().topics[0].fields.len(), 2);
    let refusal = try_fit(&table, "-i u -o y --sample-time 0.05 --time u").unwrap_err();
    assert!(refusal.contains("--sample-time"), "{refusal}");
    // A ramp in front is the time, unless it is asked for as a signal.
    let rows: String = response(200)
        .iter()
        .enumerate()
        .map(|(k, (u, y))| format!("{},{u},{y}\n", 2 * k))
        .collect();
    fs::write(&table, "ramp,u,y\n".to_owned() + &rows).unwrap();
    let refusal = try_fit(&table, "-i ramp -o y").unwrap_err();
    assert!(
        refusal.contains("'ramp' is assumed to be the time"),
        "{refusal}"
    );
}

#[test]
fn every_cell_that_is_no_number_is_counted_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("a.csv");
    let rows: String = response(200)
        .iter()
        .enumerate()
        .map(|(k, (u, y))| match k {
            20 => format!("{},,{y}\n", k as f64 * 0.05),
            30 | 40 => format!("{},{u},n/a\u{1b}[2J\n", k as f64 * 0.05),
            50 => format!("{},{u}\n", k as f64 * 0.05),
            _ => format!("{},{u},{y}\n", k as f64 * 0.05),
        })
        .collect();
    fs::write(&table, "t,u,y [rad]\n".to_owned() + &rows).unwrap();
    let prepared = fit(&table, "-i u -o y --order 1").prepared;
    let account = prepared.description();
    for note in [
        "'u': of 200 cells 1 are empty, the first in line 22",
        "'y [rad]': of 200 cells 1 are empty, the first in line 52, 2 contain no number, the first 'n/a\\u001b[2J' in line 32",
        "'y' is the column 'y [rad]'",
    ] {
        assert!(account.contains(note), "{account}");
    }
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
    two_imus(&path, |k, time| {
        // The recorder is late and irregular.
        let late = time + 3_000_000 + (k * 7_919_993) % 9_000_000;
        [(time, late), (time, late + 1)]
    });
    is_the_response(&fit(&path, IMUS));
    is_the_response(&fit(&path, &format!("{IMUS} --stamp header")));
    let by_log = fit(&path, &format!("{IMUS} --stamp log"));
    assert!((by_log.analysis.model().a[0] + 0.9).abs() > 1e-6);
    assert!(by_log.prepared.resampled.outputs[0].timing.jitter > 1e-3);

    bag(&folder.path().join("b.mcap"), 50);
    let refusal = try_fit(
        &folder.path().join("b.mcap"),
        &format!("{SIGNALS} --stamp header"),
    );
    let refusal = refusal.unwrap_err();
    assert!(
        refusal.contains("std_msgs/msg/Float64 have no stamp"),
        "{refusal}"
    );
}

#[test]
fn a_px4_log_is_read_by_its_topics_and_fields() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.ulg");
    let whole = ulog::log(&response(200));
    fs::write(&path, &whole).unwrap();
    let names: Vec<String> = survey(&path)
        .unwrap()
        .topics
        .iter()
        .flat_map(|topic| {
            topic
                .fields
                .iter()
                .map(|it| format!("{}:{}", topic.name, it.path))
        })
        .collect();
    assert_eq!(
        names,
        [
            "command:control[0]",
            "command:control[1]",
            "command_1:control[0]",
            "command_1:control[1]",
            "rates:body.x",
            "rates:body.y",
            "rates:ok"
        ]
    );
    let signals = "-i command:control[1] -o rates:body.y --method arx --order 1 --no-offset";
    let found = fit(&path, signals);
    let model = found.analysis.model();
    // The commands are floats.
    assert!(
        (model.a[0] + 0.9).abs() < 1e-6 && (model.b[0] - 0.2).abs() < 1e-6,
        "{model:?}"
    );
    let account = found.prepared.description();
    assert!(
        account.contains("dropped messages 1 times, for 1.500 s"),
        "{account}"
    );
    for (more, reason) in [
        (
            "-i comand:control[1] -o rates:body.y",
            "did you mean 'command'?",
        ),
        (
            "-i command:control[2] -o rates:body.y",
            "has no field 'control[2]'",
        ),
        (
            "-i rates:body.y -o rates:body.y",
            "is named both as input and as output",
        ),
        (
            "-i command:control[1] -o rates:body.y --stamp log",
            "do not apply to a log, because it contains its own stamps",
        ),
    ] {
        let refusal = try_fit(&path, more).unwrap_err();
        assert!(refusal.contains(reason), "{refusal}");
    }
    fs::write(&path, &whole[..whole.len() - 10]).unwrap();
    let found = fit(&path, signals);
    assert!(found.prepared.description().contains("the log is cut off"));
    // Whatever stands in it gives an answer or an error.
    let mut random = Pcg64Mcg::seed_from_u64(11);
    for _ in 0..60 {
        fs::write(&path, mutated(&whole, &mut random)).unwrap();
        let _ = (survey(&path), try_fit(&path, signals));
    }
    for bytes in [&b""[..], b"ULog", b"no log at all", &whole[..60]] {
        fs::write(&path, bytes).unwrap();
        assert!(survey(&path).unwrap_err().contains("flight.ulg"));
    }
}

#[test]
fn how_late_the_recorder_was_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    two_imus(&path, |_, time| {
        [(time, time + 2_000_000), (time, time + 45_000_000)]
    });
    for (stamp, says) in [
        (
            "header",
            "43.0 ms apart; with the header stamps, this difference does not count as a delay",
        ),
        ("log", "45.0 ms of this count as a delay of the system"),
    ] {
        let found = fit(&path, &format!("{IMUS} --stamp {stamp}"));
        let account = found.prepared.description();
        assert!(account.contains("/a 2.0 ms, /b 45.0 ms"), "{account}");
        assert!(account.contains(says), "{account}");
    }
}

#[test]
fn an_input_that_is_of_another_time_or_never_moves_is_refused_with_the_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    two_imus(&path, |_, time| {
        [(time, time), (time + 5_000_000_000_000, time)]
    });
    let refusal = try_fit(&path, &format!("{IMUS} --stamp header")).unwrap_err();
    assert!(refusal.contains("4990.050 s apart"), "{refusal}");
    assert!(refusal.contains("--stamp log"), "{refusal}");
    // By itself the recorder's time is taken.
    for stamp in ["", " --stamp log"] {
        is_the_response(&fit(&path, &format!("{IMUS}{stamp}")));
    }
    let constant = "-i a:angular_velocity.x -o b:angular_velocity.y --stamp log";
    let refusal = try_fit(&path, constant).unwrap_err();
    assert!(
        refusal.contains("is constant (0 in all 200 samples)"),
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
            "the signal has no sample",
        ),
        (
            &path,
            "-i cmd:data -o imu:angular_velocity.y --prefilter ..10",
            "edge 10 Hz is not below half the sampling rate, 10.000000 Hz",
        ),
        (
            &path,
            "-i cmd:data -o imu:orientation.x --window 90..20",
            "'90..20' is reversed; write 20..90",
        ),
        (
            &path,
            "-i cmd:data -o imu:angular_velocity.y --rate 1000",
            "--rate may be at most 20.000000",
        ),
        (
            &path,
            "-i cmd:data -o imu:orientation.x --rate 0",
            "between 1e-6 and 1e6",
        ),
        (
            &path,
            "-i cmd:data -o imu:angular_velocity.y --window 100..",
            "at no time",
        ),
        (
            &path,
            "-i cmd:data -o imu:angular_velocity.y --time t",
            "--time, like --time-unit and --sample-time, is for .csv",
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
    let note = &found.prepared.reading.notes[0];
    assert!(
        note.contains("/imu: 10 of 110 messages") && note.contains("XCDR2"),
        "{note}"
    );
    let refusal = try_fit(&path, "-i cmd:data -o wrong:angular_velocity.y").unwrap_err();
    assert!(refusal.contains("/wrong: 100 of 100 messages cannot be read as sensor_msgs/msg/Imu"));
    let refusal = try_fit(&path, "-i cmd:data -o other:x").unwrap_err();
    assert!(
        refusal.contains("'protobuf' is not supported; supported: ros2msg, ros2idl"),
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
    assert!(found.prepared.resampled.record.samples() < 3000);
    assert!(
        found.prepared.reading.notes[0].contains("incomplete"),
        "{:?}",
        found.prepared.reading.notes
    );
    assert!(survey(&path).unwrap().notes[0].contains("incomplete"));
    fs::write(&path, &bytes[..20]).unwrap();
    assert!(try_fit(&path, SIGNALS).unwrap_err().contains("cut off"));
    fs::write(&path, b"").unwrap();
    assert!(try_fit(&path, SIGNALS).unwrap_err().contains("is empty"));
}

#[test]
fn a_bag_with_more_topics_than_anybody_reads_is_listed_in_part() {
    let folder = tempfile::tempdir().unwrap();
    let file = |part: i64| {
        let path = folder.path().join(format!("many_{part}.mcap"));
        let mut maker = Maker::new(&path);
        let mut last = maker.topic("/t0", FLOAT);
        for number in 1..3000 {
            last = maker.topic(&format!("/t{number}"), FLOAT);
        }
        for k in 0..100 {
            maker.write(last, &float(k as f64), (100 * part + k) * STEP);
        }
        maker.close();
        path
    };
    let path = file(0);
    let listing = survey(&path).unwrap();
    assert_eq!(listing.topics.len(), 1000);
    assert!(
        listing.notes[0].starts_with("2000 more topics"),
        "{:?}",
        listing.notes
    );
    let refusal = try_fit(&path, "-i t2999:data -o nowhere:data").unwrap_err();
    assert!(
        refusal.len() < 1000 && refusal.contains("and 2980 more"),
        "{refusal}"
    );
    // Split in several files, they are one bag's topics all the same.
    let both = [path, file(1)];
    assert_eq!(
        BagReader::open_all(&both, Default::default())
            .unwrap()
            .topics()
            .len(),
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
    assert!(shown.contains("MiB, ") && shown.contains("/imu"), "{shown}");
    let quiet = on_a_terminal("--quiet");
    assert!(
        !quiet.contains("MiB, ") && quiet.contains("/imu"),
        "{quiet}"
    );
    let piped = Command::new(program)
        .args(["sysid", "topics", path])
        .output()
        .unwrap();
    assert!(piped.status.success() && piped.stderr.is_empty());
}

/// The command that `sysid topics` proposes, obeyed: its words, and the verdict that the fit prints; `None` where none is proposed.
fn obeyed(folder: &Path, file: &str) -> Option<(String, String)> {
    let run = |command: &str| {
        let words = format!("'{}' {command}", env!("CARGO_BIN_EXE_planesman"));
        let ran = Command::new("sh")
            .args(["-c", &words])
            .current_dir(folder)
            .output()
            .unwrap();
        assert!(ran.status.success(), "{command}: {ran:?}");
        String::from_utf8(ran.stdout).unwrap()
    };
    let topics = run(&format!("sysid topics {file} --quiet"));
    let proposed = topics
        .lines()
        .find_map(|line| line.strip_prefix("try: planesman "))?;
    let fitted = run(&format!("{proposed} --quiet"));
    Some((
        proposed.to_owned(),
        fitted.lines().next().unwrap().to_owned(),
    ))
}

#[test]
fn what_is_proposed_gives_a_model_that_is_usable() {
    let folder = tempfile::tempdir().unwrap();
    let scenarios = planesman_flight::scenario::builtin_names();
    let bags = scenarios.iter().map(|it| (*it, format!("{it}.mcap")));
    for (scenario, file) in bags.chain([("dive", "dive.csv".to_owned())]) {
        let file = file.as_str();
        let flown = Command::new(env!("CARGO_BIN_EXE_planesman"))
            .args(["sim", scenario, "--out", file])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(flown.status.success(), "{flown:?}");
        // Eight thrusters move it together, so that none of them moves it alone.
        if scenario == "bluerov2" {
            let bag = folder.path().join(file);
            let mut survey = survey(&bag).unwrap();
            survey.suggest(&DataOptions::files([bag])).unwrap();
            let told = |it: &String| it.starts_with("no command is proposed");
            assert!(survey.notes.iter().any(told), "{:?}", survey.notes);
            continue;
        }
        let (proposed, last) = obeyed(folder.path(), file).unwrap();
        assert!(!proposed.contains("position.x"), "a ramp: {proposed}");
        let usable = ["verdict: good", "verdict: usable"];
        assert!(
            usable.iter().any(|it| last.starts_with(it)),
            "{proposed}: {last}"
        );
    }
    // A ramp, a counter of messages and a stamp beside the output that answers.
    let rows = response(2000).into_iter().enumerate();
    let rows = rows.map(|(k, (u, y))| {
        format!(
            "{},{u},{},{},{},{y}\n",
            0.05 * k as f64,
            0.01 * k as f64,
            k,
            1.7e9 + 0.05 * k as f64
        )
    });
    let table = format!(
        "time,u,position,depth_count,rate_stamp,y\n{}",
        rows.collect::<String>()
    );
    fs::write(folder.path().join("ramps.csv"), table).unwrap();
    let (proposed, last) = obeyed(folder.path(), "ramps.csv").unwrap();
    assert!(proposed.contains("-i u -o y"), "{proposed}");
    assert!(last.starts_with("verdict: good"), "{last}");
}

/// Of a dive without a test signal a quick fit finds a usable model of some pairs where the fit that is proposed finds none.
#[test]
fn what_is_proposed_is_usable_by_the_command_s_own_fit() {
    let folder = tempfile::tempdir().unwrap();
    let kalman = "depth_controller.feedback.source=kalman";
    let dives = [
        ["depth_controller.depth_setpoint=0.6", kalman],
        [
            "depth_controller.depth_setpoint=0.3",
            "dha_actuator.model=ideal",
        ],
    ];
    for (file, changes) in ["a.mcap", "b.mcap"].into_iter().zip(dives) {
        let still = "depth_controller.identification.signal=none";
        let flown = Command::new(env!("CARGO_BIN_EXE_planesman"))
            .args(["sim", "dive", "--out", file, "--set", still])
            .args(changes.iter().flat_map(|it| ["--set", it]))
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(flown.status.success(), "{flown:?}");
        let Some((proposed, last)) = obeyed(folder.path(), file) else {
            continue;
        };
        let usable = ["verdict: good", "verdict: usable"];
        assert!(
            usable.iter().any(|it| last.starts_with(it)),
            "{proposed}: {last}"
        );
    }
}

/// The dive's place along its heading grows whatever the planes do: an unstable model of it, whose input accounts for nothing, was good.
#[test]
fn a_ramp_has_no_model_of_what_the_planes_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dive.csv");
    let program = env!("CARGO_BIN_EXE_planesman");
    let flown = Command::new(program)
        .args(["sim", "dive", "--out"])
        .arg(&path)
        .output()
        .unwrap();
    assert!(flown.status.success(), "{flown:?}");
    for more in ["", "--validation 60..90"] {
        let said = fit(&path, &format!("-i plane_command -o distance {more}"))
            .analysis
            .verdict_text();
        assert!(
            !said.contains("good") && !said.contains("verdict: usable"),
            "{said}"
        );
    }
}
