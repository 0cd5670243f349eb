//! How many bytes of received messages a node holds.
//!
//! What nobody has handled yet waits in the middleware, within a budget of bytes; beyond it the oldest go. A message that is
//! larger than the node has a use for is refused with its first packet. Large messages are handled one at a time, and take
//! half of the node's time at most.

use std::{
    cell::{Cell, RefCell},
    fs,
    rc::Rc,
    task::{Context, Poll, Waker},
    time::{Duration, Instant},
};

use futures::{FutureExt as _, Stream, StreamExt as _, ready};
use smol::Timer;

/// A larger message keeps the others waiting in the middleware until it is handled.
const LARGE: usize = 256 * 1024;

/// Largest request to a service.
const REQUEST: usize = 64 * 1024;

/// What a node receives.
#[derive(Clone, Copy, Debug)]
pub struct ReceiveLimits {
    /// Bytes of messages that wait in the middleware; as many again may wait for the rest of their packets.
    pub budget: usize,
    /// Largest message of a topic, by its name in DDS.
    pub(crate) largest: fn(&str) -> usize,
}

impl ReceiveLimits {
    /// For a node whose messages are the loop's, or as small.
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

    /// For a node that takes any message which the budget holds.
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

/// Lets large messages through one at a time.
#[derive(Debug, Default)]
pub(crate) struct Gate {
    is_closed: Cell<bool>,
    /// A stream that had a large message goes on then.
    next: Cell<Option<Instant>>,
    waiting: RefCell<Vec<Waker>>,
}

/// The handling of a large message, which ends when this is dropped.
#[derive(Debug)]
pub(crate) struct LargeMessage {
    gate: Rc<Gate>,
    began: Instant,
    waited_for_core: Duration,
}

/// How long this thread has been ready to run while other programs had the cores.
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
    /// Takes nothing of `samples` while a large one, of any stream, is handled; after a large one of its own, for as long
    /// again. `size` gives bytes.
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
