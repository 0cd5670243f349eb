//! What the vehicle's instruments would read: the truth, a bias and white noise.
//!
//! Three rate gyros and three accelerometers at the centre of gravity, a depth cell at its port,
//! a speed cell between the bow and the side ports. A reading is
//!
//! ```text
//! measured = true + bias + noise n,    n normal with mean 0 and variance 1
//! ```
//!
//! The random numbers depend on the seed and on how many ticks have passed, and on nothing
//! else: a full set is drawn each tick whether or not a channel uses it.
//!
//! Brunner 1988 reports of its gyros a zero that drifts within some 25 mV at 12.5 mV per deg/s
//! (pp. 75, 90); it had no accelerometers and gives no noise levels.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::{Pcg64, rand_core::SeedableRng};

use crate::{State, environment::Environment, vehicle::Derivatives, vehicle::Port};

/// One channel's imperfections, in the unit of what it measures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Channel {
    /// Added to every reading.
    pub bias: f64,
    /// Standard deviation of the white noise.
    pub noise: f64,
}

impl Channel {
    fn read(&self, truth: f64, normal: f64) -> f64 {
        truth + self.bias + self.noise * normal
    }

    fn read_each(&self, truth: [f64; 3], normal: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.read(truth[i], normal[i]))
    }
}

/// The instruments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensors {
    /// Each rate gyro \[rad/s\].
    pub gyro: Channel,
    /// Each accelerometer \[m/s^2\].
    pub accelerometer: Channel,
    /// The depth cell \[Pa\].
    pub depth: Channel,
    /// The speed cell \[Pa\].
    pub speed: Channel,
}

/// One tick's random numbers, normal with mean 0 and variance 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Normals {
    gyro: [f64; 3],
    accelerometer: [f64; 3],
    depth: f64,
    speed: f64,
}

/// Where the random numbers come from: PCG XSL RR 128/64 (O'Neill 2014), the same on every machine.
#[derive(Clone, Debug)]
pub struct Noise(Pcg64);

impl Noise {
    /// The sequence of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// The next tick's numbers.
    pub fn draw(&mut self) -> Normals {
        let mut normal = || StandardNormal.sample(&mut self.0);
        Normals {
            gyro: std::array::from_fn(|_| normal()),
            accelerometer: std::array::from_fn(|_| normal()),
            depth: normal(),
            speed: normal(),
        }
    }
}

/// One tick's readings. Vectors are in the body frame forward, left, up (REP 103).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// \[rad/s\]
    pub angular_velocity: [f64; 3],
    /// Specific force \[m/s^2\]: acceleration less gravity. At rest and level it is `g` upwards.
    pub specific_force: [f64; 3],
    /// Absolute pressure at the depth port \[Pa\].
    pub depth_pressure: f64,
    /// Stagnation less static pressure \[Pa\].
    pub speed_pressure: f64,
}

impl Sensors {
    /// What the instruments read in a state, with the planes at `delta` \[rad\].
    #[must_use]
    pub fn read(
        &self,
        state: &State,
        delta: f64,
        derivatives: &Derivatives,
        environment: &Environment,
        depth_port: &Port,
        normals: &Normals,
    ) -> Readings {
        Readings {
            angular_velocity: self
                .gyro
                .read_each([0.0, -state.pitch_rate, 0.0], normals.gyro),
            specific_force: self.accelerometer.read_each(
                specific_force(state, delta, derivatives, environment.gravity),
                normals.accelerometer,
            ),
            depth_pressure: self.depth.read(
                environment.pressure(depth_of(depth_port, state)),
                normals.depth,
            ),
            speed_pressure: self.speed.read(
                environment.dynamic_pressure(derivatives.speed),
                normals.speed,
            ),
        }
    }
}

/// The specific force at the centre of gravity, forward, left, up \[m/s^2\]. In body axes
/// forward, right, down, with `U` constant:
///
/// ```text
/// f_x = q w + g sin(theta)          f_z = w' - q U - g cos(theta)
/// ```
fn specific_force(state: &State, delta: f64, d: &Derivatives, g: f64) -> [f64; 3] {
    let State {
        pitch: theta,
        heave: w,
        pitch_rate: q,
        ..
    } = *state;
    let forward = q * w + g * theta.sin();
    let down = d.heave_acceleration(state, delta) - q * d.speed - g * theta.cos();
    [forward, 0.0, -down]
}

