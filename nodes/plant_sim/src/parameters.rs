//! The node's parameters: the one place where their defaults and ranges are written.
//!
//! Those of `core` first, then those that only the node reads (`time` and after).

use planesman_parameters::{Declaration, Value, Values};

use crate::sensors::{
    Channel, Sensors,
    adc::Adc,
    conditioning::Conditioning,
    gyro,
    plane_signal::{self, PlaneSignal},
    pressure_cell::{self, DepthPort, PressureCell},
};
use planesman_vehicle::{BRUNNER_SECANT_RATE, BRUNNER_VISCOUS_DAMPING, vehicle_file::BRUNNER};

/// Every parameter of `plant_sim`.
#[must_use]
pub fn declarations() -> Vec<Declaration> {
    [vehicle(), environment(), sensors(), node()].concat()
}

fn vehicle() -> Vec<Declaration> {
    vec![
        Declaration::new(
            "vehicle",
            BRUNNER,
            "The vehicle: 'brunner' (NPS 1988), 'brunner_as_printed' (with the errors of its programs), 'remus_100' (Prestero 2001), or the path of a vehicle file or of an identified model's (sysid fit --model)",
        )
        .read_only(),
        Declaration::new(
            "vehicle_base",
            BRUNNER,
            "The vehicle that an identified model takes geometry, masses, buoyancy and heave from",
        )
        .read_only(),
        Declaration::new(
            "speed",
            0.3048,
            "Forward speed through the water; with propulsion by thrust, at the start and after a reset",
        )
        .unit("m/s")
        .range(0.0, 5.0),
        Declaration::new(
            "propulsion",
            "held",
            "Whether the speed is held, or follows the commanded thrust against the drag",
        )
        .choices(&["held", "thrust"]),
        Declaration::new(
            "restoring",
            "sine",
            "Restoring moment over pitch: hydrostatics, the report's small-angle form, or none",
        )
        .choices(&["sine", "small_angle", "none"]),
        Declaration::new(
            "pitch_damping",
            "coefficient",
            "Of pitch: the vehicle's M'q, or the hull's drag N |q| q, as it is or made linear",
        )
        .choices(&["coefficient", "secant", "tangent", "quadratic"]),
        Declaration::new(
            "pitch_damping_viscous",
            BRUNNER_VISCOUS_DAMPING,
            "N, for the three that need it; the report's plate of 28 by 7 in, 0.4193 ft lbf s^2",
        )
        .unit("N m s^2")
        .range(0.0, 1e4),
        Declaration::new(
            "pitch_damping_rate",
            BRUNNER_SECANT_RATE,
            "Pitch rate at which the secant or the tangent is taken",
        )
        .unit("rad/s")
        .range(0.0, 10.0),
        Declaration::new(
            "heave_moment",
            true,
            "Whether heave velocity turns the vehicle (M_w)",
        ),
        Declaration::new("initial_depth", 0.0, "Depth at the start and after a reset")
            .unit("m")
            .range(0.0, 1000.0),
        Declaration::new(
            "initial_pitch",
            0.0,
            "Pitch at the start and after a reset, positive bow up",
        )
        .unit("rad")
        .range(-std::f64::consts::PI, std::f64::consts::PI),
        Declaration::new(
            "tick",
            0.05,
            "Time between two states, a whole number of steps; the report sampled at 20 Hz",
        )
        .unit("s")
        .range(1e-4, 1.0)
        .read_only(),
        Declaration::new("step", 0.001, "Integration step")
            .unit("s")
            .range(1e-5, 0.1)
            .read_only(),
        Declaration::new(
            "frame_prefix",
            "",
            "Put before odom and base_link, to tell vehicles on one /tf apart: 'auv1/'",
        )
        .read_only(),
    ]
}

