//! Sorts inputs and outputs by their stamps, regardless of the order of arrival.
//!
//! The output is known at the instants t_k, the input over the intervals `[t_k, t_(k+1))`, each message stamped with its t_k. For each k
//! the regression needs the output at t_k and the input over the interval that ended there, stamped t_(k-1).
//!
//! Instants lie on a grid of one sampling interval through the first stamp seen; a stamp
//! further than a quarter interval from it is off the grid and left out.
//!
//! - **Order.** A sample is passed on as soon as the previous sample has been passed on. The aligner waits for a missing message until an output
//!   [`WINDOW`] intervals newer has come. Then the missing sample is a gap, and the samples restart after the gap. The very first sample is delayed
//!   by the same window, since an earlier one may follow. So arrival orders that differ by less than the window give the same samples.
//! - **Left out** are repeats, messages that arrive after they were counted as missing, and inputs more than the window ahead of every
//!   output.
//! - Time going back: two consecutive outputs that are older than the newest by more than the window mean that the clock was set back, for example by
//!   a bag that loops or a restarted simulation. Everything restarts; inputs of the new time that arrived before its outputs are kept. A single such
//!   output is a late message, and left out.
//! - **Another grid**: if as many consecutive outputs as the window is long are off the grid, their publisher was restarted, or has a
//!   slightly different rate. Then a new grid is used.
//!
//! Memory is bounded by the window for any stamps, as long as samples are taken.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use planesman_record::Input;

/// The largest lateness of a message relative to the newest, in intervals.
pub const WINDOW: i64 = 16;

/// In lockstep, the number of times that an output arrives before the aligner stops waiting for its input.
pub const MAX_REPEATS: u32 = 3;

/// An output, and the input over the interval before this output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The output's stamp, ns.
    pub stamp: i64,
    /// The output at the stamp.
    pub output: f64,
    /// The input over the interval that ended at the stamp; `None` at the first sample and after a gap.
    pub input: Option<Input>,
}

/// The outcome of offering a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offer {
    /// The message was accepted.
    Accepted,
    /// The message was left out: repeated, late, or off the grid.
    LeftOut,
    /// Time went back: all earlier messages were dropped, and this one was accepted.
    WentBack,
}

/// Messages not yet passed on, and the state of the samples.
#[derive(Clone, Debug)]
pub struct Aligner {
    /// ns
    period: i64,
    /// A stamp on the grid, ns.
    origin: Option<i64>,
    /// The outputs by instant: (stamp, value). Outputs are kept for a while after they are passed on, to recognise repeats.
    outputs: ByInstant<(i64, f64)>,
    inputs: ByInstant<Input>,
    /// Inputs that are too old, unless time turns out to have gone back.
    old_inputs: VecDeque<(i64, Input)>,
    /// The last output, if it was too old, unless time turns out to have gone back.
    old_output: Option<(i64, f64)>,
    /// Number of consecutive outputs off the grid, and of consecutive inputs off the grid.
    off_grid: i64,
    inputs_off_grid: i64,
    newest_output: Option<i64>,
    /// The last input offered.
    last_input: Option<i64>,
    /// The first instant not yet passed on.
    next: i64,
    /// Whether the sample at `next` continues the previous one.
    continuing: bool,
    /// Whether the data has ended, so that the aligner no longer waits.
    finished: bool,
    answered: Option<i64>,
    /// Number of times that the newest output has arrived.
    repeats: u32,
}

impl Aligner {
    /// An aligner for a sampling interval in nanoseconds, at least 1.
    #[must_use]
    pub fn new(period: i64) -> Self {
        Self {
            period: period.max(1),
            origin: None,
            outputs: ByInstant::new(),
            inputs: ByInstant::new(),
            old_inputs: VecDeque::new(),
            old_output: None,
            off_grid: 0,
            inputs_off_grid: 0,
            newest_output: None,
            last_input: None,
            next: i64::MIN,
            continuing: false,
            finished: false,
            answered: None,
            repeats: 0,
        }
    }

