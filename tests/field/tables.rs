//! Tables as loggers, spreadsheets and scripts write them: what parts their cells, where they begin, how their time is written.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use planesman_testing::near;

use crate::answer::{Answer, fit, planesman};
use crate::plant::{SAMPLES, STEP, log};

/// Lines of a table of so many samples, each made of the row's number, time, input and output.
fn rows(line: impl Fn(usize, f64, f64, f64) -> String) -> String {
    let (u, y) = log(11, SAMPLES);
    let mut text = String::new();
    for k in 0..SAMPLES {
        writeln!(text, "{}", line(k, k as f64 * STEP, u[k], y[k])).unwrap();
    }
    text
}

fn plain() -> String {
    rows(|_, t, u, y| format!("{t:.3},{u},{y:.6}"))
}

/// A number with a decimal comma.
fn comma(number: f64) -> String {
    format!("{number:.6}").replace('.', ",")
}

/// Fits `u` and `y` of that text in a file of that name.
fn of(folder: &Path, name: &str, text: impl AsRef<[u8]>, more: &[&str]) -> Answer {
    fs::write(folder.join(name), text).unwrap();
    let signals: &[&str] = if more.contains(&"-i") {
        &[]
    } else {
        &["-i", "u", "-o", "y"]
    };
    fit(folder, &[&[name], signals, more].concat())
}

/// The time of day of a sample that was taken `t` seconds after 10:21:37.123.
fn clock(t: f64, sign: char) -> String {
    let all = (t * 1000.0).round() as u64 + 123;
    let (seconds, milli) = (all / 1000 + 37, all % 1000);
    format!(
        "10:{:02}:{:02}{sign}{milli:03}",
        21 + seconds / 60,
        seconds % 60
    )
}

