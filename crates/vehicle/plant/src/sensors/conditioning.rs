//! The analog computer's filters against the drift of the gyro's zero.
//!
//! Source: Brunner 1988, p. 69 (filters) and p. 90 (comparator). The report gives constants for neither.
//!
//! - **High-pass.** A summer with feedback through a pot `k`, an integrator and an inverter: `H = s/(s + k)`. Two in series give the
//!   second-order filter `H = s^2/(s + k)^2`. The report found it of limited value, since the zero is not constant.
//! - **Dead band.** A relay comparator that switches at 0 V, before the integrator for pitch. The gyro's zero is offset so that it stays positive;
//!   only the negative output of a dive passes. The comparator ignores bow-up motion, and bow-down motion slower than the offset.
//!
//! The digitized pitch rate was unconditioned (Fig. 44); conditioning is available for comparison. The filters are exact for an input held
//! between samples (zero-order hold).

/// Conditioning of the pitch-rate channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Conditioning {
    /// No conditioning: the signal as digitized in the report.
    #[default]
    None,
    /// `s/(s + k)`, `k` in rad/s.
    HighPass(f64),
    /// `s^2/(s + k)^2`.
    HighPassTwice(f64),
    /// Adds an offset in volts to the zero; only negative values pass.
    DeadBand(f64),
}

/// State of the two integrators \[V\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Memory([f64; 2]);

impl Conditioning {
    /// Returns the output \[V\] for an input \[V\] held over the coming `dt` \[s\], and advances `memory`.
    ///
    /// With `e = exp(-k dt)` and the integrators `x1' = k (u - x1)`, `x2' = k (u - x1 - x2)`:
    ///
    /// ```text
    /// x1 <- u + e (x1 - u)      x2 <- e (x2 + k dt (u - x1))
    /// ```
    pub(crate) fn step(&self, memory: &mut Memory, input: f64, dt: f64) -> f64 {
        let k = match *self {
            Self::None => return input,
            Self::DeadBand(zero) => return (input + zero).min(0.0),
            Self::HighPass(k) | Self::HighPassTwice(k) => k,
        };
        let [x1, x2] = memory.0;
        let once = input - x1;
        let twice = once - x2;
        let e = libm::exp(-k * dt);
        memory.0 = [input - e * once, e * (x2 + k * dt * once)];
        match self {
            Self::HighPassTwice(_) => twice,
            _ => once,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::gyro;
    use super::*;

    const T: f64 = 0.05;

    fn step_response(conditioning: Conditioning, ticks: usize) -> Vec<f64> {
        let mut memory = Memory::default();
        (0..ticks)
            .map(|_| conditioning.step(&mut memory, 1.0, T))
            .collect()
    }

    #[test]
    fn a_constant_zero_dies_away_as_the_analog_filter_s_step_responses() {
        // s/(s + k): exp(-k t).   s^2/(s + k)^2: (1 - k t) exp(-k t).
        let k = 0.7;
        let once = step_response(Conditioning::HighPass(k), 100);
        let twice = step_response(Conditioning::HighPassTwice(k), 100);
        for n in 0..100 {
            let kt = k * T * n as f64;
            assert!((once[n] - libm::exp(-kt)).abs() < 1e-12);
            assert!((twice[n] - (1.0 - kt) * libm::exp(-kt)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_ramp_is_a_constant_behind_one_high_pass_and_nothing_behind_two() {
        // Why the filters were of limited value: a drift of 1 V/s stays, as 1/k.
        let k = 0.7;
        for (conditioning, end) in [
            (Conditioning::HighPass(k), 1.0 / k),
            (Conditioning::HighPassTwice(k), 0.0),
        ] {
            let mut memory = Memory::default();
            let mut last = 0.0;
            for n in 0..2000 {
                last = conditioning.step(&mut memory, T * f64::from(n), T);
            }
            assert!((last - end).abs() < T, "{conditioning:?}: {last}");
        }
    }

    #[test]
    fn the_comparator_hears_only_dives_faster_than_the_zero() {
        let dead_band = Conditioning::DeadBand(0.025);
        let mut memory = Memory::default();
        let mut pass = |volts| dead_band.step(&mut memory, volts, T);
        assert_eq!(pass(0.125), 0.0, "bow up");
        assert_eq!(pass(-0.020), 0.0, "slower than the zero");
        assert!((pass(-0.125) + 0.100).abs() < 1e-15);
    }

    #[test]
    fn pitch_integrated_behind_the_comparator_never_comes_back_up() {
        // A dive to 20 degrees bow down and back to level, 10 deg/s.
        let dead_band = Conditioning::DeadBand(0.0);
        let mut memory = Memory::default();
        let mut pitch = 0.0_f64;
        for n in 0..80 {
            let volts = if n < 40 { -0.125 } else { 0.125 };
            pitch += T * dead_band.step(&mut memory, volts, T) / gyro::SWING.pitch.sensitivity();
        }
        let pitch = pitch.to_degrees();
        assert!((pitch + 20.0).abs() < 1e-9);
    }
}
