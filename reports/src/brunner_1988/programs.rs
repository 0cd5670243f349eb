//! The simulation programs T2 to T5 of Brunner 1988 (App. A, pp. 118-121), as printed.
//!
//! All quantities are nondimensional: lengths in body lengths `L = 28 in`, time in `L / U`.
//!
//! ```text
//! w' = (K1 delta - C1 q - B1 w) / A1           UG = U + ZG q     ZG = BG / L
//! q' = (K2 delta - D2 w - C2 theta - B2 q) / A2
//! theta' = q                                   WG = w + XG q
//! x' = UG cos(theta) + WG sin(theta)
//! z' = WG cos(theta) - UG sin(theta)
//! ```
//!
//! The planes are at 30 degrees until they are released, then at zero; the vehicle starts at rest.
//!
//! Two errors are kept, because the printed results depend on them:
//!
//! - `C2 = 1.27` uses `BG` in inches instead of feet: the restoring moment is 12 times too large (0.106 is correct, at 1 ft/s).
//! - One unit of time is interpreted as one second, but at 1 ft/s it is 28/12 s = 2.333 s; depth is converted to feet correctly.
//!
//! So the printed dive of 4.2 degrees and 2.61 ft is not a prediction for the vehicle; use [`planesman_vehicle`] with the vehicle `brunner` for
//! that. With the vehicle file `brunner_as_printed` the node flies these programs.

use planesman_linear::runge_kutta_step;

use crate::brunner_1988::track::{Sample, Track};

/// Feet per body length `L` of 28 in: the only unit conversion of the programs, at output.
pub const FEET_PER_LENGTH: f64 = 28.0 / 12.0;

/// Plane angle before release \[rad\]: 30 degrees with the digits of the listings.
#[allow(clippy::approx_constant)]
pub const PLANE_ANGLE: f64 = 0.523_598_7;

/// Integration step \[L/U\]; halving it changes no result by more than 1e-7.
pub const STEP: f64 = 0.005;

/// Constants of a program listing, with the listing's names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Program {
    /// `T2` to `T5`.
    pub name: &'static str,
    /// Whether the vehicle heaves. T3 and T4 set A1 = B1 = C1 = W = D2 = 0 instead.
    pub heaves: bool,
    /// `K1 = Z'delta`.
    pub k1: f64,
    /// `A1 = m' - Z'wdot`.
    pub a1: f64,
    /// `B1 = -Z'w`.
    pub b1: f64,
    /// `C1 = -(Z'q + m')`.
    pub c1: f64,
    /// `K2 = M'delta`.
    pub k2: f64,
    /// `A2 = I'y - M'qdot`.
    pub a2: f64,
    /// `B2 = -M'q`.
    pub b2: f64,
    /// `C2 = -M'theta`.
    pub c2: f64,
    /// `D2 = -M'w`.
    pub d2: f64,
    /// `XG`, centre of gravity forward of the origin \[L\].
    pub xg: f64,
    /// `ZG = BG / L`, centre of gravity below the origin \[L\].
    pub zg: f64,
    /// Time at which the planes return to zero \[L/U\].
    pub released_at: f64,
}

/// Program T2 (p. 118): heave and pitch.
pub const T2: Program = Program {
    name: "T2",
    heaves: true,
    // Table 1 (p. 41).
    k1: 0.095,
    // 0.609 / 1.539 + 0.65 = 1.0457.
    a1: 1.046,
    // Table 1.
    b1: 1.295,
    // 0.20 - 0.3957 = -0.1957.
    c1: -0.196,
    // The copy shows "-0.1S4" and "-0.134": -0.184, as Table 1 and the -27.5 degrees of T4 ask.
    k2: -0.184,
    // 0.6 ft lbf s^2 / 8.379 = 0.0716.
    a2: 0.072,
    // Table 1.
    b2: 0.20,
    // 19.6 lbf 0.1 in / 1.539 ft lbf = 1.274, inches left as they are. Table 1 has 0.106.
    c2: 1.27,
    // The copy shows "-0.033": -0.088, as Table 1 and the printed depth and pitch ask.
    d2: -0.088,
    xg: 0.0,
    // "BG/L" with 0.1 and 28 in, which the copy shows as "2S.O".
    zg: 0.1 / 28.0,
    released_at: 10.0,
};

