//! From a record to a model with its account: fitted, searched, tested, and judged in plain words.
//!
//! Each stretch of the record is a run of one model. The order is searched unless it is given; the model
//! is fitted to the first seven tenths of each stretch and judged on the rest, by simulation;
//! and fitted to all of it for what is reported.

use std::fmt::Write as _;

use planesman_model_file::{Continuous, Format, ModelFile, Place};

use crate::conversion;
use crate::estimators::recursive::{Kind, Options as Recursive, Recursion, Recursive as _};
use crate::estimators::{Estimate, Method};
use crate::model::Model;
use crate::record::Record;
use crate::structure::{Problem, Run, Start, Structure};
use crate::uncertainty::{Reading, SIGMAS_95, Uncertain};
use crate::validation::order_search::{Candidate, choice, first_part, search, verdict};
use crate::validation::{identifiability, residuals::ResidualTests};

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How to estimate.
    pub method: Method,
    /// The order, known poles not counted; `None` to search.
    pub order: Option<usize>,
    /// Samples from input to first effect; `None` to search.
    pub delay: Option<usize>,
    /// Zeros known to be at z = 1.
    pub zeros_at_one: usize,
    /// Poles known to be at z = 1.
    pub integrators: usize,
    /// Seek an offset of the output.
    pub offset: bool,
    /// How each stretch begins.
    pub start: Start,
}

impl Default for Options {
    /// Output error, everything searched.
    fn default() -> Self {
        Self {
            method: Method::OutputError,
            order: None,
            delay: None,
            zeros_at_one: 0,
            integrators: 0,
            offset: true,
            start: Start::Motion,
        }
    }
}

/// How many standard deviations of the noise the held-out output must vary by to say something.
const MOVES_BEYOND_NOISE: f64 = 2.0;

/// Orders and delays searched.
const ORDERS: usize = 4;
const DELAYS: usize = 3;

/// Parameters by time, for a plot of how they were learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// `a1`, `b1` and so on.
    pub names: Vec<String>,
    /// Seconds, and the parameters then.
    pub points: Vec<(f64, Vec<f64>)>,
}

/// A model and what there is to know of it.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The input's name.
    pub input: String,
    /// The output's name.
    pub output: String,
    /// The model.
    pub estimate: Estimate,
    /// What was tried; empty when order and delay were given.
    pub candidates: Vec<Candidate>,
    /// The simulated fit on the longest stretch, %.
    pub fit: Option<f64>,
    /// The simulated fit on what was held out of the longest stretch, %.
    pub held_out_fit: Option<f64>,
    /// Of the longest stretch.
    pub residuals: Option<ResidualTests>,
    /// The longest stretch's number.
    pub longest: usize,
    /// The verdict, a sentence each.
    pub verdict: Vec<String>,
    /// How a recursion of the same structure learnt.
    pub trajectory: Trajectory,
}

