//! Heading loop: proportional control with rate feedback to the rudders (Brunner, NPS thesis, 1988, p. 32, Fig. 21).
//!
//! ```text
//!  psi             Kp Kz
//! ----- = ------------------------------
//! psi_c    J s^2 + (Bz + Kdy Kz) s + Kp Kz
//! ```
//! There is no restoring moment in heading.

use super::axis::{DampedInertia, Gains};

/// Constants `Jz = 0.30` ft lbf s^2, `Bz = 0.03` ft lbf s, `Kz = 0.07` ft lbf/rad (Table 3).
pub const AXIS: DampedInertia = DampedInertia {
    inertia: 0.30,
    damping: 0.03,
    plane_moment: 0.07,
    restoring: 0.0,
};

/// The report's gains `Kp = 1`, `Kdy = 3` s.
pub const GAINS: Gains = Gains { p: 1.0, rate: 3.0 };
