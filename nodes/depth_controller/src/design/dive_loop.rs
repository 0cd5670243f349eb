//! The whole dive loop on paper: any vehicle, all four gains, an actuator with dead time.
//!
//! With depth and its rate, pitch and its rate fed back (bow up, dive-positive planes, SI), the planes are asked
//! for
//!
//! ```text
//! delta = Kpy (Kpz (z_c - z) - Kdz z') + Kpy theta + Kr q
//! ```
//! Broken at the planes, with `G_x` from `delta` to `x` and the actuator `A(s)`, the loop is
//!
//! ```text
//! L(s) = -A (Kr G_q + Kpy G_theta - Kpy Kpz G_z - Kpy Kdz G_z')
//! ```
//! and closed, `z / z_c = Kpy Kpz A G_z / (1 + L)` (Brunner, NPS thesis, 1988, pp. 9 to 20, whose vehicle is
//! a [`PitchModel`] and whose planes are ideal).

use planesman_linear::{
    Complex, DMatrix, DelayedLoop, Error, RouthColumn, StateSpace, StepMetrics, TransferFunction,
    frequency::{GainMargin, PhaseMargin},
    polynomial,
};

use super::step;
use crate::gains::{LoopGains, PitchModel};

/// The frequencies between which phase crossovers are looked for, rad/s.
const FREQUENCIES: (f64, f64) = (1e-4, 1e3);

/// The samples of a step response.
const STEP_SAMPLES: f64 = 1500.0;

/// The vehicle about level flight, from the dive planes (rad, dive) to pitch rate (rad/s, bow up), pitch (rad,
/// bow up), depth (m, down) and depth rate (m/s).
#[derive(Clone, Debug, PartialEq)]
pub struct DivePlant(StateSpace);

impl DivePlant {
    /// The vehicle of a state space with those four outputs, in that order.
    ///
    /// # Errors
    /// [`Error::Shape`] for any other number of outputs or inputs.
    pub fn new(state_space: StateSpace) -> Result<Self, Error> {
        if state_space.d.shape() == (4, 1) {
            Ok(Self(state_space))
        } else {
            Err(Error::Shape {
                what: "the vehicle",
                found: format!(
                    "{} outputs of {} inputs",
                    state_space.d.nrows(),
                    state_space.d.ncols()
                ),
                expected: "4 outputs of 1 input".to_owned(),
            })
        }
    }

    /// A damped inertia that goes where it points: `z' = -U theta`.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn of_pitch(model: &PitchModel, speed: f64) -> Result<Self, Error> {
        let PitchModel {
            plane,
            damping,
            restoring,
        } = *model;
        // x = (q, theta, z)
        #[rustfmt::skip]
        let a = [
            -damping, -restoring, 0.0,
            1.0,      0.0,        0.0,
            0.0,      -speed,     0.0,
        ];
        #[rustfmt::skip]
        let c = [
            1.0, 0.0,    0.0,
            0.0, 1.0,    0.0,
            0.0, 0.0,    1.0,
            0.0, -speed, 0.0,
        ];
        StateSpace::new(
            DMatrix::from_row_slice(3, 3, &a),
            DMatrix::from_row_slice(3, 1, &[-plane, 0.0, 0.0]),
            DMatrix::from_row_slice(4, 3, &c),
            DMatrix::zeros(4, 1),
        )
        .and_then(Self::new)
    }
}

/// The actuator between command and planes, in small motion: a lag and a dead time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Path {
    /// s; 0 for none.
    pub lag: f64,
    /// s
    pub delay: f64,
}

/// A vehicle, gains and an actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct DiveLoop {
    /// The vehicle.
    pub plant: DivePlant,
    /// `Kpz`, `Kdz`, `Kpy`, `Kr`.
    pub gains: LoopGains,
    /// The actuator.
    pub path: Path,
}

/// Stability, margins and step response of a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Of the closed loop, 1/s, slowest first; dead time as Pade's ratio.
    pub poles: Vec<Complex<f64>>,
    /// Routh's scheme of the same.
    pub routh: RouthColumn,
    /// At every gain crossover.
    pub phase: Vec<PhaseMargin>,
    /// At every phase crossover.
    pub gain: Vec<GainMargin>,
    /// Of depth after a unit step of the setpoint; `None` for an unstable loop.
    pub step: Option<StepMetrics>,
}

impl Judgement {
    /// Whether every pole decays.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.poles.iter().all(|s| s.re < 0.0)
    }

    /// The phase margin nearest to zero, rad; `None` without a gain crossover.
    #[must_use]
    pub fn phase_margin(&self) -> Option<f64> {
        let margins = self.phase.iter().map(|m| m.margin);
        margins.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// By which factor the loop's gain may grow, and to which it may fall: the nearest gain margins above and
    /// below one, `None` where there is none.
    #[must_use]
    pub fn gain_limits(&self) -> (Option<f64>, Option<f64>) {
        let factors = || self.gain.iter().map(|m| m.factor);
        (
            factors().filter(|f| *f >= 1.0).min_by(f64::total_cmp),
            factors().filter(|f| *f < 1.0).max_by(f64::total_cmp),
        )
    }
}

