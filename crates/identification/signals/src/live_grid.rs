//! Live resampling of signals with different stamps to one grid: like [`crate::gridder`], output by the method linear, input by the method
//! mean, but the next sample is not known yet. The instants are at whole intervals from the first output's stamp.
//!
//! - An output is passed on as soon as the next sample has arrived. Intervals longer than a gap, or marked as broken, are not interpolated.
//! - **An input** acts until the next one, and without a next one until eight intervals before the newest output. So a setpoint that is sent only
//!   when it changes stays known until its next change. Inputs that arrive later are left out, so arrival orders that differ by less give the same
//!   numbers.
//! - **Time going back** by more than the aligner's window, twice in a row, restarts both on the same grid, with the input of the new time
//!   if it came before the output.
//!
//! Memory is bounded by a thousand intervals for any stamps.

use std::collections::VecDeque;

use planesman_record::Input;

use crate::align::WINDOW;
use crate::channel::Method;
use crate::gridder::{Grid, Gridder, Onto, Put};

/// Maximum wait for an input that is later than the newest output, in intervals: half of the aligner's wait.
const PATIENCE: i64 = WINDOW / 2;

/// Maximum number of intervals filled at once or stored; more is a gap.
const MAX_INTERVALS: i64 = 1000;

/// Stamps beyond this, ns (146 years from the epoch), are left out, so that differences fit 64 bits.
const FARTHEST: i64 = 1 << 62;

/// One number on the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridSample {
    /// The output at an instant.
    Output(i64, f64),
    /// The input over the interval that begins at an instant.
    Input(i64, Input),
}

impl GridSample {
    fn stamp(&self) -> i64 {
        match self {
            Self::Output(stamp, _) | Self::Input(stamp, _) => *stamp,
        }
    }
}

/// The state of resampling two signals.
#[derive(Clone, Debug)]
pub struct LiveGrid {
    /// T, ns.
    period: i64,
    /// The longest interval between two outputs that is not a gap, ns.
    max_gap: i64,
    /// The grid through the first output.
    grid: Option<Grid>,
    line: Gridder,
    mean: Gridder,
    /// The last output sample.
    output: Option<(i64, f64)>,
    /// The last output with an earlier time.
    old: Option<i64>,
    /// The current input, and the time up to which it has been counted.
    held: Option<(i64, f64)>,
    /// The last input with an earlier time.
    old_input: Option<(i64, f64)>,
    /// Inputs over whole intervals, not yet passed on.
    inputs: VecDeque<(i64, Input)>,
}

impl LiveGrid {
    /// A grid before its first sample; `period` and `max_gap` in ns.
    #[must_use]
    pub fn new(period: i64, max_gap: i64) -> Self {
        let period = period.max(1);
        Self {
            period,
            max_gap: max_gap.min(MAX_INTERVALS.saturating_mul(period)),
            grid: None,
            line: Gridder::new(Method::Linear),
            mean: Gridder::new(Method::Mean),
            output: None,
            old: None,
            held: None,
            old_input: None,
            inputs: VecDeque::new(),
        }
    }

    /// Takes an output. If `broken` is set, the interval before this output is not interpolated. `None` if it is left out.
    pub fn output(&mut self, stamp: i64, value: f64, broken: bool) -> Option<Vec<GridSample>> {
        if stamp.saturating_abs() >= FARTHEST {
            return None;
        }
        if let Some((last, _)) = self.output {
            if stamp < last - WINDOW * self.period {
                // One alone is a straggler.
                self.old.replace(stamp)?;
                self.begin_anew();
            } else if stamp <= last {
                return None;
            }
        }
        self.old = None;
        let step = self.period as f64;
        let grid = self.grid.get_or_insert_with(|| Grid::new(stamp, step));
        let mut given = Vec::new();
        let put = &mut |put| {
            if let Put::One(k, output) = put {
                given.push(GridSample::Output(grid.time(k), output.mean));
            }
        };
        let onto = &mut Onto { grid, put };
        let sample = (stamp, value);
        match self.output.replace(sample) {
            Some(before) if !broken && stamp - before.0 <= self.max_gap => {
                self.line.pair(before, sample, MAX_INTERVALS as usize, onto);
            }
            _ => self.line.begin(sample, onto),
        }
        self.hold_to_instant(stamp - PATIENCE * self.period);
        self.give_inputs(&mut given);
        Some(given)
    }

