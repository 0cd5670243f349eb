//! Services: answering requests as events, and calling others.

use std::{
    cell::Cell,
    env,
    rc::{Rc, Weak},
    time::Duration,
};

use anyhow::{Context as _, anyhow, bail};
use futures::future::{Either, select};
use planesman_msgs::{Message, Service};
use ros2_client::{RmwRequestId, service::ServiceMapping};
use rustdds::GUID;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use smol::{Timer, lock::Mutex};

use crate::shared::Shared;

/// A message in the middleware's eyes, which takes only types that carry its mark.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Wire<T>(pub(crate) T);

impl<T: Serialize + DeserializeOwned> ros2_client::Message for Wire<T> {}

pub(crate) type Server<S> =
    ros2_client::Server<Wire<<S as Service>::Request>, Wire<<S as Service>::Response>>;
type MiddlewareClient<S> =
    ros2_client::Client<Wire<<S as Service>::Request>, Wire<<S as Service>::Response>>;

/// How requests and responses name each other on the wire, as the peers' ROS
/// middleware (`RMW_IMPLEMENTATION`) has it: Fast DDS, Jazzy's default, in the samples'
/// metadata, Cyclone DDS in the payload.
pub(crate) fn mapping() -> anyhow::Result<ServiceMapping> {
    match env::var("RMW_IMPLEMENTATION").as_deref() {
        Ok("rmw_cyclonedds_cpp") => Ok(ServiceMapping::Cyclone),
        Err(_) | Ok("" | "rmw_fastrtps_cpp" | "rmw_fastrtps_dynamic_cpp" | "rmw_connextdds") => {
            Ok(ServiceMapping::Enhanced)
        }
        Ok(other) => bail!("RMW_IMPLEMENTATION='{other}': this node speaks DDS only"),
    }
}

/// Answers one request. Dropped without an answer, it leaves the client waiting.
pub struct Responder<S: Service> {
    pub(crate) shared: Rc<Shared>,
    /// The service's absolute name.
    pub(crate) name: Rc<str>,
    pub(crate) server: Weak<Server<S>>,
    pub(crate) request: RmwRequestId,
}

impl<S: Service> Responder<S> {
    /// Sends the answer. A client that has gone is no error.
    ///
    /// A client may ask before we have discovered where it listens; then the answer
    /// waits for that, up to five seconds, while the node goes on.
    pub fn answer(self, response: S::Response) {
        if let Some(field) = response.first_non_finite() {
            let text = format!("no answer sent: {field} is not finite");
            self.shared.warn(&self.name, &text);
            return;
        }
        let (shared, name) = (Rc::clone(&self.shared), Rc::clone(&self.name));
        answer_when_heard(&shared, &name, self.request, move || self.send(response));
    }

    fn send(self, response: S::Response) {
        let Some(server) = self.server.upgrade() else {
            return; // The node is shutting down.
        };
        if let Err(error) = server.send_response(self.request, Wire(response)) {
            let text = format!("no answer sent: {error}");
            self.shared.warn(&self.name, &text);
        }
    }
}

/// Sends an answer of the service `name` as soon as who asked is known to listen, or after a while.
///
/// A client asks as soon as it knows of us. That it listens we may learn a little later, and our writer a little after
/// that; what is written before is lost. So the first answer to a client waits for one look more.
pub(crate) fn answer_when_heard(
    shared: &Rc<Shared>,
    name: &str,
    request: RmwRequestId,
    send: impl FnOnce() + 'static,
) {
    /// Time between two looks for the client, and how many there are.
    const LOOK: Duration = Duration::from_millis(10);
    const LOOKS: usize = 500;

    let (client, replies) = (GUID::from(request.writer_gid), replies_topic(name));
    if shared.is_heard_by(client) {
        return send();
    }
    let ours = Rc::clone(shared);
    shared.spawn(async move {
        for _ in 0..LOOKS {
            let listens = client_listens(&ours, &replies, client);
            Timer::after(LOOK).await;
            if listens {
                ours.heard_by(client);
                break;
            }
        }
        send();
    });
}

