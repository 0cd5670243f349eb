//! Certainty equivalence within bounds: the schedule, on the model that `sysid` identifies while it can be
//! trusted, on its own otherwise.
//!
//! An estimate is believed when `sysid` calls it valid, it is younger than [`Trust::oldest`], and passes
//! [`Trust`]; the first that does not hold is the reason given. The gains move towards their target no faster than [`Trust::rate`] of the scheduled gain per second,
//! so that neither a new estimate nor its loss is a step; and stay within the same factor of the scheduled
//! gains.

use planesman_msgs::planesman_msgs::msg::ModelEstimate;

use super::{LoopGains, PitchModel, Schedule, Trust, pitch_model::Identified};

/// The gains in force and the last estimate.
#[derive(Clone, Debug)]
pub struct Adaptive {
    last: Option<Heard>,
    gains: Option<LoopGains>,
}

/// An estimate as it was heard.
#[derive(Clone, Debug)]
struct Heard {
    /// ns
    stamp: i64,
    vehicle: Result<Identified, String>,
}

impl Adaptive {
    /// Nothing heard; the schedule acts.
    #[must_use]
    pub fn new() -> Self {
        Self {
            last: None,
            gains: None,
        }
    }

    /// Takes an estimate; whether it is believed is decided when gains are asked for.
    pub fn on_model(&mut self, estimate: &ModelEstimate) {
        let vehicle = if estimate.valid {
            Identified::of(estimate)
        } else {
            Err(format!("sysid: {}", estimate.reason))
        };
        self.last = Some(Heard {
            stamp: estimate.header.stamp.nanos(),
            vehicle,
        });
    }

    /// The identified vehicle if it can be believed at `stamp` (ns) and `speed` (m/s).
    ///
    /// # Errors
    /// Why not.
    pub fn believed(
        &self,
        schedule: &Schedule,
        trust: &Trust,
        speed: f64,
        stamp: i64,
    ) -> Result<PitchModel, String> {
        let heard = self.last.as_ref().ok_or("no model has come yet")?;
        let age = (stamp - heard.stamp) as f64 * 1e-9;
        if age.abs() > trust.oldest {
            return Err(format!("the last model is {age:.1} s old"));
        }
        trust.believed(&heard.vehicle.clone()?, schedule, speed)
    }

    /// The gains `dt` seconds after the last ones, and why the schedule acts alone if it does.
    pub fn step(
        &mut self,
        schedule: &Schedule,
        trust: &Trust,
        speed: f64,
        stamp: i64,
        dt: f64,
    ) -> (LoopGains, Option<String>) {
        let scheduled = schedule.at(speed);
        let (target, reason) = match self.believed(schedule, trust, speed, stamp) {
            Ok(model) => (trust.gains(schedule, &model, speed), None),
            Err(reason) => (scheduled, Some(reason)),
        };
        let before = self.gains.unwrap_or(scheduled);
        let most = trust.rate * dt;
        let gains = target
            .zip(before, |target, before| target - before)
            .zip(scheduled, |change, planned| {
                change.clamp(-most * planned, most * planned)
            })
            .zip(before, |change, before| before + change);
        self.gains = Some(gains);
        (gains, reason)
    }
}

impl Default for Adaptive {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gains::pitch_model::tests::estimate_of;
    use crate::gains::schedule::tests::T6;
    use planesman_msgs::builtin_interfaces::msg::Time;

    const TRUST: Trust = Trust {
        oldest: 5.0,
        uncertainty: 0.25,
        factor: 4.0,
        rate: 0.1,
    };
    const SECOND: i64 = 1_000_000_000;

    fn heard(plane: f64, deviation: f64, stamp: i64) -> Adaptive {
        let mut model = T6.law.model;
        model.plane *= plane;
        let mut estimate = estimate_of(&model, 0.05, deviation);
        estimate.header.stamp = Time::from_nanos(stamp);
        let mut adaptive = Adaptive::new();
        adaptive.on_model(&estimate);
        adaptive
    }

    #[test]
    fn planes_half_as_strong_double_the_pitch_gain_in_their_own_time() {
        let mut adaptive = heard(0.5, 1e-9, 0);
        let mut pitch_p = T6.reference.pitch_p;
        for k in 0..240 {
            let (gains, reason) = adaptive.step(&T6, &TRUST, 1.0, k * SECOND / 50, 0.05);
            assert_eq!(reason, None);
            assert!((gains.pitch_p - pitch_p).abs() <= 0.1 * 0.05 * 0.7 + 1e-12);
            pitch_p = gains.pitch_p;
        }
        assert!(
            (pitch_p / T6.reference.pitch_p - 2.0).abs() < 1e-2,
            "{pitch_p}"
        );
    }

    #[test]
    fn a_model_that_cannot_be_trusted_leaves_the_schedule_in_charge() {
        for (adaptive, word) in [
            (Adaptive::new(), "no model"),
            (heard(2.0, 1e-9, -20 * SECOND), "old"),
            (heard(2.0, 1e-1, 0), "known to"),
            (heard(9.0, 1e-9, 0), "times the scheduled"),
            (heard(-1.0, 1e-9, 0), "times the scheduled"),
        ] {
            let mut adaptive = adaptive;
            let (gains, reason) = adaptive.step(&T6, &TRUST, 1.0, 0, 0.05);
            assert_eq!(gains, T6.at(1.0));
            assert!(
                reason.clone().is_some_and(|r| r.contains(word)),
                "{reason:?}"
            );
        }
        let mut adaptive = Adaptive::new();
        adaptive.on_model(&ModelEstimate {
            reason: "too little excitation".to_owned(),
            ..ModelEstimate::default()
        });
        let (_, reason) = adaptive.step(&T6, &TRUST, 1.0, 0, 0.05);
        assert!(reason.is_some_and(|r| r.contains("excitation")));
    }

    #[test]
    fn a_model_lost_is_left_as_slowly_as_it_was_taken_up() {
        let mut adaptive = heard(0.5, 1e-9, 0);
        for k in 0..200 {
            let _ = adaptive.step(&T6, &TRUST, 1.0, k * SECOND / 50, 0.05);
        }
        let (before, _) = adaptive.step(&T6, &TRUST, 1.0, 4 * SECOND, 0.0);
        let (after, reason) = adaptive.step(&T6, &TRUST, 1.0, 60 * SECOND, 0.05);
        assert!(reason.is_some());
        assert!(after.pitch_p < before.pitch_p);
        assert!(before.pitch_p - after.pitch_p <= 0.1 * 0.05 * 0.7 + 1e-12);
    }
}
