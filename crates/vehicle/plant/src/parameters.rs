//! The node's parameters, with defaults and ranges.

use std::f64::consts::PI;

use planesman_parameters::{Choice, Parameters};

use crate::sensors::{
    Channel, Sensors,
    adc::Adc,
    conditioning::Conditioning,
    gyro,
    navigation::{AttitudeReference, Dvl, EarthField, Gps, Magnetometer, Navigation, Origin, Usbl},
    plane_signal::{self, PlaneSignal},
    pressure_cell::{self, DepthPort, PressureCell},
};
use planesman_vehicle::{BRUNNER_SECANT_RATE, BRUNNER_VISCOUS_DAMPING, vehicle_file::BRUNNER};

/// Every parameter of `plant_sim`: those of `core` first, then those that only the node reads (`time`
/// and after).
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct PlantParameters {
    /// Vehicle: 'brunner' (NPS 1988), 'brunner_as_printed' (with the errors of its programs), 'remus_100'
    /// (Prestero 2001), or the path of a vehicle file or of an identified model (sysid fit --model).
    #[parameter(default = BRUNNER, read_only)]
    pub vehicle: String,
    /// Base vehicle of an identified model: gives geometry, masses, buoyancy and heave.
    #[parameter(default = BRUNNER, read_only)]
    pub vehicle_base: String,
    /// Forward speed through the water; with propulsion thrust, the initial speed.
    #[parameter(default = 0.3048, unit = "m/s", range = 0.0..=5.0)]
    pub speed: f64,
    /// Propulsion: held (constant speed), or thrust (commanded thrust against the drag).
    #[parameter(default = Propulsion::Held)]
    pub propulsion: Propulsion,
    /// Law of the restoring moment as a function of pitch: sine (hydrostatics), small_angle (the report's form) or none.
    #[parameter(default = RestoringMoment::Sine)]
    pub restoring: RestoringMoment,
    /// Law of the pitch damping: coefficient (the vehicle's M'q), quadratic (the hull's drag N |q| q), or its
    /// secant or tangent.
    #[parameter(default = DampingLaw::Coefficient)]
    pub pitch_damping: DampingLaw,
    /// Drag coefficient N of pitch_damping secant, tangent and quadratic; the report's plate of 28 by 7 in,
    /// 0.4193 ft lbf s^2.
    #[parameter(default = BRUNNER_VISCOUS_DAMPING, unit = "N m s^2", range = 0.0..=1e4)]
    pub pitch_damping_viscous: f64,
    /// Pitch rate of the secant or the tangent.
    #[parameter(default = BRUNNER_SECANT_RATE, unit = "rad/s", range = 0.0..=10.0)]
    pub pitch_damping_rate: f64,
    /// Whether heave causes a pitch moment (M_w).
    #[parameter(default = true)]
    pub heave_moment: bool,
    /// Initial depth, positive down; also after a reset.
    #[parameter(default = 0.0, unit = "m", positive = "down", range = 0.0..=1000.0)]
    pub initial_depth: f64,
    /// Initial pitch, positive bow up; also after a reset.
    #[parameter(default = 0.0, unit = "rad", positive = "bow up", range = -PI..=PI)]
    pub initial_pitch: f64,
    /// Sampling time of the loop; the report sampled at 20 Hz.
    #[parameter(default = 0.05, unit = "s", range = 1e-4..=1.0, read_only)]
    pub tick: f64,
    /// Longest step of the integration; the integration error may require shorter steps.
    #[parameter(default = 0.05, unit = "s", range = 1e-5..=0.1, read_only)]
    pub step: f64,
    /// Prefix of all frames, to distinguish vehicles on one /tf: 'auv2/'.
    #[parameter(default = "", read_only)]
    pub frame_prefix: String,
    /// Whether /tf_static has the transform from map to odom, which are the same here: the simulator's odometry does not
    /// drift. false where a localization node publishes it.
    #[parameter(default = true, read_only)]
    pub map_to_odom: bool,
    /// `environment.*`.
    pub environment: Environment,
    /// Seed of the sensor noise, applied at the start and at a reset.
    #[parameter(default = 1988, range = 0.0..=i64::MAX as f64)]
    pub seed: u64,
    /// `sensors.*`.
    pub sensors: SensorParameters,
    /// `daq.*`.
    pub daq: Daq,
    /// Time source: real (the wall clock times factor), lockstep (the answers of the loop) or external (/clock).
    #[parameter(default = TimeSource::Real, read_only)]
    pub time: TimeSource,
    /// Real-time factor: simulated seconds per wall second.
    #[parameter(default = 1.0, range = 0.01..=100.0, read_only)]
    pub factor: f64,
    /// Whether /clock is published and stamps start at 0 in real time too.
    #[parameter(default = false, read_only)]
    pub sim_time: bool,
    /// Whether the vehicle waits at the first tick for ~/pause or ~/step.
    #[parameter(default = false, read_only)]
    pub start_paused: bool,
    /// Simulated time after which the vehicle stops; 0: never.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e7, read_only)]
    pub duration: f64,
    /// Whether the node ends when the duration is over, for a launch file that should end with the node.
    #[parameter(default = false, read_only)]
    pub end_when_flown: bool,
    /// Whether the sensors' topics are published reliably, for a recorder that must not lose messages, instead of
    /// best effort; always in lockstep.
    #[parameter(default = false, read_only)]
    pub reliable_sensors: bool,
    /// Largest age of an older actuator answer that is used while the answer of the tick is late, for a loop over a slow link; 0: the last angle is
    /// held at once. Not used in lockstep, which waits.
    #[parameter(default = 0, unit = "ticks", range = 0.0..=100.0)]
    pub delay_budget: i64,
    /// Time without the actuator's answer, in lockstep (by the wall clock) without an answer that the tick waits for,
    /// after which the diagnostics report an error; the planes stay held, in lockstep the tick goes on waiting. 0: never.
    #[parameter(default = 5.0, unit = "s", range = 0.0..=3600.0)]
    pub answer_timeout: f64,
    /// `lockstep.*`.
    pub lockstep: Lockstep,
}

