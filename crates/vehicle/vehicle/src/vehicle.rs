//! A vehicle: particulars, nondimensional coefficients, and derivatives at a speed.
//!
//! Coefficients are nondimensional as in Brunner 1988 (Table 1, p. 41), with the reference length `L` and the reference mass
//! `m0 = rho L^2 T / 2` (Table 2). The dimensional values at the speed `U` follow from the factors
//!
//! ```text
//! Z_wdot  m0        Z_w  m0 U / L    Z_q  m0 U      Z_delta  m0 U^2 / L
//! M_qdot  m0 L^2    M_w  m0 U        M_q  m0 L U    M_delta  m0 U^2
//!
//! Z_ww   m0 / L     Z_qq m0 L    Z_qdot  m0 L
//! M_ww   m0         M_qq m0 L^2  M_wdot  m0 L
//! ```
//!
//! So damping grows with the speed, and plane forces with its square. Cross-flow drag (second line) and the restoring moment
//! `W BG sin(theta)` do not depend on the speed. Without cross-flow drag there is no damping at rest: linear coefficients apply to a
//! vehicle under way. Coefficients published in SI units (Prestero 2001: `Z_uw` \[kg/m\] etc.) use `L` = 1 m and `m0` = 1 kg.
//!
//! Roll, yaw and propulsion are the report's single-axis plants (ch. II, [`Axis`], [`Propulsion`]); a vehicle may lack them.

use planesman_units::{Rule, readers};
use serde::Deserialize;

use crate::{axis::Axis, positive, propulsion::Propulsion};

readers! {
    // Coefficients have no dimension: those of vehicles are below 10.
    coefficient: Number, [-1e4, 1e4];
    place: Length, Rule::Any;
}

/// A vehicle, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Vehicle {
    /// Its name.
    pub name: String,
    /// `L` \[m\], reference length of the coefficients.
    pub reference_length: f64,
    /// `m0` \[kg\], reference mass of the coefficients.
    pub reference_mass: f64,
    /// `m` \[kg\].
    pub mass: f64,
    /// `W` \[N\].
    pub weight: f64,
    /// `B` \[N\]; equal to the weight if the vehicle is neutrally buoyant.
    pub buoyancy: f64,
    /// `BG` \[m\]: depth of the centre of gravity below the centre of buoyancy.
    pub restoring_arm: f64,
    /// `z_G` \[m\]: depth of the centre of gravity below the body's origin.
    pub gravity_below_origin: f64,
    /// Nondimensional coefficients.
    pub coefficients: Coefficients,
    /// Positions of the planes, which separate bow from stern planes; `None`: the planes only move together.
    pub planes: Option<PlaneArms>,
    /// Position of the depth sensor.
    pub depth_port: Port,
    /// Roll axis, driven by the roll differential; `None`: no roll.
    pub roll: Option<Axis>,
    /// Yaw axis, driven by the rudder; `None`: constant heading.
    pub yaw: Option<Axis>,
    /// Thrust and drag; `None`: the speed can only be held.
    pub propulsion: Option<Propulsion>,
}

/// Nondimensional coefficients of the vertical plane.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficients {
    /// `Z'wdot`: heave force per heave acceleration, negative (added mass).
    #[serde(with = "coefficient")]
    pub z_w_dot: f64,
    /// `Z'w`: heave force per heave velocity, negative (damping).
    #[serde(with = "coefficient")]
    pub z_w: f64,
    /// `Z'q`: heave force per pitch rate.
    #[serde(with = "coefficient")]
    pub z_q: f64,
    /// `Z'delta`: heave force per plane angle.
    #[serde(with = "coefficient")]
    pub z_delta: f64,
    /// `M'w`: pitch moment per heave velocity.
    #[serde(with = "coefficient")]
    pub m_w: f64,
    /// `M'q`: pitch moment per pitch rate, negative (damping).
    #[serde(with = "coefficient")]
    pub m_q: f64,
    /// `I'y - M'qdot`: moment of inertia including added inertia.
    #[serde(with = "coefficient")]
    pub i_y_minus_m_q_dot: f64,
    /// `M'delta`: pitch moment per plane angle.
    #[serde(with = "coefficient")]
    pub m_delta: f64,
    /// `Z'qdot`: heave force per pitch acceleration.
    #[serde(default, with = "coefficient")]
    pub z_q_dot: f64,
    /// `M'wdot`: pitch moment per heave acceleration.
    #[serde(default, with = "coefficient")]
    pub m_w_dot: f64,
    /// `Z'ww`: heave force per `w|w|`, at most 0 (cross-flow drag).
    #[serde(default, with = "coefficient")]
    pub z_ww: f64,
    /// `Z'qq`: heave force per `q|q|`.
    #[serde(default, with = "coefficient")]
    pub z_qq: f64,
    /// `M'ww`: pitch moment per `w|w|`.
    #[serde(default, with = "coefficient")]
    pub m_ww: f64,
    /// `M'qq`: pitch moment per `q|q|`, at most 0 (cross-flow drag).
    #[serde(default, with = "coefficient")]
    pub m_qq: f64,
}

