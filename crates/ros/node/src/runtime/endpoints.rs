//! The node's endpoints of topics, services and actions, and discovery of others'.

use std::marker::PhantomData;
use std::rc::Rc;

use futures::{FutureExt as _, StreamExt as _};
use planesman_msgs::{
    Action, Message, Service,
    diagnostic_msgs::msg::DiagnosticArray,
    loop_topics::{self, LoopTopic},
};
use ros2_client::{MessageInfo, ServiceTypeName, service::ServiceMapping};
use rustdds::{GUID, discovery::announce_type_hash};
use smol::channel::Sender;

use super::{Queued, Runtime};
use crate::{
    action_client::ActionClient,
    action_server::{ActionServer, Goal, GoalId},
    claim::Claim,
    discovered::{self, PublishedTopic},
    endpoint::{Direction, Endpoint, TypeNames},
    error::{Error, Result},
    publisher::{Publisher, RawPublisher},
    qos::Qos,
    qos_overrides,
    raw::RawSample,
    receive_limits::Gate,
    service::{self, Client, Responder},
    share::RequestSlot,
    shared::{Shared, type_parts, types_of},
    subscription::{self, Delivery, Read, Speakers, Unread, non_finite},
};

/// The topic of the loop with this name, if it has the type `M`.
fn loop_topic<M: Message>(name: &str) -> Result<&'static LoopTopic> {
    loop_topics::named(name)
        .filter(|topic| topic.info.type_name == M::TYPE_NAME)
        .ok_or_else(|| Error::NotOfTheLoop {
            topic: name.to_owned(),
            type_name: M::TYPE_NAME,
        })
}

