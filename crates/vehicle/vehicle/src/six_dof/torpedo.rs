//! Writes the vehicle file of a torpedo from its hull, fins, trim and top speed, by the formulas of Prestero 2001, ch. 4, and of the sources
//! named there.
//!
//! ```text
//! V = c_p pi/4 d^2 l      m = rho V (1 - reserve)      M_A: Lamb's ellipsoid of the same length and volume
//! c_d = c_ss pi A_p/A_f (1 + 60 (d/l)^3 + 0.0025 l/d),  c_ss = 3.397e-3 (p. 27)       X_u|u| = -1/2 rho c_d A_f
//! cross flow: c_dc = 1.1 on the side (Hoerner 1965)      hull lift: c_y = 0.003 * 180/pi on d l, at 0.65 l from the nose (p. 34)
//! fins: c_L = 1 / (1/(2 pi 0.9) + 1/(pi AR_e)),  AR_e = 2 span/chord (p. 32)
//! ```
//! Quantities that a shape does not determine are assumed and marked in the file: damping in roll, propeller and its torque. For submerged
//! hulls of revolution with cruciform fins.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::inertia::ellipsoid;

/// Shape, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Torpedo {
    /// Its name.
    pub name: String,
    /// \[m\]
    pub length: f64,
    /// \[m\]
    pub diameter: f64,
    /// Volume of the hull divided by the volume of its enclosing cylinder.
    pub prismatic: f64,
    /// Density of the water \[kg/m^3\].
    pub density: f64,
    /// Buoyancy minus weight, relative to the buoyancy.
    pub reserve: f64,
    /// Distance of the centre of gravity below the centre of buoyancy \[m\].
    pub gravity_below: f64,
    /// Span of one fin, from hull to tip \[m\].
    pub fin_span: f64,
    /// Chord of a fin along the stream \[m\].
    pub fin_chord: f64,
    /// Position of the fins' centre of pressure aft of the middle \[m\].
    pub fin_aft: f64,
    /// Speed at full thrust \[m/s\].
    pub top_speed: f64,
}

/// Skin friction on the hull (Prestero 2001, p. 27, after Triantafyllou).
const SKIN_FRICTION: f64 = 3.397e-3;
/// Cross-flow drag of a cylinder (Hoerner, Fluid Dynamic Drag, 1965, ch. 3).
const CROSS_FLOW: f64 = 1.1;
/// Hull lift per degree, referred to diameter times length (Hoerner and Borst 1985, ch. 13; Prestero 2001, p. 34).
const HULL_LIFT: f64 = 0.003;
/// Position of this lift, in lengths from the nose (same sources).
const HULL_LIFT_PLACE: f64 = 0.65;

/// A shape outside the range of the formulas.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what}: {value} refused: {rule}")]
pub struct NoTorpedo {
    /// Quantity of the shape.
    pub what: &'static str,
    /// Its value, SI.
    pub value: String,
    /// What holds.
    pub rule: &'static str,
}

