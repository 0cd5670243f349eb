//! The node's parameters: the one place where their defaults and ranges are written.
//!
//! Those of [`crate::core`] first, then those that only the node reads (`time` and after).

use planesman_parameters::{Declaration, Value};

use crate::{
    variant::{BRUNNER_SECANT_RATE, BRUNNER_VISCOUS_DAMPING},
    vehicle_file::BRUNNER,
};

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
            "The vehicle: 'brunner' (NPS 1988), 'brunner_as_printed' (with the errors of its programs), or the path of a vehicle file",
        )
        .read_only(),
        Declaration::new("speed", 0.3048, "Forward speed through the water")
            .unit("m/s")
            .range(0.0, 5.0),
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
            "sensors.noise",
            true,
            "Whether the sensors have their biases and noise, or read the truth",
        ),
        Declaration::new(
            "sensors.gyro.bias",
            0.0349,
            "Of each rate gyro; the report's worst drift, 25 mV at 12.5 mV per deg/s",
        )
        .unit("rad/s")
        .range(-1.0, 1.0),
        Declaration::new(
            "sensors.gyro.noise",
            0.00698,
            "Standard deviation of each rate gyro; 5 mV, assumed, the report gives none",
        )
        .unit("rad/s")
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
        Declaration::new("sensors.depth.bias", 0.0, "Of the depth cell")
            .unit("Pa")
            .range(-100_000.0, 100_000.0),
        Declaration::new(
            "sensors.depth.noise",
            4.85,
            "Standard deviation of the depth cell; 5 mV at 0.257 V per inch, assumed",
        )
        .unit("Pa")
        .range(0.0, 100_000.0),
        Declaration::new("sensors.speed.bias", 0.0, "Of the speed cell")
            .unit("Pa")
            .range(-10_000.0, 10_000.0),
        Declaration::new(
            "sensors.speed.noise",
            0.1,
            "Standard deviation of the speed cell; 5 mV at 12.453 V per inch of water, assumed",
        )
        .unit("Pa")
        .range(0.0, 10_000.0),
    ]
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
            "actuator_answer",
            "plane_motion",
            "The topic on which the actuator answers: plane_motion, or planes alone (a foreign actuator's angle, held over the tick)",
        )
        .choices(&["plane_motion", "planes"])
        .read_only(),
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
    use planesman_parameters::Values;

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
