//! The node itself: one participant, one thread, one event at a time.
//!
//! Everything that happens to a node, a message, a request, a timer, a change of
//! parameters, becomes a value of the node's own event type and passes through one
//! handler in turn. The node needs no locks, and reads as a `match`.

use crate::error::{BoxedError, Error, Result};
use std::{
    cell::RefCell,
    future::Future,
    marker::PhantomData,
    mem,
    net::Ipv4Addr,
    rc::Rc,
    time::{Duration, Instant},
};

use futures::{
    FutureExt as _, StreamExt as _,
    future::{Either, select},
};
use planesman_msgs::{
    Action, Message, Service,
    builtin_interfaces::msg::Time,
    diagnostic_msgs::msg::DiagnosticArray,
    lifecycle_msgs::{
        msg::TransitionEvent,
        srv::{
            ChangeState, ChangeStateResponse, GetAvailableStates, GetAvailableStatesResponse,
            GetAvailableTransitions, GetAvailableTransitionsResponse, GetState, GetStateResponse,
        },
    },
    loop_topics::{self, LoopTopic},
    rcl_interfaces::{
        msg::{Log, Parameter, ParameterEvent},
        srv::{
            DescribeParameters, DescribeParametersResponse, GetLoggerLevels, GetParameterTypes,
            GetParameterTypesResponse, GetParameters, GetParametersResponse, ListParameters,
            ListParametersResponse, SetLoggerLevels, SetParameters, SetParametersAtomically,
            SetParametersAtomicallyResponse, SetParametersResponse,
        },
    },
    rmw_dds_common::msg::ParticipantEntitiesInfo,
    rosgraph_msgs::msg::Clock as ClockMessage,
    type_description_interfaces::srv::GetTypeDescription,
};
use planesman_parameters::Parameters;
use ros2_client::{
    Context, MessageInfo, NodeName, NodeOptions, ServiceTypeName, service::ServiceMapping,
};
use rustdds::{
    DomainParticipantBuilder, GUID, StatusEvented as _, ThreadWatch, discovery::announce_type_hash,
    refusals,
};
use smol::{
    LocalExecutor, Timer as SmolTimer,
    channel::{Receiver, Sender, bounded},
};

use crate::{
    action_client::ActionClient,
    action_server::{ActionServer, Goal, GoalId},
    args::RosArguments,
    claim::Claim,
    clock, clock_source,
    diagnostics::{self, Connections, Level},
    discovered::{self, PublishedTopic},
    discovery_events::DiscoveryEvents,
    domain::{Domain, static_peers},
    endpoint::{Direction, Endpoint, TypeNames},
    file_size,
    graph::Graph,
    lifecycle::{Change, Lifecycle},
    logger_levels, logging, memory,
    names::NodeNames,
    parameters::{ParameterServer, STRICT_PARAMETERS},
    publisher::{Publisher, RawPublisher},
    qos::Qos,
    qos_overrides,
    raw::{RawSample, WholePayload},
    receive_limits::{Gate, LargeMessage, ReceiveLimits},
    report::ExitReport,
    security::Security,
    service::{self, Client, Responder},
    share::RequestSlot,
    shared::{Shared, type_parts, types_of},
    shutdown,
    subscription::{Speakers, non_finite, pump},
    timers, type_description,
    watchdog::Watchdog,
};

/// Events that wait for the handler; more wait in the middleware's histories.
const QUEUE: usize = 64;

/// Time between two diagnostics, s.
const DIAGNOSTICS_PERIOD: Duration = Duration::from_secs(1);

/// Time between two lines in the log about messages that are refused, s.
const REFUSALS_PERIOD: Duration = Duration::from_secs(5);

/// Time without a further change, or without any more messages, after which the diagnostics go out because of the latest, s.
/// While there is always more, as where many nodes start at once or in a dive, they go out every [`DIAGNOSTICS_PERIOD`].
const DIAGNOSTICS_SETTLING: Duration = Duration::from_millis(100);

/// Time given to the last messages at shutdown, s: a reader that misses one asks within
/// some 10 ms for it.
const LINGER: Duration = Duration::from_millis(40);

/// A node before it joins the graph.
pub struct NodeSpec<E, P> {
    /// The bare name, unless `__node` remaps it.
    pub name: &'static str,
    /// The namespace, unless `__ns` remaps it: `/auv`.
    pub namespace: &'static str,
    /// The rule for the parameters together, beyond the range of each. `use_sim_time` is added to them.
    pub validate: fn(&P) -> Result<(), BoxedError>,
    /// The event when parameters have changed.
    pub on_parameters: fn(P) -> E,
}

/// Whether the node goes on.
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
    /// An event.
    Event(E),
    /// The process has been asked to stop.
    Stop,
    /// The time is over.
    Timeout,
}

/// A timer's handle. Dropping it leaves the timer running.
#[derive(Debug)]
pub struct Timer {
    task: Option<smol::Task<()>>,
}

