//! Lift of hull and fins, and the resulting coefficients (Brunner 1988, pp. 43-46).
//!
//! The hull is treated as a wing of very low aspect ratio by Jones' formula. The fins follow equation 23 of *Principles of Naval
//! Architecture*, ch. IX, without sweep:
//!
//! ```text
//! hull  C_La = pi AR / 2                    fin  C_La = 0.9 (2 pi) a / (sqrt(a^2 + 4) + 1.8)
//! ```
//!
//! `a` is the effective aspect ratio, twice the geometric one, since the hull mirrors a fin. The lift `Z = -rho/2 C_La S U w` at the arm
//! `x` (forward positive) gives
//!
//! ```text
//! Z_w = -rho/2 C_La S U     M_w = Z_q = -x Z_w     M_q = x^2 Z_w
//! ```

use std::f64::consts::{PI, TAU};

/// Jones' lift slope \[1/rad\] at the aspect ratio `ar`; valid below about 0.2.
#[must_use]
pub fn jones_slope(ar: f64) -> f64 {
    PI * ar / 2.0
}

/// A fin's lift slope \[1/rad\] at the effective aspect ratio `a`.
#[must_use]
pub fn fin_slope(a: f64) -> f64 {
    0.9 * TAU * a / (a.mul_add(a, 4.0).sqrt() + 1.8)
}

/// `S/S0`, the factor from a lift slope on the area `s` \[m^2\] to a nondimensional force, for a reference mass `m0` and length `l`:
/// `rho S L / (2 m0)`.
#[must_use]
pub fn area_ratio(rho: f64, s: f64, m0: f64, l: f64) -> f64 {
    0.5 * rho * s * l / m0
}

/// A lifting surface, nondimensional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// `Z'w`: minus the lift slope times the area ratio.
    pub z_w: f64,
    /// Position of the lift, in lengths `L` forward of the centre of gravity.
    pub arm: f64,
}

impl Surface {
    /// `M'w = -x' Z'w`: lift forward of the centre turns the bow up.
    #[must_use]
    pub fn m_w(&self) -> f64 {
        -self.arm * self.z_w
    }

    /// `Z'q`. When the bow turns up, a point forward of the centre moves up: its `w` is `-x q`.
    #[must_use]
    pub fn z_q(&self) -> f64 {
        -self.arm * self.z_w
    }

    /// `M'q = x'^2 Z'w`.
    #[must_use]
    pub fn m_q(&self) -> f64 {
        self.arm * self.arm * self.z_w
    }

    /// `Z'delta` of a surface whose positive angle presses it down.
    #[must_use]
    pub fn z_delta(&self) -> f64 {
        -self.z_w
    }

    /// `M'delta` of the same surface: a downward force forward of the centre turns the bow down.
    #[must_use]
    pub fn m_delta(&self) -> f64 {
        -self.arm * self.z_delta()
    }
}

/// Lift of several surfaces, with the dive planes at opposite angles: the forward planes press down while the aft planes lift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planes {
    /// The forward pair.
    pub forward: Surface,
    /// The aft pair.
    pub aft: Surface,
}

impl Planes {
    /// `Z'w` of both.
    #[must_use]
    pub fn z_w(&self) -> f64 {
        self.forward.z_w + self.aft.z_w
    }

    /// `M'w` of both.
    #[must_use]
    pub fn m_w(&self) -> f64 {
        self.forward.m_w() + self.aft.m_w()
    }

    /// `Z'q` of both.
    #[must_use]
    pub fn z_q(&self) -> f64 {
        self.forward.z_q() + self.aft.z_q()
    }

    /// `M'q` of both.
    #[must_use]
    pub fn m_q(&self) -> f64 {
        self.forward.m_q() + self.aft.m_q()
    }

    /// `Z'delta` with the forward planes pressing down and the aft planes up.
    #[must_use]
    pub fn z_delta(&self) -> f64 {
        self.forward.z_delta() - self.aft.z_delta()
    }

    /// `M'delta`; both pairs turn the bow down.
    #[must_use]
    pub fn m_delta(&self) -> f64 {
        self.forward.m_delta() - self.aft.m_delta()
    }
}

/// Position of the hull's lift in a turn, in lengths `L` from the centre: half the prismatic coefficient times the bare hull's length over
/// `L`. This is a reconstruction that gives the printed sum of `M'q`; the report only says that the prismatic coefficient enters (p. 45).
#[must_use]
pub fn turning_arm(prismatic: f64, bare_length: f64, l: f64) -> f64 {
    0.5 * prismatic * bare_length / l
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fin_of_great_span_comes_to_nine_tenths_of_a_thin_airfoil() {
        assert!((fin_slope(1e9) / (0.9 * TAU) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn dive_planes_in_opposition_turn_the_bow_down_and_damp() {
        let planes = Planes {
            forward: Surface {
                z_w: -0.3,
                arm: 0.3,
            },
            aft: Surface {
                z_w: -0.2,
                arm: -0.6,
            },
        };
        assert!(planes.z_delta() > 0.0 && planes.m_delta() < 0.0 && planes.m_q() < 0.0);
        // An aft fin holds the bow into the stream: its M'w is below zero.
        assert!(planes.aft.m_w() < 0.0 && planes.forward.m_w() > 0.0);
    }
}
