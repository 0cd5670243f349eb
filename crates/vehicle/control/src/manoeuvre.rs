//! Test signals on the dive planes: step, pulse, doublet, square wave, sinusoid, pseudo-random
//! binary sequence and chirp.
//!
//! A signal is a pure function of the time since the run began, counted in whole nanoseconds so that no edge moves by rounding. The signal is zero
//! before `start`, and from `start + duration` on if a duration is given. With t the time since `start`, A the amplitude and P the period:
//!
//! | signal   | value |
//! |----------|-------|
//! | step     | A |
//! | pulse    | A for t < P, then 0 |
//! | doublet  | A for t < P/2, -A for t < P, then 0 |
//! | square   | A in the first half of each period, -A in the second |
//! | sinusoid | A sin(2 pi t / P) |
//! | prbs     | ±A, drawn again every P: P is the shortest interval |
//! | chirp    | A sin(2 pi (f t + (f' - f) t^2 / 2D)): from f = 1/P to f' = 1/P' within the duration D |
//!
//! The sequence is the output of a Fibonacci shift register of 10 bits with the feedback polynomial x^10 + x^7 + 1, which is primitive: it
//! visits all 1023 nonzero states and then repeats (Golomb, *Shift Register Sequences*, 1967). The seed chooses the start position in the
//! cycle. Brunner's runs (NPS thesis, 1988, pp. 99-101) are pulses and square waves of 10° and 20° and a sinusoid.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::error::ManoeuvreError;

/// Number of bits of the shift register.
pub(crate) const REGISTER_LENGTH: u32 = 10;

/// Number of intervals before the pseudo-random sequence repeats, `2^10 - 1`.
pub(crate) const SEQUENCE_LENGTH: usize = (1 << REGISTER_LENGTH) - 1;

/// The shape of a test signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Signal {
    /// No signal.
    None,
    /// A constant offset.
    Step,
    /// A single offset that lasts for `period`.
    Pulse,
    /// One offset to each side, with a total length of `period`.
    Doublet,
    /// Alternating offsets.
    Square,
    /// A sine wave.
    Sinusoid,
    /// A pseudo-random binary sequence.
    Prbs,
    /// A sine wave whose frequency changes linearly.
    Chirp,
}

impl Signal {
    fn is_timed_by_its_period(self) -> bool {
        !matches!(self, Self::None | Self::Step)
    }
}

/// A test signal with its numbers: the parameters `identification.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct Manoeuvre {
    /// Test signal added to the plane command for identification, in every mode but off.
    #[parameter(default = Signal::None)]
    pub signal: Signal,
    /// Amplitude of the test signal, positive dive; within planes.limit.
    #[parameter(default = 5.0_f64.to_radians(), unit = "rad", positive = "dive", range = -FRAC_PI_2..=FRAC_PI_2)]
    pub amplitude: f64,
    /// Length of a pulse; period of a doublet, square wave or sinusoid; shortest interval of a prbs; first period
    /// of a chirp.
    #[parameter(default = 1.0, unit = "s", range = 1e-3..=1e6)]
    pub period: f64,
    /// Last period of a chirp; the first is identification.period.
    #[parameter(default = 0.2, unit = "s", range = 1e-3..=1e6)]
    pub period_end: f64,
    /// Start time of the test signal since the first state.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e9)]
    pub start: f64,
    /// Duration of the test signal; 0: no end. A chirp needs a duration.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e9)]
    pub duration: f64,
    /// Start position of the prbs in its cycle of 1023 intervals.
    #[parameter(default = 1)]
    pub seed: i64,
}

/// A [`Manoeuvre`] prepared for evaluation: times in whole nanoseconds, the sequence drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TestSignal {
    signal: Signal,
    amplitude: f64,
    period: i64,
    period_end: i64,
    start: i64,
    end: i64,
    sequence: Vec<bool>,
}

