//! Variants of the vehicle with a part of its equations changed or removed, as in the thesis.
//!
//! Brunner 1988 switches heave, the restoring moment and the moment of heave `M_w` on and off, and describes pitch damping in two ways.
//! With the hull's coefficient `M'q`, damping is proportional to the speed. From the drag of the hull rotating broadside (Ch. II) it is
//!
//! ```text
//! M = -N |q| q      N = rho C_D A L^3 / 96
//! ```
//!
//! for all speeds. For linear analysis it is replaced at some rate `q0` by the secant `N q0` (By = 0.06 ft lbf s at 0.15 rad/s) or the
//! tangent `2 N q0`.

use crate::{axis::Axis, vehicle::Derivatives};
use planesman_units::{FOOT, POUND_FORCE};

/// `N` \[N m s^2/rad^2\] of the thesis' vehicle in pitch: 0.4193 ft lbf s^2 from a plate of 28 in by 7 in with `C_D = 1.2` (Ch. II, which
/// prints 0.418).
pub const BRUNNER_VISCOUS_DAMPING: f64 = 0.4193 * FOOT * POUND_FORCE;

/// Pitch rate \[rad/s\] of the thesis' secant.
pub const BRUNNER_SECANT_RATE: f64 = 0.15;

/// Law of the pitch damping.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PitchDamping {
    /// `M_q q + M_qq q|q|`, with the vehicle's own coefficients at its speed; the other laws replace both.
    #[default]
    Coefficient,
    /// `-N q0 q`: exact at the pitch rate `q0`, too large below it.
    Secant {
        /// `N` \[N m s^2/rad^2\].
        viscous: f64,
        /// `q0` \[rad/s\].
        rate: f64,
    },
    /// `-2 N q0 q`: exact for small changes about the pitch rate `q0`.
    Tangent {
        /// `N` \[N m s^2/rad^2\].
        viscous: f64,
        /// `q0` \[rad/s\].
        rate: f64,
    },
    /// `-N |q| q`.
    Quadratic {
        /// `N` \[N m s^2/rad^2\].
        viscous: f64,
    },
}

/// The changes. The default changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Law of the pitch damping.
    pub damping: PitchDamping,
    /// Whether the vehicle heaves; without heave it moves in the direction of its bow.
    pub heave: bool,
    /// Whether heave causes a pitch moment: `M_w`, and `M_ww` and `M_wdot` if present.
    pub heave_moment: bool,
    /// Whether there is a restoring moment `W BG`, in pitch and in roll.
    pub restoring_moment: bool,
}

impl Default for Variant {
    fn default() -> Self {
        Self {
            damping: PitchDamping::Coefficient,
            heave: true,
            heave_moment: true,
            restoring_moment: true,
        }
    }
}

impl Variant {
    /// Derivatives of the changed vehicle.
    #[must_use]
    pub fn apply(&self, mut d: Derivatives) -> Derivatives {
        match self.damping {
            PitchDamping::Coefficient => {}
            PitchDamping::Secant { viscous, rate } => (d.m_q, d.m_qq) = (-viscous * rate, 0.0),
            PitchDamping::Tangent { viscous, rate } => {
                (d.m_q, d.m_qq) = (-2.0 * viscous * rate, 0.0)
            }
            PitchDamping::Quadratic { viscous } => (d.m_q, d.m_qq) = (-0.0, -viscous),
        }
        if !self.heave {
            (d.z_w, d.z_q_plus_m_u, d.z_delta) = (0.0, 0.0, 0.0);
            (d.z_differential, d.z_ww, d.z_qq, d.z_q_dot) = (0.0, 0.0, 0.0, 0.0);
            (d.first_moment, d.excess_weight) = (0.0, 0.0);
        }
        if !self.heave_moment {
            (d.m_w, d.m_ww, d.m_w_dot) = (0.0, 0.0, 0.0);
        }
        if !self.restoring_moment {
            d.restoring = 0.0;
        }
        d
    }

