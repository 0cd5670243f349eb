//! A plant and a controller as a closed loop: margins, stability, responses.

use nalgebra::Complex;
use planesman_linear::ComplexFunctions as _;
use planesman_linear::frequency::{self, Response};
use planesman_linear::polynomial::{lies_within, product, sum};

use crate::controller::Controller;
use crate::plant::Plant;

/// The frequencies of a loop range from the first to the second share of Nyquist's frequency, where every loop is real.
const SHARES_OF_NYQUIST: (f64, f64) = (1e-6, 0.9999);

/// A value counts as real if its imaginary part is below this share of its magnitude.
const REAL: f64 = 1e-3;

/// The miss of an unstable loop, in addition to the number of circles that do not contain its poles: circles of radius 1 and a growing part
/// beyond.
const UNSTABLE: f64 = 10.0;
const RADIUS: (f64, f64) = (1e-3, 1.6);
const RADII: i32 = 20;

/// A plant and its frequency response.
#[derive(Clone, Debug)]
pub struct PlantResponse {
    /// The plant.
    pub plant: Plant,
    /// Frequencies, rad/s, and the response, output unit per input unit.
    pub response: Response,
}

/// Margins of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Whether every pole of the closed loop is stable.
    pub is_stable: bool,
    /// The smallest phase margin, rad; infinite without a gain crossover, negative infinite for an unstable loop.
    pub phase: f64,
    /// The factor by which the gain may at least rise or fall, above 1; infinite without a phase crossover, 0 for an unstable loop.
    pub gain: f64,
    /// The largest `|1 / (1 + L)|`; infinite for an unstable loop.
    pub sensitivity: f64,
    /// The highest gain crossover, rad/s; `None` if there is none.
    pub crossover: Option<f64>,
}

impl Margins {
    const UNSTABLE: Self = Self {
        is_stable: false,
        phase: f64::NEG_INFINITY,
        gain: 0.0,
        sensitivity: f64::INFINITY,
        crossover: None,
    };
}

impl PlantResponse {
    /// Of a plant.
    #[must_use]
    pub fn new(plant: Plant) -> Self {
        let nyquist = plant.nyquist();
        let (lowest, highest) = SHARES_OF_NYQUIST;
        let mut grid = frequency::grid(lowest * nyquist, highest * nyquist);
        grid.push(nyquist);
        let response = grid.into_iter().map(|w| (w, plant.at(w)));
        // At a pole on the unit circle there is none.
        let response = response.filter(|(_, p)| p.re.is_finite() && p.im.is_finite());
        Self {
            response: response.collect(),
            plant,
        }
    }

    /// The open loop's response with a controller, at the plant's frequencies.
    #[must_use]
    pub fn open_loop(&self, controller: &Controller) -> Response {
        let tick = self.plant.tick;
        let points = self.response.iter();
        points
            .map(|(w, p)| (*w, p * controller.at(*w, tick)))
            .collect()
    }

    /// Whether the loop is stable.
    #[must_use]
    pub fn is_stable(&self, controller: &Controller) -> bool {
        self.closed_loop(controller)
            .is_some_and(|all| lies_within(&all, 1.0))
    }

    /// The closed loop's polynomial in `1/z` after its leading 1, `A D + z^-d B N` with `C = N/D`; `None` if there is no leading 1.
    fn closed_loop(&self, controller: &Controller) -> Option<Vec<f64>> {
        let Plant { a, b, delay, tick } = &self.plant;
        let (num, den) = controller.backward(*tick);
        let monic: Vec<f64> = std::iter::once(1.0).chain(a.iter().copied()).collect();
        let mut through = vec![0.0; *delay];
        through.extend(product(b, &num));
        // In powers of 1/z: the shorter one ends earlier.
        let (mut own, mut through) = (product(&monic, &den), through);
        let length = own.len().max(through.len());
        own.resize(length, 0.0);
        through.resize(length, 0.0);
        let all = sum(&own, &through);
        let lead = all[0];
        (lead != 0.0).then(|| all[1..].iter().map(|c| c / lead).collect())
    }

    /// Stability and margins with a controller.
    #[must_use]
    pub fn margins(&self, controller: &Controller) -> Margins {
        self.margins_with(controller, &self.on_grid(controller))
    }

