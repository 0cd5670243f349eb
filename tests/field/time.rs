//! The time base: units, clocks that wrap or are set back, stamps that are too coarse, samples in bursts, slow sensors, angles
//! that wrap.

use std::fs;
use std::path::Path;

use planesman_testing::near;

use crate::answer::{Answer, fit};
use crate::plant::{GAIN, SAMPLES, STEP, log, noise, prbs, second_order, table};

/// The model of the usual log in a table whose times are written so.
fn with_times(name: &str, time: impl Fn(usize) -> String, arguments: &[&str]) -> Answer {
    let (u, y) = log(1, SAMPLES);
    let rows = (0..SAMPLES).map(|k| (time(k), u[k], y[k]));
    of_table(&table(&format!("{name},u,y"), rows), arguments)
}

fn of_table(text: &str, arguments: &[&str]) -> Answer {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.csv"), text).unwrap();
    in_folder(folder.path(), arguments)
}

fn in_folder(folder: &Path, arguments: &[&str]) -> Answer {
    fit(
        folder,
        &[&["log.csv", "-i", "u", "-o", "y"], arguments].concat(),
    )
}

/// Seconds from the beginning.
fn at(k: usize) -> f64 {
    k as f64 * STEP
}

#[test]
fn a_unit_is_known_by_name_by_size_or_by_steps() {
    let whole = |first: f64, unit: f64| move |k| format!("{:.0}", first + at(k) / unit);
    let real = |first: f64, unit: f64| move |k| format!("{:.9}", first + at(k) / unit);
    type Times = Box<dyn Fn(usize) -> String>;
    let cases: [(&str, Times); 20] = [
        ("t", Box::new(real(0.0, 1.0))),
        ("timestamp", Box::new(whole(13_550_000.0, 1e-6))),
        ("time", Box::new(whole(77.0, 1e-9))),
        ("TimeUS", Box::new(whole(3_550_123.0, 1e-6))),
        ("timestamp_sample", Box::new(whole(3_550_123.0, 1e-6))),
        ("micros", Box::new(whole(0.0, 1e-6))),
        ("millis", Box::new(whole(0.0, 1e-3))),
        ("time/ms", Box::new(whole(0.0, 1e-3))),
        ("Time (ms)", Box::new(real(0.5, 1e-3))),
        ("time_boot_ms", Box::new(whole(1000.0, 1e-3))),
        ("time_usec", Box::new(whole(1000.0, 1e-6))),
        ("time [min]", Box::new(real(0.0, 60.0))),
        ("t_h", Box::new(real(0.0, 3600.0))),
        ("timestamp", Box::new(|k| format!("{:.3}", 1.7e9 + at(k)))),
        ("timestamp", Box::new(whole(1.7e12, 1e-3))),
        ("timestamp", Box::new(whole(1.7e15, 1e-6))),
        (
            "rosbagTimestamp",
            Box::new(|k| format!("{}", 1_700_000_000_000_000_000 + k as u64 * 50_000_000)),
        ),
        // Excel's days since 1900, MATLAB's since the year 0.
        (
            "time",
            Box::new(|k| format!("{:.11}", 46_350.5 + at(k) / 86_400.0)),
        ),
        (
            "time",
            Box::new(|k| format!("{:.10}", 739_945.5 + at(k) / 86_400.0)),
        ),
        ("seconds", Box::new(real(0.0, 1.0))),
    ];
    for (name, time) in cases {
        with_times(name, time, &[]).is_the_plant(SAMPLES as u64);
    }
}

#[test]
fn a_rate_that_cannot_be_meant_is_questioned_in_the_verdict() {
    // Minutes that are written as whole seconds would be, and days without their date.
    for (first, unit) in [(0.0, 1.0 / 72_000.0), (0.0, 86_400.0)] {
        let time = |k| format!("{:.12}", first + at(k) / unit);
        let answer = with_times("t", time, &[]);
        assert!(
            !answer.said().contains("verdict: good"),
            "{}",
            answer.said()
        );
        answer
            .says("the unit of the times is not given")
            .says("--time-unit");
    }
    with_times(
        "t",
        |k| format!("{:.12}", at(k) / 86_400.0),
        &["--time-unit", "d"],
    )
    .is_the_plant(SAMPLES as u64);
}

