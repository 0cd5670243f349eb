//! A transfer function with a dead time, fitted to a frequency response in the band of sufficient coherence.
//!
//! ```text
//! J = 20/n sum W [ (dB error)^2 + 0.01745 (phase error, deg)^2 ],   W = (1.58 (1 - e^(-g2)))^2
//! ```
//! over the n frequencies of the band, with coherence g2 (Tischler and Remple, *Aircraft and Rotorcraft System Identification*, 2nd ed.,
//! 2012, ch. 11). The model includes zero-order hold ([`Orders`]), so no factor for the hold is needed.
//!
//! - **Starts**: linear least squares on `N - H D`, weighted by the previous denominator (Sanathanan and Koerner, *IEEE Trans. Automatic
//!   Control* 8, 1963), for dead times that the phase allows.
//! - **Orders**: up to four poles, with and without dead time. The fewest parameters are chosen whose criterion `2 N ln V + p ln 2N` is not
//!   clearly above the smallest. V is the mean square of the errors over their random errors, N the number of frequencies that the windows
//!   resolve.
//! - **Leakage**: in each segment the response to earlier inputs continues. The same windows on the simulated output give its size, and the
//!   response is corrected by it: `H = H_model + <g, y - simulated>`.
//! - **Intervals**: the parameters are, to first order, weighted sums of the noise's samples. The weights are summed over all frequencies and
//!   windows, so that common parts count once; the noise spectrum is the spectrum of the simulated error.

mod sampled;

use nalgebra::{DMatrix, DVector};
use planesman_linear::{Complex, ComplexFunctions as _, DelayedLoop, polar, unwrapped_phases};
use planesman_wording::option;

use super::coloured::{whitened, whitening};
use super::delayed_transfer::{HeldInputTransfer, Orders, slopes};
use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::frequency_fit::{Candidate, FrequencyFit};
use super::levenberg_marquardt::{Linearised, lowered, unit_factor};
use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use crate::frequency::{COHERENCE, Columns, DECIBEL, Settings, Spectra, band};
use crate::structure::Problem;
use planesman_parallel::on_all_cores;
use sampled::{Simulated, sampled};

/// Tischler's weight of a phase error, 1 deg against 1 dB, and the scale of the cost.
const PHASE_WEIGHT: f64 = 0.017_45;
const SCALE: f64 = 20.0;
/// Poles tried.
const MOST_POLES: usize = 4;
/// Number of initial dead times, and of searches started from the best of them.
const DEAD_TIMES: usize = 16;
const SEARCHES: usize = 3;
/// Maximum number of steps of a search, and the relative decrease of the cost at which it ends.
const STEPS: usize = 25;
const SHARE: f64 = 1e-2;
const FINE: (usize, f64) = (200, 1e-9);
/// Dead times this close to a whole sample, where the derivative jumps, are treated as equal to it, and searched again at this distance on both
/// sides, samples.
const NEAR_A_SAMPLE: f64 = 0.05;
const BESIDE: f64 = 0.3;
/// The smallest random error in the criterion, as a share of the median.
const LEAST_ERROR: f64 = 0.2;
/// Number of orders compared again once the leakage is known.
const COMPARED: usize = 6;
/// The criterion of a model with more parameters must be lower by at least this.
const BEYOND_DOUBT: f64 = 10.0;
/// Rounds of the linear start, and of the correction for leakage.
const ROUNDS: usize = 6;
const CORRECTIONS: usize = 3;
/// Minimum share of a band, on a logarithmic axis, that other data must cover to validate a model of the band.
const COVERED: f64 = 0.9;
/// The bandwidth of a Hann window, in cycles per window (Harris, *Proc. IEEE* 66, 1978).
const BANDWIDTH: f64 = 1.5;
/// Number of parts in which the noise weights are summed in parallel.
const PARTS: usize = 4;

/// A transfer function fitted to the frequency response. Of the problem's structure only the offset and the initial state are used.
#[derive(Clone, Debug, Default)]
pub struct FrequencyDomain {
    /// The orders; `None` to choose them.
    pub orders: Option<Orders>,
    /// Constraints on the choice: requested and known poles, zeros and dead time.
    pub given: TransferConstraints,
    /// The lowest coherence used; `None` for [`COHERENCE`].
    pub coherence: Option<f64>,
    /// The reference of the loop, at least as long as each record; empty in open loop.
    pub references: Vec<Vec<f64>>,
    /// The band of the model that data must cover, rad/s.
    pub covering: Option<(f64, f64)>,
}

