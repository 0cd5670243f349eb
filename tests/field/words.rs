//! An input that was not recorded, given in words.

use std::fs;
use std::path::Path;

use planesman_testing::near;

use crate::answer::{Answer, fit};
use crate::plant::noise;

/// A motor, rad/s per V and s.
const GAIN: f64 = 20.0;
const TIME_CONSTANT: f64 = 0.4;

/// A log of the motor's speed beside `level`, at 20 Hz for 10 s from `begin` on; voltages from times on, s.
fn spin_up(path: &Path, begin: f64, level: f64, steps: &[(f64, f64)]) {
    let mut text = String::from("t,speed\n");
    for (k, e) in noise(41, 200).into_iter().enumerate() {
        let t = k as f64 * 0.05;
        let mut before = 0.0;
        let mut speed = level + 0.3 * e;
        for (time, volts) in steps {
            let since = (t - time).max(0.0);
            speed += GAIN * (volts - before) * (1.0 - libm::exp(-since / TIME_CONSTANT));
            before = *volts;
        }
        text += &format!("{:.2},{speed:.4}\n", begin + t);
    }
    fs::write(path, text).unwrap();
}

/// Checks that the model is the motor.
#[track_caller]
fn is_the_motor(answer: &Answer) {
    answer.says("verdict: good");
    near(answer.number("model/steady_state_gain/0"), GAIN, 0.05);
    near(
        answer.number("model/continuous_poles/0/re"),
        -1.0 / TIME_CONSTANT,
        0.02,
    );
}

#[test]
fn a_spin_up_from_rest_is_identified_by_the_voltage_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.csv");
    let of = |input: &str| {
        fit(
            folder.path(),
            &["log.csv", "-i", input, "-o", "speed", "--order", "1"],
        )
    };
    // Within an interval of the grid, on a clock of our time.
    spin_up(&log, 1.7e9, 0.0, &[(0.13, 12.0)]);
    let answer = of("12V from 0.13s");
    is_the_motor(answer.says("not recorded: 0 V before, 12 V from 0.13 s"));
    let same = of("0 to 12 V at 130 ms");
    assert_eq!(
        same.number("model/den/1"),
        answer.number("model/den/1"),
        "{}",
        same.brief()
    );
    // From the first sample on, beside a level.
    spin_up(&log, 0.0, 100.0, &[(0.0, 12.0)]);
    is_the_motor(of("12V from 0").says("at rest until that time"));
    // On, backwards and off.
    let steps = [(1.0, 12.0), (4.0, -6.0), (7.5, 0.0)];
    spin_up(&log, 5.0, 0.0, &steps);
    is_the_motor(&of("12 from 1s, -6 from 4s, 0 from 7.5s"));
}

#[test]
fn words_are_refused_at_their_place_and_a_column_of_that_name_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.csv");
    spin_up(&log, 0.0, 0.0, &[(1.0, 12.0), (4.0, -6.0), (7.5, 0.0)]);
    let of = |input: &str| {
        fit(
            folder.path(),
            &["log.csv", "-i", input, "-o", "speed", "--order", "1"],
        )
    };
    of("12V form 0.1s").refused(&[
        "'12V form 0.1s'",
        "--input",
        "'from'",
        "character 5",
        "'12V from 0.1s'",
    ]);
    of("5 from 4s, 0 from 1s").refused(&["a time later than the previous one", "character 19"]);
    of("volts from 1").refused(&["no column 'volts from 1'"]);
    let text = fs::read_to_string(&log).unwrap();
    let rows = text.lines().enumerate().map(|(k, row)| match k {
        0 => format!("{row},3 from 2s\n"),
        // The rows from 1 s up to 4 s, and up to 7.5 s.
        21..=80 => format!("{row},12\n"),
        81..=150 => format!("{row},-6\n"),
        _ => format!("{row},0\n"),
    });
    fs::write(&log, rows.collect::<String>()).unwrap();
    is_the_motor(&of("3 from 2s"));
}