    /// Offers the input over the interval that begins at `stamp` (ns).
    pub fn offer_input(&mut self, stamp: i64, input: Input) -> Offer {
        let Some(k) = self.instant(stamp) else {
            self.inputs_off_grid += 1;
            return Offer::LeftOut;
        };
        self.inputs_off_grid = 0;
        self.last_input = Some(k);
        if let Some(newest) = self.newest_output {
            if k < newest - WINDOW {
                self.old_inputs.push_back((stamp, input));
                if self.old_inputs.len() > WINDOW as usize {
                    self.old_inputs.pop_front();
                }
                return Offer::LeftOut;
            }
            if k > newest + WINDOW {
                return Offer::LeftOut;
            }
        }
        if k < self.next.saturating_sub(1) || self.inputs.get(k).is_some() {
            return Offer::LeftOut;
        }
        self.inputs.insert(k, input);
        if self.newest_output.is_none() && self.inputs.0.len() > WINDOW as usize {
            self.inputs.0.pop_front();
        }
        self.answer(k + 1);
        Offer::Accepted
    }

    /// Offers the output at `stamp` (ns).
    pub fn offer_output(&mut self, stamp: i64, output: f64) -> Offer {
        let Some(k) = self.instant(stamp) else {
            self.off_grid += 1;
            if self.off_grid < WINDOW {
                return Offer::LeftOut;
            }
            let newest = self.newest_output.and_then(|k| self.outputs.get(k));
            let went_back = newest.is_some_and(|(newest, _)| stamp < *newest);
            self.begin_anew(&[(stamp, output)]);
            return if went_back {
                Offer::WentBack
            } else {
                Offer::Accepted
            };
        };
        self.off_grid = 0;
        let before = self.old_output.take();
        if self.newest_output.is_some_and(|newest| k < newest - WINDOW) {
            let Some(before) = before else {
                self.old_output = Some((stamp, output));
                return Offer::LeftOut;
            };
            self.begin_anew(&[before, (stamp, output)]);
            return Offer::WentBack;
        }
        if k < self.next || self.outputs.get(k).is_some() {
            if self.newest_output == Some(k) {
                self.repeats += 1;
                self.answer(k);
            }
            return Offer::LeftOut;
        }
        self.outputs.insert(k, (stamp, output));
        if self.newest_output < Some(k) {
            self.newest_output = Some(k);
            self.repeats = 1;
        }
        self.answer(k);
        Offer::Accepted
    }

    /// Drops everything except these outputs and the inputs that may belong to these outputs.
    fn begin_anew(&mut self, outputs: &[(i64, f64)]) {
        let old_inputs = std::mem::take(&mut self.old_inputs);
        *self = Self::new(self.period);
        // The newest first: the grid is laid through it, and one of another time is left out.
        for (stamp, output) in outputs.iter().rev() {
            self.offer_output(*stamp, *output);
        }
        for (stamp, input) in old_inputs {
            self.offer_input(stamp, input);
        }
    }

    /// Number of intervals by which the outputs are ahead of the inputs; if one kind is missing, relative to the first stamp.
    #[must_use]
    pub fn outputs_ahead(&self) -> i64 {
        self.newest_output.unwrap_or(0) - self.last_input.unwrap_or(0)
    }

    /// Whether the inputs' stamps differ from the outputs' by a quarter interval or more.
    #[must_use]
    pub fn inputs_are_off_grid(&self) -> bool {
        self.inputs_off_grid >= WINDOW
    }

    /// The next sample in the order of stamps, once it is final.
    pub fn take(&mut self) -> Option<Sample> {
        let sample = self.settled();
        if let (None, Some(newest)) = (sample, self.newest_output) {
            // What is not settled lies within the window; the rest is kept to know repeats.
            let kept = newest - 2 * WINDOW..=newest + WINDOW;
            self.outputs.keep(&kept);
            self.inputs.keep(&kept);
        }
        sample
    }

    fn settled(&mut self) -> Option<Sample> {
        if self.continuing {
            let k = self.next;
            if let (Some(&(stamp, output)), Some(&input)) =
                (self.outputs.get(k), self.inputs.get(k - 1))
            {
                self.next = k + 1;
                return Some(Sample {
                    stamp,
                    output,
                    input: Some(input),
                });
            }
            if self.waits_at(k) {
                return None;
            }
            self.continuing = false;
        }
        let &(first, (stamp, output)) = self.outputs.first_from(self.next)?;
        if self.waits_at(first) {
            return None;
        }
        self.next = first + 1;
        self.continuing = true;
        Some(Sample {
            stamp,
            output,
            input: None,
        })
    }

