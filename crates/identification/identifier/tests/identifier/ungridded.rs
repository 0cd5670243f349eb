//! Live signals that know nothing of each other's clocks: an output at 87 Hz, an input sent only when it changes.

use planesman_identification::Input;
use planesman_identifier::{IdentifierParameters, Pair, Sample, pair::FIRST};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

/// y_dot = -2 y + 3 u.
const POLE: f64 = -2.0;
const GAIN: f64 = 1.5;

fn pair() -> Pair {
    let parameters = IdentifierParameters {
        resample: true,
        order: 1,
        ..IdentifierParameters::default()
    };
    Pair::new(FIRST.to_owned(), &parameters).unwrap()
}

/// Sixty seconds of both signals: stamp, s, and what a message says.
fn messages(from: f64) -> Vec<(f64, Sample)> {
    let mut chance = Pcg64::seed_from_u64(1988);
    let (mut y, mut u, mut t, mut next) = (0.0, 0.0, from, from + 0.013);
    let mut said = Vec::new();
    let mut to_output = t;
    while t < from + 60.0 {
        if next <= to_output {
            y = GAIN * u + (y - GAIN * u) * libm::exp(POLE * (next - t));
            t = next;
            u = chance.random_range(-1.0..1.0);
            next += chance.random_range(0.03..0.8);
            let input = Some(Input::held(u));
            said.push((
                t,
                Sample {
                    input,
                    ..Sample::default()
                },
            ));
        } else {
            y = GAIN * u + (y - GAIN * u) * libm::exp(POLE * (to_output - t));
            t = to_output;
            to_output += chance.random_range(0.9..1.1) / 87.0;
            said.push((
                t,
                Sample {
                    output: Some(y),
                    ..Sample::default()
                },
            ));
        }
    }
    said
}

fn learn(pair: &mut Pair, messages: &[(f64, Sample)]) -> Vec<ModelEstimate> {
    messages
        .iter()
        .flat_map(|(t, sample)| pair.on_sample(Time::from_nanos((t * 1e9) as i64), sample))
        .collect()
}

/// To one per cent: the line between two samples cuts the corner that each step of the input makes.
fn assert_is_the_plant(found: &ModelEstimate) {
    assert!((found.s_poles_re[0] / POLE - 1.0).abs() < 0.01, "{found:?}");
    assert!(
        (found.steady_state_gain / GAIN - 1.0).abs() < 0.01,
        "{found:?}"
    );
}

#[test]
fn resampled_they_give_the_plant() {
    let mut pair = pair();
    let estimates = learn(&mut pair, &messages(0.3));
    let last = estimates.last().unwrap();
    assert!(last.valid, "{}", last.reason);
    assert_is_the_plant(last);
    // Before the first input, and never again.
    assert_eq!(pair.account().gaps, 1);
    assert!(pair.trouble().is_none());
}

#[test]
fn the_order_they_arrive_in_does_not_matter() {
    let messages = messages(0.3);
    let mut delayed = messages.clone();
    // Inputs arrive up to a third of a second late.
    let arrival = |(t, sample): &(f64, Sample)| t + if sample.input.is_some() { 0.3 } else { 0.0 };
    delayed.sort_by(|a, b| arrival(a).total_cmp(&arrival(b)));
    let of = |messages: &[(f64, Sample)]| {
        let mut pair = pair();
        learn(&mut pair, messages);
        pair.finish();
        pair.model()
    };
    assert_eq!(of(&messages), of(&delayed));
}

#[test]
fn a_recording_that_loops_begins_anew_and_finds_the_same() {
    let mut pair = pair();
    learn(&mut pair, &messages(1000.3));
    let estimates = learn(&mut pair, &messages(0.3));
    let last = estimates.last().unwrap();
    assert_eq!(last.restarts, 1);
    assert_is_the_plant(last);
}
