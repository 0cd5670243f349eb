//! A share of the node's time for requests, so that no client can take it all.
//!
//! Services and actions wait for their turn here, in the order in which their requests came, and one
//! request is handled at a time. After one that took a while, no other is begun for [`PAUSES`] times
//! as long: requests get a fifth of the node's thread at most, messages and timers the rest. What
//! waits meanwhile waits in the middleware, a thousand requests a service; a newer one takes the oldest's place.

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

/// The pause after a request, as a multiple of its duration.
const PAUSES: u32 = 4;

/// The longest pause, however long a request took, s.
const LONGEST_PAUSE: Duration = Duration::from_millis(500);

/// Whose turn it is, and when the next one is.
#[derive(Debug, Default)]
pub(crate) struct Share {
    /// Fair: who waits longest comes next.
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

/// The handling of one request, which ends when this is dropped.
#[derive(Debug)]
pub(crate) struct RequestSlot {
    share: Rc<Share>,
    _held: MutexGuardArc<()>,
    began: Instant,
}

impl RequestSlot {
    /// The handling begins now, after some time in the node's queue.
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

/// The pause after a request that took `took`.
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
