//! The goals of an action server: their outcomes, and the waiting clients.
//!
//! This module uses only the middleware's identifiers of goals and requests. States and codes are those of `action_msgs` (design.ros2.org,
//! "Actions").

use planesman_msgs::{
    action_msgs::srv::{CancelGoalRequest, CancelGoalResponse},
    builtin_interfaces::msg::Time,
};
use ros2_client::action::{GoalId, GoalStatusEnum as GoalStatus};

/// Number of ended goals whose results are kept.
pub const REMEMBERED: usize = 32;

/// A goal; `W` identifies a waiting client.
struct Entry<R, W> {
    id: GoalId,
    accepted: Time,
    /// Whether the client has been informed that the goal is accepted.
    answered: bool,
    status: GoalStatus,
    /// Result, once the goal has ended.
    result: Option<R>,
    waiting: Vec<W>,
}

/// Goals in order of arrival.
pub(crate) struct Goals<R, W> {
    entries: Vec<Entry<R, W>>,
}

/// Answer to a request for a result.
#[derive(Debug, PartialEq)]
pub(crate) enum Outcome<R> {
    /// The goal has ended.
    Ended(GoalStatus, R),
    /// The goal is running; the client waits.
    UnderWay,
    /// The goal is unknown.
    Unknown,
}

impl<R: Clone, W> Goals<R, W> {
    pub(crate) fn new() -> Self {
        Self {
            entries: Vec::new(),
        }
    }

    /// Adds a running goal, unless its identifier is already known.
    pub(crate) fn accept(&mut self, id: GoalId, now: Time) -> bool {
        if self.entry(id).is_some() {
            return false;
        }
        self.entries.push(Entry {
            id,
            accepted: now,
            answered: false,
            status: GoalStatus::Executing,
            result: None,
            waiting: Vec::new(),
        });
        true
    }

    /// Marks a goal's acceptance as sent to the client.
    pub(crate) fn answered(&mut self, id: GoalId) {
        if let Some(entry) = self.entry(id) {
            entry.answered = true;
        }
    }

    /// Marks the goals of a cancel request as being cancelled.
    ///
    /// # Errors
    /// The code of the answer, if there are no such goals.
    pub(crate) fn cancel(
        &mut self,
        request: &CancelGoalRequest,
    ) -> Result<Vec<(GoalId, Time)>, i8> {
        let info = &request.goal_info;
        let (id, stamp) = (info.goal_id.uuid, info.stamp.nanos());
        let (any, ever) = (id == [0; 16], stamp == 0);
        let named = |entry: &Entry<R, W>| *entry.id.uuid.as_bytes() == id;
        let by_then = |entry: &Entry<R, W>| !ever && entry.accepted.nanos() <= stamp;
        let mut cancelled = Vec::new();
        for entry in &mut self.entries {
            let meant = (any && ever) || named(entry) || by_then(entry);
            if meant && entry.status == GoalStatus::Executing {
                entry.status = GoalStatus::Canceling;
                cancelled.push((entry.id, entry.accepted.clone()));
            }
        }
        if !cancelled.is_empty() {
            Ok(cancelled)
        } else if any {
            Err(CancelGoalResponse::ERROR_REJECTED)
        } else if self.entries.iter().any(named) {
            Err(CancelGoalResponse::ERROR_GOAL_TERMINATED)
        } else {
            Err(CancelGoalResponse::ERROR_UNKNOWN_GOAL_ID)
        }
    }

    /// Ends a goal, and returns the clients waiting for its result. Drops the oldest ended goals beyond [`REMEMBERED`].
    pub(crate) fn end(&mut self, id: GoalId, status: GoalStatus, result: R) -> Vec<W> {
        let Some(entry) = self.entry(id).filter(|entry| entry.result.is_none()) else {
            return Vec::new();
        };
        entry.status = status;
        entry.result = Some(result);
        let waiting = std::mem::take(&mut entry.waiting);
        let has_ended = |entry: &Entry<R, W>| entry.result.is_some();
        if self.entries.iter().filter(|e| has_ended(e)).count() > REMEMBERED
            && let Some(oldest) = self.entries.iter().position(has_ended)
        {
            self.entries.remove(oldest);
        }
        waiting
    }

    /// Outcome of a goal; if there is no outcome yet, `asker` is added to the waiting clients.
    pub(crate) fn outcome(&mut self, id: GoalId, asker: W) -> Outcome<R> {
        match self.entry(id) {
            None => Outcome::Unknown,
            Some(entry) => match &entry.result {
                Some(result) => Outcome::Ended(entry.status, result.clone()),
                None => {
                    entry.waiting.push(asker);
                    Outcome::UnderWay
                }
            },
        }
    }

    /// Goals whose acceptance the client has received, or that have ended, with their states, newest last. Clients like rclpy's ignore the status
    /// of a goal before its acceptance.
    pub(crate) fn statuses(&self) -> impl Iterator<Item = (GoalId, Time, GoalStatus)> {
        let entries = self.entries.iter();
        let entries = entries.filter(|entry| entry.answered || entry.result.is_some());
        entries.map(|entry| (entry.id, entry.accepted.clone(), entry.status))
    }

