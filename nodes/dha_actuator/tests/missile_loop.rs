//! The pulse logic in the loop it was made for: the actuator open loop inside a digital autopilot
//! around an unstable missile (IBM 66-L03-005, Figures 2-4 and 2-5).
//!
//! ```text
//! N_ye    = N_y - (K_b/K_2) psi
//! Input_n = K_a K_2 [(N_ye,n - N_ye,n-1) + K N_ye,n] - K_r (psi'_n - psi'_(n-1))
//! psi''   = mu_b beta + mu_d delta,   beta' = psi' - Y_b beta + Y_d delta
//! ```
//!
//! The missile is a surrogate: the report's constants are lost, and these were calibrated on the
//! base row of its Table 4-2. Here it only has to agree with another simulation of itself.

mod common;

use common::actuator;
use dha_actuator::hydraulics::Hydraulics;
use dha_actuator::pulse_logic::{PulseLogic, Volume};
use dha_actuator::units::{DEGREE, INCH};
use serde_json::Value;

const K_A: f64 = 18.0;
const K_R: f64 = 2.8;
const K_2: f64 = 0.075;
const K: f64 = 1.0 / 128.0;
const MU_D: f64 = 3.1;
const MU_B: f64 = 14.0;
const Y_B: f64 = 0.1;
const Y_D: f64 = 0.0035 * MU_D;
const N_Y: f64 = 5.0;

/// psi, psi' and beta in degrees and seconds.
type Missile = [f64; 3];

fn rates([_, psi_dot, beta]: Missile, delta: f64) -> Missile {
    [
        psi_dot,
        MU_B * beta + MU_D * delta,
        psi_dot - Y_B * beta + Y_D * delta,
    ]
}

/// A Runge-Kutta step of `h` s with delta, deg, at its begin, middle and end.
fn step(x: Missile, delta: [f64; 3], h: f64) -> Missile {
    let moved = |k: Missile, h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
    let k1 = rates(x, delta[0]);
    let k2 = rates(moved(k1, 0.5 * h), delta[1]);
    let k3 = rates(moved(k2, 0.5 * h), delta[1]);
    let k4 = rates(moved(k3, h), delta[2]);
    std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}

#[test]
fn five_steering_pulses_turn_the_missile_with_the_expected_volume_pulses() {
    let expected: Value =
        serde_json::from_str(include_str!("data/missile_loop.json")).expect("JSON");
    let commands = expected["commands"].as_array().expect("a list");
    let set = actuator("table_4_1", true, true);
    let period = set.cycle();
    let (mut logic, mut hydraulics) = (PulseLogic::new(&set), Hydraulics::new(&set));
    let mut missile: Missile = [0.0; 3];
    let (mut steering_before, mut psi_dot_before) = (0.0, 0.0);
    let mut rows = expected["rows"]
        .as_array()
        .expect("a list")
        .iter()
        .peekable();
    for (n, command) in commands.iter().enumerate() {
        let [psi, psi_dot, _] = missile;
        let steering = N_Y - psi / K_2;
        let input = K_A * K_2 * ((steering - steering_before) + K * steering)
            - K_R * (psi_dot - psi_dot_before);
        (steering_before, psi_dot_before) = (steering, psi_dot);
        let ram = hydraulics
            .reading(if n == 0 { 0.0 } else { period })
            .ram
            .position;
        let decision = logic.accumulate(input * DEGREE, ram);
        let sent = match decision.command.volume {
            Volume::None => 0,
            _ => i64::from(decision.command.sign),
        };
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
            close(psi, 1, "psi");
            close(ram / INCH, 2, "X_1");
            close(logic.error() / DEGREE, 3, "eps");
        }
        hydraulics.begin_cycle(decision.command);
        let steps = 100;
        let h = period / f64::from(steps);
        let mut delta = ram / set.moment_arm / DEGREE;
        for i in 0..steps {
            let [middle, end] = [0.5, 1.0].map(|part| {
                let time = ((f64::from(i) + part) * h).min(period);
                hydraulics.advance(time);
                hydraulics.reading(time).ram.position / set.moment_arm / DEGREE
            });
            missile = step(missile, [delta, middle, end], h);
            delta = end;
        }
        hydraulics.finish_cycle();
    }
    assert!(rows.next().is_none());
}
