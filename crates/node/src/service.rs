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
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use smol::{Timer, lock::Mutex};

use crate::{
    answers,
    names::{replies_topic, requests_topic},
    shared::Shared,
};

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
    /// A client may ask before we have discovered where it listens, or leave no room for answers
    /// by acknowledging none; then the answer waits, up to five seconds, while the node goes on.
    pub fn answer(self, response: S::Response) {
        if let Some(field) = response.first_non_finite() {
            let text = format!("no answer sent: {field} is not finite");
            self.shared.warn(&self.name, &text);
            return;
        }
        let (server, request) = (self.server, self.request);
        answers::answer(&self.shared, &self.name, request, move || {
            match server.upgrade() {
                Some(server) => server.send_response(request, Wire(response.clone())),
                None => Ok(()), // The node is shutting down.
            }
        });
    }
}

/// Whether all our clients of the service `name` are matched with a server: what is written before that is lost.
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

/// Waits until there is a server of the service `name`.
pub(crate) async fn settle(shared: &Shared, name: &str) {
    /// Time between two looks for the server.
    const LOOK: Duration = Duration::from_millis(10);

    while !is_served(shared, name) {
        shared.sleep(LOOK).await;
    }
}

/// The result of `call` to the service `name`.
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