#[test]
fn a_table_begins_where_its_rows_do_and_the_lines_before_it_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let all = SAMPLES as u64;
    let german = rows(|_, t, u, y| format!("{};{};{}", comma(t), comma(u), comma(y)));
    let by_tabs = rows(|_, t, u, y| format!("{t:.3}\t{u:.2E}\t{y:.5E}"));
    let by_blanks = rows(|_, t, u, y| format!("  {t:.3}   {u:.2}  {y:.6}"));
    for (name, text, line) in [
        ("sep.csv", format!("sep=;\nt;u;y\n{german}"), None),
        (
            "quoted_sep.csv",
            format!(
                "\u{feff}\"sep=;\"\r\nt;u;y\r\n{}",
                german.replace('\n', "\r\n")
            ),
            None,
        ),
        (
            "titles.csv",
            format!(
                "Logger:,XYZ-100\nSerial:,12345\nStart:,2026-05-01 10:00:00\n\nt,u,y\n{}",
                plain()
            ),
            Some(5),
        ),
        (
            "padded.csv",
            format!("Logger,,\nSerial,12345,\n,,\nt,u,y\n{}", plain()),
            Some(4),
        ),
        ("units.csv", format!("t,u,y\ns,V,rad/s\n{}", plain()), None),
        (
            "bracketed.csv",
            format!("t,u,y\n[s],[deg],[m/s^2]\n{}", plain()),
            None,
        ),
        (
            "titled.dat",
            format!(
                "TANK (Some Institute, Town)\nZig-zag of a model : 10 / -10\n\nt\tu\ty\n{by_tabs}"
            ),
            Some(4),
        ),
        (
            "blanks.txt",
            format!("a run in the tank\n\n t  u   y\n{by_blanks}"),
            Some(3),
        ),
        (
            "two_words.txt",
            format!("Time (s)    u    y\n{by_blanks}"),
            None,
        ),
        (
            "units_of_words.txt",
            format!("t [s]   u [V]   y [rad]\n{by_blanks}"),
            None,
        ),
        (
            "bars.csv",
            format!("t|u|y\n{}", plain().replace(',', "|")),
            None,
        ),
        (
            "arduino.csv",
            format!(
                "t, u, y\n{}",
                rows(|_, t, u, y| format!("{t:.3}, {u}, {y:.6}, "))
            ),
            None,
        ),
        (
            "trailing.csv",
            format!("t,u,y,\n{}", plain().replace('\n', ",\n")),
            None,
        ),
        (
            "quoted.csv",
            format!(
                "\"t\",\"u\",\"y\"\n{}",
                rows(|_, t, u, y| format!("\"{t:.2}\",\"{u}\",\"{y:.5}\""))
            ),
            None,
        ),
        (
            "r.txt",
            format!(
                "\"t\" \"u\" \"y\"\n{}",
                rows(|k, t, u, y| format!("\"{}\" {t:.2} {u} {y:.5}", k + 1))
            ),
            None,
        ),
        (
            "totals.csv",
            format!("t,u,y\n{}mean,,0.03\n", plain()),
            None,
        ),
        (
            "pandas.csv",
            format!(
                ",t,u,y\n{}",
                rows(|k, t, u, y| format!("{k},{t:.2},{u},{y:.5}"))
            ),
            None,
        ),
        (
            "fortran.dat",
            format!(
                "t u y\n{}",
                rows(|_, t, u, y| format!("{t:.2} {u} {y:.5E}").replace('E', "D"))
            ),
            None,
        ),
        (
            "labview.lvm",
            format!(
                "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n***End_of_Header***\t\n\nChannels\t2\t\t\n\
                 Samples\t1\t1\t\nX_Value\tu\ty\tComment\n{by_tabs}"
            ),
            Some(9),
        ),
        (
            "campbell.dat",
            format!(
                "\"TOA5\",\"rig\",\"CR1000\"\n\"t\",\"u\",\"y\"\n\"TS\",\"Volts\",\"deg/s\"\n\"\",\"Smp\",\"Smp\"\n{}",
                plain()
            ),
            Some(2),
        ),
    ] {
        let answer = of(folder.path(), name, text, &[]);
        answer.is_the_plant(all);
        if let Some(line) = line {
            answer.says(&format!("{name}: the table begins in line {line}"));
        }
    }
    let text = format!("TANK (Some Institute, Town)\nZig-zag of a model : 10 / -10\n\n{by_tabs}");
    let answer = of(
        folder.path(),
        "nameless.dat",
        &text,
        &["-i", "c2", "-o", "c3"],
    );
    answer
        .is_the_plant(all)
        .says("the table begins in line 4, without names");
    // No word of a title becomes a column.
    let refusal = of(
        folder.path(),
        "nameless.dat",
        &text,
        &["-i", "of", "-o", "model"],
    );
    refusal.refused(&["no column 'of'", "c1, c2, c3", "line 4"]);
}

#[test]
fn names_that_do_not_go_with_the_rows_are_refused_or_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let decimal_commas = rows(|_, t, u, y| format!("{},{},{}", comma(t), comma(u), comma(y)));
    of(
        folder.path(),
        "commas.csv",
        format!("t,u,y\n{decimal_commas}"),
        &[],
    )
    .refused(&["line 1 has 3 names", "6 cells", "decimal comma"]);
    let twice = format!(
        "t,u,y,u\n{}",
        rows(|_, t, u, y| format!("{t:.2},0.1,{y:.5},{u}"))
    );
    of(folder.path(), "twice.csv", &twice, &[]).refused(&["'u' may mean 'u [c2]' or 'u [c4]'"]);
    of(
        folder.path(),
        "twice.csv",
        &twice,
        &["-i", "u [c4]", "-o", "y"],
    )
    .is_the_plant(SAMPLES as u64);
    let units = format!(
        "t,u,y [deg],y [rad]\n{}",
        rows(|_, t, u, y| format!("{t:.2},{u},{:.5},{y:.5}", 57.3 * y))
    );
    of(folder.path(), "units.csv", &units, &[]).refused(&["'y' may mean 'y [deg]' or 'y [rad]'"]);
    of(
        folder.path(),
        "units.csv",
        &units,
        &["-i", "u", "-o", "y [rad]"],
    )
    .is_the_plant(SAMPLES as u64);
    let wide: Vec<u8> = format!("t,u,y\n{}", plain())
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    of(
        folder.path(),
        "wide.csv",
        [vec![0xff, 0xfe], wide].concat(),
        &[],
    )
    .refused(&["UTF-16", "iconv"]);
}

