//! Services: requests as events, and calls of others' services.

use crate::error::{Error, Result};
use std::{
    cell::Cell,
    env,
    marker::PhantomData,
    rc::{Rc, Weak},
    time::Duration,
};

use futures::{
    StreamExt as _,
    future::{Either, select},
    stream::LocalBoxStream,
};
use planesman_msgs::{Message, Service, cdr};
use ros2_client::{Name, ReadError, RmwRequestId, ServiceTypeName, service::ServiceMapping};
use rustdds::GUID;
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{DeserializeOwned, DeserializeSeed as _},
    ser::SerializeTuple as _,
};
use smol::{Timer, lock::Mutex};

use crate::{
    answers,
    names::{replies_topic, requests_topic},
    qos::Qos,
    raw,
    shared::Shared,
};

/// Wraps a message for the middleware, whose types need a marker trait.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Wire<T>(pub(crate) T);

impl<T: Serialize + DeserializeOwned> ros2_client::Message for Wire<T> {}

/// Payload of a request or an answer. With this type the middleware's service code is compiled once instead of once per service and node.
#[derive(Clone, Debug)]
pub(crate) struct Bytes(Vec<u8>);

impl Bytes {
    /// A payload with its header.
    pub(crate) fn raw(payload: &[u8]) -> Self {
        Self(payload.to_vec())
    }

    pub(crate) fn of<M: Message>(message: &M) -> Self {
        Self(cdr::to_bytes(message))
    }

    /// # Errors
    /// The payload is not such a message.
    pub(crate) fn message<M: Message>(&self) -> Result<M, cdr::Error> {
        cdr::from_bytes(&self.0)
    }
}

impl ros2_client::Message for Bytes {}

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let body = self.0.get(cdr::HEADER..).unwrap_or_default();
        let mut bytes = serializer.serialize_tuple(body.len())?;
        for byte in body {
            bytes.serialize_element(byte)?;
        }
        bytes.end()
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(payload: D) -> Result<Self, D::Error> {
        raw::Payload.deserialize(payload).map(Self)
    }
}

pub(crate) type Server = ros2_client::Server<Bytes, Bytes>;
pub(crate) type MiddlewareClient = ros2_client::Client<Bytes, Bytes>;

/// Opens a server of the service `name`.
///
/// # Errors
/// The name violates the ROS rules, or an error of the middleware.
pub(crate) fn server(
    shared: &Shared,
    mapping: ServiceMapping,
    name: &str,
    (type_name, qos): &(ServiceTypeName, Qos),
) -> Result<Rc<Server>> {
    let parsed = Name::parse(name).map_err(Error::name(name))?;
    let server = shared.with_node(|node| {
        let requests = Qos::requests().profile();
        node.create_server(
            mapping,
            &parsed,
            type_name,
            requests,
            qos.impatient_profile(),
        )
    })?;
    Ok(Rc::new(server))
}

/// Stream of the requests of a service; an error is an unreadable request.
pub(crate) fn requests(
    server: &Server,
) -> LocalBoxStream<'_, Result<(RmwRequestId, Bytes), ReadError>> {
    server.receive_request_stream().boxed_local()
}

/// Opens a client of the service `name`.
///
/// # Errors
/// Same as [`server`].
pub(crate) fn client(
    shared: &Shared,
    mapping: ServiceMapping,
    name: &str,
    (type_name, qos): &(ServiceTypeName, Qos),
) -> Result<Weak<Mutex<MiddlewareClient>>> {
    let parsed = Name::parse(name).map_err(Error::name(name))?;
    let client = shared.with_node(|node| {
        node.create_client(mapping, &parsed, type_name, qos.profile(), qos.profile())
    })?;
    Ok(Rc::downgrade(&shared.keep(Mutex::new(client))))
}

