//! Describing functions and harmonic balance: analytical limit cycles.
//!
//! For an input A sin wt a nonlinearity is described by the first harmonic of its output, N(A). A cycle sustains itself in a loop with the
//! linear part H(jw) where
//!
//! ```text
//! 1 + N(A) H(jw) = 0
//! ```
//! (Gelb and Vander Velde, *Multiple-Input Describing Functions*, 1968, ch. 2 and 3). Two closed forms apply to the digital hydraulic
//! actuator:
//!
//! - **the quantizer** of the pulse logic: steps of delta_q that switch on at k delta_q + e_b and off at (k + 1) delta_q - e_b. Without
//!   leakage the loop rests in its dead zone; outside it the loop cycles through +-1 quantum;
//! - **the relay**, with leakage: the drift has the sign valve's polarity, so its mean vanishes only if the valve spends half its time on
//!   each side. The loop then stays half-way between two quantised positions and toggles: +-delta_q/2 with a hysteresis of +-(e_b - delta_q/2).

use planesman_linear::{Complex, ComplexFunctions as _, DelayedLoop};
use std::f64::consts::PI;

/// N of a quantizer with hysteresis at the amplitude `amplitude`, in the unit of `quantum` and `threshold`; zero below the threshold.
#[must_use]
pub fn quantizer(amplitude: f64, quantum: f64, threshold: f64) -> Complex<f64> {
    let mut sum = Complex::new(0.0, 0.0);
    let mut level = 0.0;
    while level + threshold < amplitude {
        let (on, off) = (
            (level + threshold) / amplitude,
            (level + quantum - threshold) / amplitude,
        );
        sum += Complex::new((1.0 - on * on).sqrt() + (1.0 - off * off).sqrt(), off - on);
        level += quantum;
    }
    sum * (2.0 * quantum / (PI * amplitude))
}

/// N of a relay with output +-`output` and switching points +-`hysteresis`; zero for a smaller amplitude.
#[must_use]
pub fn relay(amplitude: f64, output: f64, hysteresis: f64) -> Complex<f64> {
    let switches = hysteresis / amplitude;
    if switches > 1.0 {
        return Complex::new(0.0, 0.0);
    }
    Complex::new((1.0 - switches * switches).sqrt(), -switches) * (4.0 * output / (PI * amplitude))
}

/// Range of the search for a cycle: lower and upper end, not 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// The amplitudes searched, in the unit of the describing function's argument.
    pub amplitudes: (f64, f64),
    /// rad/s.
    pub frequencies: (f64, f64),
}

/// Best solution of the harmonic balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// A.
    pub amplitude: f64,
    /// rad/s.
    pub frequency: f64,
    /// |1 + N H|: 0 for a cycle, otherwise the distance from one.
    pub residual: f64,
}

/// Finds the amplitude and frequency with the smallest |1 + N(A, w) H(jw)| on a logarithmic grid, refined four times about the minimum.
#[must_use]
pub fn balance(
    search: &Search,
    describing_function: impl Fn(f64, f64) -> Complex<f64>,
    rest: impl Fn(f64) -> Complex<f64>,
) -> Balance {
    const GRID: i32 = 12;
    const DRAWN_CLOSER: usize = 4;
    let span = |(from, to): (f64, f64)| libm::pow(to / from, 1.0 / f64::from(GRID));
    let mut ratios = [span(search.amplitudes), span(search.frequencies)];
    let mut best = Balance {
        amplitude: search.amplitudes.0,
        frequency: search.frequencies.0,
        residual: f64::INFINITY,
    };
    let look = |best: &mut Balance, amplitude: f64, frequency: f64| {
        let residual =
            (describing_function(amplitude, frequency) * rest(frequency) + 1.0).modulus();
        if residual < best.residual {
            *best = Balance {
                amplitude,
                frequency,
                residual,
            };
        }
    };
    for i in 0..=GRID {
        for j in 0..=GRID {
            look(
                &mut best,
                search.amplitudes.0 * ratios[0].powi(i),
                search.frequencies.0 * ratios[1].powi(j),
            );
        }
    }
    for _ in 0..DRAWN_CLOSER {
        ratios = ratios.map(|ratio| libm::pow(ratio, 1.0 / 3.0));
        let about = best;
        for (i, j) in (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))) {
            look(
                &mut best,
                about.amplitude * ratios[0].powi(i),
                about.frequency * ratios[1].powi(j),
            );
        }
    }
    best
}