/// The parameters `environment.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Environment {
    /// Density of the water, for pressures; fresh water as in the report (1.94 slug/ft^3); sea water 1025.
    #[parameter(default = 999.835, unit = "kg/m^3", range = 900.0..=1200.0)]
    pub density: f64,
    /// Acceleration of gravity; the report's 32.2 ft/s^2.
    #[parameter(default = 9.81456, unit = "m/s^2", range = 9.0..=10.0)]
    pub gravity: f64,
    /// Absolute pressure at the surface.
    #[parameter(default = 101_325.0, unit = "Pa", range = 0.0..=200_000.0)]
    pub atmospheric_pressure: f64,
    /// Depth of the bottom, positive down; 0: none; the report's tank 1.2192 (4 ft).
    #[parameter(default = 0.0, unit = "m", positive = "down", range = 0.0..=11_000.0)]
    pub bottom: f64,
    /// `environment.current.*`.
    pub current: Current,
    /// `environment.seaway.*`.
    pub seaway: Seaway,
    /// `environment.tether.*`.
    pub tether: Tether,
    /// `environment.origin.*`.
    pub origin: Origin,
    /// `environment.earth_field.*`.
    pub earth_field: EarthField,
}

/// The parameters `environment.current.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Current {
    /// Velocity of the water along the initial heading, constant.
    #[parameter(default = 0.0, unit = "m/s", range = -5.0..=5.0)]
    pub x: f64,
    /// Velocity of the water to starboard of the initial heading, constant.
    #[parameter(default = 0.0, unit = "m/s", range = -5.0..=5.0)]
    pub y: f64,
    /// Velocity of the water downwards, constant.
    #[parameter(default = 0.0, unit = "m/s", range = -5.0..=5.0)]
    pub z: f64,
}

/// The parameters `environment.seaway.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Seaway {
    /// Standard deviation of the waves' heave force at the surface; 0, with moment 0: calm water.
    #[parameter(default = 0.0, unit = "N", range = 0.0..=1e4)]
    pub force: f64,
    /// Standard deviation of the waves' pitch moment at the surface.
    #[parameter(default = 0.0, unit = "N m", range = 0.0..=1e4)]
    pub moment: f64,
    /// Period of the peak of the wave spectrum.
    #[parameter(default = 3.0, unit = "s", range = 0.1..=60.0)]
    pub period: f64,
    /// Damping ratio of the filter that shapes the waves; a smaller ratio gives more regular waves.
    #[parameter(default = 0.1, range = 0.001..=1.0)]
    pub damping: f64,
}

