//! Bias and coverage of every estimator on the five synthetic runs, over many noises.
//!
//! Each run of [`super::synthetic`], 5 mV of noise and 25 mV of bias on its gyro, is identified anew with
//! each of many seeds. Two quantities are held against the truth: the dominant pole, which carries
//! most of the response (the estimate's pole nearest it), and the size of the frequency response at that
//! pole's frequency (the steady-state gain is 0: restoring moment). *Bias* is the mean of the estimates less the
//! truth, as a share of it; *coverage* how often the interval that the estimator claims holds the truth
//! with 95 % does. A fit that is refused holds nothing.

use std::fmt::Write as _;

use planesman_identification::estimators::recursive::{Kind, Options};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_identification::estimators::{
    Armax, Estimate, Estimator, Guess, LeastSquares, OutputError, Recursively, VehicleFilter,
    VehicleSearch,
};
use planesman_identification::{
    Problem, Reading, Run, SIGMAS_95, Structure, Uncertain, noise, on_all_cores,
};
use planesman_linear::{Complex, ComplexFunctions as _, discrete_to_continuous, polynomial};

use super::synthetic::{self, BIAS, NOISE, SAMPLE_TIME};

/// One way to identify, with the structure it is given.
pub struct Contender {
    /// Its name in the table.
    pub name: &'static str,
    structure: Structure,
    /// Which records it is given.
    records: Records,
    /// The estimator, with what it knows of the run's vehicle; of the i-th noise.
    estimator: Choice,
}

/// The records of one fit.
#[derive(Clone, Copy, Debug)]
enum Records {
    /// One run.
    One,
    /// That run and the others at its speed.
    OfSpeed,
    /// That run so many times, each with a noise of its own.
    Repeated(u32),
}

/// All ways, the thesis' first.
#[must_use]
pub fn contenders() -> Vec<Contender> {
    let order = Structure::of_order;
    let zero = || Structure::of_order(3).with_zero_at_one();
    let of = |name, structure, records, estimator| Contender {
        name,
        structure,
        records,
        estimator,
    };
    let recursive = |name, kind, structure| {
        of(
            name,
            structure,
            Records::One,
            always(Recursively {
                kind,
                options: recursion(),
            }),
        )
    };
    let pitch_alone = || VehicleSearch::default();
    let search = |run: synthetic::Run, _| VehicleSearch {
        vehicle: run.vehicle().0,
    };
    vec![
        recursive(
            "recursive least squares, order 2 (the thesis)",
            Kind::LeastSquares,
            order(2).without_offset(),
        ),
        recursive(
            "recursive least squares, order 3 (the thesis)",
            Kind::LeastSquares,
            order(3).without_offset(),
        ),
        recursive(
            "recursive least squares, order 2, constant",
            Kind::LeastSquares,
            order(2),
        ),
        of(
            "least squares, order 3, constant",
            order(3),
            Records::One,
            always(LeastSquares),
        ),
        recursive(
            "extended least squares, order 3, constant",
            Kind::ExtendedLeastSquares,
            order(3),
        ),
        recursive(
            "recursive prediction error, order 3, constant",
            Kind::PredictionError,
            order(3),
        ),
        recursive(
            "recursive output error, order 3, constant",
            Kind::OutputError,
            order(3),
        ),
        of(
            "ARMAX, order 3, constant",
            order(3),
            Records::One,
            always(Armax),
        ),
        of(
            "ARMAX, order 3, zero at 1, constant",
            zero(),
            Records::One,
            always(Armax),
        ),
        of(
            "output error, order 2, offset",
            order(2),
            Records::One,
            always(OutputError),
        ),
        of(
            "output error, order 3, offset",
            order(3),
            Records::One,
            always(OutputError),
        ),
        of(
            "output error, order 3, zero at 1, offset",
            zero(),
            Records::One,
            always(OutputError),
        ),
        of(
            "output error, order 3, zero at 1, runs of a speed pooled",
            zero(),
            Records::OfSpeed,
            always(OutputError),
        ),
        of(
            "output error, order 3, zero at 1, each run flown ten times",
            zero(),
            Records::Repeated(10),
            always(OutputError),
        ),
        of(
            "vehicle's equations, pitch alone",
            order(2),
            Records::One,
            always(pitch_alone()),
        ),
        of(
            "vehicle's equations, heave known",
            order(3),
            Records::One,
            of_run(search),
        ),
        of(
            "vehicle's equations, heave 20 % off, taken for known",
            order(3),
            Records::One,
            of_run(|run, seed| VehicleSearch {
                vehicle: doubtful(run, seed, 0.0),
            }),
        ),
        of(
            "vehicle's equations, heave 20 % off, known to 20 %",
            order(3),
            Records::One,
            of_run(|run, seed| VehicleSearch {
                vehicle: doubtful(run, seed, HEAVE_DOUBT),
            }),
        ),
        of(
            "extended Kalman filter, heave known, one pass",
            order(3),
            Records::One,
            of_run(|run, _| filter(run.vehicle().0, 1)),
        ),
        of(
            "extended Kalman filter, heave known, four passes",
            order(3),
            Records::One,
            of_run(|run, _| filter(run.vehicle().0, 4)),
        ),
        of(
            "extended Kalman filter, heave 20 % off, known to 20 %, four passes",
            order(3),
            Records::One,
            of_run(|run, seed| filter(doubtful(run, seed, HEAVE_DOUBT), 4)),
        ),
    ]
}

