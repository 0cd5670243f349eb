//! Invariants of the controller under any input: outputs within their limits, no number that is not
//! finite, and no bump when the mode changes.

use std::path::Path;
use std::sync::LazyLock;

use planesman_control::{Answer, Controller, ControllerParameters, Mode, Quantity, Source};
use planesman_model_file::ModelFile;
use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{ControlState, VehicleState};
use planesman_msgs::sensor_msgs::msg::{FluidPressure, Imu};
use planesman_parameters::{Choice as _, Parameters as _, Value, Values};
use proptest::collection::vec;
use proptest::option::weighted;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::RngSeed;

const TICK: i64 = 50_000_000;

/// The same cases in every run.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(1988),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Any finite number.
fn finite() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    prop_oneof![
        7 => POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO,
        1 => select(vec![f64::MAX, f64::MIN, 1e154]),
    ]
}

fn unit() -> impl Strategy<Value = f64> {
    -1.0..1.0
}

/// The numbers of a state, to be scaled to a vehicle's or taken as they are.
fn numbers(each: impl Strategy<Value = f64> + 'static) -> BoxedStrategy<[f64; 10]> {
    vec(each, 10)
        .prop_map(|numbers| numbers.try_into().unwrap())
        .boxed()
}

fn state(tick: i64, numbers: [f64; 10]) -> VehicleState {
    let [
        distance,
        depth,
        depth_rate,
        roll,
        roll_rate,
        pitch,
        pitch_rate,
        yaw,
        yaw_rate,
        surge,
    ] = numbers;
    let mut state = VehicleState {
        distance,
        depth,
        depth_rate,
        roll,
        roll_rate,
        pitch,
        pitch_rate,
        yaw,
        yaw_rate,
        surge,
        ..VehicleState::default()
    };
    state.header.stamp = Time::from_nanos(tick * TICK);
    state
}

/// The numbers of a vehicle's state.
fn lawful() -> impl Strategy<Value = [f64; 10]> {
    const SCALES: [f64; 10] = [100.0, 5.0, 0.3, 1.0, 1.0, 1.0, 0.5, 3.0, 0.5, 2.0];
    numbers(unit()).prop_map(|numbers| std::array::from_fn(|k| SCALES[k] * numbers[k]))
}

/// A change of one parameter within its declaration.
#[derive(Clone, Debug)]
struct Change {
    parameter: Index,
    choice: Index,
    /// Of the range, in [0, 1].
    share: f64,
}

fn change() -> impl Strategy<Value = Change> {
    let share = (0.0..1.0_f64, select(vec![1, 5, 9])).prop_map(|(x, power)| x.powi(power));
    (any::<Index>(), any::<Index>(), share).prop_map(|(parameter, choice, share)| Change {
        parameter,
        choice,
        share,
    })
}

impl Change {
    /// The values after the change; unchanged where their rules do not allow it.
    fn applied(&self, values: &Values) -> Values {
        let declaration = self.parameter.get(values.declarations()).clone();
        let value = match (&declaration.default, declaration.choices) {
            (Value::String(_), []) => Value::from(model_file()),
            (Value::String(_), choices) => Value::from(*self.choice.get(choices)),
            (Value::Bool(_), _) => Value::Bool(self.choice.index(2) == 0),
            (Value::Integer(_), _) => Value::Integer(self.choice.index(1 << 24) as i64),
            (Value::DoubleArray(_), _) => return values.clone(),
            _ => {
                let (low, high) = declaration.range.unwrap_or((-1.0, 1.0));
                Value::Double((low + (high - low) * self.share).clamp(low, high))
            }
        };
        // What is fixed at the start stays.
        let Ok(changed) = values.with_live([(declaration.name.clone(), value)]) else {
            return values.clone();
        };
        match Controller::new(&read(&changed)) {
            Ok(_) => changed,
            Err(_) => values.clone(),
        }
    }
}

/// A model file that the controller can trust: pitch as the default schedule has it, `q = -k delta / (s + b)`.
fn model_file() -> &'static str {
    const PATH: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/controller_properties.yaml");
    static WRITTEN: LazyLock<()> = LazyLock::new(|| {
        let gains = ControllerParameters::default().gains;
        let (k, b) = (gains.model.plane, gains.model.damping);
        let (dt, input, output) = (0.05, "plane_motion:dive_planes", "state:pitch_rate");
        let pole = libm::exp(-b * dt);
        let num = vec![-k * (1.0 - pole) / b];
        let file = ModelFile {
            speed: Some(gains.reference_speed),
            ..ModelFile::exact(input, output, dt, num, vec![1.0, -pole])
        };
        file.write(Path::new(PATH)).unwrap();
    });
    LazyLock::force(&WRITTEN);
    PATH
}

