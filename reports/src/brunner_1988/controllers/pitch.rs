//! Pitch loop: proportional control with rate feedback (Brunner, NPS thesis, 1988, pp. 9 f. and 19).
//!
//! ```text
//!  theta               Kpy Ky
//! ------- = -----------------------------------
//! theta_c    J s^2 + (By + Kr Ky) s + Kpy Ky
//! ```
//! The report omits the restoring moment until p. 48.

use planesman_control::gains::PitchModel;

use super::axis::{DampedInertia, Gains};

/// Constants `J = 0.6` ft lbf s^2, `By = 0.06` ft lbf s, `Ky = 0.14` ft lbf/rad (Table 3; sign of `Ky` as in program T6).
pub const AXIS: DampedInertia = DampedInertia {
    inertia: 0.6,
    damping: 0.06,
    plane_moment: 0.14,
    restoring: 0.0,
};

/// `K/J` and `B/J` of the vehicle, in the form of the controller's design functions.
#[must_use]
pub fn model() -> PitchModel {
    PitchModel {
        plane: AXIS.plane_moment / AXIS.inertia,
        damping: AXIS.damping / AXIS.inertia,
        restoring: AXIS.restoring / AXIS.inertia,
    }
}

/// Restoring moment `Me` for small angles, ft lbf/rad (p. 48).
pub const RESTORING: f64 = 0.163;

/// The report's gains `Kpy = 0.7`, `Kr = 2` s (p. 10).
pub const GAINS: Gains = Gains { p: 0.7, rate: 2.0 };

/// Effective damping of the second design, ft lbf s (p. 19).
pub const MORE_DAMPING: f64 = 0.72;

/// Pitch error at which the planes of a vehicle at rest reach `plane_limit`, in the limit's unit.
#[must_use]
pub fn error_at_plane_limit(p: f64, plane_limit: f64) -> f64 {
    plane_limit / p
}