impl<E: 'static> Runtime<E> {
    /// Opens a publisher of `topic`.
    ///
    /// # Errors
    /// The name violates the ROS rules, or an error of the middleware.
    pub fn publisher<M: Message>(&self, topic: &str, qos: Qos) -> Result<Publisher<M>> {
        let publisher = self.unlisted_publisher(topic, qos)?;
        self.list(publisher.endpoint());
        Ok(publisher)
    }

    /// Opens a publisher of a topic of the loop, with the loop's QoS.
    ///
    /// # Errors
    /// A name that is not in [`loop_topics::ALL`] or has another type there; an error of the middleware.
    pub fn loop_publisher<M: Message>(&self, topic: &str) -> Result<Publisher<M>> {
        self.publisher(topic, Qos::of(loop_topic::<M>(topic)?))
    }

    /// Like [`Runtime::loop_publisher`], for readers that must not lose messages, such as members of lockstep.
    ///
    /// # Errors
    /// Those of [`Runtime::loop_publisher`].
    pub fn lossless_publisher<M: Message>(&self, topic: &str) -> Result<Publisher<M>> {
        self.publisher(topic, Qos::of(&loop_topic::<M>(topic)?.without_loss()))
    }

    /// Turns each message on `topic` into an event.
    ///
    /// A message is refused, counted and logged if it cannot be decoded, comes from a publisher of another type, or contains a number that is not
    /// finite.
    ///
    /// # Errors
    /// The name violates the ROS rules, or an error of the middleware.
    pub fn subscribe<M: Message>(
        &self,
        topic: &str,
        qos: Qos,
        event: impl Fn(M) -> E + 'static,
    ) -> Result<()> {
        self.subscribe_where(topic, qos, |_| None, |_| Vec::new(), event)
    }

    /// Like [`Runtime::subscribe`]; also refuses messages for which `reason_against` returns a reason.
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

    /// Like [`Runtime::subscribe`], for messages sent in the name of nodes, given by full name (`/auv/sysid`). A message is refused if another
    /// participant contains that node.
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
        let speakers = Speakers::new(&self.shared);
        let (sender, event) = (self.sender.clone(), Rc::new(event));
        let read = move |it: Unread, info: &MessageInfo| {
            let message: M = it.message()?;
            let reason = non_finite(&message)
                .or_else(|| reason_against(&message))
                .or_else(|| speakers.reason_against(info.publisher_gid(), &nodes(&message)));
            if let Some(reason) = reason {
                return Err(reason);
            }
            let event = Rc::clone(&event);
            Ok(sent_to(&sender, Box::new(move || event(message).into())))
        };
        self.open(&topic, types_of::<M>(), qos, None, Box::new(read))
    }

    /// Subscribes to `topic` (full name); `read` passes its messages to the node.
    fn open(
        &self,
        topic: &str,
        types: TypeNames,
        qos: Qos,
        gate: Option<Rc<Gate>>,
        read: Read,
    ) -> Result<()> {
        let (endpoint, dds) = self.endpoint(Direction::Subscription, topic, types, qos)?;
        subscription::start(&self.shared, Rc::clone(&endpoint), &dds, gate, read)?;
        self.list(&endpoint);
        Ok(())
    }

    /// Topics currently published by other participants, sorted by name.
    #[must_use]
    pub fn published_topics(&self) -> Vec<PublishedTopic> {
        let participant = self.shared.participant();
        participant.map_or_else(Vec::new, |it| discovered::published_topics(&it))
    }

    /// Nodes of other participants that publish on `topic`, sorted; by full name if they serve parameters.
    ///
    /// # Errors
    /// The name violates the ROS rules.
    pub fn publishing_nodes(&self, topic: &str) -> Result<Vec<String>> {
        let topic = format!("rt{}", self.shared.topic_name(topic)?);
        let participant = self.shared.participant();
        Ok(participant.map_or_else(Vec::new, |it| discovered::publishing_nodes(&it, &topic)))
    }

    /// Services of other participants whose names end with `ending` (such as `/get_parameters`), sorted.
    #[must_use]
    pub fn services(&self, ending: &str) -> Vec<String> {
        let participant = self.shared.participant();
        participant.map_or_else(Vec::new, |it| discovered::services_of_others(&it, ending))
    }

    /// Turns each sample on `topic` into an event without decoding. `type_name`: ROS type (`std_msgs/msg/Float64`, `std_srvs/srv/Empty_Event`);
    /// `type_hash`: announced if known.
    ///
    /// # Errors
    /// A name violates the ROS rules, or an error of the middleware.
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
        let (sender, event, name) = (self.sender.clone(), Rc::new(event), topic.clone());
        let read = move |it: Unread, info: &MessageInfo| {
            let sample = RawSample::new(&name, it.payload, info);
            let (event, hold) = (Rc::clone(&event), it.large.into());
            let queued = move || Queued {
                event: event(sample),
                hold,
            };
            Ok(sent_to(&sender, Box::new(queued)))
        };
        let gate = Rc::clone(&self.gate);
        self.open(&topic, types, qos, Some(gate), Box::new(read))
    }

    /// Opens a publisher of raw payloads on `topic`; names as in [`Runtime::subscribe_raw`].
    ///
    /// # Errors
    /// A name violates the ROS rules, or an error of the middleware.
    pub fn raw_publisher(
        &self,
        topic: &str,
        type_name: &str,
        type_hash: Option<&str>,
        qos: Qos,
    ) -> Result<RawPublisher> {
        let topic = self.shared.topic_name(topic)?;
        let types = names_of(type_name, type_hash)?;
        let writer = self.writer(&topic, types, qos)?;
        self.list(&writer.endpoint);
        Ok(writer)
    }

    fn writer(&self, topic: &str, types: TypeNames, qos: Qos) -> Result<RawPublisher> {
        let (endpoint, dds) = self.endpoint(Direction::Publisher, topic, types, qos)?;
        let writer = self
            .shared
            .with_node(|node| node.create_publisher(&dds, None))?;
        Ok(RawPublisher {
            shared: Rc::clone(&self.shared),
            endpoint,
            writer: Rc::downgrade(&self.shared.keep(writer)),
        })
    }

    /// Claims an exclusive role in the domain (`subject`, the same for all claimants), and reads the claims of others. A claim counts only if the
    /// claimant has a writer on the DDS topic `evidence`, such as `rt/auv/state`.
    ///
    /// # Errors
    /// An error of the middleware.
    pub fn claim(&self, subject: &str, evidence: &str) -> Result<Claim> {
        let claim = Claim::new(&self.shared, subject, evidence);
        let types = types_of::<DiagnosticArray>();
        let topic = self.shared.topic_name("/diagnostics")?;
        let (endpoint, dds) =
            self.shared
                .endpoint(Direction::Subscription, &topic, types, Qos::reliable(100))?;
        let ours = claim.clone();
        let read = move |it: Unread, info: &MessageInfo| {
            let array: DiagnosticArray = it.message()?;
            let (ours, sender) = (
                ours.clone(),
                discovered::prefix(GUID::from(info.publisher_gid())),
            );
            let observe = async move {
                if let Some(sender) = sender {
                    ours.observe(&array, sender);
                }
            };
            Ok(observe.boxed_local())
        };
        subscription::start(&self.shared, endpoint, &dds, None, Box::new(read))?;
        Ok(claim)
    }

    /// Turns each request of the service `name` into an event, to be answered through its [`Responder`].
    ///
    /// # Errors
    /// The name violates the ROS rules, or an error of the middleware.
    pub fn serve<S: Service>(
        &self,
        name: &str,
        event: impl Fn(S::Request, Responder<S>) -> E + 'static,
    ) -> Result<()> {
        let (shared, sender) = (Rc::clone(&self.shared), self.sender.clone());
        let subject = self.shared.service_name(name)?;
        self.serve_with::<S, _>(name, async move |request, responder, turn| {
            if let Some(reason) = non_finite(&request) {
                shared.warn(&subject, &format!("request refused: {reason}"));
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

    /// Opens a client of the service `name` of another node.
    ///
    /// # Errors
    /// The name violates the ROS rules, or an error of the middleware.
    pub fn client<S: Service>(&self, name: &str) -> Result<Client<S>> {
        self.client_opener().open(name)
    }

    /// Opens clients of services from within a task.
    pub(crate) fn client_opener(&self) -> ClientOpener {
        ClientOpener {
            shared: Rc::clone(&self.shared),
            mapping: self.mapping,
        }
    }

    /// Serves the action `name`: each goal becomes an event, and so does each cancel request. The node decides through the [`Goal`] how a goal ends.
    ///
    /// # Errors
    /// The name violates the ROS rules, or an error of the middleware.
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

    /// Opens a client of the action `name` of another node. All its feedback becomes events.
    ///
    /// # Errors
    /// The name violates the ROS rules, or an error of the middleware.
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

    /// Answers each request of the service `name` immediately.
    pub(super) fn answer_with<S: Service>(
        &self,
        name: &str,
        answer: impl Fn(S::Request) -> S::Response + 'static,
    ) -> Result<()> {
        self.serve_with::<S, _>(name, async move |request, responder, _turn| {
            responder.answer(answer(request));
        })
    }

    /// Passes the requests of the service `name` to `answer`, one after the other.
    pub(super) fn serve_with<S, A>(&self, name: &str, mut answer: A) -> Result<()>
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
                        None => shared.warn(&name, &format!("request refused: {error}")),
                    },
                }
            }
        });
        Ok(())
    }

    /// An endpoint of a topic, with the QoS that the parameters select.
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

    /// A publisher of the runtime itself, not listed among the connections.
    pub(super) fn unlisted_publisher<M: Message>(
        &self,
        topic: &str,
        qos: Qos,
    ) -> Result<Publisher<M>> {
        let topic = self.shared.topic_name(topic)?;
        Ok(Publisher::new(self.writer(&topic, types_of::<M>(), qos)?))
    }
}

