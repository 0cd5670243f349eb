//! The node's time: the machine's, `/clock` if `use_sim_time` is set, or set by the node itself if it publishes `/clock`.

use crate::error::{Error, Result};
use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicI64, Ordering::Relaxed},
    },
    task::{Poll, Waker},
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use planesman_msgs::builtin_interfaces::msg::Time;

/// Longest single sleep on the machine's clock; it is limited because somebody may set that clock meanwhile.
const LONGEST_SLEEP: Duration = Duration::from_secs(1);

/// Source of the node's time. The log reads it from any thread.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    /// Whether the time comes from `/clock`.
    simulated: AtomicBool,
    /// Whether the node sets its time itself.
    own: AtomicBool,
    /// Latest simulated time, ns; 0 before the first.
    latest: AtomicI64,
    /// Tasks that wait for a simulated time.
    waiting: Mutex<Vec<Waker>>,
}

impl Clock {
    /// The node's time. Simulated time is 0 until the first `/clock`, as in `rclcpp`.
    pub(crate) fn now(&self) -> Time {
        if self.is_simulated() {
            Time::from_nanos(self.latest.load(Relaxed))
        } else {
            wall()
        }
    }

    /// Whether the time comes from `/clock` or from the node itself, instead of the machine.
    pub(crate) fn is_simulated(&self) -> bool {
        self.simulated.load(Relaxed) || self.own.load(Relaxed)
    }

    /// Selects `/clock` or the machine as source.
    pub(crate) fn set_simulated(&self, simulated: bool) {
        self.simulated.store(simulated, Relaxed);
        self.wake();
    }

    /// Handles a `/clock` message. A node that sets its time itself ignores this time.
    pub(crate) fn on_clock(&self, time: &Time) {
        if !self.own.load(Relaxed) {
            self.latest.store(time.nanos(), Relaxed);
            self.wake();
        }
    }

    /// Sets the time; from then on the node sets its time itself.
    pub(crate) fn set(&self, time: &Time) {
        self.latest.store(time.nanos(), Relaxed);
        self.own.store(true, Relaxed);
        self.wake();
    }

    /// Waits until the node's time is at least `due`; `sleep` waits on the machine's clock.
    pub(crate) async fn reaches(&self, due: &Time, sleep: impl AsyncFn(Duration)) {
        loop {
            let left = due.nanos().saturating_sub(self.now().nanos());
            let left = match u64::try_from(left) {
                Err(_) | Ok(0) => return,
                Ok(left) => Duration::from_nanos(left),
            };
            if self.is_simulated() {
                self.change().await;
            } else {
                sleep(left.min(LONGEST_SLEEP)).await;
            }
        }
    }

    /// Waits for the next simulated time.
    async fn change(&self) {
        let mut asked = false;
        std::future::poll_fn(|context| {
            if std::mem::replace(&mut asked, true) {
                return Poll::Ready(());
            }
            self.waiting().push(context.waker().clone());
            Poll::Pending
        })
        .await;
    }

    fn wake(&self) {
        for waker in std::mem::take(&mut *self.waiting()) {
            waker.wake();
        }
    }

    fn waiting(&self) -> std::sync::MutexGuard<'_, Vec<Waker>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Last second of stamps: `builtin_interfaces/msg/Time` has 32-bit seconds, up to 2038-01-19 03:14:07 UTC.
const LAST_SECOND: u64 = i32::MAX as u64;

/// Checks that the machine's time can be represented in stamps.
///
/// # Errors
/// A time before 1970 or after 2262, the limits of the middleware's timestamps. After 2038 the node runs with constant stamps, and logs a
/// warning.
pub(crate) fn check_machine() -> Result<()> {
    let Ok(since) = SystemTime::now().duration_since(UNIX_EPOCH) else {
        return Err(Error::Clock("before 1970, where DDS timestamps begin"));
    };
    if i64::try_from(since.as_nanos()).is_err() {
        return Err(Error::Clock(
            "past 2262-04-11, the end of 64-bit timestamps in ns",
        ));
    }
    if since.as_secs() >= LAST_SECOND {
        log::warn!(
            "this machine's clock is past 2038-01-19, the end of ROS 2 stamps: stamps no longer advance unless time is simulated"
        );
    }
    Ok(())
}

/// The machine's time since 1970, UTC.
#[must_use]
pub fn wall() -> Time {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    Time::from_nanos(i64::try_from(now.as_nanos()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;

    #[test]
    fn simulated_time_is_what_clock_said_last_and_the_nodes_own_goes_before_it() {
        let clock = Clock::default();
        assert!(clock.now().nanos() > 0);
        clock.set_simulated(true);
        assert_eq!(clock.now().nanos(), 0);
        clock.on_clock(&Time::from_nanos(7));
        assert_eq!(clock.now().nanos(), 7);
        clock.set(&Time::from_nanos(5));
        clock.on_clock(&Time::from_nanos(9));
        clock.set_simulated(false);
        assert_eq!(clock.now().nanos(), 5);
    }

    #[test]
    fn a_time_is_waited_for_by_the_clock_that_is_followed() {
        let clock = Rc::new(Clock::default());
        clock.set_simulated(true);
        let executor = smol::LocalExecutor::new();
        let waits = Rc::clone(&clock);
        let task = executor.spawn(async move {
            let sleep = async |_| unreachable!("the time is simulated");
            waits.reaches(&Time::from_nanos(10), sleep).await;
        });
        for (time, woken) in [(0, true), (9, true), (10, true), (10, false)] {
            clock.on_clock(&Time::from_nanos(time));
            assert_eq!(executor.try_tick(), woken, "{time}");
        }
        assert!(task.is_finished());
    }
}