type Choice = Box<dyn Fn(synthetic::Run, u32) -> Box<dyn Estimator> + Sync>;

/// The same whatever the run.
fn always(estimator: impl Estimator + Copy + 'static) -> Choice {
    of_run(move |_, _| estimator)
}

fn of_run<E: Estimator + 'static>(
    choose: impl Fn(synthetic::Run, u32) -> E + Sync + 'static,
) -> Choice {
    Box::new(move |run, seed| Box::new(choose(run, seed)))
}

/// Nothing forgotten, and a prior covariance such as the thesis' kind of program has.
fn recursion() -> Options {
    Options {
        initial_covariance: 1e6,
        ..Options::default()
    }
}

/// The uncertainty of heave, as a standard deviation of each coefficient.
const HEAVE_DOUBT: f64 = 0.2;

/// The run's vehicle, each coefficient of its heave off by a draw of [`HEAVE_DOUBT`], and as sure of
/// them as is said.
fn doubtful(run: synthetic::Run, seed: u32, doubt: f64) -> Vehicle {
    let draw = noise(!seed, 4);
    let heave = run.vehicle().0.heave;
    Vehicle {
        heave: heave.map(|heave| Heave {
            doubt,
            ..heave.changed([0, 1, 2, 3].map(|i| HEAVE_DOUBT * draw[i]))
        }),
    }
}

/// A filter that knows beforehand the thesis' block estimates (Table 8: J 0.6, B 0.72, K 0.14 by
/// 1.25 V/V, M_theta 0.16) with room for all else, and the level of the noise.
fn filter(vehicle: Vehicle, passes: usize) -> VehicleFilter {
    VehicleFilter {
        guess: Some(Guess {
            parameters: [1.25 * 0.14 / 0.6, 0.72 / 0.6, 0.16 / 0.6],
            deviations: [3.0, 3.0, 0.5],
            bias_deviation: 2.0 * BIAS,
        }),
        noise: Some(NOISE),
        passes,
        ..VehicleFilter::new(vehicle)
    }
}

/// Bias and coverage of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// `mean(estimate) / truth - 1`, %.
    pub bias: f64,
    /// The estimates' standard deviation, % of the truth.
    pub spread: f64,
    /// The coverage of the 95 % interval, % of all seeds.
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

/// The scores of one contender on one run.
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

