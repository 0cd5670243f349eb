//! What every estimator makes of the five synthetic runs, over many noises.
//!
//! Each run of [`crate::synthetic`], 5 mV of noise and 25 mV of bias on its gyro, is identified anew with
//! each of many seeds. Two quantities are held against the truth: the dominant pole, which carries
//! most of the response (the estimate's pole nearest it), and the size of the frequency response at that
//! pole's frequency (the steady gain is 0: restoring moment). *Bias* is the mean of the estimates less the
//! truth, as a share of it; *coverage* how often the interval that the estimator claims holds the truth
//! with 95 % does. A fit that is refused holds nothing.

use std::fmt::Write as _;

use planesman_linear::{Complex, discrete_to_continuous, polynomial};

use crate::estimators::kalman::{self, Settings};
use crate::estimators::recursive::{Forgetting, Kind, Options, Recursion, learn};
use crate::estimators::vehicle::{self, Vehicle, VehicleEstimate};
use crate::estimators::{Estimate, Method};
use crate::structure::{Problem, Run, Structure};
use crate::synthetic::{self, BIAS, NOISE, SAMPLE_TIME};
use crate::uncertainty::{Reading, SIGMAS_95, Uncertain};

/// One way to identify, with the structure it is given.
#[derive(Clone, Debug)]
pub struct Contender {
    /// What the table calls it.
    pub name: &'static str,
    way: Way,
}

#[derive(Clone, Debug)]
enum Way {
    Recursive(Kind, Structure),
    Batch(Method, Structure),
    /// With all runs at the same speed as one.
    Pooled(Method, Structure),
    Vehicle {
        heave: bool,
    },
    Kalman {
        heave: bool,
        passes: usize,
    },
}

/// All ways, the thesis' first.
#[must_use]
pub fn contenders() -> Vec<Contender> {
    let order = Structure::of_order;
    let zero = || Structure::of_order(3).with_zero_at_one();
    let of = |name, way| Contender { name, way };
    vec![
        of(
            "recursive least squares, order 2 (the thesis)",
            Way::Recursive(Kind::LeastSquares, order(2).without_offset()),
        ),
        of(
            "recursive least squares, order 3 (the thesis)",
            Way::Recursive(Kind::LeastSquares, order(3).without_offset()),
        ),
        of(
            "recursive least squares, order 2, constant",
            Way::Recursive(Kind::LeastSquares, order(2)),
        ),
        of(
            "least squares, order 3, constant",
            Way::Batch(Method::LeastSquares, order(3)),
        ),
        of(
            "extended least squares, order 3, constant",
            Way::Recursive(Kind::ExtendedLeastSquares, order(3)),
        ),
        of(
            "recursive prediction error, order 3, constant",
            Way::Recursive(Kind::PredictionError, order(3)),
        ),
        of(
            "recursive output error, order 3, constant",
            Way::Recursive(Kind::OutputError, order(3)),
        ),
        of(
            "ARMAX, order 3, constant",
            Way::Batch(Method::Armax, order(3)),
        ),
        of(
            "ARMAX, order 3, zero at 1, constant",
            Way::Batch(Method::Armax, zero()),
        ),
        of(
            "output error, order 2, offset",
            Way::Batch(Method::OutputError, order(2)),
        ),
        of(
            "output error, order 3, offset",
            Way::Batch(Method::OutputError, order(3)),
        ),
        of(
            "output error, order 3, zero at 1, offset",
            Way::Batch(Method::OutputError, zero()),
        ),
        of(
            "instruments, order 3, zero at 1, offset",
            Way::Batch(Method::Instruments, zero()),
        ),
        of(
            "output error, order 3, zero at 1, runs of a speed pooled",
            Way::Pooled(Method::OutputError, zero()),
        ),
        of(
            "vehicle's equations, pitch alone",
            Way::Vehicle { heave: false },
        ),
        of(
            "vehicle's equations, heave known",
            Way::Vehicle { heave: true },
        ),
        of(
            "extended Kalman filter, heave known, one pass",
            Way::Kalman {
                heave: true,
                passes: 1,
            },
        ),
        of(
            "extended Kalman filter, heave known, four passes",
            Way::Kalman {
                heave: true,
                passes: 4,
            },
        ),
    ]
}