fn environment() -> Vec<Declaration> {
    vec![
        Declaration::new(
            "environment.density",
            999.835,
            "Of the water, for pressures; fresh as in the report (1.94 slug/ft^3), sea 1025",
        )
        .unit("kg/m^3")
        .range(900.0, 1200.0),
        Declaration::new(
            "environment.gravity",
            9.81456,
            "Acceleration of gravity; the report's 32.2 ft/s^2",
        )
        .unit("m/s^2")
        .range(9.0, 10.0),
        Declaration::new(
            "environment.atmospheric_pressure",
            101_325.0,
            "Absolute pressure at the surface",
        )
        .unit("Pa")
        .range(0.0, 200_000.0),
        Declaration::new(
            "environment.bottom",
            0.0,
            "Depth of the bottom, 0: there is none; the report's tank 1.2192 (4 ft)",
        )
        .unit("m")
        .range(0.0, 11_000.0),
        Declaration::new(
            "environment.current.x",
            0.0,
            "The water's steady velocity along the first course",
        )
        .unit("m/s")
        .range(-5.0, 5.0),
        Declaration::new(
            "environment.current.y",
            0.0,
            "The water's steady velocity to starboard of the first course",
        )
        .unit("m/s")
        .range(-5.0, 5.0),
        Declaration::new(
            "environment.current.z",
            0.0,
            "The water's steady velocity downwards",
        )
        .unit("m/s")
        .range(-5.0, 5.0),
        Declaration::new(
            "environment.seaway.force",
            0.0,
            "Standard deviation of the waves' heave force at the surface; 0 with moment 0: calm",
        )
        .unit("N")
        .range(0.0, 1e4),
        Declaration::new(
            "environment.seaway.moment",
            0.0,
            "Standard deviation of the waves' pitch moment at the surface",
        )
        .unit("N m")
        .range(0.0, 1e4),
        Declaration::new(
            "environment.seaway.period",
            3.0,
            "Period at the peak of the waves' spectrum",
        )
        .unit("s")
        .range(0.1, 60.0),
        Declaration::new(
            "environment.seaway.damping",
            0.1,
            "Damping ratio of the filter that shapes the waves: the smaller, the more regular",
        )
        .range(0.001, 1.0),
        Declaration::new(
            "environment.tether.diameter",
            0.0,
            "Of a tether up to the surface, 0: there is none",
        )
        .unit("m")
        .range(0.0, 0.1),
        Declaration::new(
            "environment.tether.drag_coefficient",
            1.2,
            "Of the tether across the flow; 1.2 for a smooth line",
        )
        .range(0.0, 3.0),
        Declaration::new(
            "environment.tether.above",
            0.04445,
            "Height above the body's origin at which the tether is made fast; half the report's hull height",
        )
        .unit("m")
        .range(-1.0, 1.0),
    ]
}

