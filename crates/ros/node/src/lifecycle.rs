//! Managed nodes: the states of `lifecycle_msgs`, their services and `~/transition_event`.
//!
//! States and transitions with their numbers and labels are those of ROS 2's "Managed nodes" (design.ros2.org), as in `rcl_lifecycle`. A
//! transition always succeeds at once.

use std::{cell::Cell, rc::Rc};

use planesman_msgs::{
    builtin_interfaces::msg::Time,
    lifecycle_msgs::msg::{State, Transition, TransitionDescription, TransitionEvent},
};

/// A transition requested from a managed node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// From unconfigured to inactive.
    Configure,
    /// From inactive to unconfigured.
    CleanUp,
    /// From inactive to active.
    Activate,
    /// From active to inactive.
    Deactivate,
    /// To finalized.
    ShutDown,
}

/// Lifecycle state of a node, managed or always active.
#[derive(Clone, Debug)]
pub struct Lifecycle {
    state: Rc<Cell<u8>>,
}

/// Number, label, start and end state of a transition.
type Edge = (u8, &'static str, u8, u8);

/// Requestable transitions, each with its intermediate state.
const ASKED: [(Edge, Change); 7] = {
    use Change::{Activate, CleanUp, Configure, Deactivate, ShutDown};
    [
        ((1, "configure", 1, 10), Configure),
        ((2, "cleanup", 2, 11), CleanUp),
        ((3, "activate", 2, 13), Activate),
        ((4, "deactivate", 3, 14), Deactivate),
        ((5, "shutdown", 1, 12), ShutDown),
        ((6, "shutdown", 2, 12), ShutDown),
        ((7, "shutdown", 3, 12), ShutDown),
    ]
};

/// Automatic transitions from the intermediate states.
const OUTCOMES: [Edge; 18] = [
    (10, "transition_success", 10, 2),
    (11, "transition_failure", 10, 1),
    (12, "transition_error", 10, 15),
    (20, "transition_success", 11, 1),
    (21, "transition_failure", 11, 2),
    (22, "transition_error", 11, 15),
    (30, "transition_success", 13, 3),
    (31, "transition_failure", 13, 2),
    (32, "transition_error", 13, 15),
    (40, "transition_success", 14, 2),
    (41, "transition_failure", 14, 3),
    (42, "transition_error", 14, 15),
    (50, "transition_success", 12, 4),
    (51, "transition_failure", 12, 4),
    (52, "transition_error", 12, 15),
    (60, "transition_success", 15, 1),
    (61, "transition_failure", 15, 4),
    (62, "transition_error", 15, 4),
];

const STATES: [(u8, &str); 11] = [
    (State::PRIMARY_STATE_UNKNOWN, "unknown"),
    (State::PRIMARY_STATE_UNCONFIGURED, "unconfigured"),
    (State::PRIMARY_STATE_INACTIVE, "inactive"),
    (State::PRIMARY_STATE_ACTIVE, "active"),
    (State::PRIMARY_STATE_FINALIZED, "finalized"),
    (State::TRANSITION_STATE_CONFIGURING, "configuring"),
    (State::TRANSITION_STATE_CLEANINGUP, "cleaningup"),
    (State::TRANSITION_STATE_SHUTTINGDOWN, "shuttingdown"),
    (State::TRANSITION_STATE_ACTIVATING, "activating"),
    (State::TRANSITION_STATE_DEACTIVATING, "deactivating"),
    (State::TRANSITION_STATE_ERRORPROCESSING, "errorprocessing"),
];

fn state(id: u8) -> State {
    let found = STATES.iter().find(|(known, _)| *known == id);
    State {
        id,
        label: found.map_or("", |(_, label)| label).to_owned(),
    }
}

fn description(&(id, label, from, to): &Edge) -> TransitionDescription {
    TransitionDescription {
        transition: Transition {
            id,
            label: label.to_owned(),
        },
        start_state: state(from),
        goal_state: state(to),
    }
}

impl Lifecycle {
    /// The lifecycle of a node that is not managed: the node is always active.
    pub(crate) fn unmanaged() -> Self {
        Self {
            state: Rc::new(Cell::new(State::PRIMARY_STATE_ACTIVE)),
        }
    }

    /// The lifecycle of a managed node, which is initially unconfigured.
    pub(crate) fn managed() -> Self {
        Self {
            state: Rc::new(Cell::new(State::PRIMARY_STATE_UNCONFIGURED)),
        }
    }

    /// Whether the node is active.
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.state.get() == State::PRIMARY_STATE_ACTIVE
    }

    /// Label of the state, such as `inactive`.
    #[must_use]
    pub fn label(&self) -> String {
        self.current().label
    }

    pub(crate) fn current(&self) -> State {
        state(self.state.get())
    }

    pub(crate) fn states() -> Vec<State> {
        STATES.iter().map(|(id, _)| state(*id)).collect()
    }

    /// Transitions available in this state.
    pub(crate) fn available(&self) -> Vec<TransitionDescription> {
        let now = self.state.get();
        let edges = ASKED.iter().map(|(edge, _)| edge);
        edges
            .filter(|edge| edge.2 == now)
            .map(description)
            .collect()
    }

    /// All transitions.
    pub(crate) fn graph() -> Vec<TransitionDescription> {
        let asked = ASKED.iter().map(|(edge, _)| edge);
        asked.chain(&OUTCOMES).map(description).collect()
    }

    /// Performs the requested transition, by its label if one is given, if the transition is available; returns the change and the two events of the
    /// transition.
    pub(crate) fn change(
        &self,
        asked: &Transition,
        now: &Time,
    ) -> Option<(Change, [TransitionEvent; 2])> {
        let state = self.state.get();
        let is_it = |(id, label, from, _): &Edge| {
            *from == state
                && match asked.label.as_str() {
                    "" => *id == asked.id,
                    text => *label == text,
                }
        };
        let (edge, change) = ASKED.iter().find(|(edge, _)| is_it(edge))?;
        let outcome = OUTCOMES.iter().find(|outcome| outcome.2 == edge.3)?;
        self.state.set(outcome.3);
        let event = |edge| {
            let TransitionDescription {
                transition,
                start_state,
                goal_state,
            } = description(edge);
            TransitionEvent {
                timestamp: u64::try_from(now.nanos()).unwrap_or(0),
                transition,
                start_state,
                goal_state,
            }
        };
        Some((*change, [event(edge), event(outcome)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(lifecycle: &Lifecycle, id: u8, label: &str) -> Option<Change> {
        let asked = Transition {
            id,
            label: label.to_owned(),
        };
        let made = lifecycle.change(&asked, &Time::from_nanos(7));
        made.map(|(change, _)| change)
    }

    #[test]
    fn a_node_goes_through_its_states_and_through_no_others() {
        let node = Lifecycle::managed();
        assert_eq!(ask(&node, 3, ""), None, "not configured");
        assert_eq!(ask(&node, 1, ""), Some(Change::Configure));
        assert_eq!(node.label(), "inactive");
        assert_eq!(ask(&node, 0, "activate"), Some(Change::Activate));
        assert!(node.is_active());
        assert_eq!(ask(&node, 2, ""), None, "active");
        assert_eq!(ask(&node, 4, "deactivate"), Some(Change::Deactivate));
        assert_eq!(ask(&node, 2, ""), Some(Change::CleanUp));
        assert_eq!(node.label(), "unconfigured");
        assert_eq!(ask(&node, 10, ""), None, "nobody asks for an outcome");
        assert_eq!(ask(&node, 0, "shutdown"), Some(Change::ShutDown));
        assert_eq!(node.label(), "finalized");
        assert!(node.available().is_empty());
    }

    #[test]
    fn both_events_of_a_transition_are_told() {
        let node = Lifecycle::managed();
        let asked = Transition {
            id: 1,
            label: String::new(),
        };
        let (_, events) = node.change(&asked, &Time::from_nanos(7)).expect("possible");
        let way = events.map(|it| (it.start_state.label, it.transition.id, it.goal_state.label));
        let step = |from: &str, id, to: &str| (from.to_owned(), id, to.to_owned());
        let expected = [
            step("unconfigured", 1, "configuring"),
            step("configuring", 10, "inactive"),
        ];
        assert_eq!(way, expected);
        assert_eq!(Lifecycle::graph().len(), 25);
        assert_eq!(Lifecycle::states().len(), 11);
    }
}
