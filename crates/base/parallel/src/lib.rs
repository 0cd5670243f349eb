#![doc = include_str!("../README.md")]
//!
//! A search takes seconds to hours, and its caller may want to cancel it. So long loops call [`stop_point`]: after a [`Stop`] has been requested, it
//! unwinds to [`until_stopped`], which drops all unfinished results. Without a [`Stop`] it does nothing.

use std::cell::RefCell;
use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

/// A request to stop, shared with the work.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Requests that the work end at its next [`stop_point`].
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Receiver of progress reports of long work. `()` ignores them.
pub trait Progress: Sync {
    /// Work of `steps` steps begins; `done` of them were done before; 0 steps if the number is unknown.
    fn begin(&self, _what: &'static str, _steps: u64, _done: u64) {}
    /// A step is done.
    fn step(&self) {}
    /// `bytes` bytes of a source are read; 0 at its beginning.
    fn read(&self, _bytes: u64, _of: u64) {}
    /// The work has ended.
    fn end(&self) {}
}

impl Progress for () {}

/// Payload of the unwinding from a [`stop_point`].
struct Stopped;

thread_local! {
    /// The stop request of this thread's work.
    static CURRENT: RefCell<Option<Stop>> = const { RefCell::new(None) };
}

/// Result of `work` on this thread, including [`on_all_cores`]; `None` if it ended because `stop` was requested. Other panics are passed on.
pub fn until_stopped<R>(stop: &Stop, work: impl FnOnce() -> R) -> Option<R> {
    let outer = CURRENT.replace(Some(stop.clone()));
    // What was half done is dropped, and nobody sees it.
    let outcome = catch_unwind(AssertUnwindSafe(work));
    CURRENT.set(outer);
    match outcome {
        Ok(result) => Some(result),
        Err(panic) if panic.is::<Stopped>() => None,
        Err(panic) => resume_unwind(panic),
    }
}

/// A place at which long work may end: unwinds to [`until_stopped`] if a stop is requested.
pub fn stop_point() {
    let stops = |stop: &Option<Stop>| stop.as_ref().is_some_and(|it| it.0.load(Ordering::Relaxed));
    if CURRENT.with_borrow(stops) {
        resume_unwind(Box::new(Stopped));
    }
}

/// Results of `work` for each item, in order, computed on all cores, or on fewer if the system provides no more threads. A panic in `work` is
/// passed on.
pub fn on_all_cores<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let stop = CURRENT.with_borrow(Clone::clone);
    let some = || {
        CURRENT.set(stop.clone());
        let mut done = Vec::new();
        loop {
            stop_point();
            let place = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(place) else {
                return done;
            };
            done.push((place, work(item)));
        }
    };
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let mut done: Vec<(usize, R)> = thread::scope(|scope| {
        // This thread works too.
        let others: Vec<_> = (1..cores.min(items.len()))
            .map_while(|_| thread::Builder::new().spawn_scoped(scope, some).ok())
            .collect();
        let mut done = some();
        for other in others {
            match other.join() {
                Ok(part) => done.extend(part),
                Err(panic) => resume_unwind(panic),
            }
        }
        done
    });
    done.sort_by_key(|(place, _)| *place);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..100).collect();
        let slower_first = |item: &u64| {
            thread::sleep(Duration::from_micros(100 - item));
            item * item
        };
        let squares: Vec<u64> = items.iter().map(|item| item * item).collect();
        assert_eq!(on_all_cores(&items, slower_first), squares);
        assert!(on_all_cores(&[], slower_first).is_empty());
    }

    #[test]
    fn work_that_is_asked_to_stop_ends_on_all_cores_and_other_work_goes_on() {
        let stop = Stop::default();
        let items: Vec<usize> = (0..10_000).collect();
        let begun = AtomicUsize::new(0);
        let count = |item: &usize| {
            if begun.fetch_add(1, Ordering::Relaxed) == 100 {
                stop.ask();
            }
            *item
        };
        assert_eq!(until_stopped(&stop, || on_all_cores(&items, count)), None);
        let begun = begun.into_inner();
        assert!((100..5_000).contains(&begun), "{begun}");
        // Out of its reach: no stop at all, or another.
        stop_point();
        let other = || on_all_cores(&items, |item| *item);
        assert_eq!(until_stopped(&Stop::default(), other), Some(items.clone()));
    }

    #[test]
    #[should_panic(expected = "broken")]
    fn a_panic_is_no_stop() {
        until_stopped(&Stop::default(), || panic!("broken"));
    }
}