/// The parameters `environment.tether.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Tether {
    /// Diameter of a tether to the surface; 0: none.
    #[parameter(default = 0.0, unit = "m", range = 0.0..=0.1)]
    pub diameter: f64,
    /// Drag coefficient of the tether across the flow; 1.2 for a smooth line.
    #[parameter(default = 1.2, range = 0.0..=3.0)]
    pub drag_coefficient: f64,
    /// Height of the tether's attachment above the body's origin; half the report's hull height.
    #[parameter(default = 0.04445, unit = "m", range = -1.0..=1.0)]
    pub above: f64,
}

/// The parameters `sensors.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct SensorParameters {
    /// Whether the sensors have the errors below; false: they give true values through their calibrations.
    #[parameter(default = true)]
    pub errors: bool,
    /// `sensors.gyro.*`.
    pub gyro: Gyro,
    /// `sensors.accelerometer.*`.
    pub accelerometer: Accelerometer,
    /// `sensors.depth.*`.
    pub depth: Depth,
    /// `sensors.speed.*`.
    pub speed: Speed,
    /// `sensors.dvl.*`.
    pub dvl: Dvl,
    /// `sensors.magnetometer.*`.
    pub magnetometer: Magnetometer,
    /// `sensors.gps.*`.
    pub gps: Gps,
    /// `sensors.usbl.*`.
    pub usbl: Usbl,
    /// `sensors.attitude.*`.
    pub attitude: AttitudeReference,
}

/// The parameters `sensors.gyro.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Gyro {
    /// Calibration of the rate gyros: swing (final, swing test, p. 75; yaw by the preliminary mean), preliminary
    /// or preliminary_low (unequal sides, at 4.8 or 4.35 V, Figs. 29-34).
    #[parameter(default = GyroCalibration::Swing)]
    pub calibration: GyroCalibration,
    /// Relative error of the gyros' reference voltage; 1 % changes their sensitivity by 5.6 %.
    #[parameter(default = 0.0, range = -0.1..=0.1)]
    pub reference_error: f64,
    /// Constant bias of each rate gyro.
    #[parameter(default = 0.0, unit = "V", range = -1.0..=1.0)]
    pub bias: f64,
    /// `sensors.gyro.drift.*`.
    pub drift: Drift,
    /// Standard deviation of the noise of each rate gyro; assumed, because the report does not state it.
    #[parameter(default = 0.005, unit = "V", range = 0.0..=1.0)]
    pub noise: f64,
}

/// The parameters `sensors.gyro.drift.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Drift {
    /// Limit of the drift of each gyro's bias to either side (p. 90); 25 mV are 2 deg/s of pitch; 0: no drift.
    #[parameter(default = 0.025, unit = "V", range = 0.0..=1.0)]
    pub range: f64,
    /// Standard deviation of the bias' random walk after 1 s; grows as the square root of time; assumed.
    #[parameter(default = 0.001, unit = "V/s^0.5", range = 0.0..=1.0)]
    pub rate: f64,
}

/// The parameters `sensors.accelerometer.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Accelerometer {
    /// Constant bias of each accelerometer; the report's vehicle had no accelerometers.
    #[parameter(default = 0.0, unit = "m/s^2", range = -10.0..=10.0)]
    pub bias: f64,
    /// Standard deviation of the noise of each accelerometer, typical of a small MEMS unit.
    #[parameter(default = 0.02, unit = "m/s^2", range = 0.0..=10.0)]
    pub noise: f64,
}

