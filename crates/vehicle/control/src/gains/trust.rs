//! Conditions for the use of an identified model.
//!
//! 1. `K/J` and `B/J` are within a factor [`Trust::factor`] of the scheduled model's;
//! 2. their standard deviations are below [`Trust::uncertainty`] of the values.
//!
//! The gains then stay within the same factor of the scheduled gains.

use super::distrust::Distrust;
use super::pitch_model::{Identified, PitchModel};
use super::schedule::{LoopGains, Schedule};

/// Conditions on an identified model, and how fast the gains follow it: the parameters `gains.adaptive.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct Trust {
    /// Delay from the stamp of an identified model to its use, so that message latency has no effect.
    #[parameter(default = 1.0, unit = "s", range = 0.0..=60.0)]
    pub delay: f64,
    /// Maximum age at which an identified model is still used.
    #[parameter(default = 5.0, unit = "s", range = 0.0..=3600.0)]
    pub oldest: f64,
    /// Largest relative standard deviation of K/J and B/J of a model that is used.
    #[parameter(default = 0.25, range = 0.0..=10.0)]
    pub uncertainty: f64,
    /// Largest ratio between identified and scheduled K/J, B/J and gains.
    #[parameter(default = 4.0, range = 1.0..=100.0)]
    pub factor: f64,
    /// Rate limit of a gain, in scheduled gains per second.
    #[parameter(default = 0.1, unit = "1/s", range = 0.0..=100.0)]
    pub rate: f64,
}

impl Trust {
    /// The model identified at a speed (m/s), if it satisfies the conditions.
    ///
    /// # Errors
    /// The reason.
    pub fn believed(
        &self,
        identified: &Identified,
        schedule: &Schedule,
        speed: f64,
    ) -> Result<PitchModel, Distrust> {
        let expected = schedule.law.at(schedule.scheduled(speed));
        let Identified { model, .. } = identified;
        for (name, value, deviation, expected) in [
            (
                "K/J",
                model.plane,
                identified.plane_deviation,
                expected.plane,
            ),
            (
                "B/J",
                model.damping,
                identified.damping_deviation,
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

    /// The gains at a speed (m/s) for a vehicle with a trusted model.
    #[must_use]
    pub fn gains(&self, schedule: &Schedule, model: &PitchModel, speed: f64) -> LoopGains {
        schedule
            .on(model, speed)
            .zip(schedule.at(speed), |gain, planned| {
                gain.clamp(planned / self.factor, planned * self.factor)
            })
    }
}