/// Constraints on a transfer function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransferConstraints {
    /// The number of poles, not counting known poles.
    pub poles: Option<usize>,
    /// The number of zeros, not counting known zeros.
    pub zeros: Option<usize>,
    /// Its dead time, s.
    pub delay: Option<f64>,
    /// Poles known to be at s = 0.
    pub integrators: usize,
    /// Zeros known to be at s = 0.
    pub differentiators: usize,
}

impl TransferConstraints {
    /// All combinations of orders that satisfy the constraints.
    fn choices(&self) -> Vec<Orders> {
        let poles = self.poles.map_or(1..=MOST_POLES, |it| it..=it);
        let of_poles = |poles: usize| {
            let most = poles + self.integrators;
            let zeros = self.zeros.map_or(0..=most, |it| it..=it);
            zeros.flat_map(move |zeros| {
                let delays = match self.delay {
                    Some(delay) => vec![Some(delay)],
                    None => vec![Some(0.0), None],
                };
                delays.into_iter().map(move |delay| Orders {
                    poles,
                    zeros,
                    integrators: self.integrators,
                    differentiators: self.differentiators,
                    delay,
                })
            })
        };
        poles
            .flat_map(of_poles)
            .filter(Orders::is_strictly_proper)
            .collect()
    }
}

/// The points that a transfer function is fitted to.
struct Fitted<'a> {
    /// For each point its index among all, frequency, response and weight.
    points: Vec<(usize, f64, Complex<f64>, f64)>,
    /// The inverse square of each random error, times the point's share of a resolved frequency.
    precisions: Vec<f64>,
    sample_time: f64,
    /// The middle of the band, rad/s.
    middle: f64,
    /// The number of frequencies that the windows resolve.
    told_apart: f64,
    spectra: &'a Spectra<'a>,
}

impl<'a> Fitted<'a> {
    /// Selects the points with these indices and frequencies.
    fn new(spectra: &'a Spectra<'a>, numbers: &[usize], omegas: &[f64], sample_time: f64) -> Self {
        let points = numbers.iter().map(|at| {
            let point = &spectra.points[*at];
            let weight = 1.58 * (1.0 - libm::exp(-point.coherence));
            (*at, point.omega, point.values[0], weight)
        });
        let shares = numbers.iter().enumerate().map(|(i, at)| {
            let step = (omegas[(i + 1).min(omegas.len() - 1)] - omegas[i.saturating_sub(1)]) / 2.0;
            let window = spectra.points[*at].window * sample_time;
            (step / (BANDWIDTH * std::f64::consts::TAU / window)).min(1.0)
        });
        let shares: Vec<f64> = shares.collect();
        let errors = numbers
            .iter()
            .map(|at| spectra.points[*at].phase_deviation(0));
        let errors: Vec<f64> = errors.collect();
        let mut sorted = errors.clone();
        sorted.sort_by(f64::total_cmp);
        let least = (LEAST_ERROR * sorted[sorted.len() / 2]).max(f64::MIN_POSITIVE.sqrt());
        let precisions = errors.iter().zip(&shares);
        let precisions = precisions.map(|(error, share)| share * error.max(least).powi(-2));
        Self {
            points: points.collect(),
            precisions: precisions.collect(),
            sample_time,
            middle: (omegas[0] * omegas[omegas.len() - 1]).sqrt(),
            told_apart: shares.iter().sum::<f64>().max(2.0),
            spectra,
        }
    }
}

