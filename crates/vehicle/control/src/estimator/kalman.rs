//! Estimates pitch, depth rate and the gyro's zero by an extended Kalman filter on gyro, depth and speed.
//!
//! The gyro is the input, the depth the measurement:
//!
//! ```text
//! theta' = q_gyro - b - n_q           b: the gyro's zero
//! b'     = n_b                        it wanders
//! z'     = v - U sin(theta)           a bow down goes down
//! v'     = -v / T_v + n_v             what heave and currents add to that
//!
//! z_measured = z + n_z
//! ```
//! A zero that is not subtracted turns the estimated pitch, so the predicted depth deviates from the measured one: the depth reveals both
//! pitch and zero while the vehicle moves. At `U = 0` it reveals neither, and the covariance grows accordingly.
//!
//! Within a sample the gyro is assumed to be linear in time. The update is Joseph's, which keeps the covariance symmetric and positive
//! (Gelb, *Applied Optimal Estimation*, 1974, ch. 4 and 8).

use nalgebra::{Matrix4, RowVector4, Vector4};

use super::motion::{Estimate, Measurement};

/// The indices of the state vector `(theta, b, z, v)`.
const PITCH: usize = 0;
const BIAS: usize = 1;
const DEPTH: usize = 2;
const STRAY: usize = 3;

/// The largest pitch at which the model is linearised, rad: beyond it the depth contains little information on pitch.
const STEEPEST: f64 = 1.4;

/// The standard deviations of the filter: the parameters `kalman.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct Tuning {
    /// Standard deviation of a gyro reading; 5 mV at 12.5 mV per deg/s.
    #[parameter(default = 0.007, unit = "rad/s", range = 1e-9..=10.0)]
    pub gyro_noise: f64,
    /// Standard deviation of the random walk of the gyro bias after 1 s; 1 mV.
    #[parameter(default = 0.0014, unit = "rad/s^1.5", range = 0.0..=10.0)]
    pub bias_walk: f64,
    /// Standard deviation of a depth reading; 5 mV at 10.1 V/m.
    #[parameter(default = 0.0005, unit = "m", range = 1e-9..=100.0)]
    pub depth_noise: f64,
    /// Standard deviation of the depth rate not caused by pitch: heave and current.
    #[parameter(default = 0.01, unit = "m/s", range = 0.0..=100.0)]
    pub stray_rate: f64,
    /// Correlation time of the depth rate not caused by pitch.
    #[parameter(default = 2.0, unit = "s", range = 1e-3..=1e6)]
    pub stray_time: f64,
    /// Standard deviation of the initial pitch, whose mean is 0 (level).
    #[parameter(default = 0.05, unit = "rad", range = 0.0..=3.0)]
    pub initial_pitch: f64,
    /// Standard deviation of the initial gyro bias; 25 mV.
    #[parameter(default = 2.0_f64.to_radians(), unit = "rad/s", range = 0.0..=10.0)]
    pub initial_bias: f64,
}

/// The filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kalman {
    tuning: Tuning,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    x: Vector4<f64>,
    p: Matrix4<f64>,
    /// The last gyro reading, rad/s.
    gyro: f64,
}

impl Kalman {
    /// A filter before the first measurement; the vehicle is then assumed to be level.
    #[must_use]
    pub(crate) fn new(tuning: Tuning) -> Self {
        Self {
            tuning,
            state: None,
        }
    }

    /// Uses changed standard deviations from the next measurement on.
    pub(crate) fn set_tuning(&mut self, tuning: Tuning) {
        self.tuning = tuning;
    }

    /// The estimate at a measurement `dt` seconds after the last.
    pub(crate) fn step(&mut self, measured: &Measurement, dt: f64) -> Estimate {
        let mut next = match self.state {
            None => self.first(measured),
            Some(last) => self.predict(&last, measured, dt),
        };
        if let Some(depth) = measured.depth {
            self.update(&mut next, depth);
        }
        // A filter driven out of all bounds begins again rather than pass on what is no number.
        if !(next.x.iter().chain(next.p.iter())).all(|number| number.is_finite()) {
            next = self.first(measured);
        }
        self.state = Some(next);
        Estimate {
            pitch: next.x[PITCH],
            pitch_rate: measured.pitch_rate - next.x[BIAS],
            depth: next.x[DEPTH],
            depth_rate: next.x[STRAY] - measured.speed * libm::sin(next.x[PITCH]),
            gyro_bias: next.x[BIAS],
        }
    }

    /// The covariance of `(pitch, gyro zero, depth, stray depth rate)`, row by row; `None` before the
    /// first measurement.
    #[must_use]
    pub(crate) fn covariance(&self) -> Option<[f64; 16]> {
        let p = self.state?.p;
        Some(std::array::from_fn(|i| p[(i / 4, i % 4)]))
    }

    fn first(&self, measured: &Measurement) -> State {
        let t = &self.tuning;
        // A depth not measured yet may be anything within a kilometre.
        let depth_deviation = measured.depth.map_or(1e3, |_| t.depth_noise);
        let deviations = Vector4::new(
            t.initial_pitch,
            t.initial_bias,
            depth_deviation,
            t.stray_rate,
        );
        State {
            x: Vector4::new(0.0, 0.0, measured.depth.unwrap_or(0.0), 0.0),
            p: Matrix4::from_diagonal(&deviations.map(|sigma| sigma * sigma)),
            gyro: measured.pitch_rate,
        }
    }

