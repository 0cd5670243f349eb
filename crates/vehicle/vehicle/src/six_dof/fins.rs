//! Fins as lifting surfaces in the flow at their own position, including stall.
//!
//! ```text
//! V_f = v + w x r     V_c = e_c . V_f     V_n = e_n . V_f     alpha = delta - atan2(V_n, V_c)
//! F = 1/2 rho S V [ C_L (-V_n e_c + V_c e_n) - C_D (V_c e_c + V_n e_n) ]
//! ```
//!
//! Stall follows Beard and McLain, Small Unmanned Aircraft (2012), (4.9) to (4.11): near the stall angle, lift and drag change from those of a thin
//! wing to those of a flat plate. For small angles and `V_c = u` the force is `1/2 rho S a (u^2 delta - u v - x u r)`: Prestero 2001, (4.43).

use std::f64::consts::{PI, TAU};

use super::lanes::{Real, Six, Three, cross, dot, of, scaled, six, sum};

/// Section and shape of a fin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// `a`, lift slope \[1/rad\].
    pub slope: f64,
    /// `C_D0`, drag coefficient without lift.
    pub drag: f64,
    /// `e`, Oswald's efficiency.
    pub oswald: f64,
    /// `AR`, aspect ratio.
    pub aspect: f64,
    /// Stall angle \[rad\].
    pub stall: f64,
    /// Sharpness of the transition to stall, per rad.
    pub sharpness: f64,
}

impl Section {
    /// Lift and drag coefficient at an angle of attack \[rad\].
    #[must_use]
    pub fn lift_and_drag(&self, alpha: f64) -> (f64, f64) {
        let (k, s) = (self.sharpness, self.stall);
        let (below, above) = (libm::exp(-k * (alpha - s)), libm::exp(k * (alpha + s)));
        let stalled = match (1.0 + below) * (1.0 + above) {
            product if product.is_finite() => (1.0 + below + above) / product,
            _ => 1.0,
        };
        let (sin, cos) = libm::sincos(alpha);
        let thin = self.slope * alpha;
        let lift = (1.0 - stalled) * thin + 2.0 * stalled * sin * sin.abs() * cos;
        let induced = thin * thin / (PI * self.oswald * self.aspect);
        let drag = self.drag + (1.0 - stalled) * induced + 2.0 * stalled * (sin * sin * sin).abs();
        (lift, drag)
    }
}

/// A fin of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fin {
    /// Index of the vehicle's input that is its angle \[rad\].
    pub input: usize,
    /// Position of its centre of pressure from the origin \[m\].
    pub position: Three<f64>,
    /// Unit vector along the chord at angle 0, forward.
    pub chord: Three<f64>,
    /// Unit vector of the force at a positive angle in forward motion, normal to the chord.
    pub normal: Three<f64>,
    /// \[m^2\]
    pub area: f64,
    /// Density of the water \[kg/m^3\].
    pub density: f64,
    /// The section.
    pub section: Section,
}

impl Fin {
    /// Force and moment about the origin at an angle, for a velocity through the water.
    #[inline(always)]
    pub(super) fn force<T: Real>(&self, nu: &Six<T>, angle: T) -> Six<T> {
        let [u, v, w, p, q, r] = *nu;
        let (position, chord, normal) = (of(&self.position), of(&self.chord), of(&self.normal));
        let flow = sum([u, v, w], cross([p, q, r], position));
        let (along, across) = (dot(chord, flow), dot(normal, flow));
        let inflow = across.with(along, libm::atan2);
        let alpha = (angle - inflow).map(wrapped);
        let lift = alpha.map(|a| self.section.lift_and_drag(a).0);
        let drag = alpha.map(|a| self.section.lift_and_drag(a).1);
        let speed = (along * along + across * across).sqrt();
        let scale = T::of(0.5 * self.density * self.area) * speed;
        let force = sum(
            scaled(-(scale * (lift * across + drag * along)), chord),
            scaled(scale * (lift * along - drag * across), normal),
        );
        six(force, cross(position, force))
    }
}

/// The equivalent angle in -pi to pi.
fn wrapped(angle: f64) -> f64 {
    match angle {
        a if a > PI => a - TAU,
        a if a <= -PI => a + TAU,
        a => a,
    }
}
