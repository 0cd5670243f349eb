//! The pitch law, the inner loop: pitch P with rate feedback to the dive planes (Brunner, NPS thesis,
//! 1988, program T6, App. C).
//!
//! The program includes the rate feedback in the plant's damping, dive-positive:
//! ```text
//! DEL = Kpy (TC - T)
//! J T'' = Ky DEL - (By + Kr Ky) T'
//! ```
//! which is the plant `J T'' = Ky delta - By T'` under the plane command
//! `delta = Kpy (TC - T) - Kr T'`. With pitch bow-up positive, `theta = -T` and `q = -T'`:
//! ```text
//! delta = -Kpy (theta_c - theta) + Kr q
//! ```
//! A plane angle is dive-positive: too much bow-up pitch, or a rising bow, gives a dive command. [`crate::autopilot`] then applies the
//! plane limit and the test signal.

use crate::limits::bounded;

/// Pitch P with rate feedback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchLoop {
    /// `Kpy`, rad of plane per rad of pitch error.
    pub p: f64,
    /// `Kr`, s: rad of plane per rad/s of pitch rate.
    pub rate: f64,
}

/// The terms of the pitch loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PitchTerms {
    /// `theta_c - theta`, rad, bow up positive.
    pub error: f64,
    /// `-Kpy (theta_c - theta)`, rad of plane, dive positive.
    pub p: f64,
    /// `Kr q`, rad of plane, dive positive.
    pub rate: f64,
}

impl PitchTerms {
    /// The loop's plane command before any limit, rad, dive positive.
    #[must_use]
    pub fn dive_planes(&self) -> f64 {
        self.p + self.rate
    }
}

impl PitchLoop {
    /// The plane terms for a pitch command (rad), a pitch (rad) and its rate (rad/s), all bow up.
    #[must_use]
    pub fn evaluate(&self, pitch_command: f64, pitch: f64, pitch_rate: f64) -> PitchTerms {
        let error = bounded(pitch_command - pitch);
        PitchTerms {
            error,
            p: bounded(-self.p * error),
            rate: bounded(self.rate * pitch_rate),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOP: PitchLoop = PitchLoop { p: 0.7, rate: 2.0 };

    #[test]
    fn a_bow_down_command_dives_the_planes() {
        assert!(LOOP.evaluate(-0.3, 0.0, 0.0).dive_planes() > 0.0);
    }

    #[test]
    fn a_rising_bow_dives_the_planes() {
        assert!(LOOP.evaluate(0.0, 0.0, 0.1).dive_planes() > 0.0);
    }

    #[test]
    fn on_the_commanded_pitch_at_rest_the_planes_are_neutral() {
        assert_eq!(LOOP.evaluate(0.2, 0.2, 0.0).dive_planes(), 0.0);
    }
}