#[test]
fn what_may_be_read_in_two_ways_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    // Thousands that are grouped, and no fraction that tells it.
    let grouped = |number: f64, sign: char| {
        let number = (5000.0 * number).round() as i64;
        let (minus, size) = (if number < 0 { "-" } else { "" }, number.abs());
        match size {
            0..1000 => format!("{minus}{size}"),
            _ => format!("{minus}{}{sign}{:03}", size / 1000, size % 1000),
        }
    };
    let german = rows(|_, t, u, y| format!("{t:.2};{u};{}", grouped(y, '.')));
    of(folder.path(), "german.csv", format!("t;u;y\n{german}"), &[])
        .refused(&["group thousands", "of 'y'"]);
    let english = rows(|_, t, u, y| format!("{t:.2},{u},\"{}\"", grouped(y, ',')));
    of(
        folder.path(),
        "english.csv",
        format!("t,u,y\n{english}"),
        &[],
    )
    .refused(&["group thousands", "of 'y'"]);
    // A second table in the file, with the columns in another order.
    let text = rows(|k, t, u, y| match k {
        1000 => "t,y,u".to_owned(),
        0..1000 => format!("{t:.2},{u},{y:.5}"),
        _ => format!("{t:.2},{y:.5},{u}"),
    });
    of(folder.path(), "two.csv", format!("t,u,y\n{text}"), &[])
        .refused(&["line 1002", "another order"]);
    // The same names again are no matter.
    let text = rows(|k, t, u, y| match k {
        1000 => "t,u,y".to_owned(),
        _ => format!("{t:.2},{u},{y:.5}"),
    });
    let answer = of(folder.path(), "again.csv", format!("t,u,y\n{text}"), &[]);
    answer
        .says("verdict: good")
        .says("the first 't' in line 1002");
    let old = format!("t,u,y\n{}", plain()).replace('\n', "\r");
    of(folder.path(), "old.csv", old, &[]).refused(&["CR only", "tr"]);
    // A column whose name is the time's and that is empty is none.
    let text = rows(|k, _, u, y| {
        let all = k as u64 * 50_000_000;
        format!(
            "{k},,{},{},{u},{y:.5}",
            1_600_000_000 + all / 1_000_000_000,
            all % 1_000_000_000
        )
    });
    of(
        folder.path(),
        "empty.csv",
        format!("seq,stamp,secs,nsecs,u,y\n{text}"),
        &[],
    )
    .is_the_plant(SAMPLES as u64);
}

#[test]
fn a_column_that_counts_the_rows_is_no_time() {
    let folder = tempfile::tempdir().unwrap();
    for (name, header) in [
        ("pandas.csv", ",u,y"),
        ("index.csv", "index,u,y"),
        ("sample.csv", "Sample,u,y"),
    ] {
        let text = format!("{header}\n{}", rows(|k, _, u, y| format!("{k},{u},{y:.5}")));
        of(folder.path(), name, &text, &[]).refused(&["counts the rows", "--sample-time"]);
        of(folder.path(), name, &text, &["--sample-time", "0.05s"]).is_the_plant(SAMPLES as u64);
    }
}