/// The way in which requests and responses are associated on the wire depends on the peers' middleware (`RMW_IMPLEMENTATION`): Fast DDS, Jazzy's
/// default, uses the samples' metadata, Cyclone DDS the payload.
pub(crate) fn mapping() -> Result<ServiceMapping> {
    match env::var("RMW_IMPLEMENTATION").as_deref() {
        Ok("rmw_cyclonedds_cpp") => Ok(ServiceMapping::Cyclone),
        Err(_) | Ok("" | "rmw_fastrtps_cpp" | "rmw_fastrtps_dynamic_cpp" | "rmw_connextdds") => {
            Ok(ServiceMapping::Enhanced)
        }
        Ok(other) => Err(Error::environment(
            format!("RMW_IMPLEMENTATION='{other}'"),
            "this node supports only DDS",
        )),
    }
}

/// The middleware with the other form of requests: its vendor id (the beginning of its GUIDs), and the values of `RMW_IMPLEMENTATION` there and
/// here.
fn other_form(mapping: ServiceMapping) -> ([u8; 2], [&'static str; 2]) {
    let [fast, cyclone] = ["rmw_fastrtps_cpp", "rmw_cyclonedds_cpp"];
    match mapping {
        ServiceMapping::Cyclone => ([0x01, 0x0f], [fast, cyclone]),
        _ => ([0x01, 0x10], [cyclone, fast]),
    }
}

/// Checks whether requests of this client can be read.
///
/// # Errors
/// The reason why they cannot.
pub(crate) fn check_client(mapping: ServiceMapping, request: &RmwRequestId) -> Result<(), String> {
    let is_named = !matches!(mapping, ServiceMapping::Cyclone); // There the payload names the client.
    let (vendor, [theirs, _]) = other_form(mapping);
    match is_named
        && GUID::from(request.writer_gid)
            .to_bytes()
            .starts_with(&vendor)
    {
        true => Err(format!("its client uses {theirs}")),
        false => Ok(()),
    }
}

/// Advice if requests to the service `name` are unreadable because of a client with the other form.
pub(crate) fn advice(shared: &Shared, mapping: ServiceMapping, name: &str) -> Option<String> {
    let (vendor, [theirs, ours]) = other_form(mapping);
    let requests = requests_topic(name);
    let clients = shared.participant()?.discovered_writers_where(|writer| {
        let guid = writer.writer_proxy.remote_writer_guid;
        writer.publication_topic_data.topic_name == requests && guid.to_bytes().starts_with(&vendor)
    });
    (!clients.is_empty()).then(|| {
        format!(
            "a client of {name} uses the request format of {theirs}; this node uses {ours} and cannot read it. Start both \
             with the same RMW_IMPLEMENTATION"
        )
    })
}

/// Answers one request. If it is dropped without an answer, the client keeps waiting.
pub struct Responder<S: Service> {
    pub(crate) shared: Rc<Shared>,
    /// The service's absolute name.
    pub(crate) name: Rc<str>,
    pub(crate) server: Weak<Server>,
    pub(crate) request: RmwRequestId,
    pub(crate) of: PhantomData<S>,
}

impl<S: Service> Responder<S> {
    /// Sends the answer. A client that has gone is not an error.
    ///
    /// If the client's reader is not discovered yet, or the client leaves no space by not acknowledging answers, the answer waits up to five seconds
    /// while the node continues.
    pub fn answer(self, response: S::Response) {
        if let Some(field) = response.first_non_finite() {
            let text = format!("no answer sent: {field} is not finite");
            self.shared.warn(&self.name, &text);
            return;
        }
        send(
            &self.shared,
            &self.name,
            self.server,
            self.request,
            Bytes::of(&response),
        );
    }
}

fn send(
    shared: &Rc<Shared>,
    name: &str,
    server: Weak<Server>,
    request: RmwRequestId,
    response: Bytes,
) {
    answers::answer(shared, name, request, move || {
        match server.upgrade() {
            Some(server) => server.send_response(request, response.clone()),
            None => Ok(()), // The node is shutting down.
        }
    });
}

/// Whether all our clients of the service `name` are matched with a server; requests written earlier would be lost.
pub(crate) fn is_served(shared: &Shared, name: &str) -> bool {
    let (requests, replies) = (requests_topic(name), replies_topic(name));
    let Some(participant) = shared.participant() else {
        return false;
    };
    let clients = shared.clients_of(name);
    let listening = participant.discovered_readers_where(|reader| {
        *reader.subscription_topic_data.topic_name() == requests
            && participant.matches_with(reader.reader_proxy.remote_reader_guid) >= clients
    });
    let speaking = participant.discovered_writers_where(|writer| {
        writer.publication_topic_data.topic_name == replies
            && participant.matches_with(writer.writer_proxy.remote_writer_guid) >= clients
    });
    !listening.is_empty() && !speaking.is_empty()
}

/// Waits until the service `name` has a server.
pub(crate) async fn settle(shared: &Shared, name: &str) {
    /// Interval of checking for the server.
    const POLL_INTERVAL: Duration = Duration::from_millis(10);

    while !is_served(shared, name) {
        shared.sleep(POLL_INTERVAL).await;
    }
}

/// Result of `call` to the service `name`, within `timeout`.
///
/// # Errors
/// `timeout` has passed, or the call failed.
pub(crate) async fn within<T>(
    name: &str,
    timeout: Duration,
    call: impl Future<Output = Result<T>>,
) -> Result<T> {
    futures::pin_mut!(call);
    match select(call, Timer::after(timeout)).await {
        Either::Left((answer, _)) => answer.map_err(Error::call(name)),
        Either::Right(_) => Err(Error::NoAnswer {
            service: name.to_owned(),
            timeout,
        }),
    }
}

/// Client of a service of another node. Clones share one connection.
pub struct Client<S: Service> {
    connection: Connection,
    of: PhantomData<S>,
}

/// The connection to a service.
#[derive(Clone)]
struct Connection {
    name: String,
    shared: Rc<Shared>,
    /// Only one call runs at a time, because the middleware gives a response to the caller that has waited longest.
    inner: Weak<Mutex<MiddlewareClient>>,
    /// Whether a server has been found before.
    settled: Rc<Cell<bool>>,
}

impl<S: Service> Clone for Client<S> {
    fn clone(&self) -> Self {
        Self {
            connection: self.connection.clone(),
            of: PhantomData,
        }
    }
}

impl Connection {
    async fn call(&self, request: Bytes, timeout: Duration) -> Result<Bytes> {
        let call = async {
            if !self.settled.get() {
                settle(&self.shared, &self.name).await;
                self.settled.set(true);
            }
            let inner: Rc<_> = self.inner.upgrade().ok_or(Error::ShutDown)?;
            let client = inner.lock().await;
            let answer = client.async_call_service(request).await;
            answer.map_err(|e| Error::Failed(e.to_string()))
        };
        within(&self.name, timeout, call).await
    }
}

impl<S: Service> Client<S> {
    pub(crate) fn new(
        shared: &Rc<Shared>,
        name: String,
        inner: Weak<Mutex<MiddlewareClient>>,
    ) -> Self {
        Self {
            connection: Connection {
                name,
                shared: Rc::clone(shared),
                inner,
                settled: Rc::default(),
            },
            of: PhantomData,
        }
    }

    /// Whether a server has been discovered.
    #[must_use]
    pub fn is_served(&self) -> bool {
        is_served(&self.connection.shared, &self.connection.name)
    }

    /// Waits for the service, sends the request and waits for the answer.
    ///
    /// # Errors
    /// No answer within `timeout`, a number in the request that is not finite, an invalid answer, or an error of the middleware.
    pub async fn call(&self, request: S::Request, timeout: Duration) -> Result<S::Response> {
        let name = &self.connection.name;
        if let Some(field) = request.first_non_finite() {
            return Err(Error::NotFinite {
                service: name.clone(),
                done: "called",
                field,
            });
        }
        let answer = self.connection.call(Bytes::of(&request), timeout).await?;
        answer.message().map_err(Error::call(name))
    }
}
