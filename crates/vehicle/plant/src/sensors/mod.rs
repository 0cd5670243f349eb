//! Readings of the vehicle's instruments, as voltages on the wires and in SI units from drivers.
//!
//! ```text
//! truth -> gyro, cell, plane signal -> volts -+-> conditioning -> ADC -> daq
//!                                             +-> calibration ---------> imu, depth_pressure, speed_pressure
//! ```
//!
//! Each instrument has one set of errors. `imu`'s angular velocity and the two pressures come from the same voltages as the `daq` channels,
//! including bias, drift, noise, supply, port and saturation, divided by the reader's calibration. Only conditioning and converter belong
//! to `daq` alone. The accelerometers have no voltages; the report's vehicle had none.
//!
//! - `gyro`: rate gyros, their calibrations and the drift of their zero.
//! - `pressure_cell`: the depth cell and the speed cell.
//! - `plane_signal`: the signal of the dive planes.
//! - `conditioning`: high-pass filters and the relay comparator.
//! - `adc`: the converter.
//! - [`navigation`]: Doppler log, magnetometer, satellite receiver, ultra-short baseline, attitude reference: off by default.
//! - `noise`: one stream of random numbers per source of error.
//!
//! In the report the dive-plane channel was the *command* from the radio control box, calibrated in degrees of plane. The simulated vehicle
//! has no command signal. The channel therefore shows the plane angle at the stamp, like a potentiometer on the plane's shaft, through the
//! command's calibration. The measured angle lags the command by the actuator's delay.
//!
//! Brunner 1988 (ch. III.F-G, IV) gives calibrations, ranges and the size of the drift, but no noise.

pub(crate) mod adc;
pub(crate) mod conditioning;
pub mod gyro;
pub(crate) mod navigation;
mod noise;
pub mod plane_signal;
pub mod pressure_cell;

use adc::Adc;
use conditioning::Conditioning;
use gyro::Calibrations;
use navigation::Navigation;
use noise::{Source, Stream};
use plane_signal::PlaneSignal;
use planesman_msgs::planesman_msgs::msg::DaqSample;
use planesman_vehicle::{Acceleration, Body, Environment, Port, six_dof};
use pressure_cell::{DepthPort, PressureCell};

use crate::odometry::Odometry;

/// Errors of a channel, in the unit of its measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Channel {
    /// Added to every reading.
    pub bias: f64,
    /// Standard deviation of the white noise.
    pub noise: f64,
}

/// The instruments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sensors {
    /// Calibrations of the gyros.
    pub gyros: Calibrations,
    /// Errors of each gyro.
    pub gyro_errors: gyro::Errors,
    /// Each accelerometer \[m/s^2\].
    pub accelerometer: Channel,
    /// The depth cell.
    pub depth: PressureCell,
    /// Port of the depth cell.
    pub depth_port: DepthPort,
    /// The speed cell.
    pub speed: PressureCell,
    /// Distance between its ports \[m\], with dry lines between them; 0 for lines filled with water.
    pub dry_lines: f64,
    /// Signal of the dive planes.
    pub dive_planes: PlaneSignal,
    /// Conditioning of the pitch-rate channel.
    pub conditioning: Conditioning,
    /// Converter of all `daq` channels.
    pub adc: Adc,
    /// Navigation instruments.
    pub navigation: Navigation,
}

impl Default for Sensors {
    /// The report's calibrations without errors: drivers read the true values.
    fn default() -> Self {
        Self {
            gyros: gyro::SWING,
            gyro_errors: gyro::Errors::default(),
            accelerometer: Channel::default(),
            depth: pressure_cell::DEPTH,
            depth_port: DepthPort::Vehicle,
            speed: pressure_cell::SPEED,
            dry_lines: 0.0,
            dive_planes: plane_signal::DIVE,
            conditioning: Conditioning::None,
            adc: adc::NONE,
            navigation: Navigation::default(),
        }
    }
}

