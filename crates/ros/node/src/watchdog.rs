//! Checks that the middleware's threads run. A node whose middleware event loop has ended or hangs can neither receive nor send, so it must stop
//! with an error.

use rustdds::ThreadState;

/// Number of checks, one per second, after which a thread without progress counts as stuck. The event loop iterates at least every two seconds.
const STUCK_AFTER: u32 = 15;

/// Progress of each thread at the last check.
#[derive(Debug, Default)]
pub(crate) struct Watchdog {
    /// Iterations of each thread, and the number of checks since they changed.
    seen: [(u64, u32); 2],
}

impl Watchdog {
    /// Fault of a thread, if any. Must be called once a second of the node's own clock, not wall time: a stopped process has no fault.
    pub(crate) fn look(&mut self, threads: [ThreadState; 2]) -> Option<String> {
        let mut trouble = None;
        for (thread, (rounds, looks)) in threads.iter().zip(&mut self.seen) {
            if *rounds == thread.rounds {
                *looks += 1;
            } else {
                (*rounds, *looks) = (thread.rounds, 0);
            }
            if thread.ended {
                trouble = Some(format!("the middleware's {} has ended", thread.name));
            } else if *looks >= STUCK_AFTER {
                trouble = Some(format!(
                    "the middleware's {} has been stuck for {STUCK_AFTER} s",
                    thread.name
                ));
            }
        }
        trouble
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threads(rounds: [u64; 2], ended: [bool; 2]) -> [ThreadState; 2] {
        [("event loop", 0), ("discovery", 1)].map(|(name, i)| ThreadState {
            name,
            rounds: rounds[i],
            ended: ended[i],
        })
    }

    #[test]
    fn running_threads_are_no_trouble() {
        let mut watchdog = Watchdog::default();
        for round in 1..100 {
            assert_eq!(watchdog.look(threads([round, round / 2], [false; 2])), None);
        }
    }

    #[test]
    fn an_ended_thread_is_named_at_once() {
        let trouble = Watchdog::default().look(threads([1, 1], [true, false]));
        assert_eq!(
            trouble.as_deref(),
            Some("the middleware's event loop has ended")
        );
    }

    #[test]
    fn a_stuck_thread_is_named_when_patience_is_over() {
        let mut watchdog = Watchdog::default();
        let mut looks = 0;
        let trouble = loop {
            looks += 1;
            if let Some(trouble) = watchdog.look(threads([u64::from(looks), 7], [false; 2])) {
                break trouble;
            }
        };
        assert_eq!(looks, STUCK_AFTER + 1);
        assert_eq!(
            trouble,
            "the middleware's discovery has been stuck for 15 s"
        );
    }
}
