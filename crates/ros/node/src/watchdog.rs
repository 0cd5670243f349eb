//! Whether the middleware's threads still run. A node whose event loop has ended, or is
//! stuck, neither receives nor sends: it must stop with an error.

use rustdds::ThreadState;

/// Looks in a row, a second apart, that a thread may spend in one round. The event loop
/// goes round every two seconds at least.
const STUCK_AFTER: u32 = 15;

/// Remembers how far each thread was.
#[derive(Debug, Default)]
pub(crate) struct Watchdog {
    /// The rounds of each thread, and the looks since they have changed.
    seen: [(u64, u32); 2],
}

impl Watchdog {
    /// The fault of a thread, if there is one. To be called once a second by the
    /// node's own clock, not by the wall's: while the process is stopped nothing is wrong.
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
