//! The full, quantized model under sinusoids: gain and phase of the first harmonic.
//!
//! The first harmonic of what comes out, beside the sinusoid that goes in, is the model's describing
//! function at that frequency and amplitude. It is read over whole periods after the start has died
//! away, and stands beside the linear model of [`crate::linearised`].

use std::f64::consts::TAU;

use planesman_linear::Complex;

use crate::actuator_set::ActuatorSet;
use crate::bench::autopilot::PULSE;
use crate::bench::case::Case;
use crate::bench::digital_loop::Start;
use crate::dha::{Demand, Dha};

/// The first harmonic of samples taken over whole periods.
#[derive(Clone, Copy, Debug)]
struct Harmonic {
    frequency: f64,
    sum: Complex<f64>,
    samples: u32,
}

impl Harmonic {
    /// At `frequency`, rad/s.
    fn new(frequency: f64) -> Self {
        Self {
            frequency,
            sum: Complex::new(0.0, 0.0),
            samples: 0,
        }
    }

    fn add(&mut self, time: f64, value: f64) {
        self.sum += Complex::from_polar(value, -self.frequency * time);
        self.samples += 1;
    }

    /// c of c e^(jwt), whose imaginary part is the harmonic: 1 for sin wt.
    fn phasor(&self) -> Complex<f64> {
        self.sum * Complex::new(0.0, 2.0 / f64::from(self.samples))
    }
}

/// How long a sinusoid is applied before it is listened to, and then, in periods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Periods {
    /// Before.
    pub settling: u32,
    /// Listened to.
    pub heard: u32,
}

impl Default for Periods {
    fn default() -> Self {
        Self {
            settling: 4,
            heard: 12,
        }
    }
}

/// psi/(K_2 N_y) of the whole flight control under `pulses` sin wt of steering, w in rad/s.
#[must_use]
pub fn flight_control(case: &Case, pulses: f64, frequency: f64, periods: Periods) -> Complex<f64> {
    let mut control = case.fly(Start::default());
    let mut harmonic = Harmonic::new(frequency);
    let period = TAU / frequency;
    let from = f64::from(periods.settling) * period;
    let until = from + f64::from(periods.heard) * period;
    while control.time() < until {
        let steering = pulses * (frequency * control.time()).sin();
        control.cycle(steering, |instant| {
            if instant.time >= from && instant.time < until {
                harmonic.add(instant.time, instant.yaw.angle);
            }
        });
    }
    harmonic.phasor() / (pulses * PULSE)
}

/// delta_a/delta_c of the actuator alone under `demand`, its angle being the amplitude, rad, of a
/// sinusoid of `frequency`, rad/s, which is sampled at every valve cycle.
#[must_use]
pub fn actuator(
    set: &ActuatorSet,
    demand: Demand,
    frequency: f64,
    periods: Periods,
) -> Complex<f64> {
    const SAMPLES_IN_A_CYCLE: u32 = 16;
    let mut dha = Dha::new(set);
    let mut harmonic = Harmonic::new(frequency);
    let period = TAU / frequency;
    let from = f64::from(periods.settling) * period;
    let until = from + f64::from(periods.heard) * period;
    let mut sample = 0u32;
    loop {
        let cycle_begin = f64::from(sample) / f64::from(SAMPLES_IN_A_CYCLE) * set.cycle();
        let asked = Demand {
            angle: demand.angle * (frequency * cycle_begin).sin(),
            ..demand
        };
        for i in 0..SAMPLES_IN_A_CYCLE {
            sample += 1;
            let time = f64::from(sample) / f64::from(SAMPLES_IN_A_CYCLE) * set.cycle();
            if time >= until {
                return harmonic.phasor() / demand.angle;
            }
            // The next cycle waits for its own demand.
            let nanos = (time * 1e9).floor() as i64 - i64::from(i + 1 == SAMPLES_IN_A_CYCLE);
            dha.advance_to(nanos, asked);
            if time >= from {
                harmonic.add(time, dha.plane_angle(&dha.reading(nanos)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::actuator_file::load;
    use crate::bench::missile::Surrogate;
    use crate::linearised::{self, Ram};
    use crate::units::DEGREE;

    #[test]
    fn the_first_harmonic_of_a_delayed_sine_with_an_offset() {
        let frequency = 3.0;
        let mut harmonic = Harmonic::new(frequency);
        for i in 0..1000 {
            let t = f64::from(i) / 1000.0 * 5.0 * TAU / frequency;
            harmonic.add(t, 0.7 + 2.0 * (frequency * t - 0.4).sin());
        }
        let phasor = harmonic.phasor();
        assert!((phasor.norm() - 2.0).abs() < 1e-9);
        assert!((phasor.arg() + 0.4).abs() < 1e-9);
    }

    #[test]
    fn many_quanta_below_its_rate_the_actuator_is_the_linear_one_with_friction_behind_it() {
        let set = load("auv").unwrap();
        let frequency = TAU * 0.2;
        let found = actuator(
            &set,
            Demand::angle(10.0 * DEGREE),
            frequency,
            Periods::default(),
        );
        let linear = linearised::actuator(&set, Ram::OnItsOil)
            .unwrap()
            .at(frequency);
        assert!((found.norm() / linear.norm() - 1.0).abs() < 0.05, "{found}");
        // The dead zone of the position loop and the stiction band: 0.43 degrees of 10.
        let lag = (linear / found).arg() / DEGREE;
        assert!((0.0..5.0).contains(&lag), "{lag}");
    }

    #[test]
    fn the_missile_follows_slow_steering_about_as_the_linear_model_says() {
        let set = load("table_4_1").unwrap();
        let case = Case::new(Surrogate::Ps2, set);
        for (pulses, hertz, decibels, degrees) in [
            (2.0, 0.2, 2.1, -2.0),
            (4.0, 0.2, 2.5, -3.0),
            (4.0, 0.5, 4.0, -30.0),
            (4.0, 1.0, 3.6, -90.0),
        ] {
            let found = flight_control(&case, pulses, TAU * hertz, Periods::default());
            let (gain, phase) = (20.0 * found.norm().log10(), found.arg() / DEGREE);
            assert!((gain - decibels).abs() < 0.15, "{pulses} {hertz}: {gain}");
            assert!((phase - degrees).abs() < 1.5, "{pulses} {hertz}: {phase}");
        }
    }
}
