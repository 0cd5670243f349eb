//! The valves and the calibrating pistons between them (Appendix A).
//!
//! The actuating valve and the direction (sign) valve each have two settled positions. Together they decide to which end the calibrating
//! piston is pressed: the exclusive nor of the two. When that end changes, the piston strokes and moves one calibrated volume V_c: with the direction
//! valve to the right, into the ram's left chamber; with the valve to the left, out of this chamber.
//!
//! | switched | volume |
//! |---|---|
//! | actuating valve | one quantum in the present direction |
//! | direction valve | one quantum in the new direction |
//! | both together | no volume: only direction and drift polarity change |
//!
//! A volume command in parallel with a change of sign is therefore inhibited (Section II.A.1): "the transfer of a calibrated volume follows
//! the switching of the sign valve", and no volume is lost.
//!
//! A two-speed actuator has "an additional valve unit and calibrating cylinder" (Section II.A.3): a second piston with its own actuating
//! valve, and the same direction valve. A change of direction would stroke both pistons; so the actuating valve of each piston that must
//! not move is switched too.

use crate::condition::StuckValve;
use crate::pulse_logic::{Command, Volume};

/// A settled position of every valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Positions {
    /// The large volume's actuating valve.
    large_up: bool,
    /// The small volume's actuating valve.
    small_up: bool,
    direction_right: bool,
}

/// The valves, and the commands of their drivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Valves {
    /// Positions commanded by the drivers: the valves' positions unless one is stuck.
    driven: Positions,
    settled: Positions,
    stuck: Option<StuckValve>,
}

/// Volumes moved by one switching.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stroke {
    /// Large calibrated volumes moved: +1, 0 or -1.
    pub large: i8,
    /// Small calibrated volumes moved: +1, 0 or -1.
    pub small: i8,
    /// Position of the direction valve: +1 right, -1 left. The polarity is also that of the drift.
    pub polarity: i8,
    /// Whether the large volume's actuating valve has switched down, the direction of the slow latch.
    pub down: bool,
    /// Which drivers have switched: the large volume's actuating valve, the small volume's, the direction valve.
    pub driven: [bool; 3],
}

impl Stroke {
    /// No volume moved, the direction valve at `polarity`.
    #[must_use]
    pub fn none(polarity: i8) -> Self {
        Self {
            large: 0,
            small: 0,
            polarity,
            down: false,
            driven: [false; 3],
        }
    }
}

impl Positions {
    /// End to which the calibrating piston of an actuating valve is pressed.
    fn piston_end(self, actuating_up: bool) -> bool {
        actuating_up == self.direction_right
    }

    /// Volumes moved by the switching from `before` to this position.
    fn stroke_since(self, before: Self) -> Stroke {
        let polarity = if self.direction_right { 1 } else { -1 };
        let moved = |up_before, up| {
            if self.piston_end(up) == before.piston_end(up_before) {
                0
            } else {
                polarity
            }
        };
        Stroke {
            large: moved(before.large_up, self.large_up),
            small: moved(before.small_up, self.small_up),
            polarity,
            down: before.large_up && !self.large_up,
            driven: [false; 3],
        }
    }
}

impl Valves {
    /// Returns settled valves, the direction valve to the right for +1 and to the left for -1.
    #[must_use]
    pub(crate) fn settled(polarity: i8) -> Self {
        let settled = Positions {
            large_up: true,
            small_up: true,
            direction_right: polarity >= 0,
        };
        Self {
            driven: settled,
            settled,
            stuck: None,
        }
    }

    /// Sets the stuck valve. A released valve switches to its commanded position with the next command.
    pub(crate) fn set_stuck(&mut self, stuck: Option<StuckValve>) {
        self.stuck = stuck;
    }

