//! Response of the full quantized model to sinusoids: gain and phase of the first harmonic.
//!
//! The ratio of the output's first harmonic to the input sinusoid is the model's describing function at this frequency and amplitude. The response is
//! measured over whole periods after the transient, for comparison with the linear model of [`crate::linearised`].

use planesman_linear::polar;
use std::f64::consts::TAU;

use planesman_linear::Complex;

use crate::actuator_set::ActuatorSet;
use crate::dha::{Demand, Dha};

/// First harmonic of samples over whole periods.
#[derive(Clone, Copy, Debug)]
pub struct Harmonic {
    frequency: f64,
    sum: Complex<f64>,
    samples: u32,
}

impl Harmonic {
    /// Returns an empty sum at `frequency`, rad/s.
    #[must_use]
    pub fn new(frequency: f64) -> Self {
        Self {
            frequency,
            sum: Complex::new(0.0, 0.0),
            samples: 0,
        }
    }

    /// Adds the sample `value` at `time`, s.
    pub fn add(&mut self, time: f64, value: f64) {
        self.sum += polar(value, -self.frequency * time);
        self.samples += 1;
    }

    /// c such that the imaginary part of c e^(jwt) is the harmonic; 1 for sin wt.
    #[must_use]
    pub fn phasor(&self) -> Complex<f64> {
        self.sum * Complex::new(0.0, 2.0 / f64::from(self.samples))
    }
}

/// Numbers of periods of the sinusoid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Periods {
    /// Before the measurement, until the transient has decayed.
    pub settling: u32,
    /// Within the measurement.
    pub measured: u32,
}

impl Default for Periods {
    fn default() -> Self {
        Self {
            settling: 4,
            measured: 12,
        }
    }
}

/// delta_a/delta_c of the actuator alone under `demand`. The demanded angle, rad, is the amplitude of a sinusoid of `frequency`, rad/s,
/// sampled at every valve cycle. The angle is read 16 times in a valve cycle; for slow sinusoids at most 1000 times in a period.
#[must_use]
pub fn actuator(
    set: &ActuatorSet,
    demand: Demand,
    frequency: f64,
    periods: Periods,
) -> Complex<f64> {
    const MOST_SAMPLES: f64 = 16.0;
    const IN_A_PERIOD: f64 = 1000.0;
    let mut dha = Dha::new(set);
    let mut harmonic = Harmonic::new(frequency);
    let period = TAU / frequency;
    let samples = (IN_A_PERIOD * set.cycle() / period)
        .ceil()
        .min(MOST_SAMPLES) as u32;
    let from = f64::from(periods.settling) * period;
    let until = from + f64::from(periods.measured) * period;
    let mut sample = 0u32;
    loop {
        let cycle_begin = f64::from(sample) / f64::from(samples) * set.cycle();
        let asked = Demand {
            angle: demand.angle * libm::sin(frequency * cycle_begin),
            ..demand
        };
        for i in 0..samples {
            sample += 1;
            let time = f64::from(sample) / f64::from(samples) * set.cycle();
            if time >= until {
                return harmonic.phasor() / demand.angle;
            }
            // The next cycle waits for its own demand.
            let nanos = (time * 1e9).floor() as i64 - i64::from(i + 1 == samples);
            dha.advance_to(nanos, asked);
            if time >= from {
                harmonic.add(time, dha.angle(nanos));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use crate::linearised::{self, Ram};
    use planesman_linear::ComplexFunctions as _;
    use planesman_units::DEGREE;

    #[test]
    fn the_first_harmonic_of_a_delayed_sine_with_an_offset() {
        let frequency = 3.0;
        let mut harmonic = Harmonic::new(frequency);
        for i in 0..1000 {
            let t = f64::from(i) / 1000.0 * 5.0 * TAU / frequency;
            harmonic.add(t, 0.7 + 2.0 * libm::sin(frequency * t - 0.4));
        }
        let phasor = harmonic.phasor();
        assert!((phasor.modulus() - 2.0).abs() < 1e-9);
        assert!((phasor.argument() + 0.4).abs() < 1e-9);
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
        assert!(
            (found.modulus() / linear.modulus() - 1.0).abs() < 0.05,
            "{found}"
        );
        // The dead zone of the position loop and the stiction band: 0.43 degrees of 10.
        let lag = (linear / found).argument() / DEGREE;
        assert!((0.0..5.0).contains(&lag), "{lag}");
    }
}