impl Manoeuvre {
    /// The signal as a function of time.
    ///
    /// # Errors
    /// [`ManoeuvreError`]: a number that is not finite, a negative start or duration, a period below 2 ns for a signal
    /// that has one, or a chirp without end.
    pub(crate) fn build(&self) -> Result<TestSignal, ManoeuvreError> {
        for (name, number) in [
            ("amplitude", self.amplitude),
            ("period", self.period),
            ("period_end", self.period_end),
            ("start", self.start),
            ("duration", self.duration),
        ] {
            if !number.is_finite() {
                return Err(ManoeuvreError::NotFinite(name, number));
            }
            if name != "amplitude" && number < 0.0 {
                return Err(ManoeuvreError::Negative(name, number));
            }
        }
        let period = nanoseconds(self.period);
        if self.signal.is_timed_by_its_period() && period < 2 {
            return Err(ManoeuvreError::Period(self.period));
        }
        let period_end = nanoseconds(self.period_end);
        if self.signal == Signal::Chirp && (period_end < 2 || self.duration == 0.0) {
            return Err(ManoeuvreError::Chirp {
                period_end: self.period_end,
                duration: self.duration,
            });
        }
        let start = nanoseconds(self.start);
        let end = if self.duration == 0.0 {
            i64::MAX
        } else {
            start.saturating_add(nanoseconds(self.duration))
        };
        let sequence = match self.signal {
            Signal::Prbs => maximal_length_sequence(self.seed),
            _ => Vec::new(),
        };
        Ok(TestSignal {
            signal: self.signal,
            amplitude: self.amplitude,
            period,
            period_end,
            start,
            end,
            sequence,
        })
    }
}

impl TestSignal {
    /// The plane offset, rad, dive positive, `elapsed` nanoseconds after the run began.
    #[must_use]
    pub(crate) fn value(&self, elapsed: i64) -> f64 {
        if elapsed < self.start || elapsed >= self.end {
            return 0.0;
        }
        let time = elapsed - self.start;
        let sign = |positive: bool| if positive { 1.0 } else { -1.0 };
        self.amplitude
            * match self.signal {
                Signal::None => 0.0,
                Signal::Step => 1.0,
                Signal::Pulse if time < self.period => 1.0,
                Signal::Doublet if time < self.period => sign(time < self.period / 2),
                Signal::Pulse | Signal::Doublet => 0.0,
                Signal::Square => sign(time % self.period < self.period / 2),
                Signal::Sinusoid => {
                    libm::sin(TAU * (time % self.period) as f64 / self.period as f64)
                }
                Signal::Prbs => {
                    let interval = (time / self.period) as usize % SEQUENCE_LENGTH;
                    sign(self.sequence[interval])
                }
                Signal::Chirp => {
                    let [time, duration, first, last] =
                        [time, self.end - self.start, self.period, self.period_end]
                            .map(|nanos| nanos as f64 * 1e-9);
                    let sweep = (1.0 / last - 1.0 / first) / duration;
                    libm::sin(TAU * (time / first + 0.5 * sweep * time * time))
                }
            }
    }
}

/// One complete cycle of the shift register's output.
fn maximal_length_sequence(seed: i64) -> Vec<bool> {
    // Any seed gives a register that is not zero, the one state the cycle leaves out.
    let mut register = 1 + seed.rem_euclid(SEQUENCE_LENGTH as i64) as u32;
    (0..SEQUENCE_LENGTH)
        .map(|_| {
            let output = register & 1 == 1;
            let feedback = (register ^ (register >> 3)) & 1;
            register = (register >> 1) | (feedback << (REGISTER_LENGTH - 1));
            output
        })
        .collect()
}