/// Program T3 (p. 119): pitch only.
pub const T3: Program = Program {
    name: "T3",
    heaves: false,
    d2: 0.0,
    ..T2
};

/// Program T4 (p. 120): pitch only, without restoring moment, planes released at 1 `L / U`.
pub const T4: Program = Program {
    name: "T4",
    c2: 0.0,
    released_at: 1.0,
    ..T3
};

/// Program T5 (p. 121): T2 with a tenth of the pitch damping.
pub const T5: Program = Program {
    name: "T5",
    b2: 0.02,
    ..T2
};

/// All four programs, in the order of the appendix.
pub const PROGRAMS: [Program; 4] = [T2, T3, T4, T5];

impl Program {
    /// Runs the program from rest until `duration` \[L/U\]; results in lengths, radians and `L / U`.
    #[must_use]
    pub fn run(&self, duration: f64) -> Track {
        let steps = (duration / STEP).round() as usize;
        let held_steps = (self.released_at / STEP).round() as usize;
        let mut y = [0.0; 4];
        let mut samples = vec![Sample::default()];
        for k in 0..steps {
            let delta = if k < held_steps { PLANE_ANGLE } else { 0.0 };
            y = runge_kutta_step(&y, STEP, [&delta; 3], |delta, y| self.rates(y, *delta));
            let [_, pitch_rate, pitch, depth] = y;
            samples.push(Sample {
                depth,
                pitch,
                pitch_rate,
            });
        }
        Track::new(STEP, samples)
    }

    /// `w', q', theta', z'` of `[w, q, theta, z]`. The distance `x` has no influence.
    fn rates(&self, &[w, q, theta, _]: &[f64; 4], delta: f64) -> [f64; 4] {
        let w_dot = if self.heaves {
            (self.k1 * delta - self.c1 * q - self.b1 * w) / self.a1
        } else {
            0.0
        };
        let q_dot = (self.k2 * delta - self.d2 * w - self.c2 * theta - self.b2 * q) / self.a2;
        let (ug, wg) = (1.0 + self.zg * q, w + self.xg * q);
        [
            w_dot,
            q_dot,
            q,
            wg * libm::cos(theta) - ug * libm::sin(theta),
        ]
    }

    /// Initial `q'`, at rest with the planes deflected \[(U/L)^2\].
    #[must_use]
    pub fn first_pitch_acceleration(&self) -> f64 {
        self.k2 * PLANE_ANGLE / self.a2
    }

    /// Undamped frequency of pitch without heave, `sqrt(C2 / A2)` \[U/L\].
    #[must_use]
    pub fn pitch_frequency(&self) -> f64 {
        (self.c2 / self.a2).sqrt()
    }

    /// Damping ratio of pitch without heave, `B2 / (2 sqrt(C2 A2))`; infinite without `C2`.
    #[must_use]
    pub fn pitch_damping_ratio(&self) -> f64 {
        self.b2 / (2.0 * (self.c2 * self.a2).sqrt())
    }
}

/// Derivation of the listings' constants from the thesis's tables, in feet, pounds and slugs.
pub mod derivation {
    /// `m` \[slug\] (Fig. 23, p. 37).
    pub const MASS: f64 = 0.609;
    /// `W` \[lbf\] (Fig. 23).
    pub const WEIGHT: f64 = 19.6;
    /// `BG` \[in\] (Fig. 23).
    pub const BG_INCHES: f64 = 0.1;
    /// `m0 = rho L^2 T / 2` \[slug\]; at 1 ft/s also the reference moment \[ft lbf\] (Table 2, p. 42).
    pub const REFERENCE: f64 = 1.539;
    /// `Z'wdot` (Table 1).
    pub const Z_W_DOT: f64 = -0.65;
    /// `Z'q` (Table 1).
    pub const Z_Q: f64 = -0.20;

