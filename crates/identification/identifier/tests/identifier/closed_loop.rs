//! The identifier on the loop's own messages: a vehicle with heave, pitch rate and pitch under
//! depth control, its planes moved in quanta within each tick.
//!
//! The vehicle is the dimensional form of programs T2-T5 (Brunner, NPS thesis, 1988, App. A
//! and Table 1) at U = 1 ft/s, in slug, ft and s:
//! ```text
//! 1.6098 w' =  0.0627 delta - 0.8541 w + 0.3016 q
//! 0.6033 q' = -0.2832 delta + 0.1354 w - 0.7182 q - 0.16333 sin theta
//! ```

use planesman_identification::{Input, RecursiveLeastSquares, Shape, noise, rows};
use planesman_identifier::{Change, Identifier, IdentifierParameters, Scheduled};
use planesman_linear::{Complex, ComplexFunctions as _, DMatrix, StateSpace};
use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, PlaneMotion, VehicleState};
use planesman_parameters::{Parameters as _, Value};
use planesman_signals::WINDOW;

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
        (-0.2832 * planes + 0.1354 * w - 0.7182 * q - 0.16333 * libm::sin(pitch)) / 0.6033,
        q,
        w * libm::cos(pitch) - libm::sin(pitch),
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
    let parameters = IdentifierParameters::default().with(changes).unwrap();
    Identifier::new(&parameters).unwrap()
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

/// The estimates as they would be had time never gone back.
fn without_restarts(mut estimates: Vec<ModelEstimate>) -> Vec<ModelEstimate> {
    for estimate in &mut estimates {
        estimate.restarts = 0;
    }
    estimates
}

