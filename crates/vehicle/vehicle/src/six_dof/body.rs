//! A first file of a body that is pushed by a force and a moment: a start for a fit to a recording of those.
//!
//! ```text
//! V = m / rho      M_A: Lamb's ellipsoid of the same proportions and volume, and at least a fifth of the body's own
//! D_q = 1/2 rho c_d A along each axis, c_d 1 of a frame      D_l: a time constant of 5 s along an axis, of 1 s about one
//! ```
//! Nothing in it is measured: a fit replaces all of it but mass, weight and proportions.

use std::fmt::Write as _;

use super::inertia::ellipsoid;
use super::lanes::Three;

/// Mass and size, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxBody {
    /// Its name.
    pub name: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Length, width and height \[m\].
    pub size: Three<f64>,
    /// Density of the water \[kg/m^3\].
    pub density: f64,
    /// Distance of the centre of gravity below the centre of buoyancy \[m\].
    pub gravity_below: f64,
}

/// Drag of a frame with thrusters on its front area.
const DRAG: f64 = 1.0;
/// Time constants of the linear damping, along and about an axis \[s\].
const TIMES: [f64; 2] = [5.0, 1.0];
/// The least added mass, relative to the body's own.
const ADDED: f64 = 0.2;

impl BoxBody {
    /// Text of the vehicle's file, with the inputs X, Y, Z \[N\] and K, M, N \[N m\].
    #[must_use]
    pub fn file(&self) -> String {
        let (m, rho, [l, b, h]) = (self.mass, self.density, self.size);
        let inertia = [b * b + h * h, l * l + h * h, l * l + b * b].map(|it| m / 12.0 * it);
        // The ellipsoid of the same proportions that displaces the mass.
        let volume = m / rho;
        let scale = libm::cbrt(volume / (std::f64::consts::PI / 6.0 * l * b * h));
        let added = ellipsoid(rho, [l, b, h].map(|it| 0.5 * scale * it));
        let own = |i: usize| if i < 3 { m } else { inertia[i - 3] };
        let added: [f64; 6] = std::array::from_fn(|i| added[i].max(ADDED * own(i)));
        let areas = [b * h, l * h, l * b];
        let linear: [f64; 6] = std::array::from_fn(|i| (own(i) + added[i]) / TIMES[i / 3]);
        let quadratic: [f64; 6] = std::array::from_fn(|i| match i {
            0..3 => 0.5 * rho * DRAG * areas[i],
            _ => own(i) + added[i],
        });
        let weight = m * super::water::GRAVITY;
        let row = |of: &[f64]| {
            let each: Vec<String> = of.iter().map(|it| it.to_string()).collect();
            each.join(", ")
        };
        let mut text = format!(
            "# {name}: from mass and size alone (planesman six-dof box). Nothing here is measured.\n\n\
             name: {name}\n\n\
             inputs:                         # force and moment on the body: N, N m\n  - {{ name: X }}\n  - {{ name: Y }}\n  - {{ name: Z }}\n  - {{ name: K }}\n  - {{ name: M }}\n  - {{ name: N }}\n\n\
             mass: {m} kg\nweight: {weight} N\nbuoyancy: {weight} N\n\
             centre_of_gravity: [0 m, 0 m, {below} m]\ncentre_of_buoyancy: [0 m, 0 m, 0 m]\n\
             inertia:                        # of a box, filled evenly\n  about: origin\n  xx: {xx} kg m^2\n  yy: {yy} kg m^2\n  zz: {zz} kg m^2\n\n\
             added_mass: [{added}]\n\
             linear_damping: [{linear}]\n\
             quadratic_damping: [{quadratic}]\n\
             coefficients:                   # of the Munk moment beyond that of the added mass\n  includes_added_mass: false\n  values: {{ K_vw: 0, M_uw: 0, N_uv: 0 }}\n\n\
             propulsion:\n",
            name = self.name,
            below = self.gravity_below,
            xx = inertia[0],
            yy = inertia[1],
            zz = inertia[2],
            added = row(&added),
            linear = row(&linear),
            quadratic = row(&quadratic),
        );
        for axis in ["X", "Y", "Z", "K", "M", "N"] {
            let (unit, position) = match axis {
                "X" | "Y" | "Z" => ("N", ", position: [0 m, 0 m, 0 m]"),
                _ => ("N m", ""),
            };
            // Writing to a String does not fail.
            let _ = writeln!(
                text,
                "  - {{ kind: force, input: {axis}, axis: {axis}, limits: [-1e6 {unit}, 1e6 {unit}]{position} }}"
            );
        }
        let _ = write!(
            text,
            "\nhull: {{ length: {l} m, width: {b} m, height: {h} m }}\n"
        );
        text
    }
}
