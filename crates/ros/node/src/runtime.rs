//! The node: one participant, one thread, one event at a time.
//!
//! Messages, requests, timers and parameter changes become values of the node's own event type, and pass one by one through one handler. So the
//! node needs no locks, and its program is a `match`.
//!
//! - `start`: start of the node.
//! - `endpoints`: endpoints of topics, services and actions; `standard`: those of every node.

mod endpoints;
mod standard;
mod start;

pub(crate) use endpoints::ClientOpener;
pub use start::NodeSpec;

use std::cell::RefCell;
use std::future::Future;
use std::mem;
use std::rc::Rc;
use std::time::{Duration, Instant};

use futures::{
    FutureExt as _,
    future::{Either, select},
};
use planesman_msgs::builtin_interfaces::msg::Time;
use ros2_client::{Context, service::ServiceMapping};
use smol::{
    LocalExecutor, Timer as SmolTimer,
    channel::{Receiver, Sender},
};

use crate::{
    diagnostics::{self, Connections, Level},
    error::{Error, Result},
    logging,
    parameters::ParameterServer,
    receive_limits::{Gate, LargeMessage},
    report::ExitReport,
    share::RequestSlot,
    shared::Shared,
};

/// Time for the last messages at shutdown: a reader that misses a message requests it within about 10 ms.
const LINGER: Duration = Duration::from_millis(40);

/// Whether the node continues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Wait for the next event.
    Continue,
    /// Shut down.
    Stop,
}

/// The result of [`Runtime::next`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next<E> {
    /// The next event.
    Event(E),
    /// The process has been requested to stop.
    Stop,
    /// The timeout has passed.
    Timeout,
}

/// Handle of a timer. Dropping it does not stop the timer.
#[derive(Debug)]
pub struct Timer {
    task: Option<smol::Task<()>>,
}

impl Timer {
    /// Stops the timer.
    pub fn cancel(mut self) {
        drop(self.task.take());
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        if let Some(task) = self.task.take() {
            task.detach();
        }
    }
}

/// An event waiting for the handler.
struct Queued<E> {
    event: E,
    hold: EventGuard,
}

/// Resources that are released when an event has been handled.
enum EventGuard {
    Nothing,
    /// The slot of a request.
    RequestSlot(RequestSlot),
    /// The slot of a large message.
    LargeMessage(#[expect(dead_code, reason = "its end is what counts")] LargeMessage),
}

impl From<RequestSlot> for EventGuard {
    fn from(turn: RequestSlot) -> Self {
        Self::RequestSlot(turn)
    }
}

impl From<Option<LargeMessage>> for EventGuard {
    fn from(large: Option<LargeMessage>) -> Self {
        large.map_or(Self::Nothing, Self::LargeMessage)
    }
}

impl<E> From<E> for Queued<E> {
    fn from(event: E) -> Self {
        Self {
            event,
            hold: EventGuard::Nothing,
        }
    }
}

/// A running node with events of type `E`.
pub struct Runtime<E> {
    shared: Rc<Shared>,
    executor: Rc<LocalExecutor<'static>>,
    parameters: Rc<RefCell<ParameterServer>>,
    mapping: ServiceMapping,
    /// The middleware's context. Dropped after all other objects of the middleware, because it then informs the peers.
    context: Context,
    sender: Sender<Queued<E>>,
    receiver: Receiver<Queued<E>>,
    gate: Rc<Gate>,
    /// Resources of the event being handled.
    hold: RefCell<EventGuard>,
    stop: Receiver<()>,
    /// Receives the reason if the node cannot continue.
    failed: Receiver<String>,
    /// The reason, once [`Runtime::next`] has received it.
    failure: RefCell<Option<Error>>,
}

impl<E: 'static> Runtime<E> {
    /// Full name of the node after remapping, such as `/auv/plant_sim`.
    #[must_use]
    pub fn full_name(&self) -> String {
        self.shared.names.full()
    }

    /// Absolute name of a topic, remapped by the node's arguments.
    ///
    /// # Errors
    /// The name violates the ROS rules.
    pub fn topic_name(&self, topic: &str) -> Result<String> {
        self.shared.topic_name(topic)
    }

    /// The node's time: the machine's clock, or `/clock` if `use_sim_time` is set.
    #[must_use]
    pub fn now(&self) -> Time {
        self.shared.clock.now()
    }

    /// Whether the node's time is not the machine's: with `use_sim_time`, or after [`Runtime::set_time`].
    #[must_use]
    pub fn is_time_simulated(&self) -> bool {
        self.shared.clock.is_simulated()
    }

    /// Sets the node's time, for a node that publishes `/clock` or gets the time from elsewhere; diagnostics and `/rosout` use this time. From then
    /// on the machine's clock and `/clock` are ignored.
    pub fn set_time(&self, time: &Time) {
        self.shared.clock.set(time);
    }

    /// Makes an event every `period` of wall time, starting after one period. Periods that pass while the node is busy are skipped.
    pub fn every(&self, period: Duration, mut event: impl FnMut() -> E + 'static) -> Timer {
        let period = period.max(Duration::from_micros(1));
        let (sender, shared) = (self.sender.clone(), Rc::clone(&self.shared));
        self.timer(async move {
            let mut due = Instant::now();
            loop {
                due += period;
                let now = Instant::now();
                if due < now {
                    let late = now.duration_since(due).as_nanos() / period.as_nanos();
                    due += period * u32::try_from(late).unwrap_or(u32::MAX);
                }
                shared.sleep_until(due).await;
                if sender.send(event().into()).await.is_err() {
                    return;
                }
            }
        })
    }

