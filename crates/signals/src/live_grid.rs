//! Live resampling of signals with different stamps to one grid.
//!
//! ```text
//! y(t_k)                                     on the straight line between the samples before and after t_k
//! u_k = (1/T) integral of u(t) dt            over [t_k, t_(k+1)), each sample held until the next,
//! m_k = (1/T^2) integral of (t - t_k - T/2) u(t) dt      and its first moment, both exactly
//! ```
//! The instants are whole intervals from the first output's stamp. It is what [`crate::resample`] does with a
//! record, for samples of which the next is not known yet:
//!
//! - **An output** is given as soon as the sample after it has come; across an interval longer than a gap, or
//!   marked as broken, nothing is invented.
//! - **An input** acts until the next, and in want of one until eight intervals before the newest output: a
//!   setpoint that is sent when it changes is known until it changes. What comes later than that is left out, so arrival
//!   orders that differ by less give the same numbers.
//! - **Time going back** by more than the aligner's window, twice in a row, begins both anew on the same grid, with
//!   the input of the new time that overtook the output.
//!
//! Memory is bounded by a thousand intervals, whatever the stamps.

use std::collections::VecDeque;

use planesman_identification::Input;

use crate::align::WINDOW;

/// Intervals that an input is waited for behind the newest output: half of what the aligner waits.
const PATIENCE: i64 = WINDOW / 2;

/// Intervals filled at once or kept at most; beyond is a gap.
const MOST: i64 = 1000;

/// Stamps beyond this, ns (146 years from the epoch), are left out: differences fit 64 bits.
const FARTHEST: i64 = 1 << 62;

/// One number on the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Given {
    /// The output at an instant.
    Output(i64, f64),
    /// The input over the interval that begins at an instant.
    Input(i64, Input),
}

impl Given {
    fn stamp(&self) -> i64 {
        match self {
            Self::Output(stamp, _) | Self::Input(stamp, _) => *stamp,
        }
    }
}

/// Two signals on their way onto the grid.
#[derive(Clone, Debug)]
pub struct LiveGrid {
    /// T, ns.
    period: i64,
    /// The longest interval between two outputs that is no gap, ns.
    max_gap: i64,
    origin: Option<i64>,
    /// The last output sample.
    output: Option<(i64, f64)>,
    /// The last one that was of an earlier time.
    old: Option<i64>,
    held: Held,
    /// The last input that was of an earlier time.
    old_input: Option<(i64, f64)>,
    /// Inputs over whole intervals, not yet given.
    inputs: VecDeque<(i64, Input)>,
}

/// The input's integrals on the way.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    /// The input that acts, and from when it has been counted.
    now: Option<(i64, f64)>,
    /// Over the interval that is going on.
    sum: Input,
    /// The input was known when that interval began.
    whole: bool,
}

impl LiveGrid {
    /// A grid before its first sample; both in ns.
    #[must_use]
    pub fn new(period: i64, max_gap: i64) -> Self {
        let period = period.max(1);
        Self {
            period,
            max_gap: max_gap.min(MOST.saturating_mul(period)),
            origin: None,
            output: None,
            old: None,
            held: Held::default(),
            old_input: None,
            inputs: VecDeque::new(),
        }
    }

    /// Takes an output; where `broken`, nothing is said of the interval before it. `None` when it is left out.
    pub fn output(&mut self, stamp: i64, value: f64, broken: bool) -> Option<Vec<Given>> {
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
        let origin = *self.origin.get_or_insert(stamp);
        let mut given = Vec::new();
        match self.output.replace((stamp, value)) {
            Some((last, before)) if !broken && stamp - last <= self.max_gap => {
                let mut instant = self.at_or_before(origin, last) + self.period;
                while instant <= stamp {
                    let share = (instant - last) as f64 / (stamp - last) as f64;
                    given.push(Given::Output(instant, before + share * (value - before)));
                    instant += self.period;
                }
            }
            _ if self.at_or_before(origin, stamp) == stamp => {
                given.push(Given::Output(stamp, value))
            }
            _ => {}
        }
        self.hold_until(stamp - PATIENCE * self.period);
        self.give_inputs(&mut given);
        Some(given)
    }

