//! Predicted transfer functions of Brunner 1988: eq. (7a), eq. (7b) and Table 8 (pp. 92-97).
//!
//! ```text
//! q        E s^2 + F s                  z      N1 s^3 + N2 s^2 + N3 s + N4
//! ----- = -------------------------  (7a)  --- = ---------------------------   (7b)
//! delta    A s^3 + B s^2 + C s + D         q      s^2 (D1 s^2 + D2 s + D3)
//! ```
//!
//! Both follow from the nondimensional equations of the programs ([`programs`](crate::brunner_1988::programs)), so `s` is in `U / L`. The printed
//! formulas have four errors, each of which is an argument or a constant here:
//!
//! - (7b) uses `z' = w + U theta`; correct is `z' = w - U theta`: [`DepthRate`].
//! - (7b) combines the dimensional `U` in ft/s with nondimensional numbers; correct is 1.
//! - The numbers of Table 8 need 1.5 times the `D2` of its own formula: [`D2_ANOMALY`].
//! - Table 8 samples with `T = 0.05`, meaning 0.05 s, but the equations have time in `L / U`. Correct is `T = 0.05 U / L`; and `M'theta` should be
//!   `-0.106 / U^2`, with `U` in ft/s.
//!
//! (7b) is not minimal either: `s = Z'w / (m' - Z'wdot)` is both a pole and a zero, which [`Equation7::depth_minimal`] cancels. The corrected model
//! equals that of [`linearised`], for any vehicle and speed; [`Equation7::of`] gives the same result from these formulas.

use planesman_linear::{Error, TransferFunction};

use planesman_units::FOOT;
use planesman_vehicle::{
    Vehicle,
    linearised::{self, Output},
};

use crate::brunner_1988::programs::FEET_PER_LENGTH;

/// `Cf1`: gyro volts per deg/s, 0.0125, over plane command volts per degree, 0.010 (p. 93).
pub const CF1: f64 = 0.0125 / 0.010;

/// `Cf2`: depth cell volts per foot, 0.257 V/in, over gyro volts per rad/s (p. 93). The printed value is 4.306.
pub const CF2: f64 = 0.257 * 12.0 / (0.0125 * 180.0 / std::f64::consts::PI);

/// `Cf2` with the digits used in Table 8.
pub const CF2_PRINTED: f64 = 4.306;

/// Depth cell volts per metre over plane command volts per radian: 0.257 V/in, 0.010 V per degree.
pub const DEPTH_VOLTS_PER_PLANE_VOLT: f64 =
    0.257 * 12.0 / FOOT / (0.010 * 180.0 / std::f64::consts::PI);

/// The `D2` used in Table 8, divided by the value of its formula: `-ln 0.8332 / 0.05` is 3.6497, while `D2 / D1` by the formula is 2.4327.
pub const D2_ANOMALY: f64 = 1.5;

/// Sampling time of Table 8, printed in \[s\] and used in \[L/U\].
pub const SAMPLING_TIME: f64 = 0.05;

/// Relation between depth and pitch in (7b).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthRate {
    /// `z' = w + U theta`, with `U` in ft/s.
    AsPrinted {
        /// `U` \[ft/s\].
        feet_per_second: f64,
    },
    /// `z' = w - theta`, in body lengths and `L / U`.
    Corrected,
}

impl DepthRate {
    /// The number used for `U` in (7b).
    fn u(self) -> f64 {
        match self {
            Self::AsPrinted { feet_per_second } => feet_per_second,
            Self::Corrected => -1.0,
        }
    }
}

/// Coefficients of eq. (7), all nondimensional (p. 93 f.).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation7 {
    /// `a1 = -M'w`.
    pub a1: f64,
    /// `a2 = -Z'w`.
    pub a2: f64,
    /// `b1 = -M'q`.
    pub b1: f64,
    /// `b2 = m' - Z'wdot`.
    pub b2: f64,
    /// `c1 = I'y - M'qdot`.
    pub c1: f64,
    /// `c2 = -(Z'q + m')`.
    pub c2: f64,
    /// `d1 = -M'theta`.
    pub d1: f64,
    /// `k1 = M'delta`.
    pub k1: f64,
    /// `k2 = Z'delta`.
    pub k2: f64,
}