    /// `x(t + dt)` and its covariance `F P F' + Q`.
    fn predict(&self, last: &State, measured: &Measurement, dt: f64) -> State {
        let t = &self.tuning;
        let (x, u) = (&last.x, measured.speed);
        let rate = 0.5 * (last.gyro + measured.pitch_rate) - x[BIAS];
        let halfway = x[PITCH] + 0.5 * rate * dt;
        let kept = libm::exp(-dt / t.stray_time);
        let (sin, cos) = libm::sincos(halfway.clamp(-STEEPEST, STEEPEST));
        let next = Vector4::new(
            x[PITCH] + rate * dt,
            x[BIAS],
            x[DEPTH] + (x[STRAY] - u * sin) * dt,
            kept * x[STRAY],
        );
        let per_pitch = -u * cos * dt;
        #[rustfmt::skip]
        let f = Matrix4::new(
            1.0,       -dt,                   0.0, 0.0,
            0.0,       1.0,                   0.0, 0.0,
            per_pitch, -0.5 * dt * per_pitch, 1.0, dt,
            0.0,       0.0,                   0.0, kept,
        );
        let q = Vector4::new(
            (t.gyro_noise * dt).powi(2),
            t.bias_walk.powi(2) * dt,
            0.0,
            t.stray_rate.powi(2) * (1.0 - kept * kept),
        );
        State {
            x: next,
            p: f * last.p * f.transpose() + Matrix4::from_diagonal(&q),
            gyro: measured.pitch_rate,
        }
    }

    /// `x` and `P` after a depth reading.
    fn update(&self, state: &mut State, depth: f64) {
        let r = self.tuning.depth_noise.powi(2);
        let h = RowVector4::new(0.0, 0.0, 1.0, 0.0);
        let gain = state.p.column(DEPTH) / (state.p[(DEPTH, DEPTH)] + r);
        state.x += gain * (depth - state.x[DEPTH]);
        let left = Matrix4::identity() - gain * h;
        state.p = left * state.p * left.transpose() + gain * gain.transpose() * r;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TUNING: Tuning = Tuning {
        gyro_noise: 0.007,
        bias_walk: 0.0014,
        depth_noise: 0.0005,
        stray_rate: 0.01,
        stray_time: 2.0,
        initial_pitch: 0.05,
        initial_bias: 0.035,
    };
    const DT: f64 = 0.05;

    /// A vehicle at `speed` that pitches by `0.2 sin(0.5 t)`, seen by a gyro with a zero of 2 deg/s.
    fn run(speed: f64, seconds: f64) -> (Kalman, Estimate, f64) {
        let bias = 2_f64.to_radians();
        let (mut filter, mut depth, mut last) = (Kalman::new(TUNING), 1.0, Estimate::default());
        let pitch = |t: f64| 0.2 * libm::sin(0.5 * t);
        let steps = (seconds / DT) as u32;
        for k in 0..=steps {
            let t = f64::from(k) * DT;
            last = filter.step(
                &Measurement {
                    pitch_rate: 0.1 * libm::cos(0.5 * t) + bias,
                    depth: Some(depth),
                    speed,
                },
                DT,
            );
            depth -= speed * libm::sin(pitch(t + 0.5 * DT)) * DT;
        }
        (filter, last, pitch(f64::from(steps) * DT))
    }

    #[test]
    fn under_way_the_depth_shows_the_gyros_zero_and_the_pitch() {
        let (_, estimate, pitch) = run(0.5, 60.0);
        assert!(
            (estimate.gyro_bias - 2_f64.to_radians()).abs() < 2e-3,
            "{estimate:?}"
        );
        assert!(
            (estimate.pitch - pitch).abs() < 0.01,
            "{estimate:?} {pitch}"
        );
        assert!((estimate.depth_rate + 0.5 * libm::sin(pitch)).abs() < 0.005);
    }

    #[test]
    fn at_rest_the_filter_says_that_it_does_not_know_the_pitch() {
        let sigma = |(filter, ..): (Kalman, Estimate, f64)| {
            filter.covariance().map_or(0.0, |p| p[0].sqrt())
        };
        let (resting, moving) = (sigma(run(0.0, 60.0)), sigma(run(0.5, 60.0)));
        assert!(resting > 1.0, "{resting}");
        assert!(moving < 0.05, "{moving}");
    }

    #[test]
    fn the_error_is_what_the_covariance_says() {
        let (filter, estimate, pitch) = run(0.5, 60.0);
        let p = filter.covariance().unwrap_or_default();
        assert!((estimate.pitch - pitch).abs() < 3.0 * p[0].sqrt());
        assert!((estimate.gyro_bias - 2_f64.to_radians()).abs() < 3.0 * p[5].sqrt());
        for i in 0..4 {
            for j in 0..4 {
                assert!((p[4 * i + j] - p[4 * j + i]).abs() <= 1e-12 * p[5 * i].max(p[5 * j]));
            }
        }
    }

    #[test]
    fn without_depth_it_goes_on_by_gyro_and_speed() {
        let (mut filter, before, _) = run(0.5, 60.0);
        let mut after = before;
        for _ in 0..100 {
            let measured = Measurement {
                pitch_rate: before.gyro_bias,
                depth: None,
                speed: 0.5,
            };
            after = filter.step(&measured, DT);
        }
        assert!((after.pitch - before.pitch).abs() < 0.05);
        let sunk = after.depth - before.depth;
        assert!(
            (sunk + 0.5 * libm::sin(before.pitch) * 5.0).abs() < 0.15,
            "{sunk}"
        );
    }

    #[test]
    fn huge_readings_do_not_make_it_say_what_is_no_number() {
        let mut filter = Kalman::new(TUNING);
        for reading in [1e300, -1e300, f64::MAX, 0.0] {
            let measured = Measurement {
                pitch_rate: reading,
                depth: Some(reading),
                speed: 1e3,
            };
            let estimate = filter.step(&measured, DT);
            assert!(estimate.pitch.is_finite() && estimate.depth.is_finite());
        }
    }
}