impl Timer {
    /// Ends the timer.
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

/// An event on its way to the handler.
struct Queued<E> {
    event: E,
    hold: Hold,
}

/// What ends with the handling of an event.
enum Hold {
    Nothing,
    /// A request's.
    RequestSlot(RequestSlot),
    /// A large message's.
    LargeMessage(#[expect(dead_code, reason = "its end is what counts")] LargeMessage),
}

impl From<RequestSlot> for Hold {
    fn from(turn: RequestSlot) -> Self {
        Self::RequestSlot(turn)
    }
}

impl From<Option<LargeMessage>> for Hold {
    fn from(large: Option<LargeMessage>) -> Self {
        large.map_or(Self::Nothing, Self::LargeMessage)
    }
}

/// The topic of the loop of that name, if it is of the type.
fn loop_topic<M: Message>(name: &str) -> Result<&'static LoopTopic> {
    loop_topics::named(name)
        .filter(|topic| topic.info.type_name == M::TYPE_NAME)
        .ok_or_else(|| Error::NotOfTheLoop {
            topic: name.to_owned(),
            type_name: M::TYPE_NAME,
        })
}

impl<E> From<E> for Queued<E> {
    fn from(event: E) -> Self {
        Self {
            event,
            hold: Hold::Nothing,
        }
    }
}

/// A running node whose events are of type `E`.
pub struct Runtime<E> {
    shared: Rc<Shared>,
    executor: Rc<LocalExecutor<'static>>,
    parameters: Rc<RefCell<ParameterServer>>,
    mapping: ServiceMapping,
    /// Goes last of the middleware: its end tells the peers.
    context: Context,
    sender: Sender<Queued<E>>,
    receiver: Receiver<Queued<E>>,
    gate: Rc<Gate>,
    /// Of the event that is being handled.
    hold: RefCell<Hold>,
    stop: Receiver<()>,
    /// Why the node cannot go on.
    failed: Receiver<String>,
    /// The same, once [`Runtime::next`] has met it.
    failure: RefCell<Option<Error>>,
}

impl<E: 'static> Runtime<E> {
    /// Brings the node up in the domain that the environment names: log, memory ceiling,
    /// parameters, participant, parameter services, diagnostics. Returns it with its parameters.
    ///
    /// # Errors
    /// When an argument, a parameter or an environment variable is refused, or the
    /// middleware does not come up.
    pub fn start<P: Parameters + 'static>(
        spec: NodeSpec<E, P>,
        arguments: RosArguments,
    ) -> Result<(Self, P)> {
        Self::start_in(Domain::from_environment()?, spec, arguments)
    }

    /// Brings the node up in `domain`.
    ///
    /// # Errors
    /// As [`Runtime::start`].
    pub fn start_in<P: Parameters + 'static>(
        domain: Domain,
        spec: NodeSpec<E, P>,
        arguments: RosArguments,
    ) -> Result<(Self, P)> {
        Self::with_receive_limits(domain, spec, arguments, |_| ReceiveLimits::small())
    }

    /// Brings the node up in `domain`, for a node that receives other messages than small ones.
    ///
    /// # Errors
    /// As [`Runtime::start`].
    pub fn with_receive_limits<P: Parameters + 'static>(
        domain: Domain,
        spec: NodeSpec<E, P>,
        arguments: RosArguments,
        receive_limits: impl FnOnce(&P) -> ReceiveLimits,
    ) -> Result<(Self, P)> {
        let names = NodeNames::remapped(spec.name, spec.namespace, &arguments.remaps)?;
        logging::install(&names.logger(), &arguments)?;
        for ignored in &arguments.ignored {
            log::warn!("ignored: {ignored}");
        }
        clock::check_machine()?;
        let variable = |name: &str| std::env::var(name).ok();
        let security = Security::asked_for(&arguments.enclave, variable)?;
        if let Some(lack) = security.lack() {
            log::warn!("{lack}");
        }
        let peers = static_peers(variable)?;
        timers::start()?;
        file_size::limit_is_an_error();
        let stop = shutdown::requested()?;
        let strict = variable(STRICT_PARAMETERS).is_some_and(|value| !value.is_empty());
        let parameters = ParameterServer::at_start(spec.validate, &names, &arguments, strict)?;
        let at_start = P::from_values(&parameters.values)?;
        let receive_limits = receive_limits(&at_start);
        memory::limit(&receive_limits)?;
        let mapping = service::mapping()?;

        // The runtime's own types must be known before their endpoints exist.
        announce_type_hash(Log::DDS_TYPE_NAME, Log::TYPE_HASH);
        announce_type_hash(ParameterEvent::DDS_TYPE_NAME, ParameterEvent::TYPE_HASH);
        announce_type_hash(ClockMessage::DDS_TYPE_NAME, ClockMessage::TYPE_HASH);
        announce_type_hash(
            ParticipantEntitiesInfo::DDS_TYPE_NAME,
            ParticipantEntitiesInfo::TYPE_HASH,
        );

        let builder = DomainParticipantBuilder::new(domain.id);
        let builder = match (domain.local, peers.is_empty()) {
            (true, true) => builder.with_only_networks([Ipv4Addr::LOCALHOST]),
            (local, _) => builder.multicast(!local).static_peers(peers.clone()),
        };
        let builder = builder.received_bytes(receive_limits.budget, receive_limits.largest);
        let participant =
            security
                .applied(builder)
                .build()
                .map_err(|reason| Error::Middleware {
                    what: format!("no participant in domain {}", domain.id),
                    reason: reason.to_string(),
                })?;
        Graph::replace_writer_of_context(&participant);
        let context = Context::from_domain_participant(participant.clone()).map_err(|reason| {
            Error::Middleware {
                what: "no ROS context".to_owned(),
                reason: reason.to_string(),
            }
        })?;
        let node_name =
            NodeName::new(&names.namespace, &names.name).map_err(Error::name(&names.full()))?;
        let options = NodeOptions::new()
            .enable_rosout(arguments.rosout)
            .start_parameter_services(false);
        // The node's own, which it never writes to and whose QoS is none of rclcpp's; ours is in `serve_parameters`.
        participant.withhold_next_writer("rt/parameter_events");
        // Its spinner stays unused: it would announce a `/clock` reader of a wrong type, and
        // what it finds out the participant tells as well.
        let mut node = context
            .new_node(node_name, options)
            .map_err(Error::name(&names.full()))?;
        let rosout = arguments.rosout.then(|| node.logging_handle());
        let graph = Graph::new(&participant, context.clone(), &mut node)?;

        let executor = Rc::new(LocalExecutor::new());
        let (diagnostics_due, changed) = bounded(1);
        let shared = Rc::new(Shared::new(
            names,
            arguments.remaps,
            participant.clone(),
            node,
            graph,
            Rc::downgrade(&executor),
            diagnostics_due,
        ));
        logging::begin(rosout, &shared.clock);
        let (ours, listener) = (Rc::clone(&shared), participant.status_listener());
        shared.spawn(async move {
            let warnings = DiscoveryEvents::default();
            let mut events = listener.as_async_status_stream();
            while let Some(event) = events.next().await {
                warnings.log(&ours, &event);
                ours.on_discovery(&event);
                ours.request_diagnostics();
            }
        });
        let (sender, receiver) = bounded(QUEUE);
        let (fail, failed) = bounded(1);
        let runtime = Self {
            shared,
            executor,
            parameters: Rc::new(RefCell::new(parameters)),
            mapping,
            context,
            sender,
            receiver,
            gate: Rc::default(),
            hold: RefCell::new(Hold::Nothing),
            stop,
            failed,
            failure: RefCell::default(),
        };
        clock_source::set_source(&runtime.shared, runtime.parameters.borrow().uses_sim_time())?;
        runtime.serve_parameters(spec.on_parameters)?;
        if runtime.parameters.borrow().describes_types() {
            let answer = async move |request, responder: Responder<_>, _turn| {
                responder.answer(type_description::answer(&request));
            };
            runtime.serve_with::<GetTypeDescription, _>("~/get_type_description", answer)?;
        }
        if runtime.parameters.borrow().serves_logger_levels() {
            runtime.serve_with::<GetLoggerLevels, _>(
                "~/get_logger_levels",
                async |request, r: Responder<_>, _turn| r.answer(logger_levels::get(request)),
            )?;
            runtime.serve_with::<SetLoggerLevels, _>(
                "~/set_logger_levels",
                async |request, r: Responder<_>, _turn| r.answer(logger_levels::set(request)),
            )?;
        }
        runtime.send_diagnostics(changed)?;
        runtime.watch_middleware(participant.thread_watch(), fail);
        let range = match (domain.local, peers.as_slice()) {
            (true, []) => ", this machine only".to_owned(),
            (true, peers) => format!(", this machine and static peers {peers:?} only"),
            (false, []) => String::new(),
            (false, peers) => format!(", static peers {peers:?}"),
        };
        log::info!("up in domain {}{range}", runtime.context.domain_id());
        Ok((runtime, at_start))
    }

    /// The node's full name after remapping: `/auv/plant_sim`.
    #[must_use]
    pub fn full_name(&self) -> String {
        self.shared.names.full()
    }

    /// The absolute name of a topic, remapped by the node's arguments.
    ///
    /// # Errors
    /// When the name breaks ROS's rules.
    pub fn topic_name(&self, topic: &str) -> Result<String> {
        self.shared.topic_name(topic)
    }

    /// The node's time: the machine's, or `/clock`'s when `use_sim_time` is set.
    #[must_use]
    pub fn now(&self) -> Time {
        self.shared.clock.now()
    }

    /// Whether the node's time is not the machine's: `use_sim_time`, or [`Runtime::set_time`].
    #[must_use]
    pub fn is_time_simulated(&self) -> bool {
        self.shared.clock.is_simulated()
    }

    /// Sets the node's time, for a node that makes `/clock`, or knows the time from elsewhere: its diagnostics and
    /// `/rosout` then have this time. The machine's and `/clock` count no more.
    pub fn set_time(&self, time: &Time) {
        self.shared.clock.set(time);
    }

    /// Opens `topic` for sending.
    ///
    /// # Errors
    /// When the name breaks ROS's rules, or the middleware refuses.
    pub fn publisher<M: Message>(&self, topic: &str, qos: Qos) -> Result<Publisher<M>> {
        let publisher = self.unlisted_publisher(topic, qos)?;
        self.list(&publisher.endpoint);
        Ok(publisher)
    }

    /// Opens a topic of the loop for sending, with its QoS there.
    ///
    /// # Errors
    /// A name that is not in [`loop_topics::ALL`], or of another type there; when the middleware refuses.
    pub fn loop_publisher<M: Message>(&self, topic: &str) -> Result<Publisher<M>> {
        self.publisher(topic, Qos::of(loop_topic::<M>(topic)?))
    }

    /// As [`Runtime::loop_publisher`], for those who must miss nothing, as members of lockstep.
    ///
    /// # Errors
    /// Those of [`Runtime::loop_publisher`].
    pub fn lossless_publisher<M: Message>(&self, topic: &str) -> Result<Publisher<M>> {
        self.publisher(topic, Qos::of(&loop_topic::<M>(topic)?.without_loss()))
    }

    /// Turns each message on `topic` into an event.
    ///
    /// A message that cannot be decoded, comes from a publisher of another type, or holds a number
    /// that is not finite is refused, counted, and named in the log.
    ///
    /// # Errors
    /// When the name breaks ROS's rules, or the middleware refuses.
    pub fn subscribe<M: Message>(
        &self,
        topic: &str,
        qos: Qos,
        event: impl Fn(M) -> E + 'static,
    ) -> Result<()> {
        self.subscribe_where(topic, qos, |_| None, |_| Vec::new(), event)
    }

    /// As [`Runtime::subscribe`]; messages for which `reason_against` gives a reason are refused too.
    ///
    /// # Errors
    /// Those of [`Runtime::subscribe`].
    pub fn subscribe_checked<M: Message>(
        &self,
        topic: &str,
        qos: Qos,
        reason_against: impl Fn(&M) -> Option<String> + 'static,
        event: impl Fn(M) -> E + 'static,
    ) -> Result<()> {
        self.subscribe_where(topic, qos, reason_against, |_| Vec::new(), event)
    }

    /// As [`Runtime::subscribe`], of messages that speak for nodes, named in full (`/auv/sysid`): refused is a message
    /// that speaks for a node which another participant serves.
    ///
    /// # Errors
    /// Those of [`Runtime::subscribe`].
    pub fn subscribe_to_speakers<M: Message>(
        &self,
        topic: &str,
        qos: Qos,
        nodes: impl Fn(&M) -> Vec<String> + 'static,
        event: impl Fn(M) -> E + 'static,
    ) -> Result<()> {
        self.subscribe_where(topic, qos, |_| None, nodes, event)
    }

    fn subscribe_where<M: Message>(
        &self,
        topic: &str,
        qos: Qos,
        reason_against: impl Fn(&M) -> Option<String> + 'static,
        nodes: impl Fn(&M) -> Vec<String> + 'static,
        event: impl Fn(M) -> E + 'static,
    ) -> Result<()> {
        let topic = self.shared.topic_name(topic)?;
        let types = types_of::<M>();
        let (endpoint, dds) = self.endpoint(Direction::Subscription, &topic, types, qos)?;
        let reader = self
            .shared
            .with_node(|node| node.create_subscription::<M>(&dds, None))?;
        self.list(&endpoint);
        let (shared, sender) = (Rc::clone(&self.shared), self.sender.clone());
        self.shared.spawn(async move {
            let deliver = async |message, _: &MessageInfo| {
                let _ = sender.send(event(message).into()).await; // Fails only at shutdown.
            };
            let speakers = Speakers::new(&shared);
            let reason_against = |message: &M, info: &MessageInfo| {
                non_finite(message)
                    .or_else(|| reason_against(message))
                    .or_else(|| speakers.reason_against(info.publisher_gid(), &nodes(message)))
            };
            pump(
                shared,
                endpoint,
                reader.async_stream(),
                reason_against,
                deliver,
            )
            .await;
        });
        Ok(())
    }

    /// The topics that other participants publish now, in order of name.
    #[must_use]
    pub fn published_topics(&self) -> Vec<PublishedTopic> {
        let participant = self.shared.participant();
        participant.map_or_else(Vec::new, |it| discovered::published_topics(&it))
    }

    /// The nodes of other participants that publish on `topic`, by their full names where they serve parameters, in order.
    ///
    /// # Errors
    /// When the name breaks ROS's rules.
    pub fn publishing_nodes(&self, topic: &str) -> Result<Vec<String>> {
        let topic = format!("rt{}", self.shared.topic_name(topic)?);
        let participant = self.shared.participant();
        Ok(participant.map_or_else(Vec::new, |it| discovered::publishing_nodes(&it, &topic)))
    }

    /// The services of other participants whose names end so (`/get_parameters`), in order of name.
    #[must_use]
    pub fn services(&self, ending: &str) -> Vec<String> {
        let participant = self.shared.participant();
        participant.map_or_else(Vec::new, |it| discovered::services_of_others(&it, ending))
    }

    /// Turns each sample on `topic` into an event without decoding it. `type_name` is
    /// ROS's (`std_msgs/msg/Float64`, `std_srvs/srv/Empty_Event`); `type_hash`, where known, is announced.
    ///
    /// # Errors
    /// When a name breaks ROS's rules, or the middleware refuses.
    pub fn subscribe_raw(
        &self,
        topic: &str,
        type_name: &str,
        type_hash: Option<&str>,
        qos: Qos,
        event: impl Fn(RawSample) -> E + 'static,
    ) -> Result<()> {
        let topic = self.shared.topic_name(topic)?;
        let types = names_of(type_name, type_hash)?;
        let (endpoint, dds) = self.endpoint(Direction::Subscription, &topic, types, qos)?;
        let reader = self
            .shared
            .with_node(|node| node.create_subscription::<Vec<u8>>(&dds, None))?;
        self.list(&endpoint);
        let (shared, sender) = (Rc::clone(&self.shared), self.sender.clone());
        let gate = Rc::clone(&self.gate);
        self.shared.spawn(async move {
            let samples = reader.async_stream_seed(WholePayload).boxed_local();
            let samples = gate
                .guard(samples, |sample| {
                    sample.as_ref().map_or(0, |(bytes, _)| bytes.len())
                })
                .map(|(sample, large)| sample.map(|(bytes, info)| ((bytes, large), info)));
            let deliver = async |(bytes, large): (Vec<u8>, Option<LargeMessage>),
                                 info: &MessageInfo| {
                let sample = RawSample::new(&topic, bytes, info);
                let queued = Queued {
                    event: event(sample),
                    hold: large.into(),
                };
                let _ = sender.send(queued).await;
            };
            pump(shared, endpoint, samples, |_, _| None, deliver).await;
        });
        Ok(())
    }

    /// Opens `topic` for sending payloads as they are; names as of [`Runtime::subscribe_raw`].
    ///
    /// # Errors
    /// When a name breaks ROS's rules, or the middleware refuses.
    pub fn raw_publisher(
        &self,
        topic: &str,
        type_name: &str,
        type_hash: Option<&str>,
        qos: Qos,
    ) -> Result<RawPublisher> {
        let topic = self.shared.topic_name(topic)?;
        let types = names_of(type_name, type_hash)?;
        let (endpoint, dds) = self.endpoint(Direction::Publisher, &topic, types, qos)?;
        let writer = self
            .shared
            .with_node(|node| node.create_publisher(&dds, None))?;
        self.list(&endpoint);
        Ok(RawPublisher {
            shared: Rc::clone(&self.shared),
            endpoint,
            writer: Rc::downgrade(&self.shared.keep(writer)),
        })
    }

    /// Turns each request to the service `name` into an event, which is to be answered
    /// through the [`Responder`] it brings.
    ///
    /// # Errors
    /// When the name breaks ROS's rules, or the middleware refuses.
    pub fn serve<S: Service>(
        &self,
        name: &str,
        event: impl Fn(S::Request, Responder<S>) -> E + 'static,
    ) -> Result<()> {
        let (shared, sender) = (Rc::clone(&self.shared), self.sender.clone());
        let subject = self.shared.service_name(name)?;
        self.serve_with::<S, _>(name, async move |request, responder, turn| {
            if let Some(reason) = non_finite(&request) {
                shared.warn(&subject, &format!("a request is refused: {reason}"));
                return;
            }
            let queued = Queued {
                event: event(request, responder),
                hold: turn.into(),
            };
            // Fails only when the node is shutting down.
            let _ = sender.send(queued).await;
        })
    }

    /// Opens the service `name` of another node for calling.
    ///
    /// # Errors
    /// When the name breaks ROS's rules, or the middleware refuses.
    pub fn client<S: Service>(&self, name: &str) -> Result<Client<S>> {
        self.client_opener().open(name)
    }

    /// Opens services from a task.
    pub(crate) fn client_opener(&self) -> ClientOpener {
        ClientOpener {
            shared: Rc::clone(&self.shared),
            mapping: self.mapping,
        }
    }

    /// Claims to be the only one that does something in the domain (`subject`, whatever all claimants name it),
    /// and reads the claims of others. They count where the claimant has a writer on the DDS topic `evidence`, as
    /// `rt/auv/state`.
    ///
    /// # Errors
    /// When the middleware refuses.
    pub fn claim(&self, subject: &str, evidence: &str) -> Result<Claim> {
        let claim = Claim::new(&self.shared, subject, evidence);
        let types = types_of::<DiagnosticArray>();
        let topic = self.shared.topic_name("/diagnostics")?;
        let (endpoint, dds) =
            self.shared
                .endpoint(Direction::Subscription, &topic, types, Qos::reliable(100))?;
        let reader = self
            .shared
            .with_node(|node| node.create_subscription::<DiagnosticArray>(&dds, None))?;
        let (shared, ours) = (Rc::clone(&self.shared), claim.clone());
        self.shared.spawn(async move {
            let deliver = async |array: DiagnosticArray, info: &MessageInfo| {
                if let Some(sender) = discovered::prefix(GUID::from(info.publisher_gid())) {
                    ours.observe(&array, sender);
                }
            };
            pump(
                shared,
                endpoint,
                reader.async_stream(),
                |_, _| None,
                deliver,
            )
            .await;
        });
        Ok(claim)
    }

    /// The node's lifecycle. A managed node is unconfigured at first: it serves the services of `lifecycle_msgs`, publishes
    /// `~/transition_event`, and turns each change of state into an event, once it is made. Any other is always active.
    ///
    /// # Errors
    /// When the middleware refuses.
    pub fn lifecycle(
        &self,
        managed: bool,
        event: impl Fn(Change) -> E + 'static,
    ) -> Result<Lifecycle> {
        if !managed {
            return Ok(Lifecycle::unmanaged());
        }
        let lifecycle = Lifecycle::managed();
        let events =
            self.unlisted_publisher::<TransitionEvent>("~/transition_event", Qos::reliable(10))?;
        let (shared, sender) = (Rc::clone(&self.shared), self.sender.clone());
        let of = || lifecycle.clone();
        let changed = of();
        self.serve_with::<ChangeState, _>("~/change_state", async move |request, r, _turn| {
            let made = changed.change(&request.transition, &shared.clock.now());
            let success = made.is_some();
            if let Some((change, steps)) = made {
                log::info!("{change:?}: {}", changed.label());
                for step in &steps {
                    events.publish(step);
                }
                let _ = sender.send(event(change).into()).await; // Fails only at shutdown.
            }
            r.answer(ChangeStateResponse { success });
        })?;
        let told = of();
        self.serve_with::<GetState, _>("~/get_state", async move |_, r, _turn| {
            r.answer(GetStateResponse {
                current_state: told.current(),
            });
        })?;
        self.serve_with::<GetAvailableStates, _>(
            "~/get_available_states",
            async |_, r: Responder<_>, _turn| {
                r.answer(GetAvailableStatesResponse {
                    available_states: Lifecycle::states(),
                });
            },
        )?;
        let told = of();
        self.serve_with::<GetAvailableTransitions, _>(
            "~/get_available_transitions",
            async move |_, r, _turn| {
                r.answer(GetAvailableTransitionsResponse {
                    available_transitions: told.available(),
                });
            },
        )?;
        self.serve_with::<GetAvailableTransitions, _>(
            "~/get_transition_graph",
            async |_, r: Responder<_>, _turn| {
                r.answer(GetAvailableTransitionsResponse {
                    available_transitions: Lifecycle::graph(),
                });
            },
        )?;
        Ok(lifecycle)
    }

    /// Serves the action `name`: each goal becomes an event, and so does each one that is to be
    /// cancelled. Which goals there may be, and how they end, is for the node to say through the
    /// [`Goal`].
    ///
    /// # Errors
    /// When the name breaks ROS's rules, or the middleware refuses.
    pub fn serve_action<A: Action>(
        &self,
        name: &str,
        on_goal: impl Fn(Goal<A>) -> E + 'static,
        on_cancel: impl Fn(GoalId) -> E + 'static,
    ) -> Result<()> {
        let (goals, cancels) = (self.sender.clone(), self.sender.clone());
        ActionServer::serve(
            &self.shared,
            name,
            self.mapping,
            async move |goal, turn| {
                let queued = Queued {
                    event: on_goal(goal),
                    hold: turn.into(),
                };
                let _ = goals.send(queued).await; // Fails only at shutdown.
            },
            async move |id| {
                let _ = cancels.send(on_cancel(id).into()).await;
            },
        )
    }

    /// Opens the action `name` of another node. All its feedback becomes events.
    ///
    /// # Errors
    /// When the name breaks ROS's rules, or the middleware refuses.
    pub fn action_client<A: Action>(
        &self,
        name: &str,
        on_feedback: impl Fn(GoalId, A::Feedback) -> E + 'static,
    ) -> Result<ActionClient<A>> {
        let sender = self.sender.clone();
        ActionClient::open(
            &self.shared,
            name,
            self.mapping,
            async move |id, feedback| {
                let _ = sender.send(on_feedback(id, feedback).into()).await;
            },
        )
    }

    /// Makes an event every `period` of wall time, the first after one period. A period
    /// that passes while the node is busy is left out, not made up for.
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

    /// Makes one event when the node's time is `due`, at once if that is over.
    pub fn at(&self, due: Time, event: impl FnOnce() -> E + 'static) -> Timer {
        let (sender, shared) = (self.sender.clone(), Rc::clone(&self.shared));
        self.timer(async move {
            let sleep = |left| shared.sleep(left);
            shared.clock.reaches(&due, sleep).await;
            let _ = sender.send(event().into()).await;
        })
    }

    /// Makes an event of what `work` comes to, for example a service call, meanwhile
    /// going on.
    pub fn when_done(&self, work: impl Future<Output = E> + 'static) {
        let sender = self.sender.clone();
        self.shared.spawn(async move {
            let _ = sender.send(work.await.into()).await;
        });
    }

    /// Waits for `work` while the node's communication goes on. Events queue up.
    pub fn block_on<T>(&self, work: impl Future<Output = T>) -> T {
        self.take_up(Hold::Nothing);
        self.shared.block_on(self.executor.run(work))
    }

    /// Waits for the next event, for programs that are not only a node; with [`Duration::MAX`] for ever and without a timer.
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

    /// Ends the handling of the last event; if the next one is a request, its handling begins.
    fn take_up(&self, mut hold: Hold) {
        if let Hold::RequestSlot(turn) = &mut hold {
            turn.begin();
        }
        drop(self.hold.replace(hold));
    }

    /// Sets the status `name` in the diagnostics, which go out soon if its level changes.
    pub fn set_status(&self, name: &str, level: Level, message: &str, values: &[(&str, String)]) {
        diagnostics::set_status(&self.shared, name, level, message, values);
    }

    /// The node's topics and their peers now, as its diagnostics tell them.
    #[must_use]
    pub fn connections(&self) -> Connections {
        diagnostics::connections(&self.shared)
    }

    /// Handles events until the handler says [`Flow::Stop`] or fails, or the process
    /// is asked to stop; then shuts the node down, so that its peers know at once.
    ///
    /// # Errors
    /// The handler's error, or one in writing the exit report.
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
                self.take_up(Hold::Nothing);
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

    /// Waits until the process is asked to stop, `Err` when the node cannot go on.
    async fn asked_to_stop(&self) -> Result<()> {
        let (stop, failed) = (self.stop.recv(), self.failed.recv());
        futures::pin_mut!(stop, failed);
        match select(stop, failed).await {
            Either::Right((Ok(failure), _)) => Err(Error::Failed(failure)),
            _ => Ok(()),
        }
    }

    /// Shuts the node down, so that its peers know at once.
    ///
    /// # Errors
    /// When the exit report cannot be written, or the node could not go on.
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

