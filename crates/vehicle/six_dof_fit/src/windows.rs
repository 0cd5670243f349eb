//! Windows of runs: one after the other for a fit, and overlapping ones for predictions, none across a jump of the pose.

use std::ops::Range;
use std::sync::Arc;

use planesman_equations::Run;

use crate::kinematics::Reset;
use crate::options::Cost;
use crate::problem::{Held, Problem, STEPS, Window};

/// Maximum number of windows.
const WINDOWS: f64 = 60.0;
/// Time around a reset that is left out \[s\].
const AROUND_RESET: f64 = 0.3;
/// Time between the starts of predictions \[s\].
const START: f64 = 1.0;

/// Cuts runs into windows.
#[derive(Clone, Copy)]
pub(super) struct Cutter<'a> {
    pub(super) runs: &'a [Run],
    pub(super) channels: &'a [usize],
    pub(super) resets: &'a [Reset],
    cost: Cost,
    /// Maximum number of windows.
    most: f64,
    /// The longest step of the simulation \[s\].
    step: f64,
}

impl<'a> Cutter<'a> {
    pub(super) fn new(
        runs: &'a [Run],
        channels: &'a [usize],
        resets: &'a [Reset],
        cost: Cost,
    ) -> Self {
        Self {
            runs,
            channels,
            resets,
            cost,
            most: match cost {
                Cost::All => WINDOWS,
                Cost::Velocities => 20.0 * WINDOWS,
            },
            step: STEPS[STEPS.len() - 1],
        }
    }

    /// The problem for other runs with the same signals.
    pub(super) fn of_other_runs<'b>(&self, runs: &'b [Run], resets: &'b [Reset]) -> Cutter<'b>
    where
        'a: 'b,
    {
        Cutter {
            runs,
            resets,
            ..*self
        }
    }

    /// The cutter with the longest steps that are exact enough, and its windows; `exact` are those with the shortest steps.
    pub(super) fn with_longer_steps(
        &self,
        problem: &Problem<'_>,
        horizon: f64,
        exact: &[Window],
    ) -> Option<(Self, Vec<Window>)> {
        STEPS[..STEPS.len() - 1].iter().find_map(|step| {
            let longer = Self {
                step: *step,
                ..*self
            };
            let windows = longer.windows(horizon, 0.0..1.0);
            problem
                .is_exact(&windows, exact)
                .then_some((longer, windows))
        })
    }

    /// The spans of a share of a run between its resets \[s\].
    fn spans(&self, number: usize, share: &Range<f64>) -> Vec<Range<f64>> {
        let end = self.runs[number].end();
        let resets = self.resets.iter().filter(|it| it.run == number);
        let mut spans = Vec::new();
        let (mut from, to) = (share.start * end, share.end * end);
        for reset in resets {
            let until = (reset.time - AROUND_RESET).min(to);
            if until > from {
                spans.push(from..until);
            }
            from = from.max(reset.time + AROUND_RESET);
        }
        if from < to {
            // The last sample of all is in the last window.
            let until = if share.end == 1.0 { f64::INFINITY } else { to };
            spans.push(from..until);
        }
        spans
    }

    fn held(&self, number: usize) -> Arc<Vec<Held>> {
        Arc::new(self.runs[number].inputs.iter().map(Held::new).collect())
    }

    /// Windows one after the other, of a share of each run.
    pub(super) fn windows(&self, longest: f64, share: Range<f64>) -> Vec<Window> {
        let total: f64 = self.runs.iter().map(Run::end).sum();
        let longest = longest.max(total / self.most);
        let of = |(number, run): (usize, &Run)| {
            let held = self.held(number);
            let mut parts = Vec::new();
            for span in self.spans(number, &share) {
                let (from, to) = (span.start, span.end.min(run.end()));
                let count = ((to - from) / longest - 1e-9).ceil().max(1.0) as usize;
                let edge = |k: usize| from + (to - from) * k as f64 / count as f64;
                parts.extend((0..count).filter_map(|k| {
                    let until = if k + 1 == count {
                        span.end
                    } else {
                        edge(k + 1)
                    };
                    let how = (self.cost, self.step);
                    Window::of(run, self.channels, edge(k)..until, how, &held)
                }));
            }
            parts
        };
        self.runs.iter().enumerate().flat_map(of).collect()
    }

    /// Windows of that length, one from each second.
    pub(super) fn overlapping(&self, length: f64, share: Range<f64>) -> Vec<Window> {
        let of = |(number, run): (usize, &Run)| {
            let held = self.held(number);
            let mut parts = Vec::new();
            for span in self.spans(number, &share) {
                let to = span.end.min(run.end());
                let count = ((to - span.start - length) / START + 1e-9).floor();
                parts.extend((0..=count.max(-1.0) as i64).filter_map(|k| {
                    let from = span.start + START * k as f64;
                    (from + length <= to + 1e-9).then_some(())?;
                    let until = from + length;
                    Window::of(
                        run,
                        self.channels,
                        from..until,
                        (Cost::All, self.step),
                        &held,
                    )
                }));
            }
            parts
        };
        self.runs.iter().enumerate().flat_map(of).collect()
    }
}