    /// Takes an input. `None` if it is left out.
    pub fn input(&mut self, stamp: i64, value: f64) -> Option<Vec<GridSample>> {
        if stamp.saturating_abs() >= FARTHEST {
            return None;
        }
        match self.held {
            // What acts after an earlier time has begun is of no use there.
            Some((since, _)) if stamp < since => {
                self.old_input = (stamp < since - WINDOW * self.period).then_some((stamp, value));
                return None;
            }
            Some(_) => self.hold_until(stamp),
            None => {}
        }
        self.held = Some((stamp, value));
        let mut given = Vec::new();
        self.give_inputs(&mut given);
        Some(given)
    }

    /// Ends the data: the last input acts until the last output.
    pub fn finish(&mut self) -> Vec<GridSample> {
        if let Some((last, _)) = self.output {
            self.hold_to_instant(last);
        }
        let mut given = Vec::new();
        self.give_inputs(&mut given);
        given
    }

    fn begin_anew(&mut self) {
        self.output = None;
        self.held = None;
        self.mean.forget();
        self.inputs.clear();
        if let Some((stamp, value)) = self.old_input.take() {
            self.input(stamp, value);
        }
    }

    /// Extends the input up to the last instant before `until`: the length of the wait must not affect the rounding of an interval.
    fn hold_to_instant(&mut self, until: i64) {
        if let Some(grid) = &self.grid {
            self.hold_until(grid.time(grid.at_or_before(until)));
        }
    }

    /// Extends the input to `until`, and stores the complete intervals.
    fn hold_until(&mut self, until: i64) {
        let (Some(grid), Some((since, value))) = (&self.grid, self.held) else {
            return;
        };
        if until <= since {
            return;
        }
        self.held = Some((until, value));
        if until - since > MAX_INTERVALS * self.period {
            // Nobody has asked for so long: what lies between is a gap.
            return self.mean.forget();
        }
        let inputs = &mut self.inputs;
        let put = &mut |put| match put {
            Put::One(k, input) => inputs.push_back((grid.time(k), input)),
            Put::Held(first, end, value) => {
                inputs.extend((first..end).map(|k| (grid.time(k), Input::held(value))));
            }
        };
        let onto = &mut Onto { grid, put };
        self.mean
            .pair((since, value), (until, value), MAX_INTERVALS as usize, onto);
        let spare = self.inputs.len().saturating_sub(MAX_INTERVALS as usize);
        self.inputs.drain(..spare);
    }

