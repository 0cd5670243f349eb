//! The identifier on the loop's own messages: a vehicle with heave, pitch rate and pitch under
//! depth control, its planes moved in quanta within each tick.
//!
//! The vehicle is the dimensional form of programs T2-T5 (Brunner, NPS thesis, 1988, App. A
//! and Table 1) at U = 1 ft/s, in slug, ft and s:
//! ```text
//! 1.6098 w' =  0.0627 delta - 0.8541 w + 0.3016 q
//! 0.6033 q' = -0.2832 delta + 0.1354 w - 0.7182 q - 0.16333 sin theta
//! ```

#![allow(clippy::unwrap_used)]

use planesman_linear::{Complex, DMatrix, StateSpace};
use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, PlaneMotion, VehicleState};
use planesman_parameters::{Value, Values};
use sysid::core::Identifier;
use sysid::parameters::declarations;

const TICK: i64 = 50_000_000;
const START: i64 = 1_767_225_600_000_000_000;
const SUBSTEPS: usize = 50;
const SUBSTEP: f64 = 0.05 / SUBSTEPS as f64;
/// Plane angle per quantum of the actuator, rad.
const QUANTUM: f64 = 0.01;

fn stamp(tick: i64) -> Time {
    Time::from_nanos(START + tick * TICK)
}

fn derivative([w, q, pitch, _]: [f64; 4], planes: f64) -> [f64; 4] {
    [
        (0.0627 * planes - 0.8541 * w + 0.3016 * q) / 1.6098,
        (-0.2832 * planes + 0.1354 * w - 0.7182 * q - 0.16333 * pitch.sin()) / 0.6033,
        q,
        w * pitch.cos() - pitch.sin(),
    ]
}

/// q/delta of the vehicle, linear about level flight.
fn true_poles() -> Vec<Complex<f64>> {
    StateSpace::new(
        DMatrix::from_row_slice(
            3,
            3,
            &[
                -0.8541 / 1.6098,
                0.3016 / 1.6098,
                0.0,
                0.1354 / 0.6033,
                -0.7182 / 0.6033,
                -0.16333 / 0.6033,
                0.0,
                1.0,
                0.0,
            ],
        ),
        DMatrix::from_row_slice(3, 1, &[0.0627 / 1.6098, -0.2832 / 0.6033, 0.0]),
        DMatrix::from_row_slice(1, 3, &[0.0, 1.0, 0.0]),
        DMatrix::zeros(1, 1),
    )
    .unwrap()
    .poles()
    .unwrap()
}