impl Fitted<'_> {
    /// The weighted errors of each point, dB and phase; their squares sum to J.
    fn errors(&self, orders: &Orders, theta: &DVector<f64>) -> Option<DVector<f64>> {
        let values = theta.component_mul(&orders.scales(self.middle));
        let transfer = orders.transfer(&values).ok()?;
        if !(0.0..=self.longest()).contains(&transfer.delay) {
            return None;
        }
        let held = HeldInputTransfer::new(&transfer, self.sample_time).ok()?;
        let mut errors = DVector::zeros(2 * self.points.len());
        for (row, (_, omega, measured, weight)) in self.points.iter().enumerate() {
            let ratio = (measured / held.at(*omega)?).ln();
            if !(ratio.re.is_finite() && ratio.im.is_finite()) {
                return None;
            }
            errors[2 * row] = weight * self.of_decibels() * ratio.re;
            errors[2 * row + 1] = weight * self.of_phase() * ratio.im;
        }
        Some(errors)
    }

    fn root(&self) -> f64 {
        (SCALE / self.points.len() as f64).sqrt()
    }

    /// The weights of a relative error of the magnitude, and of a phase error in rad.
    fn of_decibels(&self) -> f64 {
        self.root() * DECIBEL
    }

    fn of_phase(&self) -> f64 {
        self.root() * PHASE_WEIGHT.sqrt() * 1_f64.to_degrees()
    }

    /// The longest dead time, s: the dead time that the phase allows at the top of the band, plus one turn.
    fn longest(&self) -> f64 {
        let phases = unwrapped_phases(self.points.iter().map(|it| it.2));
        let lag = phases
            .first()
            .zip(phases.last())
            .map_or(0.0, |(p, q)| p - q);
        let top = self.points.last().map_or(1.0, |it| it.1);
        (lag.max(0.0) + std::f64::consts::TAU) / top
    }

    fn linearised(&self, orders: &Orders, theta: &DVector<f64>) -> Linearised {
        let rows = 2 * self.points.len();
        match self.errors(orders, theta) {
            None => Linearised {
                errors: DVector::from_element(rows, f64::INFINITY),
                slopes: DMatrix::zeros(rows, theta.len()),
            },
            Some(errors) => Linearised {
                slopes: -slopes(theta, &errors, |theta| self.errors(orders, theta)),
                errors,
            },
        }
    }

    /// The start for a dead time, s: least squares on `N - H D`.
    fn start(&self, orders: &Orders, delay: f64) -> Option<DVector<f64>> {
        let (m, n) = (orders.zeros + 1, orders.poles);
        let rows = 2 * self.points.len();
        let mut before: Option<DVector<f64>> = None;
        let unit = Complex::new(0.0, 1.0);
        for _ in 0..ROUNDS {
            let mut columns = DMatrix::zeros(rows, m + n);
            let mut right = DVector::zeros(rows);
            for (row, (_, omega, measured, weight)) in self.points.iter().enumerate() {
                let s = unit * (omega / self.middle);
                let angle = Complex::new(0.0, -omega * self.sample_time);
                let hold = (angle.exp() - 1.0) / angle;
                let known =
                    (unit * omega).powi(orders.integrators as i32 - orders.differentiators as i32);
                let late = (unit * (omega * delay)).exp();
                let behind = measured * late * known / hold;
                let of_before = before.as_ref().map_or(Complex::new(1.0, 0.0), |theta| {
                    let lower = (0..n).map(|i| s.powi((n - 1 - i) as i32) * theta[m + i]);
                    s.powi(n as i32) + lower.sum::<Complex<f64>>()
                });
                let by = Complex::new(*weight, 0.0) / (behind * of_before);
                let mut put = |column: usize, value: Complex<f64>| {
                    columns[(2 * row, column)] = value.re;
                    columns[(2 * row + 1, column)] = value.im;
                };
                for i in 0..m {
                    put(i, by * s.powi((m - 1 - i) as i32));
                }
                for i in 0..n {
                    put(m + i, -by * behind * s.powi((n - 1 - i) as i32));
                }
                let value = by * behind * s.powi(n as i32);
                (right[2 * row], right[2 * row + 1]) = (value.re, value.im);
            }
            let sizes: Vec<f64> = (columns.column_iter())
                .map(|it| it.norm().max(f64::MIN_POSITIVE))
                .collect();
            let triangle = Triangle::new(&columns, &right).ok()?.scaled(&sizes);
            let scaled = triangle.damped(1e-7).solution().ok()?;
            before = Some(DVector::from_fn(m + n, |i, _| scaled[i] / sizes[i]));
        }
        let theta = before?;
        Some(match orders.delay {
            Some(_) => theta,
            None => theta.push(delay * self.middle),
        })
    }

    /// The least cost from a start.
    fn least(
        &self,
        orders: &Orders,
        start: DVector<f64>,
        steps: (usize, f64),
    ) -> Option<(DVector<f64>, Linearised)> {
        let lowered = |start| lowered(start, steps, |theta| self.linearised(orders, theta)).ok();
        let found = lowered(start)?;
        if orders.delay.is_some() {
            return Some(found);
        }
        let last = found.0.len() - 1;
        let per_sample = self.middle * self.sample_time;
        let delay = found.0[last] / per_sample;
        if (delay - delay.round()).abs() > NEAR_A_SAMPLE {
            return Some(found);
        }
        let beside = [-BESIDE, BESIDE].into_iter().filter_map(|by| {
            let mut start = found.0.clone();
            start[last] = (delay + by).max(0.0) * per_sample;
            lowered(start)
        });
        let beside: Vec<_> = beside.collect();
        let all = beside.into_iter().chain([found]);
        all.min_by(|p, q| p.1.cost().total_cmp(&q.1.cost()))
    }

    /// Approximately the best transfer function of these orders.
    fn best(&self, orders: &Orders) -> Option<(DVector<f64>, Linearised)> {
        let starts: Vec<DVector<f64>> = match orders.delay {
            Some(delay) => self.start(orders, delay).into_iter().collect(),
            None => {
                let longest = self.longest();
                let delays = (0..DEAD_TIMES).map(|i| longest * i as f64 / DEAD_TIMES as f64);
                delays.filter_map(|it| self.start(orders, it)).collect()
            }
        };
        let with_cost = starts.into_iter().filter_map(|start| {
            let errors = self.errors(orders, &start)?;
            Some((errors.norm_squared(), start))
        });
        let mut starts: Vec<_> = with_cost.collect();
        starts.sort_by(|p, q| p.0.total_cmp(&q.0));
        (starts.into_iter().take(SEARCHES))
            .filter_map(|(_, start)| self.least(orders, start, (STEPS, SHARE)))
            .min_by(|p, q| p.1.cost().total_cmp(&q.1.cost()))
    }

    /// Sorts orders, the best first: the order with the fewest parameters whose criterion is not clearly above the smallest. In open loop an unstable
    /// system could not have been recorded.
    fn choose(&self, choices: &[Choice], may_be_unstable: bool) -> Vec<(Candidate, DVector<f64>)> {
        let tried = on_all_cores(choices, |(orders, near)| {
            let (theta, at) = match near {
                Some(theta) => self.least(orders, theta.clone(), (STEPS, SHARE))?,
                None => self.best(orders)?,
            };
            let values = theta.component_mul(&orders.scales(self.middle));
            let transfer = orders.transfer(&values).ok()?;
            let poles = transfer.transfer_function.poles().ok()?;
            if !may_be_unstable && poles.iter().any(|pole| pole.re > 0.0) {
                return None;
            }
            let count = 2.0 * self.told_apart;
            let candidate = Candidate {
                orders: *orders,
                delay: transfer.delay,
                cost: at.cost(),
                bic: count * libm::log(self.misfit(&transfer)?)
                    + orders.parameters() as f64 * libm::log(count),
            };
            Some((candidate, theta))
        });
        let mut tried: Vec<_> = tried.into_iter().flatten().collect();
        tried.sort_by(|p, q| p.0.bic.total_cmp(&q.0.bic));
        let near = tried.first().map_or(0.0, |it| it.0.bic + BEYOND_DOUBT);
        let doubted = tried.iter().enumerate().take_while(|it| it.1.0.bic <= near);
        let fewest = doubted.min_by_key(|it| it.1.0.orders.parameters());
        if let Some(at) = fewest.map(|it| it.0) {
            tried[..=at].rotate_right(1);
        }
        tried
    }

    /// V: the mean square of the errors over their random errors.
    fn misfit(&self, transfer: &DelayedLoop) -> Option<f64> {
        let held = HeldInputTransfer::new(transfer, self.sample_time).ok()?;
        let squares = self
            .points
            .iter()
            .zip(&self.precisions)
            .map(|(point, precision)| {
                let ratio = (point.2 / held.at(point.1)?).ln();
                Some(precision * ratio.norm_sqr())
            });
        let sum = squares.sum::<Option<f64>>()?;
        Some((sum / (2.0 * self.told_apart)).max(f64::MIN_POSITIVE))
    }
}