fn defaults() -> Values {
    Values::of::<ControllerParameters>()
}

fn read(values: &Values) -> ControllerParameters {
    ControllerParameters::from_values(values).unwrap()
}

fn with(values: &Values, changes: &[(&str, Value)]) -> Values {
    let changes = changes.iter().map(|(n, v)| ((*n).to_owned(), v.clone()));
    values.with_live(changes).unwrap()
}

/// That a command keeps the limits in force, and holds no number that is not finite.
fn assert_within_limits((command, control): &Answer, values: &Values) {
    assert_eq!(command.first_non_finite(), None, "{command:?}");
    assert_eq!(control.first_non_finite(), None, "{control:?}");
    let p = read(values);
    let planes = p.planes.limit * (1.0 + 1e-15);
    let (mean, differential) = (command.dive_planes, command.bow_stern_differential);
    for side in [-1.0, 1.0] {
        let bow = mean + differential + side * command.roll_differential;
        assert!(
            bow.abs() <= planes * (1.0 + 1e-12),
            "bow {bow}: {command:?}"
        );
    }
    assert!((mean - differential).abs() <= planes, "{command:?}");
    assert!(command.roll_differential.abs() <= p.roll.limit);
    assert!(command.rudder.abs() <= p.heading.limit);
    assert!(command.thrust.abs() <= p.speed.limit);
    assert!(control.pitch_command.abs() <= p.depth.pitch_limit);
}

/// What happens between two states.
#[derive(Clone, Debug)]
enum Event {
    Change(Change),
    Setpoint(Quantity, f64),
    BackInTime,
    ResetFault,
    Silence,
    Nothing,
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        120 => change().prop_map(Event::Change),
        20 => (select(&Quantity::ALL[..]), finite()).prop_map(|(of, to)| Event::Setpoint(of, to)),
        1 => Just(Event::BackInTime),
        1 => Just(Event::ResetFault),
        1 => Just(Event::Silence),
        97 => Just(Event::Nothing),
    ]
}

/// An event, the ticks until the next state, and what the sensors say then, if they do.
type Step = (Event, i64, [f64; 10], Option<f64>, Option<f64>);