#[test]
fn steps_that_may_be_milliseconds_are_questioned() {
    let whole = |k: usize| format!("{}", 50 * k);
    let answer = with_times("time", whole, &[]);
    answer
        .says("milliseconds can have such steps")
        .says("the times are in doubt");
    with_times("time", whole, &["--time-unit", "ms"]).is_the_plant(SAMPLES as u64);
    with_times("time [ms]", whole, &[]).is_the_plant(SAMPLES as u64);
}

#[test]
fn a_stamp_that_is_damaged_costs_its_sample_alone() {
    for (damaged, samples) in [(1e9, SAMPLES), (0.0, SAMPLES)] {
        let begin = if damaged == 0.0 { 1.7e9 } else { 0.0 };
        let time = |k: usize| {
            let stamp = if k % 500 == 77 {
                damaged
            } else {
                begin + at(k)
            };
            format!("{stamp:.2}")
        };
        with_times("t", time, &[]).is_the_plant(samples as u64);
    }
}

#[test]
fn a_clock_that_is_set_right_after_the_start_parts_the_record() {
    let time = |k: usize| format!("{:.2}", at(k) + if k > 100 { 1.7e9 } else { 0.0 });
    let answer = with_times("t", time, &[]);
    answer.is_the_plant(SAMPLES as u64);
    assert_eq!(
        answer.json["record"]["segments"].as_array().unwrap().len(),
        2
    );
}

#[test]
fn samples_in_bursts_of_any_length_are_spread_over_the_time_between() {
    for longest in [4, 20] {
        let mut times = Vec::new();
        let lengths = noise(15, SAMPLES).into_iter();
        for length in lengths.map(|it| 3 + (it.abs() * 1e4) as usize % longest) {
            // All are received with the last of them.
            let received = at(times.len() + length - 1) + 0.01;
            times.extend((0..length).map(|k| received + 1e-4 * k as f64));
        }
        let answer = with_times("t", |k| format!("{:.4}", times[k]), &[]);
        answer.is_the_plant(SAMPLES as u64);
        assert!(answer.text.contains("share_a_stamp"), "{}", answer.brief());
    }
}

#[test]
fn the_time_of_a_counter_that_wraps_goes_on() {
    for (name, modulus, unit, first) in [
        ("time_us", 1_u64 << 32, 1e-6, (1_u64 << 32) - 50_000_000),
        ("time_ms", 1 << 32, 1e-3, (1 << 32) - 31_000),
        ("t_ms", 1 << 16, 1e-3, 20_000),
        ("t_us", 1 << 31, 1e-6, (1 << 31) - 70_000_000),
    ] {
        let time = |k| format!("{}", (first + (at(k) / unit).round() as u64) % modulus);
        with_times(name, time, &[])
            .is_the_plant(SAMPLES as u64)
            .says("wraps");
    }
}

#[test]
fn the_time_of_day_goes_on_at_midnight() {
    let time = |k| {
        let of_day = (86_350_000 + (at(k) * 1e3).round() as u64) % 86_400_000;
        let (seconds, ms) = (of_day / 1000, of_day % 1000);
        format!(
            "{:02}:{:02}:{:02}.{ms:03}",
            seconds / 3600,
            seconds / 60 % 60,
            seconds % 60
        )
    };
    with_times("time", time, &[])
        .is_the_plant(SAMPLES as u64)
        .says("a day");
}

#[test]
fn a_clock_that_is_set_back_parts_the_record() {
    for back in [0.5, 3.65, 3.7, 40.0] {
        let time = |k: usize| {
            let shift = if k > 1000 { back } else { 0.0 };
            format!("{:.3}", 1.7e9 + at(k) - shift)
        };
        let answer = with_times("time", time, &[]);
        answer.is_the_plant(SAMPLES as u64).says("goes back");
        assert_eq!(
            answer.json["record"]["segments"].as_array().unwrap().len(),
            2
        );
    }
}