/// An order to try, with nearby parameters if they are known.
type Choice = (Orders, Option<DVector<f64>>);

impl FrequencyDomain {
    /// A search with the orders already found, for data that covers the band.
    #[must_use]
    pub fn of_found(&self, found: &Estimate) -> Self {
        let fit = found.frequency.as_ref();
        Self {
            orders: fit.map(|it| it.orders),
            covering: fit.map(|it| it.band),
            ..self.clone()
        }
    }

    /// The records as columns.
    fn spectra<'a>(&'a self, problem: &Problem<'a>) -> Result<Spectra<'a>> {
        let references = |run: usize, count: usize| -> Result<Vec<&'a [f64]>> {
            if self.references.is_empty() {
                return Ok(Vec::new());
            }
            let of = self.references.get(run).and_then(|it| it.get(..count));
            let of = of.ok_or_else(|| {
                IdentificationError::Record("every record needs a reference".to_owned())
            })?;
            Ok(vec![of])
        };
        let records = problem.runs.iter().enumerate().map(|(run, of)| {
            Ok(Columns {
                inputs: vec![of.inputs],
                output: of.outputs,
                references: references(run, of.outputs.len())?,
            })
        });
        let records = records.collect::<Result<Vec<_>>>()?;
        Spectra::new(records, problem.sample_time, &Settings::default())
    }
}

