//! Open-loop runs of the hydraulics against an independent integration of the same equations
//! (`data/open_loop_traces.json` says which), on Tables 3-1 and 4-1 and the AUV set.

use crate::common::{Bench, Instant, actuator};
use planesman_units::{INCH, POUND_FORCE as POUND};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn traces() -> Value {
    serde_json::from_str(include_str!("data/open_loop_traces.json")).expect("JSON")
}

fn bench(trace: &Value) -> Bench {
    let commands: Vec<i8> = trace["commands"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|c| c.as_i64().expect("-1, 0 or 1") as i8)
        .collect();
    let set = actuator(
        trace["actuator"].as_str().expect("a name"),
        trace["leakage"].as_bool().expect("a boolean"),
        trace["friction"].as_bool().expect("a boolean"),
    );
    Bench::new(set, &commands)
}

fn rows(trace: &Value) -> Vec<(f64, Instant)> {
    trace["rows"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|row| {
            let expected = Instant {
                position: number(&row[1]),
                velocity: number(&row[2]),
                pressure: number(&row[3]),
                volume: number(&row[4]),
            };
            (number(&row[0]), expected)
        })
        .collect()
}

fn agrees(name: &str) {
    let all = traces();
    let trace = all["traces"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|trace| trace["name"] == name)
        .expect("in the file");
    let tolerance = &all["tolerance"];
    let mut bench = bench(trace);
    let mut last = 0.0;
    for (t, expected) in rows(trace) {
        let found = bench.at(t);
        let close = |a: f64, b: f64, what: &str| {
            assert!(
                (a - b).abs() <= number(&tolerance[what]),
                "{name} at {t} s: {what} {a} for {b}"
            );
        };
        close(found.position, expected.position, "X_1");
        close(found.velocity, expected.velocity, "X_1'");
        close(found.pressure, expected.pressure, "P_d");
        close(found.volume, expected.volume, "V_T");
        last = t;
    }
    if let Some(expected) = trace["friction_work"].as_f64() {
        let work = bench.slid(last) / INCH * (bench.set.load.coulomb / POUND);
        assert!(
            (work - expected).abs() <= 1e-7 * expected,
            "{name}: {work} for {expected}"
        );
    }
}

#[test]
fn five_pulses_out_and_three_back_on_the_hardware() {
    agrees("TR1");
}

#[test]
fn five_pulses_out_and_three_back_on_polaris() {
    agrees("TR2");
}

#[test]
fn four_pulses_ring_out_without_friction_or_leakage() {
    agrees("TR3");
}

#[test]
fn one_pulse_out_and_one_back_on_the_tight_hardware() {
    agrees("TR5");
}

#[test]
fn six_pulses_out_and_two_back_on_the_auv() {
    agrees("TR7");
}

#[test]
fn the_traces_do_not_depend_on_how_often_the_ram_is_looked_at() {
    for trace in traces()["traces"].as_array().expect("a list") {
        let (mut seldom, mut often) = (bench(trace), bench(trace));
        let mut t = 0.0;
        for (at, _) in rows(trace) {
            while t < at {
                often.reading(t);
                t += 137e-6;
            }
            assert_eq!(
                seldom.reading(at),
                often.reading(at),
                "{} at {at}",
                trace["name"]
            );
        }
    }
}