#[test]
fn rows_with_texts_in_them_are_no_header() {
    let folder = tempfile::tempdir().unwrap();
    let all = SAMPLES as u64;
    // Of a JointState, of a Wrench, of one whose clock is a simulator's.
    for (name, begin, text) in [
        ("joint.csv", 1_700_000_000_u64, ",shaft"),
        ("wrench.csv", 1_700_000_000, "base_link,\"a, b\""),
        ("simulated.csv", 12, ",shaft"),
    ] {
        let text = rows(|k, _, u, y| {
            let nanoseconds = k as u64 * 50_000_000;
            let (seconds, part) = (
                begin + nanoseconds / 1_000_000_000,
                nanoseconds % 1_000_000_000,
            );
            format!("{seconds},{part},{text},{y:.6},0.0,{u}")
        });
        let signals = ["-i", "c7", "-o", "c5"];
        if begin > 12 {
            of(folder.path(), name, &text, &signals).is_the_plant(all);
        }
        let named = [&signals[..], &["--time", "c1+c2"]].concat();
        of(folder.path(), name, &text, &named).is_the_plant(all);
    }
    let text = rows(|k, _, u, y| {
        let stamp = 1_600_000_000_000_000_000 + k as u64 * 50_000_000;
        format!("{stamp},{k},{stamp},,fin,{y:.6},{u}")
    });
    let header = "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.name0,field.position0,field.effort0";
    let signals = ["-i", "field.effort0", "-o", "field.position0"];
    of(
        folder.path(),
        "echo.csv",
        format!("{header}\n{text}"),
        &signals,
    )
    .is_the_plant(all);
    // The first rows have no value yet.
    let text = rows(|k, t, u, y| match k {
        0 | 1 => format!("{t:.2},{u},nan,init"),
        2 => format!("{t:.2},,-,init"),
        _ => format!("{t:.2},{u},{y:.5},run"),
    });
    of(
        folder.path(),
        "state.csv",
        format!("t,u,y,state\n{text}"),
        &[],
    )
    .is_the_plant(all - 3);
}

#[test]
fn a_time_in_two_columns_is_joined() {
    let folder = tempfile::tempdir().unwrap();
    let all = SAMPLES as u64;
    let parts = |unit: u64| {
        move |k: usize, _: f64, u: f64, y: f64| {
            let all = k as u64 * 50_000_000;
            format!(
                "{},{},{u},{y:.5}",
                1_700_000_000 + all / 1_000_000_000,
                all % 1_000_000_000 / unit
            )
        }
    };
    for (name, header, unit) in [
        ("sec.csv", "header.stamp.sec,header.stamp.nanosec,u,y", 1),
        ("secs.csv", "stamp_secs,stamp_nsecs,u,y", 1),
        ("seconds.csv", "seconds,nanoseconds,u,y", 1),
        ("usec.csv", "tv_sec,tv_usec,u,y", 1000),
        ("none.csv", "when,behind,u,y", 1),
    ] {
        of(
            folder.path(),
            name,
            format!("{header}\n{}", rows(parts(unit))),
            &[],
        )
        .is_the_plant(all);
    }
    for (name, header) in [
        ("ms.csv", "when,ms,u,y"),
        ("msec.csv", "gps.s,gps.msec,u,y"),
    ] {
        let joined = header.split(',').take(2).collect::<Vec<_>>().join("+");
        let text = format!("{header}\n{}", rows(parts(1_000_000)));
        of(folder.path(), name, text, &["--time", &joined]).is_the_plant(all);
    }
    for (name, header, date) in [
        ("dated.csv", "Date,Time,u,y", "2026-05-01"),
        ("us.csv", "date,time,u,y", "5/1/2026"),
        ("german.csv", "Date,Time,u,y", "01.05.2026"),
    ] {
        let text = rows(|_, t, u, y| format!("{date},{},{u},{y:.5}", clock(t, '.')));
        of(folder.path(), name, format!("{header}\n{text}"), &[])
            .is_the_plant(all)
            .says_stamps("and");
    }
    let text = rows(|_, t, u, y| format!("01.05.2026,{},{u},{y:.5}", clock(t, '.')));
    of(
        folder.path(),
        "named.csv",
        format!("Tag,Uhr,u,y\n{text}"),
        &["--time", "Tag+Uhr"],
    )
    .is_the_plant(all);
}