/// The parameters `sensors.depth.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Depth {
    /// Position of the depth port: of the vehicle file, the report's first one (bottom, 17.5 in aft of the bow),
    /// or the centre of gravity.
    #[parameter(default = DepthPort::Vehicle)]
    pub port: DepthPort,
    /// Known output of the depth cell at the surface (Fig. 38); 0 as zeroed on the bench.
    #[parameter(default = 1.627, unit = "V", range = -10.0..=10.0)]
    pub zero: f64,
    /// Largest output of the depth cell; 0: no limit. The limit of the 1988 report, 10 V, is reached at 32.58 in
    #[parameter(default = 0.0, unit = "V", range = 0.0..=1000.0)]
    pub saturation: f64,
    /// Unknown zero error of the depth cell, like the report's shift of 1.627 V before it was noticed.
    #[parameter(default = 0.0, unit = "V", range = -10.0..=10.0)]
    pub bias: f64,
    /// Standard deviation of the noise of the depth cell; assumed, because the report does not state it.
    #[parameter(default = 0.005, unit = "V", range = 0.0..=10.0)]
    pub noise: f64,
}

/// The parameters `sensors.speed.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Speed {
    /// Distance of the speed cell's ports along the hull, 14.5 in, with lines free of water, so that pitch
    /// affects the reading; 0: full lines, no effect of pitch.
    #[parameter(default = 0.3683, unit = "m", range = 0.0..=100.0)]
    pub dry_lines: f64,
    /// Largest output of the speed cell; 0: no limit. The limit of the 1988 report, 10 V, is reached at 2.07 ft/s
    #[parameter(default = 0.0, unit = "V", range = 0.0..=1000.0)]
    pub saturation: f64,
    /// Zero error of the speed cell.
    #[parameter(default = 0.0, unit = "V", range = -10.0..=10.0)]
    pub bias: f64,
    /// Standard deviation of the noise of the speed cell; assumed, because the report does not state it.
    #[parameter(default = 0.005, unit = "V", range = 0.0..=10.0)]
    pub noise: f64,
}

/// The parameters `daq.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Daq {
    /// `daq.dive_planes.*`.
    pub dive_planes: DivePlanes,
    /// Conditioning of the pitch-rate channel: none, the high-pass filter s/(s+k), the same filter twice, or the relay comparator (pp. 69, 90).
    #[parameter(default = Filter::None)]
    pub conditioning: Filter,
    /// Corner frequency k of the high-pass filters; the report does not state it.
    #[parameter(default = 0.1, unit = "rad/s", range = 0.0..=100.0)]
    pub high_pass: f64,
    /// Offset added before the comparator, so that its input stays positive.
    #[parameter(default = 0.025, unit = "V", range = 0.0..=10.0)]
    pub dead_band: f64,
    /// `daq.adc.*`.
    pub adc: AdcParameters,
}

/// The parameters `daq.dive_planes.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct DivePlanes {
    /// Offset subtracted from the potentiometer's 2.44 V + 0.010 V/deg; p. 89 prints 2.19 V, which leaves 0.25 V
    /// at neutral.
    #[parameter(default = 2.44, unit = "V", range = 0.0..=10.0)]
    pub compensation: f64,
    /// Standard deviation of the noise of the dive-plane channel; the report does not state it.
    #[parameter(default = 0.0, unit = "V", range = 0.0..=10.0)]
    pub noise: f64,
}

/// The parameters `daq.adc.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct AdcParameters {
    /// Resolution of the converter in bits; assumed, because the report does not state it. 0: neither rounding nor limit.
    #[parameter(default = 12, range = 0..=32)]
    pub bits: u32,
    /// Full scale of the converter to either side; assumed.
    #[parameter(default = 10.0, unit = "V", range = 0.1..=100.0)]
    pub range: f64,
}

/// The parameters `lockstep.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Lockstep {
    /// Nodes whose tick_answer every tick waits for, besides plane_motion.
    #[parameter(default = Vec::new(), read_only)]
    pub members: Vec<String>,
    /// Topics of any node and type that every tick waits for, besides plane_motion or planes: for the message that bears the tick's
    /// stamp; of messages without one, for the first after the tick's state.
    #[parameter(default = Vec::new(), read_only)]
    pub gates: Vec<String>,
}

/// The propulsion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum Propulsion {
    /// The speed is held.
    Held,
    /// The commanded thrust acts against the drag.
    Thrust,
}

/// Law of the restoring moment over pitch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum RestoringMoment {
    /// `sin(theta)`: hydrostatics.
    Sine,
    /// `theta`: the report's small-angle form.
    SmallAngle,
    /// No restoring moment.
    None,
}

