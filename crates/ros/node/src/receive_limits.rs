//! Limits of the received messages that a node stores.
//!
//! Unhandled messages wait in the middleware, within a budget of bytes; beyond it the oldest are dropped. A message larger than the node needs
//! is refused with its first packet. Large messages are handled one at a time, for at most half of the node's time.

use std::{
    cell::{Cell, RefCell},
    fs,
    rc::Rc,
    task::{Context, Poll, Waker},
    time::{Duration, Instant},
};

use futures::{FutureExt as _, Stream, StreamExt as _, ready};
use smol::Timer;

/// Size above which a message is large, bytes; the others then wait in the middleware until it is handled.
const LARGE: usize = 256 * 1024;

/// Largest request of a service, bytes.
const REQUEST: usize = 64 * 1024;

/// Limits of what a node receives.
#[derive(Clone, Copy, Debug)]
pub struct ReceiveLimits {
    /// Size of messages waiting in the middleware, bytes; the same amount again may wait for missing packets.
    pub budget: usize,
    /// Largest message of a topic, bytes, by its DDS name.
    pub(crate) largest: fn(&str) -> usize,
}

impl ReceiveLimits {
    /// Limits for a node with messages of the loop, or messages of similar size.
    #[must_use]
    pub fn small() -> Self {
        Self {
            budget: 32 << 20,
            largest: |topic| {
                if is_request(topic) {
                    REQUEST
                } else {
                    256 << 10
                }
            },
        }
    }

    /// Limits for a node that accepts any message that fits the budget.
    #[must_use]
    pub fn any(budget: usize) -> Self {
        Self {
            budget,
            largest: |topic| {
                if is_request(topic) {
                    REQUEST
                } else {
                    usize::MAX
                }
            },
        }
    }
}

fn is_request(topic: &str) -> bool {
    topic.starts_with("rq/")
}

/// Passes large messages one at a time.
#[derive(Debug, Default)]
pub(crate) struct Gate {
    is_closed: Cell<bool>,
    /// Time at which a stream that had a large message continues.
    next: Cell<Option<Instant>>,
    waiting: RefCell<Vec<Waker>>,
}

/// Guard of a large message; its handling ends when this is dropped.
#[derive(Debug)]
pub(crate) struct LargeMessage {
    gate: Rc<Gate>,
    began: Instant,
    waited_for_core: Duration,
}

/// Time for which this thread was ready to run while other programs used the cores.
fn waited_for_core() -> Duration {
    let statistics = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let waited = statistics.split_whitespace().nth(1);
    Duration::from_nanos(waited.and_then(|it| it.parse().ok()).unwrap_or(0))
}

impl Drop for LargeMessage {
    fn drop(&mut self) {
        let now = Instant::now();
        let gate = &self.gate;
        // Without the time of other programs: on a busy machine the messages of this one would come faster than they go.
        let took = now
            .duration_since(self.began)
            .saturating_sub(waited_for_core().saturating_sub(self.waited_for_core));
        gate.next.set(now.checked_add(took));
        gate.is_closed.set(false);
        gate.waiting.take().into_iter().for_each(Waker::wake);
    }
}

impl Gate {
    /// Takes no sample of `samples` while a large message of any stream is handled; after a large message of its own, for the same time again. `size`
    /// returns bytes.
    pub(crate) fn guard<T>(
        self: &Rc<Self>,
        mut samples: impl Stream<Item = T> + Unpin,
        size: impl Fn(&T) -> usize,
    ) -> impl Stream<Item = (T, Option<LargeMessage>)> {
        let gate = Rc::clone(self);
        let (mut was_large, mut pause) = (false, None);
        futures::stream::poll_fn(move |context: &mut Context<'_>| {
            if gate.is_closed.get() {
                let mut waiting = gate.waiting.borrow_mut();
                if !waiting.iter().any(|it| it.will_wake(context.waker())) {
                    waiting.push(context.waker().clone());
                }
                return Poll::Pending;
            }
            if was_large && let Some(next) = gate.next.get() {
                let pause = pause.get_or_insert_with(|| Timer::at(next));
                ready!(pause.poll_unpin(context));
            }
            pause = None;
            let began = Instant::now();
            let sample = ready!(samples.poll_next_unpin(context));
            was_large = sample.as_ref().is_some_and(|it| size(it) > LARGE);
            let large = was_large.then(|| {
                gate.is_closed.set(true);
                LargeMessage {
                    gate: Rc::clone(&gate),
                    began,
                    waited_for_core: waited_for_core(),
                }
            });
            Poll::Ready(sample.map(|it| (it, large)))
        })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use futures::stream;

    use super::*;

    #[test]
    fn a_large_message_keeps_those_of_all_streams_waiting() {
        let gate = Rc::new(Gate::default());
        let mut large = gate.guard(stream::iter([LARGE + 1, 10]), |size| *size);
        let mut small = gate.guard(stream::iter([1, 2]), |size| *size);
        let (first, held) = large.next().now_or_never().flatten().expect("open");
        assert_eq!(first, LARGE + 1);
        assert!(large.next().now_or_never().is_none());
        assert!(small.next().now_or_never().is_none());
        std::thread::sleep(Duration::from_millis(20));
        drop(held);
        let (next, held) = small.next().now_or_never().flatten().expect("open again");
        assert_eq!(next, 1);
        assert!(held.is_none());
        assert!(small.next().now_or_never().flatten().is_some());
        // After a pause as long as that took.
        assert!(large.next().now_or_never().is_none());
        assert!(smol::block_on(large.next()).is_some());
    }

    #[test]
    fn requests_are_small_whatever_the_node_takes() {
        for receive_limits in [ReceiveLimits::small(), ReceiveLimits::any(1 << 30)] {
            assert_eq!((receive_limits.largest)("rq/auv/sysid/fitRequest"), REQUEST);
            assert!((receive_limits.largest)("rt/auv/state") > REQUEST);
        }
    }
}