impl Torpedo {
    /// Text of the vehicle's file.
    ///
    /// # Errors
    /// [`NoTorpedo`], if a number is outside the range of the formulas.
    pub fn file(&self) -> Result<String, NoTorpedo> {
        self.check()?;
        let (l, d, rho) = (self.length, self.diameter, self.density);
        let volume = self.prismatic * PI / 4.0 * d * d * l;
        let buoyancy = rho * volume * super::water::GRAVITY;
        let weight = buoyancy * (1.0 - self.reserve);
        let mass = weight / super::water::GRAVITY;
        // The ellipsoid of the hull's length and volume.
        let (a, b) = (0.5 * l, (volume * 3.0 / (2.0 * PI * l)).sqrt());
        let mut along = ellipsoid(rho, [a, b, b]);
        // Along it the nose counts: that of the same diameter, as Prestero takes it (p. 28).
        along[0] = ellipsoid(rho, [a, 0.5 * d, 0.5 * d])[0];
        let inertia = [0.4 * mass * b * b, 0.2 * mass * (a * a + b * b)];
        let front = PI / 4.0 * d * d;
        let side = self.prismatic * l * d;
        let friction = SKIN_FRICTION * PI * side / front;
        let shape = 1.0 + 60.0 * (d / l) * (d / l) * (d / l) + 0.0025 * l / d;
        let drag = 0.5 * rho * friction * shape * front;
        let lift = 0.5 * rho * d * l * HULL_LIFT * 180.0 / PI;
        let arm = (HULL_LIFT_PLACE - 0.5) * l;
        let aspect = 2.0 * self.fin_span / self.fin_chord;
        let slope = 1.0 / (1.0 / (2.0 * PI * 0.9) + 1.0 / (PI * aspect));
        let out = 0.5 * d + 0.5 * self.fin_span;
        let area = self.fin_span * self.fin_chord;
        let thrust = 1.2 * drag * self.top_speed * self.top_speed;
        let mut text = format!(
            "# {name}: from its shape alone, by the formulas of Prestero 2001, ch. 4 (planesman six-dof torpedo). Nothing here is measured.\n\
             # Ellipsoid of {a:.4} m by {b:.4} m, displacement {volume:.5} m^3, c_d {cd:.4} on the front, c_L {slope:.3} of the fins.\n\n\
             name: {name}\n\n\
             inputs:\n  - {{ name: rudder }}            # rad, positive to starboard\n  - {{ name: stern_planes }}      # rad, positive to dive\n  - {{ name: thrust }}            # N\n\n\
             mass: {mass} kg\nweight: {weight} N\nbuoyancy: {buoyancy} N\n\
             centre_of_gravity: [0 m, 0 m, {below} m]\ncentre_of_buoyancy: [0 m, 0 m, 0 m]\n\
             inertia:                        # of the ellipsoid, filled evenly\n  about: centre_of_gravity\n  xx: {xx} kg m^2\n  yy: {yy} kg m^2\n  zz: {yy} kg m^2\n\n",
            name = self.name,
            cd = friction * shape,
            below = self.gravity_below,
            xx = inertia[0],
            yy = inertia[1],
        );
        // Writing to a String does not fail.
        let _ = write!(
            text,
            "added_mass: [{}, {}, {}, {}, {}, {}]  # Lamb, art. 114; a body of revolution has no added mass in roll\n\
             linear_damping: [0, 0, 0, {roll}, 0, 0]   # roll: for an assumed time constant of 1 s\n\
             quadratic_damping: [{drag}, 0, 0, 0, 0, 0]\n\
             cross_flow: {{ density: {rho} kg/m^3, drag: {CROSS_FLOW}, width: {d} m, ends: [{aft} m, {fore} m] }}\n\
             coefficients:\n  includes_added_mass: false\n  values:                       # the hull's lift\n    Y_uv: {y}\n    Z_uw: {y}\n    M_uw: {m}\n    N_uv: {n}\n\n\
             fins:\n",
            along[0],
            along[1],
            along[2],
            along[3],
            along[4],
            along[5],
            roll = inertia[0] + along[3],
            aft = -0.5 * l,
            fore = 0.5 * l,
            y = -lift,
            // At the hull's lift, aft of the middle: it turns the bow back into the stream.
            m = -lift * arm,
            n = lift * arm,
        );
        for (input, place, normal) in [
            ("rudder", format!("0 m, {} m", -out), "0, -1, 0"),
            ("rudder", format!("0 m, {out} m"), "0, -1, 0"),
            ("stern_planes", format!("{out} m, 0 m"), "0, 0, -1"),
            ("stern_planes", format!("{} m, 0 m", -out), "0, 0, -1"),
        ] {
            let _ = writeln!(
                text,
                "  - {{ input: {input}, position: [{aft} m, {place}], chord: [1, 0, 0], normal: [{normal}], area: {area} m^2, density: {rho} kg/m^3,\n      \
                 slope: {slope}, drag: 0.02, oswald: 0.9, aspect: {aspect}, stall: 0.35 rad, sharpness: 40 }}",
                aft = -self.fin_aft,
            );
        }
        let _ = write!(
            text,
            "\npropulsion:\n  - {{ kind: force, input: thrust, limits: [{} N, {thrust} N] }}   # upper limit: the hull's drag at {} m/s and a fifth more for the fins; the propeller's torque is not modelled\n\n\
             hull: {{ length: {l} m, width: {d} m, height: {d} m }}\n",
            -0.5 * thrust,
            self.top_speed,
        );
        Ok(text)
    }

    fn check(&self) -> Result<(), NoTorpedo> {
        let slender = self.length / self.diameter;
        for (what, value, least, most, rule) in [
            ("length", self.length, 0.2, 20.0, "0.2 to 20 m"),
            ("diameter", self.diameter, 0.02, 5.0, "0.02 to 5 m"),
            (
                "length over diameter",
                slender,
                4.0,
                15.0,
                "4 to 15: the formulas apply to slender hulls",
            ),
            (
                "prismatic coefficient",
                self.prismatic,
                0.5,
                1.0,
                "0.5 to 1",
            ),
            ("density", self.density, 900.0, 1200.0, "900 to 1200 kg/m^3"),
            (
                "reserve",
                self.reserve,
                -0.05,
                0.1,
                "-0.05 to 0.1 times the buoyancy",
            ),
            (
                "centre of gravity below that of buoyancy",
                self.gravity_below,
                0.0,
                0.5 * self.diameter,
                "0 to half a diameter",
            ),
            (
                "fin span",
                self.fin_span,
                0.05 * self.diameter,
                2.0 * self.diameter,
                "0.05 to 2 times the diameter",
            ),
            (
                "fin chord",
                self.fin_chord,
                0.2 * self.fin_span,
                5.0 * self.fin_span,
                "0.2 to 5 times the span",
            ),
            (
                "fins aft of the middle",
                self.fin_aft,
                0.0,
                0.6 * self.length,
                "0 to 0.6 lengths",
            ),
            ("top speed", self.top_speed, 0.1, 15.0, "0.1 to 15 m/s"),
        ] {
            // NaN is not within.
            if !(least..=most).contains(&value) {
                let value = value.to_string();
                return Err(NoTorpedo { what, value, rule });
            }
        }
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        match !self.name.is_empty() && self.name.chars().all(is_plain) {
            true => Ok(()),
            false => Err(NoTorpedo {
                what: "name",
                value: format!("'{}'", self.name.escape_debug()),
                rule: "letters, digits and '_'",
            }),
        }
    }
}
