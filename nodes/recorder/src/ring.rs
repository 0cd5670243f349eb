//! The latest messages, kept in memory until a snapshot is requested.

use std::collections::VecDeque;
use std::mem;

use planesman_node::RawSample;

/// A message in memory.
#[derive(Debug)]
pub struct Kept {
    /// Index of the topic.
    pub index: usize,
    /// Payload with its metadata.
    pub sample: RawSample,
    /// Time of reception, ns.
    pub received: i64,
}

/// The latest messages within a limit of memory.
#[derive(Debug)]
pub struct Ring {
    messages: VecDeque<Kept>,
    /// Total size of the kept payloads, and its limit, bytes.
    bytes: u64,
    most: u64,
}

impl Ring {
    /// Keeps payloads of at most `most` bytes in total.
    #[must_use]
    pub fn new(most: u64) -> Self {
        Self {
            messages: VecDeque::new(),
            bytes: 0,
            most,
        }
    }

    /// Adds a message, and drops the oldest messages beyond the limit.
    pub fn keep(&mut self, message: Kept) {
        self.bytes += message.sample.bytes.len() as u64;
        self.messages.push_back(message);
        while self.bytes > self.most
            && let Some(oldest) = self.messages.pop_front()
        {
            self.bytes -= oldest.sample.bytes.len() as u64;
        }
    }

    /// Removes and returns all messages, oldest first.
    pub fn take(&mut self) -> VecDeque<Kept> {
        self.bytes = 0;
        mem::take(&mut self.messages)
    }
}

#[cfg(test)]
mod tests {
    use planesman_msgs::builtin_interfaces::msg::Time;

    use super::*;

    fn message(index: usize, bytes: usize) -> Kept {
        Kept {
            index,
            sample: RawSample {
                topic: String::new(),
                bytes: vec![0; bytes],
                published: None,
                received: Time::default(),
                sequence: 0,
                publisher: [0; 16],
            },
            received: 0,
        }
    }

    #[test]
    fn the_latest_that_fit_are_kept_and_handed_out_once() {
        let mut ring = Ring::new(100);
        for index in 0..7 {
            ring.keep(message(index, 30));
        }
        let kept: Vec<_> = ring.take().iter().map(|it| it.index).collect();
        assert_eq!(kept, [4, 5, 6]);
        assert!(ring.take().is_empty());
        ring.keep(message(7, 101));
        ring.keep(message(8, 100));
        assert_eq!(ring.take().len(), 1);
    }
}
