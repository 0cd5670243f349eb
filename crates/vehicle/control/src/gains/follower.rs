//! The gains at a tick, from their source.
//!
//! A model takes effect [`Trust::delay`] after its stamp, not when it arrives, so the loop in lockstep does not depend on message latency.

use std::collections::VecDeque;

use planesman_msgs::planesman_msgs::msg::ModelEstimate;

use super::adaptive::Adaptive;
use super::from_file::FromFile;
use super::schedule::{LoopGains, Schedule};
use super::trust::Trust;

/// Maximum number of models waiting for their time; beyond it the oldest is dropped.
const MOST_WAITING: usize = 100;

/// The source of the loops' gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// The parameters, at any speed.
    Fixed,
    /// The schedule on the parameters' model of the vehicle.
    Scheduled,
    /// The schedule on the model being identified.
    Adaptive,
    /// The schedule on an identified model from a file.
    File(FromFile),
}

/// The settings of the gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// The source of the gains.
    pub source: Source,
    /// Gains over speed; the reference are the fixed gains.
    pub schedule: Schedule,
    /// Conditions on an identified model.
    pub trust: Trust,
}

/// The gains' source with its state.
#[derive(Clone, Debug, Default)]
pub struct Follower {
    adaptive: Adaptive,
    waiting: VecDeque<ModelEstimate>,
    /// Whether an identified model was used at the last tick; `None` before the first.
    adapted: Option<bool>,
    /// A line for the log.
    changes: Option<String>,
}

impl Follower {
    /// Takes a model, to be used at its time.
    pub fn on_model(&mut self, model: ModelEstimate) {
        if self.waiting.len() == MOST_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(model);
    }

    /// The gains at a speed (m/s), `dt` seconds after the last tick, and whether they come from an identified model.
    pub fn gains(&mut self, rules: &Rules, speed: f64, stamp: i64, dt: f64) -> (LoopGains, bool) {
        let delay = (rules.trust.delay * 1e9) as i64;
        let is_due =
            |model: &mut ModelEstimate| model.header.stamp.nanos().saturating_add(delay) <= stamp;
        while let Some(model) = self.waiting.pop_front_if(is_due) {
            self.adaptive.on_model(model, &rules.trust);
        }
        match rules.source {
            Source::Fixed => (rules.schedule.reference, false),
            Source::Scheduled => (rules.schedule.at(speed), false),
            Source::File(model) => (model.gains(&rules.schedule, &rules.trust, speed), true),
            Source::Adaptive => {
                let (gains, reason) =
                    self.adaptive
                        .step(&rules.schedule, &rules.trust, speed, stamp, dt);
                let adapted = reason.is_none();
                if self.adapted.replace(adapted) != Some(adapted) {
                    self.changes = Some(match reason {
                        None => "gains follow the identified model".to_owned(),
                        Some(reason) => format!("the gains follow the schedule: {reason}"),
                    });
                }
                (gains, adapted)
            }
        }
    }

    /// A change since the last call, for the log.
    pub fn take_changes(&mut self) -> Option<String> {
        self.changes.take()
    }
}