/// Every contender on every run with `seeds` noises, the runs side by side; `done` is called after each of them.
#[must_use]
pub fn table(contenders: &[Contender], seeds: usize, done: &(dyn Fn() + Sync)) -> Table {
    let columns: Vec<Vec<Cell>> = on_all_cores(&synthetic::Run::ALL, |run| {
        let cells = contenders.iter().map(|it| it.on(*run, seeds));
        cells.inspect(|_| done()).collect()
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
    let plant = run.plant();
    let den: Vec<f64> = std::iter::once(1.0)
        .chain(plant.a.iter().copied())
        .collect();
    let pole = polynomial::roots(&den)
        .unwrap_or_default()
        .iter()
        .filter_map(|z| discrete_to_continuous(*z, SAMPLE_TIME))
        .map(|s| s.re)
        .fold(0.0, f64::min);
    let back = (Complex::new(0.0, pole * SAMPLE_TIME)).exp();
    let sum = |coefficients: &[f64]| {
        coefficients
            .iter()
            .rev()
            .fold(Complex::new(0.0, 0.0), |sum, c| (sum + c) * back)
    };
    (pole, (sum(&plant.b) / (1.0 + sum(&plant.a))).modulus())
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
            .map(|(_, gain)| (gain.value.modulus(), gain.magnitude_deviation()))
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
        let noises = |run: synthetic::Run, count: u32| {
            (0..count).map(move |i| {
                let seed = seed.wrapping_add(i.wrapping_mul(0x9E37_79B9));
                (run.planes(), run.measured(seed, NOISE, BIAS))
            })
        };
        let mut records: Vec<(Vec<f64>, Vec<f64>)> = noises(run, 1).collect();
        match self.records {
            Records::One => {}
            Records::OfSpeed => {
                let others = synthetic::Run::ALL.into_iter();
                let others = others.filter(|it| *it != run && it.speed() == run.speed());
                records.extend(others.flat_map(|other| noises(other, 2).skip(1)));
            }
            Records::Repeated(times) => records.extend(noises(run, times).skip(1)),
        }
        let runs = records.iter().map(|(inputs, outputs)| Run {
            inputs,
            outputs,
            ..Run::default()
        });
        let problem = Problem::new(self.structure.clone(), SAMPLE_TIME, runs.collect()).ok()?;
        let estimator = (self.estimator)(run, seed);
        read(&estimator.fit(&problem).ok()?, pole)
    }
}

/// The one nearest `pole`.
fn nearest(poles: Vec<Uncertain>, pole: f64) -> Option<Uncertain> {
    let distance = |it: &Uncertain| (it.value - Complex::new(pole, 0.0)).modulus();
    poles
        .into_iter()
        .min_by(|p, q| distance(p).total_cmp(&distance(q)))
}

fn read(estimate: &Estimate, pole: f64) -> Option<(Uncertain, Uncertain)> {
    let reading = Reading::new(estimate, 0);
    Some((
        nearest(reading.continuous_poles().ok()?, pole)?,
        reading.response(-pole)?,
    ))
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

/// Least squares under noise and under bias: the thesis' two failures, as means over the noises.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failures {
    /// The second root of order 2 with noise alone: a smoother's, where the plant has 0.95 or more.
    pub smoothing_root: f64,
    /// The first root of order 2 with bias and noise.
    pub biased_root: f64,
    /// The steady-state gain with bias and noise (median), V/V; the plant's is 0.
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
            ..Run::default()
        };
        let structure = Structure::of_order(2).without_offset();
        let problem = Problem::new(structure, SAMPLE_TIME, vec![record]).ok()?;
        let model = LeastSquares.fit(&problem).ok()?.model(0);
        let mut roots: Vec<f64> = model.poles().ok()?.iter().map(|z| z.re).collect();
        roots.sort_by(f64::total_cmp);
        Some((*roots.first()?, *roots.last()?, model.steady_state_gain()?))
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
        "| Plain least squares, order 2 | second root, noise alone | first root, noise and bias | steady-state gain, noise and bias |\n|---|---|---|---|\n",
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