impl DiveLoop {
    /// `L(s)`, broken at the planes.
    ///
    /// # Errors
    /// Those of [`StateSpace::transfer_function`].
    pub fn open_loop(&self) -> Result<DelayedLoop, Error> {
        let g = &self.gains;
        let fed_back = [
            -g.pitch_rate,
            -g.pitch_p,
            g.pitch_p * g.depth_p,
            g.pitch_p * g.depth_d,
        ];
        Ok(DelayedLoop {
            transfer_function: self.through_actuator(&fed_back)?,
            delay: self.path.delay,
        })
    }

    /// `z / z_c`, dead time as Pade's ratio.
    ///
    /// # Errors
    /// Those of [`StateSpace::transfer_function`].
    pub fn closed_loop(&self) -> Result<TransferFunction, Error> {
        let forward = DelayedLoop {
            transfer_function: self.through_actuator(&[
                0.0,
                0.0,
                self.gains.pitch_p * self.gains.depth_p,
                0.0,
            ])?,
            delay: self.path.delay,
        }
        .rational()?;
        let open = self.open_loop()?.rational()?;
        // Both have the actuator's and the vehicle's denominator.
        TransferFunction::new(forward.num, polynomial::sum(&open.num, &open.den))
    }

    /// Poles, margins and the step response over `duration` seconds.
    ///
    /// # Errors
    /// Those of [`DiveLoop::margins`] and [`step::response`].
    pub fn judge(&self, duration: f64) -> Result<Judgement, Error> {
        let mut judgement = self.margins()?;
        if judgement.is_stable() {
            let dt = duration / STEP_SAMPLES;
            judgement.step = Some(step::response(&self.closed_loop()?, dt, duration)?);
        }
        Ok(judgement)
    }

    /// Poles and margins, without the step response.
    ///
    /// # Errors
    /// Those of [`StateSpace::transfer_function`].
    pub fn margins(&self) -> Result<Judgement, Error> {
        let closed = self.closed_loop()?;
        let open = self.open_loop()?;
        Ok(Judgement {
            poles: closed.poles()?,
            routh: RouthColumn::of(&closed.den)?,
            phase: open.phase_margins()?,
            gain: open.gain_margins(FREQUENCIES.0, FREQUENCIES.1),
            step: None,
        })
    }

    /// A weighted sum of the vehicle's four outputs, behind the actuator's lag.
    fn through_actuator(&self, weights: &[f64; 4]) -> Result<TransferFunction, Error> {
        let StateSpace { a, b, c, d } = &self.plant.0;
        let row = DMatrix::from_row_slice(1, 4, weights);
        let seen = StateSpace::new(a.clone(), b.clone(), &row * c, &row * d)?;
        seen.transfer_function(0, 0)?.series(&TransferFunction::new(
            vec![1.0],
            if self.path.lag > 0.0 {
                vec![self.path.lag, 1.0]
            } else {
                vec![1.0]
            },
        )?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gains::T6 as PROGRAM_T6;

    const T6: LoopGains = PROGRAM_T6.reference;

    /// The report's vehicle and gains, in feet.
    fn report(speed: f64, gains: LoopGains) -> DiveLoop {
        DiveLoop {
            plant: DivePlant::of_pitch(&PROGRAM_T6.law.model, speed).unwrap(),
            gains,
            path: Path::default(),
        }
    }

    #[test]
    fn without_derivative_the_loop_is_lost_between_two_and_a_quarter_and_three_feet_per_second() {
        let gains = LoopGains { depth_d: 0.0, ..T6 };
        for (speed, stable) in [(1.0, true), (2.2, true), (2.3, false), (3.0, false)] {
            let judged = report(speed, gains).judge(60.0).unwrap();
            assert_eq!(judged.is_stable(), stable, "{speed}");
            assert_eq!(judged.routh.unstable_roots() == Some(0), stable);
            assert_eq!(judged.step.is_some(), stable);
        }
    }

    #[test]
    fn the_gain_margin_puts_a_pole_on_the_axis() {
        let mut dive = report(1.0, T6);
        dive.path.delay = 0.2;
        let (above, _) = dive.judge(60.0).unwrap().gain_limits();
        let factor = above.unwrap();
        let LoopGains {
            pitch_p,
            pitch_rate,
            ..
        } = dive.gains;
        // Everything fed back passes the planes: Kpy and Kr together are the loop's gain.
        let nearest = |factor: f64| {
            let mut scaled = dive.clone();
            scaled.gains.pitch_p = pitch_p * factor;
            scaled.gains.pitch_rate = pitch_rate * factor;
            let poles = scaled.closed_loop().unwrap().poles().unwrap();
            poles.iter().map(|s| s.re).fold(f64::MIN, f64::max)
        };
        assert!(nearest(0.95 * factor) < 0.0 && nearest(1.05 * factor) > 0.0);
    }

    #[test]
    fn dead_time_and_lag_cost_phase() {
        let margin = |path| {
            let dive = DiveLoop {
                path,
                ..report(1.0, T6)
            };
            dive.judge(60.0).unwrap().phase_margin().unwrap()
        };
        let ideal = margin(Path::default());
        assert!(
            margin(Path {
                lag: 0.1,
                delay: 0.0
            }) < ideal
        );
        assert!(
            margin(Path {
                lag: 0.0,
                delay: 0.1
            }) < ideal
        );
    }
}