fn sensors() -> Vec<Declaration> {
    vec![
        Declaration::new(
            "seed",
            1988_i64,
            "Of the sensor noise, taken at the start and at a reset",
        )
        .range(0.0, i64::MAX as f64),
        Declaration::new(
            "sensors.errors",
            true,
            "Whether the sensors err as the parameters below say, or read the truth through their calibrations",
        ),
        Declaration::new(
            "sensors.gyro.calibration",
            "swing",
            "The rate gyros' sensitivities: final (swing test, p. 75; yaw, not swung, the preliminary mean), or preliminary with unequal directions at 4.8 or 4.35 V (Figs. 29-34)",
        )
        .choices(&["swing", "preliminary", "preliminary_low"]),
        Declaration::new(
            "sensors.gyro.reference_error",
            0.0,
            "Relative error of the gyros' reference voltage; 1 % changes their sensitivity by 5.6 %",
        )
        .range(-0.1, 0.1),
        Declaration::new("sensors.gyro.bias", 0.0, "Constant zero of each rate gyro")
            .unit("V")
            .range(-1.0, 1.0),
        Declaration::new(
            "sensors.gyro.drift.range",
            0.025,
            "How far each gyro's zero wanders to either side (p. 90); 25 mV are 2 deg/s of pitch; 0: not at all",
        )
        .unit("V")
        .range(0.0, 1.0),
        Declaration::new(
            "sensors.gyro.drift.rate",
            0.001,
            "Standard deviation of the zero's random walk after 1 s, growing as the root of time; assumed",
        )
        .unit("V/s^0.5")
        .range(0.0, 1.0),
        Declaration::new(
            "sensors.gyro.noise",
            0.005,
            "Standard deviation of each rate gyro; assumed, the report gives none",
        )
        .unit("V")
        .range(0.0, 1.0),
        Declaration::new(
            "sensors.accelerometer.bias",
            0.0,
            "Of each accelerometer; the report's vehicle had none",
        )
        .unit("m/s^2")
        .range(-10.0, 10.0),
        Declaration::new(
            "sensors.accelerometer.noise",
            0.02,
            "Standard deviation of each accelerometer, as of a small MEMS unit",
        )
        .unit("m/s^2")
        .range(0.0, 10.0),
        Declaration::new(
            "sensors.depth.port",
            "vehicle",
            "Where depth is sensed: the vehicle file's port, the report's first one (bottom, 17.5 in aft of the bow), or the centre of gravity",
        )
        .choices(&["vehicle", "bottom", "centre"]),
        Declaration::new(
            "sensors.depth.gradient",
            0.0,
            "Manoeuvring pressure at the depth port per rho U (w - x q) / 2; seen, but not measured (p. 64)",
        )
        .range(-10.0, 10.0),
        Declaration::new(
            "sensors.depth.zero",
            1.627,
            "Known output of the depth cell at the surface (Fig. 38); 0 as zeroed on the bench",
        )
        .unit("V")
        .range(-10.0, 10.0),
        Declaration::new(
            "sensors.depth.saturation",
            10.0,
            "Largest output of the depth cell, reached at 32.58 in; 0: no limit",
        )
        .unit("V")
        .range(0.0, 1000.0),
        Declaration::new(
            "sensors.depth.bias",
            0.0,
            "Unknown zero error of the depth cell; the report's shift of 1.627 V was one until noticed",
        )
        .unit("V")
        .range(-10.0, 10.0),
        Declaration::new(
            "sensors.depth.noise",
            0.005,
            "Standard deviation of the depth cell; assumed, the report gives none",
        )
        .unit("V")
        .range(0.0, 10.0),
        Declaration::new(
            "sensors.speed.dry_lines",
            0.3683,
            "Distance of the speed cell's ports along the hull, 14.5 in, bridged by lines without water; 0: full lines, no effect of pitch",
        )
        .unit("m")
        .range(0.0, 100.0),
        Declaration::new(
            "sensors.speed.saturation",
            10.0,
            "Largest output of the speed cell, reached at 2.07 ft/s; 0: no limit",
        )
        .unit("V")
        .range(0.0, 1000.0),
        Declaration::new("sensors.speed.bias", 0.0, "Zero error of the speed cell")
            .unit("V")
            .range(-10.0, 10.0),
        Declaration::new(
            "sensors.speed.noise",
            0.005,
            "Standard deviation of the speed cell; assumed, the report gives none",
        )
        .unit("V")
        .range(0.0, 10.0),
        Declaration::new(
            "daq.dive_planes.compensation",
            2.44,
            "What the pot takes from 2.44 V + 0.010 V/deg; p. 89 says 2.19 V, which leaves 0.25 V at neutral",
        )
        .unit("V")
        .range(0.0, 10.0),
        Declaration::new(
            "daq.dive_planes.noise",
            0.0,
            "Standard deviation of the dive-plane channel; the report gives none",
        )
        .unit("V")
        .range(0.0, 10.0),
        Declaration::new(
            "daq.conditioning",
            "none",
            "Of the pitch-rate channel: none as digitised, s/(s+k), its square, or the relay comparator (pp. 69, 90)",
        )
        .choices(&["none", "high_pass", "high_pass_twice", "dead_band"]),
        Declaration::new(
            "daq.high_pass",
            0.1,
            "The high-pass filters' k; the report prints none",
        )
        .unit("rad/s")
        .range(0.0, 100.0),
        Declaration::new(
            "daq.dead_band",
            0.025,
            "How far the zero is raised in front of the comparator, so that it stays positive",
        )
        .unit("V")
        .range(0.0, 10.0),
        Declaration::new(
            "daq.adc.bits",
            12_i64,
            "The converter's bits; assumed, the report states none. 0: neither rounding nor limit",
        )
        .range(0.0, 32.0),
        Declaration::new(
            "daq.adc.range",
            10.0,
            "The converter's full scale to either side; assumed",
        )
        .unit("V")
        .range(0.1, 100.0),
    ]
}