    /// Passes on the inputs that the outputs have nearly reached, in the order of their stamps.
    fn give_inputs(&mut self, given: &mut Vec<GridSample>) {
        let Some((newest, _)) = self.output else {
            return;
        };
        let near = newest.saturating_add(PATIENCE * self.period);
        while let Some((stamp, input)) = self.inputs.pop_front_if(|it| it.0 <= near) {
            given.push(GridSample::Input(stamp, input));
        }
        given.sort_by_key(GridSample::stamp);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: i64 = 1000;

    fn outputs(given: &[GridSample]) -> Vec<(i64, f64)> {
        let of = |it: &GridSample| match it {
            GridSample::Output(stamp, value) => Some((*stamp, *value)),
            GridSample::Input(..) => None,
        };
        given.iter().filter_map(of).collect()
    }

    fn inputs(given: &[GridSample]) -> Vec<(i64, Input)> {
        let of = |it: &GridSample| match it {
            GridSample::Input(stamp, input) => Some((*stamp, *input)),
            GridSample::Output(..) => None,
        };
        given.iter().filter_map(of).collect()
    }

    #[test]
    fn outputs_lie_on_the_straight_line_and_gaps_stay_gaps() {
        let mut grid = LiveGrid::new(T, 5 * T);
        assert_eq!(
            outputs(&grid.output(300, 1.0, false).unwrap()),
            [(300, 1.0)]
        );
        let line = outputs(&grid.output(2800, 3.5, false).unwrap());
        assert_eq!(line, [(1300, 2.0), (2300, 3.0)]);
        assert!(grid.output(2800, 9.0, false).is_none(), "a repeat");
        assert!(outputs(&grid.output(9000, 0.0, false).unwrap()).is_empty());
        assert!(outputs(&grid.output(9200, 0.0, true).unwrap()).is_empty());
        assert_eq!(
            outputs(&grid.output(9300, 5.0, false).unwrap()),
            [(9300, 5.0)]
        );
    }

    #[test]
    fn an_input_is_its_mean_and_first_moment_over_each_interval() {
        let mut grid = LiveGrid::new(T, 5 * T);
        grid.output(0, 0.0, false);
        let mut given = grid.input(0, 2.0).unwrap();
        given.extend(grid.input(1250, 4.0).unwrap());
        given.extend(grid.input(3000, 0.0).unwrap());
        let found = inputs(&given);
        assert_eq!(found[0], (0, Input::held(2.0)));
        // A quarter of 2, three of 4: mean 3.5; moment 2 (1/16 - 1/4)/2 + 4 (1/4 - 1/16)/2.
        assert_eq!(
            found[1],
            (
                1000,
                Input {
                    mean: 3.5,
                    moment: 0.1875
                }
            )
        );
        assert_eq!(found[2], (2000, Input::held(4.0)));
    }

    #[test]
    fn an_input_that_is_sent_when_it_changes_acts_until_then() {
        let mut grid = LiveGrid::new(T, 5 * T);
        grid.output(0, 0.0, false);
        grid.input(0, 2.0);
        let given: Vec<GridSample> = (1..=20)
            .filter_map(|k| grid.output(k * T, 0.0, false))
            .flatten()
            .collect();
        let found = inputs(&given);
        assert_eq!(found.len(), 20 - PATIENCE as usize);
        assert!(found.iter().all(|(_, input)| *input == Input::held(2.0)));
        assert!(
            grid.input(11 * T, 3.0).is_none(),
            "it has been given already"
        );
        assert_eq!(inputs(&grid.finish()).len(), PATIENCE as usize);
    }

    #[test]
    fn time_that_goes_back_twice_begins_anew_and_one_straggler_does_not() {
        let mut grid = LiveGrid::new(T, 5 * T);
        for k in 100..110 {
            grid.output(k * T, 1.0, false);
        }
        assert!(grid.output(0, 1.0, false).is_none());
        assert_eq!(outputs(&grid.output(110 * T, 1.0, false).unwrap()).len(), 1);
        assert!(grid.output(0, 1.0, false).is_none());
        assert_eq!(outputs(&grid.output(T, 1.0, false).unwrap()), [(T, 1.0)]);
        assert_eq!(
            outputs(&grid.output(2 * T, 1.0, false).unwrap()),
            [(2 * T, 1.0)]
        );
    }

    #[test]
    fn no_stamps_make_it_grow() {
        let mut grid = LiveGrid::new(1, i64::MAX);
        for stamp in [0, i64::MAX, i64::MIN, 1 << 61, -(1 << 61), 5, 1 << 60] {
            for _ in 0..3 {
                let given = grid.output(stamp, 1.0, false).unwrap_or_default();
                assert!(given.len() as i64 <= 2 * MAX_INTERVALS + 1);
                let given = grid.input(stamp, 1.0).unwrap_or_default();
                assert!(given.len() as i64 <= 2 * MAX_INTERVALS + 1);
            }
        }
        assert!(grid.inputs.len() as i64 <= MAX_INTERVALS);
    }
}