/// Positions of the bow and stern planes' forces, along body x \[m\] from the body's origin and positive forward; the bow planes have the
/// larger value.
///
/// The coefficients `Z_delta` and `M_delta` apply to both pairs at the same angle. With the arms they determine the force of each pair:
///
/// ```text
/// Z_b + Z_s = Z_delta        -x_b Z_b - x_s Z_s = M_delta
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneArms {
    /// `x_b`
    #[serde(with = "place")]
    pub bow: f64,
    /// `x_s`
    #[serde(with = "place")]
    pub stern: f64,
    /// Moment arm of the ram that turns the planes \[m\], only for viewers; the actuator has its own. `None`: no ram is shown.
    #[serde(default, with = "positive::optional_length")]
    pub moment_arm: Option<f64>,
}

impl PlaneArms {
    /// `Z_b` and `Z_s` \[N/rad\] from `Z_delta` \[N/rad\] and `M_delta` \[N m/rad\].
    #[must_use]
    pub fn forces(&self, z_delta: f64, m_delta: f64) -> (f64, f64) {
        let z_bow = -(m_delta + self.stern * z_delta) / (self.bow - self.stern);
        (z_bow, z_delta - z_bow)
    }

    /// Force \[N/rad\] and moment \[N m/rad\] of bow and stern planes at opposite angles.
    fn differential(&self, z_delta: f64, m_delta: f64) -> (f64, f64) {
        let (z_bow, z_stern) = self.forces(z_delta, m_delta);
        (z_bow - z_stern, self.stern * z_stern - self.bow * z_bow)
    }
}

/// A position on the hull, from the body's origin.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Port {
    /// Position along body x \[m\], positive forward.
    #[serde(with = "place")]
    pub forward: f64,
    /// Position along body z \[m\], positive towards the keel.
    #[serde(with = "place")]
    pub below: f64,
}

/// Dimensional derivatives at one speed, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives {
    /// `U` \[m/s\].
    pub speed: f64,
    /// `m - Z_wdot` \[kg\].
    pub heave_inertia: f64,
    /// `Z_w` \[N s/m\].
    pub z_w: f64,
    /// `Z_q + m U` \[N s/rad\]: lift on the rotating hull, and the centripetal term.
    pub z_q_plus_m_u: f64,
    /// `Z_delta` \[N/rad\].
    pub z_delta: f64,
    /// `I_y - M_qdot` \[kg m^2\].
    pub pitch_inertia: f64,
    /// `M_w` \[N s\].
    pub m_w: f64,
    /// `M_q` \[N m s/rad\].
    pub m_q: f64,
    /// `M_delta` \[N m/rad\].
    pub m_delta: f64,
    /// `Z_b - Z_s` \[N/rad\], of bow planes against stern planes; 0 if they only move together.
    pub z_differential: f64,
    /// `x_s Z_s - x_b Z_b` \[N m/rad\].
    pub m_differential: f64,
    /// `W BG` \[N m\].
    pub restoring: f64,
    /// `Z_qdot` \[kg m\].
    pub z_q_dot: f64,
    /// `M_wdot` \[kg m\].
    pub m_w_dot: f64,
    /// `Z_ww` \[kg/m\].
    pub z_ww: f64,
    /// `Z_qq` \[kg m\].
    pub z_qq: f64,
    /// `M_ww` \[kg\].
    pub m_ww: f64,
    /// `M_qq` \[kg m^2\]: damping by the square of the pitch rate. `M_qq` is 0 for the report's coefficients, but not for every
    /// [`Variant`](crate::Variant).
    pub m_qq: f64,
    /// `m z_G` \[kg m\].
    pub first_moment: f64,
    /// `W - B` \[N\].
    pub excess_weight: f64,
}

