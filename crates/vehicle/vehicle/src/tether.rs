//! The tether: a line from the surface that is drawn through the water.
//!
//! The report names its drag as a possible cause where runs and model disagree, but gives no numbers. The model is a straight vertical line
//! of diameter `d` from a float that follows the vehicle; its length is the vehicle's depth. Both ends of the tether share the drag of the water:
//!
//! ```text
//! F = (rho C_D d z / 2) U^2 / 2           M = h F
//! ```
//!
//! The force on the vehicle acts backwards at the height `h` above the body's origin, so it turns the bow up. The tether's weight in water is zero;
//! the effect of pitch on the direction of `F` in body axes is neglected.

/// A tether, in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tether {
    /// `d` \[m\]; 0: no tether.
    pub diameter: f64,
    /// `C_D` across the line; 1.2 for a smooth line.
    pub drag_coefficient: f64,
    /// `h` \[m\], height of the attachment.
    pub above: f64,
}

impl Tether {
    /// `F / U^2` \[kg/m\] at a depth \[m\] in water of `density` \[kg/m^3\].
    #[must_use]
    pub fn drag_per_square_speed(&self, depth: f64, density: f64) -> f64 {
        0.25 * density * self.drag_coefficient * self.diameter * depth.max(0.0)
    }

    /// Pitch moment `M` \[N m\], positive bow up.
    #[must_use]
    pub fn moment(&self, depth: f64, speed: f64, density: f64) -> f64 {
        self.above * self.drag_per_square_speed(depth, density) * speed * speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: Tether = Tether {
        diameter: 0.003,
        drag_coefficient: 1.2,
        above: 0.05,
    };

    #[test]
    fn the_drag_grows_with_depth_and_with_the_square_of_the_speed() {
        let moment = LINE.moment(1.0, 0.3, 1000.0);
        assert!(moment > 0.0, "bow up");
        assert!((LINE.moment(2.0, 0.3, 1000.0) / moment - 2.0).abs() < 1e-12);
        assert!((LINE.moment(1.0, 0.6, 1000.0) / moment - 4.0).abs() < 1e-12);
        // Half of 1000 x 1.2 x 0.003 x 1 / 2 x 0.09 N.
        let force = LINE.drag_per_square_speed(1.0, 1000.0) * 0.09;
        assert!((force - 0.081).abs() < 1e-12);
    }

    #[test]
    fn no_line_no_drag() {
        assert_eq!(Tether::default().moment(10.0, 1.0, 1000.0), 0.0);
    }
}
