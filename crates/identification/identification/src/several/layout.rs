//! Channels, each from one input to the output, and the place of every unknown in theta.
//!
//! ```text
//!                       Bi(q)
//! y_k = sum  q^-di  *  ------ u_i,k  +  offset  +  noise_k
//!        i              Ai(q)
//! ```
//! Each channel has its own order and delay; the offset of each record and the initial motion of every channel are also estimated.

use std::ops::Range;

use crate::structure::{InitialState, Structure};

/// A channel: an input and the structure of its effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The input's number.
    pub input: usize,
    /// Order, numerator and delay; a channel has no offset.
    pub structure: Structure,
}

impl Channel {
    /// A channel with an order and a delay: as many numerator coefficients as poles, one more with direct feedthrough, one for a static
    /// gain.
    pub(super) fn new(input: usize, order: usize, delay: usize, start: InitialState) -> Self {
        let at_once = usize::from(delay == 0 && order > 0);
        Self {
            input,
            structure: Structure {
                numerator: (order + at_once).max(1),
                delay,
                offset: false,
                start,
                ..Structure::of_order(order)
            },
        }
    }

    /// Its poles.
    #[must_use]
    pub fn order(&self) -> usize {
        self.structure.poles
    }

    /// Its delay, samples.
    #[must_use]
    pub fn delay(&self) -> usize {
        self.structure.delay
    }

    /// The number of poles, numerator coefficients and the delay, which is chosen too.
    pub(super) fn parameters(&self) -> usize {
        self.structure.poles + self.structure.numerator + 1
    }
}

/// The place of each unknown in theta: `[a, b of each channel, offset of each record, motions of each record]`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) channels: Vec<Channel>,
    pub(super) offset: bool,
    pub(super) runs: usize,
}

impl Layout {
    /// `a1 ... an` of a channel.
    pub(super) fn a(&self, channel: usize) -> Range<usize> {
        let before = self.channels[..channel].iter();
        let first = before
            .map(|it| it.structure.poles + it.structure.numerator)
            .sum();
        first..first + self.channels[channel].structure.poles
    }

    /// `b1 ... bm` of a channel.
    pub(super) fn b(&self, channel: usize) -> Range<usize> {
        let first = self.a(channel).end;
        first..first + self.channels[channel].structure.numerator
    }

    fn of_channels(&self) -> usize {
        match self.channels.len() {
            0 => 0,
            count => self.b(count - 1).end,
        }
    }

    /// The offset of a record.
    pub(super) fn offset(&self, run: usize) -> Option<usize> {
        self.offset.then(|| self.of_channels() + run)
    }

    /// The initial motion of a channel in a record.
    pub(super) fn motion(&self, run: usize, channel: usize) -> Range<usize> {
        let of = |it: &Channel| match it.structure.start {
            InitialState::Rest => 0,
            InitialState::Estimated => it.structure.poles,
        };
        let all: usize = self.channels.iter().map(of).sum();
        let before: usize = self.channels[..channel].iter().map(of).sum();
        let first = self.of_channels() + usize::from(self.offset) * self.runs + run * all + before;
        first..first + of(&self.channels[channel])
    }

    /// All unknowns.
    pub(super) fn count(&self) -> usize {
        match (self.channels.len(), self.runs) {
            (0, _) => usize::from(self.offset) * self.runs,
            (channels, runs) => self.motion(runs - 1, channels - 1).end,
        }
    }

    /// The number of first outputs of a record that depend on unknown inputs, given the known past of each input.
    pub(super) fn unknown(&self, past: &[Vec<f64>]) -> usize {
        let known = |input: usize| past.get(input).map_or(0, Vec::len);
        let each = self.channels.iter();
        each.map(|it| it.structure.unknown(known(it.input)))
            .max()
            .unwrap_or_default()
    }

    /// The places of the unknowns that affect a record's output.
    pub(super) fn places(&self, run: usize) -> Vec<usize> {
        let channels = 0..self.channels.len();
        let of_channels = channels.clone().flat_map(|it| self.a(it).chain(self.b(it)));
        let motions = channels.flat_map(|it| self.motion(run, it));
        of_channels.chain(self.offset(run)).chain(motions).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unknown_has_a_place_of_its_own() {
        for start in [InitialState::Estimated, InitialState::Rest] {
            let channel = |input, order, delay| Channel::new(input, order, delay, start);
            let layout = Layout {
                channels: vec![channel(0, 2, 0), channel(2, 0, 3), channel(1, 1, 1)],
                offset: true,
                runs: 2,
            };
            let mut places = [layout.places(0), layout.places(1)].concat();
            places.sort_unstable();
            places.dedup();
            assert_eq!(places, (0..layout.count()).collect::<Vec<_>>());
        }
    }
}
