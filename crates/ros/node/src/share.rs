//! Limit of the node's time spent on requests, so that no client can use it all.
//!
//! Requests of services and actions are handled one at a time, in order of arrival. After a long request the next one begins only after
//! [`PAUSES`] times its duration: requests use at most a fifth of the node's thread, messages and timers the rest. Waiting requests stay in the
//! middleware, up to a thousand per service; a newer one displaces the oldest.

use std::{
    cell::Cell,
    rc::Rc,
    sync::Arc,
    time::{Duration, Instant},
};

use smol::{
    Timer,
    lock::{Mutex, MutexGuardArc},
};

/// Pause after a request, as a multiple of its duration.
const PAUSES: u32 = 4;

/// Longest pause after a request.
const LONGEST_PAUSE: Duration = Duration::from_millis(500);

/// The queue of requests, and the time at which the next one may begin.
#[derive(Debug, Default)]
pub(crate) struct Share {
    /// A fair lock: the longest waiting request is next.
    order: Arc<Mutex<()>>,
    next: Cell<Option<Instant>>,
}

impl Share {
    /// Waits until a request may be handled.
    pub(crate) async fn turn(self: &Rc<Self>) -> RequestSlot {
        let held = self.order.lock_arc().await;
        if let Some(next) = self.next.get() {
            Timer::at(next).await;
        }
        RequestSlot {
            share: Rc::clone(self),
            _held: held,
            began: Instant::now(),
        }
    }
}

/// Guard of one request; the handling of the request ends when the guard is dropped.
#[derive(Debug)]
pub(crate) struct RequestSlot {
    share: Rc<Share>,
    _held: MutexGuardArc<()>,
    began: Instant,
}

impl RequestSlot {
    /// Handling begins now, after the time in the node's queue.
    pub(crate) fn begin(&mut self) {
        self.began = Instant::now();
    }
}

impl Drop for RequestSlot {
    fn drop(&mut self) {
        let now = Instant::now();
        let pause = pause_after(now.duration_since(self.began));
        self.share.next.set(now.checked_add(pause));
    }
}

/// Pause after a request of duration `took`.
fn pause_after(took: Duration) -> Duration {
    took.saturating_mul(PAUSES).min(LONGEST_PAUSE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_get_a_fifth_of_the_time_at_most() {
        let took = Duration::from_millis(3);
        assert_eq!(pause_after(took), Duration::from_millis(12));
        assert_eq!(pause_after(Duration::MAX), LONGEST_PAUSE);
    }

    #[test]
    fn one_request_at_a_time_in_the_order_of_asking_and_none_before_its_time() {
        let share = Rc::new(Share::default());
        let executor = smol::LocalExecutor::new();
        let handled = Rc::new(Cell::new(0));
        let tasks: Vec<_> = (0..3)
            .map(|number| {
                let (share, handled) = (Rc::clone(&share), Rc::clone(&handled));
                executor.spawn(async move {
                    let mut turn = share.turn().await;
                    turn.begin();
                    let begun = Instant::now();
                    assert!(share.next.get().is_none_or(|next| next <= begun));
                    assert_eq!(handled.replace(number + 1), number);
                    // Others run meanwhile; none of them gets a turn.
                    smol::future::yield_now().await;
                    assert_eq!(handled.get(), number + 1);
                    drop(turn);
                    assert!(share.next.get().is_some_and(|next| next >= begun));
                })
            })
            .collect();
        smol::block_on(executor.run(async {
            for task in tasks {
                task.await;
            }
        }));
        assert_eq!(handled.get(), 3);
    }
}
