//! Roll and yaw: single-axis plants, as in the report's controllers.
//!
//! ```text
//! J a'' + B a' + C a = K (U / U0)^2 delta
//! ```
//!
//! Brunner 1988, ch. II (pp. 30 to 32): roll `K / (J s^2 + B s + C)` with `C = W BG`, yaw `K / (J s^2 + B s)`. The report gives `K` for
//! `U0` = 1 ft/s; the moment of a plane grows with the square of the speed. The damping is the report's secant at 0.15 rad/s, for all
//! speeds.

use serde::Deserialize;

use crate::positive;

/// A single-axis plant, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// `K` \[N m/rad\], moment per plane angle at [`reference_speed`](Self::reference_speed).
    #[serde(with = "positive::moment")]
    pub gain: f64,
    /// `U0` \[m/s\].
    #[serde(with = "positive::speed")]
    pub reference_speed: f64,
    /// `J` \[kg m^2\], including the added inertia of the water.
    #[serde(with = "positive::inertia")]
    pub inertia: f64,
    /// `B` \[N m s/rad\].
    #[serde(with = "positive::rotary_damping")]
    pub damping: f64,
    /// `C` \[N m/rad\].
    #[serde(skip)]
    pub restoring: f64,
}

/// An angle and its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisState {
    /// Angle \[rad\], not wrapped.
    pub angle: f64,
    /// \[rad/s\]
    pub rate: f64,
}

impl Axis {
    /// Moment \[N m\] for a plane angle \[rad\] at a speed \[m/s\].
    #[must_use]
    pub fn moment(&self, speed: f64, delta: f64) -> f64 {
        let share = speed / self.reference_speed;
        self.gain * share * share * delta
    }

    /// `a''` \[rad/s^2\] for a state at a speed \[m/s\] and a plane angle \[rad\].
    #[must_use]
    pub fn acceleration(&self, state: AxisState, speed: f64, delta: f64) -> f64 {
        let moment = self.moment(speed, delta);
        (moment - self.damping * state.rate - self.restoring * state.angle) / self.inertia
    }
}

#[cfg(test)]
mod tests {
    use crate::vehicle_file::brunner;
    use planesman_units::FOOT;

    #[test]
    fn twice_the_speed_gives_four_times_the_moment() {
        let roll = brunner().roll.expect("the report's");
        assert!((roll.moment(2.0 * FOOT, 0.1) / roll.moment(FOOT, 0.1) - 4.0).abs() < 1e-12);
    }
}
