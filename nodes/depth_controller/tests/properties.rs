//! Invariants of the controller under any input: outputs within their limits, no number that is not
//! finite, and no bump when the mode changes.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::LazyLock;

use depth_controller::{Answer, Controller, ControllerParameters, Mode, Quantity, Source};
use planesman_model_file::ModelFile;
use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{ControlState, VehicleState};
use planesman_msgs::sensor_msgs::msg::{FluidPressure, Imu};
use planesman_parameters::{Choice as _, Parameters as _, Value, Values};

const TICK: i64 = 50_000_000;

/// Draws that are the same in every run: a linear congruential sequence (Numerical Recipes).
struct Draws(u32);

impl Draws {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 8
    }

    fn below(&mut self, count: usize) -> usize {
        self.next() as usize % count
    }

    /// In [-1, 1).
    fn unit(&mut self) -> f64 {
        f64::from(self.next()) / f64::from(1 << 23) - 1.0
    }

    fn one_of<T: Clone>(&mut self, choice: &[T]) -> T {
        choice[self.below(choice.len())].clone()
    }

    /// Any finite number: of every magnitude, and the ends of what there is.
    fn finite(&mut self) -> f64 {
        const EXTREMES: [f64; 6] = [f64::MAX, f64::MIN, f64::MIN_POSITIVE, 0.0, -0.0, 1e154];
        match self.below(8) {
            0 => self.one_of(&EXTREMES),
            n => self.unit() * 10_f64.powi(n as i32 * 40 - 160),
        }
    }

    /// A state of any finite numbers, or of a vehicle's.
    fn state(&mut self, tick: i64, any: bool) -> VehicleState {
        let mut draw = |scale: f64| match any {
            true => self.finite(),
            false => scale * self.unit(),
        };
        let mut state = VehicleState {
            distance: draw(100.0),
            depth: draw(5.0),
            depth_rate: draw(0.3),
            roll: draw(1.0),
            roll_rate: draw(1.0),
            pitch: draw(1.0),
            pitch_rate: draw(0.5),
            yaw: draw(3.0),
            yaw_rate: draw(0.5),
            surge: draw(2.0),
            ..VehicleState::default()
        };
        state.header.stamp = Time::from_nanos(tick * TICK);
        state
    }

    /// A change of parameters to anything that their declarations and their rules allow.
    fn change(&mut self, values: &Values) -> Values {
        let declarations = values.declarations();
        let declaration = declarations[self.below(declarations.len())].clone();
        let value = match (&declaration.default, declaration.choices) {
            (Value::String(_), []) => Value::from(model_file()),
            (Value::String(_), choices) => Value::from(self.one_of(choices)),
            (Value::Bool(_), _) => Value::Bool(self.below(2) == 0),
            (Value::Integer(_), _) => Value::Integer(i64::from(self.next())),
            (Value::DoubleArray(_), _) => return values.clone(),
            _ => {
                let (low, high) = declaration.range.unwrap_or((-1.0, 1.0));
                let share = (0.5 + 0.5 * self.unit()).powi(1 + 4 * self.below(3) as i32);
                Value::Double((low + (high - low) * share).clamp(low, high))
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
        let pole = (-b * dt).exp();
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
    assert!(command.rudder.abs() <= p.course.limit);
    assert!(command.thrust.abs() <= p.speed.limit);
    assert!(control.pitch_command.abs() <= p.depth.pitch_limit);
}

#[test]
fn outputs_stay_within_their_limits_for_any_finite_input_and_any_allowed_parameters() {
    for seed in 0..20 {
        let mut draws = Draws(seed);
        let source = draws.one_of(Source::NAMES);
        let mut values = defaults()
            .with([("feedback.source".to_owned(), Value::from(source))])
            .unwrap();
        let mut controller = Controller::new(&read(&values)).unwrap();
        let mut tick = 0;
        for _ in 0..1500 {
            tick += 1 + draws.below(3) as i64;
            match draws.below(12) {
                0..6 => {
                    values = draws.change(&values);
                    controller.set_parameters(&read(&values)).unwrap();
                }
                6 => {
                    let quantity = draws.one_of(&Quantity::ALL);
                    controller.set_setpoint(quantity, draws.finite()).unwrap();
                }
                7 if draws.below(20) == 0 => tick = -1,
                9 if draws.below(20) == 0 => drop(controller.reset_fault()),
                8 if draws.below(20) == 0 => {
                    let silent = controller.on_silence(Time::from_nanos(tick * TICK));
                    assert_within_limits(&silent, &values);
                }
                _ => {}
            }
            let any = draws.below(2) == 0;
            let stamp = Time::from_nanos(tick * TICK);
            if draws.below(3) > 0 {
                let mut imu = Imu::default();
                imu.header.stamp = stamp.clone();
                imu.angular_velocity.y = if any { draws.finite() } else { draws.unit() };
                controller.on_imu(&imu);
            }
            if draws.below(3) > 0 {
                let mut pressure = FluidPressure::default();
                pressure.header.stamp = stamp;
                pressure.fluid_pressure = if any {
                    draws.finite()
                } else {
                    1e5 * (1.1 + 0.1 * draws.unit())
                };
                controller.on_depth_pressure(&pressure);
            }
            let answer = controller.on_state(&draws.state(tick, any)).unwrap();
            assert_within_limits(&answer, &values);
        }
    }
}

#[test]
fn what_is_not_finite_is_refused_and_leaves_no_trace() {
    let mut draws = Draws(1);
    let mut clean = Controller::new(&read(&defaults())).unwrap();
    let mut troubled = clean.clone();
    for tick in 0..300 {
        let good = draws.state(tick, false);
        let bad = draws.one_of(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
        let mut poisoned = good.clone();
        let fields = [
            &mut poisoned.depth,
            &mut poisoned.pitch_rate,
            &mut poisoned.roll,
            &mut poisoned.yaw_rate,
            &mut poisoned.surge,
        ];
        *fields.into_iter().nth(draws.below(5)).unwrap() = bad;
        assert!(troubled.on_state(&poisoned).is_err());
        assert!(
            troubled
                .set_setpoint(draws.one_of(&Quantity::ALL), bad)
                .is_err()
        );
        assert_eq!(troubled.on_state(&good), clean.on_state(&good));
    }
}

/// A vehicle's next state: somewhere near the last one, as one tick allows.
fn drift(draws: &mut Draws, state: &VehicleState) -> VehicleState {
    let mut next = state.clone();
    next.header.stamp = Time::from_nanos(state.header.stamp.nanos() + TICK);
    next.depth += 0.02 * draws.unit();
    next.depth_rate = 0.3 * draws.unit();
    next.pitch += 0.02 * draws.unit();
    next.pitch_rate = 0.3 * draws.unit();
    next
}

#[test]
fn a_change_between_modes_that_hold_something_moves_the_planes_by_rounding_alone() {
    let holding: Vec<&str> = Mode::NAMES
        .iter()
        .copied()
        .filter(|mode| *mode != "off")
        .collect();
    for seed in 0..20 {
        let mut draws = Draws(seed);
        let values = with(
            &defaults(),
            &[
                ("depth_setpoint", Value::Double(3.0 * draws.unit())),
                ("pitch_setpoint", Value::Double(draws.unit())),
                ("depth.i", Value::Double(0.1)),
                ("pitch.i", Value::Double(0.2)),
                ("depth.derivative", Value::from("error")),
                ("mode", Value::from("off")),
            ],
        );
        let mut controller = Controller::new(&read(&values)).unwrap();
        let mut state = draws.state(0, false);
        let mut last = controller.on_state(&state).unwrap().0.dive_planes;
        let mut mode = "off";
        for tick in 1..400 {
            let next = draws.one_of(&holding);
            let changes = tick % 10 == 0 && next != mode;
            if changes {
                mode = next;
                let values = with(&values, &[("mode", Value::from(mode))]);
                controller.set_parameters(&read(&values)).unwrap();
            }
            state = drift(&mut draws, &state);
            let planes = controller.on_state(&state).unwrap().0.dive_planes;
            if changes {
                assert!(
                    (planes - last).abs() < 1e-13,
                    "into {mode}: {last} -> {planes}"
                );
            }
            last = planes;
        }
    }
}

#[test]
fn after_a_change_of_mode_the_transfer_moves_the_planes_no_faster_than_its_time_constant_allows() {
    let mut draws = Draws(3);
    let values = with(&defaults(), &[("mode", Value::from("open_loop"))]);
    let mut controller = Controller::new(&read(&values)).unwrap();
    let mut state = draws.state(0, false);
    state.pitch = 0.3;
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

#[test]
fn a_fault_stays_whatever_happens_until_it_is_reset() {
    for seed in 0..20 {
        let mut draws = Draws(seed);
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
        for tick in 0..1500 {
            if draws.below(10) == 0 {
                values = draws.change(&values);
                controller.set_parameters(&read(&values)).unwrap();
            }
            if draws.below(50) == 0 && controller.reset_fault().is_ok() {
                fault = 0;
            }
            let state = draws.state(tick, false);
            let (command, control) = controller.on_state(&state).unwrap();
            let stays = control.fault == fault || control.fault == ControlState::FAULT_FLOOR;
            assert!(fault == 0 || stays, "{fault} became {}", control.fault);
            if control.fault != 0 {
                let p = read(&values);
                let climb = p.safety.climb_planes;
                let climb = climb.min(p.planes.limit);
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
        assert!(faults > 1, "seed {seed}");
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
    let state = Draws(5).state(0, false);
    assert_eq!(controller.on_state(&state).unwrap().1.depth_setpoint, 0.9);
    controller
        .set_parameters(&read(&with(&shallow, &deep)))
        .unwrap();

    // Whatever is changed after whatever, what is in force is an allowed set.
    let mut draws = Draws(7);
    let mut values = defaults();
    for _ in 0..2000 {
        values = draws.change(&values);
        assert!(controller.set_parameters(&read(&values)).is_ok());
    }
}
