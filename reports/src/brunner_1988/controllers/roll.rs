//! Roll loop: proportional control with rate feedback (Brunner, NPS thesis, 1988, p. 30, Fig. 20).
//!
//! ```text
//! phi               Kpx Kx
//! ----- = -------------------------------------
//! phi_c    J s^2 + (Bx + Kdx Kx) s + Kpx Kx + Me
//! ```
//! With a restoring moment the steady-state roll is `Kpx Kx / (Kpx Kx + Me)` of the command.

use super::axis::{DampedInertia, Gains};

/// Constants `Jx = 0.04` ft lbf s^2, `Bx = 0.001` ft lbf s, `Kx = 0.02` ft lbf/rad (Table 3).
pub const AXIS: DampedInertia = DampedInertia {
    inertia: 0.04,
    damping: 0.001,
    plane_moment: 0.02,
    restoring: 0.0,
};

/// `Me` used by the report for roll, ft lbf/rad (Fig. 20).
pub const RESTORING: f64 = 0.1;

/// `Me = W BG` for 19.6 lbf and 0.1 in, the same as in pitch, with five digits, ft lbf/rad.
pub const WEIGHT_RESTORING: f64 = 0.163_33;

/// The report's gains `Kpx = 10`, `Kdx = 10` s.
pub const GAINS: Gains = Gains {
    p: 10.0,
    rate: 10.0,
};