    /// Makes one event after `delay` of wall time.
    pub fn after(&self, delay: Duration, event: impl FnOnce() -> E + 'static) -> Timer {
        let (sender, shared) = (self.sender.clone(), Rc::clone(&self.shared));
        self.timer(async move {
            shared.sleep(delay).await;
            let _ = sender.send(event().into()).await;
        })
    }

    /// Makes one event when the node's time reaches `due`, at once if that has passed.
    pub fn at(&self, due: Time, event: impl FnOnce() -> E + 'static) -> Timer {
        let (sender, shared) = (self.sender.clone(), Rc::clone(&self.shared));
        self.timer(async move {
            let sleep = |left| shared.sleep(left);
            shared.clock.reaches(&due, sleep).await;
            let _ = sender.send(event().into()).await;
        })
    }

    /// The future is boxed for the same reason as in [`Shared::spawn`].
    fn timer(&self, work: impl Future<Output = ()> + 'static) -> Timer {
        Timer {
            task: Some(self.executor.spawn(work.boxed_local())),
        }
    }

    /// Makes an event from the result of `work`, for example a service call; the node continues meanwhile.
    pub fn when_done(&self, work: impl Future<Output = E> + 'static) {
        let sender = self.sender.clone();
        self.shared.spawn(async move {
            let _ = sender.send(work.await.into()).await;
        });
    }

    /// Waits for `work` while communication continues. Events are queued.
    pub fn block_on<T>(&self, work: impl Future<Output = T>) -> T {
        self.take_up(EventGuard::Nothing);
        self.shared.block_on(self.executor.run(work))
    }

    /// Waits for the next event, for programs with their own loop; [`Duration::MAX`] waits without a timer.
    pub fn next(&self, timeout: Duration) -> Next<E> {
        self.block_on(async {
            let (stop, event) = (self.asked_to_stop(), self.receiver.recv());
            let due = self.shared.sleep(timeout);
            futures::pin_mut!(event, stop, due);
            match select(stop, select(event, due)).await {
                Either::Left((asked, _)) => {
                    if let Err(failure) = asked {
                        log::error!("{failure}");
                        *self.failure.borrow_mut() = Some(failure);
                    }
                    Next::Stop
                }
                Either::Right((Either::Left((Err(_), _)), _)) => Next::Stop,
                Either::Right((Either::Left((Ok(queued), _)), _)) => {
                    self.take_up(queued.hold);
                    Next::Event(queued.event)
                }
                Either::Right((Either::Right(_), _)) => Next::Timeout,
            }
        })
    }

    /// Ends the handling of the last event; if the next one is a request, begins its handling.
    fn take_up(&self, mut hold: EventGuard) {
        if let EventGuard::RequestSlot(turn) = &mut hold {
            turn.begin();
        }
        drop(self.hold.replace(hold));
    }

    /// Sets the status `name` in the diagnostics; a change of level is published soon.
    pub fn set_status(&self, name: &str, level: Level, message: &str, values: &[(&str, String)]) {
        diagnostics::set_status(&self.shared, name, level, message, values);
    }

    /// The node's present topics and peers, as shown in its diagnostics.
    #[must_use]
    pub fn connections(&self) -> Connections {
        diagnostics::connections(&self.shared)
    }

    /// Handles events until the handler returns [`Flow::Stop`] or an error, or the process is requested to stop; then shuts the node down and informs
    /// its peers.
    ///
    /// # Errors
    /// The handler's error, or an error of writing the exit report.
    pub fn run<X: From<Error> + std::fmt::Display>(
        mut self,
        mut handler: impl FnMut(&mut Self, E) -> Result<Flow, X>,
    ) -> Result<(), X> {
        let executor = Rc::clone(&self.executor);
        let shared = Rc::clone(&self.shared);
        let outcome = shared.block_on(executor.run(async {
            loop {
                let queued = {
                    let (event, stop) = (self.receiver.recv(), self.asked_to_stop());
                    futures::pin_mut!(event, stop);
                    match select(stop, event).await {
                        Either::Left((asked, _)) => return asked.map_err(X::from),
                        Either::Right((Err(_), _)) => return Ok(()),
                        Either::Right((Ok(queued), _)) => queued,
                    }
                };
                self.take_up(queued.hold);
                if handler(&mut self, queued.event)? == Flow::Stop {
                    return Ok(());
                }
                self.take_up(EventGuard::Nothing);
                // What the handler has published goes out now, not after the next event.
                smol::future::yield_now().await;
            }
        }));
        drop((shared, executor, handler));
        if let Err(error) = &outcome {
            logging::log_final_error(error);
        }
        outcome.and(self.shutdown().map_err(X::from))
    }

    /// Waits until the process is requested to stop; an error if the node cannot continue.
    async fn asked_to_stop(&self) -> Result<()> {
        let (stop, failed) = (self.stop.recv(), self.failed.recv());
        futures::pin_mut!(stop, failed);
        match select(stop, failed).await {
            Either::Right((Ok(failure), _)) => Err(Error::Failed(failure)),
            _ => Ok(()),
        }
    }

    /// Shuts the node down and informs its peers.
    ///
    /// # Errors
    /// The exit report cannot be written, or the node had failed.
    pub fn shutdown(self) -> Result<()> {
        log::info!("shutting down");
        self.receiver.close();
        self.block_on(async { SmolTimer::after(LINGER).await });
        let outcome = ExitReport::of(&self.shared).write();
        match self.failure.take() {
            Some(failure) => Err(failure),
            None => outcome,
        }
    }
}

/// Readers and writers are dropped before their participant, however the node ends.
impl<E> Drop for Runtime<E> {
    fn drop(&mut self) {
        logging::end(&self.shared.clock);
        drop(mem::take(&mut self.executor)); // With the tasks, which hold the readers.
        self.shared.close();
    }
}
