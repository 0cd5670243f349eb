//! The node's time: the machine's, `/clock` when `use_sim_time` is set, or the node's own where it makes `/clock`.

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

/// Longest sleep until a time of the machine's clock, s: somebody may set that clock meanwhile.
const LONGEST_SLEEP: Duration = Duration::from_secs(1);

/// Where the node's time comes from. The log reads it from any thread.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    /// Whether the time is `/clock`.
    simulated: AtomicBool,
    /// Whether the node sets its time itself.
    own: AtomicBool,
    /// The newest simulated time, ns; 0 until one has come.
    latest: AtomicI64,
    /// Who waits for a simulated time.
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

    /// Whether it is not the machine's time.
    pub(crate) fn is_simulated(&self) -> bool {
        self.simulated.load(Relaxed) || self.own.load(Relaxed)
    }

    /// Takes the time from `/clock`, or from the machine.
    pub(crate) fn set_simulated(&self, simulated: bool) {
        self.simulated.store(simulated, Relaxed);
        self.wake();
    }

    /// A `/clock` has come. A node that sets its time itself does not listen to it.
    pub(crate) fn on_clock(&self, time: &Time) {
        if !self.own.load(Relaxed) {
            self.latest.store(time.nanos(), Relaxed);
            self.wake();
        }
    }

    /// From now on the node sets its time itself.
    pub(crate) fn set(&self, time: &Time) {
        self.latest.store(time.nanos(), Relaxed);
        self.own.store(true, Relaxed);
        self.wake();
    }

    /// Waits until the node's time is `due` or later, for a time of the machine's clock by `sleep`.
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

/// The last second of stamps: `builtin_interfaces/msg/Time` counts seconds in 32 bits, up to 2038-01-19 03:14:07 UTC.
const LAST_SECOND: u64 = i32::MAX as u64;

/// Checks that the machine's clock can be told in stamps.
///
/// # Errors
/// Before 1970 and after 2262, where the middleware's timestamps begin and end. After 2038 the node runs, with stamps that
/// stand still; a warning says so.
pub(crate) fn check_machine() -> Result<()> {
    let Ok(since) = SystemTime::now().duration_since(UNIX_EPOCH) else {
        return Err(Error::Clock("before 1970, where DDS timestamps begin"));
    };
    if i64::try_from(since.as_nanos()).is_err() {
        return Err(Error::Clock(
            "past 2262-04-11, where timestamps of 64 bits in ns end",
        ));
    }
    if since.as_secs() >= LAST_SECOND {
        log::warn!(
            "this machine's clock is past 2038-01-19, where ROS 2's stamps end: they stand still unless time is simulated"
        );
    }
    Ok(())
}

/// The machine's time since 1970.
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