fn step() -> impl Strategy<Value = Step> {
    let pressure = prop_oneof![finite(), unit().prop_map(|x| 1e5 * (1.1 + 0.1 * x))];
    (
        event(),
        1..4_i64,
        prop_oneof![numbers(finite()), lawful()],
        weighted(0.67, prop_oneof![finite(), unit()]),
        weighted(0.67, pressure),
    )
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn outputs_stay_within_their_limits_for_any_finite_input_and_any_allowed_parameters(
        source in select(Source::NAMES),
        steps in vec(step(), 300),
    ) {
        let mut values = defaults()
            .with([("feedback.source".to_owned(), Value::from(source))])
            .unwrap();
        let mut controller = Controller::new(&read(&values)).unwrap();
        let mut tick = 0;
        for (event, ticks, numbers, gyro, pressure) in steps {
            tick += ticks;
            match event {
                Event::Change(change) => {
                    values = change.applied(&values);
                    controller.set_parameters(&read(&values)).unwrap();
                }
                // Refused or taken, what comes out keeps its limits.
                Event::Setpoint(of, to) => drop(controller.set_setpoint(of, to)),
                Event::BackInTime => tick = -1,
                Event::ResetFault => drop(controller.reset_fault()),
                Event::Silence => {
                    let silent = controller.on_silence(Time::from_nanos(tick * TICK));
                    assert_within_limits(&silent, &values);
                }
                Event::Nothing => {}
            }
            let stamp = Time::from_nanos(tick * TICK);
            if let Some(rate) = gyro {
                let mut imu = Imu::default();
                imu.header.stamp = stamp.clone();
                imu.angular_velocity.y = rate;
                controller.on_imu(&imu);
            }
            if let Some(pressure) = pressure {
                let mut message = FluidPressure::default();
                message.header.stamp = stamp;
                message.fluid_pressure = pressure;
                controller.on_depth_pressure(&message);
            }
            let answer = controller.on_state(&state(tick, numbers)).unwrap();
            assert_within_limits(&answer, &values);
        }
    }

    #[test]
    fn any_finite_state_gives_a_finite_answer_at_high_gains(
        mode in select(Mode::NAMES),
        steps in vec((numbers(finite()), finite()), 300),
    ) {
        let gains = ["depth.p", "depth.d", "pitch.rate"].map(|name| (name, Value::Double(1e3)));
        let values = with(&with(&defaults(), &gains), &[("mode", Value::from(mode))]);
        let mut parameters = read(&values);
        parameters.hover.vehicle = "bluerov2_heavy".to_owned();
        let mut controller = Controller::new(&parameters).unwrap();
        for (tick, (numbers, setpoint)) in (0..).zip(steps) {
            let _ = controller.set_setpoint(Quantity::Depth, setpoint);
            let answer = controller.on_state(&state(tick, numbers)).unwrap();
            assert_within_limits(&answer, &values);
            let thrusters = controller.thrusters().unwrap();
            prop_assert!(thrusters.command.iter().all(|it| (-1.0..=1.0).contains(it)), "{:?}", thrusters);
        }
    }

    #[test]
    fn what_is_not_finite_is_refused_and_leaves_no_trace(
        steps in vec(
            (
                lawful(),
                select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
                0..5_usize,
                select(&Quantity::ALL[..]),
            ),
            10,
        ),
    ) {
        let mut clean = Controller::new(&read(&defaults())).unwrap();
        let mut troubled = clean.clone();
        for (tick, (numbers, bad, field, quantity)) in (0..).zip(steps) {
            let good = state(tick, numbers);
            let mut poisoned = good.clone();
            let fields = [
                &mut poisoned.depth,
                &mut poisoned.pitch_rate,
                &mut poisoned.roll,
                &mut poisoned.yaw_rate,
                &mut poisoned.surge,
            ];
            *fields.into_iter().nth(field).unwrap() = bad;
            assert!(troubled.on_state(&poisoned).is_err());
            assert!(troubled.set_setpoint(quantity, bad).is_err());
            assert_eq!(troubled.on_state(&good), clean.on_state(&good));
        }
    }

    #[test]
    fn a_change_between_modes_that_hold_something_moves_the_planes_by_rounding_alone(
        depth_setpoint in 0.0..6.0,
        pitch_setpoint in unit(),
        start in lawful(),
        modes in vec((select(holding()), vec([unit(), unit(), unit(), unit()], 10)), 1..20),
    ) {
        let values = with(
            &defaults(),
            &[
                ("depth_setpoint", Value::Double(depth_setpoint)),
                ("pitch_setpoint", Value::Double(pitch_setpoint)),
                ("depth.i", Value::Double(0.1)),
                ("pitch.i", Value::Double(0.2)),
                ("depth.derivative", Value::from("error")),
                ("mode", Value::from("off")),
            ],
        );
        let mut controller = Controller::new(&read(&values)).unwrap();
        let mut state = state(0, start);
        let mut last = controller.on_state(&state).unwrap().0.dive_planes;
        let mut mode = "off";
        for (next, drifts) in modes {
            let mut changes = next != mode;
            mode = next;
            let values = with(&values, &[("mode", Value::from(mode))]);
            controller.set_parameters(&read(&values)).unwrap();
            for drift in drifts {
                // Near the last state, as one tick allows.
                let nanos = state.header.stamp.nanos() + TICK;
                state.header.stamp = Time::from_nanos(nanos);
                state.depth += 0.02 * drift[0];
                state.depth_rate = 0.3 * drift[1];
                state.pitch += 0.02 * drift[2];
                state.pitch_rate = 0.3 * drift[3];
                let planes = controller.on_state(&state).unwrap().0.dive_planes;
                if changes {
                    assert!(
                        (planes - last).abs() < 1e-13,
                        "into {mode}: {last} -> {planes}"
                    );
                }
                changes = false;
                last = planes;
            }
        }
    }
}

fn holding() -> Vec<&'static str> {
    let modes = Mode::NAMES.iter().copied();
    modes
        .filter(|mode| !matches!(*mode, "off" | "hover"))
        .collect()
}

