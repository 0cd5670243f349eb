//! Counts missing messages of a topic from the publishers' sequence numbers.

use std::collections::BTreeMap;

/// Maximum number of publishers; if a (hostile) peer exceeds it, counting starts again.
const PUBLISHERS: usize = 1000;

/// Count of one topic.
#[derive(Clone, Debug, Default)]
pub struct Losses {
    /// Lowest and highest sequence number, by publisher.
    spans: BTreeMap<[u8; 16], (i64, i64)>,
    /// Sequence numbers without a message, minus repeated messages.
    missing: i64,
}

impl Losses {
    /// Records a message with this sequence number of the publisher, in any order.
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

    /// Number of missing messages.
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