impl Vehicle {
    /// Dimensional derivatives at the speed `u` \[m/s\].
    #[must_use]
    pub fn derivatives(&self, u: f64) -> Derivatives {
        let Coefficients {
            z_w_dot,
            z_w,
            z_q,
            z_delta,
            m_w,
            m_q,
            i_y_minus_m_q_dot,
            m_delta,
            z_q_dot,
            m_w_dot,
            z_ww,
            z_qq,
            m_ww,
            m_qq,
        } = self.coefficients;
        let (m0, l) = (self.reference_mass, self.reference_length);
        let (z_delta, m_delta) = (z_delta * m0 * u * u / l, m_delta * m0 * u * u);
        let (z_differential, m_differential) = self
            .planes
            .map_or((0.0, 0.0), |arms| arms.differential(z_delta, m_delta));
        Derivatives {
            speed: u,
            heave_inertia: self.mass - z_w_dot * m0,
            z_w: z_w * m0 * u / l,
            z_q_plus_m_u: z_q * m0 * u + self.mass * u,
            z_delta,
            pitch_inertia: i_y_minus_m_q_dot * m0 * l * l,
            m_w: m_w * m0 * u,
            m_q: m_q * m0 * l * u,
            m_delta,
            z_differential,
            m_differential,
            restoring: self.weight * self.restoring_arm,
            z_q_dot: z_q_dot * m0 * l,
            m_w_dot: m_w_dot * m0 * l,
            z_ww: z_ww * m0 / l,
            z_qq: z_qq * m0 * l,
            m_ww: m_ww * m0,
            m_qq: m_qq * m0 * l * l,
            first_moment: self.mass * self.gravity_below_origin,
            excess_weight: self.weight - self.buoyancy,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::vehicle_file::brunner;
    use planesman_units::{FOOT, POUND_FORCE};

    /// Brunner 1988, programs T2 to T5 made dimensional at 1 ft/s:
    ///
    /// 1.6098 w' = 0.0627 delta - 0.8541 w + 0.3016 q   \[lbf\]
    /// 0.6033 q' = -0.2832 delta + 0.1354 w - 0.7182 q - 0.16333 sin(theta)   \[ft lbf\]
    #[test]
    fn the_dimensional_plant_of_the_report_comes_out_of_the_vehicle_file() {
        let d = brunner().derivatives(FOOT);
        let per_foot = POUND_FORCE / FOOT;
        let foot_pound = POUND_FORCE * FOOT;
        for (found, expected) in [
            (d.heave_inertia / per_foot, 1.6098),
            (d.z_w / per_foot, -0.8541),
            (d.z_q_plus_m_u / POUND_FORCE, 0.3016),
            (d.z_delta / POUND_FORCE, 0.0627),
            (d.pitch_inertia / foot_pound, 0.6033),
            (d.m_w / POUND_FORCE, 0.1354),
            (d.m_q / foot_pound, -0.7182),
            (d.m_delta / foot_pound, -0.2832),
        ] {
            assert!((found - expected).abs() < 5e-5, "{found} is not {expected}");
        }
        assert!((d.restoring / foot_pound - 0.16333).abs() < 5e-6);
    }

    #[test]
    fn the_derivatives_have_the_metric_values_of_the_tables() {
        // Brunner 1988, Table 1, converted.
        let d = brunner().derivatives(FOOT);
        assert!((d.z_w + 12.465).abs() < 5e-4);
        assert!((d.z_delta - 0.2789).abs() < 2e-4);
        assert!((d.m_w - 0.6023).abs() < 2e-4);
        assert!((d.m_q + 0.9735).abs() < 5e-4);
        assert!((d.pitch_inertia - 0.8135).abs() < 5e-3);
        assert!((d.m_delta + 0.3837).abs() < 5e-4);
        assert!((d.restoring - 0.2214).abs() < 5e-4);
    }

    #[test]
    fn bow_and_stern_planes_together_give_the_coefficients_and_apart_what_the_fins_lift() {
        let vehicle = brunner();
        let d = vehicle.derivatives(FOOT);
        let arms = vehicle.planes.expect("the report's");
        let (bow, stern) = arms.forces(d.z_delta, d.m_delta);
        assert!((bow + stern - d.z_delta).abs() < 1e-15);
        assert!((-arms.bow * bow - arms.stern * stern - d.m_delta).abs() < 1e-15);
        // Brunner's fins by their lift slopes (p. 43): Z'w = -0.2828 forward and -0.1847 aft.
        let unit = vehicle.reference_mass * FOOT * FOOT / vehicle.reference_length;
        assert!((bow / unit / 0.2828 - 1.0).abs() < 0.011);
        assert!((-stern / unit / 0.1847 - 1.0).abs() < 0.011);
        // Apart they lift the vehicle and hardly turn it.
        assert!(d.z_differential / d.z_delta > 4.0);
        assert!(d.m_differential.abs() < 0.2 * d.m_delta.abs());
    }

    #[test]
    fn damping_grows_with_speed_and_plane_forces_with_its_square() {
        let (slow, fast) = (brunner().derivatives(0.3), brunner().derivatives(0.6));
        assert!((fast.m_q / slow.m_q - 2.0).abs() < 1e-12);
        assert!((fast.m_delta / slow.m_delta - 4.0).abs() < 1e-12);
        assert_eq!(fast.restoring, slow.restoring);
    }
}