/// The model between the first input and the first output of a record.
///
/// # Errors
/// A sentence: a record without input or output, or one that determines no model asked for.
pub fn analyse(record: &Record, options: &Options) -> Result<Analysis, String> {
    let runs: Vec<Run<'_>> = record
        .stretches
        .iter()
        .filter_map(|stretch| {
            Some(Run {
                inputs: stretch.inputs.first()?,
                outputs: stretch.outputs.first()?,
            })
        })
        .collect();
    let name = |channels: &[crate::record::Channel]| {
        channels
            .first()
            .map(|channel| channel.name.clone())
            .unwrap_or_default()
    };
    let problem = Problem::new(
        structure(options, options.order.unwrap_or(2)),
        record.sample_time,
        runs,
    )?;
    let candidates = match (options.order, options.delay) {
        (Some(_), Some(_)) => Vec::new(),
        (order, delay) => {
            let mut found = search(
                &problem,
                options.method,
                order.unwrap_or(ORDERS),
                delay.unwrap_or(DELAYS),
            );
            found.retain(|c| {
                order.is_none_or(|n| c.order == n) && delay.is_none_or(|d| c.delay == d)
            });
            found
        }
    };
    let mut problem = problem;
    if let Some(chosen) = choice(&candidates) {
        problem.structure = Structure {
            delay: chosen.delay,
            ..structure(options, chosen.order)
        };
    }
    let estimate = options.method.fit(&problem)?;
    let longest = (0..problem.runs.len())
        .max_by_key(|r| problem.runs[*r].outputs.len())
        .unwrap_or_default();
    let run = problem.runs[longest];
    let part = Problem {
        runs: problem.runs.iter().map(first_part).collect(),
        ..problem.clone()
    };
    let held_out = part.runs[longest].outputs.len();
    // What hardly moves beyond the noise can be simulated neither well nor badly.
    let moves = run.outputs.get(held_out..).is_some_and(|outputs| {
        deviation(outputs) > MOVES_BEYOND_NOISE * estimate.noise_variance.sqrt()
    });
    let held_out_fit = options
        .method
        .fit(&part)
        .ok()
        .filter(|_| moves)
        .and_then(|part_estimate| part_estimate.simulated_fit(longest, run, held_out));
    let residuals = estimate
        .residuals
        .get(longest)
        .and_then(|residuals| ResidualTests::of(residuals, run.inputs));
    let mut found = Analysis {
        input: name(&record.inputs),
        output: name(&record.outputs),
        fit: estimate.simulated_fit(longest, run, 0),
        held_out_fit,
        residuals,
        longest,
        verdict: Vec::new(),
        trajectory: trajectory(&problem, options.method),
        candidates,
        estimate,
    };
    found.verdict = found.judged(identifiability::doubts(&problem));
    Ok(found)
}

/// The standard deviation about the mean; 0 of nothing.
fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2));
    (squares.sum::<f64>() / count).sqrt()
}

fn structure(options: &Options, order: usize) -> Structure {
    let mut structure = Structure {
        offset: options.offset,
        start: options.start,
        delay: options.delay.unwrap_or(1),
        ..Structure::of_order(order)
    };
    for _ in 0..options.zeros_at_one {
        structure = structure.with_zero_at_one();
    }
    for _ in 0..options.integrators {
        structure = structure.with_integrator();
        structure.poles += 1;
    }
    structure
}

/// How many points of a trajectory are kept.
const POINTS: usize = 400;

fn trajectory(problem: &Problem<'_>, method: Method) -> Trajectory {
    let kind = match method {
        Method::LeastSquares => Kind::LeastSquares,
        Method::Armax => Kind::PredictionError,
        Method::OutputError | Method::Instruments => Kind::OutputError,
    };
    let names = (1..=problem.structure.poles)
        .map(|i| format!("a{i}"))
        .chain((1..=problem.structure.numerator).map(|j| format!("b{j}")))
        .collect::<Vec<_>>();
    let structure = Structure {
        own_numerators: false,
        ..problem.structure.clone()
    };
    let mut points = Vec::new();
    if let Ok(mut learner) =
        Recursion::new(kind, structure, problem.sample_time, Recursive::default())
    {
        let total: usize = problem.runs.iter().map(|run| run.outputs.len()).sum();
        let stride = total.div_ceil(POINTS).max(1);
        let mut sample = 0;
        for run in &problem.runs {
            for (k, output) in run.outputs.iter().enumerate() {
                match k {
                    0 => learner.begin(*output),
                    k => learner.push(run.inputs[k - 1], *output),
                }
                if sample % stride == 0 {
                    let theta = learner.parameters();
                    let shown = theta.iter().take(names.len()).copied().collect();
                    points.push((sample as f64 * problem.sample_time, shown));
                }
                sample += 1;
            }
        }
    }
    Trajectory { names, points }
}

impl Analysis {
    /// The model of the longest stretch.
    #[must_use]
    pub fn model(&self) -> Model {
        self.estimate.model(self.longest)
    }

