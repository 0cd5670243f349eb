//! What `planesman sysid topics` says of the time and the samples of tables and logs, and the command that it proposes.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::answer::{fit, planesman};
use crate::plant::{SAMPLES, STEP, log};

/// The survey of a file, and the words of the command that it proposes, behind `planesman sysid fit`.
fn survey(folder: &Path, arguments: &[&str]) -> (String, Vec<String>) {
    let answer = planesman(folder, &[&["sysid", "topics"], arguments].concat());
    assert_eq!(answer.status, Some(0), "{}", answer.text);
    let mut lines = answer.text.lines();
    let proposed = lines.find_map(|line| line.strip_prefix("try: planesman sysid fit "));
    let words = proposed.unwrap_or_default().split(' ').map(str::to_owned);
    let words = words.filter(|it| !it.is_empty()).collect();
    (answer.text, words)
}

#[test]
fn a_table_is_told_its_unit_clock_bursts_and_held_samples_and_the_command_fits() {
    type Row = fn(usize) -> (f64, usize, f64);
    // Of each row the time, the sample that it holds, and a heading.
    let cases: [(&str, Row, &[&str]); 7] = [
        (
            "timestamp",
            |k| (13_550_000.0 + 5e4 * k as f64, k, 0.0),
            &["at 20.000 Hz", "column 'timestamp', in us, by their steps"],
        ),
        (
            "time_us",
            |k| {
                (
                    ((1_u64 << 32) - 50_000_000 + 50_000 * k as u64) as f64 % 4_294_967_296.0,
                    k,
                    0.0,
                )
            },
            &[
                "at 20.000 Hz",
                "clock: the clock wraps at 4294.917 s (2^32 us)",
            ],
        ),
        (
            "t",
            |k| {
                (
                    1.7e9 + k as f64 * STEP - if k > 1000 { 3.7 } else { 0.0 },
                    k,
                    0.0,
                )
            },
            &["clock: the clock goes back from 1700000050.000 to 1700000046.350 s"],
        ),
        (
            "t",
            |k| ((k % 800) as f64 * STEP, k, 0.0),
            &["clock: the clock goes back from 39.950 to 0.000 s"],
        ),
        (
            "t",
            |k| {
                (
                    (k / 10 * 10 + 9) as f64 * STEP + 1e-4 * (k % 10) as f64,
                    k,
                    0.0,
                )
            },
            &[
                "at 20.000 Hz",
                "in bursts (90 %",
                "note: 10.0 samples come at once every 0.500 s",
            ],
        ),
        (
            "t",
            |k| ((k as f64 * STEP).floor(), k, 0.0),
            &[
                "at 20.000 Hz",
                "1900 duplicates",
                "note: 20.0 samples share a stamp every 1.000 s",
            ],
        ),
        (
            "t",
            |k| {
                (
                    k as f64 * STEP / 5.0,
                    k / 5,
                    (350.0 + 0.1 * k as f64) % 360.0,
                )
            },
            &[
                "at 100.000 Hz",
                "note: y: the value is new only every 5 rows",
                "note: hdg: wraps around 3 times, so it is unwrapped with the period 360",
            ],
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, row, words) in cases {
        let rows = if words[0] == "at 100.000 Hz" {
            5 * SAMPLES
        } else {
            SAMPLES
        };
        let (u, y) = log(31, SAMPLES);
        let mut text = format!("{name},u,y,hdg\n");
        for k in 0..rows {
            let (time, sample, heading) = row(k);
            writeln!(
                text,
                "{time:.4},{},{:.6},{heading:.1}",
                u[sample], y[sample]
            )
            .unwrap();
        }
        fs::write(folder.path().join("log.csv"), text).unwrap();
        let (told, command) = survey(folder.path(), &["log.csv"]);
        for words in words {
            assert!(told.contains(words), "'{words}' is not in: {told}");
        }
        assert_eq!(command, ["log.csv", "-i", "u", "-o", "y"]);
        let command: Vec<&str> = command.iter().map(String::as_str).collect();
        let answer = fit(folder.path(), &command);
        answer.is_the_plant(SAMPLES as u64);
        // One sentence for one finding.
        for told in told.lines().filter_map(|it| it.strip_prefix("  clock: ")) {
            answer.says(told);
        }
    }
}

#[test]
fn a_table_without_a_time_that_can_be_meant_is_told_so_with_the_option() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(31, SAMPLES);
    let write = |header: &str, time: &dyn Fn(usize) -> String| {
        let mut text = format!("{header}\n");
        for k in 0..SAMPLES {
            writeln!(text, "{}{},{:.6}", time(k), u[k], y[k]).unwrap();
        }
        fs::write(folder.path().join("log.csv"), text).unwrap();
    };
    type Case<'a> = (&'a str, &'a dyn Fn(usize) -> String, &'a str);
    let cases: [Case<'_>; 4] = [
        (
            "t,u,y",
            &|k| format!("{:.12},", k as f64 * STEP / 86_400.0),
            "(--time-unit sets the unit)",
        ),
        (
            "t,u,y",
            &|_| "1.70000e+09,".to_owned(),
            "(--sample-time SECONDS)",
        ),
        (
            "t,u,y",
            &|k| format!("{},", SAMPLES - k),
            "Sort the samples by time",
        ),
        ("u,y", &|_| String::new(), "-o y --sample-time SECONDS"),
    ];
    for (header, time, words) in cases {
        write(header, time);
        let (told, _) = survey(folder.path(), &["log.csv"]);
        assert!(told.contains(words), "'{words}' is not in: {told}");
    }
    // What was said of the time is in the command.
    write("t,u,y", &|k| format!("{:.12},", k as f64 * STEP / 86_400.0));
    let (told, command) = survey(folder.path(), &["log.csv", "--time-unit", "d"]);
    assert!(told.contains("at 20.000 Hz"), "{told}");
    let command: Vec<&str> = command.iter().map(String::as_str).collect();
    fit(folder.path(), &command).is_the_plant(SAMPLES as u64);
}

#[test]
fn a_log_is_told_per_message_what_its_clock_does() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(31, SAMPLES);
    let mut text = "%% LOGSTART           1700000000.0\n".to_owned();
    for k in 0..SAMPLES {
        // The community begins anew; a slow sensor is repeated.
        let t = k as f64 * STEP - if k >= 900 { 45.0 } else { 0.0 };
        writeln!(text, "{t:.3} DESIRED_RUDDER pHelm {}", u[k]).unwrap();
        writeln!(text, "{t:.3} NAV_YAW_RATE uSim {:.6}", y[k]).unwrap();
        writeln!(text, "{t:.3} NAV_DEPTH uSim {:.6}", y[k / 4 * 4]).unwrap();
    }
    fs::write(folder.path().join("run.alog"), text).unwrap();
    let (told, command) = survey(folder.path(), &["run.alog"]);
    for words in [
        "NAV_DEPTH  MOOS  2000 at 20.000 Hz",
        "  clock: the clock goes back from 44.950 to 0.000 s",
        "  note: value: the value is new only every 4 rows",
    ] {
        assert!(told.contains(words), "'{words}' is not in: {told}");
    }
    let of = ["-i", "DESIRED_RUDDER:value"];
    assert!(command.windows(2).any(|it| it == of), "{command:?}");
}
