//! The report's thesis on adaptive control (Brunner 1988, p. 20): gains that are right at one foot per second are
//! not at three. The scenario `too_fast`, flown in one process with each source of gains.
use planesman_flight::compose::{Loop, Tick};
use planesman_flight::scenario::Scenario;

const SETPOINT: f64 = 10.3048;

/// The ticks of `too_fast` with this source of gains.
fn fly(source: &str) -> Vec<Tick> {
    let change = format!("depth_controller.gains.source={source}");
    let file = "launch-scripts/scenarios/too_fast.yaml";
    let scenario = Scenario::load_with(file, &[change]).unwrap();
    Loop::new(&scenario).unwrap().map(Result::unwrap).collect()
}

/// The largest depth error (m) between two times (s).
fn largest_error(ticks: &[Tick], from: f64, to: f64) -> f64 {
    let index = |time: f64| (time / 0.05) as usize;
    let depths = ticks[index(from)..index(to)]
        .iter()
        .map(|t| t.observation.state.depth);
    depths.map(|z| (z - SETPOINT).abs()).fold(0.0, f64::max)
}

#[test]
fn fixed_gains_lose_the_vehicle() {
    let ticks = fly("fixed");
    let late = largest_error(&ticks, 200.0, 240.0);
    assert!(
        late > 3.0 * 0.3048,
        "three times the step asked for: {late}"
    );
}

#[test]
fn scheduled_gains_hold_it() {
    let ticks = fly("scheduled");
    assert!(
        largest_error(&ticks, 200.0, 240.0) < 0.1,
        "{}",
        largest_error(&ticks, 200.0, 240.0)
    );
}

#[test]
fn adaptive_gains_hold_it_and_follow_the_identified_vehicle() {
    let ticks = fly("adaptive");
    assert!(
        largest_error(&ticks, 200.0, 240.0) < 0.1,
        "{}",
        largest_error(&ticks, 200.0, 240.0)
    );
    let last = &ticks[ticks.len() - 1].control;
    assert!(
        last.gains_adapted,
        "{:?}",
        ticks.iter().rev().find_map(|t| t.models.last())
    );
    assert!(!ticks[0].control.gains_adapted, "nothing is identified yet");
    // What is identified is the true plane moment, so the schedule's gain is met again.
    assert!(
        (last.gain_pitch_p / 0.7 - 1.0).abs() < 0.1,
        "{}",
        last.gain_pitch_p
    );
}
