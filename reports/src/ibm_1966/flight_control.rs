//! Flight control of Figure 5-5 with the linear actuator (IBM 66-L03-005, Section V), and the full, quantised one under sinusoids for comparison.
//!
//! With K_i = K f_c and P = psi/delta:
//!
//! ```text
//! psi/(K_2 N_y) = K_g K_a (1 + K_i/s) A P/(1 + L),    L = K_g [K_b K_a (1 + K_i/s) + K_r s] A P
//! P = [mu_delta (s + Y_beta) + mu_beta Y_delta]/{s [s^2 + Y_beta s - mu_beta]}
//! ```
//!
//! **Do not read gain margins from the linear model**: friction and the force limit halve them.

use std::f64::consts::TAU;

use planesman_hydraulics::ActuatorSet;
use planesman_hydraulics::frequency_response::{Harmonic, Periods};
use planesman_hydraulics::linearised::{Ram, actuator};
use planesman_linear::{
    Complex, ComplexFunctions as _, DelayedLoop, Error, TransferFunction, polynomial,
};

use crate::ibm_1966::autopilot::{Gains, PULSE};
use crate::ibm_1966::case::Case;
use crate::ibm_1966::digital_loop::Start;
use crate::ibm_1966::missile::YawPlant;

/// The flight control of Figure 5-5.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightControl {
    /// Open loop L, broken at the actuator.
    pub open_loop: DelayedLoop,
    /// Forward path K_g K_a (1 + K_i/s) A P, from steering angle to yaw angle without feedback.
    pub forward: DelayedLoop,
}

impl FlightControl {
    /// Flight control of a missile, an autopilot and an actuator.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn new(
        plant: &YawPlant,
        gains: &Gains,
        set: &ActuatorSet,
        ram: Ram,
    ) -> Result<Self, Error> {
        let integral = gains.compensation / set.cycle();
        let forward = gains.overall * gains.attitude;
        let through = |num: Vec<f64>| -> Result<DelayedLoop, Error> {
            let actuator = actuator(set, ram)?;
            Ok(DelayedLoop {
                transfer_function: TransferFunction::new(num, vec![1.0, 0.0])?
                    .series(&plant.transfer_function()?)?
                    .series(&actuator.transfer_function)?,
                ..actuator
            })
        };
        Ok(Self {
            open_loop: through(vec![
                gains.overall * gains.rate,
                gains.yaw * forward,
                gains.yaw * forward * integral,
            ])?,
            forward: through(vec![forward, forward * integral])?,
        })
    }

    /// psi/(K_2 N_y) at a frequency, rad/s, with the exact dead time.
    #[must_use]
    pub fn response(&self, frequency: f64) -> Complex<f64> {
        self.forward.at(frequency) / (self.open_loop.at(frequency) + 1.0)
    }

    /// psi/(K_2 N_y) with a Padé approximation of the dead time.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn closed_loop(&self) -> Result<TransferFunction, Error> {
        let (forward, open) = (self.forward.rational()?, self.open_loop.rational()?);
        // The two have the same denominator.
        TransferFunction::new(forward.num, polynomial::sum(&open.den, &open.num))
    }

    /// Resonance, `(rad/s, magnitude)`: the largest response between two frequencies, on a logarithmic grid of 2000 points.
    #[must_use]
    pub fn peak(&self, lowest: f64, highest: f64) -> (f64, f64) {
        logarithmic(lowest, highest)
            .map(|w| (w, self.response(w).modulus()))
            .fold((lowest, 0.0), |a, b| if b.1 > a.1 { b } else { a })
    }

    /// Bandwidth, rad/s: the last frequency in the range at which the response falls below 1/sqrt(2), on the same grid.
    #[must_use]
    pub fn bandwidth(&self, lowest: f64, highest: f64) -> Option<f64> {
        logarithmic(lowest, highest)
            .filter(|w| self.response(*w).modulus() > std::f64::consts::FRAC_1_SQRT_2)
            .last()
    }

    /// Step response psi/(K_2 N_y) at times 0, `dt`, ... up to `end`, s, with a Padé approximation of the dead time.
    ///
    /// # Errors
    /// Those of [`planesman_linear::StateSpace::zero_order_hold`].
    pub fn step(&self, dt: f64, end: f64) -> Result<Vec<f64>, Error> {
        let held = self.closed_loop()?.companion()?.zero_order_hold(dt)?;
        let mut state = planesman_linear::DMatrix::zeros(held.a.nrows(), 1);
        Ok((0..=(end / dt) as usize)
            .map(|_| {
                let output = (&held.c * &state + &held.d)[(0, 0)];
                state = &held.a * &state + &held.b;
                output
            })
            .collect())
    }
}

/// 2000 logarithmically spaced frequencies.
fn logarithmic(lowest: f64, highest: f64) -> impl Iterator<Item = f64> {
    const POINTS: i32 = 2000;
    let ratio = libm::pow(highest / lowest, 1.0 / f64::from(POINTS - 1));
    (0..POINTS).map(move |i| lowest * ratio.powi(i))
}