impl Estimator for FrequencyDomain {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        const NONE: IdentificationError = IdentificationError::Undetermined(
            "the frequency response does not determine a transfer function",
        );
        let choices = match self.orders {
            Some(orders) => vec![orders],
            None => self.given.choices(),
        };
        if choices.is_empty() {
            return Err(IdentificationError::Option(format!(
                "the frequency domain method needs transfer functions with more poles than zeros: {} must be at most {}",
                option("numerator"),
                option("order")
            )));
        }
        let spectra = self.spectra(problem)?;
        let coherence = self.coherence.unwrap_or(COHERENCE);
        let used = band(&spectra.points, coherence)?;
        let of_used = |(at, is_used): (usize, &bool)| is_used.then_some(at);
        let numbers: Vec<usize> = used.iter().enumerate().filter_map(of_used).collect();
        let omegas: Vec<f64> = numbers.iter().map(|at| spectra.points[*at].omega).collect();
        let edges = (omegas[0], omegas[omegas.len() - 1]);
        if let Some((low, high)) = self.covering {
            let shared = libm::log(high.min(edges.1) / low.max(edges.0));
            if shared < COVERED * libm::log(high / low) {
                return Err(IdentificationError::Undetermined(
                    "a part of the record does not excite the band",
                ));
            }
        }
        let mut fitted = Fitted::new(&spectra, &numbers, &omegas, problem.sample_time);
        let may_be_unstable = !self.references.is_empty() || self.orders.is_some();
        let choices: Vec<Choice> = choices.into_iter().map(|it| (it, None)).collect();
        let mut tried = fitted.choose(&choices, may_be_unstable);
        let mut noise: Option<Vec<f64>> = None;
        for round in 0..CORRECTIONS {
            let (candidate, theta) = tried.first().ok_or(NONE)?;
            let Some(left) = fitted.left(candidate, theta, problem)? else {
                let found = fitted.least(&candidate.orders, theta.clone(), FINE);
                tried[0].1 = found.ok_or(NONE)?.0;
                break;
            };
            fitted.correct(candidate, theta, &left).ok_or(NONE)?;
            noise = Some(spectrum(&left, &omegas, problem.sample_time));
            if round == 0 && choices.len() > 1 {
                let near = tried.iter().take(COMPARED);
                let near: Vec<Choice> = near
                    .map(|(candidate, theta)| (candidate.orders, Some(theta.clone())))
                    .collect();
                let again = fitted.choose(&near, may_be_unstable);
                tried = if again.is_empty() { tried } else { again };
            } else {
                let orders = candidate.orders;
                let found = fitted.least(&orders, theta.clone(), FINE);
                let (theta, at) = found.ok_or(NONE)?;
                tried[0].1 = theta;
                tried[0].0.cost = at.cost();
            }
        }
        let (candidate, theta) = tried.first().ok_or(NONE)?;
        let noise =
            noise.unwrap_or_else(|| numbers.iter().map(|at| spectra.points[*at].noise).collect());
        let orders = candidate.orders;
        let covariance = fitted.covariance(&orders, theta, &noise)?;
        let scales = orders.scales(fitted.middle);
        let values = theta.component_mul(&scales);
        let by = DMatrix::from_diagonal(&scales);
        let transfer = orders.transfer(&values)?;
        let fit = FrequencyFit {
            points: spectra.points.clone(),
            windows: spectra.windows.0.clone(),
            coherence,
            band: edges,
            used,
            by_reference: !self.references.is_empty(),
            orders,
            values,
            covariance: &by * &covariance * &by,
            cost: candidate.cost,
            candidates: tried.iter().map(|it| it.0).collect(),
            transfer,
        };
        sampled(problem, fitted.middle, theta, &covariance, fit)
    }

    fn learner(&self, _: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        Err(IdentificationError::Option(
            "the frequency domain method has no recursive form".to_owned(),
        ))
    }
}