    /// Roll plant of the changed vehicle.
    #[must_use]
    pub fn apply_to_roll(&self, roll: Axis) -> Axis {
        Axis {
            restoring: if self.restoring_moment {
                roll.restoring
            } else {
                0.0
            },
            ..roll
        }
    }
}

#[cfg(test)]
mod tests {
    use planesman_units::FOOT_POUND;

    use super::*;
    use crate::{Restoring, State, vehicle_file::brunner};

    fn damped(damping: PitchDamping) -> Derivatives {
        let variant = Variant {
            damping,
            ..Variant::default()
        };
        variant.apply(brunner().derivatives(FOOT))
    }

    /// The damping moment \[N m\] at a pitch rate \[rad/s\].
    fn moment(d: &Derivatives, pitch_rate: f64) -> f64 {
        let state = State {
            pitch_rate,
            ..State::default()
        };
        d.pitch_acceleration(&state, 0.0, Restoring::Sine) * d.pitch_inertia
    }

    #[test]
    fn the_default_variant_is_the_vehicle() {
        let d = brunner().derivatives(FOOT);
        assert_eq!(Variant::default().apply(d), d);
    }

    #[test]
    fn the_secant_is_the_printed_by_and_the_tangent_twice_that() {
        // Ch. II: By 0.06 (0.0629); tangent 0.1258 at 0.15 rad/s and 0.836 (0.8386) at 1 rad/s.
        let (viscous, rate) = (BRUNNER_VISCOUS_DAMPING, BRUNNER_SECANT_RATE);
        let secant = damped(PitchDamping::Secant { viscous, rate });
        assert!((-secant.m_q / FOOT_POUND - 0.0629).abs() < 1e-4);
        let tangent = damped(PitchDamping::Tangent { viscous, rate });
        assert!((tangent.m_q / secant.m_q - 2.0).abs() < 1e-12);
        let fast = damped(PitchDamping::Tangent { viscous, rate: 1.0 });
        assert!((-fast.m_q / FOOT_POUND - 0.836).abs() < 3e-3);
    }

    #[test]
    fn the_secant_meets_the_parabola_at_its_rate_and_the_tangent_its_slope() {
        let (viscous, rate) = (BRUNNER_VISCOUS_DAMPING, BRUNNER_SECANT_RATE);
        let parabola = damped(PitchDamping::Quadratic { viscous });
        let secant = damped(PitchDamping::Secant { viscous, rate });
        let tangent = damped(PitchDamping::Tangent { viscous, rate });
        assert!((moment(&parabola, rate) - moment(&secant, rate)).abs() < 1e-15);
        let slope = (moment(&parabola, rate + 1e-6) - moment(&parabola, rate - 1e-6)) / 2e-6;
        assert!((slope - tangent.m_q).abs() < 1e-6);
        assert!((moment(&parabola, -rate) + moment(&parabola, rate)).abs() < 1e-18);
    }

    #[test]
    fn a_vehicle_with_drag_of_its_own_in_pitch_has_the_named_damping_in_its_place() {
        let d = crate::vehicle_file::remus_100().derivatives(1.5);
        assert!(d.m_qq < 0.0);
        let secant = Variant {
            damping: PitchDamping::Secant {
                viscous: 4.0,
                rate: 0.5,
            },
            heave_moment: false,
            ..Variant::default()
        }
        .apply(d);
        assert_eq!((secant.m_q, secant.m_qq), (-2.0, 0.0));
        assert_eq!((secant.m_w, secant.m_ww, secant.m_w_dot), (0.0, 0.0, 0.0));
    }

    #[test]
    fn what_is_turned_off_acts_no_more() {
        let all_off = Variant {
            heave: false,
            heave_moment: false,
            restoring_moment: false,
            ..Variant::default()
        };
        let d = all_off.apply(brunner().derivatives(FOOT));
        let state = State {
            pitch: 0.3,
            heave: 0.1,
            pitch_rate: 0.2,
            ..State::default()
        };
        assert_eq!(d.heave_acceleration(&state, 0.5), 0.0);
        let still = State {
            pitch_rate: 0.0,
            ..state
        };
        assert_eq!(d.pitch_acceleration(&still, 0.0, Restoring::Sine), 0.0);
    }
}