/// What the filter is told beforehand: the thesis' block estimates (Table 8: J 0.6, B 0.72, K 0.14 by
/// 1.25 V/V, M_theta 0.16) with room for all else, and the level of the noise.
fn settings() -> Settings {
    Settings {
        parameters: [1.25 * 0.14 / 0.6, 0.72 / 0.6, 0.16 / 0.6],
        deviations: [3.0, 3.0, 0.5],
        bias_deviation: 2.0 * BIAS,
        noise: NOISE,
        bias_drift: 0.0,
        drift: [0.0; vehicle::UNKNOWNS],
        disturbance: 0.0,
        motion: 0.0,
    }
}

/// Bias and coverage of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// `mean(estimate) / truth - 1`, %.
    pub bias: f64,
    /// The estimates' standard deviation, % of the truth.
    pub spread: f64,
    /// How often the 95 % interval held the truth, % of all seeds.
    pub coverage: f64,
}

impl Score {
    fn of(truth: f64, found: &[(f64, f64)], seeds: usize) -> Self {
        let n = found.len().max(1) as f64;
        let mean = found.iter().map(|(value, _)| value).sum::<f64>() / n;
        let variance = found
            .iter()
            .map(|(value, _)| (value - mean).powi(2))
            .sum::<f64>()
            / n;
        let held = found
            .iter()
            .filter(|(value, deviation)| (value - truth).abs() <= SIGMAS_95 * deviation)
            .count();
        Self {
            bias: 100.0 * (mean / truth - 1.0),
            spread: 100.0 * variance.sqrt() / truth.abs(),
            coverage: 100.0 * held as f64 / seeds.max(1) as f64,
        }
    }

    /// Under 2 % bias, 90 to 98 % coverage.
    #[must_use]
    pub fn is_trustworthy(&self) -> bool {
        self.bias.abs() < 2.0 && (90.0..=98.0).contains(&self.coverage)
    }
}

/// What one contender came to on one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Of the dominant pole's real part.
    pub pole: Score,
    /// Of the response's size at the pole's frequency.
    pub gain: Score,
    /// Fits refused.
    pub refused: usize,
}

/// The whole table.
#[derive(Clone, Debug)]
pub struct Table {
    /// Noises per run.
    pub seeds: usize,
    /// Names, and one cell per run.
    pub rows: Vec<(&'static str, Vec<Cell>)>,
}

/// The seed of the i-th noise.
#[must_use]
pub fn seed(i: usize) -> u32 {
    (i as u32).wrapping_mul(2_654_435_761).wrapping_add(12345)
}

/// Every contender on every run with `seeds` noises, the runs side by side.
#[must_use]
pub fn table(contenders: &[Contender], seeds: usize) -> Table {
    let columns: Vec<Vec<Cell>> = std::thread::scope(|scope| {
        let threads: Vec<_> = synthetic::Run::ALL
            .map(|run| {
                scope.spawn(move || {
                    contenders
                        .iter()
                        .map(|it| it.on(run, seeds))
                        .collect::<Vec<_>>()
                })
            })
            .into_iter()
            .collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_default())
            .collect()
    });
    let rows = contenders
        .iter()
        .enumerate()
        .map(|(i, it)| {
            (
                it.name,
                columns
                    .iter()
                    .filter_map(|column| column.get(i).copied())
                    .collect(),
            )
        })
        .collect();
    Table { seeds, rows }
}

/// The dominant pole, 1/s, and the response's size at its frequency, V/V.
#[must_use]
pub fn truth(run: synthetic::Run) -> (f64, f64) {
    let (vehicle, unknowns) = run.vehicle();
    let pole = polynomial::roots(&vehicle.characteristic(unknowns))
        .unwrap_or_default()
        .iter()
        .map(|s| s.re)
        .fold(0.0, f64::min);
    let plant = run.plant();
    let back = Complex::new(0.0, pole * SAMPLE_TIME).exp();
    let sum = |coefficients: &[f64]| {
        coefficients
            .iter()
            .rev()
            .fold(Complex::new(0.0, 0.0), |sum, c| (sum + c) * back)
    };
    (pole, (sum(&plant.b) / (1.0 + sum(&plant.a))).norm())
}