#[test]
fn dates_are_read_as_spreadsheets_and_tools_write_them() {
    let folder = tempfile::tempdir().unwrap();
    let all = SAMPLES as u64;
    type Written = fn(f64) -> String;
    let forms: [(&str, Written); 19] = [
        ("plotjuggler", |t| {
            format!("\" 05/01/2026 {}\"", clock(t, '.'))
        }),
        ("plotjuggler_new", |t| {
            format!("2026/05/01 {}", clock(t, '.'))
        }),
        ("german", |t| format!("01.05.2026 {}", clock(t, '.'))),
        ("us", |t| format!("5/1/2026 {} AM", clock(t, '.'))),
        ("british", |t| format!("31/05/2026 {}", clock(t, '.'))),
        ("matlab", |t| format!("01-May-2026 {}", clock(t, '.'))),
        ("matlab_german", |t| {
            format!("01-Mai-2026 {}", clock(t, '.'))
        }),
        ("iso", |t| format!("2026-05-01T{}Z", clock(t, '.'))),
        ("offset", |t| format!("2026-05-01T{}+02:00", clock(t, '.'))),
        ("postgres", |t| format!("2026-05-01 {}+00", clock(t, '.'))),
        ("labview", |t| format!("\"5/1/2026, {}\"", clock(t, '.'))),
        ("colons", |t| format!("2026-05-01 {}", clock(t, ':'))),
        ("ctime", |t| format!("Fri May  1 {} 2026", clock(t, '.'))),
        ("compact", |t| {
            format!("20260501T{}", clock(t, '.').replace(':', ""))
        }),
        ("timetable", |t| format!("{t:.2} sec")),
        ("duration", |t| {
            format!("00:0{}:{:05.2}", (t / 60.0) as u32, t % 60.0)
        }),
        ("timedelta", |t| {
            format!("0 days 00:0{}:{:09.6}", (t / 60.0) as u32, t % 60.0)
        }),
        ("excel", |t| format!("{:.11}", 46143.432 + t / 86400.0)),
        ("datenum", |t| format!("{:.10}", 740_103.432 + t / 86400.0)),
    ];
    for (name, written) in forms {
        let text = rows(|_, t, u, y| format!("{},{u},{y:.5}", written(t)));
        let name = format!("{name}.csv");
        of(folder.path(), &name, format!("timestamp,u,y\n{text}"), &[]).is_the_plant(all);
    }
    let text = rows(|_, t, u, y| format!("01.05.2026 {};{};{}", clock(t, ','), comma(u), comma(y)));
    of(
        folder.path(),
        "datum.csv",
        format!("Datum;u;y\n{text}"),
        &[],
    )
    .is_the_plant(all);
}

#[test]
fn the_order_of_day_and_month_is_judged_over_all_rows_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    // Across a midnight that either order may have: only one has no gap.
    let midnight = |t: f64, before: &str, after: &str| {
        let seconds = 86_340.0 + t;
        let (date, of_day) = if seconds < 86_400.0 {
            (before, seconds)
        } else {
            (after, seconds - 86_400.0)
        };
        let (hours, minutes) = ((of_day / 3600.0) as u32, (of_day / 60.0) as u32 % 60);
        format!("{date} {hours:02}:{minutes:02}:{:05.2}", of_day % 60.0)
    };
    let text = |before: &str, after: &str| {
        format!(
            "timestamp,u,y\n{}",
            rows(|_, t, u, y| format!("{},{u},{y:.5}", midnight(t, before, after)))
        )
    };
    let all = SAMPLES as u64;
    let british = of(
        folder.path(),
        "british.csv",
        text("01/02/2026", "02/02/2026"),
        &[],
    );
    british.is_the_plant(all).says_stamps("day/month/year");
    let us = of(
        folder.path(),
        "us.csv",
        text("02/01/2026", "02/02/2026"),
        &[],
    );
    us.is_the_plant(all).says_stamps("month/day/year");
    let clear = of(
        folder.path(),
        "clear.csv",
        text("02/12/2026", "02/13/2026"),
        &[],
    );
    clear.is_the_plant(all).says_stamps("month/day/year");
    let doubtful = of(
        folder.path(),
        "doubtful.csv",
        text("02/03/2026", "07/08/2026"),
        &[],
    );
    doubtful.refused(&[
        "'02/03/2026 23:59:00.00' in 'timestamp'",
        "day/month",
        "2026-11-24 12:00:00",
    ]);
}