/// True values of the measured quantities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Truth {
    /// Roll, pitch and yaw rate \[rad/s\] about the body's axes forward, right, down.
    pub rates: [f64; 3],
    /// Specific force \[m/s^2\], forward, left, up: acceleration minus gravity.
    pub specific_force: [f64; 3],
    /// Pitch, bow up \[rad\].
    pub pitch: f64,
    /// Depth of the centre of gravity \[m\].
    pub depth: f64,
    /// Forward speed through the water \[m/s\].
    pub speed: f64,
    /// Angle of the dive planes \[rad\].
    pub planes: f64,
    /// Time since the start or a reset \[ns\].
    pub time: i64,
    /// Position, attitude and velocities in ROS frames.
    pub odometry: Odometry,
    /// Depth of the bottom \[m\]; `None` without a bottom.
    pub bottom: Option<f64>,
}

/// State of the instruments from tick to tick.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    gyro_noise: [Stream; 3],
    gyro_drift: [Stream; 3],
    accelerometer: [Stream; 3],
    depth: Stream,
    speed: Stream,
    planes: Stream,
    /// Present drift of the gyros \[V\].
    drift: [f64; 3],
    filter: conditioning::Memory,
    navigation: navigation::Memory,
}

impl Memory {
    /// Returns the state before the first tick for a seed.
    #[must_use]
    pub(crate) fn new(seed: u64) -> Self {
        let axes = |source: fn(u8) -> Source| [0, 1, 2].map(|axis| Stream::new(seed, source(axis)));
        Self {
            gyro_noise: axes(Source::GyroNoise),
            gyro_drift: axes(Source::GyroDrift),
            accelerometer: axes(Source::Accelerometer),
            depth: Stream::new(seed, Source::Depth),
            speed: Stream::new(seed, Source::Speed),
            planes: Stream::new(seed, Source::Planes),
            drift: [0.0; 3],
            filter: conditioning::Memory::default(),
            navigation: navigation::Memory::new(seed),
        }
    }
}

/// The four digitized channels \[V\] (p. 90), or a flag for each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Channels<T> {
    /// Pitch-rate gyro, conditioned.
    pub pitch_rate: T,
    /// The depth cell.
    pub depth: T,
    /// Signal of the dive planes.
    pub dive_planes: T,
    /// The speed cell.
    pub speed: T,
}

/// Readings of a tick. Vectors are in the body frame forward, left, up (REP 103).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Readings {
    /// \[rad/s\]
    pub angular_velocity: [f64; 3],
    /// Specific force \[m/s^2\]. At rest and level, the specific force is `g` upwards.
    pub specific_force: [f64; 3],
    /// Absolute pressure at the depth port \[Pa\].
    pub depth_pressure: f64,
    /// Stagnation pressure minus static pressure \[Pa\].
    pub speed_pressure: f64,
    /// Output of the converter \[V\].
    pub volts: Channels<f64>,
    /// Whether each channel is at a limit of its instrument or of the converter.
    pub saturated: Channels<bool>,
    /// Readings of the navigation instruments.
    pub navigation: navigation::Readings,
}

impl Sensors {
    /// Returns the present readings, and advances `memory` by a tick of `dt` \[s\].
    ///
    /// Every noise stream draws a number in every tick, even if the number is not used; streams of `navigation` draw one in every measurement.
    pub(crate) fn read(
        &self,
        truth: &Truth,
        environment: &Environment,
        depth_port: &Port,
        dt: f64,
        memory: &mut Memory,
    ) -> Readings {
        let [roll, pitch, yaw] = self.gyro_volts(truth.rates, dt, memory);
        let depth = self.depth.volts(
            self.depth_gauge_pressure(truth, environment, depth_port),
            memory.depth.draw(),
        );
        let speed = self.speed.volts(
            self.speed_differential(truth, environment),
            memory.speed.draw(),
        );
        let planes = self.dive_planes.volts(truth.planes, memory.planes.draw());
        let volts = Channels {
            pitch_rate: self.conditioning.step(&mut memory.filter, pitch, dt),
            depth,
            dive_planes: planes,
            speed,
        }
        .map(|v| self.adc.sampled(v));
        let at_end = volts.map(|v| self.adc.saturated(v));
        let rate = |volts: f64, calibration: &gyro::Calibration| volts / calibration.sensitivity();
        Readings {
            angular_velocity: [
                rate(roll, &self.gyros.roll),
                -rate(pitch, &self.gyros.pitch),
                -rate(yaw, &self.gyros.yaw),
            ],
            specific_force: std::array::from_fn(|i| {
                let Channel { bias, noise } = self.accelerometer;
                truth.specific_force[i] + bias + noise * memory.accelerometer[i].draw()
            }),
            depth_pressure: environment.atmospheric_pressure + self.depth.pressure(depth),
            speed_pressure: self.speed.pressure(speed),
            volts,
            saturated: Channels {
                depth: at_end.depth || self.depth.saturated(depth),
                speed: at_end.speed || self.speed.saturated(speed),
                ..at_end
            },
            navigation: {
                let tick = (dt * 1e9).round() as i64;
                let times = [truth.time, tick];
                (self.navigation).read(&truth.odometry, truth.bottom, times, &mut memory.navigation)
            },
        }
    }