    /// The controller's response at the plant's frequencies, which are the same for plants with the same tick.
    pub(crate) fn on_grid(&self, controller: &Controller) -> Vec<Complex<f64>> {
        let points = self.response.iter();
        points
            .map(|(w, _)| controller.at(*w, self.plant.tick))
            .collect()
    }

    /// The margins, computed from a given response of the controller at the plant's frequencies.
    pub(crate) fn margins_with(
        &self,
        controller: &Controller,
        on_grid: &[Complex<f64>],
    ) -> Margins {
        if !self.is_stable(controller) {
            return Margins::UNSTABLE;
        }
        let tick = self.plant.tick;
        let at = |w: f64| self.plant.at(w) * controller.at(w, tick);
        let response = match on_grid.len() == self.response.len() {
            true => {
                let points = self.response.iter().zip(on_grid);
                points.map(|((w, p), c)| (*w, p * c)).collect()
            }
            false => self.open_loop(controller),
        };
        let phases = frequency::phase_margins(&response, at);
        let factors = frequency::gain_margins(&response, at);
        // At both ends the loop is real, which no change of sign tells.
        let ends = [response.first(), response.last()].into_iter().flatten();
        let ends = ends.filter(|(_, l)| l.re < 0.0 && l.im.abs() < REAL * l.modulus());
        let ends = ends.map(|(_, l)| 1.0 / l.modulus());
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let factors = factors.iter().map(|it| it.factor).chain(ends);
        Margins {
            is_stable: true,
            phase: least(&mut phases.iter().map(|it| it.margin.abs())),
            gain: least(&mut factors.map(|factor| factor.max(1.0 / factor))),
            sensitivity: frequency::sensitivity_peak(&response, at)
                .map_or(f64::INFINITY, |it| it.value),
            crossover: phases.last().map(|it| it.frequency),
        }
    }
}

/// The required margins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The smallest phase margin, rad.
    pub phase: f64,
    /// The smallest factor by which the gain may rise or fall, above 1.
    pub gain: f64,
    /// The largest sensitivity peak.
    pub sensitivity: f64,
}

impl Limits {
    /// Whether margins satisfy the limits.
    #[must_use]
    pub fn are_kept(&self, by: &Margins) -> bool {
        by.is_stable
            && by.phase >= self.phase
            && by.gain >= self.gain
            && by.sensitivity <= self.sensitivity
    }

    /// The amount by which a loop misses the limits, for searches. For an unstable loop this is [`UNSTABLE`] plus a value that grows with its poles, for
    /// others the sum of the relative deficits; 0 if all are satisfied.
    #[must_use]
    pub(crate) fn missed_by(&self, seen: &PlantResponse, controller: &Controller) -> f64 {
        let margins = seen.margins(controller);
        if !margins.is_stable {
            let all = seen.closed_loop(controller).unwrap_or_default();
            let radius = |step: i32| 1.0 + RADIUS.0 * RADIUS.1.powi(step);
            let beyond = (0..RADII).take_while(|step| !lies_within(&all, radius(*step)));
            return UNSTABLE + beyond.count() as f64;
        }
        if self.are_kept(&margins) {
            return 0.0;
        }
        let lacking = (1.0 - margins.phase / self.phase).max(0.0)
            + (1.0 - margins.gain / self.gain).max(0.0)
            + (margins.sensitivity / self.sensitivity - 1.0).max(0.0);
        lacking.max(f64::MIN_POSITIVE)
    }