#[test]
fn a_time_that_is_not_read_is_shown_with_the_forms_that_are() {
    let folder = tempfile::tempdir().unwrap();
    let text = rows(|k, _, u, y| format!("tick{k},{u},{y:.5}"));
    let answer = of(
        folder.path(),
        "ticks.csv",
        format!("timestamp,u,y\n{text}"),
        &[],
    );
    answer.refused(&[
        "'tick0' in line 2",
        "24.11.2026 12:00:00,050",
        "--time-unit",
    ]);
}

#[test]
fn truth_values_and_words_for_nothing_are_cells() {
    let folder = tempfile::tempdir().unwrap();
    for (name, on, off) in [
        ("lower", "true", "false"),
        ("excel", "TRUE", "FALSE"),
        ("python", "True", "False"),
        ("switch", "on", "off"),
    ] {
        let text = rows(|_, t, u, y| format!("{t:.2},{},{y:.5}", if u > 0.0 { on } else { off }));
        let answer = of(
            folder.path(),
            &format!("{name}.csv"),
            format!("t,u,y\n{text}"),
            &[],
        );
        assert_eq!(answer.status, Some(0), "{}", answer.text);
        // From off to on is 1 in place of the 2 from -1 to 1.
        near(answer.number("model/steady_state_gain/0"), 1.5, 0.01);
        answer.says("verdict: good");
    }
    let text = rows(|k, t, u, y| match k % 500 {
        7 => format!("{t:.2},{u},NULL"),
        8 => format!("{t:.2},{u},-"),
        9 => format!("{t:.2},{u},#N/A"),
        _ => format!("{t:.2},{u},{y:.5}"),
    });
    let answer = of(folder.path(), "null.csv", format!("t,u,y\n{text}"), &[]);
    answer
        .says("12 contain no number, the first 'NULL' in line 9")
        .says("verdict: good");
    let text = rows(|_, t, u, y| format!("{t:.2},{u},\"{}\"", grouped(5000.0 * y)));
    let answer = of(
        folder.path(),
        "thousands.csv",
        format!("t,u,y\n{text}"),
        &[],
    );
    near(answer.number("model/steady_state_gain/0"), 3750.0, 20.0);
}

/// A number with its thousands grouped: `-1,234.50`.
fn grouped(number: f64) -> String {
    let text = format!("{:.2}", number.abs());
    let sign = if number < 0.0 { "-" } else { "" };
    match text.len() {
        7 => format!("{sign}{},{}", &text[..1], &text[1..]),
        _ => format!("{sign}{text}"),
    }
}