/// The instruments that the parameters describe.
#[must_use]
pub fn sensors_of(values: &Values) -> Sensors {
    let zero = values.double("sensors.depth.zero");
    let gyros = match values.string("sensors.gyro.calibration") {
        "preliminary" => gyro::PRELIMINARY,
        "preliminary_low" => gyro::PRELIMINARY_LOW,
        _ => gyro::SWING,
    };
    let conditioning = match values.string("daq.conditioning") {
        "high_pass" => Conditioning::HighPass(values.double("daq.high_pass")),
        "high_pass_twice" => Conditioning::HighPassTwice(values.double("daq.high_pass")),
        "dead_band" => Conditioning::DeadBand(values.double("daq.dead_band")),
        _ => Conditioning::None,
    };
    let perfect = Sensors {
        gyros: gyros.equal_sides(),
        depth: PressureCell {
            zero,
            ..pressure_cell::DEPTH
        },
        conditioning,
        ..Sensors::default()
    };
    if !values.bool("sensors.errors") {
        return perfect;
    }
    let cell = |cell: PressureCell, name: &str| {
        let value = |what: &str| values.double(&format!("sensors.{name}.{what}"));
        let saturation = value("saturation");
        PressureCell {
            saturation: if saturation > 0.0 {
                saturation
            } else {
                f64::INFINITY
            },
            bias: value("bias"),
            noise: value("noise"),
            ..cell
        }
    };
    Sensors {
        gyros,
        gyro_errors: gyro::Errors {
            reference: values.double("sensors.gyro.reference_error"),
            bias: values.double("sensors.gyro.bias"),
            drift: gyro::Drift {
                range: values.double("sensors.gyro.drift.range"),
                rate: values.double("sensors.gyro.drift.rate"),
            },
            noise: values.double("sensors.gyro.noise"),
        },
        accelerometer: Channel {
            bias: values.double("sensors.accelerometer.bias"),
            noise: values.double("sensors.accelerometer.noise"),
        },
        depth: cell(perfect.depth, "depth"),
        depth_port: match values.string("sensors.depth.port") {
            "bottom" => DepthPort::Bottom,
            "centre" => DepthPort::Centre,
            _ => DepthPort::Vehicle,
        },
        depth_gradient: values.double("sensors.depth.gradient"),
        speed: cell(perfect.speed, "speed"),
        dry_lines: values.double("sensors.speed.dry_lines"),
        dive_planes: PlaneSignal {
            compensation: values.double("daq.dive_planes.compensation"),
            noise: values.double("daq.dive_planes.noise"),
            ..plane_signal::DIVE
        },
        adc: Adc {
            // Declared to be 0 to 32.
            bits: values.integer("daq.adc.bits").unsigned_abs() as u32,
            range: values.double("daq.adc.range"),
        },
        ..perfect
    }
}

fn node() -> Vec<Declaration> {
    vec![
        Declaration::new(
            "time",
            "real",
            "What moves time on: the clock times the factor, the loop's answers, or /clock",
        )
        .choices(&["real", "lockstep", "external"])
        .read_only(),
        Declaration::new("factor", 1.0, "Simulated seconds per second in real time")
            .range(0.01, 100.0)
            .read_only(),
        Declaration::new(
            "sim_time",
            false,
            "Publish /clock and count stamps from 0 in real time too",
        )
        .read_only(),
        Declaration::new(
            "start_paused",
            false,
            "Wait at the first tick for ~/pause or ~/step",
        )
        .read_only(),
        Declaration::new(
            "duration",
            0.0,
            "Simulated time after which the vehicle stands still; 0: never",
        )
        .unit("s")
        .range(0.0, 1e7)
        .read_only(),
        Declaration::new(
            "reliable_sensors",
            false,
            "Offer the sensors' topics reliably, for a recorder that is to miss nothing, rather than best effort, as by convention; always in lockstep",
        )
        .read_only(),
        Declaration::new(
            "actuator_answer",
            "plane_motion",
            "The topic on which the actuator answers: plane_motion, or planes alone (a foreign actuator's angle, held over the tick)",
        )
        .choices(&["plane_motion", "planes"])
        .read_only(),
        Declaration::new(
            "delay_budget",
            0_i64,
            "How old an actuator's answer may be to be flown when the tick's own has not come in time, for a loop over a slow link; 0: the planes are held at once. Not in lockstep, which waits",
        )
        .unit("ticks")
        .range(0.0, 100.0),
        Declaration::new(
            "lockstep.members",
            Value::StringArray(Vec::new()),
            "Nodes whose tick_answer each tick waits for, besides plane_motion",
        )
        .read_only(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_obeys_its_own_declaration() {
        for declaration in declarations() {
            let default = declaration.default.clone();
            assert_eq!(declaration.accept(default.clone()), Ok(default));
        }
    }

    #[test]
    fn no_name_is_declared_twice() {
        let values = Values::defaults(declarations());
        let mut names: Vec<&str> = values.declarations().iter().map(|d| d.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), declarations().len());
    }
}