/// The limit cycle, if there is one, of an actuator with leakage and the open loop `rest`: the actuator toggles between two positions `quantum`
/// apart, in rad. The number of volumes per second is twice the cycle's frequency.
#[must_use]
pub fn toggling(rest: &DelayedLoop, quantum: f64, threshold: f64) -> Balance {
    let hysteresis = threshold - 0.5 * quantum;
    balance(
        &Search {
            amplitudes: (1.01 * hysteresis, 4.0 * quantum),
            frequencies: (6.0, 90.0),
        },
        |amplitude, _| relay(amplitude, 0.5 * quantum, hysteresis),
        |frequency| rest.at(frequency),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use crate::pulse_logic::{PulseLogic, Volume};
    use planesman_linear::polar;
    use planesman_units::DEGREE;

    #[test]
    fn the_quantizers_describing_function_is_the_pulse_logics_first_harmonic() {
        let mut set = load("auv").unwrap();
        set.inhibit_beyond = f64::INFINITY;
        for amplitude in [0.35, 0.7, 1.0, 2.6, 8.0] {
            let (mut logic, mut level, mut before) = (PulseLogic::new(&set), 0.0, 0.0);
            let mut harmonic = Complex::new(0.0, 0.0);
            let samples = 40_000;
            for i in 0..2 * samples {
                let angle = f64::from(i) / f64::from(samples) * 2.0 * PI;
                let asked = amplitude * DEGREE * libm::sin(angle);
                let command = logic.accumulate(asked - before, 0.0).command;
                before = asked;
                if command.volume != Volume::None {
                    level += f64::from(command.sign) * set.quantum;
                }
                if i >= samples {
                    harmonic += polar(level, -angle);
                }
            }
            let found =
                harmonic * Complex::new(0.0, 2.0 / f64::from(samples)) / (amplitude * DEGREE);
            let formula = quantizer(amplitude * DEGREE, set.quantum, set.threshold);
            assert!((found - formula).modulus() < 2e-3, "{found} for {formula}");
        }
    }

    #[test]
    fn a_coarse_signal_passes_the_quantizer_as_it_is_and_a_small_one_not_at_all() {
        let large = quantizer(200.0, 0.5, 0.3125);
        assert!((large - 1.0).modulus() < 2e-3, "{large}");
        assert_eq!(quantizer(0.3, 0.5, 0.3125).modulus(), 0.0);
        assert_eq!(relay(0.1, 1.0, 0.2).modulus(), 0.0);
    }

    #[test]
    fn a_relay_with_hysteresis_around_a_double_lag_cycles_where_tsypkin_says_roughly() {
        // L = 1/(s (s + 1)); -1/N has the imaginary part -pi h/(4 M) whatever the amplitude.
        let (output, hysteresis) = (1.0, 0.1);
        let found = balance(
            &Search {
                amplitudes: (0.1001, 10.0),
                frequencies: (0.1, 10.0),
            },
            |a, _| relay(a, output, hysteresis),
            |w| {
                let s = Complex::new(0.0, w);
                Complex::from(1.0) / (s * (s + 1.0))
            },
        );
        assert!(found.residual < 0.01, "{found:?}");
        let w = found.frequency;
        assert!((1.0 / (w * (1.0 + w * w)) / (PI * hysteresis / 4.0) - 1.0).abs() < 0.03);
    }
}