/// A dive to 3 ft: the messages of `state` and `plane_motion`, tick by tick. The planes
/// follow the depth law and a pseudo-random signal of `excitation` rad, a quantum at a time.
fn dive(ticks: i64, excitation: f64) -> Vec<(VehicleState, PlaneMotion)> {
    let mut x = [0.0_f64; 4];
    let mut planes = 0.0_f64;
    let mut register = 0x2aa_u32;
    let mut messages = Vec::new();
    for tick in 0..ticks {
        let [w, q, pitch, depth] = x;
        let depth_rate = derivative(x, planes)[3];
        let mut state = VehicleState {
            depth,
            depth_rate,
            pitch,
            pitch_rate: q,
            heave: w,
            dive_planes: planes,
            ..VehicleState::default()
        };
        state.header.stamp = stamp(tick);
        if tick % 10 == 0 {
            let feedback = (register ^ (register >> 3)) & 1;
            register = (register >> 1) | (feedback << 9);
        }
        let signal = if register & 1 == 1 {
            excitation
        } else {
            -excitation
        };
        let pitch_command = (-0.25 * (3.0 - depth) + 0.6 * depth_rate).clamp(-0.785, 0.785);
        let command = (-0.7 * (pitch_command - pitch) + 2.0 * q + signal).clamp(-0.524, 0.524);
        let mut motion = PlaneMotion {
            duration: Duration::from_nanos(TICK),
            dive_planes: vec![planes],
            ..PlaneMotion::default()
        };
        motion.header.stamp = stamp(tick);
        for substep in 0..SUBSTEPS {
            // A pulse every 12 substeps moves the planes one quantum over four of them.
            let before = planes;
            let pulse = (tick as usize * SUBSTEPS + substep) % 12;
            if pulse < 4 && (command - planes).abs() > 0.5 * QUANTUM {
                planes += 0.25 * QUANTUM * (command - planes).signum();
            }
            let middle = 0.5 * (before + planes);
            let along = |k: [f64; 4], h: f64| [0, 1, 2, 3].map(|i| x[i] + h * k[i]);
            let k1 = derivative(x, before);
            let k2 = derivative(along(k1, SUBSTEP / 2.0), middle);
            let k3 = derivative(along(k2, SUBSTEP / 2.0), middle);
            let k4 = derivative(along(k3, SUBSTEP), planes);
            x = [0, 1, 2, 3]
                .map(|i| x[i] + SUBSTEP / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            motion.dive_planes.push(planes);
        }
        messages.push((state, motion));
    }
    messages
}

fn identifier(changes: &[(&str, Value)]) -> Identifier {
    let values = Values::defaults(declarations())
        .with(
            changes
                .iter()
                .map(|(name, value)| ((*name).to_owned(), value.clone())),
        )
        .unwrap();
    Identifier::new(&values).unwrap()
}

/// One message of the record.
#[derive(Clone, Debug)]
enum Message {
    State(VehicleState),
    Motion(PlaneMotion),
}

impl Message {
    fn tick(&self) -> i64 {
        let header = match self {
            Self::State(state) => &state.header,
            Self::Motion(motion) => &motion.header,
        };
        (header.stamp.nanos() - START) / TICK
    }
}

/// The record as the loop sends it.
fn in_order(ticks: i64) -> Vec<Message> {
    dive(ticks, 0.05)
        .into_iter()
        .flat_map(|(state, motion)| [Message::State(state), Message::Motion(motion)])
        .collect()
}

fn feed(identifier: &mut Identifier, message: &Message) -> Vec<ModelEstimate> {
    match message {
        Message::State(m) => identifier.on("/auv/state", m.header.stamp.clone(), m),
        Message::Motion(m) => identifier.on("/auv/plane_motion", m.header.stamp.clone(), m),
    }
    .unwrap()
}

/// Every estimate published on the way, and what was held back at the end.
fn estimates(identifier: &mut Identifier, messages: &[Message]) -> Vec<ModelEstimate> {
    let mut estimates: Vec<_> = messages
        .iter()
        .flat_map(|message| feed(identifier, message))
        .collect();
    estimates.extend(identifier.finish());
    estimates
}

/// Distance from the true slowest pole, as a share of its magnitude.
fn miss(identifier: &Identifier) -> f64 {
    let slowest = true_poles()[0];
    (identifier.model().dominant_pole().unwrap() - slowest).norm() / slowest.norm()
}

#[test]
fn a_thirty_second_dive_through_a_quantized_actuator_gives_the_dominant_pole_within_a_tenth() {
    let mut identifier = identifier(&[]);
    let published = estimates(&mut identifier, &in_order(600));
    let last = published.last().unwrap();
    assert!(last.valid, "{}", last.reason);
    assert!(miss(&identifier) < 0.10, "{}", miss(&identifier));
    assert!(last.fit > 99.99);
    // The planes hold no pitch rate: restoring brings it back to zero.
    assert!(
        last.has_dc_gain && last.dc_gain.abs() < 0.01,
        "{}",
        last.dc_gain
    );
    assert_eq!(last.covariance.len(), 81);
    assert_eq!((last.a.len(), last.b.len(), last.c.len()), (3, 3, 3));
    assert_eq!(last.samples, 590);
}

#[test]
fn the_inputs_mean_alone_takes_the_timing_of_quanta_for_dynamics() {
    let mut mean_only = identifier(&[("first_moment", false.into())]);
    estimates(&mut mean_only, &in_order(600));
    assert!(miss(&mean_only) > 0.20, "{}", miss(&mean_only));
}

#[test]
fn the_estimate_depends_on_the_messages_and_not_on_their_order() {
    let messages = in_order(300);
    let live = estimates(&mut identifier(&[]), &messages);
    assert_eq!(live.len(), 29);
    let mut motion_first = messages.clone();
    for pair in motion_first.chunks_mut(2) {
        pair.reverse();
    }
    let mut in_blocks = messages.clone();
    for block in in_blocks.chunks_mut(14) {
        block.reverse();
    }
    let repeated: Vec<Message> = messages
        .windows(4)
        .flat_map(|window| [window[0].clone(), window[3].clone(), window[0].clone()])
        .collect();
    for (name, order) in [
        ("motion first", motion_first),
        ("in blocks backwards", in_blocks),
        ("repeated", repeated),
    ] {
        assert_eq!(estimates(&mut identifier(&[]), &order), live, "{name}");
    }
}

#[test]
fn a_gap_keeps_the_estimate_and_costs_only_the_rows_it_touches() {
    let messages: Vec<Message> = in_order(600)
        .into_iter()
        .filter(|message| !(300..310).contains(&message.tick()))
        .collect();
    let mut identifier = identifier(&[]);
    estimates(&mut identifier, &messages);
    let last = identifier.estimate(stamp(600));
    // 600 ticks without 10, and n rows short of a whole history on each side.
    assert_eq!(last.samples, 600 - 10 - 2 * 3);
    assert!(last.valid && miss(&identifier) < 0.10);
}

#[test]
fn time_going_back_begins_the_identification_anew() {
    let messages = in_order(200);
    let once = estimates(&mut identifier(&[]), &messages);
    let mut twice = identifier(&[]);
    for message in &messages {
        feed(&mut twice, message);
    }
    assert_eq!(estimates(&mut twice, &messages), once);
    let mut reset = identifier(&[]);
    for message in &messages {
        feed(&mut reset, message);
    }
    reset.reset();
    assert_eq!(reset.estimate(stamp(0)).samples, 0);
    assert_eq!(estimates(&mut reset, &messages), once);
}

#[test]
fn a_lockstep_tick_is_answered_with_its_state_or_the_motion_before_it() {
    let messages = in_order(5);
    let mut identifier = identifier(&[]);
    let mut answered = Vec::new();
    for message in &messages {
        feed(&mut identifier, message);
        answered.push((identifier.answered().unwrap().nanos() - START) / TICK);
    }
    assert_eq!(answered, vec![0, 0, 1, 1, 2, 2, 3, 3, 4, 4]);
}

#[test]
fn an_estimate_says_why_it_is_not_valid() {
    let messages = in_order(300);
    let mut early = identifier(&[]);
    assert!(
        early
            .estimate(stamp(0))
            .reason
            .contains("0 rows, 60 are needed")
    );
    for message in &messages[..100] {
        feed(&mut early, message);
    }
    let estimate = early.estimate(stamp(50));
    assert!(
        !estimate.valid && estimate.reason.contains("47 rows"),
        "{}",
        estimate.reason
    );

    let mut too_large = identifier(&[("order", 5_i64.into())]);
    estimates(&mut too_large, &messages);
    let estimate = too_large.estimate(stamp(300));
    assert!(
        !estimate.valid && estimate.reason.contains("excitation"),
        "{}",
        estimate.reason
    );

    let mut still = identifier(&[]);
    let mut state = VehicleState::default();
    let mut motion = PlaneMotion {
        dive_planes: vec![0.1, 0.1],
        ..PlaneMotion::default()
    };
    for tick in 0..200 {
        (state.header.stamp, motion.header.stamp) = (stamp(tick), stamp(tick));
        feed(&mut still, &Message::State(state.clone()));
        feed(&mut still, &Message::Motion(motion.clone()));
    }
    let estimate = still.estimate(stamp(200));
    assert_eq!(estimate.reason, "the input has not moved");
    assert_eq!(planesman_msgs::Message::first_non_finite(&estimate), None);
}

#[test]
fn a_held_input_needs_no_moments() {
    // A number, not a list: the angle at the stamp, taken as held over the tick.
    let mut identifier = identifier(&[
        ("input", Value::from("state:dive_planes")),
        ("order", 2_i64.into()),
    ]);
    estimates(&mut identifier, &in_order(300));
    let estimate = identifier.estimate(stamp(300));
    assert!(estimate.valid, "{}", estimate.reason);
    assert!(estimate.c.is_empty());
    assert_eq!(estimate.covariance.len(), 16);
}

#[test]
fn what_is_not_finite_or_not_there_is_refused_and_changes_nothing() {
    let messages = in_order(100);
    let mut identifier = identifier(&[]);
    for message in &messages {
        feed(&mut identifier, message);
    }
    let before = identifier.estimate(stamp(0));
    let bad = VehicleState {
        pitch_rate: f64::NAN,
        ..VehicleState::default()
    };
    let refusal = identifier.on("state", stamp(100), &bad).unwrap_err();
    assert!(refusal.contains("state:pitch_rate"), "{refusal}");
    let empty = PlaneMotion::default();
    assert!(identifier.on("plane_motion", stamp(100), &empty).is_err());
    assert!(
        identifier
            .on("/auv/odom", stamp(100), &bad)
            .unwrap()
            .is_empty()
    );
    assert_eq!(identifier.estimate(stamp(0)), before);
}

#[test]
fn forgetting_changes_in_place_and_the_order_begins_anew() {
    let with = |changes: &[(&str, Value)]| {
        Values::defaults(declarations())
            .with(
                changes
                    .iter()
                    .map(|(name, value)| ((*name).to_owned(), value.clone())),
            )
            .unwrap()
    };
    let mut identifier = identifier(&[]);
    for message in &in_order(100) {
        feed(&mut identifier, message);
    }
    identifier
        .set_values(&with(&[("forgetting", 0.99.into())]))
        .unwrap();
    assert_eq!(identifier.estimate(stamp(0)).samples, 97);
    identifier
        .set_values(&with(&[("order", 2_i64.into())]))
        .unwrap();
    assert_eq!(identifier.estimate(stamp(0)).samples, 0);
    assert!(
        identifier
            .set_values(&with(&[("input", "none".into())]))
            .is_err()
    );
    assert_eq!(identifier.config().shape.order, 2);
}