/// Seconds as whole nanoseconds, rounded to the nearest.
pub(crate) fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLISECOND: i64 = 1_000_000;

    fn signal(signal: Signal) -> TestSignal {
        Manoeuvre {
            signal,
            amplitude: 0.1,
            period: 2.0,
            period_end: 0.2,
            start: 1.0,
            duration: 10.0,
            seed: 0,
        }
        .build()
        .unwrap()
    }

    /// The value every half second from t = 0.5 s on, in units of the amplitude.
    fn every_half_second(signal: &TestSignal, count: i64) -> Vec<i64> {
        (1..=count)
            .map(|k| (signal.value(k * 500 * MILLISECOND) * 10.0).round() as i64)
            .collect()
    }

    #[test]
    fn each_signal_has_its_shape() {
        for (shape, values) in [
            (Signal::None, [0, 0, 0, 0, 0, 0, 0, 0]),
            (Signal::Step, [0, 1, 1, 1, 1, 1, 1, 1]),
            (Signal::Pulse, [0, 1, 1, 1, 1, 0, 0, 0]),
            (Signal::Doublet, [0, 1, 1, -1, -1, 0, 0, 0]),
            (Signal::Square, [0, 1, 1, -1, -1, 1, 1, -1]),
            (Signal::Sinusoid, [0, 0, 1, 0, -1, 0, 1, 0]),
        ] {
            assert_eq!(every_half_second(&signal(shape), 8), values, "{shape:?}");
        }
    }

    #[test]
    fn a_signal_ends_after_its_duration_and_zero_means_never() {
        let step = signal(Signal::Step);
        assert_eq!(step.value(10_999 * MILLISECOND), 0.1);
        assert_eq!(step.value(11_000 * MILLISECOND), 0.0);
        let endless = Manoeuvre {
            signal: Signal::Step,
            amplitude: 0.1,
            period: 0.0,
            period_end: 0.0,
            start: 0.0,
            duration: 0.0,
            seed: 0,
        };
        assert_eq!(endless.build().unwrap().value(i64::MAX - 1), 0.1);
    }

    #[test]
    fn the_edges_of_a_square_wave_do_not_drift_by_rounding() {
        let square = Manoeuvre {
            signal: Signal::Square,
            amplitude: 1.0,
            period: 0.1,
            period_end: 0.0,
            start: 0.0,
            duration: 0.0,
            seed: 0,
        }
        .build()
        .unwrap();
        for tick in 0..100_000_i64 {
            let expected = if tick % 2 == 0 { 1.0 } else { -1.0 };
            assert_eq!(square.value(tick * 50 * MILLISECOND), expected);
        }
    }

    #[test]
    fn the_pseudo_random_sequence_is_of_maximal_length() {
        let sequence = maximal_length_sequence(7);
        // Every window of ten bits occurs once in the cycle, and none is all zeros.
        let mut seen = std::collections::BTreeSet::new();
        for start in 0..SEQUENCE_LENGTH {
            let window: Vec<bool> = (0..REGISTER_LENGTH as usize)
                .map(|i| sequence[(start + i) % SEQUENCE_LENGTH])
                .collect();
            assert!(window.iter().any(|bit| *bit));
            assert!(seen.insert(window));
        }
        assert_eq!(seen.len(), SEQUENCE_LENGTH);
        assert_eq!(sequence.iter().filter(|bit| **bit).count(), 512);
    }

    #[test]
    fn another_seed_gives_another_stretch_of_the_sequence() {
        assert_ne!(maximal_length_sequence(1), maximal_length_sequence(2));
        for seed in [i64::MIN, -1, 0, 1022, 1023, i64::MAX] {
            assert!(maximal_length_sequence(seed).contains(&true));
        }
    }

    #[test]
    fn the_pseudo_random_signal_changes_no_faster_than_its_period() {
        let prbs = Manoeuvre {
            signal: Signal::Prbs,
            amplitude: 0.05,
            period: 0.5,
            period_end: 0.0,
            start: 0.0,
            duration: 0.0,
            seed: 1,
        }
        .build()
        .unwrap();
        for tick in 0..2000_i64 {
            let interval_start = tick / 10 * 10;
            let value = prbs.value(tick * 50 * MILLISECOND);
            assert_eq!(value.abs(), 0.05);
            assert_eq!(value, prbs.value(interval_start * 50 * MILLISECOND));
        }
    }

    #[test]
    fn a_chirp_goes_through_as_many_periods_as_its_mean_frequency_has() {
        // From 0.5 to 5 Hz within 10 s: 27.5 periods, a zero crossing upwards at the start of each.
        let chirp = signal(Signal::Chirp);
        let values: Vec<f64> = (0..10_000)
            .map(|k| chirp.value(1000 * MILLISECOND + k * MILLISECOND))
            .collect();
        let upwards = values.windows(2).filter(|w| w[0] <= 0.0 && w[1] > 0.0);
        assert_eq!(upwards.count(), 28);
        let first_second = values[..1000].windows(2).filter(|w| w[0] * w[1] < 0.0);
        let last_second = values[9000..].windows(2).filter(|w| w[0] * w[1] < 0.0);
        assert!(first_second.count() <= 1 && last_second.count() >= 9);
    }

    #[test]
    fn a_signal_that_cannot_be_timed_is_refused() {
        let good = Manoeuvre {
            signal: Signal::Square,
            amplitude: 0.1,
            period: 1.0,
            period_end: 0.0,
            start: 0.0,
            duration: 0.0,
            seed: 0,
        };
        for (bad, reason) in [
            (
                Manoeuvre {
                    period: 0.0,
                    ..good
                },
                "period",
            ),
            (
                Manoeuvre {
                    start: -1.0,
                    ..good
                },
                "start",
            ),
            (
                Manoeuvre {
                    duration: -1.0,
                    ..good
                },
                "duration",
            ),
            (
                Manoeuvre {
                    amplitude: f64::NAN,
                    ..good
                },
                "amplitude",
            ),
        ] {
            assert!(bad.build().unwrap_err().to_string().contains(reason));
        }
    }
}