/// A function that makes an event and queues it for the handler.
///
/// Boxed, so that its code is compiled once per node instead of once per message type.
fn sent_to<E: 'static>(
    sender: &Sender<Queued<E>>,
    event: Box<dyn FnOnce() -> Queued<E>>,
) -> Delivery {
    let sender = sender.clone();
    let sent = async move {
        let _ = sender.send(event()).await; // Fails only at shutdown.
    };
    sent.boxed_local()
}

/// Names of a type known only by its ROS name.
fn names_of(type_name: &str, type_hash: Option<&str>) -> Result<TypeNames> {
    let (package, kind, name) = type_parts(type_name)?;
    Ok(TypeNames {
        ros: type_name.to_owned(),
        dds: format!("{package}::{kind}::dds_::{name}_"),
        hash: type_hash.map(str::to_owned),
    })
}

/// Opens clients of services of other nodes.
pub(crate) struct ClientOpener {
    pub(crate) shared: Rc<Shared>,
    mapping: ServiceMapping,
}

impl ClientOpener {
    /// Same as [`Runtime::client`].
    pub(crate) fn open<S: Service>(&self, name: &str) -> Result<Client<S>> {
        let name = self.shared.service_name(name)?;
        let inner = service::client(&self.shared, self.mapping, &name, &announce_service::<S>()?)?;
        self.shared.client_opened(&name);
        Ok(Client::new(&self.shared, name, inner))
    }
}

/// Type of the service for the middleware, with its hash announced for both topics, and its QoS.
fn announce_service<S: Service>() -> Result<(ServiceTypeName, Qos)> {
    announce_type_hash(S::REQUEST_DDS_TYPE_NAME, S::TYPE_HASH);
    announce_type_hash(S::RESPONSE_DDS_TYPE_NAME, S::TYPE_HASH);
    let (package, _, name) = type_parts(S::TYPE_NAME)?;
    Ok((ServiceTypeName::new(package, name), Qos::reliable(10)))
}
