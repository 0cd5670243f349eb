//! State shared by the parts of one node, which all run on one thread.

use crate::error::{Error, Result};
use std::{
    any::Any,
    cell::{Cell, RefCell},
    collections::{BTreeMap, HashSet},
    rc::{Rc, Weak},
    sync::Arc,
    time::{Duration, Instant},
};

use futures::future::LocalBoxFuture;
use planesman_msgs::{Message, diagnostic_msgs::msg::DiagnosticStatus};
use ros2_client::Node;
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, GUID, Topic, TopicKind,
    discovery::announce_type_hash,
};
use smol::{LocalExecutor, channel::Sender};

use crate::{
    args::{Remap, RemapKind},
    clock::Clock,
    discovered::ParticipantId,
    endpoint::{Direction, Endpoint, TypeNames},
    graph::Graph,
    logging::Throttle,
    names::NodeNames,
    qos::Qos,
    share::Share,
    waiting::Answers,
};

/// Minimum time between two warnings about one topic.
const WARNING_PERIOD: Duration = Duration::from_secs(5);

/// State shared by the parts of a node.
pub(crate) struct Shared {
    pub(crate) names: NodeNames,
    pub(crate) remaps: Vec<Remap>,
    /// The participant; `None` after the node has shut down.
    participant: RefCell<Option<DomainParticipant>>,
    node: RefCell<Option<Node>>,
    graph: RefCell<Option<Graph>>,
    /// Executor of the node's tasks.
    executor: Weak<LocalExecutor<'static>>,
    /// Publishers and subscriptions of the node itself, without those of the runtime.
    pub(crate) endpoints: RefCell<Vec<Rc<Endpoint>>>,
    /// Objects that live as long as the middleware; public handles hold weak references to these objects.
    kept: RefCell<Vec<Rc<dyn Any>>>,
    pub(crate) throttle: RefCell<Throttle>,
    pub(crate) statuses: RefCell<BTreeMap<String, DiagnosticStatus>>,
    pub(crate) clock: Arc<Clock>,
    /// Whether `/clock` has been subscribed to.
    pub(crate) follows_clock: Cell<bool>,
    /// Requests that the diagnostics be published soon.
    pub(crate) diagnostics_due: Sender<()>,
    /// Limit of the time spent on requests.
    pub(crate) share: Rc<Share>,
    /// Pending answers.
    pub(crate) answers: Answers,
    /// Request writers of clients that are known to receive answers.
    matched_clients: RefCell<HashSet<GUID>>,
    /// Number of clients opened for each service. The clients live as long as the node.
    clients: RefCell<BTreeMap<String, usize>>,
    /// When each participant last sent on a topic with many publishers, such as `/diagnostics`.
    heard: RefCell<BTreeMap<ParticipantId, Instant>>,
}

/// Nodes publish diagnostics every second; after this time without any, a node has stopped.
pub(crate) const STOPPED: Duration = Duration::from_secs(2);
/// Maximum number of participants remembered; beyond it the list starts again.
const PARTICIPANTS: usize = 1000;

/// Maximum number of clients remembered; beyond it the list starts again.
const MATCHED_CLIENTS: usize = 1000;

impl Shared {
    pub(crate) fn new(
        names: NodeNames,
        remaps: Vec<Remap>,
        participant: DomainParticipant,
        node: Node,
        graph: Graph,
        executor: Weak<LocalExecutor<'static>>,
        diagnostics_due: Sender<()>,
    ) -> Self {
        Self {
            names,
            remaps,
            participant: RefCell::new(Some(participant)),
            node: RefCell::new(Some(node)),
            graph: RefCell::new(Some(graph)),
            executor,
            endpoints: RefCell::default(),
            kept: RefCell::default(),
            throttle: RefCell::new(Throttle::new(WARNING_PERIOD)),
            statuses: RefCell::default(),
            clock: Arc::default(),
            follows_clock: Cell::default(),
            diagnostics_due,
            share: Rc::default(),
            answers: Answers::default(),
            matched_clients: RefCell::default(),
            clients: RefCell::default(),
            heard: RefCell::default(),
        }
    }

    /// Records that the participant has sent on a topic with many publishers.
    pub(crate) fn heard(&self, participant: ParticipantId) {
        let mut heard = self.heard.borrow_mut();
        if heard.len() >= PARTICIPANTS && !heard.contains_key(&participant) {
            heard.clear();
        }
        heard.insert(participant, Instant::now());
    }

    /// Whether the participant is still alive: it still sends on a topic with many publishers.
    pub(crate) fn hears(&self, participant: ParticipantId) -> bool {
        let heard = self.heard.borrow();
        heard
            .get(&participant)
            .is_some_and(|at| at.elapsed() < STOPPED)
    }

    /// Whether the client with this request writer is known to receive answers.
    pub(crate) fn is_matched(&self, client: GUID) -> bool {
        self.matched_clients.borrow().contains(&client)
    }

    /// Records that the client receives answers.
    pub(crate) fn set_matched(&self, client: GUID) {
        let mut matched_clients = self.matched_clients.borrow_mut();
        if matched_clients.len() >= MATCHED_CLIENTS {
            matched_clients.clear();
        }
        matched_clients.insert(client);
    }

    /// Counts another open client of the service `name`.
    pub(crate) fn client_opened(&self, name: &str) {
        *self
            .clients
            .borrow_mut()
            .entry(name.to_owned())
            .or_default() += 1;
    }

    /// Number of open clients of the service `name`.
    pub(crate) fn clients_of(&self, name: &str) -> usize {
        self.clients.borrow().get(name).copied().unwrap_or(0)
    }