    /// Tightens the limits by a share: 0 leaves them unchanged, and no loop satisfies the limits at 1.
    #[must_use]
    pub(crate) fn tightened(&self, share: f64) -> Self {
        let phase = self.phase.min(std::f64::consts::FRAC_PI_2);
        Self {
            phase: self
                .phase
                .max(phase + share * (std::f64::consts::FRAC_PI_2 - phase)),
            gain: self.gain / (1.0 - share).max(1e-6),
            sensitivity: 1.0 + (self.sensitivity - 1.0) * (1.0 - share),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::TransferFunction;

    fn seen(num: &[f64], den: &[f64], delay: f64, tick: f64) -> PlantResponse {
        let transfer = TransferFunction::new(num.to_vec(), den.to_vec()).unwrap();
        PlantResponse::new(Plant::held(&transfer, delay, tick).unwrap())
    }

    /// Skogestad 2003, Table 1: SIMC with tau_c = theta on first order with tau_1 <= 8 theta has L = e^(-theta s) / (2 theta s): phase
    /// margin 90 deg - 1/2 rad = 61.4 deg at 1/(2 theta), gain margin pi = 3.14, Ms 1.59.
    #[test]
    fn simc_on_a_lag_has_the_margins_of_the_papers_table() {
        let pi = Controller::ideal(4.0 / (2.0 * 2.0 * 1.0), 4.0, 0.0);
        // A thousandth of the dead time as tick; half of it is dead time of the hold.
        let found = seen(&[2.0], &[4.0, 1.0], 1.0 - 0.0005, 0.001).margins(&pi);
        assert!(found.is_stable);
        assert!((found.phase.to_degrees() - (90.0 - 0.5_f64.to_degrees())).abs() < 0.05);
        assert!((found.crossover.unwrap() - 0.5).abs() < 1e-3);
        assert!((found.gain - std::f64::consts::PI).abs() < 5e-3);
        assert!((found.sensitivity - 1.59).abs() < 5e-3);
    }

    /// The same, integrating: phase margin 46.9 deg, gain margin 2.96, Ms 1.70.
    #[test]
    fn simc_on_an_integrator_has_the_margins_of_the_papers_table() {
        let pi = Controller::ideal(1.0 / (2.0 * 0.3), 8.0, 0.0);
        let found = seen(&[0.3], &[1.0, 0.0], 1.0 - 0.0005, 0.001).margins(&pi);
        assert!((found.phase.to_degrees() - 46.9).abs() < 0.05, "{found:?}");
        assert!((found.gain - 2.96).abs() < 5e-3);
        assert!((found.sensitivity - 1.70).abs() < 5e-3);
    }

    #[test]
    fn stability_is_that_of_the_closed_loops_poles() {
        // y' = u with a command that is one tick late is stable below k T = (sqrt 5 - 1)/2 (z^2 - z + k T = 0: |z| = 1 at k T = 1).
        let plant = seen(&[1.0], &[1.0, 0.0], 0.1, 0.1);
        let by = |k: f64| {
            plant.is_stable(&Controller {
                kp: k,
                ki: 0.0,
                kd: 0.0,
                filter: 0.0,
            })
        };
        assert!(by(9.99) && !by(10.01) && !by(-0.1));
        // An unstable pole z = 1.1, z - 1.1 + 0.2 k: stable for 0.5 < k < 10.5.
        let plant = PlantResponse::new(Plant::of_z(&[0.2], &[1.0, -1.1], 0.1, 0));
        let by = |k: f64| {
            plant.is_stable(&Controller {
                kp: k,
                ki: 0.0,
                kd: 0.0,
                filter: 0.0,
            })
        };
        assert!(!by(0.49) && by(0.51) && by(10.49) && !by(10.51));
        let margins = plant.margins(&Controller {
            kp: 1.0,
            ki: 0.0,
            kd: 0.0,
            filter: 0.0,
        });
        assert!(
            (margins.gain - 2.0).abs() < 1e-3,
            "it may fall to half: {margins:?}"
        );
    }

    #[test]
    fn an_unstable_loop_misses_its_limits_by_more_the_larger_its_poles() {
        let plant = seen(&[2.0], &[4.0, 1.0], 1.0, 0.1);
        let limits = Limits {
            phase: 0.8,
            gain: 2.0,
            sensitivity: 1.6,
        };
        let missed = |gain: f64| limits.missed_by(&plant, &Controller::ideal(gain, 4.0, 0.0));
        // The margins of this loop are those of `the gain margin`, pi at a gain of 1.
        assert_eq!(missed(0.9), 0.0);
        assert!((missed(2.5) - missed(1.5)) > 0.1 && missed(2.5) < UNSTABLE);
        assert!(missed(4.0) >= UNSTABLE && missed(40.0) > missed(4.0));
    }
}