/// The thesis's own numbers: Table 1, with `M'theta` in feet and at 1 ft/s.
pub const PRINTED: Equation7 = Equation7 {
    a1: -0.088,
    a2: 1.295,
    b1: 0.20,
    b2: 1.046,
    c1: 0.072,
    c2: -0.196,
    d1: 0.106,
    k1: -0.184,
    k2: 0.095,
};

impl Equation7 {
    /// Coefficients of a vehicle at a speed \[m/s\]; only `M'theta` depends on the speed.
    #[must_use]
    pub fn of(vehicle: &Vehicle, speed: f64) -> Self {
        let c = &vehicle.coefficients;
        let m = vehicle.mass / vehicle.reference_mass;
        let reference_moment = vehicle.reference_mass * speed * speed;
        Self {
            a1: -c.m_w,
            a2: -c.z_w,
            b1: -c.m_q,
            b2: m - c.z_w_dot,
            c1: c.i_y_minus_m_q_dot,
            c2: -(c.z_q + m),
            d1: vehicle.weight * vehicle.restoring_arm / reference_moment,
            k1: c.m_delta,
            k2: c.z_delta,
        }
    }

    /// `[A, B, C, D]`. A stray "+a1c2" in the copy's line for `B` is not in the thesis: the printed 0.8181 of Table 8 is `exp(-0.05 B / A)` without it.
    #[must_use]
    pub fn denominator(&self) -> [f64; 4] {
        let Self {
            a1,
            a2,
            b1,
            b2,
            c1,
            c2,
            d1,
            ..
        } = *self;
        [
            b2 * c1,
            b2 * b1 + a2 * c1,
            b2 * d1 + a2 * b1 - a1 * c2,
            a2 * d1,
        ]
    }

    /// `[E, F]`.
    #[must_use]
    pub fn numerator(&self) -> [f64; 2] {
        let Self {
            a1, a2, b2, k1, k2, ..
        } = *self;
        [k1 * b2, k1 * a2 - k2 * a1]
    }

    /// `[D1, D2, D3]`, by the printed formulas.
    #[must_use]
    pub fn depth_denominator(&self) -> [f64; 3] {
        let [e, f] = self.numerator();
        let Self { a2, b2, .. } = *self;
        [b2 * e, a2 * e + b2 * f, a2 * f]
    }

    /// `[N1, N2, N3, N4]`.
    #[must_use]
    pub fn depth_numerator(&self, depth_rate: DepthRate) -> [f64; 4] {
        let [a, b, c, d] = self.denominator();
        let [e, f] = self.numerator();
        let Self { a2, b2, c2, k2, .. } = *self;
        let u = depth_rate.u();
        [
            k2 * a,
            k2 * b + e * (u * b2 - c2),
            k2 * c + f * (u * b2 - c2) + u * a2 * e,
            u * a2 * f + k2 * d,
        ]
    }

    /// (7a), `q / delta`, with `s` and `q` in `U / L`.
    ///
    /// # Errors
    /// [`Error`] for invalid coefficients.
    pub fn pitch_rate(&self) -> Result<TransferFunction, Error> {
        let [e, f] = self.numerator();
        TransferFunction::new(vec![e, f, 0.0], self.denominator().to_vec())
    }

    /// (7b), `z / q`, with `D2` multiplied by a factor: 1 by the formula, [`D2_ANOMALY`] as printed.
    ///
    /// # Errors
    /// Same as [`Equation7::pitch_rate`].
    pub fn depth(&self, depth_rate: DepthRate, d2_factor: f64) -> Result<TransferFunction, Error> {
        let [d1, d2, d3] = self.depth_denominator();
        TransferFunction::new(
            self.depth_numerator(depth_rate).to_vec(),
            vec![d1, d2_factor * d2, d3, 0.0, 0.0],
        )
    }

