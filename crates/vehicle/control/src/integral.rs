//! An integral term of a control law, protected from wind-up while the output is at its limit.
//!
//! The report's loops have no integral. The strategies have the names of `control_toolbox`:
//!
//! | strategy | slope of the term, with the error `e`, the unlimited output `u`, and `u_lim` after its limit |
//! |---|---|
//! | none | `Ki e` |
//! | conditional_integration | `Ki e`, but 0 while that would drive `u` further beyond its limit |
//! | back_calculation | `Ki e + (u_lim - u) / T_t` |
//! With each strategy the integral term itself stays within its own limit (`i_clamp` in `control_toolbox`). The integral is stored in the unit of the
//! output, so a changed gain causes no step. (Astrom and Hagglund, *Advanced PID Control*, 2006, ch. 3.)

use crate::error::ParameterError;
use crate::limits::{Limit, bounded};

/// The anti-windup strategy of the integrals: the parameters `anti_windup.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct AntiWindup {
    /// Anti-windup strategy, as in control_toolbox: none, conditional_integration (an integral stops while its
    /// output is saturated) or back_calculation.
    #[parameter(default = Strategy::ConditionalIntegration)]
    pub strategy: Strategy,
    /// Tracking time constant of back_calculation, with which an integral leaves saturation.
    #[parameter(default = 1.0, unit = "s", range = 0.0..=1e3)]
    pub tracking_time_constant: f64,
}

impl AntiWindup {
    /// Checks that the strategy's parameters are given, and returns the settings unchanged.
    ///
    /// # Errors
    /// [`ParameterError::TrackingTime`].
    pub(crate) fn checked(self) -> Result<Self, ParameterError> {
        let time = self.tracking_time_constant;
        if self.strategy == Strategy::BackCalculation && time <= 0.0 {
            return Err(ParameterError::TrackingTime(time));
        }
        Ok(self)
    }
}

/// The anti-windup strategies by name, as in `control_toolbox`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Strategy {
    /// No anti-windup; only the integral's own limit applies.
    None,
    /// The integral does not move further while the output is saturated.
    ConditionalIntegration,
    /// The amount cut off by the saturation is fed back.
    BackCalculation,
}

/// An integral term: its value, and its slope until the next tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Integral {
    value: f64,
    slope: f64,
}

impl Integral {
    /// The term after `dt` seconds along its slope, limited to `limit`.
    #[must_use]
    pub fn after(&mut self, dt: f64, limit: Limit) -> f64 {
        self.value = limit.apply(self.value + bounded(self.slope * dt)).value;
        self.value
    }

    /// Sets the slope from now on: `drive` is `Ki e`, `excess` the amount that the output's limit cuts off, `u - u_lim`, both with the
    /// term's sign.
    pub fn lead(&mut self, drive: f64, excess: f64, anti_windup: AntiWindup) {
        self.slope = match anti_windup.strategy {
            Strategy::None => drive,
            Strategy::ConditionalIntegration if drive * excess > 0.0 => 0.0,
            Strategy::ConditionalIntegration => drive,
            Strategy::BackCalculation => {
                bounded(drive - excess / anti_windup.tracking_time_constant)
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn anti_windup(strategy: Strategy, tracking_time_constant: f64) -> AntiWindup {
        AntiWindup {
            strategy,
            tracking_time_constant,
        }
    }

    /// The share after 10 s at an error that asks for 1/s, and the time until `u = error + i` leaves the limit 1
    /// after the error has turned to -0.5.
    fn wound_up(anti_windup: AntiWindup) -> (f64, f64) {
        const DT: f64 = 0.01;
        let own = Limit::new(100.0).unwrap();
        let output = Limit::new(1.0).unwrap();
        let mut integral = Integral::default();
        let mut step = |error: f64| {
            let unlimited = error + integral.after(DT, own);
            let limited = output.apply(unlimited).value;
            integral.lead(error, unlimited - limited, anti_windup);
            (integral.value, limited)
        };
        let share = (0..1000).map(|_| step(1.0).0).fold(0.0, |_, i| i);
        let stuck = (0..10_000).take_while(|_| step(-0.5).1 >= 1.0).count();
        (share, stuck as f64 * DT)
    }

    #[test]
    fn without_a_strategy_the_share_winds_up_and_holds_the_output_at_its_limit() {
        let (share, stuck) = wound_up(anti_windup(Strategy::None, 0.0));
        assert!(share > 9.9);
        assert!(stuck > 15.0);
    }

    #[test]
    fn each_strategy_frees_the_output_when_the_error_turns() {
        for strategy in [Strategy::ConditionalIntegration, Strategy::BackCalculation] {
            let (share, stuck) = wound_up(anti_windup(strategy, 0.5));
            assert!(share < 1.0, "{strategy:?}: {share}");
            assert_eq!(stuck, 0.0, "{strategy:?}");
        }
    }

    #[test]
    fn the_share_stays_within_its_own_limit() {
        let mut integral = Integral::default();
        integral.lead(f64::MAX, 0.0, anti_windup(Strategy::None, 0.0));
        assert_eq!(integral.after(1e9, Limit::new(0.2).unwrap()), 0.2);
    }

    #[test]
    fn back_calculation_needs_a_tracking_time_constant() {
        let checked = |strategy| anti_windup(strategy, 0.0).checked();
        assert!(checked(Strategy::BackCalculation).is_err());
        assert!(checked(Strategy::ConditionalIntegration).is_ok());
    }
}
