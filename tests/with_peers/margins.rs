//! The margins that `planesman design analyse` prints, against flights of the loop with its gain below and above the gain margin, and
//! against an independent computation.
//!
//! Where `.venv` is absent the last test passes, saying what it skipped (tests/README.md).

use crate::foreign::peers;
use peers::program;
use planesman_control::design::dive_loop::Memory;
use planesman_control::gains::LoopGains;
use planesman_control::{Controller, ControllerParameters};
use planesman_hydraulics::{Actuator, ActuatorParameters, Model, actuator_file, linearised};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_plant::{Plant, PlantParameters};
use planesman_show::design::{Body, Subject, default_gains};
use planesman_units::{DEGREE, FOOT};

/// Ticks with the gains as they are, until the vehicle is in trim, and then with the loop's gain changed.
const TRIMMED: i64 = 1600;
const CHANGED: i64 = 1200;
/// Ticks at the end, over which the command's travel is read.
const OBSERVED: usize = 100;
const TICK: f64 = 0.05;
const TICK_NANOS: i64 = 50_000_000;
/// m; the flights are level.
const DEPTH: f64 = 20.0;

/// A vehicle that dives with the depth controller, at a speed (m/s), with its gains.
struct Case {
    vehicle: &'static str,
    speed: f64,
    gains: LoopGains,
    memory: Memory,
}

/// Every built-in vehicle, the gains of `remus_100` those of its scenario; and integrals and a filter.
fn cases() -> [Case; 5] {
    let case = |vehicle, speed, gains| Case {
        vehicle,
        speed,
        gains,
        memory: Memory::default(),
    };
    let remus = LoopGains {
        depth_p: 0.4,
        depth_d: 0.5,
        pitch_p: 4.0,
        pitch_rate: 2.0,
    };
    [
        case("brunner", FOOT, default_gains()),
        case("brunner", 3.0 * FOOT, default_gains()),
        case("brunner_as_printed", 3.0 * FOOT, default_gains()),
        case("remus_100", 1.54, remus),
        Case {
            memory: Memory {
                depth_i: 0.02,
                pitch_i: 0.1,
                derivative_filter: 0.3,
            },
            ..case("brunner", 3.0 * FOOT, default_gains())
        },
    ]
}

/// As the command line of `planesman design` names them.
fn subject(vehicle: &str, actuator: &str) -> Subject {
    Subject {
        body: Body::vehicle(vehicle),
        actuator: actuator.to_owned(),
        rate: 1.0 / TICK,
        ..Subject::default()
    }
}

impl Case {
    /// By which factor the gain may grow.
    fn margin(&self, actuator: &str) -> f64 {
        let subject = subject(self.vehicle, actuator);
        let drive = subject.drive().unwrap();
        let dive_loop = subject
            .dive_loop(&drive, (self.gains, self.memory), self.speed)
            .unwrap();
        let above = dive_loop.margins().unwrap().gain_limits().0;
        above.unwrap().factor
    }

    fn controller(&self, factor: f64, depth: f64) -> ControllerParameters {
        let mut parameters = ControllerParameters {
            depth_setpoint: depth,
            ..ControllerParameters::default()
        };
        parameters.depth.p = self.gains.depth_p;
        parameters.depth.d = self.gains.depth_d;
        parameters.pitch.p = self.gains.pitch_p * factor;
        parameters.pitch.rate = self.gains.pitch_rate * factor;
        parameters.depth.i = self.memory.depth_i;
        parameters.depth.derivative_filter = self.memory.derivative_filter;
        parameters.pitch.i = self.memory.pitch_i * factor;
        parameters
    }

    /// Level flight, in which the loop's gain is multiplied by `factor` and the command moved by `disturbance`, rad, at one instant.
    /// The travel of the plane command at the end, rad.
    fn travel(&self, actuator: &str, factor: f64, disturbance: f64) -> f64 {
        let mut plant = Plant::new(&PlantParameters {
            vehicle: self.vehicle.to_owned(),
            speed: self.speed,
            initial_depth: DEPTH,
            ..PlantParameters::default()
        })
        .unwrap();
        let mut planes = ActuatorParameters::default();
        match actuator {
            "ideal" => planes.model = Model::Ideal,
            "first_order" => planes.model = Model::FirstOrder,
            name => planes.actuator = name.to_owned(),
        }
        let mut planes = Actuator::new(&planes, TICK_NANOS).unwrap();
        let mut controller = Controller::new(&self.controller(1.0, DEPTH)).unwrap();
        let mut commands = Vec::new();
        for k in 0..TRIMMED + CHANGED {
            let state = plant.state(Time::from_nanos(k * TICK_NANOS));
            if k == TRIMMED {
                // The setpoint at which the new gains ask for the last command, and the disturbance.
                let g = &self.gains;
                let last: f64 = *commands.last().unwrap();
                let asked = (last + disturbance) / factor
                    - g.pitch_p * (state.pitch - g.depth_d * state.depth_rate)
                    - g.pitch_rate * state.pitch_rate;
                let depth = state.depth + asked / (g.pitch_p * g.depth_p);
                controller
                    .set_parameters(&self.controller(factor, depth))
                    .unwrap();
            }
            let (command, _) = controller.on_state(&state).unwrap();
            let output = planes.on_command(&command).unwrap();
            plant.advance(Some(&output.motion)).unwrap();
            commands.push(command.dive_planes);
        }
        let end = &commands[commands.len() - OBSERVED..];
        let (low, high) = end.iter().fold((f64::MAX, f64::MIN), |(low, high), u| {
            (low.min(*u), high.max(*u))
        });
        high - low
    }
}

