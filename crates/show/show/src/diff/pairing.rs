//! Pairing of the messages of a topic in two recordings.
//!
//! Messages with equal stamps are paired in recorded order. If several messages have the same stamp, messages with equal bytes are paired first,
//! because the order of several publishers depends on the recorder. Messages of a topic without stamps are paired by index.

use std::collections::{BTreeSet, VecDeque};

/// Position of a message in time. A clock that goes back by more than a second, for example after a restart of the loop, begins a new epoch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Key {
    epoch: u32,
    pub(crate) stamp: i64,
}

const A_SECOND: i64 = 1_000_000_000;

impl Key {
    /// The key of the topic's next message, with this stamp.
    fn then(self, stamp: i64) -> Self {
        let is_back = stamp < self.stamp.saturating_sub(A_SECOND);
        Self {
            epoch: self.epoch + u32::from(is_back),
            stamp,
        }
    }
}

/// Assigns keys to the messages of one topic in one recording.
#[derive(Default)]
struct Keys {
    last: Key,
    /// Number of messages without a stamp, of a type that has one.
    unstamped: i64,
}

impl Keys {
    /// The key of the next message with this stamp. Stamp 0 may mean that a publisher sets no stamp; such messages are distinguished by index. The first
    /// messages may have the time 0 and come from several publishers.
    fn next(&mut self, mut stamp: i64) -> Key {
        if stamp == 0 {
            stamp = (self.unstamped - LATE as i64).max(0);
            self.unstamped += 1;
        }
        self.last = self.last.then(stamp);
        self.last
    }
}

/// Sorts a topic's messages by stamp, and messages with the same stamp by their bytes, without duplicates. The order does not depend on which of
/// several publishers the recorder received first.
#[derive(Default)]
pub struct CanonicalOrder {
    keys: Keys,
    held: BTreeSet<(Key, Vec<u8>)>,
}

impl CanonicalOrder {
    /// Adds the next recorded message, and gives `take` the payloads that no later message can precede.
    pub fn push(&mut self, stamp: i64, payload: Vec<u8>, mut take: impl FnMut(&[u8])) {
        self.held.insert((self.keys.next(stamp), payload));
        while self.held.len() > LATE {
            if let Some((_, payload)) = self.held.pop_first() {
                take(&payload);
            }
        }
    }

    /// Passes on the remaining messages.
    pub fn end(self, mut take: impl FnMut(&[u8])) {
        for (_, payload) in self.held {
            take(&payload);
        }
    }
}

/// A message without a partner so far.
#[derive(Clone, Debug)]
pub(crate) struct Waiting {
    pub(crate) key: Key,
    /// Index in its recording, over all topics.
    pub(crate) number: u64,
    pub(crate) payload: Vec<u8>,
    /// Messages with later stamps came before this message.
    pub(crate) is_late: bool,
}

/// Result of pairing.
pub(crate) enum Outcome {
    /// Two messages that belong together.
    Pair {
        a: Waiting,
        b: Waiting,
        is_same: bool,
        /// Another message with this stamp or a later stamp comes before this one in only one of the recordings.
        is_reordered: bool,
    },
    /// A message only in the recording of this index; `is_repeat`: it repeats an earlier message.
    Only {
        side: usize,
        message: Waiting,
        is_repeat: bool,
    },
}

/// Pairing of one topic's messages.
#[derive(Default)]
pub(crate) struct Pairing {
    queues: [VecDeque<Waiting>; 2],
    has_ended: [bool; 2],
    keys: [Keys; 2],
    is_keyed: bool,
    /// The last payloads, to recognise a repeated one.
    recent: VecDeque<Vec<u8>>,
}

/// Number of recent messages among which a repeated one is recognised: in lockstep the messages of a tick are sent again.
const RECENT: usize = 16;

/// Number of messages by which a message may be late: the messages of each publisher are in order, but the order between publishers depends on the recorder.
const LATE: usize = 16;

/// Largest payload that is remembered, bytes.
const LARGE: usize = 1 << 16;

/// Number of messages with the same stamp among which equal messages are searched.
const GROUP: usize = 256;

impl Pairing {
    pub(crate) fn new(is_keyed: bool) -> Self {
        Self {
            is_keyed,
            ..Self::default()
        }
    }

    /// The key of the next message of one recording, with this stamp.
    pub(crate) fn key(&mut self, side: usize, stamp: i64) -> Key {
        self.keys[side].next(stamp)
    }

    /// Adds the next message of one recording, after those of the same and of earlier stamps.
    pub(crate) fn push(&mut self, side: usize, mut message: Waiting) {
        let queue = &mut self.queues[side];
        let later = (queue.iter().rev().take(LATE)).take_while(|it| it.key > message.key);
        let place = queue.len() - if self.is_keyed { later.count() } else { 0 };
        message.is_late = place < queue.len();
        queue.insert(place, message);
    }

    /// Records that no more messages come from this recording.
    pub(crate) fn end(&mut self, side: usize) {
        self.has_ended[side] = true;
    }

    /// Gives `take` all outcomes that later messages cannot change.
    pub(crate) fn advance(&mut self, take: &mut dyn FnMut(&Outcome)) {
        loop {
            let alone = match [0, 1].map(|side| self.queues[side].front()) {
                [Some(a), Some(b)] => {
                    let is_same = same(&a.payload, &b.payload);
                    if is_same || !self.is_keyed {
                        self.pair(is_same, take);
                        continue;
                    }
                    // One that is late may still be the other's partner.
                    let is_settled =
                        |side: usize| self.has_ended[side] || self.queues[side].len() > LATE;
                    if !(is_settled(0) && is_settled(1)) {
                        return;
                    }
                    let key = a.key;
                    match key.cmp(&b.key) {
                        std::cmp::Ordering::Less => 0,
                        std::cmp::Ordering::Greater => 1,
                        std::cmp::Ordering::Equal => {
                            match [0, 1].map(|side| self.group(side, key)) {
                                [Some(a), Some(b)] => self.pair_group([a, b], take),
                                _ => return,
                            }
                            continue;
                        }
                    }
                }
                [Some(_), None] if self.has_ended[1] => 0,
                [None, Some(_)] if self.has_ended[0] => 1,
                _ => return,
            };
            if let Some(message) = self.queues[alone].pop_front() {
                self.only(alone, message, take);
            }
        }
    }