/// Whether a reader of the topic `replies` is known in the client's participant.
fn client_listens(shared: &Shared, replies: &str, client: GUID) -> bool {
    shared.participant().is_some_and(|participant| {
        participant
            .discovered_readers()
            .iter()
            .map(|reader| &reader.subscription_topic_data)
            .any(|reader| *reader.topic_name() == replies && reader.key().prefix == client.prefix)
    })
}

/// Whether a server of the service `name` has been discovered.
pub(crate) fn is_served(shared: &Shared, name: &str) -> bool {
    let (requests, replies) = (requests_topic(name), replies_topic(name));
    let Some(participant) = shared.participant() else {
        return false;
    };
    let listens = participant
        .discovered_readers()
        .iter()
        .any(|reader| *reader.subscription_topic_data.topic_name() == requests);
    let speaks = participant
        .discovered_writers()
        .iter()
        .any(|writer| writer.publication_topic_data.topic_name == replies);
    listens && speaks
}

/// Waits until a server of the service `name` is known to us, and we to it.
pub(crate) async fn settle(shared: &Shared, name: &str) {
    /// Time between two looks for the server, and for our writer to take note of it
    /// once it is discovered: what is written before that is lost.
    const SETTLING: Duration = Duration::from_millis(50);

    let mut settled = false;
    while !settled {
        settled = is_served(shared, name);
        Timer::after(SETTLING).await;
    }
}

/// What `call` to the service `name` comes to.
///
/// # Errors
/// When that takes longer than `timeout`, or the call fails.
pub(crate) async fn within<T>(
    name: &str,
    timeout: Duration,
    call: impl Future<Output = anyhow::Result<T>>,
) -> anyhow::Result<T> {
    futures::pin_mut!(call);
    match select(call, Timer::after(timeout)).await {
        Either::Left((answer, _)) => answer.with_context(|| name.to_owned()),
        Either::Right(_) => bail!("{name}: no answer within {timeout:?}"),
    }
}

/// The DDS topic that a service's requests go by.
fn requests_topic(service: &str) -> String {
    format!("rq{service}Request")
}

/// The DDS topic that a service's answers go by.
fn replies_topic(service: &str) -> String {
    format!("rr{service}Reply")
}

/// Calls one service of another node. Clones share one connection.
pub struct Client<S: Service> {
    pub(crate) name: String,
    pub(crate) shared: Rc<Shared>,
    /// One call at a time: the middleware gives every response to whoever waits first.
    pub(crate) inner: Weak<Mutex<MiddlewareClient<S>>>,
    /// Whether a server has been found once.
    pub(crate) settled: Rc<Cell<bool>>,
}

impl<S: Service> Clone for Client<S> {
    fn clone(&self) -> Self {
        Self {
            name: self.name.clone(),
            shared: Rc::clone(&self.shared),
            inner: Weak::clone(&self.inner),
            settled: Rc::clone(&self.settled),
        }
    }
}

impl<S: Service> Client<S> {
    /// Whether a server for it has been discovered.
    #[must_use]
    pub fn is_served(&self) -> bool {
        is_served(&self.shared, &self.name)
    }

    /// Waits for the service, sends the request and waits for the answer.
    ///
    /// # Errors
    /// When no answer has come after `timeout`, the request holds a number that is not
    /// finite, or the middleware fails.
    pub async fn call(
        &self,
        request: S::Request,
        timeout: Duration,
    ) -> anyhow::Result<S::Response> {
        if let Some(field) = request.first_non_finite() {
            bail!("{}: not called: {field} is not finite", self.name);
        }
        let call = async {
            if !self.settled.get() {
                settle(&self.shared, &self.name).await;
                self.settled.set(true);
            }
            let inner: Rc<_> = self
                .inner
                .upgrade()
                .ok_or_else(|| anyhow!("the node has shut down"))?;
            let client = inner.lock().await;
            let answer = client.async_call_service(Wire(request)).await;
            answer
                .map(|Wire(response)| response)
                .map_err(|e| anyhow!("{e}"))
        };
        within(&self.name, timeout, call).await
    }
}