impl Contender {
    /// On one run with `seeds` noises.
    #[must_use]
    pub fn on(&self, run: synthetic::Run, seeds: usize) -> Cell {
        let (pole, gain) = truth(run);
        let found: Vec<(Uncertain, Uncertain)> = (0..seeds)
            .filter_map(|i| self.identify(run, seed(i), pole))
            .collect();
        let poles: Vec<(f64, f64)> = found
            .iter()
            .map(|(pole, _)| (pole.value.re, pole.real_deviation()))
            .collect();
        let gains: Vec<(f64, f64)> = found
            .iter()
            .map(|(_, gain)| (gain.value.norm(), gain.magnitude_deviation()))
            .collect();
        Cell {
            pole: Score::of(pole, &poles, seeds),
            gain: Score::of(gain, &gains, seeds),
            refused: seeds - found.len(),
        }
    }

    /// The pole nearest `pole` and the response at its frequency; `None` when the fit is refused.
    fn identify(
        &self,
        run: synthetic::Run,
        seed: u32,
        pole: f64,
    ) -> Option<(Uncertain, Uncertain)> {
        let (inputs, outputs) = (run.planes(), run.measured(seed, NOISE, BIAS));
        let record = Run {
            inputs: &inputs,
            outputs: &outputs,
        };
        let known = |heave: bool| {
            if heave {
                run.vehicle().0
            } else {
                Vehicle::default()
            }
        };
        match &self.way {
            Way::Recursive(kind, structure) => {
                let options = Options {
                    forgetting: Forgetting::Constant(1.0),
                    initial_covariance: 1e6,
                    ..Options::default()
                };
                let mut learner =
                    Recursion::new(*kind, structure.clone(), SAMPLE_TIME, options).ok()?;
                learn(&mut learner, record);
                read(&learner.estimate()?, pole)
            }
            Way::Batch(method, structure) => {
                let problem = Problem::new(structure.clone(), SAMPLE_TIME, vec![record]).ok()?;
                read(&method.fit(&problem).ok()?, pole)
            }
            Way::Pooled(method, structure) => {
                let others: Vec<(Vec<f64>, Vec<f64>)> = synthetic::Run::ALL
                    .into_iter()
                    .filter(|other| *other != run && other.speed() == run.speed())
                    .map(|other| (other.planes(), other.measured(!seed, NOISE, BIAS)))
                    .collect();
                let mut runs = vec![record];
                runs.extend(
                    others
                        .iter()
                        .map(|(inputs, outputs)| Run { inputs, outputs }),
                );
                let problem = Problem::new(structure.clone(), SAMPLE_TIME, runs).ok()?;
                read(&method.fit(&problem).ok()?, pole)
            }
            Way::Vehicle { heave } => {
                let found = vehicle::fit(known(*heave), SAMPLE_TIME, &[record]).ok()?;
                read_vehicle(&found, pole)
            }
            Way::Kalman { heave, passes } => {
                let found =
                    kalman::fit(known(*heave), SAMPLE_TIME, settings(), record, *passes).ok()?;
                read_vehicle(&found, pole)
            }
        }
    }
}

/// The one nearest `pole`.
fn nearest(poles: Vec<Uncertain>, pole: f64) -> Option<Uncertain> {
    let distance = |it: &Uncertain| (it.value - Complex::new(pole, 0.0)).norm();
    poles
        .into_iter()
        .min_by(|p, q| distance(p).total_cmp(&distance(q)))
}

fn read(estimate: &Estimate, pole: f64) -> Option<(Uncertain, Uncertain)> {
    let reading = Reading::of(estimate, 0);
    Some((
        nearest(reading.continuous_poles().ok()?, pole)?,
        reading.response(-pole)?,
    ))
}

/// The same of a vehicle.
fn read_vehicle(found: &VehicleEstimate, pole: f64) -> Option<(Uncertain, Uncertain)> {
    let response = found.sampled_response(SAMPLE_TIME, -pole)?;
    Some((nearest(found.poles().ok()?, pole)?, response))
}

