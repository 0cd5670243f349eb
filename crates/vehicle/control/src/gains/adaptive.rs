//! Certainty equivalence within bounds: the schedule uses the model that `sysid` identifies as long as that model can be trusted, and otherwise the
//! schedule's own model.
//!
//! An estimate is used if `sysid` marks it as valid, it is younger than [`Trust::oldest`], and it passes [`Trust`]; the first condition
//! that fails is the reported reason. If `sysid` identifies several pairs of signals, only estimates of pitch rate over plane angle are
//! used. If several pairs qualify, `sysid`'s first pair ([`FIRST_PAIR`]) is used, or else the pair whose model arrived first, until it has been
//! silent for [`Trust::oldest`].
//!
//! The gains move towards their target by at most [`Trust::rate`] of the scheduled gain per second, so that neither a new estimate nor its
//! loss causes a step. The gains stay within the same factor of the scheduled gains.

use std::cell::OnceCell;

use planesman_msgs::planesman_msgs::msg::ModelEstimate;

use super::distrust::Distrust;
use super::pitch_model::{FIRST_PAIR, Identified, PitchModel, is_of_pitch};
use super::schedule::{LoopGains, Schedule};
use super::trust::Trust;

/// The current gains and the last estimate.
#[derive(Clone, Debug)]
pub(super) struct Adaptive {
    last: Option<Received>,
    gains: Option<LoopGains>,
}

/// An estimate as received.
#[derive(Clone, Debug)]
struct Received {
    estimate: ModelEstimate,
    /// ns
    stamp: i64,
    /// The identified vehicle. It is computed when gains are first requested, and never if the gains have another source.
    vehicle: OnceCell<Result<Identified, Distrust>>,
}

impl Received {
    fn vehicle(&self) -> &Result<Identified, Distrust> {
        self.vehicle.get_or_init(|| {
            if self.estimate.valid {
                Identified::from_estimate(&self.estimate)
            } else {
                Err(Distrust::Invalid(self.estimate.reason.clone()))
            }
        })
    }
}

impl Adaptive {
    /// Gains without an estimate, so that the schedule is used.
    #[must_use]
    pub(super) fn new() -> Self {
        Self {
            last: None,
            gains: None,
        }
    }

    /// Takes an estimate of the pair that is used; it is judged only when gains are requested.
    pub(super) fn on_model(&mut self, estimate: ModelEstimate, trust: &Trust) {
        let stamp = estimate.header.stamp.nanos();
        let another_is_followed = self.last.as_ref().is_some_and(|received| {
            let age = stamp.saturating_sub(received.stamp) as f64 * 1e-9;
            let of_first = estimate.name == FIRST_PAIR;
            received.estimate.name != estimate.name && !of_first && age.abs() <= trust.oldest
        });
        if another_is_followed || !is_of_pitch(&estimate) {
            return;
        }
        self.last = Some(Received {
            estimate,
            stamp,
            vehicle: OnceCell::new(),
        });
    }

    /// The identified vehicle, if it can be trusted at `stamp` (ns) and `speed` (m/s).
    ///
    /// # Errors
    /// The reason.
    pub(super) fn believed(
        &self,
        schedule: &Schedule,
        trust: &Trust,
        speed: f64,
        stamp: i64,
    ) -> Result<PitchModel, Distrust> {
        let received = self.last.as_ref().ok_or(Distrust::NoModel)?;
        let age = (stamp - received.stamp) as f64 * 1e-9;
        if age.abs() > trust.oldest {
            return Err(Distrust::Old(age));
        }
        trust.believed(
            received.vehicle().as_ref().map_err(Clone::clone)?,
            schedule,
            speed,
        )
    }

    /// The gains `dt` seconds after the previous gains, and the reason if only the schedule is used.
    pub(super) fn step(
        &mut self,
        schedule: &Schedule,
        trust: &Trust,
        speed: f64,
        stamp: i64,
        dt: f64,
    ) -> (LoopGains, Option<Distrust>) {
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
        delay: 1.0,
        oldest: 5.0,
        uncertainty: 0.25,
        factor: 4.0,
        rate: 0.1,
    };
    const SECOND: i64 = 1_000_000_000;