#[test]
fn after_a_change_of_mode_the_transfer_moves_the_planes_no_faster_than_its_time_constant_allows() {
    let values = with(&defaults(), &[("mode", Value::from("open_loop"))]);
    let mut controller = Controller::new(&read(&values)).unwrap();
    let mut state = state(0, [0.0; 10]);
    state.pitch = 0.3;
    state.pitch_rate = 0.5;
    state.depth = 5.0;
    controller.on_state(&state).unwrap();
    let pitch = with(&values, &[("mode", Value::from("pitch"))]);
    controller.set_parameters(&read(&pitch)).unwrap();
    let mut last: Option<f64> = None;
    for tick in 1..200 {
        state.header.stamp = Time::from_nanos(tick * TICK);
        let (command, control) = controller.on_state(&state).unwrap();
        // Nothing else moves: the planes go where the law wants them as the transfer fades.
        if let Some(last) = last {
            let step = (command.dive_planes - last).abs();
            assert!(step <= 0.05 / 1.0 * (0.7 * 0.3 + 2.0 * 0.5), "{step}");
        }
        last = Some(command.dive_planes);
        if tick == 199 {
            assert!(control.transfer.abs() < 1e-4);
        }
    }
}

proptest! {
    #![proptest_config(cases(20))]

    #[test]
    fn a_fault_stays_whatever_happens_until_it_is_reset(
        steps in vec((weighted(0.1, change()), weighted(0.02, Just(())), lawful()), 1500),
    ) {
        let mut values = with(
            &defaults(),
            &[
                ("depth.max", Value::Double(4.0)),
                ("safety.floor", Value::Double(4.0)),
                ("safety.pitch", Value::Double(0.9)),
            ],
        );
        let mut controller = Controller::new(&read(&values)).unwrap();
        let (mut fault, mut faults) = (0, 0);
        for (tick, (change, reset, numbers)) in (0..).zip(steps) {
            if let Some(change) = change {
                values = change.applied(&values);
                controller.set_parameters(&read(&values)).unwrap();
            }
            if reset.is_some() && controller.reset_fault().is_ok() {
                fault = 0;
            }
            let (command, control) = controller.on_state(&state(tick, numbers)).unwrap();
            let stays = control.fault == fault || control.fault == ControlState::FAULT_FLOOR;
            assert!(fault == 0 || stays, "{fault} became {}", control.fault);
            if control.fault != 0 {
                let p = read(&values);
                let climb = p.safety.climb_planes.min(p.planes.limit);
                let bow = command.dive_planes + command.bow_stern_differential;
                assert!(
                    bow == 0.0 || control.climbing && (-climb * (1.0 + 1e-15)..0.0).contains(&bow)
                );
                assert_eq!((command.rudder, command.thrust), (0.0, 0.0));
                assert_eq!(command.roll_differential, 0.0);
            }
            faults += usize::from(fault == 0 && control.fault != 0);
            fault = control.fault;
        }
        assert!(faults > 1);
    }

    #[test]
    fn whatever_is_changed_after_whatever_what_is_in_force_is_an_allowed_set(
        changes in vec(change(), 100),
    ) {
        let mut values = defaults();
        let mut controller = Controller::new(&read(&values)).unwrap();
        for change in changes {
            values = change.applied(&values);
            assert!(controller.set_parameters(&read(&values)).is_ok());
        }
    }
}

#[test]
fn no_pair_of_live_changes_passes_through_a_set_that_is_not_allowed() {
    // Both are allowed sets, but neither change alone leads from one to the other.
    let shallow = with(
        &defaults(),
        &[
            ("depth.max", Value::Double(1.0)),
            ("depth_setpoint", Value::Double(0.9)),
        ],
    );
    let mut controller = Controller::new(&read(&shallow)).unwrap();
    let deep = [
        ("depth_setpoint", Value::Double(3.0)),
        ("depth.max", Value::Double(4.0)),
    ];
    let too_soon = with(&shallow, &deep[..1]);
    let refusal = controller
        .set_parameters(&read(&too_soon))
        .unwrap_err()
        .to_string();
    assert!(
        refusal.contains("depth_setpoint") && refusal.contains("depth.max"),
        "{refusal}"
    );
    let still = state(0, [0.0; 10]);
    assert_eq!(controller.on_state(&still).unwrap().1.depth_setpoint, 0.9);
    controller
        .set_parameters(&read(&with(&shallow, &deep)))
        .unwrap();
}