/// Readers and writers go before the participant that they belong to, however the node ends.
impl<E> Drop for Runtime<E> {
    fn drop(&mut self) {
        logging::end(&self.shared.clock);
        drop(mem::take(&mut self.executor)); // With the tasks, which hold the readers.
        self.shared.close();
    }
}

impl<E: 'static> Runtime<E> {
    /// In a box, as of [`Shared::spawn`].
    fn timer(&self, work: impl Future<Output = ()> + 'static) -> Timer {
        Timer {
            task: Some(self.executor.spawn(work.boxed_local())),
        }
    }

    /// One end of a topic, with the quality of service that the parameters give it.
    fn endpoint(
        &self,
        direction: Direction,
        topic: &str,
        types: TypeNames,
        qos: Qos,
    ) -> Result<(Rc<Endpoint>, rustdds::Topic)> {
        let qos = qos_overrides::applied(&self.parameters.borrow().values, direction, topic, qos);
        self.shared.endpoint(direction, topic, types, qos)
    }

    fn list(&self, endpoint: &Rc<Endpoint>) {
        self.shared.endpoints.borrow_mut().push(Rc::clone(endpoint));
        self.shared.request_diagnostics();
    }

    /// A publisher that does not show in the connections: the runtime's own.
    fn unlisted_publisher<M: Message>(&self, topic: &str, qos: Qos) -> Result<Publisher<M>> {
        let topic = self.shared.topic_name(topic)?;
        let types = types_of::<M>();
        let (endpoint, dds) = self.endpoint(Direction::Publisher, &topic, types, qos)?;
        let writer = self
            .shared
            .with_node(|node| node.create_publisher::<M>(&dds, None))?;
        Ok(Publisher {
            shared: Rc::clone(&self.shared),
            endpoint,
            writer: Rc::downgrade(&self.shared.keep(writer)),
        })
    }

    /// Hands each request of the service `name` to `answer`, one after the other, each in its turn.
    fn serve_with<S, A>(&self, name: &str, mut answer: A) -> Result<()>
    where
        S: Service,
        A: AsyncFnMut(S::Request, Responder<S>, RequestSlot) + 'static,
    {
        let name = self.shared.service_name(name)?;
        let server = service::server(&self.shared, self.mapping, &name, &announce_service::<S>()?)?;
        let name: Rc<str> = name.into();
        let (shared, mapping) = (Rc::clone(&self.shared), self.mapping);
        self.shared.spawn(async move {
            let mut is_advised = false;
            let mut requests = service::requests(&server);
            while let Some(request) = requests.next().await {
                let read = request.map_err(|e| e.to_string());
                let read = read.and_then(|(id, bytes)| {
                    service::check_client(mapping, &id)?;
                    let request = bytes.message::<S::Request>();
                    Ok((id, request.map_err(|e| e.to_string())?))
                });
                match read {
                    Ok((id, request)) => {
                        let responder = Responder {
                            shared: Rc::clone(&shared),
                            name: Rc::clone(&name),
                            server: Rc::downgrade(&server),
                            request: id,
                            of: PhantomData,
                        };
                        let turn = shared.share.turn().await;
                        answer(request, responder, turn).await;
                    }
                    Err(error) => match service::advice(&shared, mapping, &name) {
                        Some(_) if is_advised => {}
                        Some(advice) => {
                            is_advised = true;
                            log::warn!("{advice}");
                        }
                        None => shared.warn(&name, &format!("a request is refused: {error}")),
                    },
                }
            }
        });
        Ok(())
    }

    /// Serves the six parameter services and publishes `/parameter_events`.
    fn serve_parameters<P: Parameters + 'static>(&self, on_parameters: fn(P) -> E) -> Result<()> {
        let events =
            self.unlisted_publisher::<ParameterEvent>("/parameter_events", Qos::reliable(1000))?;
        let (shared, parameters, sender) = (
            Rc::clone(&self.shared),
            Rc::clone(&self.parameters),
            self.sender.clone(),
        );
        let announce = Rc::new(async move |changed: Vec<Parameter>| {
            if changed.is_empty() {
                return;
            }
            for parameter in &changed {
                log::info!("parameter {} changed", parameter.name);
            }
            let (uses_sim_time, new) = {
                let parameters = parameters.borrow();
                (
                    parameters.uses_sim_time(),
                    P::from_values(&parameters.values),
                )
            };
            if let Err(error) = clock_source::set_source(&shared, uses_sim_time) {
                log::error!("no /clock: {error}");
            }
            events.publish(&ParameterEvent {
                stamp: shared.clock.now(),
                node: shared.names.full(),
                changed_parameters: changed,
                ..ParameterEvent::default()
            });
            match new {
                Ok(new) => drop(sender.send(on_parameters(new).into()).await),
                Err(refusal) => log::error!("{refusal}"),
            }
        });

        let of = || Rc::clone(&self.parameters);
        let parameters = of();
        self.serve_with::<GetParameters, _>("~/get_parameters", async move |request, r, _turn| {
            let values = parameters.borrow().get(&request.names);
            r.answer(GetParametersResponse { values });
        })?;
        let parameters = of();
        self.serve_with::<GetParameterTypes, _>(
            "~/get_parameter_types",
            async move |request, r, _turn| {
                let types = parameters.borrow().types(&request.names);
                r.answer(GetParameterTypesResponse { types });
            },
        )?;
        let parameters = of();
        self.serve_with::<DescribeParameters, _>(
            "~/describe_parameters",
            async move |request, r, _turn| {
                let descriptors = parameters.borrow().describe(&request.names);
                r.answer(DescribeParametersResponse { descriptors });
            },
        )?;
        let parameters = of();
        self.serve_with::<ListParameters, _>(
            "~/list_parameters",
            async move |request, r, _turn| {
                let result = parameters.borrow().list(&request);
                r.answer(ListParametersResponse { result });
            },
        )?;
        let (parameters, notify) = (of(), Rc::clone(&announce));
        self.serve_with::<SetParameters, _>("~/set_parameters", async move |request, r, _turn| {
            let (results, changed) = parameters.borrow_mut().set_each(request);
            r.answer(SetParametersResponse { results });
            notify(changed).await;
        })?;
        let (parameters, notify) = (of(), announce);
        self.serve_with::<SetParametersAtomically, _>(
            "~/set_parameters_atomically",
            async move |request, r, _turn| {
                let (result, changed) = parameters.borrow_mut().set_together(request.parameters);
                r.answer(SetParametersAtomicallyResponse { result });
                notify(changed).await;
            },
        )
    }

    /// Publishes `/diagnostics` every second, and soon after a change.
    fn send_diagnostics(&self, changed: Receiver<()>) -> Result<()> {
        let publisher =
            self.unlisted_publisher::<DiagnosticArray>("/diagnostics", Qos::reliable(10))?;
        let shared = Rc::clone(&self.shared);
        self.shared.spawn(async move {
            let mut due = Instant::now() + DIAGNOSTICS_PERIOD;
            let mut settled = due;
            let mut look = Instant::now() + DIAGNOSTICS_SETTLING;
            // The messages of the connections: at the last look, and as told.
            let (mut seen, mut told) = (0, 0);
            loop {
                let change = changed.recv();
                let time = shared.sleep_until(due.min(settled).min(look));
                futures::pin_mut!(change, time);
                let next = select(change, time).await;
                let now = Instant::now();
                if matches!(next, Either::Left(_)) && now < due {
                    settled = now + DIAGNOSTICS_SETTLING;
                    continue;
                }
                look = now + DIAGNOSTICS_SETTLING;
                let count = diagnostics::messages(&shared);
                let has_stopped = count == seen && count != told;
                seen = count;
                if has_stopped || now >= due.min(settled) {
                    publisher.publish(&diagnostics::array(&shared));
                    due = now + DIAGNOSTICS_PERIOD;
                    settled = due;
                    told = count;
                }
            }
        });
        Ok(())
    }

    /// Once a second: shows what the middleware has refused, and fails when one of its
    /// threads has ended.
    fn watch_middleware(&self, threads: ThreadWatch, fail: Sender<String>) {
        let shared = Rc::downgrade(&self.shared);
        let mut overrides = Some(Rc::clone(&self.parameters));
        self.shared.spawn(async move {
            let mut watchdog = Watchdog::default();
            let mut before = refusals();
            let (mut told, mut next_word) = (0, Instant::now());
            loop {
                // A timer of its own: the middleware's may have stopped.
                SmolTimer::after(DIAGNOSTICS_PERIOD).await;
                let Some(shared) = shared.upgrade() else {
                    return;
                };
                // Once: by then a node has opened its topics.
                if let Some(parameters) = overrides.take() {
                    qos_overrides::warn_of_unused(&parameters.borrow().values, &shared.endpoints.borrow());
                }
                if let Some(trouble) = watchdog.look(threads.threads()) {
                    let _ =
                        fail.try_send(format!("{trouble}: the node receives no messages any more"));
                }
                let now = refusals();
                let [.., (_, samples)] = now;
                if samples > told && next_word <= Instant::now() {
                    log::warn!(
                        "{} messages are refused: larger than this node reads, or more bytes than it has room for",
                        samples - told
                    );
                    told = samples;
                    next_word = Instant::now() + REFUSALS_PERIOD;
                }
                diagnostics::set_refusals(&shared, before, now);
                before = now;
            }
        });
    }
}

