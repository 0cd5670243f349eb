//! The linear model of Section V of IBM 66-L03-005: what remains of the actuator for signals large
//! beside its quantum and small beside its rate.
//!
//! A volume that is commanded at t = 0 flows from T_D + T_v over T_f:
//!
//! ```text
//! V/command = (V_c/s) e^-(T_D + T_v)s (1 - e^(-T_f s))/(T_f s),    (1 - e^(-T_f s))/(T_f s) ~ e^(-T_f s/2)
//! ```
//! and the pulse logic with its accumulator is a zero-order hold over T, about e^(-T s/2). Quantizer
//! and minor loop being one, the planes follow what is asked for with a dead time (Figure 5-5):
//!
//! ```text
//! A(s) = e^(-tau s) [omega_n^2/(s^2 + 2 zeta omega_n s + omega_n^2)],    tau = T_D + T_v + T_f/2 + T/2
//! ```
//! The bracket is the ram on its oil column, without friction; the report leaves it out. **Gain
//! margins are not to be read off this model**: friction and the force limit make them half as large.

use planesman_linear::{DelayedLoop, Error, TransferFunction};

use crate::actuator_set::ActuatorSet;

/// How the linear model takes the ram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ram {
    /// It follows the oil metered in, as in the report.
    Rigid,
    /// It rides on its oil column with omega_n and zeta.
    OnItsOil,
}

/// tau, s: from the angle asked for to the planes.
#[must_use]
pub fn dead_time(set: &ActuatorSet) -> f64 {
    set.delay() + 0.5 * set.flow_time + 0.5 * set.cycle()
}

/// The actuator from the plane angle asked for to the plane angle, both rad: steady gain 1. Its
/// [`DelayedLoop::at`] has the dead time exact, its [`DelayedLoop::rational`] by Pade.
///
/// # Errors
/// [`Error::NotFinite`], for constants beyond all measure.
pub fn actuator(set: &ActuatorSet, ram: Ram) -> Result<DelayedLoop, Error> {
    let (wn, zeta) = (set.natural_frequency(), set.damping_ratio());
    let transfer_function = match ram {
        Ram::Rigid => TransferFunction::new(vec![1.0], vec![1.0])?,
        Ram::OnItsOil => TransferFunction::new(vec![wn * wn], vec![1.0, 2.0 * zeta * wn, wn * wn])?,
    };
    Ok(DelayedLoop {
        transfer_function,
        delay: dead_time(set),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use planesman_testing::near;

    #[track_caller]
    #[test]
    fn the_dead_times_of_the_three_actuators() {
        for (name, milliseconds) in [
            ("table_3_1", 16.5606),
            ("table_4_1", 16.5606),
            ("auv", 14.75),
        ] {
            near(dead_time(&load(name).unwrap()) * 1e3, milliseconds, 1e-4);
        }
    }

    #[test]
    fn the_linear_actuator_only_delays_until_the_column_rings() {
        let set = load("table_4_1").unwrap();
        let slow = actuator(&set, Ram::OnItsOil).unwrap().at(5.0);
        near(slow.norm(), 1.0, 1e-3);
        near(slow.arg(), -5.0 * 0.0165606, 3e-3);
        let ringing = actuator(&set, Ram::OnItsOil).unwrap();
        near(
            ringing.at(set.natural_frequency()).norm(),
            0.5 / set.damping_ratio(),
            1e-9,
        );
    }
}