impl Fitted<'_> {
    /// The simulation errors of each record with a stable model; `None` for an unstable one, whose simulation has no meaning.
    fn left(
        &self,
        candidate: &Candidate,
        theta: &DVector<f64>,
        problem: &Problem<'_>,
    ) -> Result<Option<Vec<Vec<f64>>>> {
        let orders = &candidate.orders;
        let values = theta.component_mul(&orders.scales(self.middle));
        let transfer = orders.transfer(&values)?;
        let poles = transfer.transfer_function.poles()?;
        if poles.iter().any(|pole| pole.re >= 0.0) {
            return Ok(None);
        }
        let sampled = Simulated::new(problem, orders, &transfer)?;
        Ok(Some(sampled.left))
    }

    /// Corrects the response for leakage of the windows.
    fn correct(
        &mut self,
        candidate: &Candidate,
        theta: &DVector<f64>,
        left: &[Vec<f64>],
    ) -> Option<()> {
        let orders = &candidate.orders;
        let values = theta.component_mul(&orders.scales(self.middle));
        let held =
            HeldInputTransfer::new(&orders.transfer(&values).ok()?, self.sample_time).ok()?;
        let numbers: Vec<usize> = self.points.iter().map(|it| it.0).collect();
        let of_left = on_all_cores(&numbers, |at| self.spectra.of_other(*at, left));
        for (point, response) in self.points.iter_mut().zip(of_left) {
            point.2 = held.at(point.1)? + response;
        }
        Some(())
    }

    /// The covariance of the search's parameters, for noise with this spectrum at each point.
    fn covariance(
        &self,
        orders: &Orders,
        theta: &DVector<f64>,
        noise: &[f64],
    ) -> Result<DMatrix<f64>> {
        let here = self.linearised(orders, theta);
        let factor = unit_factor(&here)?;
        // What each weighted error moves the parameters by.
        let by = &factor * factor.transpose() * here.slopes.transpose();
        let values = theta.component_mul(&orders.scales(self.middle));
        let held = HeldInputTransfer::new(&orders.transfer(&values)?, self.sample_time)?;
        let parts: Vec<usize> = (0..PARTS).collect();
        let count = theta.len();
        let sums = on_all_cores(&parts, |part| {
            let mut sums: Vec<Vec<Vec<f64>>> = Vec::new();
            for row in (*part..self.points.len()).step_by(PARTS) {
                let (at, omega, _, weight) = self.points[row];
                let kernel = self.spectra.kernel(at);
                if sums.is_empty() {
                    let none = kernel.iter().map(|it| vec![0.0; it.len()]).collect();
                    sums = vec![none; count];
                }
                let Some(model) = held.at(omega) else {
                    continue;
                };
                for (i, sum) in sums.iter_mut().enumerate() {
                    let factor = Complex::new(
                        by[(i, 2 * row)] * self.of_decibels(),
                        -by[(i, 2 * row + 1)] * self.of_phase(),
                    );
                    let factor = factor * weight * noise[row].max(0.0).sqrt() / model;
                    for (sum, kernel) in sum.iter_mut().zip(&kernel) {
                        for (sum, g) in sum.iter_mut().zip(kernel) {
                            *sum += factor.re * g.re - factor.im * g.im;
                        }
                    }
                }
            }
            sums
        });
        let mut sums = sums.into_iter().filter(|it| !it.is_empty());
        let mut all = sums.next().unwrap_or_default();
        for part in sums {
            for (all, part) in all.iter_mut().flatten().zip(part.iter().flatten()) {
                all.iter_mut().zip(part).for_each(|(sum, it)| *sum += it);
            }
        }
        let product = |i: usize, j: usize| -> f64 {
            let pairs = all[i].iter().flatten().zip(all[j].iter().flatten());
            pairs.map(|(p, q)| p * q).sum()
        };
        Ok(DMatrix::from_fn(count, count, product))
    }
}