/// The names of a type that is known by its ROS name only.
fn names_of(type_name: &str, type_hash: Option<&str>) -> Result<TypeNames> {
    let (package, kind, name) = type_parts(type_name)?;
    Ok(TypeNames {
        ros: type_name.to_owned(),
        dds: format!("{package}::{kind}::dds_::{name}_"),
        hash: type_hash.map(str::to_owned),
    })
}

/// What opens services of other nodes.
pub(crate) struct ClientOpener {
    pub(crate) shared: Rc<Shared>,
    mapping: ServiceMapping,
}

impl ClientOpener {
    /// As [`Runtime::client`].
    pub(crate) fn open<S: Service>(&self, name: &str) -> Result<Client<S>> {
        let name = self.shared.service_name(name)?;
        let inner = service::client(&self.shared, self.mapping, &name, &announce_service::<S>()?)?;
        self.shared.client_opened(&name);
        Ok(Client::new(&self.shared, name, inner))
    }
}

/// The service's type as the middleware takes it, its hash announced for both its
/// topics, and its QoS.
fn announce_service<S: Service>() -> Result<(ServiceTypeName, Qos)> {
    announce_type_hash(S::REQUEST_DDS_TYPE_NAME, S::TYPE_HASH);
    announce_type_hash(S::RESPONSE_DDS_TYPE_NAME, S::TYPE_HASH);
    let (package, _, name) = type_parts(S::TYPE_NAME)?;
    Ok((ServiceTypeName::new(package, name), Qos::reliable(10)))
}