#[test]
fn tables_of_one_topic_each_are_joined_by_time() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    let stamp = |k: usize| 1_669_909_208_879_527_696 + k as u64 * 50_000_000;
    write(
        "u.csv",
        format!(
            "%time,field.u\n{}",
            rows(|k, _, u, _| format!("{},{u}", stamp(k)))
        ),
    );
    write(
        "y.csv",
        format!(
            "%time,field.y\n{}",
            rows(|k, _, _, y| format!("{},{y:.6}", stamp(k)))
        ),
    );
    let all = SAMPLES as u64;
    let run = |arguments: &[&str]| fit(folder.path(), arguments);
    run(&["u.csv", "y.csv", "-i", "field.u", "-o", "field.y"]).is_the_plant(all);
    // Each in its own unit and form, a third one beside them.
    write(
        "u_ms.csv",
        format!(
            "t_ms;u\n{}",
            rows(|k, _, u, _| format!("{};{u}", 1_700_000_000_000 + 50 * k as u64))
        ),
    );
    write(
        "y_s.csv",
        format!(
            "stamp,y\n{}",
            rows(|_, t, _, y| format!("{:.2},{y:.6}", 1_700_000_000.0 + t))
        ),
    );
    write(
        "other.csv",
        format!(
            "t,temperature\n{}",
            rows(|_, t, _, _| format!("{:.2},20", 1_700_000_000.0 + t))
        ),
    );
    run(&["u_ms.csv", "y_s.csv", "other.csv", "-i", "u", "-o", "y"])
        .is_the_plant(all)
        .says("other.csv: this table contains none of the requested signals");
    // One name in both.
    write(
        "in.csv",
        format!("t,data\n{}", rows(|_, t, u, _| format!("{t:.2},{u}"))),
    );
    write(
        "out.csv",
        format!("t,data\n{}", rows(|_, t, _, y| format!("{t:.2},{y:.6}"))),
    );
    run(&["in.csv", "out.csv", "-i", "in.csv:data", "-o", "out:data"]).is_the_plant(all);
    run(&["in.csv", "out.csv", "y_s.csv", "-i", "data", "-o", "y"])
        .refused(&["in.csv:data", "out.csv:data"]);
    run(&["u_ms.csv", "y_s.csv", "-i", "u", "-o", "z"])
        .refused(&["no table has a column 'z'", "u, y"]);
    // Two clocks.
    run(&["in.csv", "y_s.csv", "-i", "data", "-o", "y"]).refused(&[
        "from 0.000 to 99.950 s",
        "apart, so no output sample has an input sample",
    ]);
    // Tables that have all signals are experiments, one after the other.
    write("run1.csv", format!("t,u,y\n{}", plain()));
    write("run2.csv", format!("t,u,y\n{}", plain()));
    run(&["run1.csv", "run2.csv", "-i", "u", "-o", "y"]).is_the_plant(2 * all);
    let topics = planesman(folder.path(), &["sysid", "topics", "u.csv", "y.csv"]);
    assert!(
        topics.text.contains("field.u") && topics.text.contains("field.y"),
        "{}",
        topics.text
    );
}

/// A name, and its value of input and output.
type Thing<'a> = (&'a str, &'a dyn Fn(f64, f64) -> f64);