    /// Adds an endpoint to the middleware's node.
    pub(crate) fn with_node<T, E: std::fmt::Debug>(
        &self,
        work: impl FnOnce(&mut Node) -> Result<T, E>,
    ) -> Result<T> {
        let mut node = self.node.borrow_mut();
        let node = node.as_mut().ok_or(Error::ShutDown)?;
        let done = work(node).map_err(Error::middleware)?;
        if let Some(graph) = self.graph.borrow().as_ref() {
            graph.tell();
        }
        Ok(done)
    }

    /// Handles a discovery event of the middleware.
    pub(crate) fn on_discovery(&self, event: &DomainParticipantStatusEvent) {
        if let Some(graph) = self.graph.borrow().as_ref() {
            graph.on(event);
        }
    }

    /// Waits for `work` on this thread, which meanwhile handles the node's messages.
    pub(crate) fn block_on<T>(&self, work: impl Future<Output = T>) -> T {
        match self.participant() {
            Some(participant) => participant.block_on(work),
            None => smol::future::block_on(work),
        }
    }

    /// Waits until `due`. The loop that handles the node's messages also keeps the time, so that no other thread is needed; without that loop this
    /// waits forever.
    pub(crate) async fn sleep_until(&self, due: Instant) {
        match self.participant() {
            Some(participant) => participant.sleep_until(due).await,
            None => std::future::pending().await,
        }
    }

    /// Like [`Shared::sleep_until`], for a duration.
    pub(crate) async fn sleep(&self, duration: Duration) {
        match Instant::now().checked_add(duration) {
            Some(due) => self.sleep_until(due).await,
            None => std::future::pending().await,
        }
    }

    /// The participant, for queries about discovery.
    pub(crate) fn participant(&self) -> Option<DomainParticipant> {
        self.participant.borrow().clone()
    }

    /// Runs `work` concurrently with the node's events until the node shuts down.
    ///
    /// Boxed, so that the executor's code is compiled once instead of once per task and node.
    pub(crate) fn spawn(&self, work: impl Future<Output = ()> + 'static) {
        self.spawn_boxed(Box::pin(work));
    }

    fn spawn_boxed(&self, work: LocalBoxFuture<'static, ()>) {
        if let Some(executor) = self.executor.upgrade() {
            executor.spawn(work).detach();
        }
    }

    /// Drops all objects of the middleware, writers first.
    pub(crate) fn close(&self) {
        self.kept.borrow_mut().clear();
        drop(self.graph.borrow_mut().take());
        drop(self.node.borrow_mut().take());
        drop(self.participant.borrow_mut().take());
    }

    /// Absolute, remapped name of a topic.
    pub(crate) fn topic_name(&self, topic: &str) -> Result<String> {
        Ok(self.names.resolve(topic, RemapKind::Topic, &self.remaps)?)
    }

    /// Absolute, remapped name of a service.
    pub(crate) fn service_name(&self, service: &str) -> Result<String> {
        Ok(self
            .names
            .resolve(service, RemapKind::Service, &self.remaps)?)
    }

    /// Registers an endpoint of a topic, with the middleware's topic.
    pub(crate) fn endpoint(
        &self,
        direction: Direction,
        topic: &str,
        types: TypeNames,
        qos: Qos,
    ) -> Result<(Rc<Endpoint>, Topic)> {
        if let Some(hash) = &types.hash {
            announce_type_hash(&types.dds, hash);
        }
        let participant = self.participant().ok_or(Error::ShutDown)?;
        // As `ros2_client::Node::create_topic`, which knows the types of messages only.
        let dds = participant
            .create_topic(
                format!("rt{topic}"),
                types.dds.clone(),
                &qos.profile().into(),
                TopicKind::NoKey,
            )
            .map_err(Error::middleware)?;
        Ok((Rc::new(Endpoint::new(direction, topic, types, qos)), dds))
    }

    /// Keeps `value` until the node shuts down.
    pub(crate) fn keep<T: Any>(&self, value: T) -> Rc<T> {
        let kept = Rc::new(value);
        self.kept.borrow_mut().push(Rc::clone(&kept) as Rc<dyn Any>);
        kept
    }

    /// Warns about `subject`, with limited frequency.
    pub(crate) fn warn(&self, subject: &str, text: &str) {
        self.throttle.borrow_mut().warn(subject, text);
    }

    /// Logs an error about `subject`, with limited frequency.
    pub(crate) fn complain(&self, subject: &str, text: &str) {
        if self.throttle.borrow_mut().admit(subject).is_some() {
            log::error!("{subject}: {text}");
        }
    }

    /// Requests that the diagnostics be published soon.
    pub(crate) fn request_diagnostics(&self) {
        let _ = self.diagnostics_due.try_send(()); // Full: they are going out already.
    }
}

/// The names of a message type.
pub(crate) fn types_of<M: Message>() -> TypeNames {
    TypeNames {
        ros: M::TYPE_NAME.to_owned(),
        dds: M::DDS_TYPE_NAME.to_owned(),
        hash: Some(M::TYPE_HASH.to_owned()),
    }
}

/// `planesman_msgs/msg/VehicleState` as package, kind and name.
pub(crate) fn type_parts(ros_type: &str) -> Result<(&str, &str, &str)> {
    let mut parts = ros_type.split('/');
    match (parts.next(), parts.next(), parts.next(), parts.next()) {
        (Some(package), Some(kind @ ("msg" | "srv" | "action")), Some(name), None) => {
            Ok((package, kind, name))
        }
        _ => Err(Error::TypeName {
            name: ros_type.to_owned(),
            form: "package/msg/Name is expected",
        }),
    }
}