    /// (7b) with the pole and zero at `s = -a2 / b2` cancelled, by the formulas.
    ///
    /// # Errors
    /// Same as [`Equation7::pitch_rate`].
    pub fn depth_minimal(&self, depth_rate: DepthRate) -> Result<TransferFunction, Error> {
        let [n1, n2, n3, _] = self.depth_numerator(depth_rate);
        let [e, f] = self.numerator();
        let Self { a2, b2, .. } = *self;
        // N = (b2 s + a2)(p s^2 + q s + r), compared power by power.
        let p = n1 / b2;
        let q = (n2 - a2 * p) / b2;
        let r = (n3 - a2 * q) / b2;
        TransferFunction::new(vec![p, q, r], vec![e, f, 0.0, 0.0])
    }
}

/// A transfer function multiplied by a factor.
#[must_use]
pub fn scaled(g: TransferFunction, factor: f64) -> TransferFunction {
    TransferFunction {
        num: g.num.iter().map(|c| factor * c).collect(),
        den: g.den,
    }
}

/// Pitch without heave: `q / delta = K s / (J s^2 + B s + M_e)`, Table 8's second-order form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchAlone {
    /// `J`, moment of inertia including added inertia.
    pub inertia: f64,
    /// `B`, damping.
    pub damping: f64,
    /// `M_e = W BG`.
    pub restoring: f64,
    /// `K`, moment per plane angle.
    pub plane_moment: f64,
}

impl PitchAlone {
    /// Table 8 \[ft lbf s\]: J = 0.6, B = 0.72, and `M_e = 19.6 0.1 / 12`. The table gives M_e = 0.16, but its roots are those for 0.1633; and it omits
    /// the sign of Ky = -0.14.
    pub const TABLE_8: Self = Self {
        inertia: 0.6,
        damping: 0.72,
        restoring: 19.6 * 0.1 / 12.0,
        plane_moment: 0.14,
    };

    /// The same vehicle from the dimensional column of Table 1 \[ft lbf s\], at a speed \[ft/s\]: damping is proportional to the speed, the planes'
    /// moment to its square.
    #[must_use]
    pub fn at(feet_per_second: f64) -> Self {
        Self {
            inertia: 0.6,
            damping: 0.718 * feet_per_second,
            restoring: 0.163,
            plane_moment: -0.283 * feet_per_second * feet_per_second,
        }
    }

    /// `q / delta`, gyro volts per plane volt.
    ///
    /// # Errors
    /// [`Error`] for invalid coefficients.
    pub fn volts(&self) -> Result<TransferFunction, Error> {
        TransferFunction::new(
            vec![CF1 * self.plane_moment, 0.0],
            vec![self.inertia, self.damping, self.restoring],
        )
    }

    /// Steady-state gain in volts per volt without restoring moment, positive for bow up per plane up.
    #[must_use]
    pub fn free_gain(&self) -> f64 {
        CF1 * self.plane_moment.abs() / self.damping
    }

    /// Decay rate of the pitch rate without restoring moment, `B / J`.
    #[must_use]
    pub fn free_decay(&self) -> f64 {
        self.damping / self.inertia
    }
}

/// Table 8 as printed: sampled with `T = 0.05 L / U`.
pub mod table_8 {
    use super::{
        CF1, CF2_PRINTED, D2_ANOMALY, DepthRate, Error, FEET_PER_LENGTH, PRINTED, PitchAlone,
        SAMPLING_TIME, TransferFunction,
    };

    /// `q / delta`, second order (volts per volt), with a restoring moment \[ft lbf\].
    ///
    /// # Errors
    /// None for a finite moment.
    pub fn pitch_rate_second_order(restoring: f64) -> Result<TransferFunction, Error> {
        let pitch = PitchAlone {
            restoring,
            ..PitchAlone::TABLE_8
        };
        pitch.volts()?.zero_order_hold(SAMPLING_TIME)
    }

    /// `q / delta`, third order, without its gain [`pitch_rate_gain`].
    ///
    /// # Errors
    /// None.
    pub fn pitch_rate_third_order() -> Result<TransferFunction, Error> {
        PRINTED.pitch_rate()?.zero_order_hold(SAMPLING_TIME)
    }