    /// `A1 = m' - Z'wdot`, 1.046.
    #[must_use]
    pub fn a1() -> f64 {
        MASS / REFERENCE - Z_W_DOT
    }

    /// `C1 = -(Z'q + m')`, -0.196.
    #[must_use]
    pub fn c1() -> f64 {
        -(Z_Q + MASS / REFERENCE)
    }

    /// `-M'theta = W BG / (m0 U^2)` with `BG` in feet, 0.106: as in Table 1.
    #[must_use]
    pub fn c2() -> f64 {
        WEIGHT * (BG_INCHES / 12.0) / REFERENCE
    }

    /// Like [`c2`], with `BG` left in inches, 1.27, as in the listings.
    #[must_use]
    pub fn c2_in_inches() -> f64 {
        WEIGHT * BG_INCHES / REFERENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_testing::near;
    use planesman_vehicle::{Environment, Motion, Restoring, vehicle_file};

    #[test]
    fn thirty_degrees_of_plane_dive_to_the_printed_depth_at_the_printed_angle() {
        // Pp. 38 f.: -4.2 degrees, 2.61 ft.
        let dive = T2.run(60.0);
        near(dive.at(10.0).pitch.to_degrees(), -4.2, 0.05);
        near(dive.end().depth * FEET_PER_LENGTH, 2.61, 0.015);
    }

    #[test]
    fn the_vehicle_as_printed_flies_program_t2_in_what_it_takes_for_seconds() {
        let vehicle = vehicle_file::load(vehicle_file::BRUNNER_AS_PRINTED).expect("built in");
        // A body length per second: L / U is 1 s.
        let motion = Motion {
            derivatives: vehicle.derivatives(vehicle.reference_length),
            restoring: Restoring::SmallAngle,
            environment: Environment {
                density: 999.835,
                gravity: 9.81456,
                atmospheric_pressure: 101_325.0,
            },
            step: STEP,
        };
        let flown = Track::of_dive(&motion, PLANE_ANGLE, T2.released_at, 60.0).expect("it dives");
        let program = T2.run(60.0);
        for second in 0..60 {
            let time = f64::from(second);
            near(flown.at(time).pitch, program.at(time).pitch, 1e-8);
            // The program's ZG q, which the vehicle's track goes without, lifts it a little.
            let lift = T2.zg * (1.0 - libm::cos(program.at(time).pitch));
            let depth = flown.at(time).depth / vehicle.reference_length;
            near(depth, program.at(time).depth + lift, 1e-8);
        }
    }

    #[test]
    fn without_heave_a_third_of_the_depth_is_lost() {
        // P. 39: -4.4 degrees, 1.77 ft, 32 %.
        let (with, without) = (T2.run(60.0), T3.run(60.0));
        near(without.at(10.0).pitch.to_degrees(), -4.4, 0.06);
        near(without.end().depth * FEET_PER_LENGTH, 1.77, 0.005);
        near(
            100.0 * (1.0 - without.end().depth / with.end().depth),
            32.0,
            0.5,
        );
    }

    #[test]
    fn without_a_restoring_moment_the_vehicle_keeps_the_angle_its_planes_gave_it() {
        // P. 40: -27.5 degrees. K2 delta t / B2 is what damping leaves of the impulse.
        let angle = T4.run(60.0).end().pitch;
        near(angle.to_degrees(), -27.5, 0.15);
        near(angle, T4.k2 * PLANE_ANGLE / T4.b2, 1e-12);
    }

    #[test]
    fn a_tenth_of_the_damping_changes_the_way_but_not_the_depth() {
        // P. 40: significant oscillation, the same steady depth.
        let (t2, t5) = (T2.run(60.0), T5.run(60.0));
        assert!(t5.pitch_swing(5.0, 10.0) > 20.0 * t2.pitch_swing(5.0, 10.0));
        near(t5.end().depth / t2.end().depth, 1.0, 1e-3);
    }
}