    fn entry(&mut self, id: GoalId) -> Option<&mut Entry<R, W>> {
        self.entries.iter_mut().find(|entry| entry.id == id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::{action_msgs::msg::GoalInfo, unique_identifier_msgs::msg::UUID};

    fn request(id: Option<GoalId>, stamp: i64) -> CancelGoalRequest {
        CancelGoalRequest {
            goal_info: GoalInfo {
                goal_id: UUID {
                    uuid: id.map_or([0; 16], |id| *id.uuid.as_bytes()),
                },
                stamp: Time::from_nanos(stamp),
            },
        }
    }

    /// Three goals, accepted at 1, 2 and 3 ns.
    fn three() -> (Goals<&'static str, u8>, [GoalId; 3]) {
        let mut goals = Goals::new();
        let ids = [1, 2, 3].map(|at| {
            let id = GoalId::new_random();
            assert!(goals.accept(id, Time::from_nanos(at)));
            goals.answered(id);
            id
        });
        (goals, ids)
    }

    #[test]
    fn a_known_identifier_is_not_accepted_again() {
        let (mut goals, [first, ..]) = three();
        assert!(!goals.accept(first, Time::from_nanos(9)));
        goals.end(first, GoalStatus::Succeeded, "done");
        assert!(!goals.accept(first, Time::from_nanos(9)));
    }

    #[test]
    fn a_goal_has_no_status_before_its_client_knows_that_it_is_accepted() {
        let (mut goals, _) = three();
        let id = GoalId::new_random();
        goals.accept(id, Time::from_nanos(4));
        assert_eq!(goals.statuses().count(), 3);
        goals.answered(id);
        assert_eq!(goals.statuses().count(), 4);
    }

    #[test]
    fn who_asks_early_waits_and_who_asks_late_is_told() {
        let (mut goals, [first, second, _]) = three();
        assert_eq!(goals.outcome(first, 7), Outcome::UnderWay);
        assert_eq!(goals.outcome(first, 8), Outcome::UnderWay);
        assert_eq!(goals.end(first, GoalStatus::Succeeded, "done"), [7, 8]);
        let done = Outcome::Ended(GoalStatus::Succeeded, "done");
        assert_eq!(goals.outcome(first, 9), done);
        assert!(goals.end(first, GoalStatus::Aborted, "again").is_empty());
        assert_eq!(goals.outcome(first, 9), done, "a goal ends once");
        assert_eq!(goals.outcome(GoalId::new_random(), 9), Outcome::Unknown);
        assert_eq!(goals.outcome(second, 9), Outcome::UnderWay);
    }

    #[test]
    fn a_request_to_cancel_means_one_goal_all_or_all_up_to_a_time() {
        for (which, stamp, meant) in [
            (Some(1), 0, vec![1]),
            (None, 0, vec![0, 1, 2]),
            (None, 2, vec![0, 1]),
            (Some(2), 1, vec![0, 2]),
        ] {
            let (mut goals, ids) = three();
            let cancelled = goals.cancel(&request(which.map(|i: usize| ids[i]), stamp));
            let found: Vec<GoalId> = cancelled.unwrap().into_iter().map(|(id, _)| id).collect();
            assert_eq!(found, meant.iter().map(|i| ids[*i]).collect::<Vec<_>>());
        }
    }

    #[test]
    fn what_cannot_be_cancelled_is_said_why() {
        let (mut goals, [first, ..]) = three();
        let stranger = request(Some(GoalId::new_random()), 0);
        assert_eq!(
            goals.cancel(&stranger),
            Err(CancelGoalResponse::ERROR_UNKNOWN_GOAL_ID)
        );
        goals.end(first, GoalStatus::Succeeded, "done");
        assert_eq!(
            goals.cancel(&request(Some(first), 0)),
            Err(CancelGoalResponse::ERROR_GOAL_TERMINATED)
        );
        goals.cancel(&request(None, 0)).unwrap();
        assert_eq!(
            goals.cancel(&request(None, 0)),
            Err(CancelGoalResponse::ERROR_REJECTED)
        );
    }

    #[test]
    fn only_the_last_goals_are_remembered_but_none_under_way_is_forgotten() {
        let (mut goals, [first, ..]) = three();
        let ended: Vec<GoalId> = (0..=REMEMBERED)
            .map(|_| {
                let id = GoalId::new_random();
                goals.accept(id, Time::from_nanos(4));
                goals.end(id, GoalStatus::Succeeded, "done");
                id
            })
            .collect();
        assert_eq!(goals.outcome(ended[0], 0), Outcome::Unknown);
        assert_ne!(goals.outcome(ended[1], 0), Outcome::Unknown);
        assert_eq!(goals.outcome(first, 0), Outcome::UnderWay);
        assert_eq!(goals.statuses().count(), 3 + REMEMBERED);
    }
}