    /// Factor from [`pitch_rate_third_order`] to volts per volt, per `U` \[ft/s\]: `Cf1 / L`. The copy shows "1.54U" instead of 0.54U.
    #[must_use]
    pub fn pitch_rate_gain() -> f64 {
        CF1 / FEET_PER_LENGTH
    }

    /// `z / q`, second order: `b U (z + 1) / (z - 1)^2`. Returns `b = Cf2 T^2 / 2`.
    #[must_use]
    pub fn depth_second_order() -> f64 {
        CF2_PRINTED * SAMPLING_TIME * SAMPLING_TIME / 2.0
    }

    /// `z / q`, fourth order, at a speed \[ft/s\], without its gain [`depth_gain`]; the `D2` of the formula is multiplied by a factor.
    ///
    /// # Errors
    /// None for a finite speed and factor.
    pub fn depth_fourth_order(
        feet_per_second: f64,
        d2_factor: f64,
    ) -> Result<TransferFunction, Error> {
        let as_printed = DepthRate::AsPrinted { feet_per_second };
        PRINTED
            .depth(as_printed, d2_factor)?
            .zero_order_hold(SAMPLING_TIME)
    }

    /// [`depth_fourth_order`] as printed in Table 8, with [`D2_ANOMALY`].
    ///
    /// # Errors
    /// Same as [`depth_fourth_order`].
    pub fn depth_as_printed(feet_per_second: f64) -> Result<TransferFunction, Error> {
        depth_fourth_order(feet_per_second, D2_ANOMALY)
    }

    /// Factor from [`depth_fourth_order`] to volts per volt, times `U` \[ft/s\]: `Cf2 L^2`.
    #[must_use]
    pub fn depth_gain() -> f64 {
        CF2_PRINTED * FEET_PER_LENGTH * FEET_PER_LENGTH
    }
}

/// Table 8 corrected: `q / delta` in gyro volts per plane volt, for any vehicle at a speed \[m/s\], sampled every `dt` \[s\].
///
/// # Errors
/// [`Error`] for numerical overflow or a `dt` that is not positive.
pub fn pitch_rate_in_volts(
    vehicle: &Vehicle,
    speed: f64,
    dt: f64,
) -> Result<TransferFunction, Error> {
    Ok(scaled(sampled(vehicle, speed, dt, Output::PitchRate)?, CF1))
}

/// Depth over plane angle, in depth cell volts per plane volt, for any vehicle at a speed \[m/s\].
///
/// # Errors
/// Same as [`pitch_rate_in_volts`].
pub fn depth_in_volts(vehicle: &Vehicle, speed: f64, dt: f64) -> Result<TransferFunction, Error> {
    Ok(scaled(
        sampled(vehicle, speed, dt, Output::Depth)?,
        DEPTH_VOLTS_PER_PLANE_VOLT,
    ))
}

fn sampled(
    vehicle: &Vehicle,
    speed: f64,
    dt: f64,
    output: Output,
) -> Result<TransferFunction, Error> {
    linearised::response(&vehicle.derivatives(speed), output)?
        .zero_order_hold(dt)?
        .transfer_function(0, 0)
}