    /// Standard deviation of the noise of each angular velocity \[rad/s\], forward, left, up.
    #[must_use]
    pub(crate) fn rate_noise(&self) -> [f64; 3] {
        [&self.gyros.roll, &self.gyros.pitch, &self.gyros.yaw]
            .map(|calibration| self.gyro_errors.noise / calibration.sensitivity())
    }

    /// Roll, pitch and yaw gyro \[V\].
    fn gyro_volts(&self, rates: [f64; 3], dt: f64, memory: &mut Memory) -> [f64; 3] {
        let calibrations = [&self.gyros.roll, &self.gyros.pitch, &self.gyros.yaw];
        std::array::from_fn(|i| {
            let (drift, noise) = (memory.drift[i], memory.gyro_noise[i].draw());
            let wander = memory.gyro_drift[i].draw();
            memory.drift[i] = self.gyro_errors.drift.step(drift, dt, wander);
            self.gyro_errors
                .volts(calibrations[i], rates[i], drift, noise)
        })
    }

    /// Relative to the dry interior of the vehicle, which is at atmospheric pressure \[Pa\]. For each channel in `saturated`, flags of
    /// [`DaqSample`], its measuring range.
    pub(crate) fn limits(&self, saturated: u8, environment: &Environment) -> Vec<String> {
        let [low, high] = self.adc.ends();
        let ends = |cell: &PressureCell| {
            let zero = if cell.saturation.is_finite() {
                0.0
            } else {
                low
            };
            [low.max(zero), high.min(cell.saturation)].map(|volts| cell.pressure(volts))
        };
        let weight = environment.density * environment.gravity;
        let [shallow, deep] = ends(&self.depth).map(|it| it / weight);
        let [least, most] = ends(&self.speed);
        let volts = format!("{low:.3} to {high:.3} V");
        let channels = [
            (DaqSample::PITCH_RATE, format!("pitch rate, {volts}")),
            (
                DaqSample::DEPTH,
                format!("depth, {shallow:.3} to {deep:.3} m of water over the port"),
            ),
            (DaqSample::DIVE_PLANES, format!("dive planes, {volts}")),
            (
                DaqSample::SPEED,
                format!("speed, {least:.1} to {most:.1} Pa"),
            ),
        ];
        let told = channels.into_iter().filter(|it| saturated & it.0 != 0);
        told.map(|it| it.1).collect()
    }

    fn depth_gauge_pressure(
        &self,
        truth: &Truth,
        environment: &Environment,
        vehicle_port: &Port,
    ) -> f64 {
        let port = self.depth_port.place(*vehicle_port);
        environment.pressure(pressure_cell::depth_of(&port, truth.depth, truth.pitch))
            - environment.atmospheric_pressure
    }

    /// Pressure at the nose minus pressure at the side ports \[Pa\].
    fn speed_differential(&self, truth: &Truth, environment: &Environment) -> f64 {
        let specific_weight = environment.density * environment.gravity;
        environment.dynamic_pressure(truth.speed)
            + pressure_cell::dry_line_pressure(self.dry_lines, truth.pitch, specific_weight)
    }
}

