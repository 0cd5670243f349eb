//! Roll and course: plants of one axis, as the report's controllers see them.
//!
//! ```text
//! J a'' + B a' + C a = K (U / U0)^2 delta
//! ```
//!
//! Brunner 1988, ch. II (pp. 30 to 32): roll `K / (J s^2 + B s + C)` with `C = W BG`, course
//! `K / (J s^2 + B s)`. `K` is printed for `U0` = 1 ft/s; what a plane gives grows with the square of
//! the speed. The damping is the report's secant at 0.15 rad/s, whatever the speed.
//!
//! The equation is linear, so a step with the moment held is taken exactly, by the zero-order
//! hold of the linear system, and costs four products.

use planesman_linear::{DMatrix, Error, StateSpace};

/// A plant of one axis, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// `K` \[N m/rad\], the moment per plane angle at [`reference_speed`](Self::reference_speed).
    pub gain: f64,
    /// `U0` \[m/s\].
    pub reference_speed: f64,
    /// `J` \[kg m^2\], with the water that moves along.
    pub inertia: f64,
    /// `B` \[N m s/rad\].
    pub damping: f64,
    /// `C` \[N m/rad\].
    pub restoring: f64,
}

/// An angle and its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// \[rad\], not wrapped.
    pub angle: f64,
    /// \[rad/s\]
    pub rate: f64,
}

/// An [`Axis`] over a step of one length, the moment held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldAxis {
    /// `exp(A dt)`, by rows.
    transition: [[f64; 2]; 2],
    /// The change under a held moment of 1 N m.
    input: [f64; 2],
}

impl Axis {
    /// The moment \[N m\] of a plane angle \[rad\] at a speed \[m/s\].
    #[must_use]
    pub fn moment(&self, speed: f64, delta: f64) -> f64 {
        let share = speed / self.reference_speed;
        self.gain * share * share * delta
    }

    /// The linear system with the moment \[N m\] in and angle and rate out.
    ///
    /// # Errors
    /// [`Error::NotFinite`] when the numbers overflow.
    pub fn state_space(&self) -> Result<StateSpace, Error> {
        let (c, b) = (self.restoring / self.inertia, self.damping / self.inertia);
        StateSpace::new(
            DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -c, -b]),
            DMatrix::from_row_slice(2, 1, &[0.0, 1.0 / self.inertia]),
            DMatrix::identity(2, 2),
            DMatrix::zeros(2, 1),
        )
    }

    /// The plant over steps of `dt` \[s\].
    ///
    /// # Errors
    /// As [`Axis::state_space`], or when `dt` is not above zero.
    pub fn held_over(&self, dt: f64) -> Result<HeldAxis, Error> {
        let StateSpace { a, b, .. } = self.state_space()?.zero_order_hold(dt)?;
        Ok(HeldAxis {
            transition: [[a[(0, 0)], a[(0, 1)]], [a[(1, 0)], a[(1, 1)]]],
            input: [b[(0, 0)], b[(1, 0)]],
        })
    }
}

impl HeldAxis {
    /// The state after a step under a held moment \[N m\].
    #[must_use]
    pub fn step(&self, from: Turn, moment: f64) -> Turn {
        let [[aa, ar], [ra, rr]] = self.transition;
        let [a, r] = self.input;
        Turn {
            angle: aa * from.angle + ar * from.rate + a * moment,
            rate: ra * from.angle + rr * from.rate + r * moment,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle_file::brunner;
    use planesman_units::FOOT;

    fn settled(axis: &Axis, delta: f64, dt: f64, seconds: f64) -> Turn {
        let held = axis.held_over(dt).expect("a plant");
        let moment = axis.moment(FOOT, delta);
        (0..(seconds / dt).round() as u32).fold(Turn::default(), |turn, _| held.step(turn, moment))
    }

    #[test]
    fn a_step_of_any_length_leads_to_the_same_angle() {
        for axis in [brunner().roll, brunner().course] {
            let axis = axis.expect("the report's");
            let (fine, coarse) = (
                settled(&axis, 0.2, 0.001, 7.0),
                settled(&axis, 0.2, 0.5, 7.0),
            );
            assert!((fine.angle - coarse.angle).abs() < 1e-12);
            assert!((fine.rate - coarse.rate).abs() < 1e-12);
        }
    }

    #[test]
    fn a_held_rudder_turns_the_vehicle_at_the_rate_that_damping_allows() {
        // K / B delta = 0.07 / 0.03 x 0.1 rad/s at 1 ft/s, after some time constants of 10 s.
        let course = brunner().course.expect("the report's");
        let turn = settled(&course, 0.1, 0.01, 300.0);
        assert!((turn.rate - 0.07 / 0.03 * 0.1).abs() < 1e-9);
        assert!(turn.angle > 0.0, "to starboard");
    }

    #[test]
    fn a_held_roll_differential_heels_the_vehicle_until_the_weight_holds_it() {
        let roll = brunner().roll.expect("the report's");
        let turn = settled(&roll, 0.1, 0.05, 2000.0);
        // K delta / (W BG) = 0.02 x 0.1 / 0.16333 rad.
        assert!((turn.angle - 0.02 * 0.1 / 0.163_333).abs() < 1e-7);
        assert!(turn.rate.abs() < 1e-9);
    }

    #[test]
    fn twice_the_speed_gives_four_times_the_moment() {
        let roll = brunner().roll.expect("the report's");
        assert!((roll.moment(2.0 * FOOT, 0.1) / roll.moment(FOOT, 0.1) - 4.0).abs() < 1e-12);
    }
}
