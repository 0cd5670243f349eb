//! How many messages of a topic are missing between those that came, by the numbers that publishers give them.

use std::collections::BTreeMap;

/// Publishers that are told apart; of more, as of a hostile peer's, the account begins anew.
const PUBLISHERS: usize = 1000;

/// The account of one topic.
#[derive(Clone, Debug, Default)]
pub struct Losses {
    /// The least and greatest number by publisher.
    spans: BTreeMap<[u8; 16], (i64, i64)>,
    /// Numbers between them without a message, minus messages that came twice.
    missing: i64,
}

impl Losses {
    /// Notes that the publisher's message with that number has come, in any order.
    pub fn received(&mut self, publisher: [u8; 16], sequence: i64) {
        if self.spans.len() >= PUBLISHERS && !self.spans.contains_key(&publisher) {
            self.spans.clear();
        }
        let width = |(first, last): (i64, i64)| last.saturating_sub(first);
        let Some(span) = self.spans.get_mut(&publisher) else {
            self.spans.insert(publisher, (sequence, sequence));
            return;
        };
        let before = width(*span);
        *span = (span.0.min(sequence), span.1.max(sequence));
        let new = width(*span).saturating_sub(before);
        self.missing = self.missing.saturating_add(new.saturating_sub(1));
    }

    /// Messages that are missing.
    #[must_use]
    pub fn missing(&self) -> u64 {
        u64::try_from(self.missing).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_of_each_publisher_count_whatever_the_order() {
        let mut losses = Losses::default();
        for sequence in [7, 8, 10, 9, 12] {
            losses.received([1; 16], sequence);
        }
        assert_eq!(losses.missing(), 1, "number 11");
        losses.received([2; 16], 100);
        losses.received([2; 16], 103);
        assert_eq!(losses.missing(), 3);
        losses.received([1; 16], 11);
        assert_eq!(losses.missing(), 2);
        losses.received([3; 16], i64::MIN);
        losses.received([3; 16], i64::MAX);
        losses.received([4; 16], 1);
        assert!(losses.missing() > 1 << 60);
    }
}