/// The built-in vehicle with `M'theta` rounded as in Table 1: -0.106 at 1 ft/s instead of -0.10613.
#[must_use]
pub fn with_the_rounded_restoring_moment(vehicle: &Vehicle) -> Vehicle {
    let moment = PRINTED.d1 * vehicle.reference_mass * FOOT * FOOT;
    Vehicle {
        restoring_arm: moment / vehicle.weight,
        ..vehicle.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::ComplexFunctions as _;
    use planesman_vehicle::vehicle_file::brunner;

    fn close(found: &[f64], expected: &[f64], tolerance: f64) {
        assert_eq!(found.len(), expected.len());
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < tolerance, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn the_third_order_pitch_rate_of_table_8_comes_out_with_its_time_unit_error() {
        let g = table_8::pitch_rate_third_order().expect("a model");
        close(&g.num, &[0.0, -0.1191, 0.2313, -0.1122], 6e-5);
        close(&g.den, &[1.0, -2.8074, 2.6257, -0.8181], 6e-5);
    }

    #[test]
    fn the_fourth_order_depth_of_table_8_needs_one_and_a_half_times_d2() {
        let printed = [1.0, -3.8298, 5.4927, -3.4962, 0.8332];
        let anomalous = table_8::depth_as_printed(1.2).expect("a model");
        close(&anomalous.den, &printed, 3e-4);
        close(
            &anomalous.num,
            &[0.0, -0.0001, 0.0034, -0.0063, 0.0029],
            1.3e-4,
        );
        let by_the_formula = table_8::depth_fourth_order(1.2, 1.0).expect("a model");
        assert!((by_the_formula.den[4] - 0.8332).abs() > 0.05);
    }

    #[test]
    fn the_coefficients_of_the_vehicle_file_are_those_printed() {
        let found = Equation7::of(&brunner(), FOOT);
        assert!((found.d1 - PRINTED.d1).abs() < 5e-4);
        for (f, p) in [
            (found.b2, PRINTED.b2),
            (found.c2, PRINTED.c2),
            (found.a1, PRINTED.a1),
        ] {
            assert!((f - p).abs() < 1e-9, "{f} is not {p}");
        }
    }

    /// `s` in `U / L` to `s` in rad/s: `s' = s L / U`, power by power.
    fn in_seconds(g: &TransferFunction, unit: f64) -> TransferFunction {
        let scale = |c: &[f64]| -> Vec<f64> {
            let degree = c.len() as i32 - 1;
            (0..)
                .zip(c)
                .map(|(i, c)| c * unit.powi(degree - i))
                .collect()
        };
        TransferFunction {
            num: scale(&g.num),
            den: scale(&g.den),
        }
    }

    #[test]
    fn equation_7_put_right_is_the_linear_vehicle() {
        let vehicle = brunner();
        for speed in [0.3, 0.55, 0.64] {
            let unit = vehicle.reference_length / speed;
            let eq7 = Equation7::of(&vehicle, speed);
            let rate = eq7.pitch_rate().expect("(7a)");
            // q' = q L / U.
            let rate = scaled(in_seconds(&rate, unit), 1.0 / unit);
            let rate = rate.zero_order_hold(0.05).expect("sampled");
            let linear = pitch_rate_in_volts(&vehicle, speed, 0.05).expect("a model");
            close(&rate.den, &linear.den, 1e-11);
            close(&scaled(rate, CF1).num, &linear.num, 1e-11);

            // z / delta = (7a) (7b); the factor E s + F of (7a) stands below in (7b).
            let depth = eq7.depth_minimal(DepthRate::Corrected).expect("(7b)");
            let mut den = eq7.denominator().to_vec();
            den.push(0.0);
            let depth = TransferFunction::new(depth.num, den).expect("z / delta");
            // z' = z / L.
            let depth = scaled(in_seconds(&depth, unit), vehicle.reference_length);
            let depth = depth.zero_order_hold(0.05).expect("sampled");
            let linear = depth_in_volts(&vehicle, speed, 0.05).expect("a model");
            close(&depth.den, &linear.den, 1e-11);
            let depth = scaled(depth, DEPTH_VOLTS_PER_PLANE_VOLT);
            close(&depth.num, &linear.num, 1e-13);
        }
    }

    #[test]
    fn the_pole_and_zero_that_equation_7b_has_in_common_leave_nothing_behind() {
        for depth_rate in [
            DepthRate::Corrected,
            DepthRate::AsPrinted {
                feet_per_second: 1.2,
            },
        ] {
            let full = PRINTED.depth(depth_rate, 1.0).expect("(7b)");
            let minimal = PRINTED.depth_minimal(depth_rate).expect("(7b)");
            for point in [0.3, 1.7] {
                let point = planesman_linear::Complex::new(0.2, point);
                let (f, m) = (full.value_at(point), minimal.value_at(point));
                assert!((f - m).modulus() < 1e-12 * f.modulus(), "{f} is not {m}");
            }
        }
    }
}
