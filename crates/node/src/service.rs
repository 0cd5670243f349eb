//! Services: answering requests as events, and calling others.

use std::{
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
    pub(crate) server: Weak<Server<S>>,
    pub(crate) request: RmwRequestId,
}

impl<S: Service> Responder<S> {
    /// Sends the answer. A client that has gone is no error.
    pub fn answer(self, response: S::Response) {
        let Some(server) = self.server.upgrade() else {
            return; // The node is shutting down.
        };
        if let Some(field) = response.first_non_finite() {
            log::error!("{}: no answer sent: {field} is not finite", S::TYPE_NAME);
        } else if let Err(error) = server.send_response(self.request, Wire(response)) {
            log::warn!("{}: no answer sent: {error}", S::TYPE_NAME);
        }
    }
}

/// Calls one service of another node. Clones share one connection.
pub struct Client<S: Service> {
    pub(crate) name: String,
    pub(crate) shared: Rc<Shared>,
    /// One call at a time: the middleware gives every response to whoever waits first.
    pub(crate) inner: Weak<Mutex<MiddlewareClient<S>>>,
}

impl<S: Service> Clone for Client<S> {
    fn clone(&self) -> Self {
        Self {
            name: self.name.clone(),
            shared: Rc::clone(&self.shared),
            inner: Weak::clone(&self.inner),
        }
    }
}

impl<S: Service> Client<S> {
    /// Whether a server for it has been discovered.
    #[must_use]
    pub fn is_served(&self) -> bool {
        let requests = format!("rq{}Request", self.name);
        let replies = format!("rr{}Reply", self.name);
        let Some(participant) = self.shared.participant() else {
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

    /// Waits for the service, sends the request and waits for the answer.
    ///
    /// # Errors
    /// When no answer has come after `timeout`, or the middleware fails.
    pub async fn call(
        &self,
        request: S::Request,
        timeout: Duration,
    ) -> anyhow::Result<S::Response> {
        /// Time between two looks for the server, and then for it to have found us too.
        const SETTLING: Duration = Duration::from_millis(50);

        if let Some(field) = request.first_non_finite() {
            bail!("{}: not called: {field} is not finite", self.name);
        }
        let name = self.name.clone();
        let call = async {
            while !self.is_served() {
                Timer::after(SETTLING).await;
                if self.is_served() {
                    Timer::after(SETTLING).await;
                }
            }
            let inner: Rc<_> = self
                .inner
                .upgrade()
                .ok_or_else(|| anyhow!("the node has shut down"))?;
            let client = inner.lock().await;
            client
                .async_call_service(Wire(request))
                .await
                .map_err(|e| anyhow!("{e}"))
        };
        futures::pin_mut!(call);
        match select(call, Timer::after(timeout)).await {
            Either::Left((answer, _)) => {
                answer.map(|Wire(response)| response).with_context(|| name)
            }
            Either::Right(_) => bail!("{name}: no answer within {timeout:?}"),
        }
    }
}