/// Law of the pitch damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum DampingLaw {
    /// The vehicle's `M'q`.
    Coefficient,
    /// The secant of `N |q| q` at a rate.
    Secant,
    /// The tangent of `N |q| q` at a rate.
    Tangent,
    /// `N |q| q`.
    Quadratic,
}

/// Calibration of the rate gyros.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum GyroCalibration {
    /// The swing test (p. 75).
    Swing,
    /// Preliminary, at 4.8 V (Figs. 29-34).
    Preliminary,
    /// Preliminary, at 4.35 V.
    PreliminaryLow,
}

/// Conditioning of the pitch-rate channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum Filter {
    /// None, as digitized.
    None,
    /// `s/(s + k)`.
    HighPass,
    /// `s/(s + k)` twice.
    HighPassTwice,
    /// The relay comparator.
    DeadBand,
}

/// Source of the ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum TimeSource {
    /// The wall clock times the factor.
    Real,
    /// Each tick waits for the loop's answers.
    Lockstep,
    /// `/clock`.
    External,
}

/// The instruments with the settings from the parameters.
#[must_use]
pub(crate) fn sensors_of(parameters: &PlantParameters) -> Sensors {
    let PlantParameters {
        environment,
        sensors,
        daq,
        ..
    } = parameters;
    let navigation = Navigation {
        origin: environment.origin,
        earth_field: environment.earth_field,
        dvl: sensors.dvl,
        magnetometer: sensors.magnetometer,
        gps: sensors.gps,
        usbl: sensors.usbl,
        attitude: sensors.attitude,
    };
    let gyros = match sensors.gyro.calibration {
        GyroCalibration::Preliminary => gyro::PRELIMINARY,
        GyroCalibration::PreliminaryLow => gyro::PRELIMINARY_LOW,
        GyroCalibration::Swing => gyro::SWING,
    };
    let perfect = Sensors {
        gyros: gyros.equal_sides(),
        depth: PressureCell {
            zero: sensors.depth.zero,
            ..pressure_cell::DEPTH
        },
        conditioning: match daq.conditioning {
            Filter::HighPass => Conditioning::HighPass(daq.high_pass),
            Filter::HighPassTwice => Conditioning::HighPassTwice(daq.high_pass),
            Filter::DeadBand => Conditioning::DeadBand(daq.dead_band),
            Filter::None => Conditioning::None,
        },
        navigation: navigation.without_errors(),
        ..Sensors::default()
    };
    if !sensors.errors {
        return perfect;
    }
    let limit = |saturation| {
        if saturation > 0.0 {
            saturation
        } else {
            f64::INFINITY
        }
    };
    Sensors {
        gyros,
        gyro_errors: gyro::Errors {
            reference: sensors.gyro.reference_error,
            bias: sensors.gyro.bias,
            drift: gyro::Drift {
                range: sensors.gyro.drift.range,
                rate: sensors.gyro.drift.rate,
            },
            noise: sensors.gyro.noise,
        },
        accelerometer: Channel {
            bias: sensors.accelerometer.bias,
            noise: sensors.accelerometer.noise,
        },
        depth: PressureCell {
            saturation: limit(sensors.depth.saturation),
            bias: sensors.depth.bias,
            noise: sensors.depth.noise,
            ..perfect.depth
        },
        depth_port: sensors.depth.port,
        speed: PressureCell {
            saturation: limit(sensors.speed.saturation),
            bias: sensors.speed.bias,
            noise: sensors.speed.noise,
            ..perfect.speed
        },
        dry_lines: sensors.speed.dry_lines,
        dive_planes: PlaneSignal {
            compensation: daq.dive_planes.compensation,
            noise: daq.dive_planes.noise,
            ..plane_signal::DIVE
        },
        adc: Adc {
            bits: daq.adc.bits,
            range: daq.adc.range,
        },
        navigation,
        ..perfect
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Values;

    #[test]
    fn every_default_obeys_its_own_declaration_under_a_name_of_its_own() {
        let values = Values::of::<PlantParameters>();
        let mut names: Vec<&str> = Vec::new();
        for declaration in values.declarations() {
            let default = declaration.default.clone();
            assert_eq!(declaration.accept(default.clone()), Ok(default));
            names.push(&declaration.name);
        }
        let declared = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), declared);
    }
}