    fn pair(&mut self, is_same: bool, take: &mut dyn FnMut(&Outcome)) {
        if let [Some(a), Some(b)] = [0, 1].map(|side| self.queues[side].pop_front()) {
            let is_reordered = a.is_late != b.is_late;
            self.hand(
                Outcome::Pair {
                    a,
                    b,
                    is_same,
                    is_reordered,
                },
                take,
            );
        }
    }

    fn only(&mut self, side: usize, message: Waiting, take: &mut dyn FnMut(&Outcome)) {
        let is_repeat = self.is_repeat(&message);
        self.hand(
            Outcome::Only {
                side,
                message,
                is_repeat,
            },
            take,
        );
    }

    /// Whether a message repeats an earlier one; only for topics whose messages contain a stamp.
    fn is_repeat(&self, message: &Waiting) -> bool {
        let mut recent = self.recent.iter();
        self.is_keyed && recent.any(|it| same(it, &message.payload))
    }

    /// Passes on an outcome and remembers its payloads.
    fn hand(&mut self, outcome: Outcome, take: &mut dyn FnMut(&Outcome)) {
        take(&outcome);
        let payloads = match outcome {
            Outcome::Pair { a, b, is_same, .. } => [Some(a), (!is_same).then_some(b)],
            Outcome::Only {
                message, is_repeat, ..
            } => [(!is_repeat).then_some(message), None],
        };
        let payloads = payloads.into_iter().flatten().map(|it| it.payload);
        for payload in payloads.filter(|it| self.is_keyed && it.len() <= LARGE) {
            if self.recent.len() == RECENT {
                self.recent.pop_front();
            }
            self.recent.push_back(payload);
        }
    }

    /// Number of messages of this key at the head of a queue; `None` while more may come.
    fn group(&self, side: usize, key: Key) -> Option<usize> {
        let queue = &self.queues[side];
        let end = queue.iter().position(|it| it.key != key);
        end.or_else(|| self.has_ended[side].then_some(queue.len()))
    }

    /// Pairs the messages with the same stamp: first messages with equal bytes, then the others in order.
    fn pair_group(&mut self, [in_a, in_b]: [usize; 2], take: &mut dyn FnMut(&Outcome)) {
        let a: Vec<Waiting> = self.queues[0].drain(..in_a).collect();
        let mut b: Vec<Waiting> = self.queues[1].drain(..in_b).collect();
        let mut rest = Vec::new();
        for a in a {
            let found = (b.iter().take(GROUP)).position(|it| same(&it.payload, &a.payload));
            let Some(at) = found else {
                rest.push(a);
                continue;
            };
            let pair = Outcome::Pair {
                is_reordered: at > 0 || !rest.is_empty() || a.is_late != b[at].is_late,
                a,
                b: b.remove(at),
                is_same: true,
            };
            self.hand(pair, take);
        }
        // One that is repeated is not the partner of another.
        let (again, b): (Vec<_>, Vec<_>) = b.into_iter().partition(|it| self.is_repeat(it));
        let (a_again, rest): (Vec<_>, Vec<_>) = rest.into_iter().partition(|it| self.is_repeat(it));
        for (side, message) in
            (a_again.into_iter().map(|it| (0, it))).chain(again.into_iter().map(|it| (1, it)))
        {
            self.only(side, message, take);
        }
        let (mut rest, mut b) = (rest.into_iter(), b.into_iter());
        loop {
            let pair = match (rest.next(), b.next()) {
                (Some(a), Some(b)) => Outcome::Pair {
                    a,
                    b,
                    is_same: false,
                    is_reordered: false,
                },
                (Some(a), None) => {
                    self.only(0, a, take);
                    continue;
                }
                (None, Some(b)) => {
                    self.only(1, b, take);
                    continue;
                }
                (None, None) => return,
            };
            self.hand(pair, take);
        }
    }
}

/// Whether payloads have equal bytes, ignoring the header's options and the up to three bytes that DDS adds to fill whole words.
pub(crate) fn same(a: &[u8], b: &[u8]) -> bool {
    let (short, long) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    let (head, fill) = long.split_at(short.len());
    if fill.len() > 3 || fill.iter().any(|it| *it != 0) {
        return false;
    }
    head == short || (short.len() > 4 && head[..2] == short[..2] && head[4..] == short[4..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_the_time_zero_the_order_of_two_publishers_is_no_difference() {
        let mut pairing = Pairing::new(true);
        for (side, order) in [(0, [1, 2]), (1, [2, 1])] {
            let stamps = [0, 0, 50_000_000]
                .into_iter()
                .zip(order.into_iter().chain([3]));
            for (number, (stamp, payload)) in stamps.enumerate() {
                let message = Waiting {
                    key: pairing.key(side, stamp),
                    number: number as u64,
                    payload: vec![payload; 8],
                    is_late: false,
                };
                pairing.push(side, message);
            }
            pairing.end(side);
        }
        let mut same = 0;
        pairing.advance(&mut |outcome| {
            assert!(matches!(outcome, Outcome::Pair { is_same: true, .. }));
            same += 1;
        });
        assert_eq!(same, 3);
    }
}
