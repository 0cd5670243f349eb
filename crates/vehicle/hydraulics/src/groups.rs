//! Groups of planes with their own actuator.
//!
//! With `together` one ram moves the bow and stern planes; all other commands pass through unchanged. With `each` there are four groups:
//!
//! ```text
//! bow = dive_planes + bow_stern_differential      roll   = roll_differential
//! stern = dive_planes - bow_stern_differential    rudder = rudder
//! ```

use planesman_msgs::planesman_msgs::msg::{PlaneCommand, PlaneMotion};

/// Planes moved by one actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Bow and stern planes together.
    DivePlanes,
    /// The bow planes.
    Bow,
    /// The stern planes.
    Stern,
    /// The port bow plane against the starboard bow plane.
    Roll,
    /// The rudder.
    Rudder,
}

impl Group {
    /// All possible groups.
    pub const ALL: [Self; 5] = [
        Self::DivePlanes,
        Self::Bow,
        Self::Stern,
        Self::Roll,
        Self::Rudder,
    ];

    /// Name in parameters and messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DivePlanes => "dive_planes",
            Self::Bow => "bow",
            Self::Stern => "stern",
            Self::Roll => "roll",
            Self::Rudder => "rudder",
        }
    }

    /// Topic of its `DhaState`. The group that moves the bow planes uses `dha_state`.
    #[must_use]
    pub fn topic(self) -> &'static str {
        match self {
            Self::DivePlanes | Self::Bow => "dha_state",
            Self::Stern => "dha_state_stern",
            Self::Roll => "dha_state_roll",
            Self::Rudder => "dha_state_rudder",
        }
    }

    /// The angle, rad, that `command` demands from this group.
    #[must_use]
    pub fn angle(self, command: &PlaneCommand) -> f64 {
        match self {
            Self::DivePlanes => command.dive_planes,
            Self::Bow => command.dive_planes + command.bow_stern_differential,
            Self::Stern => command.dive_planes - command.bow_stern_differential,
            Self::Roll => command.roll_differential,
            Self::Rudder => command.rudder,
        }
    }
}

/// Division of the planes among actuators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Grouping {
    /// One actuator moves bow and stern planes.
    Together,
    /// Bow, stern, roll differential and rudder have one each.
    Each,
}

impl Grouping {
    /// The groups with an actuator; the group of the bow planes comes first.
    #[must_use]
    pub(crate) fn groups(self) -> &'static [Group] {
        match self {
            Self::Together => &Group::ALL[..1],
            Self::Each => &Group::ALL[1..],
        }
    }

    /// Writes the angles of the actuators over a tick, rad, in the order of [`Grouping::groups`], into a motion; channels without an
    /// actuator stay unchanged.
    pub(crate) fn fill(self, motion: &mut PlaneMotion, mut angles: Vec<Vec<f64>>) {
        match (self, angles.as_mut_slice()) {
            (Self::Together, [dive]) => motion.dive_planes = std::mem::take(dive),
            (Self::Each, [bow, stern, roll, rudder]) => {
                let pairs = || bow.iter().zip(stern.iter());
                motion.dive_planes = pairs().map(|(b, s)| 0.5 * (b + s)).collect();
                motion.bow_stern_differential = pairs().map(|(b, s)| 0.5 * (b - s)).collect();
                motion.roll_differential = std::mem::take(roll);
                motion.rudder = std::mem::take(rudder);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_topic_and_each_name_stands_for_one_group_of_a_grouping() {
        for grouping in [Grouping::Together, Grouping::Each] {
            let mut topics: Vec<_> = grouping.groups().iter().map(|g| g.topic()).collect();
            assert_eq!(topics[0], "dha_state");
            topics.dedup();
            assert_eq!(topics.len(), grouping.groups().len());
        }
    }

    #[test]
    fn what_is_asked_of_bow_and_stern_comes_back_as_sum_and_difference() {
        let command = PlaneCommand {
            dive_planes: 0.25,
            bow_stern_differential: 0.125,
            roll_differential: -0.5,
            rudder: 0.0625,
            ..PlaneCommand::default()
        };
        let groups = Grouping::Each.groups();
        let angles = groups.iter().map(|g| vec![g.angle(&command); 2]).collect();
        let mut motion = PlaneMotion::default();
        Grouping::Each.fill(&mut motion, angles);
        assert_eq!(motion.dive_planes, [0.25; 2]);
        assert_eq!(motion.bow_stern_differential, [0.125; 2]);
        assert_eq!(motion.roll_differential, [-0.5; 2]);
        assert_eq!(motion.rudder, [0.0625; 2]);
    }
}