/// The depth \[m\] of a place on the hull.
fn depth_of(port: &Port, state: &State) -> f64 {
    state.depth - port.forward * state.pitch.sin() + port.below * state.pitch.cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{quantity::FOOT, vehicle_file::brunner};

    const FRESH: Environment = Environment {
        density: 999.835,
        gravity: 9.81456,
        atmospheric_pressure: 101_325.0,
    };

    fn perfect(state: &State, delta: f64, speed: f64) -> Readings {
        let vehicle = brunner();
        Sensors::default().read(
            state,
            delta,
            &vehicle.derivatives(speed),
            &FRESH,
            &vehicle.depth_port,
            &Noise::new(1).draw(),
        )
    }

    #[test]
    fn level_and_steady_the_accelerometers_feel_gravity_upwards() {
        let readings = perfect(&State::default(), 0.0, FOOT);
        assert_eq!(readings.specific_force, [0.0, 0.0, 9.81456]);
        assert_eq!(readings.angular_velocity, [0.0; 3]);
        assert_eq!(readings.depth_pressure, 101_325.0);
    }

    #[test]
    fn bow_up_gravity_pushes_from_behind_and_the_left_hand_gyro_turns_backwards() {
        let state = State {
            pitch: 0.3,
            pitch_rate: 0.1,
            depth: 5.0,
            ..State::default()
        };
        let readings = perfect(&state, 0.0, 0.0);
        assert!((readings.specific_force[0] - 9.81456 * 0.3_f64.sin()).abs() < 1e-12);
        assert_eq!(readings.angular_velocity[1], -0.1);
    }

    #[test]
    fn specific_force_is_the_acceleration_of_the_path_less_gravity() {
        // Differentiate the track velocity numerically and turn it into the body frame.
        let d = brunner().derivatives(FOOT);
        let state = State {
            depth: 5.0,
            pitch: -0.4,
            heave: 0.05,
            pitch_rate: 0.2,
            ..State::default()
        };
        let (delta, h) = (0.3, 1e-5);
        let velocity = |t: f64| {
            let rates: [f64; 5] = d.rates(&state, delta, crate::Restoring::Sine).into();
            let now: [f64; 5] = state.into();
            let then = State::from(std::array::from_fn::<f64, 5, _>(|i| now[i] + t * rates[i]));
            (d.track_speed(&then), d.depth_rate(&then))
        };
        let (after, before) = (velocity(h), velocity(-h));
        let (x, z) = (
            (after.0 - before.0) / (2.0 * h),
            (after.1 - before.1) / (2.0 * h) - FRESH.gravity,
        );
        let (sin, cos) = state.pitch.sin_cos();
        let [forward, _, up] = specific_force(&state, delta, &d, FRESH.gravity);
        assert!((forward - (x * cos - z * sin)).abs() < 1e-8);
        assert!((up + (x * sin + z * cos)).abs() < 1e-8);
    }

    #[test]
    fn three_inches_between_ports_are_half_an_inch_of_depth_at_ten_degrees() {
        // Brunner 1988, p. 64: why the port was moved.
        let state = State {
            depth: 1.0,
            pitch: 10_f64.to_radians(),
            ..State::default()
        };
        let port = |inches: f64| Port {
            forward: inches * crate::quantity::INCH,
            below: 0.0,
        };
        let shift = depth_of(&port(-2.5), &state) - depth_of(&port(0.5), &state);
        assert!((shift / crate::quantity::INCH - 0.52).abs() < 5e-3);
    }

    #[test]
    fn noise_has_the_bias_and_the_deviation_it_was_given() {
        let sensors = Sensors {
            gyro: Channel {
                bias: 0.5,
                noise: 0.1,
            },
            ..Sensors::default()
        };
        let vehicle = brunner();
        let mut noise = Noise::new(7);
        let count = 20_000;
        let readings: Vec<f64> = (0..count)
            .map(|_| {
                let normals = noise.draw();
                let d = vehicle.derivatives(FOOT);
                let port = &vehicle.depth_port;
                let state = State::default();
                sensors
                    .read(&state, 0.0, &d, &FRESH, port, &normals)
                    .angular_velocity[1]
            })
            .collect();
        let mean = readings.iter().sum::<f64>() / f64::from(count);
        let variance = readings.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / f64::from(count);
        assert!((mean - 0.5).abs() < 4e-3);
        assert!((variance.sqrt() - 0.1).abs() < 3e-3);
    }

    #[test]
    fn a_seed_gives_the_same_numbers_in_every_run() {
        let mut noise = Noise::new(1988);
        let first = noise.draw();
        let known = [-1.3303214241460202, 0.5976417695992623, -1.525637874311572];
        assert_eq!(first.gyro, known);
        assert_ne!(first, noise.draw());
        assert_ne!(first, Noise::new(1989).draw());
    }
}
