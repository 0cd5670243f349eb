//! The two valves and the calibrating piston between them (Appendix A).
//!
//! The actuating valve and the direction (sign) valve each have two settled positions. Together
//! they decide which end the calibrating piston is pressed to: the exclusive nor of the two.
//! When that end changes, the piston strokes and one calibrated volume V_c moves, into the
//! ram's left chamber with the direction valve to the right, out of it with the valve to the
//! left.
//!
//! | switched | volume |
//! |---|---|
//! | actuating valve | one quantum in the present direction |
//! | direction valve | one quantum in the new direction |
//! | both together | none: direction and drift polarity change alone |
//!
//! This is why a volume command in parallel with a change of sign is inhibited (Section
//! II.A.1): "the transfer of a calibrated volume follows the switching of the sign valve", and
//! no volume is lost.

use crate::pulse_logic::Command;

/// The settled positions of both valves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Valves {
    actuating_up: bool,
    direction_right: bool,
}

/// What one switching moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stroke {
    /// Calibrated volumes moved: +1, 0 or -1.
    pub quanta: i8,
    /// The direction valve's position: +1 right, -1 left. The drift has its polarity.
    pub polarity: i8,
}

impl Valves {
    /// Both valves settled, the direction valve to the right for +1 and to the left for -1.
    #[must_use]
    pub fn settled(polarity: i8) -> Self {
        Self {
            actuating_up: true,
            direction_right: polarity >= 0,
        }
    }

    /// Which end the calibrating piston is pressed to.
    #[must_use]
    fn piston_end(self) -> bool {
        self.actuating_up == self.direction_right
    }

    /// Switches the valves named and moves what follows.
    pub fn switch(&mut self, actuating: bool, direction: bool) -> Stroke {
        let before = self.piston_end();
        self.actuating_up ^= actuating;
        self.direction_right ^= direction;
        let polarity = if self.direction_right { 1 } else { -1 };
        Stroke {
            quanta: if self.piston_end() == before {
                0
            } else {
                polarity
            },
            polarity,
        }
    }

    /// Carries out a pulse command (Figure 2-3). A sign that stays gates the volume to the
    /// actuating valve. A sign that changes switches the direction valve, and the volume in
    /// parallel is inhibited, since that switching moves one; without a volume asked for, both
    /// valves switch and none moves.
    pub fn obey(&mut self, command: Command) -> Stroke {
        let sign_changes = (command.sign > 0) != self.direction_right;
        self.switch(command.volume != sign_changes, sign_changes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STARTS: [(bool, bool); 4] = [(true, true), (true, false), (false, true), (false, false)];

    fn valves((actuating_up, direction_right): (bool, bool)) -> Valves {
        Valves {
            actuating_up,
            direction_right,
        }
    }

    #[test]
    fn the_actuating_valve_alone_moves_one_quantum_in_the_present_direction() {
        for start in STARTS {
            let present = if start.1 { 1 } else { -1 };
            let stroke = valves(start).switch(true, false);
            assert_eq!((stroke.quanta, stroke.polarity), (present, present));
        }
    }

    #[test]
    fn the_direction_valve_alone_moves_one_quantum_in_the_new_direction() {
        for start in STARTS {
            let new = if start.1 { -1 } else { 1 };
            let stroke = valves(start).switch(false, true);
            assert_eq!((stroke.quanta, stroke.polarity), (new, new));
        }
    }

    #[test]
    fn both_valves_together_change_the_direction_and_move_nothing() {
        for start in STARTS {
            let new = if start.1 { -1 } else { 1 };
            let stroke = valves(start).switch(true, true);
            assert_eq!((stroke.quanta, stroke.polarity), (0, new));
        }
    }

    #[test]
    fn a_volume_command_moves_one_quantum_with_its_sign_whatever_the_sign_before() {
        for start in STARTS {
            for sign in [1, -1] {
                for volume in [true, false] {
                    let stroke = valves(start).obey(Command { volume, sign });
                    let quanta = if volume { sign } else { 0 };
                    assert_eq!((stroke.quanta, stroke.polarity), (quanta, sign));
                }
            }
        }
    }
}