/// The spectrum of errors at frequencies, rad/s, as the variance of white noise with that spectrum, from the autoregression that whitens
/// them.
fn spectrum(errors: &[Vec<f64>], omegas: &[f64], sample_time: f64) -> Vec<f64> {
    let d = whitening(errors.iter().map(Vec::as_slice));
    let white = errors.iter().flat_map(|it| whitened(&d, it));
    let (count, squares) = white.fold((0_usize, 0.0), |(n, sum), e| (n + 1, sum + e * e));
    let variance = squares / count.max(1) as f64;
    let at = |omega: &f64| {
        let back = polar(1.0, -omega * sample_time);
        let d = d
            .iter()
            .rev()
            .fold(Complex::new(0.0, 0.0), |sum, c| sum * back + c);
        variance / d.norm_sqr()
    };
    omegas.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::InitialState;
    use crate::structure::Structure;
    use planesman_record::filter;
    use planesman_record::{Run, with_noise};

    const DT: f64 = 0.02;
    const COUNT: usize = 3000;

    /// A chirp, 0.2 to 60 rad/s over 60 s, as AP's: its frequency rises by the same factor each second.
    fn chirp() -> Vec<f64> {
        let (low, high, end) = (0.2_f64, 60.0_f64, COUNT as f64 * DT);
        let rate = libm::log(high / low) / end;
        let phase = |t: f64| low / rate * (libm::exp(rate * t) - 1.0);
        (0..COUNT)
            .map(|k| libm::sin(phase(k as f64 * DT)))
            .collect()
    }

    /// `r/(s + p)` behind a dead time, for an input that is held: in closed form.
    fn lag(residue: f64, pole: f64, delay: f64, input: &[f64]) -> Vec<f64> {
        let whole = (delay / DT).floor();
        let left = DT - (delay - whole * DT);
        let [through, part] = [DT, left].map(|t| libm::exp(-pole * t));
        let at = |k: usize, back: usize| {
            let at = (k + 1).checked_sub(1 + whole as usize + back);
            at.map_or(0.0, |at| input[at])
        };
        let mut y = vec![0.0];
        for k in 0..input.len() - 1 {
            let driven = (1.0 - part) * at(k, 0) + (part - through) * at(k, 1);
            y.push(through * y[k] + residue / pole * driven);
        }
        y
    }

    /// `(4 s + 36) e^(-0.05 s) / ((s + 2)(s + 6)) = (7/(s + 2) - 3/(s + 6)) e^(-0.05 s)`, by b1, b0, a1, a0, theta.
    const TRUTH: [f64; 5] = [4.0, 36.0, 8.0, 12.0, 0.05];

    fn plant(input: &[f64]) -> Vec<f64> {
        let parts = [(7.0, 2.0), (-3.0, 6.0)].map(|(r, p)| lag(r, p, TRUTH[4], input));
        parts[0].iter().zip(&parts[1]).map(|(x, y)| x + y).collect()
    }

    fn fitted(estimator: &FrequencyDomain, input: &[f64], output: &[f64]) -> Result<Estimate> {
        let run = Run {
            inputs: input,
            outputs: output,
            ..Run::default()
        };
        let structure = Structure {
            start: InitialState::Estimated,
            ..Structure::of_order(1)
        };
        estimator.fit(&Problem::new(structure, DT, vec![run])?)
    }

    fn of_orders(poles: usize, zeros: usize) -> FrequencyDomain {
        FrequencyDomain {
            orders: Some(Orders {
                poles,
                zeros,
                integrators: 0,
                differentiators: 0,
                delay: None,
            }),
            ..FrequencyDomain::default()
        }
    }

    #[test]
    fn a_chirp_gives_response_orders_and_dead_time_of_the_plant() {
        let u = chirp();
        let y = with_noise(&plant(&u), 7, 0.05);
        let found = fitted(&FrequencyDomain::default(), &u, &y).unwrap();
        let fit = found.frequency.as_ref().unwrap();
        assert_eq!(
            (fit.orders.poles, fit.orders.zeros),
            (2, 1),
            "{:?}",
            fit.candidates
        );
        for ((name, value, deviation), truth) in fit.named().zip(TRUTH) {
            assert!(
                (value - truth).abs() < 4.0 * deviation,
                "{name} {value} {deviation}"
            );
            assert!(deviation < 0.1 * truth, "{name} {deviation}");
        }
        // The sampled plant in closed form, z-transforms of the two lags.
        let exact = |omega: f64| -> Complex<f64> {
            let z = |t: f64| (Complex::new(0.0, omega * t)).exp();
            let (whole, left) = (2.0, DT - (0.05 - 2.0 * DT));
            let lag = |r: f64, p: f64| {
                let [through, part] = [DT, left].map(|t| libm::exp(-p * t));
                let driven = (1.0 - part) + (part - through) * z(-DT);
                driven * z(-whole * DT) * (r / p) / (z(DT) - through)
            };
            lag(7.0, 2.0) + lag(-3.0, 6.0)
        };
        let used = fit.points.iter().zip(&fit.used).filter(|it| *it.1);
        let within = used.clone().filter(|(point, _)| {
            let off = (point.values[0] / exact(point.omega)).ln();
            off.re.abs() < point.sigmas_95() * point.phase_deviation(0)
        });
        let (within, used) = (within.count() as f64, used.count() as f64);
        assert!(within / used > 0.85, "{within} of {used}");
        // The difference equation is that of the transfer function.
        let reading = crate::Reading::new(&found, 0);
        for omega in [0.5, 5.0, 50.0] {
            let off = reading.response(omega).unwrap().value - fit.model_at(omega, DT).unwrap();
            assert!(off.modulus() < 1e-6, "{omega}");
        }
        assert!(
            found
                .simulated_fit(
                    0,
                    Run {
                        inputs: &u,
                        outputs: &y,
                        ..Run::default()
                    },
                    0
                )
                .unwrap()
                > 90.0
        );
    }

    #[test]
    fn standard_deviations_are_those_of_the_estimates() {
        let (u, estimator) = (chirp(), of_orders(2, 1));
        let clean = plant(&u);
        let seeds: Vec<u32> = (1..=16).collect();
        let squares = on_all_cores(&seeds, |seed| {
            // Noise with a memory of ten samples.
            let noise = with_noise(&vec![0.0; COUNT], *seed, 0.01);
            let noise = filter(&[1.0], &[1.0, -0.9], &noise);
            let y: Vec<f64> = clean.iter().zip(noise).map(|(y, v)| y + v).collect();
            let found = fitted(&estimator, &u, &y).unwrap().frequency.unwrap();
            let each = found.named().zip(TRUTH);
            each.map(|((_, value, deviation), truth)| ((value - truth) / deviation).powi(2))
                .collect::<Vec<f64>>()
        });
        let all: Vec<f64> = squares.concat();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        // Of 80 squares, of which those of a record hang together: 95 % of such means lie within 0.3 and 1.7.
        assert!((0.5..1.8).contains(&mean), "{mean}");
    }

    #[test]
    fn in_a_loop_the_reference_leaves_no_bias_and_the_direct_response_has_one() {
        // u = r - 2 y about 1/(s + 1), with noise of the output's size that goes round.
        const SEEDS: u32 = 10;
        let r = chirp();
        let through = libm::exp(-DT);
        let loops = (1..=SEEDS).map(|seed| {
            let white = with_noise(&vec![0.0; COUNT], seed, 0.06);
            let (mut x, mut u, mut y) = (0.0, Vec::new(), Vec::new());
            for (r, v) in r.iter().zip(filter(&[1.0], &[1.0, -0.95], &white)) {
                y.push(x + v);
                u.push(r - 2.0 * (x + v));
                x = through * x + (1.0 - through) * u[u.len() - 1];
            }
            (u, y)
        });
        let loops: Vec<_> = loops.collect();
        // The mean of a0 and its standard deviation.
        let pole = |references: Vec<Vec<f64>>| {
            let estimator = FrequencyDomain {
                references,
                coherence: Some(0.3),
                ..of_orders(1, 0)
            };
            let found = on_all_cores(&loops, |(u, y)| {
                let fit = fitted(&estimator, u, y).unwrap().frequency.unwrap();
                fit.values[1]
            });
            let count = f64::from(SEEDS);
            let mean = found.iter().sum::<f64>() / count;
            let squares: f64 = found.iter().map(|it| (it - mean).powi(2)).sum();
            (mean, (squares / (count - 1.0) / count).sqrt())
        };
        let (mean, deviation) = pole(vec![r.clone()]);
        assert!((mean - 1.0).abs() < 4.0 * deviation, "{mean} {deviation}");
        let (mean, deviation) = pole(Vec::new());
        assert!((mean - 1.0).abs() > 5.0 * deviation, "{mean} {deviation}");
    }

    #[test]
    fn noise_alone_has_no_band() {
        let y = with_noise(&vec![0.0; COUNT], 2, 1.0);
        let refusal = fitted(&FrequencyDomain::default(), &chirp(), &y).unwrap_err();
        assert!(refusal.to_string().contains("Next: excite"), "{refusal}");
    }
}