/// The rows of several things one below the other, or in turns: time, what the number is of, and the number.
fn below_each_other(things: &[Thing<'_>], in_turns: bool) -> Vec<(f64, String, f64)> {
    let (u, y) = log(11, SAMPLES);
    let mut rows = Vec::new();
    for (thing, number) in things {
        let of = |k: usize| (k as f64 * STEP, (*thing).to_owned(), number(u[k], y[k]));
        rows.extend((0..SAMPLES).map(of));
    }
    if in_turns {
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    rows
}

#[test]
fn where_each_row_says_what_its_number_is_of_that_is_a_signal() {
    let folder = tempfile::tempdir().unwrap();
    let all = SAMPLES as u64;
    let things: [Thing<'_>; 2] = [("u", &|u, _| u), ("y", &|_, y| y)];
    for (header, sign, in_turns) in [
        ("time,name,value", ',', true),
        ("time,variable,value", ',', false),
        ("Series;Time;Value", ';', false),
        ("timestamp_ms\tmetric\tval", '\t', true),
        // Without names.
        ("", ',', true),
    ] {
        let mut text = String::new();
        for (t, name, number) in below_each_other(&things, in_turns) {
            let row = match header {
                "Series;Time;Value" => format!("{name};{t:.2};{number:.6}"),
                "timestamp_ms\tmetric\tval" => format!("{:.0}\t{name}\t{number:.6}", 1e3 * t),
                _ => format!("{t:.2}{sign}{name}{sign}{number:.6}"),
            };
            text += &(row + "\n");
        }
        let text = format!("{header}\n{text}");
        of(folder.path(), "long.csv", text.trim_start(), &[]).is_the_plant(all);
        let value = header.rsplit(sign).next().unwrap();
        let value = if value.is_empty() { "c3" } else { value };
        fit(folder.path(), &["long.csv", "-i", "u", "-o", value])
            .refused(&["several signals have the name", "choose one of u, y"]);
        fit(folder.path(), &["long.csv", "-i", "u", "-o", "yy"])
            .refused(&["no signal 'yy'", "did you mean 'y'?"]);
    }
    // Each with its own rate and place in the proposed command.
    let topics = planesman(folder.path(), &["sysid", "topics", "long.csv"]);
    for words in [
        "2000 at 20.000 Hz",
        "try: planesman sysid fit long.csv -i u -o y\n",
    ] {
        assert!(topics.text.contains(words), "{}", topics.text);
    }
}

#[test]
fn what_databases_export_is_told_apart_by_measurement_and_field() {
    let folder = tempfile::tempdir().unwrap();
    let all = SAMPLES as u64;
    let things: [Thing<'_>; 3] = [
        ("x,cmd", &|u, _| u),
        ("x,imu", &|_, y| y),
        ("depth,pressure", &|_, y| 2.0 * y),
    ];
    let mut text = "#datatype,string,long,dateTime:RFC3339,dateTime:RFC3339,double,string,string\n#group,false,false,true,false,false,true,true\n\
        #default,_result,,,,,,\n,result,table,_start,_time,_value,_field,_measurement\n"
        .to_owned();
    for (t, name, number) in below_each_other(&things, false) {
        let (minutes, seconds) = ((t / 60.0) as u64, t % 60.0);
        let start = "2026-11-24T11:00:00Z";
        writeln!(
            text,
            ",,0,{start},2026-11-24T12:{minutes:02}:{seconds:06.3}Z,{number:.6},{name}"
        )
        .unwrap();
    }
    let signals = |output| ["-i", "cmd.x", "-o", output];
    of(folder.path(), "influx.csv", text, &signals("imu.x")).is_the_plant(all);
    let double = fit(
        folder.path(),
        &[&["influx.csv"][..], &signals("depth")].concat(),
    );
    near(double.number("model/steady_state_gain/0"), 1.5, 0.01);
    fit(folder.path(), &["influx.csv", "-i", "x", "-o", "depth"])
        .refused(&["several signals have the name 'x'", "cmd.x, imu.x, depth"]);
}

#[test]
fn rows_of_two_vehicles_are_two_and_a_word_beside_the_numbers_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let all = SAMPLES as u64;
    let both =
        rows(|_, t, u, y| format!("{t:.2},alpha,{u},{y:.6}\n{t:.2},beta,{},{:.6}", -u, 5.0 + y));
    let text = format!("t,vehicle,u,y\n{both}");
    let alpha = ["-i", "u[alpha]", "-o", "y[alpha]"];
    of(folder.path(), "fleet.csv", &text, &alpha).is_the_plant(all);
    of(folder.path(), "fleet.csv", &text, &[])
        .refused(&["several signals have the name 'u'", "u[beta]"]);
    let word = |u: f64| if u > 0.0 { "up" } else { "down" };
    let text = rows(|_, t, u, y| format!("{t:.2},{},{u},{y:.6}", word(u)));
    of(folder.path(), "word.csv", format!("t,dir,u,y\n{text}"), &[]).is_the_plant(all);
}