    fn received(plane: f64, deviation: f64, stamp: i64) -> Adaptive {
        let mut model = T6.law.model;
        model.plane *= plane;
        let mut estimate = estimate_of(&model, 0.05, deviation);
        estimate.header.stamp = Time::from_nanos(stamp);
        let mut adaptive = Adaptive::new();
        adaptive.on_model(estimate, &TRUST);
        adaptive
    }

    #[test]
    fn planes_half_as_strong_double_the_pitch_gain_in_their_own_time() {
        let mut adaptive = received(0.5, 1e-9, 0);
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
        for (adaptive, part) in [
            (Adaptive::new(), "no model"),
            (received(2.0, 1e-9, -20 * SECOND), "old"),
            (received(2.0, 1e-1, 0), "known only to"),
            (received(9.0, 1e-9, 0), "times its scheduled"),
            (received(-1.0, 1e-9, 0), "times its scheduled"),
        ] {
            let mut adaptive = adaptive;
            let (gains, reason) = adaptive.step(&T6, &TRUST, 1.0, 0, 0.05);
            assert_eq!(gains, T6.at(1.0));
            assert!(
                reason.clone().is_some_and(|r| r.to_string().contains(part)),
                "{reason:?}"
            );
        }
        let mut adaptive = Adaptive::new();
        let unsure = ModelEstimate {
            valid: false,
            reason: "too little excitation".to_owned(),
            ..estimate_of(&T6.law.model, 0.05, 1e-9)
        };
        adaptive.on_model(unsure, &TRUST);
        let (_, reason) = adaptive.step(&T6, &TRUST, 1.0, 0, 0.05);
        assert!(reason.is_some_and(|r| r.to_string().contains("excitation")));
    }

    #[test]
    fn only_pitch_is_received_and_of_several_estimators_that_of_the_first_pair() {
        let of = |name: &str, plane: f64, stamp: i64| {
            let mut model = T6.law.model;
            model.plane *= plane;
            let mut estimate = estimate_of(&model, 0.05, 1e-9);
            estimate.name = name.to_owned();
            estimate.header.stamp = Time::from_nanos(stamp);
            estimate
        };
        let heave = ModelEstimate {
            output: "state:heave".to_owned(),
            ..of("heave", 2.0, 0)
        };
        let mut adaptive = Adaptive::new();
        adaptive.on_model(heave.clone(), &TRUST);
        assert!(adaptive.believed(&T6, &TRUST, 1.0, 0).is_err());
        adaptive.on_model(of("filtered", 2.0, SECOND), &TRUST);
        adaptive.on_model(of("model", 0.5, SECOND), &TRUST);
        adaptive.on_model(of("filtered", 2.0, SECOND), &TRUST);
        adaptive.on_model(heave, &TRUST);
        let plane = |adaptive: &Adaptive, stamp| {
            let believed = adaptive
                .believed(&T6, &TRUST, 1.0, stamp)
                .expect("believed");
            believed.plane / T6.law.model.plane
        };
        assert!((plane(&adaptive, SECOND) - 0.5).abs() < 1e-2);
        // Silent for longer than is believed: the other's turn.
        adaptive.on_model(of("filtered", 2.0, 7 * SECOND), &TRUST);
        assert!((plane(&adaptive, 7 * SECOND) - 2.0).abs() < 4e-2);
        adaptive.on_model(of("another", 1.0, 8 * SECOND), &TRUST);
        assert!((plane(&adaptive, 8 * SECOND) - 2.0).abs() < 4e-2);
    }

    #[test]
    fn a_model_lost_is_left_as_slowly_as_it_was_taken_up() {
        let mut adaptive = received(0.5, 1e-9, 0);
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
