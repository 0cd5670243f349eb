//! Conditions on an identified model for its gains to be used.
//!
//! 1. `K/J` and `B/J` lie within a factor [`Trust::factor`] of the scheduled model's;
//! 2. their standard deviations are below [`Trust::uncertainty`] of the values.
//!
//! The gains then stay within the same factor of the scheduled ones.

use super::distrust::Distrust;
use super::pitch_model::{Identified, PitchModel};
use super::schedule::{LoopGains, Schedule};

/// Conditions on an identified model, and how fast the gains follow it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trust {
    /// The oldest estimate acted upon, s.
    pub oldest: f64,
    /// The largest relative standard deviation of `K/J` and `B/J`.
    pub uncertainty: f64,
    /// The largest factor between identified and scheduled; above 1.
    pub factor: f64,
    /// The largest change of a gain, in scheduled gains per second.
    pub rate: f64,
}

impl Trust {
    /// The model found at a speed (m/s), if it meets the conditions.
    ///
    /// # Errors
    /// Why not.
    pub fn believed(
        &self,
        found: &Identified,
        schedule: &Schedule,
        speed: f64,
    ) -> Result<PitchModel, Distrust> {
        let expected = schedule.law.at(schedule.scheduled(speed));
        let Identified { model, .. } = found;
        for (name, value, deviation, expected) in [
            ("K/J", model.plane, found.plane_deviation, expected.plane),
            (
                "B/J",
                model.damping,
                found.damping_deviation,
                expected.damping,
            ),
        ] {
            let ratio = value / expected;
            // Ranges hold no NaN, so a NaN is not believed.
            if !(1.0 / self.factor..=self.factor).contains(&ratio) {
                return Err(Distrust::Far { name, ratio });
            }
            if !(0.0..=self.uncertainty * value).contains(&deviation) {
                let deviation = deviation / value;
                return Err(Distrust::Uncertain { name, deviation });
            }
        }
        Ok(*model)
    }

    /// The gains at a speed (m/s) for a vehicle of a model that is believed.
    #[must_use]
    pub fn gains(&self, schedule: &Schedule, model: &PitchModel, speed: f64) -> LoopGains {
        schedule
            .on(model, speed)
            .zip(schedule.at(speed), |gain, planned| {
                gain.clamp(planned / self.factor, planned * self.factor)
            })
    }
}