/// psi/(K_2 N_y) of the full flight control for steering `pulses` sin wt, w in rad/s.
#[must_use]
pub fn full_response(case: &Case, pulses: f64, frequency: f64, periods: Periods) -> Complex<f64> {
    let mut control = case.fly(Start::default());
    let mut harmonic = Harmonic::new(frequency);
    let period = TAU / frequency;
    let from = f64::from(periods.settling) * period;
    let until = from + f64::from(periods.measured) * period;
    while control.time() < until {
        let steering = pulses * libm::sin(frequency * control.time());
        control.cycle(steering, |instant| {
            if instant.time >= from && instant.time < until {
                harmonic.add(instant.time, instant.yaw.angle);
            }
        });
    }
    harmonic.phasor() / (pulses * PULSE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ibm_1966::missile::Surrogate;
    use planesman_hydraulics::actuator_file::load;
    use planesman_hydraulics::describing_function::toggling;
    use planesman_testing::near;
    use planesman_units::DEGREE;
    use std::f64::consts::PI;

    /// The flight control on PS-2 with K = 2^-`k`.
    fn flight_control(k: i32, ram: Ram) -> FlightControl {
        let surrogate = Surrogate::Ps2;
        let gains = Gains {
            compensation: 0.5f64.powi(k),
            ..Gains::new(surrogate)
        };
        let polaris = load("table_4_1").unwrap();
        FlightControl::new(&surrogate.plant(), &gains, &polaris, ram).unwrap()
    }

    #[track_caller]
    #[test]
    fn the_loop_crosses_over_with_43_degrees_to_spare() {
        let margins = flight_control(7, Ram::Rigid).open_loop.phase_margins();
        let [margin] = margins.unwrap()[..] else {
            panic!("one crossover");
        };
        near(margin.frequency, 8.787, 0.01);
        near(margin.margin / DEGREE, 43.537, 0.01);
    }

    #[test]
    fn the_loop_is_stable_between_two_gains_and_the_ram_lowers_the_upper_one() {
        let margins = flight_control(7, Ram::Rigid)
            .open_loop
            .gain_margins(0.5, 150.0);
        let [low, high] = margins[..] else {
            panic!("{margins:?}");
        };
        near(low.frequency, 2.347, 0.01);
        near(low.factor, 0.3475, 0.001);
        near(high.frequency, 90.52, 0.05);
        near(high.factor, 10.425, 0.01);
        let riding = flight_control(7, Ram::OnItsOil)
            .open_loop
            .gain_margins(10.0, 500.0);
        let least = riding.iter().map(|m| m.factor).fold(f64::MAX, f64::min);
        near(least, 8.6, 0.1);
    }

    #[test]
    fn the_compensation_decides_how_the_loop_resonates() {
        for (k, peak, tolerance) in [
            (7, 1.639_3, 0.001),
            (5, 3.12, 0.01),
            (9, 1.43, 0.01),
            (16, 1.37, 0.01),
        ] {
            near(
                flight_control(k, Ram::Rigid).peak(0.5, 30.0).1,
                peak,
                tolerance,
            );
        }
        let base = flight_control(7, Ram::Rigid);
        near(base.peak(0.5, 30.0).0, 3.523_25, 0.01);
        near(base.bandwidth(0.5, 30.0).unwrap(), 9.602, 0.02);
        let fast = flight_control(5, Ram::Rigid).open_loop.phase_margins();
        near(fast.unwrap()[0].margin / DEGREE, 33.3, 0.1);
    }

    #[test]
    fn a_step_of_steering_overshoots_by_half_after_six_tenths_of_a_second() {
        let dt = 1e-3;
        let step = flight_control(7, Ram::Rigid).step(dt, 3.0).unwrap();
        let (at, peak) = step
            .iter()
            .enumerate()
            .fold((0, 0.0), |a, (i, y)| if *y > a.1 { (i, *y) } else { a });
        near(at as f64 * dt, 0.574, 0.005);
        near(peak, 1.550, 0.005);
    }

    #[test]
    fn the_frequency_response_of_the_base_case() {
        let base = flight_control(7, Ram::Rigid);
        for (hertz, decibels, degrees) in [
            (0.2, 2.88, -1.0),
            (0.5, 4.26, -35.0),
            (0.8, 3.73, -70.0),
            (1.0, 2.37, -92.0),
            (1.5, -2.7, -131.0),
        ] {
            let response = base.response(std::f64::consts::TAU * hertz);
            near(20.0 * libm::log10(response.modulus()), decibels, 0.06);
            near(response.argument() / DEGREE, degrees, 0.6);
        }
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
            let found = full_response(&case, pulses, TAU * hertz, Periods::default());
            let (gain, phase) = (
                20.0 * libm::log10(found.modulus()),
                found.argument() / DEGREE,
            );
            assert!((gain - decibels).abs() < 0.15, "{pulses} {hertz}: {gain}");
            assert!((phase - degrees).abs() < 1.5, "{pulses} {hertz}: {phase}");
        }
    }

    #[test]
    fn with_leakage_the_missiles_loop_toggles_ten_times_a_second_for_its_dead_time_alone() {
        let set = load("table_4_1").unwrap();
        let surrogate = Surrogate::Ps2;
        let gains = Gains::new(surrogate);
        let control = FlightControl::new(&surrogate.plant(), &gains, &set, Ram::Rigid).unwrap();
        let quantum = set.quantum;
        let cycle = |delay: f64| {
            let mut rest = control.open_loop.clone();
            rest.delay += delay;
            toggling(&rest, quantum, 0.625 * quantum)
        };
        for (lag, toggles) in [(0.0, 10.4), (0.022, 6.46)] {
            let found = cycle(lag);
            assert!(found.residual < 0.01, "{found:?}");
            assert!(
                (found.frequency / PI / toggles - 1.0).abs() < 0.01,
                "{found:?}"
            );
        }
        // With the lag of the ram against friction, 0.0101 degrees of yaw from peak to peak.
        let s = Complex::new(0.0, cycle(0.022).frequency);
        let plant = surrogate.plant().transfer_function().unwrap();
        let yaw = 2.0 * (2.0 / PI * quantum) * plant.value_at(s).modulus();
        assert!(
            (yaw / DEGREE / 0.0101 - 1.0).abs() < 0.05,
            "{}",
            yaw / DEGREE
        );
    }
}