    /// What can be read from it.
    #[must_use]
    pub fn reading(&self) -> Reading<'_> {
        Reading::of(&self.estimate, self.longest)
    }

    fn judged(&self, doubts: Vec<String>) -> Vec<String> {
        let mut said = doubts;
        said.extend(verdict(&self.candidates));
        match (self.held_out_fit, self.fit) {
            (Some(held), _) if held >= 90.0 => said.push(format!("it simulates {held:.1} % of what it was not fitted to: very good")),
            (Some(held), Some(fit)) if held < fit - 20.0 => said.push(format!(
                "it simulates {held:.1} % of what it was not fitted to, and {fit:.1} % of everything: it has learnt this record rather than the system, or the system changed"
            )),
            (Some(held), _) => said.push(format!("it simulates {held:.1} % of what it was not fitted to")),
            (None, _) => said.push("the output does not move beyond the noise in what was held out: nothing was checked".to_owned()),
        }
        if let Some(tests) = &self.residuals {
            said.push(match (tests.of_earlier_inputs().passes(), tests.whiteness.passes()) {
                (true, true) => "what it leaves over is white and unrelated to the input: nothing is left to explain".to_owned(),
                (true, false) => "what it leaves over is unrelated to the input but coloured: the model stands, its standard errors are too small or too large".to_owned(),
                (false, _) => format!(
                    "what it leaves over still follows earlier inputs ({} of {} lags beyond 99 %): dynamics are missing, a higher order or another delay may find them",
                    tests.of_earlier_inputs().outside(), tests.of_earlier_inputs().values.len()
                ),
            });
            if !tests.of_later_inputs().passes() {
                said.push("later inputs follow what it leaves over: there is feedback; use armax, or two stages with the loop's reference".to_owned());
            }
        }
        said.extend(self.suspicious_poles());
        said
    }

    /// Poles that are noise's rather than the system's.
    fn suspicious_poles(&self) -> Vec<String> {
        let reading = self.reading();
        let (Ok(poles), Ok(zeros)) = (reading.poles(), reading.zeros()) else {
            return Vec::new();
        };
        let mut said = Vec::new();
        for pole in poles.iter().filter(|pole| pole.value.im >= 0.0) {
            let at = complex(pole);
            if pole.value.re < 0.0 && pole.covariance != nalgebra::Matrix2::zeros() {
                said.push(format!("the pole at z = {at} alternates from sample to sample: it is what noise makes of a fit, not the system's"));
            } else if pole.value.norm() - SIGMAS_95 * pole.magnitude_deviation() > 1.0 {
                said.push(format!(
                    "the pole at z = {at} is unstable beyond its uncertainty"
                ));
            }
            let cancels = zeros.iter().any(|zero| {
                let apart = (zero.value - pole.value).norm();
                let joint = zero.magnitude_deviation().hypot(pole.magnitude_deviation());
                joint > 0.0 && apart < SIGMAS_95 * joint && apart < 0.2
            });
            if cancels {
                said.push(format!(
                    "a zero may cancel the pole at z = {at}: a lower order would do as well"
                ));
            }
        }
        said
    }

    /// The model file: what other programs load.
    ///
    /// # Errors
    /// A sentence, when poles or zeros cannot be found.
    pub fn file(&self) -> Result<ModelFile, String> {
        let model = self.model();
        let reading = self.reading();
        let places = |found: Vec<Uncertain>| -> Vec<Place> { found.iter().map(place).collect() };
        let continuous = conversion::continuous(&model).ok();
        let covariance = self.estimate.coefficient_covariance(self.longest);
        Ok(ModelFile {
            format: Format::One,
            input: self.input.clone(),
            output: self.output.clone(),
            method: self.estimate.method.name().to_owned(),
            speed: None,
            sample_time: model.sample_time,
            num: model.b.clone(),
            den: std::iter::once(1.0)
                .chain(model.a.iter().copied())
                .collect(),
            covariance: covariance
                .row_iter()
                .map(|row| row.iter().copied().collect())
                .collect(),
            continuous: continuous.map(|it| Continuous {
                num: it.transfer.num.clone(),
                den: it.transfer.den.clone(),
                delay: it.delay,
            }),
            physical: None,
            offset: self.estimate.offset(self.longest),
            noise_variance: self.estimate.noise_variance,
            noise_model: self.estimate.noise_model.clone(),
            poles: places(reading.poles()?),
            continuous_poles: places(reading.continuous_poles()?),
            zeros: places(reading.zeros()?),
            dc_gain: reading
                .dc_gain()
                .map(|gain| [gain.value.re, gain.real_deviation()]),
            fit: self.fit,
            held_out_fit: self.held_out_fit,
            verdict: self.verdict.clone(),
        })
    }

    /// The account for the terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let model = self.model();
        let mut text = format!(
            "{} -> {}, {}, {} poles, {} numerator coefficients, delay {}, {} s\n",
            self.input,
            self.output,
            self.estimate.method,
            self.estimate.layout.structure.poles,
            self.estimate.layout.structure.numerator,
            self.estimate.layout.structure.delay,
            model.sample_time
        );
        if !self.candidates.is_empty() {
            text += "\norder  delay   AIC        BIC        held-out fit\n";
            for c in self.candidates.iter().take(8) {
                let fit = c
                    .held_out_fit
                    .map_or("-".to_owned(), |fit| format!("{fit:.2} %"));
                let _ = writeln!(
                    text,
                    "{:<6} {:<7} {:<10.1} {:<10.1} {fit}",
                    c.order, c.delay, c.aic, c.bic
                );
            }
        }
        let list = |values: &[f64]| {
            values
                .iter()
                .map(|v| format!("{v:.8}"))
                .collect::<Vec<_>>()
                .join("  ")
        };
        let _ = writeln!(
            text,
            "\nnumerator    {}   (z^{} first)",
            list(&model.b),
            model.b.len() - 1
        );
        let _ = writeln!(text, "denominator  1  {}", list(&model.a));
        let reading = self.reading();
        for (name, found) in [
            ("z pole", reading.poles()),
            ("s pole", reading.continuous_poles()),
            ("z zero", reading.zeros()),
        ] {
            for it in found
                .unwrap_or_default()
                .iter()
                .filter(|it| it.value.im >= 0.0)
            {
                let _ = writeln!(text, "{name:<12} {}", complex(it));
            }
        }
        if let Some(gain) = reading.dc_gain() {
            let _ = writeln!(
                text,
                "{:<12} {:.5} ± {:.5}",
                "dc gain",
                gain.value.re,
                SIGMAS_95 * gain.real_deviation()
            );
        }
        let _ = writeln!(
            text,
            "{:<12} {:.6}\n{:<12} {:.3e}, one standard deviation",
            "offset",
            self.estimate.offset(self.longest),
            "noise",
            self.estimate.noise_variance.sqrt()
        );
        let percent = |fit: Option<f64>| fit.map_or("none".to_owned(), |fit| format!("{fit:.2} %"));
        let _ = writeln!(
            text,
            "{:<12} {} simulated, {} on held-out data\n",
            "fit",
            percent(self.fit),
            percent(self.held_out_fit)
        );
        for sentence in &self.verdict {
            let _ = writeln!(text, "- {sentence}");
        }
        text
    }
}

/// A number with its 95 % interval, upper of a pair.
fn complex(it: &Uncertain) -> String {
    let real = format!(
        "{:.5} ± {:.5}",
        it.value.re,
        SIGMAS_95 * it.real_deviation()
    );
    if it.value.im == 0.0 {
        real
    } else {
        format!(
            "{real}, ± ({:.5} ± {:.5}) i",
            it.value.im,
            SIGMAS_95 * it.imaginary_deviation()
        )
    }
}

fn place(it: &Uncertain) -> Place {
    Place {
        re: it.value.re,
        im: it.value.im,
        re_deviation: it.real_deviation(),
        im_deviation: it.imaginary_deviation(),
    }
}