#[test]
fn a_clock_that_begins_anew_parts_the_record_each_time() {
    let (u, y) = log(2, SAMPLES);
    // Each run begins at rest, at 0 s, or where the machine was started.
    for (run, first) in [(500, 0.0), (700, 0.0), (1000, 300.0), (400, 0.0)] {
        let rows = (0..SAMPLES).map(|k| (format!("{:.2}", first + at(k % run)), u[k], y[k]));
        let answer = of_table(&table("t,u,y", rows), &[]);
        answer.is_the_plant(SAMPLES as u64).says("goes back");
        let segments = answer.json["record"]["segments"].as_array().unwrap().len();
        assert_eq!(segments, SAMPLES.div_ceil(run));
    }
}

#[test]
fn a_straggler_does_not_part_the_record() {
    let (u, y) = log(1, SAMPLES);
    let mut order: Vec<usize> = (0..SAMPLES).collect();
    for k in (40..SAMPLES - 40).step_by(97) {
        let straggler = order.remove(k);
        order.insert(k + 20, straggler);
    }
    // Blocks of ten in wrong order.
    order
        .chunks_mut(20)
        .skip(50)
        .step_by(7)
        .for_each(|it| it.rotate_left(10));
    let rows = order
        .into_iter()
        .map(|k| (format!("{:.2}", at(k)), u[k], y[k]));
    let answer = of_table(&table("t,u,y", rows), &[]);
    answer.is_the_plant(SAMPLES as u64);
    assert_eq!(
        answer.json["record"]["segments"].as_array().unwrap().len(),
        1
    );
}

#[test]
fn rows_that_are_not_sorted_are_refused() {
    let (u, y) = log(4, SAMPLES);
    let rows = (0..SAMPLES)
        .rev()
        .map(|k| (format!("{:.2}", at(k)), u[k], y[k]));
    let answer = of_table(&table("t,u,y", rows), &[]);
    answer.refused(&["Sort the samples by time", "--time"]);
}

#[test]
fn rows_of_one_second_are_spread_over_it() {
    // Whole seconds, from the middle of one; tenths; dates; half the rows of a second are missing.
    let whole = |k: usize| format!("{}", ((at(k) + 0.35) as u64));
    let tenths = |k: usize| format!("{:.1}", ((at(k) * 10.0 + 1e-6).floor()) / 10.0);
    let dates = |k: usize| {
        let second = at(k) as u64;
        format!("2026-05-01 10:{:02}:{:02}", second / 60, second % 60)
    };
    with_times("time", whole, &[]).is_the_plant(SAMPLES as u64);
    with_times("time", tenths, &[]).is_the_plant(SAMPLES as u64);
    let answer = with_times("timestamp", dates, &[]);
    answer.is_the_plant(SAMPLES as u64);
    near(answer.number("record/sample_time"), STEP, 1e-9);
}

#[test]
fn a_time_without_its_digits_asks_for_the_sample_time() {
    // As a spreadsheet writes an epoch in six digits.
    let time = |_| "1.70000e+09".to_owned();
    with_times("time", time, &[]).refused(&["--sample-time"]);
    with_times("time", time, &["--sample-time", "0.05s"]).is_the_plant(SAMPLES as u64);
}