    /// Takes an input. `None` when it is left out.
    pub fn input(&mut self, stamp: i64, value: f64) -> Option<Vec<Given>> {
        if stamp.saturating_abs() >= FARTHEST {
            return None;
        }
        match self.held.now {
            // What acts after an earlier time has begun is of no use there.
            Some((since, _)) if stamp < since => {
                self.old_input = (stamp < since - WINDOW * self.period).then_some((stamp, value));
                return None;
            }
            Some(_) => self.hold_until(stamp),
            None => {}
        }
        if self.held.now.is_none() {
            let begins = |origin| self.at_or_before(origin, stamp) == stamp;
            self.held.whole = self.origin.is_some_and(begins);
        }
        self.held.now = Some((stamp, value));
        let mut given = Vec::new();
        self.give_inputs(&mut given);
        Some(given)
    }

    /// Says that nothing more will come: the last input acts until the last output.
    pub fn finish(&mut self) -> Vec<Given> {
        if let Some((last, _)) = self.output {
            self.hold_until(last);
        }
        let mut given = Vec::new();
        self.give_inputs(&mut given);
        given
    }

    fn begin_anew(&mut self) {
        self.output = None;
        self.held = Held::default();
        self.inputs.clear();
        if let Some((stamp, value)) = self.old_input.take() {
            self.input(stamp, value);
        }
    }

    fn at_or_before(&self, origin: i64, stamp: i64) -> i64 {
        stamp - (stamp - origin).rem_euclid(self.period)
    }

    /// Lets the input act until then, and keeps what that makes of whole intervals.
    fn hold_until(&mut self, until: i64) {
        let (Some(origin), Some((mut since, value))) = (self.origin, self.held.now) else {
            return;
        };
        if until - since > MOST * self.period {
            // Nobody has asked for so long: what lies between is a gap.
            self.held.sum = Input::default();
            self.held.whole = false;
            since = until;
        }
        while since < until {
            let begin = self.at_or_before(origin, since);
            let end = until.min(begin + self.period);
            let part = |stamp: i64| (stamp - begin) as f64 / self.period as f64;
            let (from, to) = (part(since), part(end));
            self.held.sum.mean += value * (to - from);
            self.held.sum.moment += value * ((to - 0.5).powi(2) - (from - 0.5).powi(2)) / 2.0;
            since = end;
            if end == begin + self.period {
                if self.held.whole {
                    self.inputs.push_back((begin, self.held.sum));
                    if self.inputs.len() > MOST as usize {
                        self.inputs.pop_front();
                    }
                }
                self.held.sum = Input::default();
                self.held.whole = true;
            }
        }
        self.held.now = Some((since.max(until), value));
    }

    /// Gives the inputs that the outputs have come near to, all in the order of their stamps.
    fn give_inputs(&mut self, given: &mut Vec<Given>) {
        let Some((newest, _)) = self.output else {
            return;
        };
        let near = newest.saturating_add(PATIENCE * self.period);
        while let Some((stamp, input)) = self.inputs.pop_front_if(|it| it.0 <= near) {
            given.push(Given::Input(stamp, input));
        }
        given.sort_by_key(Given::stamp);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: i64 = 1000;

    fn outputs(given: &[Given]) -> Vec<(i64, f64)> {
        let of = |it: &Given| match it {
            Given::Output(stamp, value) => Some((*stamp, *value)),
            Given::Input(..) => None,
        };
        given.iter().filter_map(of).collect()
    }

    fn inputs(given: &[Given]) -> Vec<(i64, Input)> {
        let of = |it: &Given| match it {
            Given::Input(stamp, input) => Some((*stamp, *input)),
            Given::Output(..) => None,
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
        let given: Vec<Given> = (1..=20)
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
                assert!(given.len() as i64 <= 2 * MOST + 1);
                let given = grid.input(stamp, 1.0).unwrap_or_default();
                assert!(given.len() as i64 <= 2 * MOST + 1);
            }
        }
        assert!(grid.inputs.len() as i64 <= MOST);
    }
}