impl<T: Copy> Channels<T> {
    fn map<U>(self, f: impl Fn(T) -> U) -> Channels<U> {
        Channels {
            pitch_rate: f(self.pitch_rate),
            depth: f(self.depth),
            dive_planes: f(self.dive_planes),
            speed: f(self.speed),
        }
    }
}

/// Specific force at the origin of a vehicle with six degrees of freedom, forward, left, up \[m/s^2\]: `v' + w x v - R^T g`, where `v'` is
/// the derivative of its velocity in body axes.
pub(crate) fn specific_force_of(
    state: &six_dof::State,
    [u_dot, v_dot, w_dot]: [f64; 3],
    g: f64,
) -> [f64; 3] {
    let [u, v, w, p, q, r] = state.velocity;
    let fall =
        six_dof::rotation::to_body(&six_dof::rotation::matrix(state.attitude), [0.0, 0.0, g]);
    [
        u_dot + q * w - r * v - fall[0],
        0.0 - (v_dot + r * u - p * w - fall[1]),
        -(w_dot + p * v - q * u - fall[2]),
    ]
}

/// Specific force at the body's origin, forward, left, up \[m/s^2\]: the acceleration due to all forces, minus gravity. In body axes
/// forward, right, down, without sideslip:
///
/// ```text
/// f_x = U' + q w       + g sin(theta)
/// f_y = r U - p w      - g cos(theta) sin(phi)
/// f_z = w' - q U       - g cos(theta) cos(phi)
/// ```
/// At the surface or the bottom the vertical acceleration is removed; the impact at first contact is not included.
#[must_use]
pub fn specific_force(body: &Body, acceleration: &Acceleration, g: f64) -> [f64; 3] {
    let down = [0.0, 0.0, g - acceleration.boundary];
    let fall = body.attitude().to_body(down);
    let origin = acceleration.of_the_origin(body);
    let [forward, right, down] = std::array::from_fn(|i| origin[i] - fall[i]);
    // `0 - right`, not `-right`: no negative zero.
    [forward, 0.0 - right, -down]
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_units::{FOOT, INCH};
    use planesman_vehicle::vehicle_file::brunner;

    const FRESH: Environment = Environment {
        density: 999.835,
        gravity: 9.81456,
        atmospheric_pressure: 101_325.0,
    };

    const T: f64 = 0.05;

    /// Every error on.
    fn imperfect() -> Sensors {
        let errors = gyro::Errors {
            reference: 0.01,
            bias: 0.01,
            drift: gyro::Drift {
                range: 0.025,
                rate: 1e-3,
            },
            noise: 5e-3,
        };
        let cell = |cell: PressureCell| PressureCell {
            saturation: 10.0,
            bias: 0.02,
            noise: 5e-3,
            ..cell
        };
        Sensors {
            gyro_errors: errors,
            accelerometer: Channel {
                bias: 0.1,
                noise: 0.02,
            },
            depth: cell(pressure_cell::DEPTH),
            depth_port: DepthPort::Bottom,
            speed: cell(pressure_cell::SPEED),
            dry_lines: pressure_cell::SIDE_PORTS * INCH,
            dive_planes: PlaneSignal {
                compensation: plane_signal::PRINTED_COMPENSATION,
                noise: 1e-3,
                ..plane_signal::DIVE
            },
            adc: Adc {
                bits: 12,
                range: 10.0,
            },
            ..Sensors::default()
        }
    }

    const DIVING: Truth = Truth {
        rates: [0.02, -0.1, 0.03],
        specific_force: [0.1, 0.0, 9.8],
        pitch: -0.02,
        depth: 0.3,
        speed: FOOT,
        planes: 0.2,
        time: 0,
        odometry: Odometry::AT_REST,
        bottom: None,
    };

    fn run(sensors: &Sensors, ticks: usize) -> Vec<Readings> {
        let port = brunner().depth_port;
        let mut memory = Memory::new(1988);
        (0..ticks)
            .map(|_| sensors.read(&DIVING, &FRESH, &port, T, &mut memory))
            .collect()
    }

    fn once(sensors: &Sensors, truth: &Truth) -> Readings {
        let mut memory = Memory::new(1);
        sensors.read(truth, &FRESH, &brunner().depth_port, T, &mut memory)
    }

    #[test]
    fn without_errors_the_drivers_read_the_truth_and_the_wires_the_calibrations() {
        let readings = once(&Sensors::default(), &DIVING);
        for (rate, expected) in readings.angular_velocity.iter().zip([0.02, 0.1, -0.03]) {
            assert!((rate - expected).abs() < 1e-15);
        }
        assert_eq!(readings.specific_force, DIVING.specific_force);
        let port_depth = 0.3 + 0.5 * INCH * libm::sin(0.02_f64);
        assert!((readings.depth_pressure - FRESH.pressure(port_depth)).abs() < 1e-9);
        assert!((readings.speed_pressure - FRESH.dynamic_pressure(FOOT)).abs() < 1e-12);
        let Channels {
            pitch_rate,
            depth,
            dive_planes,
            speed,
        } = readings.volts;
        assert!((pitch_rate + 0.071_619_724).abs() < 1e-9);
        assert!((depth - 1.627 - 10.118_110 * port_depth).abs() < 1e-6);
        assert!((dive_planes - 0.572_957_8 * 0.2).abs() < 1e-7);
        assert!((speed - 2.3230).abs() < 5e-4);
        assert_eq!(readings.saturated, Channels::default());
    }

    #[test]
    fn the_imu_and_the_pitch_rate_channel_are_one_instrument() {
        let sensors = Sensors {
            adc: adc::NONE,
            ..imperfect()
        };
        for readings in run(&sensors, 50) {
            let rate = -readings.angular_velocity[1];
            let volts = readings.volts.pitch_rate;
            assert!((rate * gyro::SWING.pitch.sensitivity() - volts).abs() < 1e-15);
            let pressure = readings.depth_pressure - FRESH.atmospheric_pressure;
            assert!(
                (sensors.depth.volts(pressure, 0.0) - 0.02 - readings.volts.depth).abs() < 1e-12
            );
        }
    }

    #[test]
    fn switching_one_error_off_changes_no_other_channel() {
        let all = run(&imperfect(), 40);
        let mut without = imperfect();
        without.gyro_errors = gyro::Errors::default();
        for (a, b) in all.iter().zip(run(&without, 40)) {
            assert_ne!(a.angular_velocity, b.angular_velocity);
            assert_eq!(a.specific_force, b.specific_force);
            assert_eq!(a.depth_pressure, b.depth_pressure);
            assert_eq!(a.speed_pressure, b.speed_pressure);
            assert_eq!(a.volts.dive_planes, b.volts.dive_planes);
        }
        let mut quiet = imperfect();
        quiet.depth.noise = 0.0;
        quiet.speed.noise = 0.0;
        quiet.accelerometer.noise = 0.0;
        quiet.dive_planes.noise = 0.0;
        for (a, b) in all.iter().zip(run(&quiet, 40)) {
            assert_eq!(a.angular_velocity, b.angular_velocity);
            assert_ne!(a.depth_pressure, b.depth_pressure);
        }
    }

    #[test]
    fn a_gyro_that_does_not_wander_keeps_its_white_noise() {
        let mut still = imperfect();
        still.gyro_errors.drift = gyro::Drift::default();
        let all = run(&imperfect(), 40);
        let noise = run(&still, 40);
        assert_eq!(all[0].angular_velocity, noise[0].angular_velocity);
        let wander: Vec<f64> = all
            .iter()
            .zip(&noise)
            .map(|(a, b)| {
                (a.angular_velocity[1] - b.angular_velocity[1]) * gyro::SWING.pitch.sensitivity()
            })
            .collect();
        // A walk: no step is longer than a few times 1 mV sqrt(0.05).
        for pair in wander.windows(2) {
            let step = (pair[1] - pair[0]).abs();
            assert!(step > 0.0 && step < 5.0 * 1e-3 * T.sqrt());
        }
    }

    #[test]
    fn each_gyro_has_the_bias_and_the_deviation_it_was_given() {
        let mut sensors = Sensors::default();
        sensors.gyro_errors.bias = 0.025;
        sensors.gyro_errors.noise = 5e-3;
        let rates: Vec<f64> = run(&sensors, 20_000)
            .iter()
            .map(|r| -r.angular_velocity[1] - DIVING.rates[1])
            .collect();
        let count = rates.len() as f64;
        let mean = rates.iter().sum::<f64>() / count;
        let variance = rates.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / count;
        // 25 mV are two degrees a second, 5 mV 0.4.
        assert!((mean.to_degrees() - 2.0).abs() < 0.02);
        assert!((variance.sqrt().to_degrees() - 0.4).abs() < 0.01);
        assert!((sensors.rate_noise()[1].to_degrees() - 0.4).abs() < 1e-12);
    }

    #[test]
    fn a_dive_saturates_the_speed_cell_and_later_the_depth_cell() {
        let mut sensors = Sensors::default();
        sensors.depth.saturation = pressure_cell::FULL_SCALE;
        sensors.speed.saturation = pressure_cell::FULL_SCALE;
        sensors.dry_lines = pressure_cell::SIDE_PORTS * INCH;
        let at = |pitch: f64, depth: f64| {
            let truth = Truth {
                pitch: pitch.to_radians(),
                depth,
                ..DIVING
            };
            once(&sensors, &truth).saturated
        };
        assert!(!at(0.0, 0.3).speed);
        assert!(
            at(-3.0, 0.3).speed,
            "a knot less than at rest, with a foot a second"
        );
        assert!(at(3.0, 0.3).speed, "at zero");
        assert!(!at(0.0, 0.82).depth && at(0.0, 0.83).depth);
        // 32.58 in of the report's water (p. 77), at 10 V; 0.8 in of water (p. 79).
        let tank = Environment {
            density: 999.835,
            gravity: 9.81456,
            atmospheric_pressure: 101_325.0,
        };
        let lines = sensors.limits(DaqSample::DEPTH | DaqSample::SPEED, &tank);
        let depth = "depth, -0.161 to 0.828 m of water over the port";
        assert_eq!(lines[0], depth);
        assert_eq!(lines[1], "speed, 0.0 to 199.9 Pa");
        assert!(sensors.limits(0, &tank).is_empty());
    }

    #[test]
    fn moving_the_port_three_inches_is_half_an_inch_of_depth_at_ten_degrees() {
        // Brunner 1988, p. 64: why the port was moved.
        let bow_up = Truth {
            depth: 1.0,
            pitch: 10_f64.to_radians(),
            ..Truth::default()
        };
        let inches = |depth_port: DepthPort| {
            let sensors = Sensors {
                depth_port,
                ..Sensors::default()
            };
            let pressure = once(&sensors, &bow_up).depth_pressure;
            sensors.depth.volts(pressure, 0.0) / 0.257
        };
        let below = 1.75 * libm::cos(10_f64.to_radians());
        let shift = inches(DepthPort::Bottom) - inches(DepthPort::Vehicle) - below;
        assert!((shift - 0.5209).abs() < 1e-3, "{shift}");
    }

    const STEADY: Acceleration = Acceleration {
        surge: 0.0,
        heave: 0.0,
        pitch: 0.0,
        boundary: 0.0,
    };

    #[test]
    fn level_and_steady_the_accelerometers_feel_gravity_upwards() {
        let felt = specific_force(&Body::default(), &STEADY, FRESH.gravity);
        assert_eq!(felt, [0.0, 0.0, 9.81456]);
    }

    #[test]
    fn heeled_to_starboard_the_accelerometers_feel_the_support_from_port_too() {
        let mut body = Body::default();
        body.roll.angle = 0.5;
        let [forward, left, up] = specific_force(&body, &STEADY, FRESH.gravity);
        assert_eq!(forward, 0.0);
        assert!((left - FRESH.gravity * libm::sin(0.5f64)).abs() < 1e-12);
        assert!((up - FRESH.gravity * libm::cos(0.5f64)).abs() < 1e-12);
    }
}
