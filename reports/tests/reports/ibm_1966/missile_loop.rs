//! The pulse logic in the loop it was made for: the actuator open loop inside the digital autopilot
//! around the missile's surrogate (IBM 66-L03-005, Figures 2-4 and 2-5), against another simulation
//! of the same loop.

use planesman_hydraulics::{Options, SignChange};
use planesman_reports::ibm_1966::{Case, DigitalLoop, Start, Surrogate};
use planesman_units::{DEGREE, INCH};
use serde_json::Value;

fn missile(start: Start) -> DigitalLoop {
    Case::table_4_1(Surrogate::Ps2)
        .expect("built in")
        .fly(start)
}

#[test]
fn five_steering_pulses_turn_the_missile_with_the_expected_volume_pulses() {
    let expected: Value = serde_json::from_str(include_str!("missile_loop.json")).expect("JSON");
    let commands = expected["commands"].as_array().expect("a list");
    let rows = expected["rows"].as_array().expect("a list");
    let mut rows = rows.iter().peekable();
    let mut flight = missile(Start::default());
    for (n, command) in commands.iter().enumerate() {
        let (psi, ram) = (flight.yaw().angle, flight.ram());
        let sent = i64::from(flight.cycle(5.0, |_| ()));
        assert_eq!(sent, command.as_i64().expect("-1, 0 or 1"), "cycle {n}");
        if let Some(row) = rows.next_if(|row| row[0] == n) {
            let close = |found: f64, column: usize, what: &str| {
                let expected_value = row[column].as_f64().expect("a number");
                let tolerance = expected["tolerance"][what].as_f64().expect("a number");
                assert!(
                    (found - expected_value).abs() <= tolerance,
                    "cycle {n}: {what} {found} for {expected_value}"
                );
            };
            close(psi / DEGREE, 1, "psi");
            close(ram / INCH, 2, "X_1");
            close(flight.error() / DEGREE, 3, "eps");
        }
    }
    assert!(rows.next().is_none());
}

#[test]
fn half_a_degree_off_course_is_taken_back_with_the_expected_volume_pulses() {
    let mut flight = missile(Start {
        yaw: -0.5 * DEGREE,
        ram: 0.0,
    });
    let expected = "+++++++00------0----0-0-000-0000000000000000+";
    for (n, command) in expected.chars().enumerate() {
        if n == 24 {
            assert!((flight.yaw().angle / DEGREE + 0.043_396_62).abs() < 1e-6);
        }
        let quanta = match command {
            '+' => 1,
            '-' => -1,
            _ => 0,
        };
        assert_eq!(flight.cycle(0.0, |_| ()), quanta, "cycle {n}");
    }
}

/// psi from peak to peak, deg, that is left of half a degree under these options.
fn limit_cycle(options: Options) -> f64 {
    let case = Case::table_4_1(Surrogate::Ps2).expect("built in");
    Case { options, ..case }.limit_cycle().yaw / DEGREE
}

#[test]
fn dropping_the_volume_of_a_sign_change_makes_the_limit_cycle_ten_times_what_it_is() {
    let moved = limit_cycle(Options::SINGLE_SPEED);
    assert!((moved - 0.0133).abs() < 0.003, "{moved}");
    let dropped = limit_cycle(Options {
        sign_change: SignChange::DropsVolume,
        ..Options::SINGLE_SPEED
    });
    assert!((dropped - 0.14).abs() < 0.02, "{dropped}");
}

#[test]
fn precision_mode_does_not_help_the_missile_which_has_no_position_loop() {
    let single_speed = limit_cycle(Options::SINGLE_SPEED);
    let precise = limit_cycle(Options::PRECISION);
    assert!(precise > 3.0 * single_speed, "{precise}");
}