/// The travel at the end with the loop's gain at 0.9 and at 1.1 times the margin, rad.
fn about_the_margin(case: &Case, actuator: &str, disturbance: f64) -> [f64; 2] {
    let margin = case.margin(actuator);
    [0.9, 1.1].map(|share| case.travel(actuator, share * margin, disturbance))
}

#[test]
fn ideal_planes_and_those_of_a_lag_come_to_rest_below_the_gain_margin_and_swing_above_it() {
    let disturbance = 1e-3 * DEGREE;
    for case in cases() {
        for actuator in ["ideal", "first_order"] {
            let [below, above] = about_the_margin(&case, actuator, disturbance);
            let flown = format!("{} at {} m/s behind {actuator}", case.vehicle, case.speed);
            assert!(below < 1e-3 * disturbance, "{flown}: {below} rad");
            assert!(above > 1e3 * disturbance, "{flown}: {above} rad");
        }
    }
}

/// The pitch of `remus_100` is unstable by itself: with too little gain it leaves level flight.
#[test]
fn an_unstable_vehicle_needs_the_gain_that_its_lower_gain_margin_says() {
    let [.., case, _] = cases();
    let subject = subject(case.vehicle, "ideal");
    let drive = subject.drive().unwrap();
    let law = (case.gains, case.memory);
    let dive_loop = subject.dive_loop(&drive, law, case.speed).unwrap();
    let below = dive_loop.margins().unwrap().gain_limits().1.unwrap();
    let disturbance = 1e-3 * DEGREE;
    let [lost, held] =
        [0.9, 1.1].map(|share| case.travel("ideal", share * below.factor, disturbance));
    assert!(held < disturbance, "{held} rad");
    assert!(lost > 10.0 * disturbance, "{lost} rad");
}

/// At rest there is its limit cycle of a quantum or two, at every gain.
#[test]
fn moved_by_a_ticks_slew_the_digital_hydraulic_actuator_keeps_to_its_quantum_below_the_gain_margin_and_swings_above_it()
 {
    for case in cases() {
        for actuator in ["auv", "auv_two_speed", "table_3_1", "table_4_1"] {
            let set = actuator_file::load(actuator).unwrap();
            let quantum = set.plane_quantum();
            let slew = f64::from(linearised::volumes_in_a_tick(&set, TICK)) * quantum;
            let quanta = about_the_margin(&case, actuator, slew).map(|travel| travel / quantum);
            let flown = format!("{} at {} m/s behind {actuator}", case.vehicle, case.speed);
            assert!(quanta[0] < 3.0, "{flown}: {quanta:?} quanta");
            assert!(quanta[1] > 10.0, "{flown}: {quanta:?} quanta");
        }
    }
}

/// The same numbers from the thesis' coefficients, by scipy and python-control.
#[test]
fn the_margins_are_those_of_an_independent_computation() {
    for (feet_per_second, actuator) in [
        (1.0, "ideal"),
        (3.0, "ideal"),
        (3.0, "first_order"),
        (1.0, "auv"),
        (3.0, "auv"),
        (3.0, "table_4_1"),
    ] {
        let subject = subject("brunner", actuator);
        let drive = subject.drive().unwrap();
        let Some(mut peer) = program("sampled_margins.py") else {
            return;
        };
        peer.arg(feet_per_second.to_string());
        if drive.path.lag > 0.0 {
            peer.args(["--lag", &(1.0 / drive.path.lag).to_string()]);
        }
        // How the digital hydraulic actuator moves is its own model's to say.
        let motion = &drive.sampling.as_ref().unwrap().motion;
        peer.args(["--motion", &serde_json::to_string(motion).unwrap()]);
        let printed = peer.output().unwrap();
        let peer: serde_json::Value = serde_json::from_slice(&printed.stdout)
            .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&printed.stderr)));
        let expected = |at: &str| peer.pointer(at).unwrap().as_f64().unwrap();

        let speed = feet_per_second * FOOT;
        let dive_loop = subject
            .dive_loop(&drive, (default_gains(), Memory::default()), speed)
            .unwrap();
        let judged = dive_loop.margins().unwrap();
        let gain = judged.gain_limits().0.unwrap();
        let phase = judged.phase[0];
        for (found, expected, what) in [
            (gain.factor, expected("/gain/0"), "gain margin"),
            (gain.frequency, expected("/gain/1"), "its frequency"),
            (phase.frequency, expected("/phase/0/0"), "gain crossover"),
            (phase.margin, expected("/phase/0/1"), "phase margin"),
            (
                judged.sensitivity.unwrap().value,
                expected("/sensitivity"),
                "sensitivity",
            ),
        ] {
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "{actuator} at {feet_per_second} ft/s, {what}: {found}, not {expected}"
            );
        }
    }
}
