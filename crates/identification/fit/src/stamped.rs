//! Samples at their original stamps: time intervals in which all signals are known.

use planesman_equations::{Between, Run, Track};
use planesman_parallel::Progress;
use planesman_signals::{Method, Reading, Request, Role, Stretches, hertz, read_samples};

use crate::data::{DataOptions, reading};
use crate::declaration::OptionGroup as _;
use crate::error::FitError;
use crate::fit::{data_warnings, downgrade_verdict};
use crate::options::{FitOptions, GridOptions, Validation};
use planesman_identification::analysis::{Reason, Verdict};

/// An interval of this many usual intervals is a gap. The simulation continues through shorter gaps, because the inputs are known.
const GAP: f64 = 20.0;
/// Maximum number of runs; the longest runs are used.
const MOST_RUNS: usize = 40;
/// Samples of an input kept from before a run.
const PAST: usize = 1000;
/// Minimum number of samples of each output in a run.
const FEWEST: usize = 3;

/// Data at its original stamps.
#[derive(Clone, Debug)]
pub struct StampedRuns {
    /// The names of the signals: inputs, then outputs.
    pub signals: Vec<String>,
    /// The runs.
    pub runs: Vec<Run>,
    /// The runs for validation; empty without validation data.
    pub validation: Vec<Run>,
    /// A summary of the data, one entry per line.
    pub description: Vec<String>,
    /// Information on the reading of each source.
    pub readings: Vec<Reading>,
}

/// An interval of time, ns.
type Span = (i64, i64);

/// Whether inputs are held or linear between samples.
fn between(of: &GridOptions) -> Result<Between, FitError> {
    match of.input_method {
        Method::Mean | Method::Hold => Ok(Between::Held),
        Method::Linear | Method::Foh => Ok(Between::Lines),
        Method::Centred => Err(FitError::NotOf("input_method centred", WHAT)),
    }
}

const WHAT: &str = "a fit at the original stamps, without a grid";

impl FitOptions {
    /// Refuses options of a grid, of its preparation and of other models.
    ///
    /// # Errors
    /// [`FitError::NotOf`] for the first such option.
    pub fn check_stamped(&self) -> Result<(), FitError> {
        self.check()?;
        let given = self.given();
        let of_grid = given.iter().find(|it| it.of_grid);
        match of_grid.or_else(|| given.iter().find(|it| it.of_one)) {
            Some(option) => Err(FitError::NotOf(option.name, WHAT)),
            None => Ok(()),
        }
    }

    /// The runs to fit, and those for validation.
    ///
    /// # Errors
    /// If the data cannot be read, or at no time are all signals known.
    pub fn stamped(
        &self,
        inputs: &[String],
        outputs: &[String],
        progress: &dyn Progress,
    ) -> Result<StampedRuns, FitError> {
        let signals = &self.signals;
        let mut found = StampedRuns {
            signals: [inputs, outputs].concat(),
            runs: Vec::new(),
            validation: Vec::new(),
            description: Vec::new(),
            readings: Vec::new(),
        };
        let windows = match self.validation {
            Some(Validation::Window(from, to)) => {
                let ways = signals.grid.outside((from, to))?;
                ways.into_iter()
                    .next()
                    .map(|it| it.window)
                    .unwrap_or_default()
            }
            _ => signals.grid.window.clone(),
        };
        found.runs = self.runs_of(&signals.data, &windows, &mut found, inputs.len(), progress)?;
        found.validation = match &self.validation {
            None => Vec::new(),
            Some(Validation::Window(from, to)) => {
                let window = [(*from, *to)];
                self.runs_of(&signals.data, &window, &mut found, inputs.len(), &())?
            }
            Some(Validation::Data(path)) => {
                let data = signals.data.for_files(vec![path.clone()]);
                let runs = self.runs_of(&data, &[], &mut found, inputs.len(), progress);
                runs.map_err(|error| FitError::Validation(Box::new(error)))?
            }
        };
        Ok(found)
    }

