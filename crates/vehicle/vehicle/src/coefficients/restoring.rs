//! The static moment of weight and buoyancy (Brunner 1988, p. 46).
//!
//! `M = -W BG sin(theta)`; for small angles `W BG` per rad. Divided by `m0 U^2`, `M'theta` decreases with the square of the speed, unlike
//! the other coefficients.

use super::reference::Reference;

/// `W BG` \[N m/rad\] of a neutrally buoyant vehicle with its centre of gravity `arm` \[m\] below the centre of buoyancy.
#[must_use]
pub fn stiffness(weight: f64, arm: f64) -> f64 {
    weight * arm
}

/// `M'theta` at the speed of `reference`.
#[must_use]
pub fn m_theta(weight: f64, arm: f64, reference: &Reference) -> f64 {
    -stiffness(weight, arm) / reference.moment()
}