/// Distance from the true slowest pole, as a share of its magnitude.
fn miss(identifier: &Identifier) -> f64 {
    let slowest = true_poles()[0];
    (identifier.model().dominant_pole().unwrap() - slowest).modulus() / slowest.modulus()
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
        last.has_steady_state_gain && last.steady_state_gain.abs() < 0.01,
        "{}",
        last.steady_state_gain
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

/// A dive of 300 ticks after which the vehicle is put back to its initial state, time going on, and dives again for a minute.
fn dive_with_a_reset(flagged: bool) -> Vec<Message> {
    let first = dive(300, 0.05);
    let mut second = dive(1200, 0.05);
    for (tick, (state, motion)) in (300..).zip(&mut second) {
        state.header.stamp = stamp(tick);
        motion.header.stamp = stamp(tick);
    }
    if flagged {
        second[0].0.planes_source = VehicleState::PLANES_RESET;
    }
    let both = first.into_iter().chain(second);
    both.flat_map(|(state, motion)| [Message::State(state), Message::Motion(motion)])
        .collect()
}

#[test]
fn a_vehicle_that_is_reset_costs_only_the_rows_that_the_jump_touches() {
    let mut told = identifier(&[]);
    estimates(&mut told, &dive_with_a_reset(true));
    let last = told.estimate(stamp(1500));
    assert_eq!(last.samples, 1500 - 2 * 3);
    assert!(last.valid && miss(&told) < 0.10, "{}", miss(&told));
    // The jump is worth seeing: taken for the vehicle's motion, it is what the model explains.
    let mut untold = identifier(&[]);
    estimates(&mut untold, &dive_with_a_reset(false));
    assert!(miss(&untold) > 0.3, "{}", miss(&untold));
}

#[test]
fn time_going_back_begins_the_identification_anew() {
    let messages = in_order(200);
    let once = estimates(&mut identifier(&[]), &messages);
    let mut twice = identifier(&[]);
    for message in &messages {
        feed(&mut twice, message);
    }
    let again = estimates(&mut twice, &messages);
    assert!(again.iter().all(|estimate| estimate.restarts == 1));
    assert_eq!(without_restarts(again), once);
    assert_eq!(twice.pairs()[0].account().restarts, 1);
    let mut reset = identifier(&[]);
    for message in &messages {
        feed(&mut reset, message);
    }
    let answers = reset.change(Change::Reset);
    assert_eq!((answers.len(), answers[0].samples), (1, 0));
    assert_eq!(reset.estimate(stamp(0)).samples, 0);
    // The record from its beginning is time going back as well.
    assert_eq!(without_restarts(estimates(&mut reset, &messages)), once);
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
    let refusal = identifier
        .on("state", stamp(100), &bad)
        .unwrap_err()
        .to_string();
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
    let with = |changes: &[(&str, Value)]| IdentifierParameters::default().with(changes).unwrap();
    let mut identifier = identifier(&[]);
    for message in &in_order(100) {
        feed(&mut identifier, message);
    }
    identifier
        .set_parameters(&with(&[("forgetting", 0.99.into())]))
        .unwrap();
    assert_eq!(identifier.estimate(stamp(0)).samples, 97);
    identifier
        .set_parameters(&with(&[("order", 2_i64.into())]))
        .unwrap();
    assert_eq!(identifier.estimate(stamp(0)).samples, 0);
    assert!(
        identifier
            .set_parameters(&with(&[("input", "none".into())]))
            .is_err()
    );
    assert_eq!(identifier.config().structure.poles, 2);
}

#[test]
fn by_default_it_is_the_square_root_recursion_on_whole_histories_bit_for_bit() {
    let record = dive(600, 0.05);
    let inputs: Vec<Input> = record
        .iter()
        .map(|(_, motion)| Input::through(&motion.dive_planes).unwrap())
        .collect();
    let outputs: Vec<f64> = record.iter().map(|(state, _)| state.pitch_rate).collect();
    let shape = Shape {
        order: 3,
        moment: true,
        bias: false,
    };
    let mut rls = RecursiveLeastSquares::new(9, 1.0, 1e18).unwrap();
    for (row, output) in rows(shape, &inputs, &outputs) {
        rls.update(&row, output);
    }
    let mut identifier = identifier(&[]);
    estimates(&mut identifier, &in_order(600));
    let estimate = identifier.estimate(stamp(0));
    let found = [estimate.a, estimate.b, estimate.c].concat();
    assert_eq!(found, rls.parameters().as_slice());
    let covariance = rls.unit_covariance() * rls.noise_variance().unwrap();
    assert_eq!(estimate.covariance, covariance.as_slice());
}

const VEHICLE: [&str; 3] = ["K/J", "B/J", "M_theta/J"];
/// In SI, of the vehicle's dimensional form.
const TRUTH: [f64; 3] = [-0.2832 / 0.6033, 0.7182 / 0.6033, 0.16333 / 0.6033];

#[test]
fn estimators_with_a_model_of_noise_or_vehicle_find_the_dominant_pole_of_the_dive() {
    for (estimator, within) in [
        ("extended_least_squares", 0.10),
        ("recursive_prediction_error", 0.05),
        ("kalman", 0.02),
    ] {
        let mut identifier = identifier(&[("estimator", estimator.into())]);
        let published = estimates(&mut identifier, &in_order(1200));
        let last = published.last().unwrap();
        assert!(last.valid, "{estimator}: {}", last.reason);
        assert_eq!(last.estimator, estimator);
        let miss = miss(&identifier);
        assert!(miss < within, "{estimator}: {miss}");
        assert!(last.fit > 99.0, "{estimator}: {}", last.fit);
        assert_eq!(last.poles_re.len(), 3);
        let width = last.a.len() + last.b.len() + last.c.len();
        let with_bias = width + usize::from(estimator == "kalman");
        assert_eq!(last.covariance.len(), with_bias * with_bias, "{estimator}");
    }
}

#[test]
fn where_least_squares_is_led_astray_by_the_sensor_output_error_is_not_and_its_fit_tells() {
    // y = 0.5 y + u, seen through white noise.
    let found = |estimator: &str| {
        let mut identifier = identifier(&[
            ("estimator", estimator.into()),
            ("input", "state:dive_planes".into()),
            ("order", 1_i64.into()),
        ]);
        let (inputs, noise) = (noise(1, 4000), noise(2, 4000));
        let mut y = 0.0;
        for k in 0..4000 {
            let mut state = VehicleState {
                dive_planes: inputs[k],
                pitch_rate: y + 0.5 * noise[k],
                ..VehicleState::default()
            };
            state.header.stamp = stamp(k as i64);
            feed(&mut identifier, &Message::State(state));
            y = 0.5 * y + inputs[k];
        }
        let estimate = identifier.estimate(stamp(0));
        assert!(estimate.valid, "{}", estimate.reason);
        (estimate.a[0] + 0.5, estimate.fit)
    };
    let (off, _) = found("recursive_least_squares");
    assert!(off > 0.05, "{off}");
    let (off, fit) = found("recursive_output_error");
    assert!(off.abs() < 0.02, "{off}");
    // Of a spread of 4/3 + 1/4 the noise leaves a fourth.
    assert!((55.0..65.0).contains(&fit), "{fit}");
}

#[test]
fn the_kalman_filter_tells_the_vehicles_own_coefficients() {
    let begun_off = [
        ("estimator", "kalman".into()),
        ("kalman.plane", Value::from(-0.3)),
        ("kalman.damping", Value::from(0.8)),
    ];
    let mut identifier = identifier(&begun_off);
    assert!(
        identifier.estimate(stamp(0)).reason.contains("are needed"),
        "{:?}",
        identifier.estimate(stamp(0))
    );
    let last = estimates(&mut identifier, &in_order(1200)).pop().unwrap();
    assert_eq!(last.physical_names[..3], VEHICLE);
    for (i, truth) in TRUTH.iter().enumerate() {
        let (found, deviation) = (last.physical_values[i], last.physical_deviations[i]);
        assert!((found / truth - 1.0).abs() < 0.05, "{last:?}");
        assert!(deviation > 0.0 && deviation < 0.2, "{last:?}");
    }
    // A zero at z = 1: restoring brings the pitch rate back to zero.
    assert!(
        last.steady_state_gain.abs() < 1e-6,
        "{}",
        last.steady_state_gain
    );
}

#[test]
fn a_zero_known_to_be_at_one_leaves_no_steady_state_gain() {
    let mut identifier = identifier(&[("zeros_at_one", 1_i64.into())]);
    let last = estimates(&mut identifier, &in_order(600)).pop().unwrap();
    assert!(last.valid && miss(&identifier) < 0.10, "{}", last.reason);
    assert!(
        last.steady_state_gain.abs() < 1e-9,
        "{}",
        last.steady_state_gain
    );
    assert_eq!((last.a.len(), last.b.len(), last.c.len()), (3, 3, 3));
    assert_eq!(last.covariance.len(), 81);
}

#[test]
fn an_integral_is_learnt_as_one_and_a_gap_ends_it() {
    let integrated = [
        ("output", Value::from("state:pitch")),
        ("break_on", Value::from("")),
        ("order", 4_i64.into()),
        ("integrators", 1_i64.into()),
    ];
    let mut identifier = identifier(&integrated);
    let messages = in_order(600);
    for message in &messages[..800] {
        feed(&mut identifier, message);
    }
    let estimate = identifier.estimate(stamp(0));
    assert!(estimate.valid, "{}", estimate.reason);
    assert!((estimate.poles_re[0] - 1.0).abs() < 1e-9 && !estimate.has_steady_state_gain);
    for message in &messages[900..] {
        feed(&mut identifier, message);
    }
    assert!(identifier.estimate(stamp(0)).samples < 150);
}

#[test]
fn a_frozen_model_predicts_and_publishes_and_learns_nothing() {
    let messages = in_order(600);
    for estimator in [
        "recursive_least_squares",
        "recursive_prediction_error",
        "kalman",
    ] {
        let mut identifier = identifier(&[("estimator", estimator.into())]);
        let mut live: Vec<ModelEstimate> = Vec::new();
        for message in &messages[..600] {
            live.extend(feed(&mut identifier, message));
        }
        let answers = identifier.change(Change::Freeze(true));
        assert!(answers[0].frozen, "{estimator}");
        assert_eq!(identifier.change(Change::Freeze(true)), vec![]);
        live.extend(answers.clone());
        let mut frozen = Vec::new();
        for message in &messages[600..900] {
            frozen.extend(feed(&mut identifier, message));
        }
        assert_eq!(frozen.len(), 15, "{estimator}");
        for estimate in &frozen {
            assert!(estimate.frozen);
            assert_eq!(estimate.a, answers[0].a, "{estimator}");
            assert_eq!(estimate.samples, answers[0].samples);
            assert_eq!(estimate.covariance, answers[0].covariance);
        }
        assert!(frozen.last().unwrap().fit > 50.0, "{estimator}");
        // Time going back leaves it what it has learnt.
        for message in &messages[..100] {
            feed(&mut identifier, message);
        }
        assert_eq!(identifier.estimate(stamp(0)).a, answers[0].a);
        assert_eq!(identifier.estimate(stamp(0)).restarts, 1);
    }
}

#[test]
fn what_was_frozen_and_reset_is_so_again_in_its_time() {
    let messages = in_order(600);
    let mut live = identifier(&[]);
    let mut published = Vec::new();
    let mut scheduled = Vec::new();
    for (k, message) in messages.iter().enumerate() {
        let change = match k {
            401 => Some(Change::Freeze(true)),
            600 => Some(Change::Freeze(false)),
            801 => Some(Change::Reset),
            _ => None,
        };
        if let Some(change) = change {
            let answers = live.change(change);
            scheduled.push(Scheduled {
                restarts: 0,
                stamp: answers[0].header.stamp.nanos(),
                change,
            });
            published.extend(answers);
        }
        published.extend(feed(&mut live, message));
    }
    published.extend(live.finish());
    // In another order of arrival.
    let mut again = identifier(&[]);
    for scheduled in scheduled {
        again.schedule("model", scheduled);
    }
    let mut other_order = messages;
    for block in other_order.chunks_mut(14) {
        block.reverse();
    }
    assert_eq!(estimates(&mut again, &other_order), published);
}

/// Two outputs of one input, one of them by two estimators.
const PAIRS: [&str; 3] = [
    "heave: plane_motion:dive_planes -> state:heave",
    "filtered: plane_motion:dive_planes -> state:pitch_rate estimator=kalman publish_rate=1.0",
    "held: state:dive_planes -> state:pitch_rate order=2",
];

#[test]
fn several_pairs_are_learnt_side_by_side_as_each_would_be_alone() {
    let messages = in_order(400);
    let pairs: &[&str] = &PAIRS;
    let mut together = identifier(&[("pairs", pairs.into())]);
    let all = estimates(&mut together, &messages);
    let of = |name: &str| -> Vec<ModelEstimate> {
        let mut of = all.clone();
        of.retain(|estimate| estimate.name == name);
        for estimate in &mut of {
            estimate.name = "model".to_owned();
        }
        of
    };
    assert_eq!(of("model"), estimates(&mut identifier(&[]), &messages));
    for (name, alone) in [
        ("heave", vec![("output", Value::from("state:heave"))]),
        (
            "filtered",
            vec![("estimator", "kalman".into()), ("publish_rate", 1.0.into())],
        ),
        (
            "held",
            vec![
                ("input", "state:dive_planes".into()),
                ("order", 2_i64.into()),
            ],
        ),
    ] {
        assert_eq!(of(name), estimates(&mut identifier(&alone), &messages));
    }
    assert_eq!(of("filtered").len(), 19);
    assert_eq!(together.pair("").unwrap().name(), "model");
    assert_eq!(together.pair("held").unwrap().config().structure.poles, 2);
    assert!(together.pair("roll").is_none());
}

#[test]
fn pairs_that_are_none_are_refused_with_the_form() {
    for (text, reason) in [
        ("plane_motion:dive_planes -> state:heave", "it has no name"),
        ("heave: plane_motion:dive_planes state:heave", "'->'"),
        ("heave: plane_motion:dive_planes -> ", "no output"),
        (
            "a b: plane_motion:dive_planes -> state:heave",
            "contains a space",
        ),
        (
            "model: plane_motion:dive_planes -> state:heave",
            "that name",
        ),
        (
            "heave: plane_motion:dive_planes -> state:heave fast",
            "'fast'",
        ),
        (
            "heave: plane_motion:dive_planes -> state:heave order=99",
            "order",
        ),
        (
            "heave: plane_motion:dive_planes -> state:heave speed=1",
            "declared",
        ),
        (
            "heave: plane_motion:dive_planes -> state:heave answer=true",
            "belongs to the node",
        ),
        ("heave: dive_planes -> state:heave", "TOPIC:FIELD"),
        ("heave: state:heave -> state:heave", "also the input"),
    ] {
        let pairs: &[&str] = &[text];
        let parameters = IdentifierParameters::default()
            .with(&[("pairs", pairs.into())])
            .unwrap();
        let refusal = Identifier::new(&parameters).unwrap_err().to_string();
        assert!(refusal.contains(reason), "{text}: {refusal}");
    }
}

#[test]
fn a_publisher_that_restarts_in_another_phase_is_followed_after_a_gap() {
    let later = |message: &Message| {
        let mut message = message.clone();
        let header = match &mut message {
            Message::State(state) => &mut state.header,
            Message::Motion(motion) => &mut motion.header,
        };
        header.stamp = Time::from_nanos(header.stamp.nanos() + TICK / 3);
        message
    };
    let messages: Vec<Message> = in_order(600)
        .iter()
        .map(|message| match message.tick() {
            ..300 => message.clone(),
            _ => later(message),
        })
        .collect();
    let mut identifier = identifier(&[]);
    estimates(&mut identifier, &messages);
    let last = identifier.estimate(stamp(600));
    assert!(last.samples > 600 - 2 * WINDOW as u64, "{}", last.samples);
    assert!(last.valid && miss(&identifier) < 0.10);
    let account = identifier.pairs()[0].account();
    assert_eq!((account.gaps, account.restarts), (1, 0));
    assert!(account.left_out >= 2 * (WINDOW as u64 - 1));
}

#[test]
fn late_repeated_and_silent_messages_are_accounted_for() {
    let messages = in_order(300);
    let mut identifier = identifier(&[]);
    for message in &messages {
        feed(&mut identifier, message);
        feed(&mut identifier, message);
    }
    let before = identifier.estimate(stamp(0));
    assert_eq!(identifier.pairs()[0].account().left_out, 600);
    // One straggler is no restart.
    feed(&mut identifier, &messages[10]);
    assert_eq!(identifier.pairs()[0].account().restarts, 0);
    assert_eq!(identifier.estimate(stamp(0)), before);
    assert_eq!(identifier.pairs()[0].trouble(), None);
    // The actuator stops; the last motion it answered leads to one more sample.
    for message in &in_order(400)[600..] {
        if matches!(message, Message::State(_)) {
            feed(&mut identifier, message);
        }
    }
    let silence = identifier.pairs()[0].trouble().unwrap();
    assert!(
        silence.contains("no messages of plane_motion:dive_planes for 5.0 s"),
        "{silence}"
    );
    assert_eq!(identifier.estimate(stamp(0)).samples, before.samples + 1);
}

#[test]
fn an_input_that_is_never_stamped_when_the_output_is_is_said_to_be_so() {
    let mut identifier = identifier(&[]);
    for (state, mut motion) in dive(40, 0.05) {
        motion.header.stamp = Time::from_nanos(motion.header.stamp.nanos() + TICK / 2);
        feed(&mut identifier, &Message::State(state));
        feed(&mut identifier, &Message::Motion(motion));
    }
    assert_eq!(identifier.estimate(stamp(0)).samples, 0);
    let trouble = identifier.pairs()[0].trouble().unwrap();
    assert!(
        trouble
            .contains("plane_motion:dive_planes has no sample with the stamp of state:pitch_rate"),
        "{trouble}"
    );
}

#[test]
fn what_changes_while_it_learns_and_what_begins_anew_is_as_described() {
    let samples = |changes: &[(&str, Value)]| {
        let mut identifier = identifier(&[]);
        for message in &in_order(100) {
            feed(&mut identifier, message);
        }
        let parameters = IdentifierParameters::default().with(changes).unwrap();
        identifier.set_parameters(&parameters).unwrap();
        identifier.estimate(stamp(0)).samples
    };
    for declaration in IdentifierParameters::declarations() {
        if declaration.read_only {
            continue;
        }
        let other: Value = match (&declaration.default, declaration.choices) {
            (Value::Bool(on), _) => (!on).into(),
            (Value::Integer(i), _) => (i + 1).into(),
            (Value::Double(_), _) => {
                let (low, high) = declaration.range.unwrap();
                let middle = 0.5 * (low.max(1e-3) + high.min(1.0));
                middle.into()
            }
            (Value::String(_), choices) => (*choices.last().unwrap()).into(),
            (other, _) => panic!("{other:?}"),
        };
        let name = declaration.name.as_str();
        // The order leaves room for what is known of it.
        let anew = declaration.description.contains("restarts the estimate");
        let kept = samples(&[(name, other)]) == 97;
        assert_eq!(kept, !anew, "{name}");
    }
}

#[test]
fn an_estimate_can_be_valid_after_as_many_samples_as_are_asked_for() {
    let messages = in_order(200);
    let at_sample = |min_samples: i64| {
        let mut identifier = identifier(&[
            ("min_samples", min_samples.into()),
            ("publish_rate", Value::Double(20.0)),
        ]);
        let published = estimates(&mut identifier, &messages);
        published.iter().find(|e| e.valid).expect("valid").samples
    };
    assert_eq!(at_sample(150), 150);
    assert!(at_sample(60) < 150);
}

#[test]
fn with_variable_forgetting_more_information_is_a_longer_memory() {
    let messages = in_order(600);
    // The parameters' covariance over the noise variance: the longer the memory, the smaller.
    let covariance = |information: f64| {
        let mut identifier = identifier(&[
            ("forgetting_kind", Value::from("variable")),
            ("forgetting", Value::Double(0.9)),
            ("forgetting_information", Value::Double(information)),
        ]);
        estimates(&mut identifier, &messages);
        let estimate = identifier.estimate(stamp(600));
        estimate.covariance[0] / estimate.noise_variance
    };
    let (short, long) = (covariance(1e-14), covariance(1.0));
    assert!(long < 0.5 * short, "{long} {short}");
}

#[test]
fn the_planes_heave_force_is_part_of_what_the_kalman_filter_knows() {
    let messages = in_order(600);
    // K/J; a heave force that is not there is taken from the pitch moment.
    let miss = |from_plane: f64| {
        let mut identifier = identifier(&[
            ("estimator", Value::from("kalman")),
            ("kalman.heave.from_plane", Value::Double(from_plane)),
        ]);
        estimates(&mut identifier, &messages);
        (identifier.estimate(stamp(600)).physical_values[0] - TRUTH[0]).abs()
    };
    assert!(miss(0.0119) < miss(0.5), "{} {}", miss(0.0119), miss(0.5));
}