    fn runs_of(
        &self,
        data: &DataOptions,
        windows: &[(f64, f64)],
        found: &mut StampedRuns,
        inputs: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Run>, FitError> {
        let grid = &self.signals.grid;
        let between = between(grid)?;
        let request = |(number, name): (usize, &String)| Request {
            name: name.clone(),
            role: if number < inputs {
                Role::Input
            } else {
                Role::Output
            },
        };
        let requests: Vec<Request> = found.signals.iter().enumerate().map(request).collect();
        let mut runs = Vec::new();
        for source in data.each(&found.signals)? {
            let read = reading(source.bytes(), progress, |told| {
                read_samples(&*source, &requests, grid.unwrap, told)
            });
            let (signals, mut of) = read.map_err(FitError::data)?;
            let slowest = signals[inputs..]
                .iter()
                .map(|it| it.interval)
                .fold(0.0, f64::max);
            if slowest > 0.0 {
                of.question_unit(1.0 / slowest);
            }
            for (request, signal) in requests.iter().zip(&signals) {
                let kind = match request.role {
                    Role::Input => "input ",
                    Role::Output => "output",
                };
                found
                    .description
                    .push(format!("{kind}  {}: {}", request.name, described(signal)));
            }
            found.description.push(format!("stamps  {}", of.stamps));
            for note in of.clock.iter().chain(&of.mixed).chain(&of.notes) {
                found.description.push(format!("note    {note}"));
            }
            found.readings.push(of);
            for (from, to) in common(&signals, inputs, windows, grid.max_gap) {
                let cut = |number: usize, of: &Stretches| track(of, (from, to), number < inputs);
                let tracks: Vec<Track> = signals
                    .iter()
                    .enumerate()
                    .map(|(i, it)| cut(i, it))
                    .collect();
                let (of_inputs, of_outputs) = tracks.split_at(inputs);
                if of_outputs.iter().all(|it| it.times.len() >= FEWEST) {
                    runs.push(Run {
                        inputs: of_inputs.to_vec(),
                        outputs: of_outputs.to_vec(),
                        between,
                    });
                }
            }
        }
        if runs.is_empty() {
            return Err(FitError::NoStretch(found.signals.join(", ")));
        }
        if runs.len() > MOST_RUNS {
            runs.sort_by(|p, q| q.end().total_cmp(&p.end()));
            found.description.push(format!(
                "note    only the {MOST_RUNS} longest of {} segments are used",
                runs.len()
            ));
            runs.truncate(MOST_RUNS);
        }
        Ok(runs)
    }
}

impl StampedRuns {
    /// Downgrades a verdict by findings about the clock; returns it with the reasons.
    pub(crate) fn doubts(&self, verdict: Verdict) -> (Verdict, Vec<Reason>) {
        let readings: Vec<&Reading> = self.readings.iter().collect();
        (
            downgrade_verdict(&readings, verdict),
            data_warnings(&readings),
        )
    }
}

fn described(of: &Stretches) -> String {
    let samples: usize = of.stretches.iter().map(Vec::len).sum();
    let rate = match of.interval > 0.0 {
        true => format!(" at about {} Hz", hertz(1.0 / of.interval)),
        false => String::new(),
    };
    let changes: String = of.changes.iter().map(|it| format!("; {it}")).collect();
    format!("{samples} samples{rate}{changes}")
}

/// The time spans, within the windows, in which every output is known without a gap and every input has a value. Windows count from the first
/// output's first sample.
fn common(
    signals: &[Stretches],
    inputs: usize,
    windows: &[(f64, f64)],
    max_gap: Option<f64>,
) -> Vec<Span> {
    let first = |of: &Stretches| {
        of.stretches
            .first()
            .and_then(|it| it.first())
            .map_or(0, |it| it.0)
    };
    let origin = signals.get(inputs).map_or(0, first);
    let at = |seconds: f64| origin.saturating_add((seconds * 1e9).clamp(-4e18, 4e18) as i64);
    let mut spans: Vec<Span> = match windows {
        [] => vec![(i64::MIN, i64::MAX)],
        windows => windows.iter().map(|it| (at(it.0), at(it.1))).collect(),
    };
    for of in &signals[inputs..] {
        let longest = (max_gap.unwrap_or(GAP * of.interval) * 1e9).min(9e18) as i64;
        let mut known: Vec<Span> = Vec::new();
        for stretch in &of.stretches {
            let mut begin = stretch[0].0;
            for pair in stretch.windows(2) {
                if longest > 0 && pair[1].0.saturating_sub(pair[0].0) > longest {
                    known.push((begin, pair[0].0));
                    begin = pair[1].0;
                }
            }
            known.push((begin, stretch[stretch.len() - 1].0));
        }
        let meet = |span: &Span| {
            let each = known.iter().map(|it| (it.0.max(span.0), it.1.min(span.1)));
            each.filter(|it| it.0 <= it.1).collect::<Vec<Span>>()
        };
        spans = spans.iter().flat_map(meet).collect();
    }
    for of in &signals[..inputs] {
        spans.iter_mut().for_each(|it| it.0 = it.0.max(first(of)));
    }
    spans.retain(|it| it.0 < it.1);
    spans
}

/// The samples of a span, and for an input also earlier samples; times in s from the beginning of the span.
fn track(of: &Stretches, (from, to): Span, is_input: bool) -> Track {
    let all: Vec<&(i64, f64)> = of.stretches.iter().flatten().collect();
    let mut begin = all.partition_point(|it| it.0 < from);
    if is_input {
        // What acts at the begin, and within a dead time before it.
        begin = begin.saturating_sub(PAST);
    }
    let end = all.partition_point(|it| it.0 <= to).max(begin);
    let of = &all[begin..end];
    Track {
        times: of
            .iter()
            .map(|it| it.0.saturating_sub(from) as f64 * 1e-9)
            .collect(),
        values: of.iter().map(|it| it.1).collect(),
    }
}
