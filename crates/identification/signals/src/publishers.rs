//! Finds which of several publishers of a topic sent a message, if the bag shows it: by its channel, and by the sequence numbers of each
//! publisher.
//!
//! Messages of one publisher have consecutive numbers; with two publishers, each continues its own numbers. A skipped number that comes late belongs
//! to the publisher that skipped it. Recorders without sequence numbers write 0.

use std::collections::VecDeque;

use planesman_decode::FieldPath;
use planesman_decode::path::Step;

use crate::error::{Result, SourceError};
use crate::signal::Signal;

/// Maximum number of distinguished publishers of a topic, and of numbers that may still come late.
const MOST: usize = 32;
const LATE: usize = 64;

/// A publisher must have at least this many messages and this share of all messages, and the topic must return to this publisher at least this often.
const FEWEST: u64 = 10;
const SHARE: f64 = 0.02;

/// The publishers of one topic, numbered in the order of appearance.
#[derive(Clone, Debug, Default)]
pub struct Publishers {
    list: Vec<Publisher>,
}

#[derive(Clone, Debug)]
struct Publisher {
    channel: u16,
    /// The latest sequence number and its time, ns.
    number: u32,
    time: i64,
    /// The usual time between two messages, ns; 0 before it is known.
    interval: f64,
    /// Skipped numbers.
    passed: VecDeque<u32>,
}

impl Publisher {
    fn goes_on(&mut self, number: u32, time: i64) {
        let interval = time.saturating_sub(self.time) as f64;
        self.interval += 0.1 * (interval - self.interval);
        (self.number, self.time) = (number, time);
    }
}

impl Publishers {
    /// The publisher, from 1, of a message with that number on the channel, received at that time.
    pub fn of(&mut self, channel: u16, number: u32, time: i64) -> usize {
        // Nearly all messages are of a topic with one publisher, and none is lost.
        if let [one] = &mut self.list[..]
            && one.channel == channel
            && one.passed.is_empty()
            && (number == one.number.wrapping_add(1) || (number, one.number) == (0, 0))
        {
            one.goes_on(number, time);
            return 1;
        }
        let here = || {
            self.list
                .iter()
                .enumerate()
                .filter(|it| it.1.channel == channel)
        };
        let late = here().find(|it| it.1.passed.contains(&number));
        if let Some((place, _)) = late {
            self.list[place].passed.retain(|it| *it != number);
            return place + 1;
        }
        // No number at all, or the one that goes on with least between; of two, that whose time it is.
        let ahead = |it: &Publisher| match (it.number, number) {
            (0, 0) => Some(0),
            (before, number) => number.checked_sub(before)?.checked_sub(1),
        };
        let early = |it: &Publisher| ((time.saturating_sub(it.time)) as f64 - it.interval).abs();
        let next = here()
            .filter_map(|(place, it)| Some((ahead(it)?, early(it), place)))
            .min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let is_full = self.list.len() == MOST;
        let place = match next {
            Some((_, _, place)) => place,
            None if is_full => return MOST,
            None => {
                self.list.push(Publisher {
                    channel,
                    number,
                    time,
                    interval: 0.0,
                    passed: VecDeque::new(),
                });
                return self.list.len();
            }
        };
        let it = &mut self.list[place];
        for passed in (it.number.saturating_add(1)..number).rev().take(LATE) {
            it.passed.push_back(passed);
        }
        let spare = it.passed.len().saturating_sub(LATE);
        it.passed.drain(..spare);
        it.goes_on(number, time);
        place + 1
    }

    /// The path without its prefix `[publisher=2]`, and the selected publisher.
    pub(crate) fn chosen(path: &FieldPath) -> (FieldPath, Option<usize>) {
        let Some((Step::Named(name), steps)) = path.steps.split_first() else {
            return (path.clone(), None);
        };
        match name.strip_prefix("publisher=").map(str::parse) {
            Some(Ok(number)) => {
                let steps = steps.to_vec();
                (FieldPath { steps }, Some(number))
            }
            _ => (path.clone(), None),
        }
    }
}

/// The publishers of a signal's messages.
#[derive(Clone, Debug, Default)]
pub struct Senders {
    /// The number of messages of each publisher, from 1.
    counts: Vec<u64>,
    last: usize,
    /// Number of times that a publisher has sent again after another.
    returns: u64,
}

impl Senders {
    /// Takes a message that has the signal.
    pub fn take(&mut self, publisher: usize) {
        if publisher > self.counts.len() {
            self.counts.resize(publisher, 0);
        }
        let Some(count) = self.counts.get_mut(publisher.wrapping_sub(1)) else {
            return;
        };
        // A publisher that is started again counts anew: none comes back then.
        self.returns += u64::from(*count > 0 && self.last != publisher);
        *count += 1;
        self.last = publisher;
    }

    /// The publishers that alternate, with the number of messages of each; empty if there is only one.
    #[must_use]
    pub fn in_turn(&self) -> Vec<(usize, u64)> {
        let all: u64 = self.counts.iter().sum();
        let is_one = |count: u64| count >= FEWEST && count as f64 >= SHARE * all as f64;
        let list: Vec<(usize, u64)> = (1..)
            .zip(self.counts.iter().copied())
            .filter(|it| is_one(it.1))
            .collect();
        match list.len() > 1 && self.returns >= FEWEST {
            true => list,
            false => Vec::new(),
        }
    }

    /// Checks that the signal comes from one publisher.
    ///
    /// # Errors
    /// If it alternates between publishers, with the signals to choose from, or if the chosen publisher sends nothing.
    pub(crate) fn judge(&self, signal: &Signal, chosen: Option<usize>) -> Result<()> {
        let topic = signal.topic();
        let (path, _) = Publishers::chosen(signal.path());
        let several = self.in_turn();
        let listed = several.iter().map(|(publisher, count)| {
            let path = path.choosing(0, &format!("publisher={publisher}"));
            format!("'{topic}:{path}' ({count} messages)")
        });
        let listed = listed.collect::<Vec<_>>().join(" or ");
        match chosen {
            Some(chosen) if chosen == 0 || chosen > self.counts.len() => {
                let all = match several.is_empty() {
                    true => format!("'{topic}:{path}'"),
                    false => listed,
                };
                Err(SourceError::Request(format!(
                    "{signal}: the bag shows no publisher {chosen} of {topic}. Choose one of {all}"
                )))
            }
            None if !several.is_empty() => Err(SourceError::Request(format!(
                "{signal}: the messages come from different publishers in turn ({} changes, by their channels or numbers), so the signal mixes several sources. Choose one: {listed}",
                self.returns
            ))),
            _ => Ok(()),
        }
    }
}