    /// Carries out a pulse command (Figure 2-3). If the sign is unchanged, the actuating valve moves the commanded volume. If the sign changes, the
    /// direction valve switches. Its switching moves the volume, so the parallel volume command is inhibited. The actuating valves of the other volumes
    /// switch too, so these volumes do not move. The drivers know only their own last command, not the valves' positions.
    pub(crate) fn obey(&mut self, command: Command) -> Stroke {
        let sign_changes = (command.sign > 0) != self.driven.direction_right;
        self.driven.direction_right ^= sign_changes;
        let switch = |volume| (command.volume == volume) != sign_changes;
        let (large, small) = (switch(Volume::Large), switch(Volume::Small));
        self.driven.large_up ^= large;
        self.driven.small_up ^= small;
        let before = self.settled;
        self.settled = self.driven;
        match self.stuck {
            Some(StuckValve::Actuating) => self.settled.large_up = before.large_up,
            Some(StuckValve::Direction) => self.settled.direction_right = before.direction_right,
            None => {}
        }
        Stroke {
            driven: [large, small, sign_changes],
            ..self.settled.stroke_since(before)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every position of actuating and direction valve.
    const STARTS: [(bool, bool); 4] = [(true, true), (true, false), (false, true), (false, false)];

    fn positions((large_up, direction_right): (bool, bool)) -> Positions {
        Positions {
            large_up,
            small_up: true,
            direction_right,
        }
    }

    fn valves(start: (bool, bool)) -> Valves {
        Valves {
            driven: positions(start),
            settled: positions(start),
            stuck: None,
        }
    }

    /// The motion of the large volume when the valves named are switched.
    fn switched(start: (bool, bool), actuating: bool, direction: bool) -> (i8, i8) {
        let (before, mut after) = (positions(start), positions(start));
        after.large_up ^= actuating;
        after.direction_right ^= direction;
        let stroke = after.stroke_since(before);
        (stroke.large, stroke.polarity)
    }

    #[test]
    fn the_actuating_valve_alone_moves_one_quantum_in_the_present_direction() {
        for start in STARTS {
            let present = if start.1 { 1 } else { -1 };
            assert_eq!(switched(start, true, false), (present, present));
        }
    }

    #[test]
    fn the_direction_valve_alone_moves_one_quantum_in_the_new_direction() {
        for start in STARTS {
            let new = if start.1 { -1 } else { 1 };
            assert_eq!(switched(start, false, true), (new, new));
        }
    }

    #[test]
    fn both_valves_together_change_the_direction_and_move_nothing() {
        for start in STARTS {
            let new = if start.1 { -1 } else { 1 };
            assert_eq!(switched(start, true, true), (0, new));
        }
    }

    #[test]
    fn a_volume_command_moves_that_volume_alone_with_its_sign_whatever_the_sign_before() {
        for start in STARTS {
            for sign in [1, -1] {
                for volume in [Volume::None, Volume::Small, Volume::Large] {
                    let stroke = valves(start).obey(Command { volume, sign });
                    let large = if volume == Volume::Large { sign } else { 0 };
                    let small = if volume == Volume::Small { sign } else { 0 };
                    assert_eq!((stroke.large, stroke.small), (large, small));
                    assert_eq!(stroke.polarity, sign);
                }
            }
        }
    }

    fn large(sign: i8) -> Command {
        Command {
            volume: Volume::Large,
            sign,
        }
    }

    #[test]
    fn with_the_direction_valve_stuck_every_volume_goes_one_way_but_for_the_change_itself() {
        let mut valves = Valves::settled(1);
        valves.set_stuck(Some(StuckValve::Direction));
        let moved = [1, 1, -1, -1, -1].map(|sign| valves.obey(large(sign)).large);
        assert_eq!(moved, [1, 1, 0, 1, 1]);
        // Let go, it is where its driver holds it: a change of direction at last.
        valves.set_stuck(None);
        let freed = valves.obey(Command {
            volume: Volume::None,
            sign: -1,
        });
        assert_eq!((freed.large, freed.polarity), (-1, -1));
    }

    #[test]
    fn with_the_actuating_valve_stuck_only_changes_of_direction_move_a_volume() {
        let mut valves = Valves::settled(1);
        valves.set_stuck(Some(StuckValve::Actuating));
        let moved = [1, 1, -1, -1, 1, 1].map(|sign| valves.obey(large(sign)).large);
        assert_eq!(moved, [0, 0, -1, 0, 1, 0]);
        // And in precision mode, where none should move, each does.
        let turned = valves.obey(Command {
            volume: Volume::None,
            sign: -1,
        });
        assert_eq!(turned.large, -1);
    }
}