impl Table {
    /// The contenders whose dominant pole is trustworthy on every run.
    #[must_use]
    pub fn trustworthy(&self) -> Vec<&'static str> {
        self.rows
            .iter()
            .filter(|(_, cells)| cells.iter().all(|cell| cell.pole.is_trustworthy()))
            .map(|(name, _)| *name)
            .collect()
    }

    /// The table in Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "{} noises per run: bias ± spread in % of the truth, then coverage of the 95 % interval in %.\n",
            self.seeds
        );
        type Part = fn(&Cell) -> Score;
        let quantities: [(&str, Part); 2] = [
            ("Dominant pole, 1/s", |cell| cell.pole),
            ("Response at its frequency, V/V", |cell| cell.gain),
        ];
        for (i, (quantity, part)) in quantities.into_iter().enumerate() {
            let _ = write!(text, "\n| {quantity} |");
            for run in synthetic::Run::ALL {
                let (pole, gain) = truth(run);
                let _ = write!(text, " {} ({:.4}) |", run.name(), [pole, gain][i]);
            }
            let _ = writeln!(text, "\n|---|{}", "---|".repeat(synthetic::Run::ALL.len()));
            for (name, cells) in &self.rows {
                let _ = write!(text, "| {name} |");
                for cell in cells {
                    let score = part(cell);
                    let refused = match cell.refused {
                        0 => String::new(),
                        n => format!(" ({n} refused)"),
                    };
                    let _ = write!(
                        text,
                        " {:+.1} ± {:.1}, {:.0}{refused} |",
                        score.bias, score.spread, score.coverage
                    );
                }
                text.push('\n');
            }
        }
        text
    }
}

/// What least squares makes of noise and of bias: the thesis' two failures, as means over the noises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failures {
    /// The second root of order 2 with noise alone: a smoother's, where the plant has 0.95 or more.
    pub smoothing_root: f64,
    /// The first root of order 2 with bias and noise.
    pub biased_root: f64,
    /// The steady gain with bias and noise (median), V/V; the plant's is 0.
    pub biased_gain: f64,
}

/// The failures on a run, over `seeds` noises.
#[must_use]
pub fn failures(run: synthetic::Run, seeds: usize) -> Failures {
    let inputs = run.planes();
    let fit = |seed: u32, bias: f64| {
        let outputs = run.measured(seed, NOISE, bias);
        let record = Run {
            inputs: &inputs,
            outputs: &outputs,
        };
        let structure = Structure::of_order(2).without_offset();
        let problem = Problem::new(structure, SAMPLE_TIME, vec![record]).ok()?;
        let model = Method::LeastSquares.fit(&problem).ok()?.model(0);
        let mut roots: Vec<f64> = model.poles().ok()?.iter().map(|z| z.re).collect();
        roots.sort_by(f64::total_cmp);
        Some((*roots.first()?, *roots.last()?, model.dc_gain()?))
    };
    let all = |bias: f64| -> Vec<(f64, f64, f64)> {
        (0..seeds).filter_map(|i| fit(seed(i), bias)).collect()
    };
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let biased = all(BIAS);
    let mut gains: Vec<f64> = biased.iter().map(|it| it.2).collect();
    gains.sort_by(f64::total_cmp);
    Failures {
        smoothing_root: mean(all(0.0).iter().map(|it| it.0).collect()),
        biased_root: mean(biased.iter().map(|it| it.1).collect()),
        biased_gain: gains.get(gains.len() / 2).copied().unwrap_or(0.0),
    }
}

/// The failures on every run, in Markdown.
#[must_use]
pub fn failures_markdown(seeds: usize) -> String {
    let mut text = String::from(
        "| Plain least squares, order 2 | second root, noise alone | first root, noise and bias | steady gain, noise and bias |\n|---|---|---|---|\n",
    );
    for run in synthetic::Run::ALL {
        let found = failures(run, seeds);
        let slow = discrete_to_continuous(Complex::new(found.biased_root, 0.0), SAMPLE_TIME)
            .map_or(f64::NAN, |s| s.re);
        let _ = writeln!(
            text,
            "| {} | {:.3} | {:.4} ({slow:.2} 1/s) | {:.2} |",
            run.name(),
            found.smoothing_root,
            found.biased_root,
            found.biased_gain
        );
    }
    text
}