#[test]
fn stamps_in_coarse_steps_are_spread_evenly() {
    // 400 rows a second by a clock of milliseconds; 150 by one whose numbers have 24 bits, a day after its start.
    let milliseconds = |k: usize| format!("{:.3}", (k as f64 * 2.5).floor() / 1000.0);
    let single = |k: usize| format!("{:.7}", f64::from((100_000.0 + k as f64 / 150.0) as f32));
    for (rate, time) in [
        (400.0, &milliseconds as &dyn Fn(usize) -> String),
        (150.0, &single),
    ] {
        let count = 8000;
        let u: Vec<f64> = prbs(11, count)
            .chunks(10)
            .flat_map(|it| [it[0]; 100])
            .take(count)
            .collect();
        let y = second_order([3.0 * 400.0, 1.2 * 20.0, 4.0 * 400.0], 1.0 / rate, &u);
        let noise = noise(12, count);
        let rows = (0..count).map(|k| (time(k), u[k], y[k] + 0.002 * noise[k]));
        let answer = of_table(&table("t,u,y", rows), &["--order", "2"]);
        near(answer.number("record/sample_time") * rate, 1.0, 0.001);
        near(answer.number("model/continuous_poles/0/re"), -12.0, 0.2);
        near(answer.number("model/steady_state_gain/0"), GAIN, 0.005);
    }
}

#[test]
fn rows_that_are_there_twice_count_once() {
    let (u, y) = log(13, SAMPLES);
    let rows = (0..2 * SAMPLES).map(|k| (format!("{:.2}", at(k / 2)), u[k / 2], y[k / 2]));
    of_table(&table("t,u,y", rows), &[]).is_the_plant(SAMPLES as u64);
}

#[test]
fn tables_one_behind_the_other_are_runs_of_one_model() {
    let (u, y) = log(14, SAMPLES);
    let rows = |from: usize| {
        table(
            "t,u,y",
            (0..1000).map(|k| (format!("{:.2}", at(k)), u[from + k], y[from + k])),
        )
    };
    let answer = of_table(&(rows(0) + &rows(1000)), &[]);
    answer.is_the_plant(SAMPLES as u64).says("goes back");
}

#[test]
fn a_slow_sensor_in_a_fast_log_counts_by_its_own_samples() {
    // The log has 100 rows a second, the sensor 10 samples.
    let count = 6000;
    let u = prbs(6, count);
    let y = second_order([3.0, 1.2, 4.0], 0.01, &u);
    for rows in [5, 10] {
        let rows_of =
            (0..count).map(|k| (format!("{:.2}", k as f64 * 0.01), u[k], y[k / rows * rows]));
        let answer = of_table(&table("t,u,y", rows_of), &[]);
        near(
            answer.number("record/sample_time"),
            0.01 * rows as f64,
            1e-9,
        );
        answer.is_the_plant((count / rows) as u64);
    }
}

#[test]
fn an_angle_that_wraps_is_unwrapped() {
    // The heading of 0.5/(s (2 s + 1)) to a rudder, with a mean that turns it round and round.
    let count = 4000;
    let u: Vec<f64> = prbs(7, count).iter().map(|u| 10.0 * u + 4.0).collect();
    let heading = second_order([0.25, 0.5, 0.0], STEP, &u);
    let heading: Vec<f64> = heading
        .iter()
        .zip(noise(8, count))
        .map(|(y, e)| y + 0.02 * e)
        .collect();
    let pi = std::f64::consts::PI;
    for (low, period) in [
        (0.0, 360.0),
        (-180.0, 360.0),
        (-pi, 2.0 * pi),
        (0.0, 2.0 * pi),
        (0.0, 65_536.0),
        (-32_768.0, 65_536.0),
    ] {
        let unit = period / 360.0;
        let rows = (0..count).map(|k| {
            let wrapped = (heading[k] * unit - low).rem_euclid(period) + low;
            (format!("{:.2}", at(k)), u[k] * unit, wrapped)
        });
        let answer = of_table(&table("t,u,y", rows), &[]);
        let poles = answer
            .json
            .pointer("/model/continuous_poles")
            .unwrap()
            .as_array()
            .unwrap();
        let mut poles: Vec<f64> = poles.iter().map(|it| it["re"].as_f64().unwrap()).collect();
        poles.sort_by(f64::total_cmp);
        assert_eq!(poles.len(), 2, "{low} {period}: {}", answer.said());
        near(poles[0], -0.5, 0.01);
        near(poles[1], 0.0, 0.001);
    }
}