    /// Whether a message missing at instant k may still come.
    fn waits_at(&self, k: i64) -> bool {
        !self.finished && self.newest_output.is_none_or(|newest| newest - k < WINDOW)
    }

    /// Ends the input; the remaining samples become available.
    pub fn finish(&mut self) {
        self.finished = true;
    }

    /// The latest output stamp (ns) for which all data promised by lockstep has arrived: the input over the interval before the output, unless the
    /// output at the beginning of that interval is missing. An output that has come [`MAX_REPEATS`] times counts as answered without its input, because
    /// no node can send that input any more.
    #[must_use]
    pub fn answered(&self) -> Option<i64> {
        self.answered
    }

    /// Records that the output at instant k is complete, if it is.
    fn answer(&mut self, k: i64) {
        let given_up = self.newest_output == Some(k) && self.repeats >= MAX_REPEATS;
        let waits_for_input =
            !given_up && self.outputs.get(k - 1).is_some() && self.inputs.get(k - 1).is_none();
        if let Some((stamp, _)) = self.outputs.get(k)
            && !waits_for_input
            && self.answered.is_none_or(|latest| latest < *stamp)
        {
            self.answered = Some(*stamp);
        }
    }

    /// The instant a stamp belongs to, `None` off the grid.
    fn instant(&mut self, stamp: i64) -> Option<i64> {
        let origin = *self.origin.get_or_insert(stamp);
        let offset = stamp.checked_sub(origin)?;
        let k = offset.checked_add(self.period / 2)?.div_euclid(self.period);
        let distance = (offset - k * self.period).abs();
        // Instants stay far enough from the ends of their type to be counted with.
        let countable = (-i64::MAX / 4..i64::MAX / 4).contains(&k);
        (countable && distance <= self.period / 4).then_some(k)
    }
}

/// Values by instant, in the order of time. The newest value is nearly always the one requested or added.
#[derive(Clone, Debug)]
struct ByInstant<T>(VecDeque<(i64, T)>);

impl<T> ByInstant<T> {
    fn new() -> Self {
        Self(VecDeque::new())
    }

    /// Number of instants before k.
    fn before(&self, k: i64) -> usize {
        let earlier = self.0.iter().rposition(|(instant, _)| *instant < k);
        earlier.map_or(0, |place| place + 1)
    }

    fn get(&self, k: i64) -> Option<&T> {
        let (instant, value) = self.first_from(k)?;
        (*instant == k).then_some(value)
    }

    /// The first instant not before k.
    fn first_from(&self, k: i64) -> Option<&(i64, T)> {
        self.0.get(self.before(k))
    }

    /// Adds a value for an instant that has none.
    fn insert(&mut self, k: i64, value: T) {
        self.0.insert(self.before(k), (k, value));
    }

    /// Drops values outside a range of instants. It does not visit the kept values, which are nearly all values.
    fn keep(&mut self, kept: &RangeInclusive<i64>) {
        while self.0.pop_front_if(|(k, _)| *k < *kept.start()).is_some() {}
        while self.0.pop_back_if(|(k, _)| *k > *kept.end()).is_some() {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: i64 = 50_000_000;
    /// The loop's stamps need not be multiples of the period.
    const START: i64 = 1_700_000_000_123_456_789;

    #[derive(Clone, Copy, Debug)]
    enum Message {
        Input(i64),
        Output(i64),
    }
    use Message::{Input as I, Output as O};

    fn stamp(k: i64) -> i64 {
        START + k * PERIOD
    }

    fn offer(aligner: &mut Aligner, message: Message) -> Offer {
        match message {
            I(k) => aligner.offer_input(stamp(k), Input::held(k as f64)),
            O(k) => aligner.offer_output(stamp(k), k as f64),
        }
    }

    /// (instant, whether an input leads to it) of every sample, taken as the messages come.
    fn samples(messages: &[Message]) -> Vec<(i64, bool)> {
        let mut aligner = Aligner::new(PERIOD);
        let mut samples = Vec::new();
        let mut take = |aligner: &mut Aligner| {
            while let Some(sample) = aligner.take() {
                let k = (sample.stamp - START) / PERIOD;
                assert_eq!(sample.output, k as f64);
                if let Some(input) = sample.input {
                    assert_eq!(input.mean, (k - 1) as f64);
                }
                samples.push((k, sample.input.is_some()));
            }
        };
        for message in messages {
            offer(&mut aligner, *message);
            take(&mut aligner);
            assert!(aligner.outputs.0.len() as i64 <= 2 * WINDOW + 1);
            assert!(aligner.inputs.0.len() as i64 <= 3 * WINDOW + 1);
        }
        aligner.finish();
        take(&mut aligner);
        samples
    }

    fn in_order(count: i64) -> Vec<Message> {
        (0..count).flat_map(|k| [O(k), I(k)]).collect()
    }

    fn whole(count: i64) -> Vec<(i64, bool)> {
        (0..count).map(|k| (k, k > 0)).collect()
    }

    #[test]
    fn each_output_comes_with_the_input_over_the_interval_before_it() {
        assert_eq!(samples(&in_order(100)), whole(100));
    }

    #[test]
    fn any_order_within_the_window_gives_the_same_samples() {
        let swapped: Vec<_> = (0..100).flat_map(|k| [I(k), O(k)]).collect();
        assert_eq!(samples(&swapped), whole(100));
        let late_inputs: Vec<_> = (0..100 + WINDOW / 2)
            .flat_map(|k| [O(k), I(k - WINDOW / 2)])
            .filter(|m| matches!(m, O(0..100) | I(0..100)))
            .collect();
        assert_eq!(samples(&late_inputs), whole(100));
        let mut reversed_in_blocks = in_order(100);
        for block in reversed_in_blocks.chunks_mut(14) {
            block.reverse();
        }
        assert_eq!(samples(&reversed_in_blocks), whole(100));
    }

    #[test]
    fn repeats_change_nothing() {
        let repeated: Vec<_> = in_order(100)
            .windows(6)
            .flat_map(|w| [w[5], w[0], w[3], w[0]])
            .collect();
        let mut messages = in_order(100);
        messages.truncate(6);
        messages.extend(repeated);
        assert_eq!(samples(&messages), whole(100));
    }

    #[test]
    fn after_a_gap_in_the_outputs_the_samples_begin_anew() {
        let messages: Vec<_> = in_order(100)
            .into_iter()
            .filter(|m| !matches!(m, O(40..45)))
            .collect();
        let expected: Vec<_> = whole(100)
            .into_iter()
            .filter(|(k, _)| !(40..45).contains(k))
            .map(|(k, led)| (k, led && k != 45))
            .collect();
        assert_eq!(samples(&messages), expected);
    }

    #[test]
    fn after_a_gap_in_the_inputs_the_samples_begin_anew() {
        let messages: Vec<_> = in_order(100)
            .into_iter()
            .filter(|m| !matches!(m, I(40..45)))
            .collect();
        let expected: Vec<_> = whole(100)
            .into_iter()
            .map(|(k, led)| (k, led && !(41..46).contains(&k)))
            .collect();
        assert_eq!(samples(&messages), expected);
    }

    #[test]
    fn once_running_a_sample_is_given_out_as_soon_as_it_is_whole() {
        let mut aligner = Aligner::new(PERIOD);
        for message in in_order(50) {
            offer(&mut aligner, message);
            while aligner.take().is_some() {}
        }
        assert_eq!(offer(&mut aligner, O(50)), Offer::Accepted);
        assert_eq!(aligner.take().unwrap().stamp, stamp(50));
    }

    #[test]
    fn time_going_back_begins_everything_anew_and_loses_nothing_of_the_new_time() {
        let mut messages = in_order(100);
        messages.push(I(0));
        messages.extend(in_order(100));
        let mut aligner = Aligner::new(PERIOD);
        let went_back: Vec<usize> = (0..messages.len())
            .filter(|i| offer(&mut aligner, messages[*i]) == Offer::WentBack)
            .collect();
        // Of the new time the second output says so.
        assert_eq!(went_back, vec![203]);
        let mut expected = whole(100);
        expected.extend(whole(100));
        assert_eq!(samples(&messages), expected);
    }

    #[test]
    fn a_stamp_off_the_grid_is_left_out() {
        let mut aligner = Aligner::new(PERIOD);
        assert_eq!(aligner.offer_output(stamp(0), 0.0), Offer::Accepted);
        assert_eq!(
            aligner.offer_output(stamp(1) + PERIOD / 3, 0.0),
            Offer::LeftOut
        );
        assert_eq!(
            aligner.offer_output(stamp(1) - PERIOD / 5, 0.0),
            Offer::Accepted
        );
    }

    #[test]
    fn one_straggler_is_left_out_and_time_goes_on() {
        let mut messages = in_order(100);
        messages.insert(120, O(3));
        messages.insert(160, O(5));
        assert_eq!(samples(&messages), whole(100));
    }

    #[test]
    fn a_publisher_started_again_off_the_grid_lays_another() {
        let mut aligner = Aligner::new(PERIOD);
        let mut taken = 0;
        for k in 0..100 {
            // From the fiftieth on a third of an interval later.
            let late = if k < 50 { 0 } else { PERIOD / 3 };
            let offer = aligner.offer_output(stamp(k) + late, k as f64);
            assert_eq!(offer == Offer::LeftOut, (50..50 + WINDOW - 1).contains(&k));
            aligner.offer_input(stamp(k) + late, Input::held(0.0));
            while aligner.take().is_some() {
                taken += 1;
            }
        }
        assert!(taken > 60, "{taken}");
    }

    #[test]
    fn who_has_fallen_silent_shows_in_how_far_the_others_are_ahead() {
        let mut aligner = Aligner::new(PERIOD);
        for message in in_order(50) {
            offer(&mut aligner, message);
        }
        assert_eq!(aligner.outputs_ahead(), 0);
        for k in 50..90 {
            offer(&mut aligner, O(k));
        }
        assert_eq!(aligner.outputs_ahead(), 40);
        for k in 90..150 {
            offer(&mut aligner, I(k));
        }
        assert_eq!(aligner.outputs_ahead(), -60);
        let mut alone = Aligner::new(PERIOD);
        for k in 0..30 {
            offer(&mut alone, I(k));
        }
        assert_eq!(alone.outputs_ahead(), -29);
    }

    #[test]
    fn stamps_from_the_far_ends_of_time_neither_break_nor_fill_anything() {
        let mut messages = in_order(30);
        messages.push(I(40_000_000_000));
        messages.extend((30..60).flat_map(|k| [O(k), I(k)]));
        assert_eq!(samples(&messages), whole(60));
        for first in [i64::MIN, 0, i64::MAX] {
            let mut aligner = Aligner::new(1);
            for stamp in [first, i64::MAX, i64::MIN, 0, -1, i64::MAX - 1] {
                aligner.offer_output(stamp, 0.0);
                aligner.offer_input(stamp, Input::default());
                while aligner.take().is_some() {}
            }
        }
    }

    #[test]
    fn a_lost_motion_is_waited_for_until_the_state_has_come_three_times() {
        let mut aligner = Aligner::new(PERIOD);
        let mut answered = |message| {
            offer(&mut aligner, message);
            while aligner.take().is_some() {}
            aligner.answered().map(|stamp| (stamp - START) / PERIOD)
        };
        for (message, answer) in [
            (O(0), Some(0)),
            (O(1), Some(0)), // the motion over 0 is lost
            (O(1), Some(0)),
            (I(0), Some(1)), // and said again
            (I(1), Some(1)),
            (O(2), Some(2)),
            (O(3), Some(2)), // that over 2 never comes
            (O(3), Some(2)),
            (O(3), Some(3)),
            (I(3), Some(3)),
            (O(4), Some(4)),
        ] {
            assert_eq!(answered(message), answer, "{message:?}");
        }
    }

    #[test]
    fn a_tick_is_answered_when_its_state_and_the_motion_before_it_have_come() {
        let mut aligner = Aligner::new(PERIOD);
        let mut answered = |message| {
            offer(&mut aligner, message);
            aligner.answered().map(|stamp| (stamp - START) / PERIOD)
        };
        for (message, answer) in [
            (I(6), None),
            (O(7), Some(7)), // the output at 6 was never seen: nothing to wait for
            (O(8), Some(7)),
            (I(7), Some(8)),
            (I(8), Some(8)),
            (O(9), Some(9)),
            (O(9), Some(9)),
            (I(9), Some(9)),
        ] {
            assert_eq!(answered(message), answer, "{message:?}");
        }
    }
}
